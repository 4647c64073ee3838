// SPDX-License-Identifier: Apache-2.0
#include "ovoid/kernel_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "data/field_id.h"
#include "data/kernels/kernel_shape.h"
#include "data/kernels/kernel_sums.h"
#include "data/kernels/some_kernels.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

constexpr std::int64_t kMostSamples = 1 << 16;  // kernels looked at for a quantile
constexpr double kNarrowShare = 0.2;
constexpr double kMostSheets = 512;  // through the bounds' diagonal, by default

struct TypicalSigmas {
  double median;  // of the kernels' sizes: the geometric means of their sigmas
  double narrow;  // kernels of a fifth of all area, as seen from their flat side, are narrower
};

TypicalSigmas typical_sigmas(const KernelSource& source) {
  struct Kernel {
    double size, least, area;
  };
  std::vector<Kernel> kernels;
  data::for_some_kernels(source, kMostSamples,
                         [&](const KernelBrick&, const KernelView& view, std::int32_t i) {
                           const auto numbers = data::shape_numbers(view, source.shape(), i);
                           const Vec3 axes = data::semi_axes(source.shape(), numbers.data());
                           const double least = axes.minCoeff();
                           kernels.push_back({std::cbrt(axes.prod()), least, axes.prod() / least});
                         });
  const auto middle = kernels.begin() + static_cast<std::ptrdiff_t>(kernels.size() / 2);
  std::nth_element(kernels.begin(), middle, kernels.end(),
                   [](const Kernel& a, const Kernel& b) { return a.size < b.size; });
  TypicalSigmas sigmas{middle->size, 0.0};
  std::sort(kernels.begin(), kernels.end(),
            [](const Kernel& a, const Kernel& b) { return a.least < b.least; });
  double left = 0;
  for (const Kernel& kernel : kernels) left += kNarrowShare * kernel.area;
  for (const Kernel& kernel : kernels) {
    sigmas.narrow = kernel.least;
    left -= kernel.area;
    if (left <= 0) break;
  }
  return sigmas;
}

// Half a spacing beyond the centres: for lattice-like kernels, half a spacing is sigma.
Bounds3 bounds_of_cells(const KernelSource& source) {
  Bounds3 bounds;
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) bounds.extend(source.brick(b).cells);
  return bounds;
}

ValueRange range_of_sums(const KernelSums& sums) {
  ValueRange range{0.0F, 0.0F};  // a sum fades to nothing
  for (const float value : sums.values) {
    range.lo = std::min(range.lo, value);
    range.hi = std::max(range.hi, value);
  }
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

std::shared_ptr<const KernelSource> KernelSource::every(std::int64_t /*stride*/) const {
  return nullptr;
}

KernelField::KernelField(std::shared_ptr<const KernelSource> source, Reconstruction reconstruction,
                         int attribute, int color_attribute)
    : source_(std::move(source)), reconstruction_(reconstruction) {
  look_at_kernels(attribute, color_attribute);
  if (reconstruction_ == Reconstruction::kNormalized) {
    value_range_ = source_->attributes()[static_cast<std::size_t>(attribute_)].range;
    color_range_ = source_->attributes()[static_cast<std::size_t>(color_attribute_)].range;
    return;
  }
  const std::int64_t stride = data::stride_of_sums(num_kernels());
  take_sums({stride, data::sums_at_kernels(*this, stride)});
}

KernelField::KernelField(std::shared_ptr<const KernelSource> source, KernelSums sums, int attribute,
                         int color_attribute)
    : source_(std::move(source)), reconstruction_(Reconstruction::kSum) {
  look_at_kernels(attribute, color_attribute);
  const std::int64_t wanted =
      data::count_of_every(num_kernels(), std::max<std::int64_t>(1, sums.stride));
  if (sums.stride < 1 || std::ssize(sums.values) != wanted)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("sums: {} values at every {}th of {} kernels, expected {}",
                            sums.values.size(), sums.stride, num_kernels(), wanted));
  take_sums(std::move(sums));
}

void KernelField::take_sums(KernelSums sums) {
  value_range_ = range_of_sums(sums);
  color_range_ = has_own_color()
                     ? source_->attributes()[static_cast<std::size_t>(color_attribute_)].range
                     : value_range_;
  sums_ = std::make_shared<const KernelSums>(std::move(sums));
}

void KernelField::look_at_kernels(int attribute, int color_attribute) {
  if (!source_)
    throw Error(ErrorCode::kInvalidArgument, "source = null: a field needs a kernel source");
  attribute_ = checked_attribute(*source_, attribute, "attribute");
  color_attribute_ = color_attribute == -1
                         ? attribute_
                         : checked_attribute(*source_, color_attribute, "color_attribute");
  bounds_ = bounds_of_cells(*source_);
  const TypicalSigmas sigmas = typical_sigmas(*source_);
  sampling_distance_ = std::max(2 * sigmas.median, bounds_.diagonal().norm() / kMostSheets);
  refined_distance_ =
      std::clamp(2 * sigmas.narrow, 0.25 * sampling_distance_, 0.5 * sampling_distance_);
  id_ = data::next_field_id();
  version_ = 1;
}

}  // namespace ovoid
