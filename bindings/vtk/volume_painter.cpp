// SPDX-License-Identifier: Apache-2.0
#include "volume_painter.h"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkMatrix4x4.h>
#include <vtkPlane.h>
#include <vtkPlaneCollection.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkRectilinearGrid.h>
#include <vtkRenderer.h>
#include <vtkTimeStamp.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkVolume.h>
#include <vtkVolumeMapper.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "colored_extremes.h"
#include "grid_dataset.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "placed_lattice.h"
#include "point_set_dataset.h"
#include "property_look.h"

namespace ovoid::mappers {
namespace {

class Watch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

Affine3 matrix_of(vtkVolume* volume) {
  Affine3 world_from_data = Affine3::Identity();
  vtkMatrix4x4* const matrix = volume->GetMatrix();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      world_from_data(row, column) = matrix->GetElement(row, column);
  }
  if (!world_from_data.matrix().allFinite() || !(world_from_data.linear().determinant() != 0))
    throw Error(ErrorCode::kInvalidArgument, "the volume's matrix is degenerate");
  return world_from_data;
}

// What else than the array a field is made of.
std::vector<double> shape_of(vtkDataSet* data) {
  std::vector<double> shape;
  const auto add_time = [&](vtkObject* object) {
    shape.push_back(object != nullptr ? static_cast<double>(object->GetMTime()) : 0);
  };
  add_time(data->GetPointGhostArray());
  add_time(data->GetCellGhostArray());
  if (auto* const image = vtkImageData::SafeDownCast(data)) {
    shape.insert(shape.end(), image->GetExtent(), image->GetExtent() + 6);
    shape.insert(shape.end(), image->GetOrigin(), image->GetOrigin() + 3);
    shape.insert(shape.end(), image->GetSpacing(), image->GetSpacing() + 3);
    const double* const directions = image->GetDirectionMatrix()->GetData();
    shape.insert(shape.end(), directions, directions + 9);
    return shape;
  }
  if (auto* const grid = vtkRectilinearGrid::SafeDownCast(data)) {
    shape.insert(shape.end(), grid->GetExtent(), grid->GetExtent() + 6);
    for (vtkObject* const axis :
         {grid->GetXCoordinates(), grid->GetYCoordinates(), grid->GetZCoordinates()})
      add_time(axis);
    return shape;
  }
  if (auto* const points = vtkPointSet::SafeDownCast(data);
      points != nullptr && points->GetPoints()) {
    add_time(points->GetPoints());
    add_time(points->GetPoints()->GetData());
  }
  if (auto* const grid = vtkUnstructuredGrid::SafeDownCast(data)) {
    add_time(grid->GetCells());
    add_time(grid->GetCellTypesArray());
  }
  return shape;
}

// vtkOvoidVolumeMapper::KernelType, in its order.
void take_kernel(int kernel, LatticeModelOptions* options) {
  constexpr LatticeKernel kKernels[] = {{}, kBSplineKernel, kCatmullRomKernel, {}, kBSplineKernel};
  if (kernel == 0) return;
  options->kernel = kKernels[kernel];
  if (options->kernel->kind == LatticeKernelKind::kBSpline) options->prefilter = kernel == 1;
}

// How much of the array the field's samples lie in; 0: they are copies.
std::int64_t shared_bytes_of(const Field& field, const Dataset& dataset) {
  const LatticeField* const lattice = field.lattice();
  if (lattice == nullptr) return 0;
  const BrickView samples = lattice->samples().acquire(0, 0, 0, 0);
  const auto* const first = static_cast<const std::byte*>(samples.data);
  const auto bytes = dataset.arrays.front().bytes.view;
  const bool is_within = first >= bytes.data() && first < bytes.data() + bytes.size();
  return is_within ? static_cast<std::int64_t>(bytes.size()) : 0;
}

// Throws Error for several components in a blend mode that has one.
void require_several(int blend_mode, std::size_t count, bool are_dependent) {
  const bool is_additive = blend_mode == vtkVolumeMapper::ADDITIVE_BLEND;
  const char* const name = blend_mode == vtkVolumeMapper::AVERAGE_INTENSITY_BLEND ? "average"
                           : blend_mode == vtkVolumeMapper::ISOSURFACE_BLEND      ? "isosurface"
                           : blend_mode == vtkVolumeMapper::SLICE_BLEND           ? "slice"
                           : is_additive && are_dependent                         ? "additive"
                                                                                  : nullptr;
  if (name == nullptr) return;
  throw Error(ErrorCode::kUnsupported,
              are_dependent
                  ? fmt::format("blend mode {}: {} dependent components: composite, maximum and "
                                "minimum draw them (IndependentComponentsOn, SetVectorMode)",
                                name, count)
                  : fmt::format("blend mode {}: {} independent components with a weight: one is "
                                "drawn (SetComponentWeight 0 of the others, SetVectorMode)",
                                name, count));
}

RendererSetup setup_for(int backend, int num_threads) {
  constexpr Backend kBackends[] = {Backend::kAuto, Backend::kCpu, Backend::kVulkan};
  RendererSetup setup;
  setup.backend = kBackends[backend];
  setup.threads = num_threads;
  return setup;
}

}  // namespace

