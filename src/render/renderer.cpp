// SPDX-License-Identifier: Apache-2.0
#include "ovoid/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "data/validate.h"
#include "ovoid/error.h"
#include "render/cpu/cpu_renderer.h"
#include "render/reference/reference_renderer.h"
#include "view/behind.h"
#ifdef OVOID_VULKAN
#include "render/vulkan/vulkan_renderer.h"
#endif

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

// Throws Error(kUnsupported).
void require_central_differences(const RenderOptions& options) {
  if (options.gradient == GradientMethod::kAuto || options.gradient == GradientMethod::kCentral)
    return;
  throw Error(
      ErrorCode::kUnsupported,
      "gradient: kernel sets take central differences; exact and corrected are for lattices");
}

// Throws Error unless the trail can be drawn with the field.
void require_trail(const Field& field, const Look& look, const Trail& trail,
                   const RenderOptions& options) {
  if (field.lattice() == nullptr)
    throw Error(ErrorCode::kUnsupported, "trail: is for lattices, the field is a set of kernels");
  if (look.mode != Mode::kComposite && look.mode != Mode::kIsosurface)
    throw Error(ErrorCode::kUnsupported, "trail: is for the modes composite and isosurface");
  if (is_published(options.post_convolution))
    throw Error(ErrorCode::kUnsupported, "trail: is for post-convolution off and auto");
  const LatticeGeometry& own = field.lattice()->geometry();
  if (trail.field.is_empty() || trail.field.geometry().kind != own.kind ||
      trail.field.geometry().dims != own.dims ||
      trail.field.geometry().world_from_index.matrix() != own.world_from_index.matrix())
    throw Error(ErrorCode::kInvalidArgument, "trail.field: must be on the lattice of the field");
}

view::Behind behind_of(const Trail& trail, const Look& look) {
  view::Behind behind{&trail.field, {}};
  behind.look.transfer_function = trail.transfer_function;
  behind.look.transfer_function.gradient_opacities.clear();
  behind.look.shade = false;
  behind.look.unit_distance = look.unit_distance;
  return behind;
}

#ifdef OVOID_VULKAN
bool draws_on_device(const RendererSetup& setup) { return vulkan::has_device_for_auto(setup); }
#else
constexpr const char* kWithoutVulkan =
    "backend vulkan: this program was built without it; backend cpu is there";
bool draws_on_device(const RendererSetup& /*setup*/) { return false; }
#endif

// Of a back end that runs on none.
[[noreturn]] void refuse_device(const RendererSetup& setup) {
  throw Error(
      ErrorCode::kInvalidArgument,
      setup.backend == Backend::kAuto
          ? fmt::format("device = {}: there is none that backend auto would take: leave it "
                        "out to draw on the cpu, or name backend vulkan to hear why",
                        setup.device)
          : fmt::format("device = {}: is for backend vulkan, not {}: leave one of them out",
                        setup.device, setup.backend == Backend::kCpu ? "cpu" : "reference"));
}

// What render() was called with.
struct Job {
  const Field& field;
  const Camera& camera;
  const Look& look;
  const Trail* trail;
  const RenderOptions& options;
  const RenderHooks& hooks;
};

void add_notice(FrameProfile& profile, const std::string& notice) {
  if (!profile.notice.empty()) profile.notice += "; ";
  profile.notice += notice;
}

// Where half sheets are asked for and nothing is kept that could be halved.
void note_on_precision(FrameProfile& profile, const Job& job) {
  if (job.options.sheet_precision == SheetPrecision::kSingle) return;
  if (profile.backend != "vulkan") {
    add_notice(profile, fmt::format("sheet precision: floats; backend {} has no half sheets",
                                    profile.backend));
  } else if (job.field.lattice() != nullptr) {
    add_notice(profile, "sheet precision: floats; of lattices no sheets are kept");
  }
}

}  // namespace

struct __attribute__((visibility("hidden"))) Renderer::Impl {
  Frame draw(const Job& job) const;
  Frame draw_by_choice(const Job& job) const;
  Frame draw_by(Backend by, const Job& job) const;
  // With a notice where there were fewer threads than wanted.
  static Frame told(Frame frame, int wanted);

  Backend backend;
  bool is_auto = false;
  cpu::Machine machine;
#ifdef OVOID_VULKAN
  std::unique_ptr<vulkan::VulkanRenderer> vulkan;
#endif
};

