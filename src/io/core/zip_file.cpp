// SPDX-License-Identifier: Apache-2.0
#include "io/core/zip_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "data/names_text.h"
#include "io/core/decompressors.h"
#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::uint32_t kLocalHeader = 0x04034b50;
constexpr std::uint32_t kCentralHeader = 0x02014b50;
constexpr std::uint32_t kEndOfDirectory = 0x06054b50;
constexpr std::uint32_t kEndOfDirectory64 = 0x06064b50;
constexpr std::uint32_t kLocatorOfEnd64 = 0x07064b50;
constexpr std::int64_t kLocalSize = 30, kCentralSize = 46, kEndSize = 22, kEnd64Size = 56,
                       kLocator64Size = 20;
constexpr std::int64_t kMaxZipComment = 65535;
constexpr std::int64_t kMaxZipDirectory = std::int64_t{64} << 20;
constexpr std::uint32_t kIn64 = 0xffffffff;  // the number stands in the extra field of 64 bits
constexpr unsigned kStored = 0, kDeflated = 8;

[[noreturn]] void fail_zip(const ByteSource& source, const std::string& what,
                           ErrorCode code = ErrorCode::kFileFormat) {
  throw Error(code, fmt::format("{}: zip: {}", source.name(), what));
}

// A number at `offset`, which the caller has checked; zip is little endian.
template <typename T>
T zip_number(std::string_view bytes, std::size_t offset) {
  return number_at<T>(bytes.data() + offset, false);
}

template <typename T>
void put_zip_number(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xff);
}

struct ZipDirectory {
  std::uint64_t count = 0;
  std::uint64_t size = 0;
  std::uint64_t offset = 0;
};

std::optional<ZipDirectory> read_end64(const ByteSource& source, std::int64_t end_offset) {
  if (end_offset < kLocator64Size) return std::nullopt;
  const std::string locator = source.text(end_offset - kLocator64Size, kLocator64Size);
  if (zip_number<std::uint32_t>(locator, 0) != kLocatorOfEnd64) return std::nullopt;
  const auto offset = zip_number<std::uint64_t>(locator, 8);
  if (offset > static_cast<std::uint64_t>(source.size() - kEnd64Size) || source.size() < kEnd64Size)
    fail_zip(source, "the 64-bit directory lies outside the file");
  const std::string end = source.text(static_cast<std::int64_t>(offset), kEnd64Size);
  if (zip_number<std::uint32_t>(end, 0) != kEndOfDirectory64)
    fail_zip(source, "the 64-bit directory is not where it should be");
  return ZipDirectory{zip_number<std::uint64_t>(end, 32), zip_number<std::uint64_t>(end, 40),
                      zip_number<std::uint64_t>(end, 48)};
}

ZipDirectory find_directory(const ByteSource& source) {
  const std::int64_t tail_size = std::min(source.size(), kEndSize + kMaxZipComment);
  const std::string tail = source.text(source.size() - tail_size, tail_size);
  for (std::int64_t at = tail_size - kEndSize; at >= 0; --at) {
    const auto begin = static_cast<std::size_t>(at);
    if (tail[begin] != 'P' || zip_number<std::uint32_t>(tail, begin) != kEndOfDirectory) continue;
    if (at + kEndSize + zip_number<std::uint16_t>(tail, begin + 20) > tail_size) continue;
    if (const auto end64 = read_end64(source, source.size() - tail_size + at)) return *end64;
    if (zip_number<std::uint16_t>(tail, begin + 4) != 0)
      fail_zip(source, "is one of several files of an archive", ErrorCode::kUnsupported);
    return {zip_number<std::uint16_t>(tail, begin + 10),
            zip_number<std::uint32_t>(tail, begin + 12),
            zip_number<std::uint32_t>(tail, begin + 16)};
  }
  fail_zip(source, "has no directory at its end: is the file truncated?");
}

// The 64-bit numbers of an entry, where its 32-bit ones say so, in the order of the format.
void apply_extra64(const ByteSource& source, std::string_view extra,
                   std::uint64_t* const (&in)[3]) {
  while (extra.size() >= 4) {
    const auto id = zip_number<std::uint16_t>(extra, 0);
    const std::size_t size = zip_number<std::uint16_t>(extra, 2);
    if (size > extra.size() - 4) break;
    std::string_view field = extra.substr(4, size);
    extra.remove_prefix(4 + size);
    if (id != 1) continue;
    for (std::uint64_t* const number : in) {
      if (*number != kIn64) continue;
      if (field.size() < 8) fail_zip(source, "an entry's 64-bit sizes are missing");
      *number = zip_number<std::uint64_t>(field, 0);
      field.remove_prefix(8);
    }
    return;
  }
}

