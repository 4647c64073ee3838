// SPDX-License-Identifier: Apache-2.0
#include "drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "load.h"
#include "make_channels.h"
#include "make_geometry.h"
#include "make_labels.h"
#include "make_look.h"
#include "make_over.h"
#include "ovoid/error.h"
#include "ovoid/framing.h"
#include "ovoid/io.h"
#include "ovoid/sampler.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

bool shows_any(const TransferFunction& tf, const ValueRange& range) {
  if (tf.opacity_at(range.lo) > 0 || tf.opacity_at(range.hi) > 0) return true;
  return std::any_of(tf.opacities.begin(), tf.opacities.end(), [&](const OpacityPoint& point) {
    return range.lo <= point.x && point.x <= range.hi && point.opacity > 0;
  });
}

}  // namespace

std::vector<InputFile> files_to_read(const DataFlags& data, const DrawingFlags& drawing) {
  std::vector<InputFile> inputs = volume_inputs(data.inputs);
  const auto add = [&](const std::string& value, const char* what) {
    if (!value.empty() && !is_json(value)) inputs.push_back({value, what});
  };
  add(drawing.look.file, "the look of --tf");
  add(drawing.look.color_file, "the colours of --color-tf");
  add(drawing.trail.file, "the look of --trail-tf");
  add(drawing.camera.file, "the camera of --camera");
  add(drawing.surface.within, "the mesh of --within");
  for (const std::string& file : drawing.geometry.files) add(file, "a surface of --add");
  add(drawing.labels.file, "the label map of --labels");
  add(drawing.labels.table, "the names of --label-table");
  for (const std::string& file : drawing.over.files) {
    const std::vector<InputFile> own = volume_inputs({file});
    inputs.insert(inputs.end(), own.begin(), own.end());
  }
  for (const std::string& file : drawing.over.looks) add(file, "a look of --over-tf");
  for (const std::string& file : drawing.over.transforms)
    add(file, "a transform of --over-transform");
  return inputs;
}

namespace {

// The surface of --within, whose values are the field's.
std::shared_ptr<const Surface> surface_within(const std::string& path, const Field& field,
                                              Session& session) {
  DataFlags data;
  data.inputs = {path};
  Dataset mesh = [&] {
    const Quiet quiet(session);
    return load(data, session);
  }();
  if (mesh.kind != DatasetKind::kMesh && mesh.kind != DatasetKind::kBoxes)
    refuse_kind("--within", "meshes", mesh);
  if (mesh.kind == DatasetKind::kMesh) mesh.arrays = {nothing_at_nodes(mesh)};
  const auto own = make_surface(mesh, {}, session.stop());
  if (own == nullptr || !own->encloses_mesh()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--within: '{}' has no solid cells to be within", mesh.source));
  }
  return surface_with_values(*own, field, session);
}

}  // namespace

std::shared_ptr<const Surface> surface_with_values(const Surface& surface, const Field& field,
                                                   const Session& session) {
  auto made = std::make_shared<Surface>(surface);
  const FieldSampler sampler(field);
  std::vector<float> values;
  for (const Vec3& place : made->places) {
    if (session.stop().stop_requested()) throw Error(ErrorCode::kCancelled, "cancelled");
    const FieldSample sample = sampler.at(place);
    values.push_back(sample.is_defined ? static_cast<float>(sample.color_value)
                                       : std::numeric_limits<float>::quiet_NaN());
  }
  for (Surface::Triangle& triangle : made->triangles) {
    for (std::size_t i = 0; i < 3; ++i) triangle.values[i] = values[triangle.corners[i]];
  }
  return made;
}

std::shared_ptr<const Surface> surface_of(const Dataset& dataset, const DrawingFlags& drawing,
                                          const Modelled& modelled, Session& session) {
  if (!drawing.surface.within.empty())
    return surface_within(drawing.surface.within, modelled.field, session);
  if (dataset.kind != DatasetKind::kMesh && dataset.kind != DatasetKind::kBoxes) return nullptr;
  KernelModelOptions options = drawing.model.kernels;
  options.array = modelled.array;
  if (modelled.color_array != modelled.array) options.color_array = modelled.color_array;
  options.component = modelled.component;
  auto surface = dataset.share ? modelled.surface : make_surface(dataset, options, session.stop());
  if (surface == nullptr && drawing.surface.opacity.value_or(0) > 0) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--surface: '{}' has no cells whose faces are known", dataset.source));
  }
  return surface;
}

