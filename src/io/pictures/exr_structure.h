// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "io/core/byte_source.h"

namespace ovoid::io {

// Whether a file is a deep picture of scan lines whose attributes and chunks lie within it, and
// unpack to no more than it can hold: OpenEXR allocates what a file claims before it reads on. To
// be asked first. Throws Error(kFileFormat) that says what is wrong, or what else the file is.
void require_deep_structure(const ByteSource& source);

}  // namespace ovoid::io
