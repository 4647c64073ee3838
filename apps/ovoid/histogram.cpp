// SPDX-License-Identifier: Apache-2.0
#include "histogram.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ovoid/error.h"
#include "ovoid/sampler.h"

namespace ovoid::cli {
namespace {

constexpr std::int64_t kEnoughSamples = 4'000'000;
constexpr std::int64_t kEnoughKernels = 20'000;  // where each is a sum over its neighbours
constexpr std::int64_t kEnoughValues = 200'000;  // for quantiles

Histogram::Bins bins_over(double lo, double hi, std::size_t number) {
  return {lo, hi > lo ? hi : lo + 1, std::vector<std::uint64_t>(number, 0), 0};
}

void add(Histogram::Bins& bins, double at) {
  const auto number = static_cast<double>(bins.counts.size());
  const double bin = std::floor((at - bins.lo) / (bins.hi - bins.lo) * number);
  ++bins.counts[static_cast<std::size_t>(std::clamp(bin, 0.0, number - 1))];
}

class Counter {
 public:
  // `step`: between values where only multiples of it occur, else 0.
  // `expected`: about how many values there will be.
  Counter(const ValueRange& range, double step, std::int64_t expected)
      : values_apart_(1 + expected / kEnoughValues) {
    const double span = static_cast<double>(range.hi) - range.lo;
    const double values = step > 0 ? std::round(span / step) + 1 : 0;
    if (values >= 2 && values <= kHistogramBins) {
      histogram_.linear =
          bins_over(range.lo - step / 2, range.hi + step / 2, static_cast<std::size_t>(values));
    } else {
      histogram_.linear = bins_over(range.lo, range.hi, kHistogramBins);
    }
    if (!(range.hi > 0)) return;
    constexpr double kDecades = 6;
    const double hi = std::log10(static_cast<double>(range.hi));
    const double lo = range.lo > 0 ? std::log10(static_cast<double>(range.lo)) : hi - kDecades;
    histogram_.logarithmic = bins_over(lo, hi, kHistogramBins);
  }
  void count(double value) {
    if (!std::isfinite(value)) return;
    if (num_counted_++ % values_apart_ == 0) histogram_.values.push_back(static_cast<float>(value));
    add(histogram_.linear, value);
    Histogram::Bins& logarithmic = histogram_.logarithmic;
    if (value <= 0 || logarithmic.counts.empty()) return;
    const double at = std::log10(value);
    if (at >= logarithmic.lo) add(logarithmic, at);
  }
  Histogram result() {
    for (Histogram::Bins* const bins : {&histogram_.linear, &histogram_.logarithmic}) {
      if (bins->counts.empty()) continue;
      bins->greatest = *std::max_element(bins->counts.begin(), bins->counts.end());
    }
    std::sort(histogram_.values.begin(), histogram_.values.end());
    return std::move(histogram_);
  }

 private:
  Histogram histogram_;
  std::int64_t values_apart_;
  std::int64_t num_counted_ = 0;
};

// Between the values of a lattice of whole numbers; 0 for others.
double step_of(const Field& field) {
  const LatticeField* const lattice = field.lattice();
  if (lattice == nullptr) return 0;
  const BrickSource& source = lattice->samples();
  return is_floating(source.acquire(0, 0, 0, 0).type) ? 0 : std::abs(source.value_scale());
}

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
  const BrickSource& source = field.samples();
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

double Histogram::quantile(double q) const {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double place = std::clamp(q, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(static_cast<double>(values[below]), static_cast<double>(values[above]),
                   place - static_cast<double>(below));
}

Histogram histogram_of(const Field& field, const std::stop_token& stop) {
  const ValueRange range = field.value_range();
  if (!(range.lo <= range.hi)) return {};
  Counter counter(range, step_of(field), std::min(field.num_kernels(), kEnoughSamples));
  if (field.lattice() != nullptr) {
    count_lattice(*field.lattice(), counter, stop);
  } else {
    count_kernels(*field.kernels(), counter, stop);
  }
  return counter.result();
}

}  // namespace ovoid::cli
