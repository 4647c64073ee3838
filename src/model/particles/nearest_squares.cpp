// SPDX-License-Identifier: Apache-2.0
#include "model/particles/nearest_squares.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "model/particles/nearest_squares.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace ovoid::model {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
inline constexpr D d;

inline std::size_t lanes() { return hn::Lanes(d); }

HWY_INLINE std::uint32_t bits_of(hn::Mask<D> mask) {
  alignas(8) std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
}

// Writes the squares of the distances to the candidates of all chunks that come nearer than the
// bound to `to`, which has a chunk's room left at its end; returns how many.
HWY_INLINE std::size_t squares_within(const CandidateBatch& batch, const NearestSquares::Site& site,
                                      float* to) {
  const V x = hn::Set(d, site.at[0]), y = hn::Set(d, site.at[1]), z = hn::Set(d, site.at[2]);
  const V bound = hn::Set(d, site.bound);
  const auto beyond = [&](int axis, std::size_t chunk, V at) {
    const V low = hn::Sub(hn::Load(d, batch.lows[axis] + chunk), at);
    const V high = hn::Sub(at, hn::Load(d, batch.highs[axis] + chunk));
    return hn::Max(hn::Max(low, high), hn::Zero(d));
  };
  const auto square = [](V dx, V dy, V dz) {
    return hn::MulAdd(dx, dx, hn::MulAdd(dy, dy, hn::Mul(dz, dz)));
  };
  float* const begin = to;
  for (std::size_t first = 0; first < batch.num_chunks(); first += lanes()) {
    const V from = square(beyond(0, first, x), beyond(1, first, y), beyond(2, first, z));
    std::uint32_t bits = bits_of(hn::Le(from, bound));
    const std::size_t rest = batch.num_chunks() - first;
    if (rest < lanes()) bits &= (1U << rest) - 1U;
    for (; bits != 0; bits &= bits - 1) {
      const std::size_t chunk = first + static_cast<std::size_t>(std::countr_zero(bits));
      const std::size_t at = chunk * CandidateBatch::kChunkRoom;
      for (std::size_t i = 0; i < CandidateBatch::kChunkRoom; i += lanes()) {
        hn::StoreU(square(hn::Sub(hn::Load(d, batch.places[0] + at + i), x),
                          hn::Sub(hn::Load(d, batch.places[1] + at + i), y),
                          hn::Sub(hn::Load(d, batch.places[2] + at + i), z)),
                   d, to + i);
      }
      to += batch.sizes[chunk];  // the next chunk overwrites the room that this one left
    }
  }
  return static_cast<std::size_t>(to - begin);
}

// How many of the numbers are at most `most`; behind them is a vector of kNoBound.
HWY_INLINE std::size_t count_within(const float* numbers, std::size_t count, float most) {
  const V limit = hn::Set(d, most);
  std::size_t within = 0;
  for (std::size_t i = 0; i < count; i += lanes())
    within += hn::CountTrue(d, hn::Le(hn::LoadU(d, numbers + i), limit));
  return within;
}

// (lo, hi]: an interval of squares, and how many numbers are at most as great as its ends.
struct Interval {
  float lo = -1.0F, hi = 0.0F;
  std::size_t below = 0, within = 0;
};

// Moves an end of the interval, which holds the k-th smallest, by counting; false if floats have
// nothing between them. In space, squares of distances grow by about the power 2/3 of their number.
HWY_INLINE bool narrow(const float* numbers, std::size_t count, std::size_t k, int step,
                       Interval& in) {
  const float share =
      (static_cast<float>(k - in.below) - 0.5F) / static_cast<float>(in.within - in.below);
  float at = in.lo + (in.hi - in.lo) * (step % 3 == 2 ? 0.5F : share);
  if (in.below == 0 && step < 2) at = in.hi * std::sqrt(share * std::sqrt(std::sqrt(share)));
  if (!(at > in.lo && at < in.hi)) at = 0.5F * (in.lo + in.hi);
  if (!(at > in.lo && at < in.hi)) return false;
  const std::size_t number = count_within(numbers, count, at);
  if (number >= k) {
    in.hi = at;
    in.within = number;
  } else {
    in.lo = at;
    in.below = number;
  }
  return true;
}

// Around the k-th smallest of the numbers, of which all, or at least k, are at most `bound`.
HWY_INLINE Interval whole(const float* numbers, std::size_t count, float bound) {
  if (bound < NearestSquares::kNoBound)
    return {-1.0F, bound, 0, count_within(numbers, count, bound)};
  V greatest = hn::Zero(d);
  const V none = hn::Set(d, NearestSquares::kNoBound);
  for (std::size_t i = 0; i < count; i += lanes()) {
    const V group = hn::LoadU(d, numbers + i);
    greatest = hn::Max(greatest, hn::IfThenZeroElse(hn::Ge(group, none), group));
  }
  return {-1.0F, hn::GetLane(hn::MaxOfLanes(d, greatest)), 0, count};
}

