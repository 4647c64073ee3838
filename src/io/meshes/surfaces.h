// SPDX-License-Identifier: Apache-2.0
// Files of triangles and polygons, which stand in a scene beside a field: STL and OBJ.
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Meshes of triangles, with zeros for values; polygons become fans, a corner for each mention. Of
// OBJ files v and f count: neither materials, curves nor lines. Peak memory is that of the mesh.
// Throw Error(kFileFormat) that names the line, or the bytes that are missing.
Dataset read_stl(const ByteSource& source, const ReadOptions& options);
Dataset read_obj(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
