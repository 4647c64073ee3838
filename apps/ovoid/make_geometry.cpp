// SPDX-License-Identifier: Apache-2.0
#include "make_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "environment.h"
#include "histogram.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/model.h"

namespace ovoid::cli {
namespace {

// Of surfaces that are given none, in turn: bone, steel, copper, moss.
constexpr Rgb kGeometryColors[] = {
    {0.9, 0.87, 0.78}, {0.55, 0.66, 0.78}, {0.8, 0.5, 0.32}, {0.5, 0.64, 0.4}};

// The one of that number; of fewer the last.
template <class T>
T nth(const std::vector<T>& values, std::size_t n, const T& without) {
  return values.empty() ? without : values[std::min(n, values.size() - 1)];
}

// Gray, or the map of --slice-map, over what nearly all values span. What scans have much of, at
// the low end, is nothing to see: it is see-through.
TransferFunction colors_of_slices(const GeometryFlags& flags, const Histogram& histogram,
                                  const ValueRange& range) {
  constexpr double kLow = 0.05, kMuch = 0.2;
  auto [lo, hi] = usual_slice_range(histogram, range);
  const double empty = lo + kLow * (hi - lo);
  const double is_clear = empty + kLow * (hi - lo);
  const bool has_empty = lo < hi && histogram.quantile(kMuch) < empty && !flags.shows_empty;
  if (flags.slice_range) std::tie(lo, hi) = *flags.slice_range;
  TransferFunction colors = color_map(flags.slice_map);
  colors.map_range(lo, lo < hi ? hi : lo + 1);
  if (has_empty) colors.opacities = {{empty, 0}, {is_clear, 1}};
  return colors;
}

// As radiologists' programs tell their three views apart: sagittal, coronal, axial.
Rgb usual_outline_color(const Vec3& normal) {
  constexpr Rgb kOfAxes[] = {{0.93, 0.84, 0.30}, {0.43, 0.69, 0.29}, {0.96, 0.31, 0.28}};
  const double length = normal.norm();
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(normal[axis]) == length) return kOfAxes[axis];
  return {0.9, 0.9, 0.9};
}

// Faces, and tubes and balls; null: there are none.
std::shared_ptr<const Surface> both(std::shared_ptr<const Surface> faces,
                                    std::shared_ptr<const Surface> tubes) {
  if (faces == nullptr) return tubes;
  if (tubes == nullptr) return faces;
  auto all = std::make_shared<Surface>(*faces);
  const auto first = static_cast<std::uint32_t>(all->places.size());
  all->places.insert(all->places.end(), tubes->places.begin(), tubes->places.end());
  for (Surface::Triangle triangle : tubes->triangles) {
    for (std::uint32_t& corner : triangle.corners) corner += first;
    all->triangles.push_back(triangle);
  }
  all->bounds.extend(tubes->bounds);
  return all;
}

// What programs write along with faces, under the names that VTK's readers and writers give it.
bool is_of_faces(const std::string& name) {
  static constexpr std::array<std::string_view, 7> kOfFaces = {
      kNothing, "Normals", "TCoords", "RGB", "RGBA", "Texture Coordinates", "TextureCoordinates"};
  return std::find(kOfFaces.begin(), kOfFaces.end(), name) != kOfFaces.end();
}

}  // namespace

Dataset read_faces(const std::string& path, Session& session) {
  if (const auto held = session.provided(path)) return *held;
  ReadOptions options;
  options.faces = true;
  options.stop = session.stop();
  options.reader_program = reader_of_environment();
  Dataset mesh = read_dataset({path}, options);
  session.notes(mesh.notes);
  return mesh;
}

std::shared_ptr<const Surface> surface_of_faces(Dataset mesh, const std::string& path,
                                                const GeometryFlags& flags, std::size_t n,
                                                const Session& session) {
  if (mesh.kind == DatasetKind::kLattice || mesh.kind == DatasetKind::kKernels) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--add: '{}' holds {}, expected a surface: .stl, .obj, .ply, .vtp "
                            "or a mesh",
                            path, mesh.kind == DatasetKind::kLattice ? "a lattice" : "kernels"));
  }
  KernelModelOptions options;
  const AddedStyle style = added_style(flags, n);
  options.array = style.array;
  if (options.array.empty() && mesh.kind != DatasetKind::kBoxes)
    mesh.arrays = {nothing_at_nodes(mesh)};
  auto surface = both(make_surface(mesh, options, session.stop()),
                      make_tubes(mesh, style.radius, options, session.stop()));
  if (surface == nullptr || surface->triangles.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--add: '{}' has no faces, lines or points", path));
  }
  return surface;
}

bool has_more_than_faces(const Dataset& mesh) {
  return mesh.kind != DatasetKind::kMesh ||
         std::any_of(mesh.arrays.begin(), mesh.arrays.end(),
                     [](const DataArray& array) { return !is_of_faces(array.name); });
}

