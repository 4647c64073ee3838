// SPDX-License-Identifier: Apache-2.0
//
// The window holds consecutive slices that are filtered along x and y and eliminated along z: those
// of the slab whose coefficients are next, as many behind it as these need to look ahead, and the
// last before it.
#include "model/lattice/coefficients.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "model/lattice/line_solver.h"
#include "model/time/slice_filter.h"

namespace ovoid::model {

namespace {

constexpr double kMostLevels = 4096;
constexpr std::int64_t kSlab = 32;  // slices
constexpr double kUsualRange = 4;   // of coefficients, in ranges of samples
constexpr double kSteps = 65534.0;  // between the least and the greatest of 16 bits

// Samples that are rounded to `offset + n * step`.
struct Quantizer {
  double offset;
  double step;

  explicit Quantizer(const ValueRange& range)
      : offset(0.5 * (static_cast<double>(range.lo) + static_cast<double>(range.hi))),
        step((static_cast<double>(range.hi) - static_cast<double>(range.lo)) / kSteps) {
    if (!(step > 0)) step = 1;  // of a constant
  }

  void round(const float* from, std::int64_t count, std::int16_t* to) const {
    const auto middle = static_cast<float>(offset);
    const auto per_step = static_cast<float>(1 / step);
    for (std::int64_t i = 0; i < count; ++i) {
      const float n = std::clamp((from[i] - middle) * per_step, -32767.0F, 32767.0F);
      to[i] = static_cast<std::int16_t>(static_cast<std::int32_t>(n + 32768.5F) - 32768);
    }
  }
};

constexpr ValueRange kNoRange{std::numeric_limits<float>::max(),
                              std::numeric_limits<float>::lowest()};

ValueRange usual_range(const ValueRange& samples) {
  const float span = samples.hi - samples.lo;
  const auto margin = static_cast<float>(0.5 * (kUsualRange - 1)) * span;
  return {samples.lo - margin, samples.hi + margin};
}

class SlabFilter {
 public:
  SlabFilter(const ScalarSamples& samples, const Index3& dims, const PrefilterOptions& options)
      : samples_(samples),
        dims_(dims),
        options_(options),
        slice_(dims[0] * dims[1]),
        in_slices_(dims, options),
        along_z_(dims[2], options.kernel, options.reconstruction),
        window_(static_cast<std::size_t>(
            slice_ * std::min(dims[2], kSlab + along_z_.look_ahead() + along_z_.band()))) {}

  // The coefficients' own range; what lies outside the quantizer's is cut.
  ValueRange run(const Quantizer& quantizer, std::int16_t* out) {
    own_range_ = kNoRange;
    window_first_ = 0;
    std::int64_t known = 0;  // slices that are, or have been, in the window
    for (std::int64_t begin = 0; begin < dims_[2]; begin += kSlab) {
      const std::int64_t end = std::min(begin + kSlab, dims_[2]);
      const std::int64_t seen = std::min(end + along_z_.look_ahead(), dims_[2]);
      load(known, seen);
      finish({begin, end, known, seen}, quantizer, out);
      window_first_ = std::max<std::int64_t>(window_first_, end - along_z_.band());
      known = seen;
    }
    return own_range_;
  }

 private:
  struct Slab {
    std::int64_t begin, end;  // slices whose coefficients are next
    std::int64_t known;       // those before are eliminated
    std::int64_t seen;        // those before are loaded
  };

  float* slice(std::int64_t z) { return window_.data() + (z - window_first_) * slice_; }

  void load(std::int64_t begin, std::int64_t end) {
    const std::int64_t grain = std::max<std::int64_t>(kGrainSamples / slice_, 1);
    data::parallel_ranges({end - begin, grain, options_.threads, options_.stop},
                          [&](std::int64_t first, std::int64_t last) {
                            for (std::int64_t z = begin + first; z < begin + last; ++z) {
                              to_values(z, slice(z));
                              in_slices_.apply(slice(z));
                            }
                          });
  }

  void to_values(std::int64_t z, float* out) const {
    data::visit_scalar(samples_.type, [&]<class T>(std::type_identity<T>) {
      const std::byte* const bytes = samples_.bytes.view.data();
      for (std::int64_t i = 0; i < slice_; ++i) {
        const auto stored = static_cast<double>(data::load_scalar<T>(bytes, z * slice_ + i));
        out[i] = static_cast<float>(stored * samples_.value_scale + samples_.value_offset);
      }
    });
  }

