// SPDX-License-Identifier: Apache-2.0
// How the bytes of a Zarr chunk are packed: the codecs of numcodecs and of Zarr's version 3.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace ovoid::io {

enum class ZarrCodec { kNone, kGzip, kBzip2, kBlosc, kZstd, kLz4 };

struct ZarrPacking {
  ZarrCodec codec = ZarrCodec::kNone;
  bool has_checksum = false;  // CRC-32C behind the packed bytes
};

// By the names of numcodecs and of Zarr's version 3; gzip stands for zlib, too. Throws
// Error(kUnsupported) for one that is not read.
ZarrCodec zarr_codec_called(const std::string& where, const std::string& name);

// Unpacks into `out`, which is what a chunk takes. `where` names the chunk. Throws
// Error(kFileFormat) for what is damaged or has another size; kOutOfMemory.
void unpack_zarr_chunk(const std::string& where, std::span<const std::byte> packed,
                       const ZarrPacking& packing, std::span<std::byte> out);

}  // namespace ovoid::io
