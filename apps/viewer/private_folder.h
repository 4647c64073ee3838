// SPDX-License-Identifier: Apache-2.0
// Where files lie that are drawn as the program would draw them, and that nobody has asked for yet.
#pragma once

#include <filesystem>
#include <string>

namespace ovoid::viewer {

// A folder that nobody else sees, gone with the object.
class PrivateFolder {
 public:
  PrivateFolder();  // throws Error(kFileWrite), std::filesystem::filesystem_error
  ~PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace ovoid::viewer
