// SPDX-License-Identifier: Apache-2.0
// ovoid view: hands over to the viewer, a program of its own, so that drawing to files needs no
// library for windows.

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include "command.h"
#include "ovoid/error.h"

namespace ovoid::cli {

void run_view(const Words& words) {
  std::error_code ignored;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const std::string viewer = (self.parent_path() / "ovoid-viewer").string();
  if (self.empty() || !std::filesystem::is_regular_file(viewer, ignored)) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("view: the viewer is not part of this installation, there is no {}; to "
                            "draw to a file: ovoid render INPUT... -o OUT.png",
                            viewer));
  }
  std::vector<char*> arguments;  // execv() leaves them as they are
  arguments.push_back(const_cast<char*>(viewer.c_str()));
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  execv(viewer.c_str(), arguments.data());
  throw Error(ErrorCode::kUnsupported,
              fmt::format("view: {} cannot be started: {}", viewer, std::strerror(errno)));
}

}  // namespace ovoid::cli
