// SPDX-License-Identifier: Apache-2.0
#include "io/pictures/exr_structure.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string_view>

#include "ovoid/error.h"
#include "ovoid/render_options.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostAttribute = std::int64_t{1} << 24;
constexpr std::size_t kMostName = 31;  // without the flag for longer ones, which is refused
constexpr int kMostAttributes = 256;
// What is packed well may be a thousand times as large, hardly more.
constexpr std::int64_t kMostPacking = 2000;

[[noreturn]] void refuse_structure(const ByteSource& source, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source.name(), what));
}

// Reads numbers, little-endian as this machine, one after the other.
class Walk {
 public:
  Walk(const ByteSource& source, std::int64_t at) : source_(source), at_(at) {}

  template <class T>
  T number() {
    T value{};
    read(std::as_writable_bytes(std::span(&value, 1)));
    return value;
  }
  // Up to a zero.
  std::string name() {
    std::string text;
    for (char c = number<char>(); c != 0; c = number<char>()) {
      if (text.size() == kMostName) refuse_structure(source_, "a name without an end");
      text += c;
    }
    return text;
  }
  std::string text(std::int64_t size) {
    require_left(size);
    std::string out = source_.text(at_, size);
    at_ += size;
    return out;
  }
  std::int64_t at() const noexcept { return at_; }
  void require_left(std::int64_t size) const {
    if (size < 0 || size > source_.size() - at_)
      refuse_structure(source_, fmt::format("ends early, or claims {} bytes at {}", size, at_));
  }

 private:
  void read(std::span<std::byte> out) {
    require_left(static_cast<std::int64_t>(out.size()));
    source_.read(at_, out);
    at_ += static_cast<std::int64_t>(out.size());
  }

  const ByteSource& source_;
  std::int64_t at_;
};

// The bytes of a list of channels, which OpenEXR reads to its own end.
std::int64_t bytes_of_channels(const ByteSource& source, std::int64_t at) {
  constexpr std::int64_t kNumbers = 16;  // of a channel, after its name
  Walk list(source, at);
  while (!list.name().empty()) list.text(kNumbers);
  return list.at() - at;
}

// Whether OpenEXR reads as many bytes of an attribute as it claims to have; those of other types
// than a part has might be read otherwise.
bool is_sized(const ByteSource& source, const std::string& type, std::int64_t at,
              std::int64_t size) {
  static const std::map<std::string, std::int64_t, std::less<>> kSizes = {
      {"int", 4}, {"float", 4}, {"box2i", 16}, {"v2f", 8}, {"compression", 1}, {"lineOrder", 1}};
  if (type == "string") return size >= 0;
  if (type == "chlist") return size == bytes_of_channels(source, at);
  const auto known = kSizes.find(type);
  return known != kSizes.end() && known->second == size;
}

// The lines of the picture.
std::int64_t lines_of(const ByteSource& source, const std::string& window) {
  std::int32_t box[4];
  if (window.size() != sizeof(box)) refuse_structure(source, "has no data window");
  std::memcpy(box, window.data(), sizeof(box));
  if (box[0] != 0 || box[1] != 0)
    refuse_structure(source,
                     fmt::format("its pixels begin at {}, {}: must at 0, 0", box[0], box[1]));
  constexpr int kMost = RenderOptions::kMaxImageSide;
  const std::int64_t width = std::int64_t{box[2]} + 1;
  const std::int64_t height = std::int64_t{box[3]} + 1;
  if (width < 1 || width > kMost || height < 1 || height > kMost)
    refuse_structure(source,
                     fmt::format("{} x {} pixels: must be 1 to {} each way", width, height, kMost));
  return height;
}

// A chunk: its line, sizes of both its parts as packed, of the second unpacked; then both.
std::int64_t unpacked_bytes(const ByteSource& source, std::int64_t offset) {
  if (offset < 0 || offset > source.size()) refuse_structure(source, "a line beyond its end");
  Walk chunk(source, offset);
  chunk.number<std::int32_t>();
  const auto counts = chunk.number<std::int64_t>();
  const auto packed = chunk.number<std::int64_t>();
  const auto unpacked = chunk.number<std::int64_t>();
  chunk.require_left(counts);
  chunk.require_left(packed);
  if (unpacked < 0 || unpacked / kMostPacking > packed)
    refuse_structure(source, fmt::format("claims {} bytes in a line of {}", unpacked, packed));
  return unpacked;
}

}  // namespace

void require_deep_structure(const ByteSource& source) {
  constexpr std::int32_t kExrMagic = 20000630;
  constexpr std::uint32_t kVersion = 2, kTiled = 0x200, kDeep = 0x800;
  Walk header(source, 0);
  if (source.size() < 8 || header.number<std::int32_t>() != kExrMagic)
    refuse_structure(source,
                     "is no OpenEXR file, not a part of a picture: expected what ovoid render "
                     "--part writes");
  const auto version = header.number<std::uint32_t>();
  if (version != (kVersion | kDeep))
    refuse_structure(source, fmt::format("is a {}picture, not a part of a picture: expected what "
                                         "ovoid render --part writes",
                                         (version & kTiled) != 0 ? "tiled " : ""));
  std::map<std::string, std::string, std::less<>> attributes;
  for (std::string name = header.name(); !name.empty(); name = header.name()) {
    const std::string type = header.name();
    const std::int64_t size = header.number<std::int32_t>();
    if (size > kMostAttribute || attributes.size() == kMostAttributes ||
        !is_sized(source, type, header.at(), size))
      refuse_structure(source, fmt::format("attribute '{}' of type '{}' and {} bytes: is none that "
                                           "a part of a picture has",
                                           name, type, size));
    attributes[name] = header.text(size);
  }
  const std::int64_t lines = lines_of(source, attributes["dataWindow"]);
  std::int32_t chunks = 0;
  if (attributes["chunkCount"].size() == sizeof(chunks))
    std::memcpy(&chunks, attributes["chunkCount"].data(), sizeof(chunks));
  if (chunks != lines)
    refuse_structure(source, fmt::format("has {} chunks for {} lines", chunks, lines));
  header.require_left(lines * static_cast<std::int64_t>(sizeof(std::int64_t)));
  std::int64_t unpacked = 0;
  for (std::int64_t line = 0; line < lines; ++line)
    unpacked += unpacked_bytes(source, header.number<std::int64_t>());
  if (unpacked / kMostPacking > source.size())
    refuse_structure(source, fmt::format("claims {} bytes of runs", unpacked));
}

}  // namespace ovoid::io