void VolumePainter::make_field(vtkDataSet* data, const DrawnValues& drawn,
                               const Affine3& world_from_data, const FieldKey& key) {
  auto* const points = vtkPointSet::SafeDownCast(data);
  Dataset dataset = points != nullptr ? point_set_dataset(points, drawn, world_from_data)
                                      : grid_dataset(data, drawn, world_from_data);
  const std::size_t num_components = drawn.components.size();
  if (num_components > 1 && dataset.kind != DatasetKind::kLattice) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("array '{}': {} {} components at uneven coordinates: one is drawn "
                            "(SetComponentWeight 0 of the others, SetVectorMode)",
                            dataset.arrays.front().name, num_components,
                            drawn.are_dependent ? "dependent" : "independent"));
  }
  FieldModelOptions options;
  options.kernels.is_density = dataset.arrays.empty();  // particles without values
  if (!dataset.arrays.empty()) {
    DataArray& array = dataset.arrays.front();
    if (key.is_negated) array.value_scale = -1;
    options.lattice.array = options.kernels.array = array.name;
  }
  take_kernel(key.kernel, &options.lattice);
  const auto field_of = [&](const DrawnComponent& component) {
    options.lattice.component = options.kernels.component = component.component;
    Field field = ovoid::make_field(dataset, options);
    if (field.value_range().is_empty()) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("array '{}': no value is a finite number", options.lattice.array));
    }
    return field;
  };
  made_ = field_of(drawn.components.front());
  made_further_.reserve(num_components - 1);
  if (drawn.are_dependent) dataset.arrays.front().value_scale = 1;  // of colours
  for (std::size_t i = 1; i < num_components; ++i)
    made_further_.push_back(*field_of(drawn.components[i]).lattice());
  shared_bytes_ = shared_bytes_of(made_, dataset);
  const bool has_surface =
      dataset.kind == DatasetKind::kMesh || dataset.kind == DatasetKind::kBoxes;
  surface_ = has_surface ? make_surface(dataset, options.kernels) : nullptr;
  if (surface_ != nullptr && !surface_->encloses_mesh()) surface_ = nullptr;
}

// Lattices move as they are; kernels are made where they are.
void VolumePainter::place_field(const Affine3& world_from_data) {
  world_from_made_ = world_from_data;
  const LatticeField* const lattice = made_.lattice();
  field_ = lattice != nullptr ? Field(placed(*lattice, world_from_data)) : made_;
  further_.clear();
  further_.reserve(made_further_.size());
  for (const LatticeField& further : made_further_)
    further_.push_back(placed(further, world_from_data));
}

void VolumePainter::update_field(vtkDataSet* data, const DrawnValues& drawn,
                                 const Affine3& world_from_data, const MapperSettings& settings) {
  FieldKey key;
  key.array = drawn.array;
  if (drawn.array != nullptr) {
    if (drawn.array->HasStandardMemoryLayout()) key.values = drawn.array->GetVoidPointer(0);
    key.array_time = drawn.array->GetMTime();
  }
  key.components.reserve(drawn.components.size());
  for (const DrawnComponent& component : drawn.components)
    key.components.push_back(component.component);
  key.kernel = settings.kernel;
  key.is_negated = settings.blend_mode == vtkVolumeMapper::MINIMUM_INTENSITY_BLEND;
  key.shape = shape_of(data);
  const bool stays = world_from_made_.isApprox(world_from_data, 0.0);
  if (key_ == key && (stays || made_.lattice() != nullptr)) {
    if (!stays) place_field(world_from_data);
    return;
  }
  key_.reset();
  made_ = field_ = Field();
  made_further_.clear();
  make_field(data, drawn, world_from_data, key);
  place_field(world_from_data);
  key_ = std::move(key);
  vtkTimeStamp now;
  now.Modified();
  field_time_ = now.GetMTime();
}

