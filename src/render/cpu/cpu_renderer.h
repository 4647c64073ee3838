// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/renderer.h"
#include "render/cpu/runner.h"

namespace ovoid::cpu {

// The cpu back end: tiles as tasks on a runner, SIMD within. Arguments have been validated.
Frame render(const LatticeField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, const RenderHooks& hooks, Runner& runner);

}  // namespace ovoid::cpu
