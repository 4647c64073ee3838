// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace ovoid::io {

// Real data next to the project, or "" if it is not there.
inline std::string real_data_path(const std::string& name) {
  const char* const folder = std::getenv("OVOID_DATA");
  const std::filesystem::path base =
      folder != nullptr ? folder : std::filesystem::path(OVOID_SOURCE_DIR) / "../shared/data";
  const std::filesystem::path path = base / name;
  return std::filesystem::exists(path) ? path.string() : "";
}

}  // namespace ovoid::io
