// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vtkDataSet.h>
#include <vtkSmartPointer.h>

#include "io/core/byte_source.h"
#include "io/foreign/vtk_header.h"
#include "io/foreign/vtk_reading.h"
#include "ovoid/io.h"

namespace ovoid::io {

// A VTK file of one data set, read.
struct VtkLeaf {
  VtkGrid grid = VtkGrid::kImage;
  vtkSmartPointer<vtkDataSet> data;
  bool has_one_array = false;  // the others have not been read
};

// Reads an XML or a legacy file after checking its header (vtk_header.h); of an XML file only
// options.array, if that is given, and what says which cells are ghosts, but all of polygons whose
// faces are not asked for. Throws Error. Only with VTK.
VtkLeaf read_vtk_leaf(const ByteSource& source, bool is_xml, const ReadOptions& options,
                      VtkRun& run);

// What an XML file says of itself (vtk_header.h), also where its base64 is put right for VTK.
// Throws Error.
VtkOutline outline_of_vtk_xml_leaf(const ByteSource& source);

// "VTU" and so on, or "legacy VTK".
const char* format_of_leaf(VtkGrid grid, bool is_xml) noexcept;

[[noreturn]] void throw_no_array(const ByteSource& source, const std::string& wanted,
                                 const std::vector<std::string>& names);

}  // namespace ovoid::io
