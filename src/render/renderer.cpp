// SPDX-License-Identifier: Apache-2.0
#include "ovoid/renderer.h"

#include <fmt/format.h>

#include "ovoid/error.h"
#include "render/cpu/cpu_renderer.h"
#include "render/cpu/tile.h"
#include "render/reference/reference_renderer.h"

namespace ovoid {
namespace {

// Bilinear spread is a weighted mean of a lattice's samples. Throws Error(kUnsupported).
void require_spread(const Field& field, const RenderOptions& options) {
  if (options.spread == Spread::kGaussian) return;
  if (field.kernels() != nullptr)
    throw Error(ErrorCode::kUnsupported, "spread: bilinear is for lattices");
  if (field.lattice()->reconstruction() == Reconstruction::kSum)
    throw Error(ErrorCode::kUnsupported, "spread: bilinear is for normalized lattices, not sums");
}

}  // namespace

struct Renderer::Impl {
  Backend backend;
  std::unique_ptr<cpu::Runner> runner;
};

Renderer::Renderer(Backend backend, int threads) : impl_(std::make_unique<Impl>()) {
  if (threads < 0) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("threads = {}: must be >= 1, or 0 for one per hardware thread", threads));
  }
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
  const bool is_reference = impl_->backend == Backend::kReference;
  require_spread(field, options);
  if (const KernelField* kernels = field.kernels()) {
    if (is_reference)
      return reference::render(*kernels, camera, look, options, hooks,
                               impl_->runner->num_workers());
    return cpu::render(*kernels, camera, look, options, hooks, *impl_->runner);
  }
  return is_reference ? reference::render(*field.lattice(), camera, look, options, hooks,
                                          impl_->runner->num_workers())
                      : cpu::render(*field.lattice(), camera, look, options, hooks, *impl_->runner);
}

std::vector<std::string> simd_targets() { return cpu::usable_simd_targets(); }

}  // namespace ovoid
