// SPDX-License-Identifier: Apache-2.0
#include "make_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <span>
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

std::shared_ptr<const Surface> surface_of_file(const std::string& path, Session& session) {
  ReadOptions options;
  options.faces = true;
  options.stop = session.stop();
  options.reader_program = reader_of_environment();
  Dataset mesh = read_dataset({path}, options);
  session.notes(mesh.notes);
  if (mesh.kind != DatasetKind::kMesh && mesh.kind != DatasetKind::kBoxes) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--add: '{}' holds {}, expected a surface: .stl, .obj, .ply, .vtp "
                            "or a mesh",
                            path, mesh.kind == DatasetKind::kLattice ? "a lattice" : "points"));
  }
  if (mesh.kind == DatasetKind::kMesh) mesh.arrays = {nothing_at_nodes(mesh)};
  auto surface = make_surface(mesh, {}, session.stop());
  if (surface == nullptr || surface->triangles.empty())
    throw Error(ErrorCode::kInvalidArgument, fmt::format("--add: '{}' has no faces", path));
  return surface;
}

// The one of that number; of fewer the last.
template <class T>
T nth(const std::vector<T>& values, std::size_t n, const T& without) {
  return values.empty() ? without : values[std::min(n, values.size() - 1)];
}

// Gray, or the map of --slice-map, over what nearly all values span. What scans have much of, at
// the low end, is nothing to see: it is see-through.
TransferFunction colors_of_slices(const GeometryFlags& flags, const Field& field,
                                  Session& session) {
  constexpr double kTail = 0.005, kLow = 0.05, kMuch = 0.2;
  const Histogram histogram = histogram_of(field, session.stop());
  double lo = histogram.quantile(kTail);
  double hi = histogram.quantile(1 - kTail);
  if (!(lo < hi)) std::tie(lo, hi) = std::pair(field.value_range().lo, field.value_range().hi);
  const double empty = lo + kLow * (hi - lo);
  const bool has_empty = lo < hi && histogram.quantile(kMuch) < empty && !flags.shows_empty;
  if (flags.slice_range) std::tie(lo, hi) = *flags.slice_range;
  TransferFunction colors = color_map(flags.slice_map);
  colors.map_range(lo, lo < hi ? hi : lo + 1);
  if (has_empty) colors.opacities = {{empty, 0}, {empty + kLow * (hi - lo), 1}};
  return colors;
}

}  // namespace

Scenery make_scenery(const GeometryFlags& flags, const Field& field, Session& session) {
  Scenery all;
  for (std::size_t i = 0; i < flags.files.size(); ++i) {
    all.geometry.push_back({surface_of_file(flags.files[i], session),
                            nth(flags.colors, i, kGeometryColors[i % std::size(kGeometryColors)]),
                            nth(flags.opacities, i, 1.0), flags.shows_edges});
  }
  if (flags.slices.empty()) return all;
  const TransferFunction colors = colors_of_slices(flags, field, session);
  const Bounds3 bounds = field.world_bounds();
  for (const SlicePlane& plane : flags.slices) {
    FieldSlice slice{plane.normal, plane.offset.value_or(bounds.center().dot(plane.normal)),
                     colors};
    slice.opacity = flags.slice_opacity;
    all.slices.push_back(std::move(slice));
  }
  return all;
}

DataArray nothing_at_nodes(const Dataset& mesh) {
  const auto zeros =
      std::make_shared<const std::vector<float>>(static_cast<std::size_t>(mesh.num_positions()));
  DataArray array;
  array.name = "nothing";
  array.type = ScalarType::kFloat32;
  array.num_tuples = mesh.num_positions();
  array.bytes = {zeros, std::as_bytes(std::span(*zeros))};
  return array;
}

}  // namespace ovoid::cli
