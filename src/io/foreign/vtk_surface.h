// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// The faces of a PLY file as a mesh of triangles, whatever ReadOptions::faces says, by VTK's
// reader. Throws Error.
Dataset read_ply_faces(const ByteSource& source, const ReadOptions& options);

}  // namespace ovoid::io
