// SPDX-License-Identifier: Apache-2.0
// Volumes in NumPy's archives: what numpy.savez makes of arrays.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/zip_file.h"
#include "io/images/npy_header.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// The name of an array that an entry of an archive holds.
std::string_view npz_array_name(std::string_view entry);

// The header of an entry that is an array; nothing for another one. Little of it is unpacked.
// Throws Error as read_npy_header() does.
std::optional<NpyHeader> npz_header(const ByteSource& source, const ZipEntry& entry);

// Reads the arrays of the archive that are volumes and of one size, those of most samples or of
// options.array; each is taken as read_npy() takes it. Small arrays called spacing, origin,
// direction and affine place them, with a note, unless options.raw.spacing does. Peak memory: the
// arrays, twice where they are packed. Throws Error(kFileFormat) where there is no volume.
Dataset read_npz_volume(const ByteSource& source, const std::vector<ZipEntry>& entries,
                        const ReadOptions& options);

// Throws Error(kUnsupported) that names what a zip file is, where it is another program's.
void refuse_other_zip(const ByteSource& source, const std::vector<ZipEntry>& entries);

}  // namespace ovoid::io
