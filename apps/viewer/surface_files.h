// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "ovoid/dataset.h"
#include "ovoid/surface.h"
#include "session.h"

namespace ovoid::viewer {

// Surfaces that were read from files. As long as somebody has one, and its file is as it was, it is
// not read again. For one thread at a time.
class SurfaceFiles {
 public:
  struct Found {
    std::shared_ptr<const Surface> surface;  // null: a lattice
    bool is_alone = false;                   // the file holds nothing but faces, as no values
    std::shared_ptr<const Dataset> lattice{};
  };
  // Throws Error for what cannot be read, and is neither.
  Found find(const std::string& path, cli::Session& session);
  // The surface. Throws Error for what cannot be read or is none.
  std::shared_ptr<const Surface> read(const std::string& path, cli::Session& session);

 private:
  struct Kept {
    std::filesystem::file_time_type time;
    std::uintmax_t size = 0;
    bool is_alone = false;
    std::weak_ptr<const Surface> surface;
  };

  std::map<std::filesystem::path, Kept> kept_;
};

}  // namespace ovoid::viewer
