// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

#include "render/cpu/lattice/block.h"

namespace ovoid::cpu {

// The cheapest clock there is: about 20 cycles on x86, so that stages of a few hundred samples can
// be told apart.
inline std::uint64_t read_ticks() noexcept {
#if defined(__x86_64__)
  return __rdtsc();
#else
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

// Adds the time since the last lap to a stage. Does nothing unless switched on.
class StageClock {
 public:
  StageClock(std::array<std::uint64_t, kNumStages>& totals, bool is_on)
      : totals_(totals), is_on_(is_on), last_(is_on ? read_ticks() : 0) {}
  void lap(StageIndex stage) noexcept {
    if (!is_on_) return;
    const std::uint64_t now = read_ticks();
    totals_[stage] += now - last_;
    last_ = now;
  }

 private:
  std::array<std::uint64_t, kNumStages>& totals_;
  bool is_on_;
  std::uint64_t last_;
};

}  // namespace ovoid::cpu
