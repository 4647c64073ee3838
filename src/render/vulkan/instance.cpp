// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/instance.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "ovoid/error.h"
#include "render/vulkan/result.h"
#include "render/vulkan/stages.h"

namespace ovoid::vulkan {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::kUnsupported, "backend vulkan: " + why);
}

// The loader's library, by its own name or by those that systems give it.
void* open_loader(const std::string& own) {
  if (!own.empty()) {
    if (void* library = dlopen(own.c_str(), RTLD_NOW | RTLD_LOCAL)) return library;
    refuse(fmt::format("vulkan.loader = {}: cannot be opened as a Vulkan loader", own));
  }
#if defined(__APPLE__)
  const char* const names[] = {"libvulkan.dylib", "libvulkan.1.dylib", "libMoltenVK.dylib"};
#else
  const char* const names[] = {"libvulkan.so.1", "libvulkan.so"};
#endif
  for (const char* name : names) {
    if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL)) return library;
  }
  refuse(fmt::format(
      "there is no Vulkan loader on this machine ({}): install the graphics driver and its "
      "loader (libvulkan1), or use backend cpu",
      names[0]));
}

bool has_layer(const char* wanted) {
  std::uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(), [&](const VkLayerProperties& layer) {
    return std::strcmp(layer.layerName, wanted) == 0;
  });
}

bool has_extension(const char* layer, const char* wanted) {
  std::uint32_t count = 0;
  vkEnumerateInstanceExtensionProperties(layer, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateInstanceExtensionProperties(layer, &count, extensions.data());
  return std::any_of(extensions.begin(), extensions.end(), [&](const VkExtensionProperties& e) {
    return std::strcmp(e.extensionName, wanted) == 0;
  });
}

std::string version_text(std::uint32_t version) {
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                     VK_API_VERSION_PATCH(version));
}

DeviceKind kind_of(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return DeviceKind::kDiscrete;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return DeviceKind::kIntegrated;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return DeviceKind::kVirtual;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return DeviceKind::kSoftware;
    default:
      return DeviceKind::kOther;
  }
}

std::uint64_t local_memory(VkPhysicalDevice device) {
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(device, &memory);
  std::uint64_t most = 0;
  for (std::uint32_t heap = 0; heap < memory.memoryHeapCount; ++heap) {
    if ((memory.memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0)
      most = std::max<std::uint64_t>(most, memory.memoryHeaps[heap].size);
  }
  return most;
}

// What a device lacks of what the stages need; empty: nothing.
std::string lack_of(VkPhysicalDevice device, const VkPhysicalDeviceProperties& properties) {
  if (properties.apiVersion < VK_API_VERSION_1_2)
    return fmt::format("has Vulkan {}, 1.2 is needed", version_text(properties.apiVersion));
  if (compute_family(device) < 0) return "has no queue that computes";
  const VkPhysicalDeviceLimits& limits = properties.limits;
  if (limits.maxPerStageDescriptorStorageBuffers < kMaxBindings)
    return fmt::format("gives a shader {} buffers, {} are needed",
                       limits.maxPerStageDescriptorStorageBuffers, kMaxBindings);
  if (limits.maxComputeSharedMemorySize < kSharedBytes)
    return fmt::format("has {} bytes of shared memory, {} are needed",
                       limits.maxComputeSharedMemorySize, kSharedBytes);
  if (limits.maxComputeWorkGroupInvocations < kMostInvocations)
    return fmt::format("has work groups of {}, {} are needed",
                       limits.maxComputeWorkGroupInvocations, kMostInvocations);
  return "";
}

}  // namespace

int compute_family(VkPhysicalDevice device) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  for (std::uint32_t f = 0; f < count; ++f) {
    if ((families[f].queueFlags & VK_QUEUE_COMPUTE_BIT) != 0) return static_cast<int>(f);
  }
  return -1;
}

std::shared_ptr<Instance> Instance::get(const VulkanSetup& setup) {
  static std::mutex mutex;
  static std::weak_ptr<Instance> known;
  const std::lock_guard lock(mutex);
  std::shared_ptr<Instance> instance = known.lock();
  if (!instance) {
    instance.reset(new Instance(setup));
    known = instance;
  }
  return instance;
}

