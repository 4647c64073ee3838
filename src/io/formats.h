// SPDX-License-Identifier: Apache-2.0
// What a file is, told from its first bytes, and what a name asks for.
#pragma once

#include <string>
#include <string_view>

namespace ovoid::io {

enum class FileKind {
  kUnknown,
  kNrrd,
  kNpy,
  kNifti,
  kMetaImage,
  kSlc,
  kVtkXml,
  kVtkLegacy,
  kDicom,
  kPly,
  kZip,
  kHdf5,
  kLammpsDump
};

// From the first 512 bytes of a file.
FileKind kind_of(std::string_view start) noexcept;

// The format of a picture that may be a slice of somebody's volume: "TIFF"; empty if it is none.
std::string picture_format_of(std::string_view start);

// The magic of HDF5, whatever is in the file.
bool is_hdf5(std::string_view start) noexcept;

// A format that is recognised but not read, in words for a message ("a NIfTI file"); empty if none
// is.
std::string unsupported_kind_of(std::string_view start);

// The data behind these bytes are compressed so.
bool is_gzip(std::string_view start) noexcept;
bool is_bzip2(std::string_view start) noexcept;

// The lower-case ending with its dot (".nrrd"), with the one before it if it is ".gz" (".nii.gz");
// empty without one. plain_ending_of() leaves out ".gz" and ".bz2" (".nii").
std::string ending_of(const std::string& path);
std::string plain_ending_of(const std::string& path);

}  // namespace ovoid::io
