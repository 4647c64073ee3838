// SPDX-License-Identifier: Apache-2.0
// glTF 2 [glTF 2021]: the scene's triangles, lines and points, where its nodes put them.
#pragma once

#include <string_view>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

bool is_gltf(const ByteSource& source, std::string_view start);  // binary, or by name

// A mesh, with zeros for values; of materials, skins and animations nothing is read. Throws Error:
// kFileFormat that names what is not there, or longer than what it lies in; kUnsupported for
// compressed geometry.
Dataset read_gltf(const ByteSource& source, const ReadOptions& options, const Opener& open);

}  // namespace ovoid::io
