// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "render/vulkan/commands.h"

namespace ovoid::vulkan {

// A part of a field that is sent to the device at once.
struct Resident {
  Buffer data;  // empty: not there
  std::uint64_t last_used = 0;
};

// Keeps the parts that the device has within a bound: those that were not used for longest give
// way.
class Residency {
 public:
  explicit Residency(std::uint64_t most_bytes) : most_bytes_(most_bytes) {}

  // Sends a part, which is not there, in place of others of `parts`, which derive from Resident.
  template <class Part>
  void send(Part& part, std::span<Part> parts, std::span<const std::byte> bytes,
            const std::shared_ptr<Device>& device, Commands& commands) {
    while (bytes_ > 0 && bytes_ + bytes.size() > most_bytes_) {
      Part* oldest = nullptr;
      for (Part& other : parts) {
        if (other.data.is_empty()) continue;
        if (oldest == nullptr || other.last_used < oldest->last_used) oldest = &other;
      }
      bytes_ -= std::min(bytes_, oldest->data.bytes());
      oldest->data = Buffer();
    }
    part.data = Buffer(device, bytes.size(), BufferUse::kDevice);
    bytes_ += part.data.bytes();
    commands.upload(part.data, 0, bytes);
  }
  void touch(Resident& part) noexcept { part.last_used = ++clock_; }

 private:
  std::uint64_t most_bytes_, bytes_ = 0, clock_ = 0;
};

}  // namespace ovoid::vulkan
