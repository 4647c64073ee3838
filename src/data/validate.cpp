// SPDX-License-Identifier: Apache-2.0
#include "data/validate.h"

#include <fmt/format.h>

#include <cmath>

#include "ovoid/error.h"

namespace ovoid::data {

namespace {

[[noreturn]] void fail(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

}  // namespace

void validate_kernel(const LatticeKernel& kernel) {
  if (kernel.kind != LatticeKernelKind::kGaussian &&
      !(kernel == LatticeKernel{.kind = kernel.kind})) {
    fail(
        fmt::format("kernel {} with sigma = {}, cutoff = {}: has one size, leave them at {} and {}",
                    name_of(kernel.kind), kernel.sigma, kernel.cutoff, LatticeKernel{}.sigma,
                    LatticeKernel{}.cutoff));
  }
  // Written so that NaN fails.
  if (!(kernel.sigma >= LatticeKernel::kMinSigma && kernel.sigma <= LatticeKernel::kMaxSigma)) {
    fail(fmt::format("kernel sigma = {}: must be {} to {} spacings", kernel.sigma,
                     LatticeKernel::kMinSigma, LatticeKernel::kMaxSigma));
  }
  if (!(kernel.cutoff > 0 && kernel.cutoff <= LatticeKernel::kMaxCutoff)) {
    fail(fmt::format("kernel cutoff = {}: must be > 0 and <= {} sigmas", kernel.cutoff,
                     LatticeKernel::kMaxCutoff));
  }
  if (kernel.support_radius() < LatticeKernel::kMinSupport) {
    fail(
        fmt::format("kernel sigma * cutoff = {}: must be >= {} spacings, or the kernels leave gaps",
                    kernel.support_radius(), LatticeKernel::kMinSupport));
  }
}

// Products of three spacings, and of their inverses, do not overflow; and of the places of samples
// along one axis those along another one are still told apart.
constexpr double kLeastSpacing = 1e-100;
constexpr double kMostSpacingRatio = 1e12;

void validate_geometry(const LatticeGeometry& geometry) {
  std::int64_t samples = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t size = geometry.dims[axis];
    if (size < 1) fail(fmt::format("lattice dims[{}] = {}: must be >= 1", axis, size));
    if (size > kMaxSamples / samples) {
      fail(fmt::format("lattice dims = {} x {} x {}: must be at most {} samples", geometry.dims[0],
                       geometry.dims[1], geometry.dims[2], kMaxSamples));
    }
    samples *= size;
  }
  if (geometry.dims[2] < geometry.num_sublattices())
    fail(fmt::format("lattice dims[2] = {}: a body-centred lattice has at least 2 layers",
                     geometry.dims[2]));
  if (!geometry.world_from_index.matrix().allFinite()) {
    fail("lattice world_from_index: must be finite (spacing, origin or directions are not)");
  }
  Mat3 axes = geometry.world_from_index.linear();
  Vec3 lengths;
  for (int axis = 0; axis < 3; ++axis) {
    const double length = axes.col(axis).stableNorm();
    if (!(length > 0) || !std::isfinite(length)) {
      fail(fmt::format("lattice spacing[{}] = {}: must be > 0 and finite", axis, length));
    }
    if (!(length >= kLeastSpacing && length <= 1 / kLeastSpacing)) {
      fail(fmt::format("lattice spacing[{}] = {}: must be {} to {}; give lengths in another unit",
                       axis, length, kLeastSpacing, 1 / kLeastSpacing));
    }
    axes.col(axis) /= length;
    lengths[axis] = length;
  }
  if (!(lengths.maxCoeff() <= kMostSpacingRatio * lengths.minCoeff())) {
    fail(fmt::format("lattice spacing = {}, {}, {}: must differ by a factor of at most {}",
                     lengths[0], lengths[1], lengths[2], kMostSpacingRatio));
  }
  if (!(std::abs(axes.determinant()) >= kMinRelativeVolume)) {
    fail(fmt::format("lattice axis directions: must not lie in one plane (relative volume {})",
                     std::abs(axes.determinant())));
  }
}

void require_field(const Field& field) {
  if (field.is_empty())
    fail(
        "field: is empty; make_lattice_field() and make_kernel_field() make one of a dataset, and "
        "the constructors of LatticeField and KernelField of a source");
}

}  // namespace ovoid::data
