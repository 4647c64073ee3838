// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/commands.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "ovoid/error.h"
#include "render/vulkan/result.h"

namespace ovoid::vulkan {
namespace {

constexpr std::uint32_t kSetsPerPool = 512;
constexpr std::uint32_t kMostMarks = 1024;
constexpr std::uint64_t kStagingBytes = std::uint64_t{32} << 20;

}  // namespace

Commands::Commands(std::shared_ptr<Device> device) : device_(std::move(device)) {
  const VolkDeviceTable& vk = device_->vk();
  auto pool = structure<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool.queueFamilyIndex = device_->family();
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  check(vk.vkCreateCommandPool(device_->handle(), &pool, nullptr, &pool_), "a command pool");
  auto buffer =
      structure<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  buffer.commandPool = pool_;
  buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  buffer.commandBufferCount = 1;
  check(vk.vkAllocateCommandBuffers(device_->handle(), &buffer, &buffer_), "a command buffer");
  const auto fence = structure<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  check(vk.vkCreateFence(device_->handle(), &fence, nullptr, &fence_), "a fence");
  if (!device_->has_timestamps()) return;
  auto queries = structure<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
  queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
  queries.queryCount = kMostMarks;
  check(vk.vkCreateQueryPool(device_->handle(), &queries, nullptr, &queries_), "a query pool");
}

Commands::~Commands() {
  const VolkDeviceTable& vk = device_->vk();
  for (VkDescriptorPool pool : set_pools_)
    vk.vkDestroyDescriptorPool(device_->handle(), pool, nullptr);
  if (queries_ != VK_NULL_HANDLE) vk.vkDestroyQueryPool(device_->handle(), queries_, nullptr);
  vk.vkDestroyFence(device_->handle(), fence_, nullptr);
  vk.vkDestroyCommandPool(device_->handle(), pool_, nullptr);
}

void Commands::begin() {
  if (is_recording_) return;
  const VolkDeviceTable& vk = device_->vk();
  check(vk.vkResetCommandPool(device_->handle(), pool_, 0), "recording commands");
  for (VkDescriptorPool pool : set_pools_) vk.vkResetDescriptorPool(device_->handle(), pool, 0);
  current_pool_ = 0;
  auto info = structure<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vk.vkBeginCommandBuffer(buffer_, &info), "recording commands");
  if (queries_ != VK_NULL_HANDLE && times) vk.vkCmdResetQueryPool(buffer_, queries_, 0, kMostMarks);
  marks_.clear();
  is_recording_ = true;
  // The host's writes to mapped memory are seen by themselves; copies of earlier lists are over.
}

// All that is written before is there for all that comes after.
void Commands::barrier() {
  auto barrier = structure<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_UNIFORM_READ_BIT | VK_ACCESS_SHADER_READ_BIT |
                          VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                          VK_ACCESS_TRANSFER_WRITE_BIT;
  constexpr VkPipelineStageFlags kStages =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
  device_->vk().vkCmdPipelineBarrier(buffer_, kStages, kStages, 0, 1, &barrier, 0, nullptr, 0,
                                     nullptr);
}

VkDescriptorSet Commands::new_set(const Pipeline& pipeline) {
  const VolkDeviceTable& vk = device_->vk();
  auto info =
      structure<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  info.descriptorSetCount = 1;
  info.pSetLayouts = &pipeline.set_layout;
  VkDescriptorSet set = VK_NULL_HANDLE;
  for (; current_pool_ < set_pools_.size(); ++current_pool_) {
    info.descriptorPool = set_pools_[current_pool_];
    if (vk.vkAllocateDescriptorSets(device_->handle(), &info, &set) == VK_SUCCESS) return set;
  }
  const std::array sizes{
      VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, kSetsPerPool * kMaxBindings},
      VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, kSetsPerPool}};
  auto pool = structure<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  pool.maxSets = kSetsPerPool;
  pool.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  pool.pPoolSizes = sizes.data();
  check(vk.vkCreateDescriptorPool(device_->handle(), &pool, nullptr, &info.descriptorPool),
        "a descriptor pool");
  set_pools_.push_back(info.descriptorPool);
  check(vk.vkAllocateDescriptorSets(device_->handle(), &info, &set), "a descriptor set");
  return set;
}

void Commands::dispatch_bytes(const Shader& shader, const Constants& constants,
                              std::initializer_list<const Buffer*> buffers,
                              std::span<const std::byte> push, Groups groups) {
  if (groups.x == 0 || groups.y == 0 || groups.z == 0) return;
  const Pipeline& pipeline = device_->pipeline(shader, constants);
  assert(buffers.size() == pipeline.num_bindings);
  begin();
  const VolkDeviceTable& vk = device_->vk();
  VkDescriptorSet set = new_set(pipeline);
  std::array<VkDescriptorBufferInfo, kMaxBindings> infos{};
  std::uint32_t count = 0;
  for (const Buffer* buffer : buffers) infos[count++] = {buffer->handle(), 0, VK_WHOLE_SIZE};
  const std::uint32_t num_frames = pipeline.has_frame ? 1 : 0;
  std::array<VkWriteDescriptorSet, 2> writes{};  // the frame, the others
  for (VkWriteDescriptorSet& write : writes) {
    write = structure<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
    write.dstSet = set;
  }
  writes[0].descriptorCount = 1;
  writes[0].descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  writes[0].pBufferInfo = infos.data();
  writes[1].dstBinding = num_frames;
  writes[1].descriptorCount = count - num_frames;
  writes[1].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  writes[1].pBufferInfo = infos.data() + num_frames;
  vk.vkUpdateDescriptorSets(device_->handle(), 1 + num_frames, &writes[1 - num_frames], 0, nullptr);
  vk.vkCmdBindPipeline(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.pipeline);
  vk.vkCmdBindDescriptorSets(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout, 0, 1, &set,
                             0, nullptr);
  if (!push.empty())
    vk.vkCmdPushConstants(buffer_, pipeline.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                          static_cast<std::uint32_t>(push.size()), push.data());
  vk.vkCmdDispatch(buffer_, groups.x, groups.y, groups.z);
  barrier();
}

