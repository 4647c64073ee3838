// SPDX-License-Identifier: Apache-2.0
// PLOT3D: curvilinear grids in one file, the flow on them in another (P. P. Walatka, P. G. Buning
// and others, PLOT3D User's Manual, NASA TM-101067, 1990). Binary, three-dimensional, either byte
// order, with and without Fortran's record marks, one grid or several, float32 or float64, with and
// without IBLANK. The files say none of this: it is what their sizes allow.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

enum class Plot3dContent { kGrid, kSolution };

struct Plot3dLayout {
  bool is_big_endian = false;
  bool has_marks = false;    // each record lies between two counts of its bytes
  bool is_multiple = false;  // begins with the number of grids
  bool is_double = false;
  bool has_iblank = false;  // grids: an integer per node, 0 where there is none
  std::vector<Index3> dims;
  std::vector<std::int64_t> offsets;  // of each grid's first number; solutions: of its four numbers
  std::int64_t num_padding = 0;       // zeros behind the last record
};

// The layout in which the file has exactly the bytes it needs (or up to 4 KiB of zeros more), and
// all record marks are right; empty if there is none. Looks at the header alone.
std::optional<Plot3dLayout> find_plot3d(const ByteSource& source, Plot3dContent content);

// A grid and its solutions, which are its time steps. Arrays: Density, Momentum, StagnationEnergy;
// from them Pressure and VelocityMagnitude (perfect gas of gamma 1.4, in the file's own units).
// Throws Error(kFileFormat) naming the file that does not fit.
Dataset read_plot3d(const std::string& grid_path, const std::vector<std::string>& solution_paths,
                    const ReadOptions& options);

// Throws Error(kFileFormat) if the file is half of a dataset: a grid, or a solution.
void refuse_lone_plot3d(const ByteSource& source);

}  // namespace ovoid::io
