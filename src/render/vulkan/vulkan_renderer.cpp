// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/vulkan_renderer.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <optional>

#include "ovoid/error.h"
#include "render/vulkan/kernel_renderer.h"
#include "render/vulkan/lattice_renderer.h"

namespace ovoid::vulkan {
namespace {

// Of the device's memory, unless somebody says how much: the rest is for pictures and others.
constexpr double kShareForFields = 0.7;

using Clock = std::chrono::steady_clock;
double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

struct VulkanRenderer::Impl {
  const RendererSetup setup;
  bool has_drawn = false;
  std::optional<Workbench> bench;
  std::optional<LatticeRenderer> lattices;
  std::optional<KernelRenderer> kernels;

  explicit Impl(const RendererSetup& of) : setup(of) {}
  void open() {
    std::shared_ptr<Device> device = Device::get(setup.device, setup.vulkan);
    const std::uint64_t all = device->info().memory_bytes;
    const auto bytes = setup.device_memory > 0
                           ? setup.device_memory
                           : static_cast<std::uint64_t>(kShareForFields * static_cast<double>(all));
    bench.emplace(std::move(device), bytes);
    lattices.emplace(*bench);
    kernels.emplace(*bench);
  }
  void close() {
    has_drawn = false;
    lattices.reset();
    kernels.reset();
    bench.reset();
  }

  // Times a frame and tells of it. A frame that is stopped leaves the fields where they are. Where
  // memory does not suffice while other fields lie there, it is tried once more without them; a
  // device that is lost is given up, and the next frame opens it anew.
  Frame draw(const FrameJob& job) {
    const bool is_fresh = !bench || !has_drawn;
    try {
      return try_to_draw(job);
    } catch (const Error& error) {
      const bool is_well =
          error.code() == ErrorCode::kCancelled || error.code() == ErrorCode::kInvalidArgument;
      if (is_well && bench) {
        bench->commands.discard();
        lattices->forget_relevance();
        throw;
      }
      close();
      if (error.code() != ErrorCode::kOutOfMemory || is_fresh) throw;
    }
    try {
      return try_to_draw(job);
    } catch (const Error&) {
      close();
      throw;
    }
  }

  Frame try_to_draw(const FrameJob& job) {
    const RenderOptions& options = job.options;
    const Clock::time_point start = Clock::now();
    if (!bench) open();
    has_drawn = true;
    Frame out;
    out.image.width = options.width;
    out.image.height = options.height;
    const std::size_t num_pixels = static_cast<std::size_t>(options.width) * options.height;
    out.image.rgba.assign(4 * num_pixels, 0.0F);
    out.image.depth.assign(num_pixels, std::numeric_limits<float>::infinity());
    out.image.front_depth = out.image.depth;
    out.profile.backend = "vulkan";
    out.profile.device = bench->device->info().name;
    out.profile.kernels_total = job.field.num_kernels();
    Commands& commands = bench->commands;
    commands.times = options.collect_profile;
    commands.uploaded_bytes = 0;
    commands.stages_ms.clear();
    commands.stage_order.clear();
    if (job.field.kernels() != nullptr) {
      kernels->render(job, out.image, out.profile);
    } else {
      lattices->render(job, out.image, out.profile);
    }
    bench->device->check_messages();
    out.profile.bytes_uploaded = static_cast<std::int64_t>(commands.uploaded_bytes);
    out.profile.frame_ms = ms_since(start);
    for (const std::string& stage : commands.stage_order)
      out.profile.stages_ms.emplace_back(stage, commands.stages_ms[stage]);
    if (job.hooks.stop.stop_requested())
      throw Error(ErrorCode::kCancelled, "rendering was cancelled");
    return out;
  }
};

VulkanRenderer::VulkanRenderer(const RendererSetup& setup) : impl_(std::make_unique<Impl>(setup)) {
  impl_->open();
}

VulkanRenderer::~VulkanRenderer() = default;

Frame VulkanRenderer::draw(const FrameJob& job) { return impl_->draw(job); }

namespace {

// False where the system has no node of any graphics processor: then the loader and its drivers,
// some 40 MiB and 0.05 s, need not be loaded to learn that there is none.
bool may_have_hardware() {
#if defined(__linux__)
  for (const char* node : {"/dev/dri", "/dev/nvidiactl", "/dev/nvidia0", "/dev/dxg",
                           "/dev/kgsl-3d0", "/dev/mali0", "/dev/pvrsrvkm"}) {
    std::error_code ignored;
    if (std::filesystem::exists(node, ignored)) return true;
  }
  return false;
#else
  return true;
#endif
}

}  // namespace

bool has_device_for_auto(const RendererSetup& setup) {
  if (!setup.auto_takes_software && !may_have_hardware()) return false;
  try {
    const std::shared_ptr<Instance> instance = Instance::get(setup.vulkan);
    for (int i = 0; i < static_cast<int>(instance->physical_devices().size()); ++i) {
      const DeviceInfo info = instance->info_of(i);
      if ((setup.auto_takes_software || info.is_hardware()) && info.is_usable()) return true;
    }
  } catch (const Error&) {
    return false;
  }
  return false;
}

}  // namespace ovoid::vulkan
