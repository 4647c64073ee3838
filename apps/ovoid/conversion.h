// SPDX-License-Identifier: Apache-2.0
// What `ovoid convert` and the Python module share: which data are to become of data.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "lattice_flags.h"
#include "ovoid/resample.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// What --size asks for: sides, or one for the longest, of cubes.
struct GridSize {
  std::optional<Index3> dims;
  std::int64_t longest = 0;

  bool is_given() const noexcept { return dims || longest > 0; }
};

struct ConvertFlags {
  DataFlags data;
  ModelFlags model;
  std::string output;
  std::string look_name;
  GridSize size;
  bool as_kernels = false;
  std::optional<TargetLattice> lattice;
  double lattice_spacing = 1.0;
  bool band_limit = true;
  std::optional<double> relevant_above;
  std::string relevant_look;  // a file
  std::optional<double> background_value;
  int threads = 0;
};

// The flags of `ovoid convert`, which set `into`.
Flags make_convert_flags(ConvertFlags* into);

// The dataset as it is to be written: on a grid or another lattice, as kernels, or one array of it,
// or as it is. Throws Error, and UsageError for what does not go with the kind of the data.
Dataset converted(const ConvertFlags& convert, const Flags& flags, const Dataset& dataset,
                  Session& session);

// How a lattice is brought to another, with a line of progress.
LatticeResampleOptions resample_options(const ConvertFlags& convert, Progress& progress,
                                        Session& session);

}  // namespace ovoid::cli
