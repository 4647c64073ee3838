// SPDX-License-Identifier: Apache-2.0
// VTK's XML files that name other files: pieces (.pvtu .pvtp .pvts .pvtr), blocks (.vtm), adaptive
// grids (.vth .vthb) and time series (.pvd).
#pragma once

#include <string>

#include "io/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Is this what the root of such a file says it is (vtk_xml_type)?
bool is_vtk_set(const std::string& xml_type) noexcept;

// Reads the files it names, each checked as it would be alone. Names count from the file's folder.
// Pieces and blocks become one mesh (mesh_of_parts), adaptive grids boxes, and of a time series one
// step is read. At most 10 000 files, sets within sets 8 deep. Throws Error; kUnsupported without
// VTK.
Dataset read_vtk_set(const ByteSource& source, const std::string& xml_type,
                     const ReadOptions& options);

}  // namespace ovoid::io
