// SPDX-License-Identifier: Apache-2.0
// What is open and how it is shown: all that the panels edit, that pictures are drawn from, and
// that a state file keeps. Knows no window.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fitter.h"
#include "label_edits.h"
#include "loader.h"
#include "make_camera.h"
#include "make_geometry.h"
#include "size.h"
#include "worker.h"

namespace ovoid::viewer {

// A surface beside the data.
struct AddedSurface {
  SurfaceSource source;                   // as it is wanted
  std::shared_ptr<const ReadSurface> of;  // of this file; of another array or radius until it is
                                          // made of the wanted one
  Rgb color{0.9, 0.9, 0.9};
  double opacity = 1;
  bool is_hidden = false;
  std::string color_map = cli::kUsualAddedMap;       // where an array gives colours
  std::optional<std::pair<double, double>> range{};  // that the map spans; none: all values

  bool is_made() const { return of->source == source; }
  Geometry geometry(bool shows_edges) const;
};

// A volume that is drawn with the data. The light is the view's.
struct AddedVolume {
  std::shared_ptr<const VolumeBeside> of;
  TransferFunction curves;
  double unit_distance = 0;  // as Look has it
  bool is_hidden = false;
};

// How a channel is drawn.
struct ChannelStyle {
  Rgb color{1, 1, 1};
  ValueRange range;
  bool is_hidden = false;
};

// How the picture looks, but for the camera: what undo takes back.
struct View {
  Look look;
  std::optional<Bounds3> crop;  // world; sides that are not cut are infinite
  std::vector<ClipPlane> clip_planes;
  std::optional<ValuePlane> plane;
  bool draws_surface = false;  // of a mesh
  SurfaceStyle surface;
  bool draws_points = false;  // of particles and kernels: balls instead of the field
  PointStyle points;
  Mixing mixing = Mixing::kAveraged;  // of several volumes
  RenderOptions options;              // without size and clip planes
  cli::AnnotationFlags marks;
  Rgb background = cli::kBackground;
  std::vector<AddedSurface> added;
  bool added_edges = false;                      // of the faces of all of them
  cli::GeometryFlags slices;                     // of it what is about slices
  bool label_surfaces = true;                    // of data that are labels, instead of the field
  std::optional<LabelsBeside> labels;            // instead of those that the data may be
  LabelEdits label_edits;                        // of the labels that are drawn
  std::optional<cli::SliceLabels> slice_labels;  // what slices show of them; none: as opened
  bool are_labels_flat = false;                  // on slices alone
  std::vector<AddedVolume> volumes;
  std::vector<ChannelStyle> channels;  // of the channels that are shown, if so many are
  std::optional<SolidShape> solid;     // is shown instead of the mesh, as soon as it is made
};

// One of two settings that are compared.
struct Setting {
  View view;
  RendererSetup setup;
};

// kDivided: in the same place, one on the left of a line that can be moved, one on its right.
enum class CompareMode { kOff, kDivided, kSideBySide, kDifference };
// What the view is compared with: another one, which stands on the left (A, the view is B), or the
// same view of the fit, which stands on the right.
enum class CompareWith { kOther, kFit };

struct TimeState {
  double now = 0;
  bool is_playing = false;
  bool loops = true;
  bool is_interpolated = false;
  bool is_fastest = false;  // shows every step as soon as it can, whatever the clock
  double rate = 1;          // units of time per second
  double blur_length = 0;   // 0: none
  double blur_decay = 0;
};

// A control mesh that a file holds.
struct ControlFile {
  std::shared_ptr<const SolidMesh> mesh;
  std::string path;
};

class Document {
 public:
  // --- data, as the loader reports them
  std::shared_ptr<const Launch> launch;  // as opened
  std::shared_ptr<const DataInfo> info;  // null: nothing is open
  std::shared_ptr<const Shown> shown;
  std::shared_ptr<const Extras> extras;
  std::optional<Counted2D> counted_2d;        // of the array that is shown, maybe at another time
  std::vector<std::string> notes;             // what reading and modelling had to say
  std::vector<ControlFile> control_files;     // the one that was opened, and what was saved
  std::optional<LatticeKernel> label_kernel;  // narrow, where the data look like labels

