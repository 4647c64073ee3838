// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::io {

// Real data next to the project, or "" if it is not there.
inline std::string real_data_path(const std::string& name) {
  const char* const folder = std::getenv("OVOID_DATA");
  const std::filesystem::path base =
      folder != nullptr ? folder : std::filesystem::path(OVOID_SOURCE_DIR) / "../shared/data";
  const std::filesystem::path path = base / name;
  return std::filesystem::exists(path) ? path.string() : "";
}

inline Bytes own_bytes(std::vector<std::byte> bytes) {
  const auto owner = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
  return {owner, *owner};
}

}  // namespace ovoid::io
