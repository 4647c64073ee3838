// SPDX-License-Identifier: Apache-2.0
// Compressed pixel data, one frame at a time. RLE is decoded here; JPEG, JPEG-LS and JPEG 2000 by
// GDCM's codecs (foreign/gdcm_codec.h) in the reader's process, which believe a stream's own header
// and allocate by it. So a stream is looked through first: its size and depth must be the file's,
// its markers must lie within it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace ovoid::io {

// Whether a transfer syntax is none of the uncompressed ones.
bool is_compressed_syntax(const std::string& uid) noexcept;

// Why frames of a compressed transfer syntax cannot be read, by this build or at all; empty if
// they can.
std::string unreadable_syntax_reason(const std::string& uid);

// What a frame should be.
struct DicomFrameShape {
  std::string where;  // file and frame, for messages
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  int bits_allocated = 16;  // 8, 16 or 32: the width of the words that come out
};

// How a stream says what it holds.
struct DicomStreamHeader {
  int precision = 0;      // bits of a sample
  bool is_lossy = false;  // as far as it matters to the codec: JPEG of 12 bits
};

enum class DicomCodec { kRle, kJpeg, kJpegLs, kJpeg2000 };

// Decodes a stream that was checked, to samples of one byte up to a precision of 8, else of two in
// the machine's order; gives another number of bytes for one that is damaged. May be called from
// many threads.
using ForeignDicomDecoder = std::vector<char> (*)(DicomCodec codec,
                                                  std::span<const std::byte> stream,
                                                  const DicomFrameShape& shape,
                                                  const DicomStreamHeader& header);

// The process that has other people's codecs names them here.
void set_foreign_dicom_decoder(ForeignDicomDecoder decoder) noexcept;

// Whether frames of this transfer syntax must be decoded in another process than this one.
bool needs_foreign_decoder(const std::string& uid) noexcept;

// Throws Error(kFileFormat) unless the stream begins and goes on as one of the transfer syntax and
// holds a frame of this shape; Error(kUnsupported) for what is sound but is not read.
DicomStreamHeader check_dicom_stream(const std::string& uid, std::span<const std::byte> stream,
                                     const DicomFrameShape& shape);

// Decodes one frame to words of the machine's byte order; `out` has exactly the frame's bytes.
// Bits above the stream's precision are 0 or copies of the sign. Throws Error.
void decode_dicom_frame(const std::string& uid, std::span<const std::byte> stream,
                        const DicomFrameShape& shape, std::span<std::byte> out);

}  // namespace ovoid::io
