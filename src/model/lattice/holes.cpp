// SPDX-License-Identifier: Apache-2.0
#include "model/lattice/holes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include "ovoid/error.h"

namespace ovoid::model {

namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr float kQueued = std::numeric_limits<float>::infinity();  // unknown, and in the rim

// Calls visit(index) for the up to six neighbours of a sample, in a fixed order.
template <class Visit>
void for_neighbours(std::int64_t index, const Index3& dims, const Visit& visit) {
  const std::int64_t strides[3] = {1, dims[0], dims[0] * dims[1]};
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t position = index / strides[axis] % dims[axis];
    if (position > 0) visit(index - strides[axis]);
    if (position + 1 < dims[axis]) visit(index + strides[axis]);
  }
}

class HoleFiller {
 public:
  HoleFiller(std::span<float> samples, const Index3& dims) : samples_(samples), dims_(dims) {}

  void fill(const std::vector<bool>& missing, const std::stop_token& stop) {
    std::vector<std::int64_t> rim = first_rim(missing);
    while (!rim.empty()) {
      if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "cancelled");
      fill_rim(rim);
      rim = next_rim(rim);
    }
  }

 private:
  std::vector<std::int64_t> first_rim(const std::vector<bool>& missing) {
    std::vector<std::int64_t> rim;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (!missing[i]) continue;
      const auto index = static_cast<std::int64_t>(i);
      bool is_rim = false;
      for_neighbours(index, dims_, [&](std::int64_t n) { is_rim |= std::isfinite(samples_[n]); });
      if (!is_rim) continue;
      samples_[i] = kQueued;
      rim.push_back(index);
    }
    return rim;
  }

  // All means are taken before any is stored, so that the order within the rim does not matter.
  void fill_rim(const std::vector<std::int64_t>& rim) {
    std::vector<float> means(rim.size());
    std::transform(rim.begin(), rim.end(), means.begin(), [&](std::int64_t index) {
      double sum = 0;
      int count = 0;
      for_neighbours(index, dims_, [&](std::int64_t n) {
        if (!std::isfinite(samples_[n])) return;
        sum += samples_[n];
        ++count;
      });
      return static_cast<float>(sum / count);
    });
    for (std::size_t i = 0; i < rim.size(); ++i) samples_[rim[i]] = means[i];
  }

  std::vector<std::int64_t> next_rim(const std::vector<std::int64_t>& rim) {
    std::vector<std::int64_t> next;
    for (const std::int64_t index : rim) {
      for_neighbours(index, dims_, [&](std::int64_t n) {
        if (!std::isnan(samples_[n])) return;
        samples_[n] = kQueued;
        next.push_back(n);
      });
    }
    return next;
  }

  std::span<float> samples_;
  Index3 dims_;
};

}  // namespace

std::vector<bool> fill_missing(std::span<float> samples, const Index3& dims, std::stop_token stop) {
  const auto exists = [](float value) { return std::isfinite(value); };
  if (std::all_of(samples.begin(), samples.end(), exists)) return {};
  std::vector<bool> missing(samples.size());
  std::transform(samples.begin(), samples.end(), missing.begin(), std::not_fn(exists));
  restore_missing(samples, missing);  // infinities become NaN: infinity marks the rim
  HoleFiller(samples, dims).fill(missing, stop);
  return missing;
}

void restore_missing(std::span<float> samples, const std::vector<bool>& missing) {
  for (std::size_t i = 0; i < missing.size(); ++i) {
    if (missing[i]) samples[i] = kUnknown;
  }
}

}  // namespace ovoid::model
