// SPDX-License-Identifier: Apache-2.0
// VTK files of one data set, XML or legacy, through VTK's own readers.
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads the data set that `source`, of XML or legacy, holds, with its point and cell
// arrays of numbers. Images are lattices, and so are rectilinear grids of equal spacing; other
// grids, structured and unstructured, are meshes; polygonal data are particles (mesh_of_parts). The
// header is checked against the file's size before VTK allocates. VTK's messages end up in the
// Error or in notes, never on stderr. Throws Error.
Dataset read_vtk_file(const ByteSource& source, bool is_xml, const ReadOptions& options);

}  // namespace ovoid::io
