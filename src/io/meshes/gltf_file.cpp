// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <span>
#include <string_view>
#include <utility>

#include "io/core/base64.h"
#include "io/core/memory.h"
#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::string_view kGltfMagic = "glTF";
constexpr std::int64_t kBinaryHeader = 12;  // magic, version, length
constexpr std::int64_t kChunkHeader = 8;    // length, kind
constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr std::string_view kData = "data:";

[[noreturn]] void refuse_gltf(const ByteSource& source, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source.name(), what));
}

std::uint32_t word_at(const ByteSource& source, std::int64_t offset) {
  const std::string bytes = source.text(offset, sizeof(std::uint32_t));
  if (bytes.size() < sizeof(std::uint32_t)) refuse_gltf(source, "ends within its header");
  return number_at<std::uint32_t>(bytes.data(), false);
}

// Where in a file its text is, and its numbers.
struct GltfChunks {
  std::int64_t text = 0, text_bytes = 0, binary = 0, binary_bytes = 0;
};

GltfChunks chunks_of(const ByteSource& source) {
  if (source.text(0, 4) != kGltfMagic) return {.text_bytes = source.size()};
  GltfChunks chunks{.text = kBinaryHeader + kChunkHeader};
  chunks.text_bytes = word_at(source, kBinaryHeader);
  if (word_at(source, kBinaryHeader + 4) != kJsonChunk)
    refuse_gltf(source, "does not begin with its text");
  const std::int64_t next = chunks.text + chunks.text_bytes;
  if (next > source.size())
    refuse_gltf(source, fmt::format("its text has {} bytes, {} are there", chunks.text_bytes,
                                    source.size() - chunks.text));
  if (next + kChunkHeader > source.size() || word_at(source, next + 4) != kBinaryChunk)
    return chunks;
  chunks.binary = next + kChunkHeader;
  chunks.binary_bytes = word_at(source, next);
  if (chunks.binary + chunks.binary_bytes > source.size())
    refuse_gltf(source, fmt::format("its numbers have {} bytes, {} are there", chunks.binary_bytes,
                                    source.size() - chunks.binary));
  return chunks;
}

Json json_of_chunk(const ByteSource& source, const GltfChunks& chunks) {
  if (chunks.text_bytes > static_cast<std::int64_t>(kMaxJsonBytes))
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: its text has {} bytes, at most {} are read", source.name(),
                            chunks.text_bytes, kMaxJsonBytes));
  return parse_json(source.text(chunks.text, chunks.text_bytes), source.name());
}

// A whole number of at least 0; without the member `usual`.
std::size_t whole(const JsonValue& value) {
  constexpr double kMost = 1e12;
  const double number = value.number();
  if (!(number >= 0 && number <= kMost) || number != std::trunc(number))
    value.refuse("expected a whole number of at least 0");
  return static_cast<std::size_t>(number);
}
std::size_t whole(const JsonValue& object, const char* name, std::size_t usual) {
  return object.has(name) ? whole(object.member(name)) : usual;
}

// The bytes of "data:...;base64,DIGITS".
std::vector<std::byte> bytes_of_data(const JsonValue& place, const std::string& uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string::npos || uri.substr(0, comma).find(";base64") == std::string::npos)
    place.refuse("expected data in base64");
  std::string_view digits = std::string_view(uri).substr(comma + 1);
  digits = digits.substr(0, digits.find('='));
  if (!std::all_of(digits.begin(), digits.end(),
                   [](char c) { return value_of_base64_digit(c) >= 0; }))
    place.refuse("is no base64");
  const std::string data = decoded_base64(digits);
  const auto bytes = std::as_bytes(std::span(data));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::size_t GltfNumbers::size_of(Type type) noexcept {
  switch (type) {
    case kInt8:
    case kUInt8:
      return 1;
    case kInt16:
    case kUInt16:
      return 2;
    case kUInt32:
    case kFloat:
      break;
  }
  return 4;
}

double GltfNumbers::at(std::int64_t element, int component) const {
  const std::byte* const place = first_ + static_cast<std::size_t>(element) * stride_ +
                                 static_cast<std::size_t>(component) * size_of(type_);
  const auto scaled = [&](double number, double greatest) {
    return is_normalized_ ? std::max(number / greatest, -1.0) : number;
  };
  switch (type_) {
    case kInt8:
      return scaled(number_at<std::int8_t>(place, false), 127);
    case kUInt8:
      return scaled(number_at<std::uint8_t>(place, false), 255);
    case kInt16:
      return scaled(number_at<std::int16_t>(place, false), 32767);
    case kUInt16:
      return scaled(number_at<std::uint16_t>(place, false), 65535);
    case kUInt32:
      return number_at<std::uint32_t>(place, false);
    case kFloat:
      break;
  }
  return static_cast<double>(number_at<float>(place, false));
}

std::uint32_t GltfNumbers::index_at(std::int64_t element) const {
  const std::byte* const place = first_ + static_cast<std::size_t>(element) * stride_;
  if (type_ == kUInt8) return number_at<std::uint8_t>(place, false);
  if (type_ == kUInt16) return number_at<std::uint16_t>(place, false);
  return number_at<std::uint32_t>(place, false);
}

