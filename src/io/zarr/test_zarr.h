// SPDX-License-Identifier: Apache-2.0
// Zarr stores for tests: descriptions, packed chunks, and zip files of them.
#pragma once

#include <blosc.h>
#include <bzlib.h>
#include <lz4.h>
#include <zstd.h>

#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <utility>

#include "io/core/test_deflate.h"

namespace ovoid::io {

using ZarrFiles = std::map<std::string, std::string>;  // keys and values

inline std::string with_blosc(const std::string& bytes, const char* compressor, int shuffle,
                              std::size_t item_size) {
  std::string packed(bytes.size() + BLOSC_MAX_OVERHEAD, '\0');
  const int size = blosc_compress_ctx(5, shuffle, item_size, bytes.size(), bytes.data(),
                                      packed.data(), packed.size(), compressor, 0, 1);
  packed.resize(static_cast<std::size_t>(size));
  return packed;
}

inline std::string with_zstd(const std::string& bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 1));
  return packed;
}

// The size in front, as numcodecs writes it.
inline std::string with_lz4(const std::string& bytes) {
  std::string packed(
      4 + static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(bytes.size()))), '\0');
  const auto size = static_cast<std::uint32_t>(bytes.size());
  std::memcpy(packed.data(), &size, sizeof size);
  const int end = LZ4_compress_default(bytes.data(), packed.data() + 4, static_cast<int>(size),
                                       static_cast<int>(packed.size() - 4));
  packed.resize(4 + static_cast<std::size_t>(end));
  return packed;
}

inline std::string with_bzip2(const std::string& bytes) {
  std::string packed(bytes.size() + 1000, '\0');
  auto size = static_cast<unsigned>(packed.size());
  BZ2_bzBuffToBuffCompress(packed.data(), &size, const_cast<char*>(bytes.data()),
                           static_cast<unsigned>(bytes.size()), 9, 0, 0);
  packed.resize(size);
  return packed;
}

// A description of version 2. Lists are JSON: "[4, 3, 2]".
struct TestZarray {
  std::string shape = "[2, 3, 4]", chunks = "[2, 2, 2]", dtype = "|u1";
  std::string compressor = "null", fill = "0", order = "C", separator = ".", filters = "null";
};

inline std::string zarray(const TestZarray& array) {
  return R"({"zarr_format": 2, "shape": )" + array.shape + R"(, "chunks": )" + array.chunks +
         R"(, "dtype": ")" + array.dtype + R"(", "compressor": )" + array.compressor +
         R"(, "fill_value": )" + array.fill + R"(, "order": ")" + array.order +
         R"(", "filters": )" + array.filters + R"(, "dimension_separator": ")" + array.separator +
         R"("})";
}

inline constexpr const char* kZgroup = R"({"zarr_format": 2})";

// A zip file of stored entries, as far as readers look at it.
inline std::string zip_of(const ZarrFiles& files) {
  std::string bytes, directory;
  const auto put = [](std::string& out, std::uint64_t value, int size) {
    for (int i = 0; i < size; ++i) out += static_cast<char>(value >> (8 * i) & 255);
  };
  for (const auto& [name, value] : files) {
    const std::size_t offset = bytes.size();
    const auto checksum =
        crc32(0, reinterpret_cast<const Bytef*>(value.data()), static_cast<uInt>(value.size()));
    std::string common;  // version, flags, stored, time, date, sum, sizes, lengths
    put(common, 20, 2);
    common += std::string(8, '\0');
    put(common, checksum, 4);
    put(common, value.size(), 4);
    put(common, value.size(), 4);
    put(common, name.size(), 2);
    put(common, 0, 2);
    bytes += "PK\x03\x04" + common + name + value;
    directory += "PK\x01\x02";
    put(directory, 20, 2);
    directory += common;
    directory += std::string(10, '\0');  // comment, disk, attributes
    put(directory, offset, 4);
    directory += name;
  }
  const std::size_t begin = bytes.size();
  bytes += directory + "PK\x05\x06";
  put(bytes, 0, 4);
  put(bytes, files.size(), 2);
  put(bytes, files.size(), 2);
  put(bytes, directory.size(), 4);
  put(bytes, begin, 4);
  put(bytes, 0, 2);
  return bytes;
}

}  // namespace ovoid::io
