// SPDX-License-Identifier: Apache-2.0
// Files of surfaces, which fill no volume and stand in a scene beside a field. All by VTK's
// readers.
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Throws Error(kFileFormat) unless the file is as long as its number of triangles says, or text.
void check_stl(const ByteSource& source);

// The faces as a mesh of triangles, whatever ReadOptions::faces says; nodes at one place are one.
// Throw Error.
Dataset read_stl(const ByteSource& source, const ReadOptions& options);
Dataset read_obj(const ByteSource& source, const ReadOptions& options);
Dataset read_ply_faces(const ByteSource& source, const ReadOptions& options);
Dataset read_gltf(const ByteSource& source, const ReadOptions& options);  // of all its meshes

}  // namespace ovoid::io
