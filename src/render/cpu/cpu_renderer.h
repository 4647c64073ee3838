// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "render/back_end.h"
#include "render/cpu/runner.h"
#include "simd/peak.h"
#include "simd/simd_target.h"

namespace ovoid::cpu {

// What the cpu back end draws with.
struct Machine {
  std::unique_ptr<Runner> runner = make_runner(0);
  simd::SimdTarget target{};

  // Measured when they are first asked for.
  double multiply_add_peak() const {
    if (multiply_add_peak_ == 0) multiply_add_peak_ = simd::multiply_add_peak(target);
    return multiply_add_peak_;
  }
  double bandwidth_peak() const {
    if (bandwidth_peak_ == 0) bandwidth_peak_ = simd::bandwidth_peak(target);
    return bandwidth_peak_;
  }
  mutable double multiply_add_peak_ = 0;
  mutable double bandwidth_peak_ = 0;
};

// The cpu back end: tiles as tasks on a runner, SIMD within. Of a kernel field gradients are
// central differences. Memory of that: 64 bytes per kernel that can be seen, and 4 per block that
// it reaches.
Frame render(const FrameJob& job, const Machine& machine);

}  // namespace ovoid::cpu
