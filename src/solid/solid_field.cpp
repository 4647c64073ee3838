// SPDX-License-Identifier: Apache-2.0
//
// A level of a subdivision solid -> kernels. A vertex gets the mean metric of the corners around
// it, J J^T, which maps Gaussians of the regular mesh of edge 1; where values are to be worked out,
// they solve the linear equations that the field takes the densities at the vertices.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "data/parallel.h"
#include "model/mesh/ellipsoid_shape.h"
#include "model/particles/kernel_parts.h"
#include "ovoid/error.h"
#include "ovoid/fit.h"
#include "solid/corner_frames.h"
#include "solid/hex_topology.h"
#include "solid/link.h"

namespace ovoid {

namespace solid {

namespace {

// Of the interpolating one a falloff between 1.9, with which the cardinal functions of a regular
// mesh come nearest the basis (6.9 % of it), and 1.4, with which smooth densities come nearest the
// solid, with less ripple. Of the others least squares over
// [-3, 3]^3; a pair with falloffs nearer to each other is better by 0.05 % and has heights of
// thousands (docs/numerics.md, "Subdivision solids").
constexpr std::array<BasisGaussian, 1> kInterpolatingGaussian = {{{1, 1.6}}};
constexpr std::array<BasisGaussian, 1> kOneGaussian = {{{1.0346, 2.6291}}};
constexpr std::array<BasisGaussian, 2> kTwoGaussians = {{{6.9342784, 1.6}, {-5.9645329, 1.5}}};

// What cells around a vertex are like.
struct VertexFrame {
  Mat3 factor = Mat3::Identity();  // L with L L^T = J J^T
  // Volume that the vertex stands for over that of the frame: 1 where the mesh is regular and at
  // its boundary.
  double share = 1;
};

VertexFrame frame_of_vertex(const SolidMesh& level, const HexTopology& topology,
                            std::uint32_t vertex) {
  Mat3 metric = Mat3::Zero();
  double volume = 0;
  const auto cells = topology.cells_of_vertex.of(vertex);
  for (const std::uint32_t c : cells) {
    const auto& cell = level.cells[c];
    const auto corner = std::find(cell.begin(), cell.end(), vertex) - cell.begin();
    const Mat3 frame = corner_frame(level, c, static_cast<int>(corner));
    metric += frame * frame.transpose();
    volume += std::abs(frame.determinant());
  }
  const auto count = static_cast<double>(cells.size());
  VertexFrame result;
  result.factor = model::shape_of_covariance(metric / count).factor;
  const bool is_inside = link_of_vertex(topology, level.cells, vertex).is_closed;
  const double stands_for = is_inside ? volume / 8 : volume / count;
  result.share = std::clamp(stands_for / result.factor.determinant(), 0.25, 4.0);
  return result;
}

constexpr std::int64_t kFrameGrain = 1024;

std::vector<VertexFrame> frames_of(const SolidMesh& level, const SolidFieldOptions& options) {
  const HexTopology topology = checked_topology(level);
  std::vector<VertexFrame> frames(level.num_vertices());
  data::parallel_ranges(
      {static_cast<std::int64_t>(frames.size()), kFrameGrain, options.threads, options.stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v)
          frames[v] = frame_of_vertex(level, topology, static_cast<std::uint32_t>(v));
      });
  return frames;
}

// Values at which the field takes the densities at the vertices, as nearly as conjugate gradients
// get: the ridge holds what a degenerate mesh leaves open.
std::vector<double> interpolating_values(const SolidMesh& level, const KernelColumns& columns,
                                         const SolidFieldOptions& options) {
  const KernelOperator field(columns, Reconstruction::kSum, level.positions, options.threads,
                             options.stop);
  const std::vector<double> shares(level.num_vertices(), 1.0);
  ValueProblem problem;
  problem.targets = level.densities;
  problem.shares = shares;
  problem.ridge = 1e-6;
  problem.iterations = 200;
  problem.tolerance = 1e-5;
  std::vector<double> values = level.densities;
  fit_values(field, problem, values, options.stop);
  return values;
}

}  // namespace

}  // namespace solid

const char* name_of(SolidBasis basis) noexcept {
  switch (basis) {
    case SolidBasis::kInterpolating:
      return "interpolating";
    case SolidBasis::kOneGaussian:
      return "one";
    case SolidBasis::kTwoGaussians:
      return "two";
  }
  return "unknown";
}

std::span<const BasisGaussian> gaussians_of(SolidBasis basis) noexcept {
  switch (basis) {
    case SolidBasis::kOneGaussian:
      return solid::kOneGaussian;
    case SolidBasis::kTwoGaussians:
      return solid::kTwoGaussians;
    case SolidBasis::kInterpolating:
      break;
  }
  return solid::kInterpolatingGaussian;
}

namespace solid {
namespace {

KernelField field_of(const SolidMesh& level, const SolidFieldOptions& options) {
  const std::vector<solid::VertexFrame> frames = solid::frames_of(level, options);
  std::vector<double> centers, values;
  std::vector<float> shapes, weights;
  for (const BasisGaussian& gaussian : gaussians_of(options.basis)) {
    const double sigma = std::sqrt(0.5 / gaussian.falloff);
    for (std::size_t v = 0; v < frames.size(); ++v) {
      const Vec3 at = level.position(v);
      centers.insert(centers.end(), at.begin(), at.end());
      model::append_factor(sigma * frames[v].factor, shapes);
      weights.push_back(static_cast<float>(frames[v].share * std::abs(gaussian.height)));
      values.push_back(std::copysign(1.0, gaussian.height) * level.densities[v]);
    }
  }
  KernelColumns columns;
  columns.shape = KernelShape::kEllipsoids;
  columns.cutoff = options.cutoff;
  columns.centers = centers;
  columns.shapes = shapes;
  columns.weights = weights;
  if (options.basis == SolidBasis::kInterpolating)
    values = solid::interpolating_values(level, columns, options);
  const std::vector<float> stored(values.begin(), values.end());
  columns.values.emplace_back(stored);
  columns.attributes.push_back({level.name, level.unit, {}});
  return {make_kernel_source(columns, options.threads), Reconstruction::kSum};
}

}  // namespace
}  // namespace solid

KernelField make_solid_field(const SolidMesh& level, const SolidFieldOptions& options) {
  try {
    return solid::field_of(level, options);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("no memory for the kernels of {} vertices", level.num_vertices()));
  }
}

}  // namespace ovoid
