// SPDX-License-Identifier: Apache-2.0
// Two functions of OpenVDB's, which stand before those of its library in the program that this is
// linked into. A block of voxels is preceded by the bytes that it takes in the file: below 0 if it
// is not packed. OpenVDB 10 believes that number, writes so much behind the memory of a node, and
// compares then. Here it is compared first.
#include <blosc.h>
#include <fmt/format.h>
#include <openvdb/Exceptions.h>
#include <openvdb/io/Compression.h>
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <istream>
#include <string>
#include <vector>

namespace {

// Unpacks all of `packed` to `num_bytes` bytes at `to`, and no more. Does it hold so many?
using UnpackBlock = bool (*)(const std::vector<char>& packed, char* to, std::size_t num_bytes);

// What no packed block of so many bytes is longer than; a writer keeps those that do not shrink as
// they are.
std::size_t most_packed(std::size_t num_bytes) { return num_bytes + num_bytes / 64 + 1024; }

void read_block(std::istream& stream, char* to, std::size_t num_bytes, UnpackBlock unpack) {
  std::int64_t told = 0;
  stream.read(reinterpret_cast<char*>(&told), sizeof(told));
  if (!stream) throw openvdb::IoError("the voxels end too soon");
  const bool is_packed = told > 0;
  // Not by negation: the least number has none.
  const std::uint64_t stored =
      is_packed ? static_cast<std::uint64_t>(told) : 0 - static_cast<std::uint64_t>(told);
  if (is_packed ? stored > most_packed(num_bytes) : stored != num_bytes) {
    throw openvdb::IoError(
        fmt::format("a block of {} bytes of voxels claims {} in the file", num_bytes, stored));
  }
  if (to == nullptr) {  // passed over
    stream.seekg(static_cast<std::streamoff>(stored), std::ios_base::cur);
    return;
  }
  if (!is_packed) {
    stream.read(to, static_cast<std::streamsize>(num_bytes));
    if (!stream) throw openvdb::IoError("the voxels end too soon");
    return;
  }
  std::vector<char> packed(stored);
  stream.read(packed.data(), static_cast<std::streamsize>(stored));
  if (!stream) throw openvdb::IoError("the voxels end too soon");
  if (!unpack(packed, to, num_bytes)) throw openvdb::IoError("packed voxels are damaged");
}

bool unpack_zip(const std::vector<char>& packed, char* to, std::size_t num_bytes) {
  uLongf size = num_bytes;
  return uncompress(reinterpret_cast<Bytef*>(to), &size,
                    reinterpret_cast<const Bytef*>(packed.data()), packed.size()) == Z_OK &&
         size == num_bytes;
}

bool unpack_blosc(const std::vector<char>& packed, char* to, std::size_t num_bytes) {
  std::size_t size = 0;
  return blosc_cbuffer_validate(packed.data(), packed.size(), &size) == 0 && size == num_bytes &&
         blosc_decompress_ctx(packed.data(), to, num_bytes, 1) == static_cast<int>(num_bytes);
}

}  // namespace

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {
namespace io {

void unzipFromStream(std::istream& stream, char* to, std::size_t num_bytes) {
  read_block(stream, to, num_bytes, unpack_zip);
}

void bloscFromStream(std::istream& stream, char* to, std::size_t num_bytes) {
  read_block(stream, to, num_bytes, unpack_blosc);
}

}  // namespace io
}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb
