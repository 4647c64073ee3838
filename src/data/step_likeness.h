// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/series.h"

namespace ovoid::data {

// Throws Error(kInvalidArgument) if a source's times are not num_steps() finite rising numbers.
void check_times(const StepSource& source);

// What the steps of a series have in common, as the first that was read has it.
class StepLikeness {
 public:
  StepLikeness(const Dataset& first, std::int64_t step, SeriesKind series);

  // Throws Error(kFileFormat) naming the step and what differs (Series::step says what may).
  void check(const Dataset& dataset, std::int64_t step) const;

 private:
  struct Array {
    std::string name;
    ScalarType type;
    int num_components;
    bool is_cell_data;
  };

  void check_lattice(const Dataset& dataset, std::int64_t step) const;
  void check_arrays(const Dataset& dataset, std::int64_t step) const;
  [[noreturn]] void fail(const Dataset& dataset, std::int64_t step, const std::string& what) const;

  DatasetKind kind_;
  LatticeGeometry lattice_;
  std::vector<Array> arrays_;
  std::int64_t step_;
  SeriesKind series_;
};

}  // namespace ovoid::data