Renderer& VolumePainter::renderer_for(const MapperSettings& settings) {
  if (!renderer_ || renderer_backend_ != settings.backend ||
      renderer_threads_ != settings.num_threads) {
    renderer_.reset();
    renderer_.emplace(setup_for(settings.backend, settings.num_threads));
    renderer_backend_ = settings.backend;
    renderer_threads_ = settings.num_threads;
  }
  return *renderer_;
}

RenderOptions VolumePainter::options_for(const MapperSettings& settings,
                                         const Affine3& world_from_data) const {
  RenderOptions options;
  options.width = view_.width;
  options.height = view_.height;
  options.sampling_distance = settings.sample_distance;
  if (settings.has_image_sheets) options.sheets = Sheets::kImage;
  // A coarser field would be made of this part of the data alone, and not match that of the next.
  if (settings.owned && is_minified()) options.post_convolution = PostConvolution::kOff;
  if (settings.cropping && is_one_box(*settings.cropping))
    options.clip_planes = planes_of_box(*settings.cropping, world_from_data);
  if (settings.clipping_planes != nullptr) {
    for (int i = 0; i < settings.clipping_planes->GetNumberOfItems(); ++i) {
      vtkPlane* const plane = settings.clipping_planes->GetItem(i);
      const Vec3 normal(plane->GetNormal());
      options.clip_planes.push_back({normal, normal.dot(Vec3(plane->GetOrigin()))});
    }
  }
  for (const ClipPlane& plane : clipping_range_planes(view_, field_.world_bounds()))
    options.clip_planes.push_back(plane);
  return options;
}

void VolumePainter::add_limits(vtkRenderer* renderer, const MapperSettings& settings,
                               const Affine3& world_from_data, RenderOptions* options) {
  std::shared_ptr<const DepthLimits> limits;
  const auto narrow = [&](DepthLimits other) {
    limits = std::make_shared<const DepthLimits>(limits ? intersection(*limits, other)
                                                        : std::move(other));
  };
  const Watch reading;
  const std::span<const float> depths = screen_.depths(renderer, view_, farthest_depth());
  times_.screen += reading.seconds();
  if (!depths.empty()) {
    if (scene_limits_ == nullptr) scene_limits_ = std::make_shared<DepthLimits>();
    limits_before(depths, view_, scene_limits_.get());
    limits = scene_limits_;
  }
  if (settings.cropping && !is_one_box(*settings.cropping))
    narrow(region_limits(*settings.cropping, world_from_data, view_));
  if (settings.owned) narrow(box_limits(*settings.owned, view_));
  options->depth_limits = std::move(limits);
}

// Whether some pixel is wider than the samples of a lattice are apart.
bool VolumePainter::is_minified() const {
  const Camera& camera = view_.camera;
  constexpr double kRadians = 3.14159265358979323846 / 180;
  const double half = camera.parallel_projection
                          ? camera.parallel_scale
                          : farthest_depth() * std::tan(0.5 * kRadians * camera.view_angle);
  return 2 * half / view_.height > field_.default_sampling_distance();
}

// Where the field ends, as seen.
double VolumePainter::farthest_depth() const {
  const Vec3 ahead = (view_.camera.focal_point - view_.camera.position).normalized();
  double farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 place = field_.world_bounds().corner(static_cast<Bounds3::CornerType>(corner));
    farthest = std::max(farthest, ahead.dot(place - view_.camera.position));
  }
  return farthest;
}

// As many pixels as the time that the window grants allows, by that of the last frame.
double VolumePainter::image_distance_for(vtkVolume* volume, double greatest) const {
  const double granted = volume->GetAllocatedRenderTime();
  if (!(greatest > 1) || !(granted > 0) || !(frame_seconds_ > 0)) return 1;
  const double whole = frame_seconds_ * image_distance_ * image_distance_;
  // A little beyond is borne: few pixels less are seen at once.
  constexpr double kBorne = 1.2;
  return whole <= kBorne * granted ? 1 : std::min(std::sqrt(whole / granted), greatest);
}

