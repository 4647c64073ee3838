// SPDX-License-Identifier: Apache-2.0
// All settings that several commands share: the values, and the tables that declare them. What is
// not given is what the initialisers say, or the file's, or the library's default.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "environment.h"
#include "flag_set.h"
#include "flags.h"
#include "ovoid/camera.h"
#include "ovoid/field.h"
#include "ovoid/hyperslice.h"
#include "ovoid/io.h"
#include "ovoid/look.h"
#include "ovoid/model.h"
#include "ovoid/renderer.h"
#include "ovoid/scene.h"
#include "ovoid/slices.h"
#include "setting.h"

namespace ovoid::cli {

// --hyperslice and how it is taken.
struct SliceFlags {
  std::optional<Hyperplane> plane;
  SliceMethod method = SliceMethod::kInterpolated;
  std::optional<LatticeKind> lattice;
  double spacing = 1.0;
};

inline constexpr std::size_t kMemoryOfSteps = std::size_t{1} << 30;

// Which data: files, and what headerless ones cannot say.
struct DataFlags {
  std::vector<std::string> inputs;
  std::shared_ptr<const StepSource> steps;  // in memory, in the place of the inputs
  RawOptions raw;
  std::string block;
  std::optional<std::int64_t> step;
  std::optional<double> time;
  TimeFilter time_filter = TimeFilter::kFourSteps;
  SliceFlags slice;
  // Bytes of steps (none: kMemoryOfSteps), and of a lattice's samples (none: what there is).
  std::optional<std::size_t> memory_limit;
  std::string positions;             // HDF5: the path of the positions
  std::vector<std::string> values;   // HDF5: paths of arrays
  std::vector<std::string> folders;  // where files that the input names may lie, beside its own
  bool may_stay_in_file =
      false;                   // of commands that draw, and make nothing of the samples themselves
  bool may_be_shared = false;  // among processes: kernels that each makes of its rows
  std::string array;           // the only one that is read where the format allows; empty: all
  int component = 0;           // of hyperslices
};

// A component that nobody named: the norm of vectors, else the first.
inline constexpr int kUsualComponent = -2;

// Which array is drawn, and how it becomes a field: what all data, what lattices, and what
// everything else takes. The members of the latter two that have the name of one before them are
// not used.
struct ModelFlags {
  std::string array;
  int component = kUsualComponent;  // LatticeModelOptions::kMagnitude: the norm
  std::optional<Reconstruction> reconstruction;
  std::optional<double> relevant_above;
  LatticeModelOptions lattice;
  KernelModelOptions kernels;
  std::int64_t kept_bytes = 0;  // of kernels that other processes have; 0: as TeamFieldOptions says
};

// Appearance: colours and opacities, mode, light.
struct LookFlags {
  std::string file;        // a name, or JSON itself
  std::string file_name;   // which look of the file; empty: the first
  std::string color_file;  // the colours of --color-array; empty: the other flags say them
  std::string preset;
  std::string color_map;  // by name, or a list of colours; empty: none
  std::vector<OpacityPoint> opacities;
  std::vector<OpacityPoint> gradient_opacities;
  std::string file_2d;               // colour and opacity by value and gradient; a name, or JSON
  std::optional<Ranges2D> range_2d;  // of a picture's
  std::optional<std::pair<double, double>> range;
  double shift = 0;        // of colours and opacities along the values
  bool is_window = false;  // `range` was given as window and level
  bool is_log = false;
  std::optional<double> linear_width;  // of a symmetric logarithm; none: not asked for
  std::optional<Rgb> below_color;
  std::optional<Rgb> above_color;
  std::optional<double> unit_distance;
  Mode mode = Mode::kComposite;
  std::vector<Isosurface> isosurfaces;  // none: the mode is another
  bool shade = false;                   // asked for
  bool no_shade = false;
  std::optional<double> ambient;
  std::optional<double> diffuse;
  std::optional<double> specular;
  std::optional<double> specular_power;
  Light light = Light::kStudio;
  std::optional<Vec3> light_direction;  // none: with the camera
  bool names_lights = false;            // else the look's further ones
  std::vector<FurtherLight> further_lights;
  std::optional<double> flat_rise;
  std::optional<double> occlusion;
  std::optional<double> shadows;
  std::optional<double> scattering_blending;  // VTK's, [0, 2], for shadows
  std::optional<double> scatter;
};

// How near a camera that nobody placed comes.
enum class Fit { kVisible, kBox };

// Where the picture is taken from.
struct CameraFlags {
  std::string file;  // a name, or JSON itself
  std::string view;
  double azimuth = 0;  // degrees, as are the next two
  double elevation = 0;
  double roll = 0;
  Fit fit = Fit::kVisible;
  double zoom = 1;
  std::optional<bool> parallel_projection;
  std::optional<double> view_angle;
};

// The part of the data that is drawn. An end that is not given is the data's own.
struct CropFlags {
  struct Range {
    std::optional<std::int64_t> first, last;  // samples, both included
  };
  std::optional<std::array<Range, 3>> samples;
  std::optional<Bounds3> world;  // infinite where not given
};

// Which marks are drawn into the picture.
struct AnnotationFlags {
  bool color_bar = false;
  std::string title;  // of the colour bar; empty: the array's name
  bool axes = false;
  bool bounding_box = false;
  bool scale_bar = false;
  std::optional<std::string> length_unit;  // none: what the data say
  double text_px = 0;                      // height of a line of text; 0: by the picture's size

