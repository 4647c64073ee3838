// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "ovoid/error.h"
#include "render/vulkan/result.h"

namespace ovoid::vulkan {
namespace {

// The first that draws by itself, else the first that can be used at all; -1: none.
int preferred(const Instance& instance) {
  int fallback = -1;
  for (int i = 0; i < static_cast<int>(instance.physical_devices().size()); ++i) {
    const DeviceInfo info = instance.info_of(i);
    if (!info.is_usable()) continue;
    if (info.is_hardware()) return i;
    if (fallback < 0) fallback = i;
  }
  return fallback;
}

int checked_index(const Instance& instance, int index) {
  const auto count = static_cast<int>(instance.physical_devices().size());
  if (count == 0)
    throw Error(ErrorCode::kUnsupported,
                "backend vulkan: there is no Vulkan device on this machine: install its graphics "
                "driver (or Mesa's software driver, mesa-vulkan-drivers), or use backend cpu");
  if (index >= count)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("device = {}: there are {} devices, expected 0 to {}", index, count,
                            count - 1));
  if (index < 0) index = preferred(instance);
  const DeviceInfo info = instance.info_of(std::max(index, 0));
  if (!info.is_usable())
    throw Error(ErrorCode::kUnsupported, fmt::format("device {}: {} cannot be used: it {}",
                                                     info.index, info.name, info.lack));
  return index;
}

bool device_has(VkPhysicalDevice device, const char* wanted) {
  std::uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data());
  return std::any_of(extensions.begin(), extensions.end(), [&](const VkExtensionProperties& e) {
    return std::strcmp(e.extensionName, wanted) == 0;
  });
}

}  // namespace

std::shared_ptr<Device> Device::get(int index, const VulkanSetup& setup) {
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<Device>> known;
  const std::lock_guard lock(mutex);
  std::shared_ptr<Instance> instance = Instance::get(setup);
  index = checked_index(*instance, index);
  std::shared_ptr<Device> device = known[index].lock();
  if (!device || device->is_lost()) {
    device.reset(new Device(std::move(instance), index));
    known[index] = device;
  }
  return device;
}

Device::Device(std::shared_ptr<Instance> instance, int index)
    : instance_(std::move(instance)),
      info_(instance_->info_of(index)),
      physical_(instance_->physical_devices()[static_cast<std::size_t>(index)]),
      family_(static_cast<std::uint32_t>(compute_family(physical_))) {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(physical_, &properties);
  limits_ = properties.limits;
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);
  std::uint32_t num_families = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &num_families, nullptr);
  std::vector<VkQueueFamilyProperties> families(num_families);
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &num_families, families.data());
  timestamp_bits_ = families[family_].timestampValidBits;

  const float priority = 1.0F;
  auto queue = structure<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queue.queueFamilyIndex = family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  std::vector<const char*> extensions;
  // Who has it must be asked for it.
  constexpr const char* kPortability = "VK_KHR_portability_subset";
  if (device_has(physical_, kPortability)) extensions.push_back(kPortability);
  auto info = structure<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  // Uniform buffers with the layout of storage buffers, which Vulkan 1.2 asks of every device.
  auto features = structure<VkPhysicalDeviceVulkan12Features>(
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
  features.uniformBufferStandardLayout = VK_TRUE;
  info.pNext = &features;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  check(vkCreateDevice(physical_, &info, nullptr, &device_), "opening the device");
  volkLoadDeviceTable(&vk_, device_);
  vk_.vkGetDeviceQueue(device_, family_, 0, &queue_);
}

Device::~Device() {
  for (auto& [key, pipeline] : pipelines_) {
    vk_.vkDestroyPipeline(device_, pipeline.pipeline, nullptr);
    vk_.vkDestroyPipelineLayout(device_, pipeline.layout, nullptr);
    vk_.vkDestroyDescriptorSetLayout(device_, pipeline.set_layout, nullptr);
  }
  vk_.vkDestroyDevice(device_, nullptr);
}

int Device::memory_type(std::uint32_t allowed, VkMemoryPropertyFlags needed,
                        VkMemoryPropertyFlags wanted) const noexcept {
  for (const VkMemoryPropertyFlags flags : {needed | wanted, needed}) {
    for (std::uint32_t t = 0; t < memory_.memoryTypeCount; ++t) {
      if ((allowed >> t & 1U) != 0 && (memory_.memoryTypes[t].propertyFlags & flags) == flags)
        return static_cast<int>(t);
    }
  }
  return -1;
}

bool Device::is_host_visible(int type) const noexcept {
  return (memory_.memoryTypes[type].propertyFlags & kMapped) == kMapped;
}

const Pipeline& Device::pipeline(const Shader& shader, const Constants& constants) {
  const std::lock_guard lock(mutex_);
  const auto key = std::make_pair(&shader, constants);
  auto known = pipelines_.find(key);
  if (known == pipelines_.end())
    known = pipelines_.emplace(key, make_pipeline(shader, constants)).first;
  return known->second;
}

Pipeline Device::make_pipeline(const Shader& shader, const Constants& constants) const {
  Pipeline made;
  made.num_bindings = shader.num_bindings;
  made.has_frame = shader.has_frame;
  std::vector<VkDescriptorSetLayoutBinding> bindings(shader.num_bindings);
  for (std::uint32_t b = 0; b < shader.num_bindings; ++b)
    bindings[b] = {b, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  if (shader.has_frame) bindings[0].descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  auto set = structure<VkDescriptorSetLayoutCreateInfo>(
      VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  set.bindingCount = shader.num_bindings;
  set.pBindings = bindings.data();
  check(vk_.vkCreateDescriptorSetLayout(device_, &set, nullptr, &made.set_layout), shader.name);
  const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, shader.push_bytes};
  auto layout =
      structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  layout.setLayoutCount = 1;
  layout.pSetLayouts = &made.set_layout;
  layout.pushConstantRangeCount = shader.push_bytes > 0 ? 1 : 0;
  layout.pPushConstantRanges = &push;
  check(vk_.vkCreatePipelineLayout(device_, &layout, nullptr, &made.layout), shader.name);

  auto code = structure<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  code.codeSize = shader.code.size_bytes();
  code.pCode = shader.code.data();
  VkShaderModule module = VK_NULL_HANDLE;
  check(vk_.vkCreateShaderModule(device_, &code, nullptr, &module), shader.name);
  std::vector<VkSpecializationMapEntry> entries(constants.size());
  for (std::uint32_t i = 0; i < constants.size(); ++i)
    entries[i] = {i, static_cast<std::uint32_t>(i * sizeof(std::uint32_t)), sizeof(std::uint32_t)};
  VkSpecializationInfo special{static_cast<std::uint32_t>(entries.size()), entries.data(),
                               constants.size() * sizeof(std::uint32_t), constants.data()};
  auto info =
      structure<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
  info.stage = structure<VkPipelineShaderStageCreateInfo>(
      VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &special;
  info.layout = made.layout;
  const VkResult result =
      vk_.vkCreateComputePipelines(device_, VK_NULL_HANDLE, 1, &info, nullptr, &made.pipeline);
  vk_.vkDestroyShaderModule(device_, module, nullptr);
  check(result, shader.name);
  return made;
}

void Device::check_messages() {
  const std::vector<std::string> messages = instance_->take_messages();
  if (messages.empty()) return;
  throw Error(ErrorCode::kUnsupported,
              fmt::format("backend vulkan: the validation layer found {} faults, the first: {}",
                          messages.size(), messages.front()));
}

}  // namespace ovoid::vulkan
