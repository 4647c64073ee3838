// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

// NOLINTBEGIN(cppcoreguidelines-virtual-class-destructor): VTK counts references
class vtkAlgorithm;
class vtkDataSet;
// NOLINTEND(cppcoreguidelines-virtual-class-destructor)

namespace ovoid::io {

// Reads one step of a VTK reader that is ready but for Update(), whose blocks are the dataset's.
// `set_up` runs once its information is there. `rename`, if given, makes a block's name from VTK's.
// Throws Error. Only with VTK.
Dataset read_timed(const ByteSource& source, const std::string& format, vtkAlgorithm* reader,
                   const ReadOptions& options, const std::function<void()>& set_up = {},
                   const std::function<std::string(const std::string&)>& rename = {});

// An image or a rectilinear grid of equal spacing as a lattice, with its ghost arrays
// (io/vtk/image_ghosts.h), everything else as a mesh.
// `dataset` has source, format and notes. In vtk_image.cpp.
Dataset dataset_of(const ByteSource& source, vtkDataSet* data, Dataset dataset,
                   const ReadOptions& options);

}  // namespace ovoid::io