// The entry at the front of the rest of the directory, which is shortened by it.
ZipEntry take_entry(const ByteSource& source, std::string_view& rest) {
  if (rest.size() < static_cast<std::size_t>(kCentralSize) ||
      zip_number<std::uint32_t>(rest, 0) != kCentralHeader)
    fail_zip(source, "the directory is broken");
  const std::size_t name_size = zip_number<std::uint16_t>(rest, 28);
  const std::size_t extra_size = zip_number<std::uint16_t>(rest, 30);
  const std::size_t comment_size = zip_number<std::uint16_t>(rest, 32);
  if (kCentralSize + name_size + extra_size + comment_size > rest.size())
    fail_zip(source, "the directory is broken");
  ZipEntry entry;
  entry.name = rest.substr(kCentralSize, name_size);
  const auto flags = zip_number<std::uint16_t>(rest, 8);
  const auto method = zip_number<std::uint16_t>(rest, 10);
  entry.crc = zip_number<std::uint32_t>(rest, 16);
  std::uint64_t packed = zip_number<std::uint32_t>(rest, 20);
  std::uint64_t size = zip_number<std::uint32_t>(rest, 24);
  std::uint64_t offset = zip_number<std::uint32_t>(rest, 42);
  apply_extra64(source, rest.substr(kCentralSize + name_size, extra_size),
                {&size, &packed, &offset});
  rest.remove_prefix(kCentralSize + name_size + extra_size + comment_size);
  if ((flags & 1U) != 0)
    fail_zip(source, fmt::format("{} is encrypted", data::name_text(entry.name)),
             ErrorCode::kUnsupported);
  if (method != kStored && method != kDeflated) {
    fail_zip(source,
             fmt::format("{}: compression {}: expected stored or deflated",
                         data::name_text(entry.name), method),
             ErrorCode::kUnsupported);
  }
  entry.is_deflated = method == kDeflated;
  const auto file_size = static_cast<std::uint64_t>(source.size());
  const std::uint64_t most = entry.is_deflated ? packed * kMaxDeflateRatio : packed;
  if (packed > file_size || offset > file_size || packed + kLocalSize > file_size - offset ||
      size > most || (!entry.is_deflated && size != packed)) {
    fail_zip(source, fmt::format("{}: {} bytes, {} unpacked, at byte {} do not fit the file",
                                 data::name_text(entry.name), packed, size, offset));
  }
  entry.packed_size = static_cast<std::int64_t>(packed);
  entry.size = static_cast<std::int64_t>(size);
  entry.offset = static_cast<std::int64_t>(offset);
  return entry;
}

// A part of another source.
class PartSource final : public ByteSource {
 public:
  PartSource(std::string name, const ByteSource& whole, std::int64_t offset, std::int64_t size)
      : ByteSource(std::move(name), size), whole_(whole), offset_(offset) {}
  void read(std::int64_t offset, std::span<std::byte> out) const override {
    whole_.read(offset_ + offset, out);
  }

 private:
  const ByteSource& whole_;
  std::int64_t offset_;
};

Bytes unpack(const ByteSource& source, const ZipEntry& entry, std::int64_t offset) {
  constexpr std::int64_t kPiece = std::int64_t{1} << 18;
  const auto broken = [&](const std::string& why) {
    fail_zip(source, fmt::format("{} is broken: {}", data::name_text(entry.name), why));
  };
  Inflater inflater(Inflater::kBare);
  SampleBuffer out;
  std::int64_t num_left = entry.packed_size;
  std::string piece;
  uLong crc = crc32(0, nullptr, 0);
  while (!inflater.ended) {
    if (inflater.stream.avail_in == 0 && num_left > 0) {
      piece = source.text(offset, std::min(num_left, kPiece));
      offset += static_cast<std::int64_t>(piece.size());
      num_left -= static_cast<std::int64_t>(piece.size());
      inflater.stream.next_in = reinterpret_cast<Bytef*>(piece.data());
      inflater.stream.avail_in = static_cast<uInt>(piece.size());
    }
    std::byte behind{};  // room for one byte too many, where all is there but the end
    const std::int64_t wanted = std::min(entry.size - out.size(), std::int64_t{1} << 20);
    const std::span<std::byte> room =
        wanted > 0 ? out.extend(wanted, entry.size) : std::span(&behind, 1);
    inflater.stream.next_out = reinterpret_cast<Bytef*>(room.data());
    inflater.stream.avail_out = static_cast<uInt>(room.size());
    const bool had_input = inflater.stream.avail_in > 0;
    const std::string problem = inflater.step();
    if (!problem.empty()) broken(problem);
    const std::size_t made = room.size() - inflater.stream.avail_out;
    if (wanted <= 0 && made > 0) broken(fmt::format("it has more than {} bytes", entry.size));
    if (wanted > 0) out.shrink(static_cast<std::int64_t>(room.size() - made));
    crc = crc32(crc, reinterpret_cast<const Bytef*>(room.data()), static_cast<uInt>(made));
    if (!had_input && made == 0 && !inflater.ended) broken("it ends too early");
  }
  if (out.size() != entry.size)
    broken(fmt::format("it has {} bytes: expected {}", out.size(), entry.size));
  if (crc != entry.crc) broken("its checksum is wrong");
  return out.release();
}

