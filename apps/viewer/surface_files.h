// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/surface.h"
#include "session.h"

namespace ovoid::viewer {

// What a surface that is added is made of.
struct SurfaceSource {
  std::string file;
  std::string array{};  // gives colours; empty: none
  double radius = 0;    // of lines and points, world; 0: the usual one
  bool operator==(const SurfaceSource&) const = default;
};

// Immutable.
struct ReadSurface {
  SurfaceSource source;
  std::shared_ptr<const Surface> surface;
  std::pair<double, double> values{0, 1};  // of the array, the least and the greatest
  std::vector<std::string> arrays;         // of the file, that may give colours
  bool has_radius = false;                 // there are lines or points
};

// Surfaces that were read from files. As long as somebody has one, and its file is as it was, it is
// not read again. For one thread at a time.
class SurfaceFiles {
 public:
  struct Found {
    std::shared_ptr<const ReadSurface> read;  // null: a lattice
    bool is_alone = false;                    // the file holds nothing but faces, as no values
    std::shared_ptr<const Dataset> lattice{};
  };
  // Throws Error for what cannot be read, and is neither.
  Found find(const SurfaceSource& source, cli::Session& session);
  // The surface. Throws Error for what cannot be read or is none.
  std::shared_ptr<const ReadSurface> read(const SurfaceSource& source, cli::Session& session);

 private:
  // A file as it was.
  struct State {
    std::filesystem::file_time_type time;
    std::uintmax_t size = 0;
    bool operator==(const State&) const = default;
  };
  struct Kept {
    State state;
    bool is_alone = false;
    std::weak_ptr<const ReadSurface> read;
  };
  struct Mesh {
    std::filesystem::path place;
    State state;
    Dataset mesh;
  };
  Dataset mesh_at(const std::filesystem::path& place, const std::string& path, const State& state,
                  cli::Session& session);

  std::map<std::pair<std::filesystem::path, std::pair<std::string, double>>, Kept> kept_;
  std::optional<Mesh> last_;  // read last, if it is small: other arrays and radii are of it
};

}  // namespace ovoid::viewer
