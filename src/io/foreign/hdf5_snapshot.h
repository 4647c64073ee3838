// SPDX-License-Identifier: Apache-2.0
// Snapshots of simulations in several HDF5 files (NumFilesPerSnapshot of Gadget and its
// descendants): which files belong together, and their particles as one dataset.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/foreign/hdf5_simulation.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Files that are one step.
struct Snapshot {
  std::string source;              // the one that is named first
  std::vector<std::string> files;  // of parts in the order of their numbers
  std::int64_t num_named = 0;      // of these; the others were found beside them
  std::vector<std::string> missing;
  std::optional<SnapshotHeader> header;  // of parts
};

// Sorts files into snapshots, in the order in which they are first named. Files that say to be
// parts of one belong together by their names (snapshot_part()), others by what their headers have
// the same; a file that says nothing is a step by itself. Parts beside those that are named join
// them. Throws Error(kFileFormat).
std::vector<Snapshot> sort_snapshots(const std::vector<std::string>& paths);

// Particles of one kind of a snapshot in parts: as read_hdf5_points() reads a file. Parts that hold
// none of them are passed over, arrays that not all others have are left out with a note, and so
// are parts that are missing. Peak memory is that of the rows, and of one array again.
Dataset read_snapshot(const Snapshot& snapshot, const ReadOptions& options);

}  // namespace ovoid::io
