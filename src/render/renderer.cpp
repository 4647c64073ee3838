// SPDX-License-Identifier: Apache-2.0
#include "ovoid/renderer.h"

#include "render/field_renderer.h"
#include "render/passes/scene_frame.h"

namespace ovoid {

struct __attribute__((visibility("hidden"))) Renderer::Impl {
  explicit Impl(const RendererSetup& setup) : fields(setup) {}
  FieldRenderer fields;
};

Renderer::Renderer(const RendererSetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

int Renderer::threads() const noexcept { return impl_->fields.threads(); }

Frame Renderer::render(const Scene& scene, const Camera& camera, const RenderOptions& options,
                       const RenderHooks& hooks) {
  return draw_scene(impl_->fields, scene, camera, options, hooks);
}

std::vector<std::string> simd_targets() { return simd::SimdTarget::usable(); }

}  // namespace ovoid
