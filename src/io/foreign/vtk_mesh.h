// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

// NOLINTBEGIN(cppcoreguidelines-virtual-class-destructor): VTK counts references
class vtkDataObject;
class vtkDataSet;
// NOLINTEND(cppcoreguidelines-virtual-class-destructor)

namespace ovoid::io {

// A mesh that VTK has read, of any of its kinds of data sets: nodes, cells, the arrays of numbers
// and a "TimeValue". Arrays share VTK's memory. Node numbers are checked against the nodes, since
// what VTK hands on is what the file says. `notes` gets what is left out. Throws
// Error(kFileFormat). Only with VTK.
MeshPart part_of(const std::string& source, vtkDataSet* data, std::vector<std::string>& notes);

// The same for all leaves of a tree of blocks, or for a single data set. A block is called by its
// name, below others "outer/inner", without one by its number. Empty ones are passed over.
std::vector<MeshPart> parts_of(const std::string& source, vtkDataObject* data,
                               std::vector<std::string>& notes);

}  // namespace ovoid::io