void Commands::fill(const Buffer& buffer, std::uint32_t word) {
  begin();
  device_->vk().vkCmdFillBuffer(buffer_, buffer.handle(), 0, VK_WHOLE_SIZE, word);
  barrier();
}

void Commands::copy(const Buffer& from, std::uint64_t from_offset, const Buffer& to,
                    std::uint64_t to_offset, std::uint64_t bytes) {
  begin();
  const VkBufferCopy region{from_offset, to_offset, bytes};
  device_->vk().vkCmdCopyBuffer(buffer_, from.handle(), to.handle(), 1, &region);
  barrier();
}

void Commands::mark(const char* name) {
  if (!times || queries_ == VK_NULL_HANDLE) return;
  begin();
  if (marks_.size() + 2 > kMostMarks) return;
  device_->vk().vkCmdWriteTimestamp(buffer_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_,
                                    static_cast<std::uint32_t>(marks_.size()));
  marks_.emplace_back(name);
}

void Commands::discard() {
  if (!is_recording_) return;
  device_->vk().vkEndCommandBuffer(buffer_);
  marks_.clear();
  is_recording_ = false;
}

void Commands::submit_and_wait() {
  if (!is_recording_) return;
  is_recording_ = false;
  const VolkDeviceTable& vk = device_->vk();
  if (!marks_.empty())
    vk.vkCmdWriteTimestamp(buffer_, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_,
                           static_cast<std::uint32_t>(marks_.size()));
  // For the host to see what mapped memory holds.
  auto barrier = structure<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
  vk.vkCmdPipelineBarrier(buffer_,
                          VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT,
                          VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
  const auto run = [&]() -> VkResult {
    if (const VkResult ended = vk.vkEndCommandBuffer(buffer_); ended < 0) return ended;
    auto submit = structure<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &buffer_;
    {
      const std::lock_guard lock(device_->queue_mutex());
      if (const VkResult sent = vk.vkQueueSubmit(device_->queue(), 1, &submit, fence_); sent < 0)
        return sent;
    }
    const VkResult waited = vk.vkWaitForFences(device_->handle(), 1, &fence_, VK_TRUE, UINT64_MAX);
    if (waited < 0) return waited;
    return vk.vkResetFences(device_->handle(), 1, &fence_);
  };
  const VkResult result = run();
  if (result == VK_ERROR_DEVICE_LOST) device_->mark_lost();
  check(result, "drawing");
  collect_times();
}

void Commands::collect_times() {
  if (marks_.empty()) return;
  std::vector<std::uint64_t> ticks(marks_.size() + 1);
  const VkResult result = device_->vk().vkGetQueryPoolResults(
      device_->handle(), queries_, 0, static_cast<std::uint32_t>(ticks.size()),
      ticks.size() * sizeof(std::uint64_t), ticks.data(), sizeof(std::uint64_t),
      VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
  check(result, "reading the clock");
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    const double ms = static_cast<double>(ticks[i + 1] - ticks[i]) *
                      static_cast<double>(device_->limits().timestampPeriod) * 1e-6;
    add_time(marks_[i].c_str(), ms);
  }
  marks_.clear();
}

void Commands::add_time(const char* name, double ms) {
  if (!times) return;
  if (!stages_ms.contains(name)) stage_order.emplace_back(name);
  stages_ms[name] += ms;
}

void Commands::upload(const Buffer& to, std::uint64_t offset, std::span<const std::byte> bytes) {
  assert(!is_recording_);
  if (bytes.empty()) return;
  uploaded_bytes += bytes.size();
  if (to.mapped() != nullptr) {
    std::memcpy(to.mapped() + offset, bytes.data(), bytes.size());
    return;
  }
  reserve(staging_, device_, std::min<std::uint64_t>(kStagingBytes, bytes.size()),
          BufferUse::kUpload);
  for (std::uint64_t done = 0; done < bytes.size();) {
    const std::uint64_t part = std::min<std::uint64_t>(staging_.bytes(), bytes.size() - done);
    std::memcpy(staging_.mapped(), bytes.data() + done, part);
    copy(staging_, 0, to, offset + done, part);
    submit_and_wait();
    done += part;
  }
}

std::span<const std::byte> Commands::fetch(const Buffer& from, std::uint64_t offset,
                                           std::uint64_t bytes) {
  // A graphics processor's memory may be shared, and yet not in the processor's cache.
  if (from.mapped() != nullptr && device_->info().kind == DeviceKind::kSoftware)
    return {from.mapped() + offset, bytes};
  reserve(readback_, device_, bytes, BufferUse::kReadBack);
  copy(from, offset, readback_, 0, bytes);
  submit_and_wait();
  return {readback_.mapped(), bytes};
}

void Commands::read_back(const Buffer& from, std::uint64_t offset, std::span<std::byte> bytes) {
  if (bytes.empty()) return;
  const std::span<const std::byte> found = fetch(from, offset, bytes.size());
  std::memcpy(bytes.data(), found.data(), bytes.size());
}

}  // namespace ovoid::vulkan
