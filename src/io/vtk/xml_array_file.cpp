// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/xml_array_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <string_view>
#include <system_error>

#include "io/core/atomic_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::string_view kAppendedBegin = "  <AppendedData encoding=\"raw\">\n   _";
constexpr std::string_view kAppendedEnd = "\n  </AppendedData>\n</VTKFile>\n";

// Decimal digits of the largest offset.
constexpr std::size_t kOffsetDigits = 20;

// Readers unpack whole blocks: small enough for a part of an array, large enough that the window of
// deflate (32 KiB) is rarely started anew.
constexpr std::size_t kBlockBytes = std::size_t{1} << 18;
constexpr int kZlibLevel = 5;  // VTK's own

const char* vtk_type_name(ScalarType type) {
  switch (type) {
    case ScalarType::kUInt8:
      return "UInt8";
    case ScalarType::kInt8:
      return "Int8";
    case ScalarType::kUInt16:
      return "UInt16";
    case ScalarType::kInt16:
      return "Int16";
    case ScalarType::kUInt32:
      return "UInt32";
    case ScalarType::kInt32:
      return "Int32";
    case ScalarType::kUInt64:
      return "UInt64";
    case ScalarType::kInt64:
      return "Int64";
    case ScalarType::kFloat32:
      return "Float32";
    case ScalarType::kFloat64:
      return "Float64";
  }
  return "";
}

// Bytes of the UTF-8 character that begins at `at`, 0 if none does that XML may hold.
std::size_t utf8_size(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0U;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  std::uint32_t code = first & (0xffU >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0U) != 0x80) return 0;
    code = code << 6U | (byte(i) & 0x3fU);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = code >= 0xd800 && code <= 0xdfff;
  const bool is_character = first >= 0xc2 && code >= kLeast[size] && code <= 0x10ffff &&
                            code != 0xfffe && code != 0xffff && !is_surrogate;
  return is_character ? size : 0;
}

class Deflater {
 public:
  Deflater() : packed_(::compressBound(kBlockBytes)) {}

  // Valid until the next call.
  std::span<const Bytef> pack(std::span<const std::byte> block) {
    auto size = static_cast<uLongf>(packed_.size());
    const int status =
        ::compress2(packed_.data(), &size, reinterpret_cast<const Bytef*>(block.data()),
                    static_cast<uLong>(block.size()), kZlibLevel);
    // There is room for anything, so that only memory can be missing.
    if (status != Z_OK) throw Error(ErrorCode::kOutOfMemory, "zlib: cannot start");
    return {packed_.data(), size};
  }

 private:
  std::vector<Bytef> packed_;
};

// Number of blocks, size of each, size of the last if that is shorter, packed size of each.
std::vector<std::uint64_t> block_table(std::size_t num_bytes) {
  const std::uint64_t num_blocks = (num_bytes + kBlockBytes - 1) / kBlockBytes;
  std::vector<std::uint64_t> table(3 + num_blocks);
  table[0] = num_blocks;
  table[1] = kBlockBytes;
  table[2] = num_bytes % kBlockBytes;
  return table;
}

// A place in a file that was written before its content was known.
struct Patch {
  std::uint64_t position;
  std::string bytes;
};

template <typename T>
std::string table_bytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

void apply(const std::vector<Patch>& patches, const AtomicFile& file, const std::string& path) {
  const auto fail = [&] {
    throw Error(ErrorCode::kFileWrite, fmt::format("{}: cannot be written: {}", path,
                                                   std::generic_category().message(errno)));
  };
  struct Descriptor {
    int number;
    ~Descriptor() { ::close(number); }
  };
  const int number = ::open(file.partial_path().c_str(), O_WRONLY | O_CLOEXEC);
  if (number < 0) fail();
  const Descriptor descriptor{number};
  for (const Patch& patch : patches) {
    std::string_view left = patch.bytes;
    auto position = static_cast<off_t>(patch.position);
    while (!left.empty()) {
      const ssize_t written = ::pwrite(number, left.data(), left.size(), position);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail();
      left.remove_prefix(static_cast<std::size_t>(written));
      position += written;
    }
  }
}

}  // namespace

XmlArrayFile::XmlArrayFile(const std::string& type, Packing packing) : packing_(packing) {
  header_ = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"{}\" "
      "header_type=\"UInt64\"{}>\n",
      type, std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian",
      packing == Packing::kZlib ? " compressor=\"vtkZLibDataCompressor\"" : "");
}

void XmlArrayFile::array(const std::string& name, ScalarType type, int num_components,
                         std::span<const std::byte> bytes, const std::string& unit) {
  header_ += fmt::format(
      "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
      "offset=\"",
      vtk_type_name(type), xml_text(name), num_components);
  pieces_.push_back({bytes, header_.size()});
  // Blanks around the number are allowed, and filled in when it is known.
  header_ +=
      packing_ == Packing::kPlain ? std::to_string(num_appended_) : std::string(kOffsetDigits, ' ');
  num_appended_ += sizeof(std::uint64_t) + bytes.size();
  if (unit.empty()) {
    header_ += "\"/>\n";
    return;
  }
  header_ += fmt::format(
      "\">\n          <InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{}"
      "</InformationKey>\n        </DataArray>\n",
      xml_text(unit));
}

void XmlArrayFile::write(const std::string& path, const std::stop_token& stop) const {
  if (packing_ == Packing::kZlib) return write_packed(path, stop);
  AtomicFile file(path, stop);
  file.write(header_);
  file.write(kAppendedBegin);
  for (const Piece& piece : pieces_) {
    const std::uint64_t size = piece.bytes.size();
    file.write(&size, sizeof(size));
    file.write(piece.bytes.data(), piece.bytes.size());
  }
  file.write(kAppendedEnd);
  file.commit();
}

void XmlArrayFile::write_packed(const std::string& path, const std::stop_token& stop) const {
  AtomicFile file(path, stop);
  file.write(header_);
  file.write(kAppendedBegin);
  std::vector<Patch> patches;
  const std::uint64_t begin = header_.size() + kAppendedBegin.size();
  std::uint64_t position = begin;
  Deflater deflater;
  for (const Piece& piece : pieces_) {
    patches.push_back({piece.offset_at, std::to_string(position - begin)});
    std::vector<std::uint64_t> table = block_table(piece.bytes.size());
    const std::uint64_t table_at = position;
    file.write(table_bytes(table));
    position += table.size() * sizeof(std::uint64_t);
    for (std::size_t block = 0; block < table[0]; ++block) {
      const std::size_t from = block * kBlockBytes;
      const std::size_t size = std::min(kBlockBytes, piece.bytes.size() - from);
      const auto packed = deflater.pack(piece.bytes.subspan(from, size));
      file.write(packed.data(), packed.size());
      table[3 + block] = packed.size();
      position += packed.size();
    }
    patches.push_back({table_at, table_bytes(table)});
  }
  file.write(kAppendedEnd);
  apply(patches, file, path);
  file.commit();
}

std::string xml_text(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t size = utf8_size(text, i);
    const char c = text[i];
    if (size == 0) {
      out += '?';
    } else if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else if (size == 1 && static_cast<unsigned char>(c) < ' ') {
      out += ' ';
    } else {
      out += std::string_view(text).substr(i, size);
    }
    i += std::max<std::size_t>(size, 1);
  }
  return out;
}

}  // namespace ovoid::io
