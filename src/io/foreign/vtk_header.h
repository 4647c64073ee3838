// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// VTK's readers believe what a file claims and allocate it. These look at the file first, without
// VTK, and throw where it cannot hold what it says: Error(kFileFormat) naming file, array, what is
// stored and what is needed; Error(kUnsupported) if the file is well-formed but no image. Nothing
// is allocated in proportion to a claim. A file that passes may still be broken inside.

enum class VtkGrid { kImage, kRectilinear, kStructured, kUnstructured, kPolyData };

// XML files of one data set (.vti .vtr .vts .vtu .vtp): extents, pieces and their numbers of points
// and cells, numbers of an image's place, what every stored array states and whether its bytes or
// numbers are there, and the ratios its compressor can reach. The node numbers of cells are counted
// (where no compressor hides them, their last offset is read), but not looked at.
VtkGrid check_vtk_xml(const ByteSource& source);

// What such a file says of itself, checked as check_vtk_xml() does.
struct VtkOutline {
  VtkGrid grid = VtkGrid::kImage;
  std::int64_t num_points = 0;
  std::int64_t num_cells = 0;
  std::vector<DataArray> arrays;  // of numbers, of points and cells, without bytes
  bool is_plain = true;  // false: has several pieces, or arrays without a name of their own
};
VtkOutline grid_outline_of_vtk_xml(const ByteSource& source);

// Legacy files (.vtk) of the same kinds: dimensions, numbers of points and cells, and every array
// to the end.
VtkGrid check_legacy_vtk(const ByteSource& source);

}  // namespace ovoid::io