  // --- how they are shown
  Camera camera;
  View view;
  RendererSetup setup;
  TimeState time;
  CompareMode compare = CompareMode::kOff;
  CompareWith compare_with = CompareWith::kOther;
  std::optional<Setting> other;
  std::shared_ptr<const Fitted> fit;  // the last that was made; null: none
  bool fit_has_surface = true;        // ends at the surface of what it is of

  bool is_open() const noexcept { return shown != nullptr; }
  bool has_time() const noexcept { return info && info->times.size() > 1; }
  bool compares() const {
    return compare != CompareMode::kOff &&
           (compare_with == CompareWith::kFit ? has_fit_of_shown() : other.has_value());
  }
  bool compares_fit() const { return compares() && compare_with == CompareWith::kFit; }
  // The file that holds the solid's control mesh; null: none does.
  const ControlFile* control_file() const;
  // Writes the control mesh, which from then on is what the file holds: densities are rounded to
  // float32. Throws Error.
  void save_control(const std::string& path);
  // A vertex of the solid elsewhere, or with another density. Where that cannot be it stays, and
  // what is returned says why; else that is empty.
  std::string set_vertex(std::size_t vertex, const Vec3& place, double density);
  bool has_fit_of_shown() const { return fit && is_open() && fit->is_of(*shown); }

  // New data: keeps camera and look where `keeps_view` says so (a reload), else takes those that
  // flags or the data ask for. `aspect`: width over height of the picture.
  void take(const Opened& opened);
  void take(const ShownReady& ready, double aspect);

  // Whether a view shows the surface of what is shown, or its kernels as balls.
  bool draws_surface(const View& of) const;
  bool draws_points(const View& of) const;
  // Whether surfaces and slices of a view are seen, if it has any.
  bool shows_scenery(const View& of) const;
  // The labels of a view, as their table has them: of a file, or of data that are labels; null:
  // there are none. Whether the view shows them, and how.
  const LabelSurfaces* plain_labels(const View& of) const;
  bool shows_labels(const View& of) const;
  LabelSurfaces labels_of(const View& of) const;
  // The edits are the view's. The look of data that are labels goes with them.
  void edit_labels(LabelEdits edits);
  // A label map's file, in the place of another one, or of nothing.
  void set_labels(std::optional<LabelsBeside> labels);
  // The one that was read again in the place of the one before, wherever that is.
  void renew_labels(const LabelsBeside& labels);
  // The surface of a file into the view, in the next usual colour.
  void add_surface(std::shared_ptr<const ReadSurface> surface);
  // One that was read again, or made otherwise, in the place of those before, wherever it is
  // wanted. Undo keeps no other one of the file, which may be large: it has them made again.
  void renew_surface(const std::shared_ptr<const ReadSurface>& surface);
  // Those that are wanted otherwise than they are.
  std::vector<SurfaceSource> surfaces_to_make() const;
  // It cannot be made: what is there is what is wanted.
  void give_up_surface(const SurfaceSource& source);
  // Of a file, those that are shown, here or in what is compared with.
  std::vector<SurfaceSource> surfaces_of(const std::string& file) const;
  // Whether a view's mode, and what else it shows, leave room for several volumes; whether these
  // are channels of the file, or volumes beside it.
  bool may_show_several(const View& of) const;
  bool shows_channels(const View& of) const;
  bool shows_volumes(const View& of) const;
  // The view's, or those that the channels begin with.
  std::vector<ChannelStyle> channels_of(const View& of) const;
  // What a channel's look is made of but colour and range, and the look.
  cli::LookFlags channel_flags(const View& of) const;
  Look channel_look(const View& of, std::size_t channel) const;
  Look volume_look(const View& of, const AddedVolume& volume) const;
  void add_volume(const std::shared_ptr<const VolumeBeside>& volume);
  void renew_volume(const std::shared_ptr<const VolumeBeside>& volume);
  // Those that can be drawn: several channels have no colour bar.
  cli::AnnotationFlags marks_of(const View& of) const;
  // The part of the data that is left by the crop.
  Bounds3 bounds() const;
  Bounds3 data_bounds() const { return shown->field().world_bounds(); }
  // Where a slice lies, in its own numbers; without one through the middle.
  double offset_of(const cli::SlicePlane& slice) const {
    return slice.offset.value_or(data_bounds().center().dot(slice.normal));
  }
  double extent() const { return data_bounds().diagonal().norm(); }
  // What shows fills the picture, from where a first picture is taken, or from the view of that
  // name (default_camera()); the projection stays as it is.
  void reset_camera(double aspect, const std::string& view = {});
  const ArrayInfo* array_info(const std::string& name) const;

