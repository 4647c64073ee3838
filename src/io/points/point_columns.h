// SPDX-License-Identifier: Apache-2.0
// The columns of a table of points, by their names: which hold the positions, and which belong
// together as one array.
#pragma once

#include <cstdint>
#include <span>
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
  bool is_empty = false;  // as far as it was looked at: without a name it is left out, with a note
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
    double factor = 1;  // -1: a depth, which is counted downwards
  };
  std::vector<Array> arrays;    // the first one is the positions
  std::vector<Target> targets;  // of each column
  bool is_flat = false;         // no column holds z, which is 0
};

// Finds the positions, whatever the case and the units in brackets. In this order:
//   x y z; the same with a word such as Points, pos, coordinate or centroid before or behind the
//   letter ("x-coordinate", "pos_x", "X Location"); NAME:0 NAME:1 NAME:2 with such a name; x_mm;
//   x and y, longitude and latitude or easting and northing in the horizontal plane, with altitude,
//   height or elevation, or with depth, which counts downwards, or flat (not x and y without z, if
//   there are px py pz); px py pz;
//   else the first three columns of numbers that are neither numbers of points nor times.
// A note tells which were taken, unless they say so by themselves. Columns NAME:0, NAME:1 ... in a
// row become one array. Throws Error(kFileFormat) naming `where` for fewer than three columns of
// numbers, and for a column of positions that holds text.
PointLayout lay_out_points(const std::string& where, const std::vector<PointColumn>& columns,
                           std::vector<std::string>& notes);

// Does one of these rules but the last find positions?
bool has_position_names(const std::vector<PointColumn>& columns);

// "x[kpc]" and "x (kpc)" into name and unit; "T (K) @ t=1" is "T @ t=1" in K.
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

  // Makes places of `positions`, rows of three numbers: turns what counts downwards, and fills the
  // third of flat ones.
  static void place(const PointLayout& layout, std::span<double> positions);

 private:
  PointLayout layout_;
  std::vector<SampleBuffer> buffers_;
  std::int64_t num_rows_ = 0;
};

}  // namespace ovoid::io
