// SPDX-License-Identifier: Apache-2.0
#include "other_program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "ovoid/error.h"

namespace ovoid::cli {

OtherProgram program_beside(const std::string& name) {
  std::error_code ignored;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const std::filesystem::path program = self.parent_path() / name;
  return {program.string(), !self.empty() && std::filesystem::is_regular_file(program, ignored)};
}

void become(const std::string& program, const std::vector<std::string>& words,
            const std::string& what) {
  std::vector<char*> arguments;  // execv() leaves them as they are
  arguments.push_back(const_cast<char*>(program.c_str()));
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: {} cannot be started: {}", what, program, std::strerror(errno)));
}

}  // namespace ovoid::cli
