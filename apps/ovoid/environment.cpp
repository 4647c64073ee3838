// SPDX-License-Identifier: Apache-2.0
#include "environment.h"

#include <cstdlib>

namespace ovoid::cli {

std::string value_of(const char* variable) {
  const char* const text = std::getenv(variable);
  return text == nullptr ? "" : text;
}

RendererSetup setup_of_environment() {
  RendererSetup setup;
  setup.simd_target = value_of("OVOID_TARGET");
  setup.auto_takes_software = value_of("OVOID_AUTO_DEVICE") == "any";
  setup.vulkan.loader = value_of("OVOID_VULKAN_LOADER");
  const std::string validation = value_of("OVOID_VULKAN_VALIDATION");
  setup.vulkan.validates = !validation.empty() && validation != "0";
  return setup;
}

std::string reader_of_environment() { return value_of("OVOID_READER"); }

}  // namespace ovoid::cli
