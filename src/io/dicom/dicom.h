// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads one DICOM file: its frames are the slices. Throws Error.
Dataset read_dicom(const ByteSource& source, const ReadOptions& options);

// Reads the volume that several files hold together, or one of the volumes: options.block, else the
// one with most samples. Files that are no DICOM, or hold nothing that becomes a volume, are passed
// over and counted in a note. `source`: what the user gave, for messages. Throws Error.
Dataset read_dicom(const std::string& source, const std::vector<std::string>& files,
                   const ReadOptions& options, const Opener& open = open_file);

// The files of a folder, sorted by name; hidden ones are left out. If none of them is a DICOM file
// with pixels, those of all folders in it: media keep a directory file on top and the pictures
// below. Throws Error(kFileNotFound, kFileFormat) if the folder cannot be read or there are more
// than 100 000 files.
std::vector<std::string> dicom_files_in(const std::string& folder);

// Whether the file begins like DICOM; false if it cannot be read.
bool is_dicom_file(const std::string& path);

}  // namespace ovoid::io
