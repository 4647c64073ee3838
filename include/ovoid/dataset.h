// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
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
  std::vector<double> times;       // time values of the steps; empty if the data has no time
  std::vector<std::string> notes;  // what a reader assumed or found odd, one line each

  // The array called `name`; empty name: the first that varies and is not a "vtk*" bookkeeping
  // array, else the first. Throws Error(kInvalidArgument) naming the arrays that exist. Cost of the
  // default: one pass over the arrays looked at.
  const DataArray& array(const std::string& name = {}) const;
};

}  // namespace ovoid
