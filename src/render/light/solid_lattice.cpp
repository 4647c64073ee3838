// SPDX-License-Identifier: Apache-2.0
// A picture of the mesh along z, a pixel for each column of cells: the spans in which its ray is
// inside are what fills the column.
#include "render/light/solid_lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "render/passes/boundary_limits.h"
#include "view/plan/visible_points.h"

namespace ovoid {
namespace {

constexpr int kSolidCells = 96;                         // along the longest side
constexpr double kSolidExtinction = kOpaqueExtinction;  // per cell edge, of a full cell

std::int64_t cells_along(double length, double edge) {
  return std::max<std::int64_t>(1, std::llround(std::ceil(length / edge))) + 4;
}

// Adds what a span of depths, in cells, fills of a column.
void fill_column(double begin, double end, float share, std::size_t stride,
                 std::vector<float>& cells, std::size_t first, std::int64_t count) {
  begin = std::clamp(begin, 0.0, static_cast<double>(count));
  end = std::clamp(end, 0.0, static_cast<double>(count));
  for (auto k = static_cast<std::int64_t>(begin); k < count && static_cast<double>(k) < end; ++k) {
    const auto at = static_cast<double>(k);
    const double filled = std::min(end, at + 1) - std::max(begin, at);
    cells[first + static_cast<std::size_t>(k) * stride] += share * static_cast<float>(filled);
  }
}

// A quarter of each cell to either side, along each axis: what is slanted or round has no steps
// then.
void blur(const Index3& dims, std::vector<float>& cells) {
  std::size_t stride = 1;
  std::vector<float> line;
  for (const std::int64_t dim : dims) {
    const auto count = static_cast<std::size_t>(dim);
    line.resize(count);
    for (std::size_t first = 0; first < cells.size(); ++first) {
      if (first / stride % count != 0) continue;
      for (std::size_t i = 0; i < count; ++i) line[i] = cells[first + i * stride];
      for (std::size_t i = 1; i + 1 < count; ++i)
        cells[first + i * stride] = 0.25F * (line[i - 1] + 2 * line[i] + line[i + 1]);
    }
    stride *= count;
  }
}

}  // namespace

ExtinctionLattice solid_lattice(const Surface& surface, const std::vector<ClipPlane>& clip_planes,
                                int threads, const std::stop_token& stop) {
  const Vec3 size = surface.bounds.sizes();
  const double edge = size.maxCoeff() / kSolidCells;
  ExtinctionLattice out;
  Vec3 half;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t count = cells_along(size[a], edge);
    out.dims[static_cast<std::size_t>(a)] = count;
    half[a] = 0.5 * edge * static_cast<double>(count);
  }
  const Vec3 middle = surface.bounds.center();
  out.world_from_cell = Eigen::Translation3d(middle - half + Vec3::Constant(0.5 * edge)) *
                        Eigen::Scaling(Vec3::Constant(edge));

  // Towards +z with y up, x goes to the left.
  Camera camera;
  camera.parallel_projection = true;
  camera.focal_point = middle;
  camera.position = middle - Vec3(0, 0, half[2] + edge);
  camera.view_up = Vec3(0, 1, 0);
  camera.parallel_scale = half[1];
  RenderOptions options;
  options.width = static_cast<int>(out.dims[0]);
  options.height = static_cast<int>(out.dims[1]);
  const DepthLimits limits =
      boundary_limits(surface, camera, {}, {0, false}, options, threads, stop);
  const auto stride = static_cast<std::size_t>(out.dims[0] * out.dims[1]);
  out.extinction.assign(stride * static_cast<std::size_t>(out.dims[2]), 0.0F);
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      const auto number_of = [&](int row, int column) {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(options.width) +
               static_cast<std::size_t>(column);
      };
      const std::size_t pixel = number_of(y, x);
      const auto stops = limits.of_pixel(x, y);
      const std::size_t column = number_of(options.height - 1 - y, options.width - 1 - x);
      for (std::size_t i = 0; i < stops.size(); ++i) {
        if (!stops[i].is_field_behind) continue;
        const double end = i + 1 < stops.size() ? static_cast<double>(stops[i + 1].depth)
                                                : std::numeric_limits<double>::infinity();
        // The first cell begins an edge behind the eye's plane.
        fill_column(static_cast<double>(stops[i].depth) / edge - 1, end / edge - 1,
                    limits.coverage[pixel], stride, out.extinction, column, out.dims[2]);
      }
    }
  }
  blur(out.dims, out.extinction);
  std::size_t cell = 0;
  for (std::int64_t k = 0; k < out.dims[2]; ++k) {
    for (std::int64_t j = 0; j < out.dims[1]; ++j) {
      for (std::int64_t i = 0; i < out.dims[0]; ++i, ++cell) {
        const Vec3 place =
            out.world_from_cell *
            Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        const bool is_kept = clip_planes.empty() || view::is_kept(place, clip_planes);
        out.extinction[cell] *= is_kept ? static_cast<float>(kSolidExtinction / edge) : 0.0F;
      }
    }
  }
  return out;
}

}  // namespace ovoid
