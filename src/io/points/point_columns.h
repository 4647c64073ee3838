// SPDX-License-Identifier: Apache-2.0
// The columns of a table of points, by their names: which hold the positions, and which belong
// together as one array.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/core/samples.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// One column as the file has it.
struct PointColumn {
  std::string name;
  bool is_number = true;  // text is left out, with a note
};

// Where the columns go.
struct PointLayout {
  struct Array {
    std::string name;
    std::string unit;
    int num_components = 1;
  };
  struct Target {
    int array = -1;  // index into `arrays`; -1: left out
    int component = 0;
  };
  std::vector<Array> arrays;    // the first one is the positions
  std::vector<Target> targets;  // of each column
};

// Finds the positions: x y z, the units in brackets aside; else NAME:0 NAME:1 NAME:2 or NAME_0 ...
// with a name such as Points; else pos_x pos_y pos_z and the like; case does not matter. Without
// any, or where the columns have no names, the first three columns of numbers are taken, with a
// note. NAME:0, NAME:1 ... in a row become one array. Throws Error(kFileFormat) naming `where` for
// fewer than three columns of numbers.
PointLayout lay_out_points(const std::string& where, const std::vector<PointColumn>& columns,
                           std::vector<std::string>& notes);

// "x[kpc]" and "x (kpc)" into name and unit.
struct NameAndUnit {
  std::string name;
  std::string unit;
};
NameAndUnit split_unit(std::string_view text);

// Is it how files call positions: "Coordinates", "pos", "xyz" ...? Case does not matter.
bool is_position_name(std::string_view name);

// Numbers of the columns, row by row, on their way into a dataset of particles.
class PointTable {
 public:
  // Throws Error(kOutOfMemory), as all that grows.
  explicit PointTable(PointLayout layout);

  // Room for `count` more rows; at most as many numbers may then be put into every column.
  void extend(std::int64_t count);
  // Takes back the last `count` rows.
  void shrink(std::int64_t count);
  std::int64_t num_rows() const noexcept { return num_rows_; }

  // Where the number of `row` in `column` goes, rows `stride` numbers apart; nullptr for a column
  // that is left out. Valid until the next extend().
  struct Slot {
    double* first = nullptr;
    std::size_t stride = 0;
  };
  Slot slot(std::size_t column, std::int64_t row);

  // As positions and arrays of `dataset`, which becomes one of particles.
  void release(Dataset& dataset);

 private:
  PointLayout layout_;
  std::vector<SampleBuffer> buffers_;
  std::int64_t num_rows_ = 0;
};

}  // namespace ovoid::io
