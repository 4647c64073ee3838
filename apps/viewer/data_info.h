// SPDX-License-Identifier: Apache-2.0
// What an input is, whatever of it is shown.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/field.h"
#include "settings.h"

namespace ovoid::viewer {

struct ArrayInfo {
  std::string name;
  std::string unit;
  int num_components = 1;
  bool is_cell_data = false;
  ValueRange range;         // of the first component, or of the magnitude if there are several
  int usual_component = 0;  // that is drawn if nobody names one
};

struct DataInfo {
  std::string title;  // of the window
  std::string source;
  DatasetKind kind = DatasetKind::kLattice;
  std::vector<ArrayInfo> arrays;
  std::vector<double> times;  // one per step; the steps' numbers where the input names none
  std::string time_unit;
  bool is_staggered = false;
  std::int64_t step = 0;         // the one that was read first
  bool is_control_mesh = false;  // hexahedra with values per node, at one time
};

// The name of the first file, and how many more there are.
std::string title_of(const cli::DataFlags& data);

std::shared_ptr<const DataInfo> info_of(const Dataset& dataset, const cli::DataFlags& data);

}  // namespace ovoid::viewer
