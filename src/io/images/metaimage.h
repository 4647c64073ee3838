// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads a MetaImage volume, .mhd or .mha, of two or three axes and perhaps time; `open` finds
// detached data, whose names are relative to the header's folder. World coordinates are LPS, as ITK
// reads and writes these files; AnatomicalOrientation, which it ignores, is ignored. Throws Error.
Dataset read_metaimage(const ByteSource& source, const ReadOptions& options,
                       const Opener& open = open_file);

}  // namespace ovoid::io
