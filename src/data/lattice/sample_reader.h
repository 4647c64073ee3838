// SPDX-License-Identifier: Apache-2.0
// Single samples of a lattice, and places spread over it.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "data/scalar_visit.h"
#include "ovoid/field.h"

namespace ovoid::data {

// Reads single samples, and keeps the brick that it read last.
class SampleReader {
 public:
  explicit SampleReader(const BrickSource& source)
      : source_(source),
        dims_(source.geometry().dims),
        edge_(source.brick_edge()),
        scale_(source.value_scale()),
        offset_(source.value_offset()) {}

  // NaN if it is missing or lies outside.
  float at(const Index3& index) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (index[a] < 0 || index[a] >= dims_[a]) return std::numeric_limits<float>::quiet_NaN();
    }
    for (std::size_t a = 0; a < 3; ++a) {
      if (index[a] >= view_.lo[a] && index[a] < view_.hi[a]) continue;
      view_ = source_.acquire(index[0] / edge_, index[1] / edge_,
                              index[2] / (edge_ * source_.geometry().num_sublattices()), 0.0);
      break;
    }
    const std::int64_t position = (index[0] - view_.lo[0]) +
                                  (index[1] - view_.lo[1]) * view_.stride_y +
                                  (index[2] - view_.lo[2]) * view_.stride_z;
    return visit_scalar(view_.type, [&]<class T>(std::type_identity<T>) {
      const auto stored =
          static_cast<double>(load_scalar<T>(static_cast<const std::byte*>(view_.data), position));
      const auto value = static_cast<float>(stored * scale_ + offset_);
      return std::isfinite(value) ? value : std::numeric_limits<float>::quiet_NaN();
    });
  }

  // What was acquired for the sample read last: others in it cost little.
  const BrickView& view() const { return view_; }

  // Of the samples read last.
  bool is_counted() const {
    return view_.data != nullptr && view_.type != ScalarType::kFloat32 &&
           view_.type != ScalarType::kFloat64;
  }

 private:
  const BrickSource& source_;
  const Index3 dims_;
  const std::int64_t edge_;
  const double scale_;
  const double offset_;
  BrickView view_;  // of nothing: lo == hi
};

inline constexpr int kGreatestLabel = (1 << 24) - 1;  // float tells all whole numbers up to here

inline bool is_label(float value) {
  return value >= 0 && value <= kGreatestLabel && value == std::floor(value);
}

// Numbers that look random and are the same everywhere (a finalizer of splitmix64's kind).
inline std::uint64_t scrambled(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

// Calls visit(index) for about one in `every` places of the box [lo, hi), in order.
template <class Visit>
void visit_some(const Index3& lo, const Index3& hi, std::int64_t every, const Visit& visit) {
  // What a row's end leaves over is carried into the next, behind a scrambled start: no pattern in
  // the data can meet one in the places.
  const std::int64_t width = hi[0] - lo[0];
  Index3 index{};
  for (index[2] = lo[2]; index[2] < hi[2]; ++index[2]) {
    for (index[1] = lo[1]; index[1] < hi[1]; ++index[1]) {
      const auto row = static_cast<std::uint64_t>(index[2] * 0x1000003 + index[1]);
      auto x = static_cast<std::int64_t>(scrambled(row) % static_cast<std::uint64_t>(every));
      for (; x < width; x += every) {
        index[0] = lo[0] + x;
        visit(index);
      }
    }
  }
}

}  // namespace ovoid::data
