// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// VTK's readers believe what a file claims and allocate it. These look at the file first, without
// VTK, and throw where it cannot hold what it says: Error(kFileFormat) naming file, array, what is
// stored and what is needed; Error(kUnsupported) if the file is well-formed but no image. Nothing
// is allocated in proportion to a claim. A file that passes may still be broken inside.

enum class VtkGrid { kImage, kRectilinear, kStructured, kUnstructured, kPolyData };

// An array of points or cells that holds text.
struct VtkTextArray {
  std::string name;
  bool is_cell_data = false;
};

// What an XML file of one data set says of itself.
struct VtkOutline {
  VtkGrid grid = VtkGrid::kImage;
  std::int64_t num_points = 0;
  std::int64_t num_cells = 0;
  std::vector<DataArray> arrays;  // of numbers, of points and cells, without bytes
  std::vector<VtkTextArray> texts;
  bool is_plain = true;  // false: has several pieces, or arrays without a name of their own
};

// Checks such files (.vti .vtr .vts .vtu .vtp): extents, pieces and their numbers of points
// and cells, numbers of an image's place, what every stored array states and whether its bytes or
// numbers are there, and the ratios its compressor can reach. The node numbers of cells are counted
// (where no compressor hides them, their last offset is read), but not looked at. Text is not
// looked at: VTK is to leave `texts` out.
VtkOutline check_vtk_xml(const ByteSource& source);

// Legacy files (.vtk) of the same kinds: dimensions, numbers of points and cells, and every array
// to the end.
VtkGrid check_legacy_vtk(const ByteSource& source);

}  // namespace ovoid::io
