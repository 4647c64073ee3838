// SPDX-License-Identifier: Apache-2.0
// Pixel data of DICOM files: from one frame's bytes to samples in memory.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "io/core/byte_source.h"
#include "io/dicom/dicom_file.h"

namespace ovoid::io {

// Reads a frame to `out`, which has file.frame_bytes(): words of the machine's byte order,
// BitsStored bits of each, the rest 0 or copies of the sign. Native pixel data are read where they
// belong, without another copy; for compressed ones the stream is in memory besides. Throws Error.
void read_dicom_frame(const ByteSource& data, const DicomFile& file, std::size_t frame,
                      std::span<std::byte> out);

// Whether two frames of one size and type are stored as the same bytes.
bool is_same_dicom_frame(const ByteSource& data_a, const DicomFile& a, std::size_t frame_a,
                         const ByteSource& data_b, const DicomFile& b, std::size_t frame_b);

}  // namespace ovoid::io
