// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ovoid/export.h"

namespace OVOID_API ovoid {

enum class DeviceKind { kDiscrete, kIntegrated, kVirtual, kSoftware, kOther };

const char* name_of(DeviceKind kind) noexcept;  // "discrete", "integrated", ...

// A device that Vulkan lists.
struct DeviceInfo {
  int index = 0;  // what RendererSetup::device asks for it by
  std::string name;
  DeviceKind kind = DeviceKind::kOther;
  std::uint64_t memory_bytes = 0;  // its largest heap that is its own
  std::string driver;              // name and version
  std::string api_version;         // "1.3.230"
  std::string lack;                // what it lacks to be used; empty: nothing

  // Draws by itself, not by a program on the processor.
  bool is_hardware() const noexcept {
    return kind == DeviceKind::kDiscrete || kind == DeviceKind::kIntegrated ||
           kind == DeviceKind::kVirtual;
  }
  bool is_usable() const noexcept { return lack.empty(); }
};

// How Vulkan is brought up. A process has one loader and one instance at a time, as the first
// renderer or list that lives asks for them; later ones share them.
struct VulkanSetup {
  std::string loader{};    // path of the loader's library; empty: the system's
  bool validates = false;  // the validation layer looks on; what it finds is an error
};

struct DeviceList {
  std::vector<DeviceInfo> devices;  // in the loader's order
  std::string problem;              // why there is none: one line; empty if there are some
};

// The devices of this machine that Backend::kVulkan could use. Never throws for want of them. Cost:
// the loader and all drivers are loaded, some 0.1 s.
DeviceList list_devices(const VulkanSetup& setup = {});

}  // namespace ovoid
