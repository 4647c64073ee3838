// SPDX-License-Identifier: Apache-2.0
// What the device is told to do, in order: recorded, submitted, waited for.
#pragma once

#include <initializer_list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "render/vulkan/buffer.h"

namespace ovoid::vulkan {

struct Groups {
  std::uint32_t x = 1, y = 1, z = 1;
};

// One list of commands at a time. Each sees what those before it have written. Not for several
// threads at once.
class Commands {
 public:
  explicit Commands(std::shared_ptr<Device> device);
  ~Commands();
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  // Runs a stage, or any shader, on `groups` work groups; nothing if there are none. `buffers` are
  // its bindings 0, 1, ...; `push` its push constants.
  void dispatch_bytes(const Shader& shader, const Constants& constants,
                      std::initializer_list<const Buffer*> buffers, std::span<const std::byte> push,
                      Groups groups);
  template <class T>
  void dispatch(Stage stage, const Constants& constants,
                std::initializer_list<const Buffer*> buffers, const T& push, Groups groups) {
    dispatch_bytes(shader_of(stage), constants, buffers, std::as_bytes(std::span(&push, 1)),
                   groups);
  }
  void fill(const Buffer& buffer, std::uint32_t word);
  void copy(const Buffer& from, std::uint64_t from_offset, const Buffer& to,
            std::uint64_t to_offset, std::uint64_t bytes);

  // What follows, up to the next mark, is timed under this name; without timestamps nothing is.
  void mark(const char* name);

  // What has been recorded is not wanted after all.
  void discard();
  // Throws Error(kDeviceLost) and marks the device, Error(kOutOfMemory).
  void submit_and_wait();

  // Writes to a buffer at once, by way of a staging buffer if it must; waits.
  void upload(const Buffer& to, std::uint64_t offset, std::span<const std::byte> bytes);
  // Whatever is wanted of a buffer, after a submit.
  void read_back(const Buffer& from, std::uint64_t offset, std::span<std::byte> bytes);
  // The same where it lies, until the next upload or read.
  std::span<const std::byte> fetch(const Buffer& from, std::uint64_t offset, std::uint64_t bytes);

  // Adds the processor's own time under a name, if marks do anything.
  void add_time(const char* name, double ms);

  std::uint64_t uploaded_bytes = 0;         // since it was cleared
  bool times = false;                       // whether marks do anything
  std::map<std::string, double> stages_ms;  // added up since it was cleared
  std::vector<std::string> stage_order;

 private:
  void begin();
  void barrier();
  VkDescriptorSet new_set(const Pipeline& pipeline);
  void collect_times();

  std::shared_ptr<Device> device_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer buffer_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  VkQueryPool queries_ = VK_NULL_HANDLE;
  std::vector<VkDescriptorPool> set_pools_;
  std::size_t current_pool_ = 0;
  std::vector<std::string> marks_;  // names of the queries; the last ends the list
  bool is_recording_ = false;
  Buffer staging_, readback_;
};

}  // namespace ovoid::vulkan
