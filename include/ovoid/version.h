// SPDX-License-Identifier: Apache-2.0
// The version of the library that is compiled against; version() is that of the library in use.
#pragma once

#include "ovoid/export.h"

// CMakeLists.txt reads these three lines: the project's version is written here alone.
#define OVOID_VERSION_MAJOR 0
#define OVOID_VERSION_MINOR 1
#define OVOID_VERSION_PATCH 0

namespace OVOID_API ovoid {

struct Version {
  int major = OVOID_VERSION_MAJOR;
  int minor = OVOID_VERSION_MINOR;
  int patch = OVOID_VERSION_PATCH;
  bool operator==(const Version&) const = default;
};

// Before 1.0 a program runs with every library of the major and minor version it was compiled with,
// which the library's file name (SONAME) ensures.
Version version() noexcept;

}  // namespace ovoid
