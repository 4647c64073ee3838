// SPDX-License-Identifier: Apache-2.0
// What several formats are told by: the first bytes of a file, and the ending of its name.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace ovoid::io {

// The data behind these bytes are compressed so.
bool is_gzip(std::string_view start) noexcept;
bool is_bzip2(std::string_view start) noexcept;

// The magic of HDF5, whatever is in the file.
bool is_hdf5(std::string_view start) noexcept;

// A DICOM file with its header: behind a preamble of 128 bytes, which may begin like any other
// file, DICM and an element of the header's group. `start`: at least kDicomStart bytes, if there
// are. Source: [DICOM PS3.10], 7.1.
bool has_dicom_header(std::string_view start) noexcept;
inline constexpr std::size_t kDicomStart = 138;

// The format of a picture that may be a slice of somebody's volume: "TIFF"; empty if it is none, or
// DICOM with such a preamble.
std::string picture_format_of(std::string_view start);

// The lower-case ending with its dot (".nrrd"), with the one before it if it is ".gz" (".nii.gz");
// empty without one. plain_ending_of() leaves out ".gz" and ".bz2" (".nii").
std::string ending_of(const std::string& path);
std::string plain_ending_of(const std::string& path);

}  // namespace ovoid::io
