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
  kDicom
};

// From the first 512 bytes of a file.
FileKind kind_of(std::string_view start) noexcept;

// A format that is recognised but not read, in words for a message ("a NIfTI file"); empty if none
// is.
std::string unsupported_kind_of(std::string_view start);

// The data behind these bytes are compressed by gzip.
bool is_gzip(std::string_view start) noexcept;

// The lower-case ending with its dot (".nrrd"), with the one before it if it is ".gz" (".nii.gz");
// empty without one.
std::string ending_of(const std::string& path);

}  // namespace ovoid::io
