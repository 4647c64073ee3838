// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// What a name such as "scans/foot_256x256x128_uint8.raw" says; spacing and byte order stay open.
// Empty members for a name that does not follow the convention
// <anything>_<X>x<Y>x<Z>_<type>[_<anything>].<ending>[.gz].
RawOptions parse_raw_name(const std::string& path);

// Reads a file that is nothing but samples, x fastest. Dimensions and type come from options.raw,
// else from the name. The file must hold exactly them, or if its name ends in .gz, gzip data of
// them. Throws Error.
Dataset read_raw(const ByteSource& source, const ReadOptions& options);

// Writes the bytes of the array, native order. Throws Error(kFileWrite).
void write_raw(const DataArray& array, const std::string& path, const std::stop_token& stop = {});

}  // namespace ovoid::io
