// SPDX-License-Identifier: Apache-2.0
// Snapshots of simulations in several files, by their names: snap_000.0.hdf5, snap_000.1.hdf5 ...
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"

namespace ovoid::io {

// "run/snap_000.12.hdf5" is "run/snap_000", 12 and ".hdf5"; the ending may be empty.
struct SnapshotPart {
  std::string stem;
  std::int64_t number = 0;
  std::string ending;

  std::string path(std::int64_t of_number) const;  // of another part
};

// Nothing for another name. Codes write the numbers without zeros in front.
std::optional<SnapshotPart> snapshot_part(const std::string& path);

// The files of that name with other numbers, which lie in its folder, or where it is a link to;
// whether they are parts of the same snapshot is for the reader to see. None for another name.
std::vector<std::string> snapshot_siblings(const ByteSource& source);

}  // namespace ovoid::io