Instance::Instance(const VulkanSetup& setup)
    : library_(open_loader(setup.loader)), validates_(setup.validates) {
  // Never closed: drivers leave threads and handlers behind.
  auto* const find =
      reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library_, "vkGetInstanceProcAddr"));
  if (find == nullptr) refuse("the Vulkan loader has no vkGetInstanceProcAddr");
  volkInitializeCustom(find);
  if (vkEnumerateInstanceVersion == nullptr || volkGetInstanceVersion() < VK_API_VERSION_1_2)
    refuse(fmt::format("the Vulkan loader is of version {}, 1.2 is needed",
                       version_text(volkGetInstanceVersion())));
  create();
  listen();
  std::uint32_t count = 0;
  check(vkEnumeratePhysicalDevices(instance_, &count, nullptr), "listing the devices");
  devices_.resize(count);
  check(vkEnumeratePhysicalDevices(instance_, &count, devices_.data()), "listing the devices");
  devices_.resize(count);
}

void Instance::create() {
  std::vector<const char*> layers;
  std::vector<const char*> extensions;
  if (validates_) {
    if (!has_layer(kValidationLayer))
      refuse("vulkan.validates is set, but the validation layer is not installed");
    layers.push_back(kValidationLayer);
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  }
  auto info = structure<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  // MoltenVK is listed only to those who ask for what is not all of Vulkan.
  if (has_extension(nullptr, VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
    extensions.push_back(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
    info.flags |= VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
  }
  auto application = structure<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = application.pEngineName = "ovoid";
  application.apiVersion = VK_API_VERSION_1_2;
  const VkValidationFeatureEnableEXT enabled =
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  auto features = structure<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &enabled;
  if (validates_ && has_extension(kValidationLayer, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME)) {
    extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    info.pNext = &features;
  }
  info.pApplicationInfo = &application;
  info.enabledLayerCount = static_cast<std::uint32_t>(layers.size());
  info.ppEnabledLayerNames = layers.data();
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  const VkResult result = vkCreateInstance(&info, nullptr, &instance_);
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER) refuse("no Vulkan driver is installed");
  check(result, "an instance");
  volkLoadInstanceOnly(instance_);
}

void Instance::listen() {
  if (!validates_) return;
  auto info = structure<VkDebugUtilsMessengerCreateInfoEXT>(
      VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                         VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  info.pfnUserCallback = &Instance::hear;
  info.pUserData = this;
  check(vkCreateDebugUtilsMessengerEXT(instance_, &info, nullptr, &messenger_), "a messenger");
}

VkBool32 Instance::hear(VkDebugUtilsMessageSeverityFlagBitsEXT /*severity*/,
                        VkDebugUtilsMessageTypeFlagsEXT /*types*/,
                        const VkDebugUtilsMessengerCallbackDataEXT* data, void* instance) {
  auto& self = *static_cast<Instance*>(instance);
  const std::lock_guard lock(self.mutex_);
  self.messages_.emplace_back(data->pMessage);
  return VK_FALSE;
}

Instance::~Instance() {
  if (messenger_ != VK_NULL_HANDLE) vkDestroyDebugUtilsMessengerEXT(instance_, messenger_, nullptr);
  if (instance_ != VK_NULL_HANDLE) vkDestroyInstance(instance_, nullptr);
}

std::vector<std::string> Instance::take_messages() {
  const std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

DeviceInfo Instance::info_of(int index) const {
  VkPhysicalDevice device = devices_[static_cast<std::size_t>(index)];
  auto driver = structure<VkPhysicalDeviceDriverProperties>(
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  auto properties =
      structure<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
  properties.pNext = &driver;
  vkGetPhysicalDeviceProperties2(device, &properties);
  const VkPhysicalDeviceProperties& facts = properties.properties;
  DeviceInfo info;
  info.index = index;
  info.name = facts.deviceName;
  info.kind = kind_of(facts.deviceType);
  info.memory_bytes = local_memory(device);
  info.driver = fmt::format("{} {}", driver.driverName, driver.driverInfo);
  info.api_version = version_text(facts.apiVersion);
  info.lack = lack_of(device, facts);
  return info;
}

}  // namespace ovoid::vulkan
