// SPDX-License-Identifier: Apache-2.0
// Pixel data of DICOM files: from the bytes of a file to samples in memory.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "io/core/byte_source.h"
#include "io/dicom/dicom_file.h"

namespace ovoid::io {

// Reads slices of files: frames, and tiles of frames, whose picture is kept for the next tile.
class DicomSliceReader {
 public:
  // Reads slice `slice` of a file to `out`, which has file.slice_bytes(): words of the machine's
  // byte order, BitsStored bits of each, the rest 0 or copies of the sign. Native pixel data of a
  // frame are read where they belong, without another copy; for compressed ones the stream is in
  // memory besides, for tiles their picture. Throws Error.
  void read(const ByteSource& data, const DicomFile& file, std::size_t slice,
            std::span<std::byte> out);

 private:
  const DicomFile* file_ = nullptr;  // of the picture that is kept
  std::size_t frame_ = 0;
  std::vector<std::byte> picture_;
};

// Whether two slices of one size and type are stored as the same bytes.
bool is_same_dicom_slice(const ByteSource& data_a, const DicomFile& a, std::size_t slice_a,
                         const ByteSource& data_b, const DicomFile& b, std::size_t slice_b);

}  // namespace ovoid::io