// Behind the local header.
std::int64_t offset_of_data(const ByteSource& source, const ZipEntry& entry) {
  const std::string header = source.text(entry.offset, kLocalSize);
  if (static_cast<std::int64_t>(header.size()) < kLocalSize ||
      zip_number<std::uint32_t>(header, 0) != kLocalHeader)
    fail_zip(source,
             fmt::format("{} is not where the directory says", data::name_text(entry.name)));
  const std::int64_t offset = entry.offset + kLocalSize + zip_number<std::uint16_t>(header, 26) +
                              zip_number<std::uint16_t>(header, 28);
  if (offset > source.size() || entry.packed_size > source.size() - offset)
    fail_zip(source, fmt::format("{} ends behind the file", data::name_text(entry.name)));
  return offset;
}

}  // namespace

std::vector<ZipEntry> read_zip_entries(const ByteSource& source) {
  const ZipDirectory directory = find_directory(source);
  const auto file_size = static_cast<std::uint64_t>(source.size());
  if (directory.offset > file_size || directory.size > file_size - directory.offset ||
      directory.size > kMaxZipDirectory ||
      directory.count > directory.size / static_cast<std::uint64_t>(kCentralSize)) {
    fail_zip(source, fmt::format("a directory of {} entries in {} bytes at byte {} does not fit",
                                 directory.count, directory.size, directory.offset));
  }
  const std::string text = source.text(static_cast<std::int64_t>(directory.offset),
                                       static_cast<std::int64_t>(directory.size));
  std::string_view rest = text;
  std::vector<ZipEntry> entries;
  std::int64_t packed_size = 0;
  for (std::uint64_t i = 0; i < directory.count; ++i) {
    ZipEntry entry = take_entry(source, rest);
    packed_size += entry.packed_size + kLocalSize;
    if (packed_size > source.size())  // the same bytes many times over would unpack without end
      fail_zip(source, "its entries overlap");
    if (!entry.name.ends_with('/')) entries.push_back(std::move(entry));
  }
  return entries;
}

ZipMember open_zip_entry(const ByteSource& source, const ZipEntry& entry) {
  const std::int64_t offset = offset_of_data(source, entry);
  const std::string name = fmt::format("{}: {}", source.name(), entry.name.substr(0, 80));
  ZipMember member;
  if (entry.is_deflated) {
    member.unpacked = unpack(source, entry, offset);
    member.source = open_memory(name, member.unpacked.view);
  } else {
    member.source = std::make_unique<PartSource>(name, source, offset, entry.size);
  }
  return member;
}

std::string zip_entry_start(const ByteSource& source, const ZipEntry& entry, std::int64_t count) {
  const std::int64_t offset = offset_of_data(source, entry);
  count = std::min(count, entry.size);
  if (!entry.is_deflated) return source.text(offset, count);
  // What cannot be packed takes a few bytes more than it has.
  constexpr std::int64_t kMargin = 1024;
  std::string packed = source.text(offset, std::min(entry.packed_size, count + kMargin));
  std::string start(static_cast<std::size_t>(count), '\0');
  Inflater inflater(Inflater::kBare);
  inflater.stream.next_in = reinterpret_cast<Bytef*>(packed.data());
  inflater.stream.avail_in = static_cast<uInt>(packed.size());
  inflater.stream.next_out = reinterpret_cast<Bytef*>(start.data());
  inflater.stream.avail_out = static_cast<uInt>(start.size());
  while (!inflater.ended && inflater.stream.avail_out > 0) {
    const uInt left = inflater.stream.avail_out;
    if (!inflater.step().empty() || inflater.stream.avail_out == left) break;
  }
  start.resize(start.size() - inflater.stream.avail_out);
  return start;
}