  // The request for what is shown in `size` pixels. Each of two pictures beside each other has half
  // of them, and in it the whole width of the view, which alone is `alone` pixels wide (0: as
  // wide).
  std::vector<std::shared_ptr<const PictureJob>> jobs(Size size, int alone = 0) const;
  // Which of them is the view's; what it is compared with is the other one.
  std::size_t own_job() const { return compares() && !compares_fit() ? 1 : 0; }
  // The same options as a job has, crop and clip planes included.
  RenderOptions options_of(const View& of, Size size) const;

  // --- undo
  // To be called when an edit is complete: remembers the view that was there before. Without an
  // edit (touch()) since the last one nothing happens, so that what undo does is none itself.
  void remember();
  // Of a solid that cannot be made: what is shown is wanted again, or the mesh where that is a
  // solid as it was while it moved.
  void give_up_solid();

  bool can_undo() const noexcept { return !past_.empty(); }
  bool can_redo() const noexcept { return !future_.empty(); }
  void undo();
  void redo();

  // --- pictures: counts up with each change that a picture shows
  std::uint64_t version() const noexcept { return version_; }
  void touch() noexcept {
    count_up();
    is_edited_ = true;
  }
  // What has changed is no part of the view, and undo leaves it: camera, back end, comparison.
  void touch_beside_view() noexcept { ++version_; }
  std::uint64_t view_version() const noexcept { return view_version_; }
  // What is compared with has changed, or which it is.
  void touch_other() noexcept {
    ++version_;
    ++other_version_;
  }
  std::uint64_t other_version() const noexcept { return other_version_; }

 private:
  cli::CameraSubject camera_subject(const PictureJob& drawn, double aspect) const;
  void count_up() noexcept {
    ++version_;
    ++view_version_;
  }
  void change_views(const std::function<void(View&)>& change);  // those of undo, too
  void take_channels(bool is_first);
  std::vector<Volume> volumes_of(const View& of) const;  // beside the first
  void put_channels(const View& of, PictureJob& into) const;
  void forget_solids();  // of a mesh that was read again: they are of the one before
  bool has_trail(const View& of) const;
  std::shared_ptr<PictureJob> job(const View& of, const RendererSetup& on, Size size) const;
  std::shared_ptr<PictureJob> job_of_fit(Size size) const;

  std::vector<View> past_, future_;
  View settled_;  // the view when remember() was called last
  std::vector<std::shared_ptr<const ReadSurface>> opened_surfaces_;  // for the first view
  std::optional<LabelsBeside> opened_labels_;                        // likewise
  std::vector<std::shared_ptr<const VolumeBeside>> opened_volumes_;
  bool is_edited_ = false;
  bool awaits_first_ = false;
  bool is_reload_ = false;
  std::uint64_t version_ = 0;
  std::uint64_t view_version_ = 0;  // counts what is no change of the camera
  std::uint64_t other_version_ = 0;
};

}  // namespace ovoid::viewer
