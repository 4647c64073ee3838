// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Is the file a description of a Zarr array or group, by its name, or a zip file that holds one?
bool is_zarr(const ByteSource& source, std::string_view start);

// Of a folder that is a Zarr hierarchy, the file in it that says so ("a.zarr/.zgroup"); any other
// path as it is. Throws Error(kFileFormat) for a folder called .zarr without such a file.
std::string zarr_description_of(const std::string& path);

// Reads what the file is in: an array, an image of OME-Zarr at one of its resolutions
// (options.block: their paths are the dataset's blocks), or a group's arrays if they are of one
// size (options.array: by path or name). docs/formats.md, "Zarr", says how axes become space, time
// and channels. Throws Error: kFileFormat, kUnsupported, kInvalidArgument that lists what can be
// chosen.
Dataset read_zarr(const ByteSource& source, const ReadOptions& options, const Opener& open);

}  // namespace ovoid::io
