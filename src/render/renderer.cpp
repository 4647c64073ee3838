// SPDX-License-Identifier: Apache-2.0
#include "ovoid/renderer.h"

#include <fmt/format.h>

#include <cmath>

#include "ovoid/error.h"
#include "render/cpu/cpu_renderer.h"
#include "render/cpu/tile.h"
#include "render/reference/reference_renderer.h"

namespace ovoid {
namespace {

void require(bool holds, const std::string& message) {
  if (!holds) throw Error(ErrorCode::kInvalidArgument, message);
}

}  // namespace

void RenderOptions::validate() const {
  for (const auto& [name, side] : {std::pair{"width", width}, std::pair{"height", height}}) {
    require(side >= 1 && side <= kMaxImageSide,
            fmt::format("{} = {}: must be 1 to {}", name, side, kMaxImageSide));
  }
  require(std::isfinite(sampling_distance) && sampling_distance >= 0,
          fmt::format("sampling_distance = {}: must be > 0, or 0 for the field's own",
                      sampling_distance));
  require(clip_planes.size() <= kMaxClipPlanes,
          fmt::format("clip_planes: {} given, at most {} are possible", clip_planes.size(),
                      kMaxClipPlanes));
  for (std::size_t i = 0; i < clip_planes.size(); ++i) {
    const ClipPlane& plane = clip_planes[i];
    require(plane.normal.allFinite() && plane.normal.norm() > 0,
            fmt::format("clip_planes[{}].normal: must be finite and not zero", i));
    require(std::isfinite(plane.offset), fmt::format("clip_planes[{}].offset: must be finite", i));
  }
}

struct Renderer::Impl {
  Backend backend;
  std::unique_ptr<cpu::Runner> runner;
};

Renderer::Renderer(Backend backend, int threads) : impl_(std::make_unique<Impl>()) {
  require(threads >= 0,
          fmt::format("threads = {}: must be >= 1, or 0 for one per hardware thread", threads));
  impl_->backend = backend == Backend::kAuto ? Backend::kCpu : backend;
  impl_->runner = cpu::make_runner(threads);
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Frame Renderer::render(const Field& field, const Camera& camera, const Look& look,
                       const RenderOptions& options, const RenderHooks& hooks) {
  camera.validate();
  look.validate();
  options.validate();
  if (impl_->backend == Backend::kReference) {
    return reference::render(field, camera, look, options, hooks, impl_->runner->num_workers());
  }
  return cpu::render(field, camera, look, options, hooks, *impl_->runner);
}

std::vector<std::string> simd_targets() { return cpu::usable_simd_targets(); }

}  // namespace ovoid
