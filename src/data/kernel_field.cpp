// SPDX-License-Identifier: Apache-2.0
#include "ovoid/kernel_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "data/field_id.h"
#include "data/kernel_shape.h"
#include "data/some_kernels.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

constexpr std::int64_t kMostSamples = 1 << 16;  // kernels looked at for a quantile
constexpr double kMostSheets = 512;             // through the bounds' diagonal, by default

// The median of the kernels' sizes: the geometric means of their sigmas.
double median_sigma(const KernelSource& source) {
  std::vector<double> sizes;
  data::for_some_kernels(
      source, kMostSamples, [&](const KernelBrick&, const KernelView& view, std::int32_t i) {
        const auto numbers = data::shape_numbers(view, source.shape(), i);
        sizes.push_back(std::cbrt(data::factor_of(source.shape(), numbers.data()).determinant()));
      });
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

// Half a spacing beyond the centres: for lattice-like kernels, half a spacing is sigma.
Bounds3 bounds_of_cells(const KernelSource& source) {
  Bounds3 bounds;
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    // A brick's box is wider than its centres' by the reach of kernels of nearly one size.
    const KernelBrick& brick = source.brick(b);
    const KernelView view = source.acquire(b, 0.0);
    for (std::int32_t i = 0; i < view.count; ++i) {
      const auto numbers = data::shape_numbers(view, source.shape(), i);
      const Vec3 at = brick.origin + data::offset_of(view, i);
      const Vec3 reach = data::factor_of(source.shape(), numbers.data()).rowwise().norm();
      bounds.extend(Bounds3(at - reach, at + reach));
    }
  }
  return bounds;
}

// A summed field at some of its centres.
ValueRange sampled_sum_range(const KernelField& field) {
  constexpr std::int64_t kMostEvaluations = 8192;
  const KernelSampler sampler(field);
  const KernelSource& source = field.source();
  const std::int64_t stride =
      std::max<std::int64_t>(1, std::min(source.num_kernels(), kMostSamples) / kMostEvaluations);
  ValueRange range{0.0F, 0.0F};  // a sum fades to nothing
  std::int64_t count = 0;
  data::for_some_kernels(
      source, kMostSamples, [&](const KernelBrick& brick, const KernelView& view, std::int32_t i) {
        if (count++ % stride != 0) return;
        const auto value =
            static_cast<float>(sampler.at(brick.origin + data::offset_of(view, i)).value);
        range.lo = std::min(range.lo, value);
        range.hi = std::max(range.hi, value);
      });
  return range;
}

int checked_attribute(const KernelSource& source, int attribute, const char* name) {
  const auto count = static_cast<int>(source.attributes().size());
  if (attribute < 0 || attribute >= count)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{} = {}: must be from 0 to {}", name, attribute, count - 1));
  return attribute;
}

}  // namespace

KernelField::KernelField(std::shared_ptr<const KernelSource> source, Reconstruction reconstruction,
                         int attribute, int color_attribute)
    : source_(std::move(source)), reconstruction_(reconstruction) {
  if (!source_)
    throw Error(ErrorCode::kInvalidArgument, "source = null: a field needs a kernel source");
  attribute_ = checked_attribute(*source_, attribute, "attribute");
  color_attribute_ = color_attribute == -1
                         ? attribute_
                         : checked_attribute(*source_, color_attribute, "color_attribute");
  bounds_ = bounds_of_cells(*source_);
  sampling_distance_ =
      std::max(2 * median_sigma(*source_), bounds_.diagonal().norm() / kMostSheets);
  id_ = data::next_field_id();
  version_ = 1;
  if (reconstruction_ == Reconstruction::kNormalized) {
    value_range_ = source_->attributes()[static_cast<std::size_t>(attribute_)].range;
    color_range_ = source_->attributes()[static_cast<std::size_t>(color_attribute_)].range;
  } else {
    value_range_ = sampled_sum_range(*this);
    color_range_ = has_own_color()
                       ? source_->attributes()[static_cast<std::size_t>(color_attribute_)].range
                       : value_range_;
  }
}

}  // namespace ovoid