bool has_lines_or_points(const Dataset& mesh) {
  if (mesh.kind == DatasetKind::kParticles) return true;
  const auto types = mesh.cells.types.view();
  return mesh.kind == DatasetKind::kMesh && std::any_of(types.begin(), types.end(), [](CellType t) {
           return t == CellType::kVertex || t == CellType::kLine || t == CellType::kPolyLine;
         });
}

std::vector<std::string> arrays_for_colors(const Dataset& mesh) {
  std::vector<std::string> names;
  for (const DataArray& array : mesh.arrays) {
    const bool is_new = std::find(names.begin(), names.end(), array.name) == names.end();
    if (is_new && !array.name.empty() && !is_of_faces(array.name)) names.push_back(array.name);
  }
  return names;
}

AddedStyle added_style(const GeometryFlags& flags, std::size_t n) {
  AddedStyle style;
  style.color = nth(flags.colors, n, usual_surface_color(n));
  style.opacity = nth(flags.opacities, n, 1.0);
  style.array = nth(flags.arrays, n, std::string());
  style.color_map = nth(flags.color_maps, n, std::string(kUsualAddedMap));
  if (!flags.ranges.empty()) style.range = nth(flags.ranges, n, {});
  style.radius = nth(flags.radii, n, 0.0);
  return style;
}

std::pair<double, double> range_of_values(const Surface& surface) {
  double lo = std::numeric_limits<double>::max(), hi = std::numeric_limits<double>::lowest();
  for (const Surface::Triangle& triangle : surface.triangles) {
    for (const float value : triangle.values) {
      if (!std::isfinite(value)) continue;
      lo = std::min<double>(lo, value);
      hi = std::max<double>(hi, value);
    }
  }
  return lo <= hi ? std::pair(lo, hi) : std::pair(0.0, 1.0);
}

TransferFunction colors_of_values(const std::string& map, const std::pair<double, double>& range) {
  TransferFunction colors = color_map(map);
  colors.map_range(range.first, range.first < range.second ? range.second : range.first + 1);
  return colors;
}

Rgb usual_surface_color(std::size_t n) { return kGeometryColors[n % std::size(kGeometryColors)]; }

Geometry styled_surface(const GeometryFlags& flags, std::size_t n,
                        std::shared_ptr<const Surface> surface) {
  const AddedStyle style = added_style(flags, n);
  Geometry geometry;
  geometry.color = style.color;
  geometry.opacity = style.opacity;
  geometry.shows_edges = flags.shows_edges;
  if (surface != nullptr && !style.array.empty()) {
    const auto range = style.range ? *style.range : range_of_values(*surface);
    geometry.colors = colors_of_values(style.color_map, range);
  }
  geometry.surface = std::move(surface);
  return geometry;
}

std::pair<double, double> usual_slice_range(const Histogram& histogram, const ValueRange& range) {
  constexpr double kTail = 0.005;
  const double lo = histogram.quantile(kTail);
  const double hi = histogram.quantile(1 - kTail);
  return lo < hi ? std::pair(lo, hi) : std::pair<double, double>(range.lo, range.hi);
}

std::vector<FieldSlice> make_slices(const GeometryFlags& flags, const Field& field,
                                    const Histogram& histogram) {
  const TransferFunction colors = colors_of_slices(flags, histogram, field.value_range());
  const Bounds3 bounds = field.world_bounds();
  std::vector<FieldSlice> slices;
  for (const SlicePlane& plane : flags.slices) {
    FieldSlice slice{plane.normal, plane.offset.value_or(bounds.center().dot(plane.normal)),
                     colors};
    slice.opacity = flags.slice_opacity;
    if (flags.has_outlines)
      slice.outline = flags.outline_color.value_or(usual_outline_color(plane.normal));
    slices.push_back(std::move(slice));
  }
  return slices;
}

std::vector<Geometry> make_surfaces(const GeometryFlags& flags, const Field& field,
                                    Session& session) {
  std::vector<Geometry> all;
  for (std::size_t i = 0; i < flags.files.size(); ++i) {
    if (nth(flags.opacities, i, 1.0) == 0) continue;
    const std::string& path = flags.files[i];
    all.push_back(styled_surface(
        flags, i, surface_of_faces(read_faces(path, session), path, flags, i, session)));
    if (!all.back().surface->bounds.intersects(field.world_bounds()))
      session.note(fmt::format("'{}' lies outside of the data, nowhere within them", path));
  }
  return all;
}

DataArray nothing_at_nodes(const Dataset& mesh) {
  const auto zeros =
      std::make_shared<const std::vector<float>>(static_cast<std::size_t>(mesh.num_positions()));
  DataArray array;
  array.name = kNothing;
  array.type = ScalarType::kFloat32;
  array.num_tuples = mesh.num_positions();
  array.bytes = {zeros, std::as_bytes(std::span(*zeros))};
  return array;
}

}  // namespace ovoid::cli