// The k-th smallest of the numbers, 1 <= k <= count.
HWY_INLINE float kth_of(const float* numbers, std::size_t count, std::size_t k, float bound) {
  Interval in = whole(numbers, count, bound);
  for (int step = 0; in.below + 1 < k && k < in.within; ++step) {
    if (!narrow(numbers, count, k, step, in)) return in.hi;
  }
  // The least or the greatest of those in the interval.
  const bool is_least = in.below + 1 == k;
  const V low = hn::Set(d, in.lo), high = hn::Set(d, in.hi);
  V least = high, greatest = hn::Set(d, 0.0F);
  for (std::size_t i = 0; i < count; i += lanes()) {
    const V group = hn::LoadU(d, numbers + i);
    const auto is_in = hn::And(hn::Gt(group, low), hn::Le(group, high));
    least = hn::Min(least, hn::IfThenElse(is_in, group, high));
    greatest = hn::Max(greatest, hn::IfThenElseZero(is_in, group));
  }
  return hn::GetLane(is_least ? hn::MinOfLanes(d, least) : hn::MaxOfLanes(d, greatest));
}

// Squares of the distances to those kept and to what the batch has within the bound, and a vector
// of kNoBound behind them.
HWY_INLINE std::size_t squares_with(const CandidateBatch& batch, const NearestSquares::Site& site,
                                    float* squares) {
  std::copy_n(site.kept, site.count, squares);
  const std::size_t count = site.count + squares_within(batch, site, squares + site.count);
  hn::StoreU(hn::Set(d, NearestSquares::kNoBound), d, squares + count);
  return count;
}

// A bound that is not far above the k-th's square.
HWY_INLINE std::size_t estimate_bound(const CandidateBatch& batch, std::size_t k,
                                      NearestSquares::Site& site, float* squares) {
  const std::size_t count = squares_with(batch, site, squares);
  if (count < k) return count;
  Interval in = whole(squares, count, site.bound);
  for (int step = 0; in.within > k + k / 4; ++step) {
    if (!narrow(squares, count, k, step, in)) break;
  }
  site.bound = in.hi;
  return count;
}

HWY_INLINE std::size_t find_bound(const CandidateBatch& batch, std::size_t k,
                                  NearestSquares::Site& site, float* squares) {
  const std::size_t count = squares_with(batch, site, squares);
  const std::size_t compared = count - site.count;
  if (count >= k && compared > 0) site.bound = kth_of(squares, count, k, site.bound);
  return compared;
}

// As find_bound(), and keeps the k smallest for batches to come.
HWY_INLINE std::size_t find_and_keep(const CandidateBatch& batch, std::size_t k,
                                     NearestSquares::Site& site, float* squares) {
  const std::size_t compared = find_bound(batch, k, site, squares);
  const std::size_t count = site.count + compared;
  if (count < k) {
    std::copy_n(squares, count, site.kept);
    site.count = count;
    return compared;
  }
  float* to = site.kept;
  for (std::size_t i = 0; i < count; ++i) {
    if (squares[i] < site.bound) *to++ = squares[i];
  }
  std::fill(to, site.kept + k, site.bound);  // the rest of the k are as great
  site.count = k;
  return compared;
}

// Returns how many candidates were compared with the site. `squares`: room for k, all candidates of
// a batch and a chunk.
std::size_t add_batch(const CandidateBatch& batch, NearestSquares::Wanted wanted, std::size_t k,
                      NearestSquares::Site& site, float* squares) {
  switch (wanted) {
    case NearestSquares::Wanted::kEstimate:
      return estimate_bound(batch, k, site, squares);
    case NearestSquares::Wanted::kMoreToCome:
      return find_and_keep(batch, k, site, squares);
    case NearestSquares::Wanted::kLast:
      break;
  }
  return find_bound(batch, k, site, squares);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::model
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovoid::model {

HWY_EXPORT(add_batch);

void NearestSquares::add_site(float x, float y, float z) {
  const std::size_t site = num_sites_++;
  if (places_.size() < num_sites_) {
    places_.resize(num_sites_);
    bounds_.resize(num_sites_);
    counts_.resize(num_sites_);
    kept_.resize(num_sites_ * k_);
  }
  places_[site] = {x, y, z};
  bounds_[site] = kNoBound;
  counts_[site] = 0;
}

float NearestSquares::widest_bound() const noexcept {
  return *std::max_element(bounds_.begin(),
                           bounds_.begin() + static_cast<std::ptrdiff_t>(num_sites_));
}

std::int64_t NearestSquares::add(const simd::SimdTarget& target, const CandidateBatch& batch,
                                 Wanted wanted) {
  constexpr std::size_t kRoom = (CandidateBatch::kMostChunks + 1) * CandidateBatch::kChunkRoom;
  squares_.resize(k_ + kRoom);
  const auto add_to_site = target.choose(HWY_DISPATCH_TABLE(add_batch));
  std::size_t num_pairs = 0;
  for (std::size_t i = 0; i < num_sites_; ++i) {
    Site site{{places_[i][0], places_[i][1], places_[i][2]},
              bounds_[i],
              counts_[i],
              kept_.data() + i * k_};
    num_pairs += add_to_site(batch, wanted, k_, site, squares_.data());
    bounds_[i] = site.bound;
    counts_[i] = site.count;
  }
  return static_cast<std::int64_t>(num_pairs);
}

}  // namespace ovoid::model
#endif