Subject make_subject(const Dataset& dataset, const Flags& flags, DrawingFlags* drawing,
                     Session& session) {
  check_kind_flags(flags, dataset);
  take_channels(dataset, flags, drawing, session);
  Subject subject;
  const bool is_said = is_segmentation(dataset) && may_draw_own_labels(*drawing);
  const auto merged = drawing->channels.names.empty()
                          ? merged_layers(dataset, drawing->model.component)
                          : std::nullopt;
  const Dataset& drawn = merged ? merged->dataset : dataset;
  subject.modelled = make_field(drawn, drawing->model, drawing->run.threads, session);
  if (!drawing->channels.names.empty())
    take_channel_look(drawn, *subject.modelled.field.lattice(), drawing);
  const bool are_labels = drawing->channels.names.empty() && !flags.is_given("kernel") &&
                          may_be_labels(drawing->look) &&
                          (is_said || holds_labels(subject.modelled.field));
  if (are_labels) {
    session.note(
        "the values look like labels: drawn by their surfaces (--label-opacity, --label-table; "
        "--kernel, --tf, --colormap with --range for another look)");
    drawing->model.lattice.kernel = kLabelKernel;
    // Within a sample a narrow kernel's field is flat; only its neighbours know where it ends.
    if (!flags.is_given("gradient")) drawing->options.gradient = GradientMethod::kCentral;
    subject.modelled = make_field(drawn, drawing->model, drawing->run.threads, session);
  }
  subject.described = describe(drawn, subject.modelled, subject.modelled.component);
  subject.unit = unit_of(drawn, subject.modelled, Role::kOpacity);
  const Field& field = subject.field();
  Volume volume{field, {}};
  volume.boundary = surface_of(drawn, *drawing, subject.modelled, session);
  subject.has_points = drawn.kind == DatasetKind::kParticles || drawn.kind == DatasetKind::kKernels;
  subject.has_walls = volume.boundary != nullptr &&
                      (drawn.kind == DatasetKind::kMesh || !drawing->surface.within.empty());
  Scene& scene = subject.scene;
  scene.volumes = {std::move(volume)};
  scene.surfaces = make_surfaces(drawing->geometry, field, session);
  if (!drawing->geometry.slices.empty())
    scene.slices = make_slices(drawing->geometry, field, histogram_of(field, session.stop()));
  if (drawing->labels.own_surfaces || (are_labels && may_draw_own_labels(*drawing))) {
    const auto table =
        merged ? merged->table : table_of_file(drawn.source, std::max(drawing->model.component, 0));
    scene.labels = make_own_labels(field, drawn.source, table, *drawing, session);
    subject.usual_look.set(label_look(scene.labels.styles));
    subject.described.label_names = names_of(scene.labels.styles);
    leave_slices_to_labels(scene.labels, scene.slices);
  } else {
    scene.labels = make_labels_beside(*drawing, session);
    const std::shared_ptr<const LabelMap>& map = scene.labels.map;
    if (map != nullptr && !map->geometry().world_bounds().intersects(field.world_bounds()))
      session.note(fmt::format("--labels: '{}' lies outside of the data, nowhere within them",
                               drawing->labels.file));
  }
  for (Volume& further : drawing->channels.names.empty() ? make_over(*drawing, drawn, session)
                                                         : make_channels(drawn, *drawing, session))
    scene.volumes.push_back(std::move(further));
  scene.mixing = mixing_of(*drawing);
  scene.plane = drawing->plane;
  return subject;
}

std::pair<double, double> range_of_integrals(const Image& image) {
  double lo = 0;
  double hi = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] == 0) continue;
    lo = std::min<double>(lo, image.rgba[i]);
    hi = std::max<double>(hi, image.rgba[i]);
  }
  return {lo, hi};
}

void spread_over_integrals(TransferFunction& tf, const Image& image, const LookFlags& flags,
                           Session& session) {
  auto [lo, hi] = range_of_integrals(image);
  if (flags.range) std::tie(lo, hi) = *flags.range;
  session.note(
      fmt::format("x-ray: colours span the integrals {:g} to {:g} (value x length)", lo, hi));
  if (!(lo < hi)) hi = lo + 1;  // nothing but zeros: the low end's colour
  if (tf.scale == ValueScale::kLog) std::tie(lo, hi) = logarithmic_range(lo, hi, session);
  tf.map_range(lo, hi);
}

void color_integrals(Image& image, const TransferFunction& tf) {
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] == 0) continue;
    const Rgb color = tf.color_at(image.rgba[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      image.rgba[i + c] = static_cast<float>(color[c]) * image.rgba[i + 3];
    }
  }
}

namespace {

// What the middle nine tenths of some values span.
double middle_span(std::vector<float>& values) {
  if (values.empty()) return 0;
  const auto quantile = [&](double q) {
    const auto place =
        values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return static_cast<double>(*place);
  };
  return quantile(0.95) - quantile(0.05);
}

// Shares of the values' range that are seen: from outside, and through all of the surface.
double share_seen(const std::shared_ptr<const Surface>& boundary, const Field& field) {
  constexpr int kSide = 64;
  Look gray = ramp_look(field.color_range(), "gray");
  gray.shade = false;
  RenderOptions small;
  small.width = small.height = kSide;
  const Camera camera = first_camera(field, boundary->bounds);
  Scene scene(field, gray);
  scene.volumes.front().boundary = boundary;
  scene.volumes.front().walls = {1, false};
  const Image image = Renderer(Backend::kCpu, 1).render(scene, camera, small).image;
  std::vector<float> values;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] >= 1) values.push_back(image.rgba[i]);
  }
  return middle_span(values);
}

