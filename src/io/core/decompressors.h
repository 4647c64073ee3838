// SPDX-License-Identifier: Apache-2.0
// zlib and libbz2 behind one shape: `stream` is the library's own, of which next_in, avail_in,
// next_out and avail_out are the caller's; step() consumes input and fills output, as much as it
// can.
#pragma once

#include <bzlib.h>
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "data/out_of_memory.h"

namespace ovoid::io {

// Deflate's longest match is 258 bytes, coded in two bits at best: 1032 to 1 (zlib's technical
// notes).
inline constexpr std::int64_t kMaxDeflateRatio = 1032;

struct Inflater {
  static constexpr const char* kName = "gzip";
  static constexpr int kGzipOrZlib = 15 + 32;       // zlib's window bits: a header of either kind
  static constexpr std::size_t kMemory = 40 << 10;  // at most: its state and a window of 32 KiB
  static constexpr int kBare = -15;                 // none: deflate data as zip files hold them
  z_stream stream{};
  bool ended = false;  // at the end of a member

  explicit Inflater(int window_bits = kGzipOrZlib) {
    if (inflateInit2(&stream, window_bits) != Z_OK) data::throw_out_of_memory("zlib", kMemory);
  }
  ~Inflater() { inflateEnd(&stream); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  bool restart() {
    ended = false;
    return inflateReset(&stream) == Z_OK;
  }
  // Empty if all is well, else what is wrong. Throws Error(kOutOfMemory).
  std::string step() {
    const int status = inflate(&stream, Z_NO_FLUSH);
    ended = status == Z_STREAM_END;
    if (status == Z_OK || status == Z_STREAM_END || status == Z_BUF_ERROR) return {};
    if (status == Z_MEM_ERROR) data::throw_out_of_memory("zlib", kMemory);
    return stream.msg != nullptr   ? stream.msg
           : status == Z_NEED_DICT ? "needs a dictionary"
                                   : "broken";
  }
};

struct Bunzipper {
  static constexpr const char* kName = "bzip2";
  static constexpr std::size_t kMemory = 3'700'000;  // at most, says its manual
  bz_stream stream{};
  bool ended = false;

  Bunzipper() {
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) data::throw_out_of_memory("libbz2", kMemory);
  }
  ~Bunzipper() { BZ2_bzDecompressEnd(&stream); }
  Bunzipper(const Bunzipper&) = delete;
  Bunzipper& operator=(const Bunzipper&) = delete;

  bool restart() {
    char* const next_in = stream.next_in;
    const unsigned avail_in = stream.avail_in;
    BZ2_bzDecompressEnd(&stream);
    stream = {};
    ended = false;
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return false;
    stream.next_in = next_in;
    stream.avail_in = avail_in;
    return true;
  }
  std::string step() {
    const int status = BZ2_bzDecompress(&stream);
    ended = status == BZ_STREAM_END;
    if (status == BZ_OK || status == BZ_STREAM_END) return {};
    if (status == BZ_MEM_ERROR) data::throw_out_of_memory("libbz2", kMemory);
    return "block or checksum broken";
  }
};

}  // namespace ovoid::io
