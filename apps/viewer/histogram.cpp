// SPDX-License-Identifier: Apache-2.0
#include "histogram.h"

#include <algorithm>
#include <cmath>

#include "ovoid/error.h"
#include "ovoid/sampler.h"

namespace ovoid::viewer {
namespace {

constexpr std::int64_t kEnoughSamples = 4'000'000;
constexpr std::int64_t kEnoughKernels = 20'000;  // where each is a sum over its neighbours

class Counter {
 public:
  explicit Counter(const ValueRange& range) {
    histogram_.lo = range.lo;
    histogram_.hi = range.hi > range.lo ? static_cast<double>(range.hi) : range.lo + 1.0;
    histogram_.counts.assign(kHistogramBins, 0);
    bins_per_value_ = kHistogramBins / (histogram_.hi - histogram_.lo);
  }
  void count(double value) {
    const double bin = std::floor((value - histogram_.lo) * bins_per_value_);
    if (!std::isfinite(bin)) return;
    ++histogram_.counts[static_cast<std::size_t>(std::clamp(bin, 0.0, kHistogramBins - 1.0))];
  }
  Histogram result() {
    histogram_.greatest = *std::max_element(histogram_.counts.begin(), histogram_.counts.end());
    return std::move(histogram_);
  }

 private:
  Histogram histogram_;
  double bins_per_value_ = 1;
};

template <typename Sample>
void count_samples(const BrickView& view, const Index3& lo, const Index3& hi,
                   const BrickSource& source, Counter& counter) {
  const auto* const data = static_cast<const Sample*>(view.data);
  for (std::int64_t k = lo[2]; k < hi[2]; ++k) {
    for (std::int64_t j = lo[1]; j < hi[1]; ++j) {
      const Sample* const row =
          data + (j - view.lo[1]) * view.stride_y + (k - view.lo[2]) * view.stride_z - view.lo[0];
      for (std::int64_t i = lo[0]; i < hi[0]; ++i)
        counter.count(static_cast<double>(row[i]) * source.value_scale() + source.value_offset());
    }
  }
}

void count_brick(const BrickView& view, const Index3& lo, const Index3& hi,
                 const BrickSource& source, Counter& counter) {
  switch (view.type) {
    case ScalarType::kUInt8:
      return count_samples<std::uint8_t>(view, lo, hi, source, counter);
    case ScalarType::kInt8:
      return count_samples<std::int8_t>(view, lo, hi, source, counter);
    case ScalarType::kUInt16:
      return count_samples<std::uint16_t>(view, lo, hi, source, counter);
    case ScalarType::kInt16:
      return count_samples<std::int16_t>(view, lo, hi, source, counter);
    default:
      return count_samples<float>(view, lo, hi, source, counter);
  }
}

void count_lattice(const LatticeField& field, Counter& counter, const std::stop_token& stop) {
  const BrickSource& source = field.source();
  const LatticeGeometry& geometry = source.geometry();
  const std::int64_t edge = source.brick_edge();
  Index3 bricks{};
  for (std::size_t a = 0; a < 3; ++a) bricks[a] = (geometry.cells()[a] + edge - 1) / edge;
  const std::int64_t step = 1 + field.num_kernels() / kEnoughSamples;
  for (std::int64_t b = 0; b < num_samples(bricks); b += step) {
    if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "interrupted");
    const std::int64_t x = b % bricks[0];
    const std::int64_t y = b / bricks[0] % bricks[1];
    const std::int64_t z = b / (bricks[0] * bricks[1]);
    const BrickView view = source.acquire(x, y, z, 0);
    const std::int64_t layers = edge * geometry.num_sublattices();
    const Index3 lo{x * edge, y * edge, z * layers};
    const Index3 hi{std::min(lo[0] + edge, geometry.dims[0]),
                    std::min(lo[1] + edge, geometry.dims[1]),
                    std::min(lo[2] + layers, geometry.dims[2])};
    count_brick(view, lo, hi, source, counter);
  }
}

void count_kernels(const KernelField& field, Counter& counter, const std::stop_token& stop) {
  const KernelSource& source = field.source();
  const bool is_sum = field.reconstruction() == Reconstruction::kSum;
  const std::int64_t enough = is_sum ? kEnoughKernels : kEnoughSamples;
  const std::int64_t step = 1 + source.num_kernels() / enough;
  const KernelSampler sampler(field);
  const auto attribute = static_cast<std::size_t>(field.attribute());
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "interrupted");
    const KernelBrick& brick = source.brick(b);
    const KernelView view = source.acquire(b, 0);
    for (std::int64_t i = b % step; i < view.count; i += step) {
      if (!is_sum) {
        counter.count(static_cast<double>(view.value[attribute][i]));
        continue;
      }
      const Vec3 center =
          brick.origin + Vec3(view.center[0][i], view.center[1][i], view.center[2][i]);
      counter.count(sampler.at(center).value);
    }
  }
}

}  // namespace

Histogram histogram_of(const Field& field, const std::stop_token& stop) {
  const ValueRange range = field.value_range();
  if (!(range.lo <= range.hi)) return {};
  Counter counter(range);
  if (field.lattice() != nullptr) {
    count_lattice(*field.lattice(), counter, stop);
  } else {
    count_kernels(*field.kernels(), counter, stop);
  }
  return counter.result();
}

}  // namespace ovoid::viewer
