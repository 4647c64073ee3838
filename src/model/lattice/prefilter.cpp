// SPDX-License-Identifier: Apache-2.0
//
// Samples -> coefficients of an interpolating field.
//
// A slice is filtered along x and y while it is in the cache; then some lanes along z, in a buffer,
// since slices a power of two apart would push each other out of the cache. What threads take
// shares nothing.
#include "model/lattice/prefilter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "data/parallel.h"
#include "model/lattice/holes.h"
#include "model/lattice/line_solver.h"
#include "model/time/slice_filter.h"
#include "ovoid/error.h"

namespace ovoid::model {

namespace {

// Larger samples are made smaller while they are filtered: coefficients may be 50 times as large
// along each axis, and no sum may overflow on the way.
constexpr float kLargestAsItIs = 1e32F;
constexpr float kShrink = 0x1p-22F;

void filter_slices(std::span<float> samples, const Index3& dims, const PrefilterOptions& options) {
  const SliceFilter filter(dims, options);
  const std::int64_t slice = dims[0] * dims[1];
  const std::int64_t grain = std::max<std::int64_t>(kGrainSamples / slice, 1);
  data::parallel_ranges({dims[2], grain, options.threads, options.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (std::int64_t z = begin; z < end; ++z)
                            filter.apply(samples.data() + z * slice);
                        });
}

void filter_along_z(std::span<float> samples, const Index3& dims, const PrefilterOptions& options) {
  const LineSolver along_z(dims[2], options.kernel, options.reconstruction);
  const std::int64_t slice = dims[0] * dims[1];
  const std::int64_t batches = (slice + kLanesAlongZ - 1) / kLanesAlongZ;
  const std::int64_t grain =
      std::max<std::int64_t>(kGrainSamples / (kLanesAlongZ * along_z.size()), 1);
  data::parallel_ranges(
      {batches, grain, options.threads, options.stop}, [&](std::int64_t begin, std::int64_t end) {
        std::vector<float> lines(static_cast<std::size_t>(along_z.size() * kLanesAlongZ));
        for (std::int64_t b = begin; b < end; ++b) {
          const std::int64_t lanes = std::min(kLanesAlongZ, slice - b * kLanesAlongZ);
          float* const first = samples.data() + b * kLanesAlongZ;
          for (std::int64_t j = 0; j < along_z.size(); ++j)
            std::copy_n(first + j * slice, lanes, lines.data() + j * kLanesAlongZ);
          along_z.solve({lines.data(), kLanesAlongZ, lanes});
          for (std::int64_t j = 0; j < along_z.size(); ++j)
            std::copy_n(lines.data() + j * kLanesAlongZ, lanes, first + j * slice);
        }
      });
}

// Of samples of which none is missing.
bool are_large(std::span<const float> samples, const ValueRange& range) {
  if (!range.is_empty()) return std::max(std::abs(range.lo), std::abs(range.hi)) > kLargestAsItIs;
  return std::any_of(samples.begin(), samples.end(),
                     [](float sample) { return std::abs(sample) > kLargestAsItIs; });
}

}  // namespace

double least_response(const LatticeKernel& kernel) {
  // A cosine polynomial of at most 64 terms (kMaxSigma * kMaxCutoff): 1024 steps resolve each of
  // its waves 16-fold.
  constexpr int kFrequencies = 1024;
  const std::vector<double> taps = one_axis_taps(kernel);
  double constant = taps[0];
  for (std::size_t k = 1; k < taps.size(); ++k) constant += 2 * taps[k];
  double least = constant;
  for (int step = 1; step <= kFrequencies; ++step) {
    const double frequency = std::numbers::pi * step / kFrequencies;
    double response = taps[0];
    for (std::size_t k = 1; k < taps.size(); ++k) {
      response += 2 * taps[k] * std::cos(static_cast<double>(k) * frequency);
    }
    least = std::min(least, response);
  }
  return least / constant;
}

void require_interpolating(const LatticeKernel& kernel) {
  const double response = least_response(kernel);
  if (response >= kMinResponse) return;
  // The largest smaller sigma that will do, to two digits.
  LatticeKernel narrower = kernel;
  for (int hundredths = static_cast<int>(std::ceil(kernel.sigma * 100)) - 1; hundredths > 0;
       --hundredths) {
    narrower.sigma = hundredths / 100.0;
    if (least_response(narrower) >= kMinResponse) break;
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("kernel sigma = {}: its samples cannot be interpolated (least response "
                          "{:.2g}, must be >= {}); with cutoff {} prefilter needs sigma <= {}",
                          kernel.sigma, response, kMinResponse, kernel.cutoff, narrower.sigma));
}

void prefilter(std::span<float> samples, const Index3& dims, const PrefilterOptions& options) {
  require_interpolating(options.kernel);
  std::vector<bool> missing;
  if (options.may_miss) missing = fill_missing(samples, dims, options.stop);
  const bool shrinks = are_large(samples, options.range);
  if (shrinks)
    for (float& sample : samples) sample *= kShrink;
  filter_slices(samples, dims, options);
  filter_along_z(samples, dims, options);
  if (shrinks) {
    constexpr float kLargest = std::numeric_limits<float>::max() * kShrink;
    for (float& sample : samples) sample = std::clamp(sample, -kLargest, kLargest) / kShrink;
  }
  restore_missing(samples, missing);
}

}  // namespace ovoid::model