void ZipWriter::write(std::string_view bytes) {
  file_.write(bytes);
  position_ += static_cast<std::int64_t>(bytes.size());
}

namespace {

// What the local header and the directory say alike, from "version needed" to the extra field.
std::string common_header(const ZipEntry& entry) {
  std::string out;
  put_zip_number<std::uint16_t>(out, 45);      // version 4.5: 64-bit sizes
  put_zip_number<std::uint16_t>(out, 0x0800);  // names are UTF-8
  put_zip_number<std::uint16_t>(out, kStored);
  put_zip_number<std::uint32_t>(out, 0x00210000);  // 1980-01-01: files do not depend on the hour
  put_zip_number<std::uint32_t>(out, entry.crc);
  put_zip_number<std::uint32_t>(out, kIn64);
  put_zip_number<std::uint32_t>(out, kIn64);
  put_zip_number(out, static_cast<std::uint16_t>(entry.name.size()));
  return out;
}

}  // namespace

void ZipWriter::add(const std::string& name, std::string_view head,
                    std::span<const std::byte> rest) {
  if (name.size() > 65535)
    throw Error(ErrorCode::kInvalidArgument, "array name: longer than a zip file can hold");
  ZipEntry entry;
  entry.name = name;
  entry.offset = position_;
  entry.size = entry.packed_size = static_cast<std::int64_t>(head.size() + rest.size());
  uLong crc = crc32_z(0, reinterpret_cast<const Bytef*>(head.data()), head.size());
  crc = crc32_z(crc, reinterpret_cast<const Bytef*>(rest.data()), rest.size());
  entry.crc = static_cast<std::uint32_t>(crc);
  std::string header;
  put_zip_number<std::uint32_t>(header, kLocalHeader);
  header += common_header(entry);
  put_zip_number<std::uint16_t>(header, 20);  // the extra field
  header += name;
  put_zip_number<std::uint16_t>(header, 1);
  put_zip_number<std::uint16_t>(header, 16);
  put_zip_number<std::uint64_t>(header, entry.size);
  put_zip_number<std::uint64_t>(header, entry.packed_size);
  write(header);
  write(head);
  write({reinterpret_cast<const char*>(rest.data()), rest.size()});
  entries_.push_back(std::move(entry));
}

void ZipWriter::finish() {
  const std::int64_t begin = position_;
  for (const ZipEntry& entry : entries_) {
    std::string header;
    put_zip_number<std::uint32_t>(header, kCentralHeader);
    put_zip_number<std::uint16_t>(header, 45);
    header += common_header(entry);
    put_zip_number<std::uint16_t>(header, 28);
    header.append(10, '\0');  // no comment, disk 0, no attributes
    put_zip_number<std::uint32_t>(header, kIn64);
    header += entry.name;
    put_zip_number<std::uint16_t>(header, 1);
    put_zip_number<std::uint16_t>(header, 24);
    put_zip_number<std::uint64_t>(header, entry.size);
    put_zip_number<std::uint64_t>(header, entry.packed_size);
    put_zip_number<std::uint64_t>(header, entry.offset);
    write(header);
  }
  const std::int64_t end = position_;
  std::string tail;
  put_zip_number<std::uint32_t>(tail, kEndOfDirectory64);
  put_zip_number<std::uint64_t>(tail, kEnd64Size - 12);
  put_zip_number<std::uint32_t>(tail, 45U | 45U << 16);
  put_zip_number<std::uint64_t>(tail, 0);  // disks
  put_zip_number<std::uint64_t>(tail, entries_.size());
  put_zip_number<std::uint64_t>(tail, entries_.size());
  put_zip_number<std::uint64_t>(tail, end - begin);
  put_zip_number<std::uint64_t>(tail, begin);
  put_zip_number<std::uint32_t>(tail, kLocatorOfEnd64);
  put_zip_number<std::uint32_t>(tail, 0);
  put_zip_number<std::uint64_t>(tail, end);
  put_zip_number<std::uint32_t>(tail, 1);
  put_zip_number<std::uint32_t>(tail, kEndOfDirectory);
  put_zip_number<std::uint32_t>(tail, 0);
  put_zip_number<std::uint32_t>(tail, kIn64);  // both counts, 0xffff each
  put_zip_number<std::uint32_t>(tail, kIn64);
  put_zip_number<std::uint32_t>(tail, kIn64);
  put_zip_number<std::uint16_t>(tail, 0);
  write(tail);
}

}  // namespace ovoid::io
