// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/rectilinear.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// The mean step from sample to sample if all of them keep it; 0 for a single one.
std::optional<double> common_step(const std::string& where, const AxisCoordinates& axis) {
  const std::vector<double>& values = axis.values;
  double greatest = 0;
  for (const double value : values) {
    if (!std::isfinite(value))
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}: is not finite", where, value));
    greatest = std::max(greatest, std::abs(value));
  }
  if (values.size() == 1) return 0;
  const double step = (values.back() - values.front()) / static_cast<double>(values.size() - 1);
  // Half a unit in the last place of each of the three coordinates that are compared.
  const double rounding = 1.5 * (axis.is_float32 ? 0x1p-23 : 0x1p-52) * greatest;
  const double tolerance = kMaxUnevenness * std::abs(step) + rounding;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double expected = values.front() + step * static_cast<double>(i);
    if (std::abs(values[i] - expected) <= tolerance) continue;
    return std::nullopt;
  }
  return step;
}

}  // namespace

std::optional<LatticeGeometry> lattice_of_coordinates(const std::string& name,
                                                      const std::array<AxisCoordinates, 3>& axes) {
  LatticeGeometry lattice;
  Vec3 steps;
  Vec3 origin;
  double smallest = 0;  // of the axes that have a step
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const std::string where = fmt::format("{}: {} coordinates", name, "xyz"[axis]);
    lattice.dims[axis] = static_cast<std::int64_t>(axes[axis].values.size());
    origin[i] = axes[axis].values.front();
    const auto step = common_step(where, axes[axis]);
    if (!step) return std::nullopt;
    steps[i] = *step;
    if (lattice.dims[axis] == 1) continue;
    smallest = smallest == 0 ? std::abs(steps[i]) : std::min(smallest, std::abs(steps[i]));
  }
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (lattice.dims[static_cast<std::size_t>(i)] == 1) steps[i] = smallest > 0 ? smallest : 1.0;
  }
  lattice.world_from_index.linear() = steps.asDiagonal();
  lattice.world_from_index.translation() = origin;
  check_geometry(name + ": coordinates", lattice.world_from_index);
  return lattice;
}

}  // namespace ovoid::io
