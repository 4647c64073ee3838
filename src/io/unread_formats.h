// SPDX-License-Identifier: Apache-2.0
// Well known formats that are not read: what a file is, and what makes a file of it that is read.
#pragma once

#include <string>
#include <string_view>

#include "io/core/byte_source.h"

namespace ovoid::io {

// "is Zeiss CZI, which is not read: expected ..." for a file that begins, or is called, like one of
// those formats; empty for others. `start`: its first bytes, as stored.
std::string unread_format_of(const ByteSource& source, std::string_view start);

// The same of files in HDF5 or netCDF, told by their name: their dialects' words are not read.
std::string unread_dialect_of(const std::string& path);

// The same of a folder, by the files in it.
std::string unread_folder_of(const std::string& path);

}  // namespace ovoid::io