  // The slab's coefficients, and the window moved on to the next.
  void finish(const Slab& slab, const Quantizer& quantizer, std::int16_t* out) {
    const std::int64_t batches = (slice_ + kLanesAlongZ - 1) / kLanesAlongZ;
    const std::int64_t grain =
        std::max<std::int64_t>(kGrainSamples / (kLanesAlongZ * (slab.seen - slab.begin)), 1);
    data::parallel_ranges(
        {batches, grain, options_.threads, options_.stop},
        [&](std::int64_t first, std::int64_t last) {
          std::vector<float> scratch(
              static_cast<std::size_t>((slab.seen - slab.begin) * kLanesAlongZ));
          ValueRange range = kNoRange;
          for (std::int64_t b = first; b < last; ++b)
            finish_lanes(slab, b * kLanesAlongZ, quantizer, scratch, out, range);
          const std::lock_guard lock(mutex_);
          own_range_ = {std::min(own_range_.lo, range.lo), std::max(own_range_.hi, range.hi)};
        });
  }

  void finish_lanes(const Slab& slab, std::int64_t lane, const Quantizer& quantizer,
                    std::vector<float>& scratch, std::int16_t* out, ValueRange& range) {
    const std::int64_t lanes = std::min(kLanesAlongZ, slice_ - lane);
    along_z_.eliminate({slice(window_first_) + lane, slice_, lanes, window_first_}, slab.known,
                       slab.seen);
    const Lines lines{scratch.data(), kLanesAlongZ, lanes, slab.begin};
    for (std::int64_t z = slab.begin; z < slab.seen; ++z)
      std::copy_n(slice(z) + lane, lanes, lines.sample(z));
    along_z_.substitute(lines, slab.begin, slab.seen);
    for (std::int64_t z = slab.begin; z < slab.end; ++z) {
      const float* const found = lines.sample(z);
      for (std::int64_t i = 0; i < lanes; ++i)
        range = {std::min(range.lo, found[i]), std::max(range.hi, found[i])};
      quantizer.round(found, lanes, out + z * slice_ + lane);
    }
    const std::int64_t next_first =
        std::max<std::int64_t>(window_first_, slab.end - along_z_.band());
    for (std::int64_t z = next_first; z < slab.seen; ++z)
      std::copy_n(slice(z) + lane, lanes, slice(z - next_first + window_first_) + lane);
  }

  const ScalarSamples& samples_;
  const Index3 dims_;
  const PrefilterOptions& options_;
  const std::int64_t slice_;
  const SliceFilter in_slices_;
  const LineSolver along_z_;
  std::vector<float> window_;
  std::int64_t window_first_ = 0;
  std::mutex mutex_;
  ValueRange own_range_;
};

}  // namespace

bool have_few_levels(const ScalarSamples& samples, const ValueRange& range) {
  constexpr float kLargest = 1e30F;
  if (samples.type == ScalarType::kFloat32 || range.is_empty()) return false;
  if (std::max(std::abs(range.lo), std::abs(range.hi)) > kLargest) return false;
  const double span = static_cast<double>(range.hi) - static_cast<double>(range.lo);
  return span <= kMostLevels * std::abs(samples.value_scale);
}

ScalarSamples make_coefficients(const ScalarSamples& samples, const Index3& dims,
                                const PrefilterOptions& options) {
  require_interpolating(options.kernel);
  const auto count = static_cast<std::size_t>(num_samples(dims));
  const auto memory = std::make_shared_for_overwrite<std::int16_t[]>(count);
  SlabFilter filter(samples, dims, options);
  ValueRange range = usual_range(options.range);
  const ValueRange own = filter.run(Quantizer(range), memory.get());
  if (own.lo < range.lo || own.hi > range.hi) {
    range = own;
    filter.run(Quantizer(range), memory.get());
  }
  const Quantizer quantizer(range);
  return {ScalarType::kInt16,
          {memory, std::as_bytes(std::span<const std::int16_t>(memory.get(), count))},
          nullptr,
          quantizer.step,
          quantizer.offset};
}

}  // namespace ovoid::model
