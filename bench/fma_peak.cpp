// SPDX-License-Identifier: Apache-2.0
// The machine's peak of single-precision fused multiply-adds: what the reconstruct stage is held
// against. Every thread runs independent chains of FMAs on registers alone, with the best SIMD
// target there is. Prints JSON, lane FMAs per second.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/fma_peak.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovoid_bench {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Ten chains hide a latency of five cycles at two FMAs a cycle. With a factor below 1 they
// converge: no overflow, no denormals.
HWY_ATTR float run_chains(int64_t steps) {
  const hn::ScalableTag<float> d;
  const auto factor = hn::Set(d, 0.999F);
  const auto term = hn::Set(d, 0.001F);
  auto a = hn::Set(d, 1.0F), b = a, c = a, e = a, f = a, g = a, h = a, i = a, j = a, k = a;
  for (int64_t step = 0; step < steps; ++step) {
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
  const auto sum = a + b + c + e + f + g + h + i + j + k;
  return hn::GetLane(sum);
}

HWY_ATTR int64_t num_lanes() { return static_cast<int64_t>(hn::Lanes(hn::ScalableTag<float>())); }

}  // namespace HWY_NAMESPACE
}  // namespace ovoid_bench
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

namespace ovoid_bench {
HWY_EXPORT(run_chains);
HWY_EXPORT(num_lanes);

constexpr int64_t kSteps = 20'000'000;
constexpr int64_t kChains = 10;

// Best of five: the peak is what the machine can do, not what it did while something else ran.
double measure(int num_threads) {
  double best = 0;
  for (int round = 0; round < 5; ++round) {
    std::vector<float> sinks(static_cast<size_t>(num_threads));
    const auto start = std::chrono::steady_clock::now();
    {
      std::vector<std::jthread> threads;
      for (float& sink : sinks) {
        threads.emplace_back([&sink] { sink = HWY_DYNAMIC_DISPATCH(run_chains)(kSteps); });
      }
    }
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    for (const float sink : sinks) {
      if (!(sink > 0)) std::abort();  // keeps the chains alive
    }
    const auto lanes = static_cast<double>(HWY_DYNAMIC_DISPATCH(num_lanes)());
    best = std::max(best,
                    static_cast<double>(kSteps * kChains * num_threads) * lanes / elapsed.count());
  }
  return best;
}

}  // namespace ovoid_bench

int main() {
  const int num_threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  nlohmann::json result;
  for (int threads = 1; threads <= num_threads; threads *= 2) {
    result["fma_per_second"][std::to_string(threads)] = ovoid_bench::measure(threads);
  }
  result["target"] = hwy::TargetName(hwy::SupportedTargets() & -hwy::SupportedTargets());
  result["lanes"] = HWY_DYNAMIC_DISPATCH(ovoid_bench::num_lanes)();
  std::cout << result.dump(1) << '\n';
}
#endif  // HWY_ONCE
