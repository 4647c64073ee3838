// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>

#include "render/vulkan/commands.h"
#include "render/vulkan/pixels.h"

namespace ovoid::vulkan {

// What is needed for drawing, whatever is drawn.
struct Workbench {
  Workbench(std::shared_ptr<Device> on, std::uint64_t bytes)
      : device(std::move(on)), commands(device), pixels(device), most_bytes(bytes) {}

  std::shared_ptr<Device> device;
  Commands commands;
  Pixels pixels;
  std::uint64_t most_bytes;  // of the device's memory for fields
};

inline std::uint32_t groups_for(std::uint64_t count, std::uint32_t size) {
  return static_cast<std::uint32_t>((count + size - 1) / size);
}

// So many work groups in a row, as a grid that no limit forbids; a few more than asked for.
inline Groups grid_of(std::uint32_t groups) {
  constexpr std::uint32_t kMostInRow = 32768;
  return {std::min(groups, kMostInRow), groups_for(groups, kMostInRow), 1};
}

// Work groups of edge^2 pixels for a strip.
inline Groups groups_of(const RenderOptions& options, const Strip& strip, std::uint32_t edge) {
  return {groups_for(static_cast<std::uint64_t>(options.width), edge),
          groups_for(static_cast<std::uint64_t>(strip.rows()), edge), 1};
}

// While it lives, the processor's time goes under a stage's name.
class HostStage {
 public:
  HostStage(Commands& commands, const char* name) : commands_(commands), name_(name) {}
  ~HostStage() {
    const auto taken = std::chrono::steady_clock::now() - start_;
    commands_.add_time(name_, std::chrono::duration<double, std::milli>(taken).count());
  }
  HostStage(const HostStage&) = delete;
  HostStage& operator=(const HostStage&) = delete;

 private:
  Commands& commands_;
  const char* name_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// A strip is finished.
void tell_of(const Strip& strip, const RenderHooks& hooks, const Image& image);

// Adds what each of so many work groups has counted: samples reconstructed, shaded, gradients, -.
void add_counts(Commands& commands, const Buffer& counts, std::size_t num_groups,
                FrameProfile& profile);

}  // namespace ovoid::vulkan
