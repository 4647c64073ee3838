// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/renderer.h"
#include "render/cpu/runner.h"
#include "view/trail_view.h"

namespace ovoid::cpu {

// The cpu back end: tiles as tasks on a runner, SIMD within. Arguments have been validated.
// `trail`: none if null.
Frame render(const LatticeField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, const RenderHooks& hooks, Runner& runner,
             const view::TrailView* trail = nullptr);

// The same of a kernel field; gradients are central differences. Memory: 64 bytes per kernel that
// can be seen, and 4 per block that it reaches.
Frame render(const KernelField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, const RenderHooks& hooks, Runner& runner);

}  // namespace ovoid::cpu
