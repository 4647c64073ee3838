// SPDX-License-Identifier: Apache-2.0
// What both mappers do: data to a field, once; property and camera to a look and a view; a frame;
// and its picture onto the screen.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "kernel_sums.h"
#include "ovoid/dataset.h"
#include "ovoid/field.h"
#include "ovoid/image.h"
#include "ovoid/renderer.h"
#include "ovoid/surface.h"
#include "ray_limits.h"
#include "screen.h"
#include "view.h"
#include "vtk_arrays.h"

class vtkDataSet;
class vtkImageData;
class vtkPlaneCollection;
class vtkRenderer;
class vtkVolume;
class vtkWindow;

namespace ovoid::mappers {

// What a mapper says beside its volume, in VTK's words.
struct MapperSettings {
  ArrayChoice arrays;
  int kernel = 0;  // of lattices, vtkOvoidVolumeMapper::KernelType
  int blend_mode = 0;
  int backend = 0;
  int num_threads = 0;
  double sample_distance = 0;
  double greatest_image_distance = 1;
  vtkPlaneCollection* clipping_planes = nullptr;  // or null
  std::optional<Cropping> cropping;
  std::optional<Bounds3> owned;  // world; what lies outside is drawn elsewhere
  bool has_image_sheets = false;
};

// Seconds of a frame; `screen` is OpenGL's share.
struct FrameTimes {
  double all = 0;
  double renderer = 0;
  double screen = 0;
};

class VolumePainter {
 public:
  // Makes a field anew where it is due, and draws a frame over the renderer's viewport. Throws
  // Error, and what the library throws; the painter can be used again.
  void draw(vtkRenderer* renderer, vtkVolume* volume, vtkDataSet* data,
            const MapperSettings& settings);

  // The field alone, where it is due; draw() then finds it made. Throws as draw().
  void prepare(vtkVolume* volume, vtkDataSet* data, const MapperSettings& settings);
  // The distance of sheets that the field which was made last asks for, world units.
  double field_distance(vtkVolume* volume, const MapperSettings& settings) const;
  // vtkOvoidVolumeMapper::KernelType of that field, never AUTO_KERNEL.
  int field_kernel() const;
  // Of a field of kernels, those whose centres are owned; of a lattice zeros.
  // Made once for each field and box.
  const KernelSums& field_sums(const MapperSettings& settings);

  void release(vtkWindow* window) { screen_.release(window); }

  const FrameTimes& times() const { return times_; }
  double image_distance() const { return image_distance_; }
  // A count of VTK's clock: when the field was made; 0: never.
  std::uint64_t field_time() const { return field_time_; }
  // Whether the field's samples lie in the array's own memory.
  bool shares_memory() const { return shared_bytes_ > 0; }
  // Of the field, without the samples that it shares.
  std::int64_t field_bytes() const;
  // Of the last frame that was drawn.
  const View& image_view() const { return image_view_; }
  const Image& image() const { return image_; }

 private:
  // What a field is made of; another key, another field.
  struct FieldKey {
    const void* array = nullptr;
    const void* values = nullptr;
    std::uint64_t array_time = 0;
    std::vector<int> components;
    int kernel = 0;
    bool is_negated = false;    // for the least values, which are the greatest of the negated
    std::vector<double> shape;  // geometry, or the times of what says it
    bool operator==(const FieldKey&) const = default;
  };

  void update_field(vtkDataSet* data, const DrawnValues& drawn, const Affine3& world_from_data,
                    const MapperSettings& settings);
  void make_field(vtkDataSet* data, const DrawnValues& drawn, const Affine3& world_from_data,
                  const FieldKey& key);
  void place_field(const Affine3& world_from_data);
  // Of the component of drawn_ that `field` is of.
  Look look_of(vtkVolume* volume, std::size_t component, const Field& field,
               const MapperSettings& settings) const;
  // All components, without limits.
  Scene scene_of(vtkRenderer* renderer, vtkVolume* volume, const MapperSettings& settings) const;
  Frame draw_slice(vtkVolume* volume, Scene scene, const RenderOptions& options,
                   const MapperSettings& settings);
  // Of dependent components, in two frames.
  Frame draw_extremes(const Scene& scene, const RenderOptions& options,
                      const MapperSettings& settings);
  Renderer& renderer_for(const MapperSettings& settings);
  RenderOptions options_for(const MapperSettings& settings, const Affine3& world_from_data) const;
  void add_limits(vtkRenderer* renderer, const MapperSettings& settings,
                  const Affine3& world_from_data, RenderOptions* options);
  bool is_minified() const;
  double farthest_depth() const;
  double image_distance_for(vtkVolume* volume, double greatest) const;

  std::optional<FieldKey> key_;
  DrawnValues drawn_;  // of the last data
  Field made_;         // where the data have it
  Field field_;        // in the world
  // Of the second component that is drawn, the third ...: likewise.
  std::vector<LatticeField> made_further_;
  std::vector<LatticeField> further_;
  Affine3 world_from_made_ = Affine3::Identity();
  std::shared_ptr<const Surface> surface_;  // of a mesh; or null
  std::uint64_t field_time_ = 0;
  std::int64_t shared_bytes_ = 0;
  KernelSums sums_{};
  std::uint64_t sums_time_ = 0;  // of the field that they are of
  std::optional<Bounds3> sums_box_;
  std::optional<Renderer> renderer_;
  int renderer_backend_ = 0;
  int renderer_threads_ = 0;
  Screen screen_;
  std::shared_ptr<DepthLimits> scene_limits_;  // of the last frame; their memory is the next one's
  View view_;                                  // of the frame that is under way
  View image_view_;
  Image image_;
  FrameTimes times_;
  double frame_seconds_ = 0;  // of the last frame, without making its field; 0: none
  double image_distance_ = 1;
};

// One draw() for a mapper: says in one line what went wrong.
void draw_or_tell(const std::function<void()>& draw, const std::function<void(const char*)>& tell);

// The last frame's viewport, rows from the bottom, as floats.
void copy_colors(const VolumePainter& painter, vtkImageData* image);
void copy_depths(const VolumePainter& painter, vtkImageData* image);

}  // namespace ovoid::mappers
