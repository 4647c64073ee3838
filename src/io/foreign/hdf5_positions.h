// SPDX-License-Identifier: Apache-2.0
// Which datasets of an HDF5 file are the places of particles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/foreign/hdf5_file.h"

namespace ovoid::io {

// Where positions lie: one dataset, or one per axis. Of a file that must outlive it.
struct Hdf5Positions {
  std::vector<const Hdf5Dataset*> datasets;
  bool is_transposed = false;  // [3, n]
  std::int64_t count = 0;

  const std::string& group() const { return datasets[0]->group; }
  const std::string& path() const { return datasets[0]->path; }
};

// All that are called like positions, and may be some.
std::vector<Hdf5Positions> candidates_in(const Hdf5File& file);

// Those that the user names. Throws Error(kInvalidArgument) naming `source`.
Hdf5Positions asked_positions(const Hdf5File& file, const std::string& source,
                              const std::string& asked);

// Which of several places positions are taken from: of Gadget's types the first that matters, which
// a note tells. Throws Error(kFileFormat) that lists them if there are several others, or none.
struct PositionsPlace {
  std::string path, group;
};
std::size_t choose_positions(const std::string& source, const std::vector<PositionsPlace>& places,
                             std::vector<std::string>& notes);

// "/PartType4" is 4; -1 for another group.
int gadget_type(std::string_view group);

std::string absolute_path(const std::string& path);  // in the file, from its root

}  // namespace ovoid::io