GltfFile::GltfFile(const ByteSource& source, const ReadOptions& options, const Opener& open)
    : text_(json_, source.name() + ": ") {
  const GltfChunks chunks = chunks_of(source);
  binary_offset_ = chunks.binary;
  binary_bytes_ = chunks.binary_bytes;
  json_ = json_of_chunk(source, chunks);
  const std::string version = text_.object().member("asset").object().member("version").string();
  if (!version.starts_with("2."))
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: is of glTF {}, 2 is read", source.name(), version.substr(0, 8)));
  for (std::size_t i = 0; i < count("buffers"); ++i)
    read_buffer(element("buffers", i), source, options, open);
}

std::size_t GltfFile::count(const char* list) const {
  return text_.has(list) ? text_.member(list).array().size() : 0;
}

JsonValue GltfFile::element(const char* list, std::size_t i) const {
  return text_.member(list).element(i).object();
}

std::size_t GltfFile::index(const JsonValue& value, const char* list) const {
  const std::size_t i = whole(value);
  if (i >= count(list)) value.refuse(fmt::format("there are {} {}", count(list), list));
  return i;
}

void GltfFile::read_buffer(const JsonValue& buffer, const ByteSource& source,
                           const ReadOptions& options, const Opener& open) {
  const std::size_t wanted = whole(buffer.member("byteLength"));
  const auto require_there = [&](std::int64_t there) {
    if (wanted > static_cast<std::size_t>(there))
      buffer.refuse(fmt::format("{} of its {} bytes are there", there, wanted));
  };
  const auto read = [&](const ByteSource& from, std::int64_t offset) {
    require_memory(buffer.place(), static_cast<std::int64_t>(wanted));
    std::vector<std::byte>& bytes = buffers_.emplace_back(wanted);
    ReadProgress progress(options, static_cast<std::int64_t>(wanted));
    for (std::size_t done = 0; done < wanted;) {
      const std::size_t now =
          std::min(wanted - done, static_cast<std::size_t>(ReadProgress::kChunk));
      from.read(offset + static_cast<std::int64_t>(done), std::span(bytes).subspan(done, now));
      progress.advance(static_cast<std::int64_t>(now));
      done += now;
    }
  };
  if (!buffer.has("uri")) {
    require_there(buffers_.empty() ? binary_bytes_ : 0);
    return read(source, binary_offset_);
  }
  const std::string uri = buffer.member("uri").string();
  if (uri.starts_with(kData)) {
    buffers_.push_back(bytes_of_data(buffer.member("uri"), uri));
    return require_there(static_cast<std::int64_t>(buffers_.back().size()));
  }
  const std::unique_ptr<ByteSource> file = open(path_beside(source.name(), uri));
  require_there(file->size());
  read(*file, 0);
}

GltfFile::View GltfFile::view(std::size_t i) const {
  const JsonValue view = element("bufferViews", i);
  const std::vector<std::byte>& buffer = buffers_[index(view.member("buffer"), "buffers")];
  const std::size_t offset = whole(view, "byteOffset", 0);
  const std::size_t bytes = whole(view.member("byteLength"));
  if (offset + bytes > buffer.size())
    view.refuse(fmt::format("must end within its buffer of {} bytes", buffer.size()));
  return {buffer.data() + offset, bytes, whole(view, "byteStride", 0)};
}

GltfNumbers GltfFile::numbers(const JsonValue& value) const {
  static const std::map<std::string, int> kComponents = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  const JsonValue accessor = element("accessors", index(value, "accessors"));
  if (accessor.has("sparse") || !accessor.has("bufferView"))
    throw Error(ErrorCode::kUnsupported,
                accessor.place() + ": sparse accessors, and those without a view, are not read");
  const std::size_t type = whole(accessor.member("componentType"));
  const auto components = kComponents.find(accessor.member("type").string());
  const bool is_known = (type >= GltfNumbers::kInt8 && type <= GltfNumbers::kUInt16) ||
                        type == GltfNumbers::kUInt32 || type == GltfNumbers::kFloat;
  if (!is_known || components == kComponents.end()) accessor.refuse("is of no type of glTF's");
  GltfNumbers numbers;
  numbers.type_ = static_cast<GltfNumbers::Type>(type);
  numbers.components_ = components->second;
  numbers.is_normalized_ = accessor.has("normalized") && accessor.member("normalized").boolean();
  const std::size_t count = whole(accessor.member("count"));
  numbers.count_ = static_cast<std::int64_t>(count);
  const View in = view(index(accessor.member("bufferView"), "bufferViews"));
  const std::size_t size =
      GltfNumbers::size_of(numbers.type_) * static_cast<std::size_t>(numbers.components_);
  const std::size_t offset = whole(accessor, "byteOffset", 0);
  numbers.stride_ = std::max(in.stride, size);
  if (count < 1 || offset + size > in.bytes ||
      (count - 1) > (in.bytes - offset - size) / numbers.stride_)
    accessor.refuse(fmt::format("must end within its view of {} bytes", in.bytes));
  numbers.first_ = in.first + offset;
  return numbers;
}

std::vector<std::string> gltf_companions(const ByteSource& source) {
  const Json json = json_of_chunk(source, chunks_of(source));
  const auto buffers = json.find("buffers");
  std::vector<std::string> files;
  if (buffers == json.end() || !buffers->is_array()) return files;
  for (const Json& buffer : *buffers) {
    const auto uri = buffer.find("uri");
    if (uri == buffer.end() || !uri->is_string()) continue;
    const auto name = uri->get<std::string>();
    if (name.starts_with(kData)) continue;
    const std::string path = path_beside(source.name(), name);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) break;
    files.push_back(path);
  }
  return files;
}

}  // namespace ovoid::io
