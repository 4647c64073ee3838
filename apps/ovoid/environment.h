// SPDX-License-Identifier: Apache-2.0
// The library reads no environment; the program does, and hands it over (docs/conventions.md).
#pragma once

#include <string>

#include "ovoid/renderer.h"

namespace ovoid::cli {

// Of a variable of the environment; empty if it is not set.
std::string value_of(const char* variable);

// OVOID_TARGET, OVOID_AUTO_DEVICE, OVOID_VULKAN_LOADER and OVOID_VULKAN_VALIDATION.
RendererSetup setup_of_environment();

// OVOID_READER.
std::string reader_of_environment();

}  // namespace ovoid::cli
