// SPDX-License-Identifier: Apache-2.0
// An OpenVDB file [Museth 2013], all numbers little endian: the magic (8 bytes), version of the
// format, major and minor version of the library (4 each), whether grids can be found by offsets
// (1), an identifier (36); metadata of the file; the number of grids (4). Each grid: name, type of
// its tree, name of the grid whose tree it shares, and three offsets (8 each): of its data, of its
// voxels, and of what follows it. Its data begin with flags of compression (4) and metadata of its
// own. Metadata are their number (4), then name, type, size (4) and bytes of each. Text is its
// length (4) and bytes.
#include "io/vdb/vdb_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::uint32_t kOldest = 222;  // that which a grid's flags of compression came with
constexpr std::int64_t kIdentifier = 36;
constexpr std::int64_t kLongestText = 64 << 10;
constexpr std::int32_t kMostVdbGrids = 10000;
constexpr std::uint32_t kMostMetadata = 100000;

// OpenVDB sets a number behind a name that several grids have apart by this.
constexpr char kSeparator = '\x1e';

std::string readable_name(const std::string& unique) {
  const std::size_t end = unique.find(kSeparator);
  if (end == std::string::npos) return unique;
  return fmt::format("{}[{}]", unique.substr(0, end), unique.substr(end + 1));
}

class HeaderWalk {
 public:
  explicit HeaderWalk(const ByteSource& source) : source_(source) {}

  VdbHeader walk() {
    VdbHeader header;
    skip(8, "the magic");
    header.version = number<std::uint32_t>("the version");
    if (header.version < kOldest) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: has version {} of OpenVDB's format: expected {} or later, which "
                              "any OpenVDB since 2013 writes",
                              source_.name(), header.version, kOldest));
    }
    skip(8, "the library's version");
    header.has_offsets = number<std::uint8_t>("the flag of offsets") != 0;
    skip(kIdentifier, "the identifier");
    pass_metadata("of the file");
    if (!header.has_offsets) return header;
    const auto count = number<std::int32_t>("the number of grids");
    if (count < 0 || count > kMostVdbGrids)
      fail(fmt::format("has {} grids: expected 0 to {}", count, kMostVdbGrids));
    for (std::int32_t i = 0; i < count; ++i) header.grids.push_back(entry(i));
    return header;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source_.name(), what));
  }
  [[noreturn]] void fail_at_end(const std::string& field) const {
    fail(fmt::format("ends within {}, after {} bytes: is the file truncated?", field,
                     source_.size()));
  }

  void skip(std::int64_t count, const std::string& field) {
    if (count > source_.size() - position_) fail_at_end(field);
    position_ += count;
  }

  template <typename T>
  T number(const std::string& field) {
    std::byte bytes[sizeof(T)];
    const std::int64_t at = position_;
    skip(sizeof(T), field);
    source_.read(at, bytes);
    std::make_unsigned_t<T> value = 0;
    for (std::size_t i = sizeof(T); i-- > 0;)
      value = static_cast<std::make_unsigned_t<T>>((std::uint64_t{value} << 8U) |
                                                   static_cast<std::uint64_t>(bytes[i]));
    return static_cast<T>(value);
  }

  std::string text(const std::string& field) {
    const std::int64_t length = number<std::uint32_t>(field);
    if (length > kLongestText)
      fail(fmt::format("{} claims {} bytes: at most {} are read", field, length, kLongestText));
    const std::int64_t at = position_;
    skip(length, field);
    return source_.text(at, length);
  }

  void pass_metadata(const std::string& whose) {
    const std::string field = "the metadata " + whose;
    const auto count = number<std::uint32_t>(field);
    if (count > kMostMetadata)
      fail(fmt::format("{} are {}: at most {} are read", field, count, kMostMetadata));
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::string name = text(field);
      text(field);  // its type
      skip(number<std::uint32_t>(field), fmt::format("{}, '{}'", field, name));
    }
  }

  VdbEntry entry(std::int32_t number_of_grid) {
    const std::string field = fmt::format("the descriptor of grid {}", number_of_grid);
    VdbEntry entry;
    entry.name = readable_name(text(field));
    entry.type = text(field);
    const bool shares_tree = !text(field).empty();  // the grid's whose tree it is
    const auto begin = number<std::int64_t>(field);
    const auto voxels = number<std::int64_t>(field);
    const auto end = number<std::int64_t>(field);
    const bool is_in_order =
        begin >= position_ && end >= begin && (shares_tree || (voxels >= begin && voxels <= end));
    if (!is_in_order) {
      fail(
          fmt::format("grid '{}' says that it lies from byte {} to {}, its voxels from {} on, "
                      "behind a descriptor that ends at {}: is the file damaged?",
                      entry.name, begin, end, voxels, position_));
    }
    if (end > source_.size()) {
      fail(fmt::format("grid '{}' ends at byte {}, the file at {}: is the file truncated?",
                       entry.name, end, source_.size()));
    }
    position_ = begin;
    skip(4, field);
    pass_metadata(fmt::format("of grid '{}'", entry.name));
    position_ = end;
    return entry;
  }

  const ByteSource& source_;
  std::int64_t position_ = 0;
};

}  // namespace

VdbHeader read_vdb_header(const ByteSource& source) { return HeaderWalk(source).walk(); }

}  // namespace ovoid::io