double share_in_all(const Surface& surface, const Field& field) {
  std::vector<float> values;
  for (const Surface::Triangle& triangle : surface.triangles) {
    for (const float value : triangle.values) {
      if (!std::isnan(value)) values.push_back(value);
    }
  }
  const ValueRange range = field.color_range();
  const double span = static_cast<double>(range.hi) - range.lo;
  return span > 0 ? middle_span(values) / span : 1.0;
}

bool is_about_inside(const DrawingFlags& drawing) {
  const LookFlags& look = drawing.look;
  const bool has_preset = !look.preset.empty() && look.preset != kCinematicPreset;  // light alone
  return look.mode != Mode::kComposite || !look.file.empty() || has_preset ||
         !look.opacities.empty() || !look.gradient_opacities.empty() || !look.file_2d.empty() ||
         look.unit_distance || drawing.plane;
}

// Whether there are solid cells, whatever is known of their faces.
bool has_inside(const Surface& surface) {
  return surface.leaves_out_cells || surface.encloses_mesh();
}

}  // namespace

SurfaceStyle surface_to_draw(const Subject& subject, const DrawingFlags& drawing) {
  constexpr double kMuch = 0.25;
  constexpr double kSeeThrough = 0.2;
  const bool shows_edges = drawing.surface.shows_edges;
  const SurfaceStyle none{0, shows_edges};
  if (!subject.has_walls) return none;
  const std::shared_ptr<const Surface>& surface = subject.scene.volumes.front().boundary;
  if (drawing.surface.opacity) return {*drawing.surface.opacity, shows_edges};
  if (shows_edges) return {1, true};
  if (is_about_inside(drawing)) return none;
  const Field& field = subject.field();
  const bool is_constant = !(field.color_range().lo < field.color_range().hi);
  if (is_constant || !has_inside(*surface) || share_seen(surface, field) >= kMuch)
    return {1, false};
  if (share_in_all(*surface, field) >= kMuch) return {kSeeThrough, false};
  return none;
}

std::optional<PointStyle> points_to_draw(const PointFlags& points) {
  if (!points.size) return std::nullopt;
  return PointStyle{*points.size};
}

bool shows_boundary_alone(const Scene& scene) {
  const Volume& volume = scene.volumes.front();
  return volume.boundary != nullptr && volume.walls.opacity >= 1 && !scene.plane;
}

std::string picture_ending(const std::string& path) {
  for (const char* const ending : {".png", ".jpg", ".jpeg", ".exr", ".npy"}) {
    if (has_ending(path, ending)) return ending;
  }
  return "";
}

bool is_for_eyes(const std::string& path) {
  const std::string ending = picture_ending(path);
  return ending == ".png" || ending == ".jpg" || ending == ".jpeg";
}

void check_background(const DrawingFlags& drawing, const std::string& output) {
  if (drawing.background) return;
  const std::string ending = picture_ending(output);
  if (ending != ".jpg" && ending != ".jpeg") return;
  throw UsageError(
      fmt::format("--background none: '{}' is a JPEG, which cannot be transparent", output));
}

bool is_empty(const Image& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    if (image.rgba[i] > 0) return false;
  }
  return true;
}

std::string cause_of_emptiness(const Look& look, const ValueRange& range) {
  std::string cause =
      "is all of the data clipped away or out of sight, or too thin for its sheets "
      "(--sampling-distance)?";
  const auto is_among = [&](double value) { return range.lo <= value && value <= range.hi; };
  const auto& surfaces = look.isosurfaces;
  const bool has_any =
      surfaces.empty()
          ? is_among(look.isovalue)
          : std::any_of(surfaces.begin(), surfaces.end(),
                        [&](const Isosurface& surface) { return is_among(surface.value); });
  if (look.mode == Mode::kIsosurface && !has_any) {
    cause = fmt::format("--iso {:g} is not among them", look.isovalue);
  } else if (uses_opacity(look.mode) && !shows_any(look.transfer_function, range)) {
    cause = "the look gives them no opacity (--range, --opacity, --tf)";
  }
  return fmt::format("the data's values are {:g} to {:g}; {}", range.lo, range.hi, cause);
}

void write_picture(Image& image, const DrawingFlags& drawing, const Described& described,
                   const Camera& camera, const Look& look, const PictureFile& file) {
  draw_annotations(image, drawing.annotation, described, camera, look, drawing.background);
  // Of the other modes a depth is no surface's.
  const bool has_surface = look.mode == Mode::kComposite || look.mode == Mode::kIsosurface;
  if (has_surface && picture_ending(file.path) == ".exr")
    image.normals = depth_normals(image.depth, image.width, image.height, camera);
  write_image(image, file.path, drawing.background, {file.stop});
}

}  // namespace ovoid::cli