  bool any() const noexcept { return color_bar || axes || bounding_box || scale_bar; }
};

// --motion-blur: what was there some time ago, behind what is.
struct TrailFlags {
  std::optional<double> length;
  double decay = 0;
  std::string file;       // its look, a name or JSON itself; empty: made from the picture's
  std::string file_name;  // which look of the file; empty: the first
};

// Behind a picture: dark, so that what is light and what is seen through stand out.
inline constexpr Rgb kBackground{0.10, 0.11, 0.13};

// The surface of a mesh.
struct SurfaceFlags {
  std::optional<double> opacity;  // 0: the volume instead; none: as the data are
  bool shows_edges = false;
  std::string within;  // a mesh's file, whose surface is that of data without cells; empty: none
};

// A plane of --slice.
struct SlicePlane {
  Vec3 normal{0, 0, 1};
  std::optional<double> offset;  // world; none: through the middle
};

// What stands beside the field.
struct GeometryFlags {
  std::vector<std::string> files;
  std::vector<Rgb> colors;        // of the first, the second ...; the last one counts for the rest
  std::vector<double> opacities;  // likewise; 0: not drawn
  std::vector<std::string> arrays;                // which give colours, likewise; empty, "": none
  std::vector<std::string> color_maps;            // of these, likewise
  std::vector<std::pair<double, double>> ranges;  // that they span, likewise; none: all values
  std::vector<double> radii;  // world, of lines and points, likewise; none: usual_radius()
  bool shows_edges = false;
  std::vector<SlicePlane> slices;
  std::string slice_map = "gray";
  std::optional<std::pair<double, double>> slice_range;  // none: of nearly all values
  double slice_opacity = 1;
  bool shows_empty = false;
  bool has_outlines = false;         // of slices
  std::optional<Rgb> outline_color;  // of all of them; none: by their axes
};

// What slices show of labels.
enum class SliceLabels { kLines, kAreas, kBoth, kNone };

// The surfaces of labels.
struct LabelFlags {
  // By number or name; "others": all that are not named.
  struct Opacity {
    std::string label;
    double opacity = 1;
  };
  struct Color {
    std::string label;
    Rgb rgb{};
  };
  bool own_surfaces = false;   // the data are labels, and drawn by their surfaces whatever the look
  std::string file;            // empty: the data's own, if they are labels
  bool is_read_apart = false;  // the file is no part of a Subject
  std::string table;           // of names and colours; empty: the file's own, if it has one
  std::vector<Opacity> opacities;
  std::vector<Color> colors;                 // by number or name
  std::vector<std::string> inside, outside;  // where the field is drawn; empty: not said
  std::optional<SliceLabels> on_slices;      // none: areas of data that are labels, else lines
  bool are_flat = false;                     // on slices alone
};

// --channels: arrays of the input in one picture, each with the colour and range of its place.
struct ChannelFlags {
  std::vector<std::string> names;  // of arrays, "all" or "rgb" alone; empty: there are none
  std::vector<Rgb> colors;
  std::vector<std::pair<double, double>> ranges;
  std::optional<Mixing> mixing;  // also of --over
};

inline constexpr std::size_t kMostOver = Scene::kMaxVolumes - 1;

// --over: other volumes in the picture. What is said of them is said of the first, the second ...
struct OverFlags {
  std::vector<std::string> files;
  std::vector<std::string> arrays;
  std::vector<std::string> looks;  // names, or JSON itself
  std::vector<std::string> presets;
  std::vector<std::string> color_maps;
  std::vector<std::pair<double, double>> ranges;
  std::vector<std::vector<OpacityPoint>> opacities;
  std::vector<std::string> transforms;  // files that place them (placement.h)
};

// Particles and kernels as balls.
struct PointFlags {
  std::optional<double> size;  // as PointStyle has it; none: the field is drawn
};

struct DrawingFlags {
  std::optional<Rgb> background = kBackground;  // none: transparent
  ModelFlags model;
  LookFlags look;
  CameraFlags camera;
  CropFlags crop;
  AnnotationFlags annotation;
  SurfaceFlags surface;
  PointFlags points;
  GeometryFlags geometry;
  LabelFlags labels;
  ChannelFlags channels;
  OverFlags over;
  RenderOptions options;
  TrailFlags trail;
  std::optional<ValuePlane> plane;
  RendererSetup run = setup_of_environment();
  TimeFilter time_filter = TimeFilter::kFourSteps;  // as DataFlags has it
};

const Table<DataFlags>& data_settings();
const Table<DataFlags>& raw_settings();
const Table<ModelFlags>& array_settings();  // --array, --color-array, --component
const Table<ModelFlags>& kernel_settings();
const Table<ModelFlags>& particle_settings();
const Table<ModelFlags>& relevant_settings();  // of commands that draw or describe
const Table<LookFlags>& color_settings();
const Table<LookFlags>& light_settings();
const Table<CameraFlags>& camera_settings();
const Table<CropFlags>& crop_settings();
const Table<AnnotationFlags>& mark_settings();
const Table<SurfaceFlags>& surface_settings();
const Table<PointFlags>& point_settings();
const Table<GeometryFlags>& geometry_settings();
const Table<LabelFlags>& label_settings();
const Table<ChannelFlags>& channel_settings();
const Table<OverFlags>& over_settings();
const Table<TrailFlags>& trail_settings();
const Table<DrawingFlags>& picture_settings();  // --size, --background
const Table<RenderOptions>& number_settings();
const Table<DrawingFlags>& plane_settings();
const Table<RendererSetup>& run_settings();
const Table<RenderOptions>& switch_settings();  // --no-skip, --no-stop, --no-pack

// The INPUT... arguments and the flags of sections "data" and "raw data".
void add_input_flags(Flags& flags, DataFlags* data);
// Sections "array" and "kernels" with "particles".
void add_array_flags(Flags& flags, ModelFlags* model);
void add_kernel_flags(Flags& flags, ModelFlags* model);
// All that draw, section by section, from the marks to section "running", which stays open.
void add_drawing_flags(Flags& flags, DrawingFlags* drawing);
// Section "several volumes", of those that draw more than one.
void add_over_flags(Flags& flags, DrawingFlags* drawing);

// The other way round: the flags that say the same, in the place of those that the set has. What is
// at its default takes no flag. `names`: these alone; empty: all of the table.
template <class S>
void tell(const Table<S>& table, const std::type_identity_t<S>& settings, FlagSet* flags,
          const std::vector<std::string>& names = {}) {
  for (const Setting<S>& setting : table) {
    if (!names.empty() && std::find(names.begin(), names.end(), setting.flag.name) == names.end())
      continue;
    flags->erase(setting.flag.name);
    const FlagSet::Json value = setting.tell(settings);
    if (!value.is_null()) flags->set(setting.flag.name, value);
  }
}

// Throws UsageError if no INPUT was given, or an empty one.
void require_inputs(const Flags& flags, const DataFlags& data);

// Throws Error(kInvalidArgument) for the first flag that is given but not for this kind of data.
void check_kind_flags(const Flags& flags, const Dataset& dataset);
// "--kernel: is for lattices, 'x.csv' holds particles"
[[noreturn]] void refuse_kind(const std::string& flag, const std::string& meant,
                              const Dataset& dataset);

// Whether a flag of the model is given.
bool is_model_flag_given(const Flags& flags);

// Throws UsageError for JSON that is no look or no camera, before any file is read.
void check_json_flags(const DrawingFlags& drawing);

const char* name_of_mode(Mode mode);

}  // namespace ovoid::cli
