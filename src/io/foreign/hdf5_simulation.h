// SPDX-License-Identifier: Apache-2.0
// What an HDF5 file of particles says of the simulation that wrote it: which snapshot it is part
// of, what its smoothing lengths mean, which factors are left to the reader.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "data/kernels/smoothing_codes.h"

namespace ovoid::io {

// Of a file that is one of several.
struct SnapshotHeader {
  std::int64_t num_files = 1;
  std::vector<double> totals;    // particles in all files by type; empty if it does not say
  std::vector<double> identity;  // what all files of a snapshot have the same, totals among it
};

// Nothing for a file that is a snapshot by itself, or none, or is not there. Throws
// Error(kFileFormat) for a number of files that no snapshot has.
std::optional<SnapshotHeader> snapshot_header(const std::string& path);

// Whose smoothing lengths those called `name` are, of particles in `group`: of Gadget and its
// descendants, or of SWIFT with the kernel that it names, else the cubic spline with `is_sure`
// false. Nothing for other codes.
struct CodeFound {
  data::SmoothingCode code;
  bool is_sure = true;
};
std::optional<CodeFound> smoothing_code(const std::string& path, const std::string& group,
                                        const std::string& name);

// Which factors of cosmology are left to the reader, in words; empty if none are.
std::string cosmology_text(const std::string& path);

}  // namespace ovoid::io