void VolumePainter::prepare(vtkVolume* volume, vtkDataSet* data, const MapperSettings& settings) {
  if (data == nullptr) throw Error(ErrorCode::kInvalidArgument, "no input: expected a data set");
  if (data->GetNumberOfPoints() < 1) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("the input, a {}, is empty", data->GetClassName()));
  }
  drawn_ = drawn_values(data, settings.arrays, volume->GetProperty());
  update_field(data, drawn_, matrix_of(volume), settings);
}

double VolumePainter::field_distance(vtkVolume* volume, const MapperSettings& settings) const {
  const auto distance_of = [&](std::size_t component, const Field& field) {
    return sheet_distance(field, look_of(volume, component, field, settings), {});
  };
  double distance = distance_of(0, field_);
  for (std::size_t i = 0; i < further_.size(); ++i)
    distance = std::min(distance, distance_of(i + 1, Field(further_[i])));
  return distance;
}

Look VolumePainter::look_of(vtkVolume* volume, std::size_t component, const Field& field,
                            const MapperSettings& settings) const {
  vtkVolumeProperty* const property = volume->GetProperty();
  if (drawn_.are_dependent && component > 0)
    return look_of_color(property, drawn_, component, field);
  Look look = look_of_property(property, drawn_.components[component], settings.blend_mode, field);
  if (!drawn_.are_dependent) return look;
  if (look.transfer_function_2d) {
    throw Error(ErrorCode::kUnsupported,
                "two-dimensional transfer functions: are not drawn of dependent components "
                "(IndependentComponentsOn, SetVectorMode)");
  }
  leave_colors(&look);
  return look;
}

// VTK's sum of independent components' colours is nearest to what Mixing::kAdded shows, and in the
// modes maximum and minimum the same. What ADDITIVE_BLEND adds are extinctions.
Scene VolumePainter::scene_of(vtkRenderer* renderer, vtkVolume* volume,
                              const MapperSettings& settings) const {
  Scene scene;
  const auto add = [&](const Field& field) {
    Look look = look_of(volume, scene.volumes.size(), field, settings);
    take_lights(renderer, field.world_bounds().center(), &look);
    scene.volumes.push_back({field, std::move(look)});
  };
  add(field_);
  scene.volumes.front().boundary = surface_;
  if (further_.empty()) return scene;
  require_several(settings.blend_mode, further_.size() + 1, drawn_.are_dependent);
  scene.mixing = drawn_.are_dependent                                     ? Mixing::kColored
                 : settings.blend_mode == vtkVolumeMapper::ADDITIVE_BLEND ? Mixing::kAveraged
                                                                          : Mixing::kAdded;
  for (const LatticeField& further : further_) add(Field(further));
  return scene;
}

// The library's planes clip the field alone, VTK's the slice, too.
Frame VolumePainter::draw_slice(vtkVolume* volume, Scene scene, const RenderOptions& options,
                                const MapperSettings& settings) {
  Look& look = scene.volumes.front().look;
  scene.slices = {slice_of(volume->GetProperty(), look)};
  look.transfer_function.opacities = {{0, 0}};
  RenderOptions alone = options;
  alone.sheets = Sheets::kImage;
  alone.clip_planes.clear();
  if (!options.clip_planes.empty()) {
    DepthLimits planes = plane_limits(options.clip_planes, view_);
    if (options.depth_limits != nullptr) planes = intersection(*options.depth_limits, planes);
    alone.depth_limits = std::make_shared<const DepthLimits>(std::move(planes));
  }
  return renderer_for(settings).render(scene, view_.camera, alone);
}

Frame VolumePainter::draw_extremes(const Scene& scene, const RenderOptions& options,
                                   const MapperSettings& settings) {
  RenderOptions alone = options;
  alone.sheets = Sheets::kImage;  // on which a pixel's depth is on its own ray
  Renderer& renderer = renderer_for(settings);
  const Volume& first = scene.volumes.front();
  Frame frame = renderer.render({first.field, first.look}, view_.camera, alone);
  times_.renderer += 1e-3 * color_extremes(renderer, scene, view_, alone, &frame.image);
  return frame;
}

const KernelSums& VolumePainter::field_sums(const MapperSettings& settings) {
  const auto is_same = [](const Bounds3& a, const Bounds3& b) {
    return a.min() == b.min() && a.max() == b.max();
  };
  const bool has_same_box = settings.owned.has_value() == sums_box_.has_value() &&
                            (!sums_box_ || is_same(*settings.owned, *sums_box_));
  if (sums_time_ == field_time_ && has_same_box) return sums_;
  const KernelField* const kernels = field_.kernels();
  sums_ = kernels != nullptr ? kernel_sums(*kernels, settings.owned) : KernelSums{};
  sums_time_ = field_time_;
  sums_box_ = settings.owned;
  return sums_;
}