Renderer::Renderer(const RendererSetup& setup) : impl_(std::make_unique<Impl>()) {
  if (setup.threads < 0) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("threads = {}: must be >= 1, or 0 for one per hardware thread", setup.threads));
  }
  if (setup.device < -1) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("device = {}: must be >= 0, or -1 for the first", setup.device));
  }
  impl_->machine = {cpu::make_runner(setup.threads), cpu::SimdTarget(setup.simd_target)};
  impl_->backend = setup.backend;
  impl_->is_auto = setup.backend == Backend::kAuto;
  if (impl_->is_auto) impl_->backend = draws_on_device(setup) ? Backend::kVulkan : Backend::kCpu;
  if (setup.device >= 0 && impl_->backend != Backend::kVulkan) refuse_device(setup);
  if (impl_->backend == Backend::kVulkan) {
#ifdef OVOID_VULKAN
    impl_->vulkan = std::make_unique<vulkan::VulkanRenderer>(setup);
#else
    throw Error(ErrorCode::kUnsupported, kWithoutVulkan);
#endif
  }
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Frame Renderer::render(const Field& field, const Camera& camera, const Look& look,
                       const RenderOptions& options, const RenderHooks& hooks) {
  return impl_->draw({field, camera, look, nullptr, options, hooks});
}

Frame Renderer::render(const Field& field, const Camera& camera, const Look& look,
                       const Trail& trail, const RenderOptions& options, const RenderHooks& hooks) {
  return impl_->draw({field, camera, look, &trail, options, hooks});
}

Frame Renderer::Impl::draw(const Job& job) const try {
  data::require_field(job.field);
  job.camera.validate();
  job.look.validate();
  job.options.validate();
  Frame frame = draw_by_choice(job);
  note_on_precision(frame.profile, job);
  return frame;
} catch (const std::bad_alloc&) {
  // What is large names itself.
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("a frame of {} x {} pixels: no memory for its plan", job.options.width,
                          job.options.height));
}

Frame Renderer::Impl::draw_by_choice(const Job& job) const {
  if (!is_auto || backend != Backend::kVulkan) return draw_by(backend, job);
  try {
    return draw_by(Backend::kVulkan, job);
  } catch (const Error& error) {
    const bool is_of_device = error.code() == ErrorCode::kOutOfMemory ||
                              error.code() == ErrorCode::kDeviceLost ||
                              error.code() == ErrorCode::kUnsupported;
    if (!is_of_device) throw;
    // What the cpu cannot do either, it refuses likewise.
    Frame frame = draw_by(Backend::kCpu, job);
    add_notice(frame.profile, fmt::format("{}; drawn by backend cpu", error.what()));
    return frame;
  }
}

Frame Renderer::Impl::draw_by(Backend by, const Job& job) const {
  const auto& [field, camera, look, trail, options, hooks] = job;
  const int wanted = machine.runner->num_wanted();
  const int num_rows_at_once = std::min(wanted, options.height);  // of the reference
  require_spread(field, options);
  if (trail != nullptr) require_trail(field, look, *trail, options);
  if (const KernelField* kernels = field.kernels()) {
    require_central_differences(options);
#ifdef OVOID_VULKAN
    if (by == Backend::kVulkan) return vulkan->render(*kernels, camera, look, options, hooks);
#endif
    if (by == Backend::kReference)
      return told(reference::render(*kernels, camera, look, options, hooks, num_rows_at_once),
                  num_rows_at_once);
    return told(cpu::render(*kernels, camera, look, options, hooks, machine), wanted);
  }
  std::optional<view::Behind> behind;
  if (trail != nullptr) {
    behind = behind_of(*trail, look);
    behind->look.validate();
  }
  const view::Behind* const second = behind ? &*behind : nullptr;
  const LatticeField& lattice = *field.lattice();
#ifdef OVOID_VULKAN
  if (by == Backend::kVulkan) return vulkan->render(lattice, camera, look, options, hooks, second);
#endif
  if (by == Backend::kReference)
    return told(reference::render(lattice, camera, look, options, hooks, num_rows_at_once, second),
                num_rows_at_once);
  return told(cpu::render(lattice, camera, look, options, hooks, machine, second), wanted);
}

Frame Renderer::Impl::told(Frame frame, int wanted) {
  if (frame.profile.threads < wanted) {
    frame.profile.notice =
        fmt::format("threads: {} were wanted, the system grants {}", wanted, frame.profile.threads);
  }
  return frame;
}

std::vector<std::string> simd_targets() { return cpu::SimdTarget::usable(); }

}  // namespace ovoid
