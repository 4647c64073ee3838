// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ovoid/renderer.h"
#include "render/cpu/runner.h"
#include "render/cpu/simd_target.h"
#include "view/trail_view.h"

namespace ovoid::cpu {

// What the cpu back end draws with.
struct Machine {
  std::unique_ptr<Runner> runner = make_runner(0);
  SimdTarget target{};
};

// The cpu back end: tiles as tasks on a runner, SIMD within. Arguments have been validated.
// `trail`: none if null.
Frame render(const LatticeField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, const RenderHooks& hooks, const Machine& machine,
             const view::TrailView* trail = nullptr);

// The same of a kernel field; gradients are central differences. Memory: 64 bytes per kernel that
// can be seen, and 4 per block that it reaches.
Frame render(const KernelField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, const RenderHooks& hooks, const Machine& machine);

}  // namespace ovoid::cpu
