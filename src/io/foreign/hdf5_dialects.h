// SPDX-License-Identifier: Apache-2.0
// HDF5 files that say in words of their own where their arrays are and how they lie. Each reads a
// file that is of its dialect, and returns nothing for another. `file` lists datasets of
// Hdf5Extent::kMaxRank axes. Throw Error.
#pragma once

#include <optional>

#include "io/foreign/hdf5_file.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Adaptive grids in blocks: the cells of those that nothing finer covers, as boxes.
std::optional<Dataset> read_flash(const Hdf5File& file, const ReadOptions& options);
std::optional<Dataset> read_athena(const Hdf5File& file, const ReadOptions& options);

// Microscopes: channels are arrays, time points steps, and options.block takes a resolution, of
// which the finest is read without it.
std::optional<Dataset> read_imaris(const Hdf5File& file, const ReadOptions& options);
std::optional<Dataset> read_big_data_viewer(const Hdf5File& file, const ReadOptions& options);

// Meshes of openPMD: records are arrays, iterations steps. Nothing where a file has particles
// alone.
std::optional<Dataset> read_openpmd(const Hdf5File& file, const ReadOptions& options);

// What is in the file, and why none of it is drawn. Throws Error(kFileFormat), or
// kInvalidArgument where options.array names what is not there.
[[noreturn]] void refuse_hdf5(const Hdf5File& file, const ReadOptions& options);

}  // namespace ovoid::io
