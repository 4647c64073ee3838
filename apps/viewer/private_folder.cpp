// SPDX-License-Identifier: Apache-2.0
#include "private_folder.h"

#include <fmt/format.h>

#include <random>
#include <system_error>

#include "ovoid/error.h"

namespace ovoid::viewer {

PrivateFolder::PrivateFolder() {
  std::random_device random;
  path_ = std::filesystem::temp_directory_path() /
          fmt::format("ovoid-{:08x}{:08x}", random(), random());
  if (!std::filesystem::create_directory(path_))
    throw Error(ErrorCode::kFileWrite, fmt::format("'{}' exists", path_.string()));
  std::filesystem::permissions(path_, std::filesystem::perms::owner_all);
}

PrivateFolder::~PrivateFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace ovoid::viewer
