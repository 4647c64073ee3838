// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "ovoid/surface.h"
#include "session.h"

namespace ovoid::viewer {

// Surfaces that were read from files. As long as somebody has one, and its file is as it was, it is
// not read again. For one thread at a time.
class SurfaceFiles {
 public:
  // Throws Error for what cannot be read or is no surface.
  std::shared_ptr<const Surface> read(const std::string& path, cli::Session& session);
  // The same of a file that may be meant as data: null where it holds more than faces, as values.
  std::shared_ptr<const Surface> read_if_alone(const std::string& path, cli::Session& session);

 private:
  struct Kept {
    std::filesystem::file_time_type time;
    std::uintmax_t size = 0;
    bool is_alone = false;
    std::weak_ptr<const Surface> surface;
  };
  // The surface, and whether the file holds nothing else.
  struct Found {
    std::shared_ptr<const Surface> surface;
    bool is_alone = false;
  };
  Found find(const std::string& path, cli::Session& session);

  std::map<std::filesystem::path, Kept> kept_;
};

}  // namespace ovoid::viewer
