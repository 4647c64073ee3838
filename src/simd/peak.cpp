// SPDX-License-Identifier: Apache-2.0
#include "simd/peak.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/peak.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovoid::simd {
namespace HWY_NAMESPACE {

// Chains that do not wait for each other: more than hide a latency of five cycles at two
// multiply-adds a cycle. With a factor below 1 they converge: no overflow, no denormals. Returns
// the multiply-adds done; `out` keeps the result from being left out.
inline double run_chains(long steps, float* out) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<float, 16> d;
  const auto factor = hn::Set(d, 0.999F);
  const auto term = hn::Set(d, 0.001F);
  // No two alike, nor known beforehand, lest one is worked out for all.
  const auto begin = [&](int chain) {
    return hn::Set(d, *out + 1.0F + 0.01F * static_cast<float>(chain));
  };
  auto a = begin(0), b = begin(1), c = begin(2), e = begin(3), f = begin(4);
  auto g = begin(5), h = begin(6), i = begin(7), j = begin(8), k = begin(9);
  for (long step = 0; step < steps; ++step) {
    a = hn::MulAdd(a, factor, term);
    b = hn::MulAdd(b, factor, term);
    c = hn::MulAdd(c, factor, term);
    e = hn::MulAdd(e, factor, term);
    f = hn::MulAdd(f, factor, term);
    g = hn::MulAdd(g, factor, term);
    h = hn::MulAdd(h, factor, term);
    i = hn::MulAdd(i, factor, term);
    j = hn::MulAdd(j, factor, term);
    k = hn::MulAdd(k, factor, term);
  }
  const auto ab = hn::Add(hn::Add(a, b), hn::Add(c, e));
  const auto fi = hn::Add(hn::Add(f, g), hn::Add(h, i));
  *out = hn::GetLane(hn::Add(hn::Add(ab, fi), hn::Add(j, k)));
  constexpr double kChains = 10;
  return kChains * static_cast<double>(steps) * static_cast<double>(hn::Lanes(d));
}

// The sum of `count` floats, a multiple of 64, in four chains: memory is what they wait for.
inline float sum_of(const float* from, std::size_t count) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<float, 16> d;
  const std::size_t lanes = hn::Lanes(d);
  auto a = hn::Zero(d), b = hn::Zero(d), c = hn::Zero(d), e = hn::Zero(d);
  for (std::size_t i = 0; i < count; i += 4 * lanes) {
    a = hn::Add(a, hn::LoadU(d, from + i));
    b = hn::Add(b, hn::LoadU(d, from + i + lanes));
    c = hn::Add(c, hn::LoadU(d, from + i + 2 * lanes));
    e = hn::Add(e, hn::LoadU(d, from + i + 3 * lanes));
  }
  return hn::GetLane(hn::SumOfLanes(d, hn::Add(hn::Add(a, b), hn::Add(c, e))));
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <chrono>
#include <memory>
#include <new>

namespace ovoid::simd {

HWY_EXPORT(run_chains);
HWY_EXPORT(sum_of);

double multiply_add_peak(const SimdTarget& target) {
  using Clock = std::chrono::steady_clock;
  const auto run = target.choose(HWY_DISPATCH_TABLE(run_chains));
  constexpr long kSteps = 40'000;
  float result = 0;
  double best = 0;
  for (int round = 0; round < 12; ++round) {
    const Clock::time_point start = Clock::now();
    const double done = run(kSteps, &result);
    best = std::max(best, done / std::chrono::duration<double>(Clock::now() - start).count());
  }
  return result > 0 ? best : 0;
}

double bandwidth_peak(const SimdTarget& target) {
  using Clock = std::chrono::steady_clock;
  constexpr std::size_t kFloats = std::size_t{1} << 20U;
  constexpr std::size_t kLine = 64 / sizeof(float);
  const std::unique_ptr<float[]> memory(new (std::nothrow) float[kFloats]);
  if (memory == nullptr) return 0;
  std::fill_n(memory.get(), kFloats, 1.0F);
  const auto run = target.choose(HWY_DISPATCH_TABLE(sum_of));
  float result = 0;
  double best = 0;
  for (int round = 0; round < 12; ++round) {
    for (std::size_t i = 0; i < kFloats; i += kLine) hwy::FlushCacheline(memory.get() + i);
    const Clock::time_point start = Clock::now();
    result += run(memory.get(), kFloats);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    best = std::max(best, static_cast<double>(kFloats * sizeof(float)) / seconds);
  }
  return result > 0 ? best : 0;
}

}  // namespace ovoid::simd
#endif