int VolumePainter::field_kernel() const {
  const LatticeField* const lattice = made_.lattice();
  if (lattice == nullptr || lattice->kernel().kind == LatticeKernelKind::kGaussian) return 3;
  if (lattice->kernel().kind == LatticeKernelKind::kCatmullRom) return 2;
  return lattice->source().samples() != nullptr ? 1 : 4;  // whether it is prefiltered
}

void VolumePainter::draw(vtkRenderer* renderer, vtkVolume* volume, vtkDataSet* data,
                         const MapperSettings& settings) {
  if (renderer->GetSelector() != nullptr) return;  // which wants numbers of props for colours
  const Watch all;
  const double distance = image_distance_for(volume, settings.greatest_image_distance);
  times_ = {};
  view_ = view_of(renderer);
  if (view_.width < 1 || view_.height < 1) return;
  prepare(volume, data, settings);
  const Affine3 world_from_data = matrix_of(volume);
  const Watch drawing;
  Scene scene = scene_of(renderer, volume, settings);
  image_distance_ = distance;
  view_ = coarser(view_, distance);
  RenderOptions options = options_for(settings, world_from_data);
  add_limits(renderer, settings, world_from_data, &options);
  const bool is_slice = settings.blend_mode == vtkVolumeMapper::SLICE_BLEND;
  const bool is_colored = drawn_.are_dependent && scene.volumes.front().look.mode == Mode::kMaximum;
  Frame frame = is_slice     ? draw_slice(volume, std::move(scene), options, settings)
                : is_colored ? draw_extremes(scene, options, settings)
                             : renderer_for(settings).render(scene, view_.camera, options);
  times_.renderer += 1e-3 * frame.profile.frame_ms;
  if (settings.blend_mode == vtkVolumeMapper::ADDITIVE_BLEND) show_sums(&frame.image);
  image_ = std::move(frame.image);
  image_view_ = view_;
  const Watch showing;
  screen_.show(renderer, view_, image_);
  times_.screen += showing.seconds();
  frame_seconds_ = drawing.seconds();
  times_.all = all.seconds();
}

std::int64_t VolumePainter::field_bytes() const {
  if (made_.is_empty()) return 0;
  std::size_t bytes = made_.resident_bytes();
  for (const LatticeField& further : made_further_) bytes += Field(further).resident_bytes();
  return static_cast<std::int64_t>(bytes) - shared_bytes_;
}

void draw_or_tell(const std::function<void()>& draw, const std::function<void(const char*)>& tell) {
  try {
    draw();
  } catch (const std::bad_alloc&) {
    tell("out of memory: nothing is drawn");
  } catch (const std::exception& error) {
    tell(error.what());
  }
}

namespace {

// Rows from the bottom, of the part of the picture that the viewport shows.
void copy_viewport(const VolumePainter& painter, const std::vector<float>& values, int count,
                   vtkImageData* image) {
  const View& view = painter.image_view();
  const bool is_coarse = view.coarseness_x > 1 || view.coarseness_y > 1;
  const int width = is_coarse ? view.width : view.viewport_width;
  const int height = is_coarse ? view.height : view.viewport_height;
  const bool is_drawn = !values.empty();
  image->SetDimensions(is_drawn ? width : 0, is_drawn ? height : 0, is_drawn ? 1 : 0);
  image->AllocateScalars(VTK_FLOAT, count);
  if (!is_drawn) return;
  auto* out = static_cast<float*>(image->GetScalarPointer());
  for (int y = 0; y < height; ++y) {
    const auto row = static_cast<std::size_t>(view.height - 1 - (y + view.bottom));
    const std::size_t first =
        (row * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(view.left)) *
        static_cast<std::size_t>(count);
    const auto length = static_cast<std::size_t>(width) * static_cast<std::size_t>(count);
    out = std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(first), length, out);
  }
}

}  // namespace

void copy_colors(const VolumePainter& painter, vtkImageData* image) {
  copy_viewport(painter, painter.image().rgba, 4, image);
}

void copy_depths(const VolumePainter& painter, vtkImageData* image) {
  copy_viewport(painter, painter.image().depth, 1, image);
}

}  // namespace ovoid::mappers
