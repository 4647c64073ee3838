// SPDX-License-Identifier: Apache-2.0
// A volume in pictures, one for each slice.
#pragma once

#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Whether the file is a picture that may be a slice: a PNG, a JPEG, a TIFF of one page. False if it
// cannot be read.
bool is_slice_file(const std::string& path);

// The files of a folder, not of those below, that are pictures which may be slices; hidden ones are
// left out. Throws Error(kFileNotFound) if it cannot be read.
std::vector<std::string> slice_files_in(const std::string& folder);

// Whether a folder is read as slices: there are such pictures in it, and it holds no DICOM, which
// goes before them. False for what is no folder.
bool is_slice_folder(const std::string& path);

// Reads the slices that a folder holds, or the files named, in the order of the numbers in their
// names (slice_names.h), the lowest at z = 0. All must have one size and type. Colours become three
// components, unless all pixels are grey. The spacing is options.raw.spacing, or what the files
// say, or 1. Peak memory is the volume, three of it where grey is stored as colour, and a
// file for each thread. Throws Error: kFileFormat naming the file that is damaged, kInvalidArgument
// naming the one that does not fit the others, kUnsupported for another file than a picture among
// them.
Dataset read_slice_folder(const std::string& folder, const ReadOptions& options);
Dataset read_slice_files(const std::vector<std::string>& paths, const ReadOptions& options);

}  // namespace ovoid::io
