// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/back_end.h"

namespace ovoid::reference {

// One picture of a lattice field by the letter of docs/numerics.md: double precision, every sample
// of every ray from every kernel in reach; no tiles, no skipping, no tables. It is what every other
// back end is held to, and shares no code with them. `threads` 0: one per hardware thread; the
// bytes do not depend on it. Hooks are called as Renderer::render() says, a row being a tile. The
// published ways of RenderOptions::post_convolution are drawn by the letter, too; kAuto is kOff
// here. RenderOptions::evaluate, skip_irrelevant and stop_opaque mean nothing here. Throws Error as
// Renderer::render() does. Cost: about half a microsecond per sample of Slab::kMid and a hundred
// times that for Slab::kMean, 36 to 300 times as much where there are nodes; 9 bytes per kernel.
Frame render(const FrameJob& job, int threads = 0);

// The same of a field alone.
Frame render(const LatticeField& field, const Camera& camera, const Look& look,
             const RenderOptions& options = {}, const RenderHooks& hooks = {}, int threads = 0);

// The same of a kernel field; RenderOptions::evaluate means nothing here. Cost: some 20 ns per
// kernel and sample that it reaches, and the kernels once per eight rows.
Frame render(const KernelField& field, const Camera& camera, const Look& look,
             const RenderOptions& options = {}, const RenderHooks& hooks = {}, int threads = 0,
             const view::LightVolume* light = nullptr);

}  // namespace ovoid::reference
