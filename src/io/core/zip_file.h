// SPDX-License-Identifier: Apache-2.0
// As much of zip as NPZ files need: entries that are stored or deflated, also with 64-bit sizes.
// Source: PKWARE's APPNOTE.TXT [docs/references.md].
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/atomic_file.h"
#include "io/core/byte_source.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// A file within the file. Offsets and sizes are checked against the whole file.
struct ZipEntry {
  std::string name;
  bool is_deflated = false;
  std::uint32_t crc = 0;
  std::int64_t offset = 0;       // of its local header
  std::int64_t packed_size = 0;  // in the file
  std::int64_t size = 0;         // unpacked; at most what deflate can make of packed_size
};

// From the directory at the end of the file; folders are left out. Throws Error: kFileFormat;
// kUnsupported for encryption, other compressions and archives of several files.
std::vector<ZipEntry> read_zip_entries(const ByteSource& source);

// An entry's bytes: of a stored one a view of the file, else unpacked in memory. `source` must
// outlive it. The checksum of an unpacked one is verified.
struct ZipMember {
  Bytes unpacked;
  std::unique_ptr<ByteSource> source;  // its name is "FILE: ENTRY"
};
ZipMember open_zip_entry(const ByteSource& source, const ZipEntry& entry);

// The first `count` bytes of an entry, or as many as there are before its end or damage: to see
// what it is without unpacking all of it. Throws Error(kFileFormat).
std::string zip_entry_start(const ByteSource& source, const ZipEntry& entry, std::int64_t count);

// Writes entries, stored, one behind the other.
class ZipWriter {
 public:
  explicit ZipWriter(AtomicFile& file) : file_(file) {}

  // An entry of two pieces. Throws Error(kFileWrite).
  void add(const std::string& name, std::string_view head, std::span<const std::byte> rest);
  // The directory; nothing may be added afterwards.
  void finish();

 private:
  void write(std::string_view bytes);

  AtomicFile& file_;
  std::vector<ZipEntry> entries_;
  std::int64_t position_ = 0;
};

}  // namespace ovoid::io
