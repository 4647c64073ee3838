// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid {

// Bytes that are owned, or borrowed from a caller who keeps them alive through `owner`. Cheap to
// copy, immutable.
struct Bytes {
  std::shared_ptr<const void>
      owner;  // what keeps `view` valid; may be empty for memory that outlives the library's use
  std::span<const std::byte> view;
};

// One named array of a dataset: `num_tuples` tuples of `num_components` values, component fastest.
struct DataArray {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  int num_components = 1;
  std::int64_t num_tuples = 0;
  std::string unit;  // empty if the file names none
  bool is_cell_data = false;
  Bytes bytes;  // num_tuples * num_components * size_of(type), native byte order
  // What a stored number s stands for: s * value_scale + value_offset (NIfTI's slope and intercept,
  // DICOM's rescale). Finite, value_scale not 0. Everything that shows or takes values applies it.
  double value_scale = 1.0;
  double value_offset = 0.0;

  bool is_scaled() const noexcept { return value_scale != 1.0 || value_offset != 0.0; }
};

// One of several volumes that an input holds: a series of a DICOM folder.
struct DatasetBlock {
  std::string name;         // what ReadOptions::block takes
  std::string description;  // one line for people
};

// The patient coordinate system of medical files. World coordinates are the file's own, nothing is
// flipped.
enum class Space { kNone, kLps, kRas };

const char* name_of(Space space) noexcept;  // "none", "LPS", "RAS"

// What a file says, before any choice of kernels. A dataset is one lattice with its arrays. The
// samples' order in memory is x fastest, then y, then z.
struct Dataset {
  std::string source;  // path as given, for messages
  std::string format;  // "NRRD", "VTI", ...
  LatticeGeometry lattice;
  Space space = Space::kNone;
  std::vector<DataArray> arrays;
  std::vector<DatasetBlock> blocks;  // all volumes of the input; empty if it is one
  std::string block;                 // the one that was read; empty if the input is one
  std::int64_t num_steps = 1;        // time steps that the input holds
  std::int64_t step = 0;             // the one that was read
  std::vector<double> times;         // time values of the steps; empty if the file names none
  std::vector<std::string> notes;    // what a reader assumed or found odd, one line each

  // The array called `name`; empty name: the first that varies and is not a "vtk*" bookkeeping
  // array, else the first. Throws Error(kInvalidArgument) naming the arrays that exist. Cost of the
  // default: one pass over the arrays looked at.
  const DataArray& array(const std::string& name = {}) const;
};

}  // namespace ovoid
