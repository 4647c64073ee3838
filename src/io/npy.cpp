// SPDX-License-Identifier: Apache-2.0
#include "io/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

#include "io/atomic_file.h"
#include "io/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::int64_t kMaxNpyHeaderSize =
    65536;                                   // numpy itself refuses more than 10 000 characters
constexpr std::int64_t kMaxComponents = 64;  // a longer last axis is far more likely space or time

struct NpyHeader {
  std::string descr;
  bool is_fortran_order = false;
  std::vector<std::int64_t> shape;
  std::int64_t data_offset = 0;
};

// The part of Python's literals that numpy writes: {'descr': '<f4', 'fortran_order': False,
// 'shape': (3, 4, 5), }
class DictParser {
 public:
  DictParser(const std::string& name, std::string_view text) : name_(name), text_(text) {}

  NpyHeader run() {
    NpyHeader header;
    bool has_descr = false, has_order = false, has_shape = false;
    expect('{');
    while (!accept('}')) {
      const std::string key = string();
      expect(':');
      if (key == "descr" && !has_descr) {
        if (peek() == '[')
          throw Error(
              ErrorCode::kUnsupported,
              fmt::format("{}: descr: is a record of several fields: expected one number type",
                          name_));
        header.descr = string();
        has_descr = true;
      } else if (key == "fortran_order" && !has_order) {
        header.is_fortran_order = boolean();
        has_order = true;
      } else if (key == "shape" && !has_shape) {
        header.shape = tuple();
        has_shape = true;
      } else {
        fail(fmt::format("key '{}' is unknown or stands twice", key.substr(0, 40)));
      }
      if (!accept(',')) {
        expect('}');
        break;
      }
    }
    if (peek() != '\0') fail("text follows the dictionary");
    if (!has_descr || !has_order || !has_shape)
      fail("expected the keys descr, fortran_order and shape");
    return header;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: NPY header: {}", name_, what));
  }

  char peek() {
    while (!text_.empty() &&
           (text_.front() == ' ' || text_.front() == '\n' || text_.front() == '\t'))
      text_.remove_prefix(1);
    return text_.empty() ? '\0' : text_.front();
  }

  bool accept(char c) {
    if (peek() != c || text_.empty()) return false;
    text_.remove_prefix(1);
    return true;
  }

  void expect(char c) {
    if (!accept(c)) fail(fmt::format("expected '{}' at '{}'", c, text_.substr(0, 20)));
  }

  std::string string() {
    const char quote = peek() == '"' ? '"' : '\'';
    expect(quote);
    const auto end = text_.find(quote);
    if (end == std::string_view::npos) fail("a string does not end");
    std::string result(text_.substr(0, end));
    text_.remove_prefix(end + 1);
    return result;
  }

  bool boolean() {
    peek();
    for (const auto& [word, value] :
         {std::pair<std::string_view, bool>{"True", true}, {"False", false}}) {
      if (!text_.starts_with(word)) continue;
      text_.remove_prefix(word.size());
      return value;
    }
    fail(fmt::format("expected True or False at '{}'", text_.substr(0, 20)));
  }

  std::vector<std::int64_t> tuple() {
    std::vector<std::int64_t> result;
    expect('(');
    while (!accept(')')) {
      peek();
      std::int64_t value = 0;
      const auto parsed = std::from_chars(text_.data(), text_.data() + text_.size(), value);
      if (parsed.ec != std::errc{})
        fail(fmt::format("shape: expected a number at '{}'", text_.substr(0, 20)));
      text_.remove_prefix(static_cast<std::size_t>(parsed.ptr - text_.data()));
      accept('L');  // long integers of Python 2
      result.push_back(value);
      if (result.size() > 32) fail("shape: has more than 32 axes");
      if (!accept(',')) {
        expect(')');
        break;
      }
    }
    return result;
  }

  const std::string& name_;
  std::string_view text_;
};

NpyHeader read_header(const ByteSource& source) {
  const std::string start = source.text(0, 12);
  const auto byte = [&](std::size_t i) {
    return static_cast<std::int64_t>(static_cast<unsigned char>(start[i]));
  };
  const std::int64_t version = start.size() > 6 ? byte(6) : 0;
  const std::int64_t text_offset = version == 1 ? 10 : 12;
  if (static_cast<std::int64_t>(start.size()) < text_offset) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: NPY header: the file ends within it", source.name()));
  }
  if (version < 1 || version > 3) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: NPY version {}: expected 1 to 3", source.name(), version));
  }
  std::int64_t length = byte(8) + 256 * byte(9);
  if (version > 1) length += 65536 * byte(10) + 16777216 * byte(11);
  if (length > kMaxNpyHeaderSize || text_offset + length > source.size()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: NPY header: claims {} bytes, the file has {} and {} are allowed",
                            source.name(), length, source.size() - text_offset, kMaxNpyHeaderSize));
  }
  const std::string text = source.text(text_offset, length);
  NpyHeader header = DictParser(source.name(), text).run();
  header.data_offset = text_offset + length;
  return header;
}

struct NpyType {
  ScalarType type;
  bool is_big_endian;
  bool is_boolean;
};

NpyType parse_descr(const std::string& name, const std::string& descr) {
  const std::string code = descr.size() > 1 ? descr.substr(1) : "";
  const bool is_boolean = code == "b1";
  const auto type =
      is_boolean ? ScalarType::kUInt8 : find_scalar_type(code.size() == 2 ? code : "");
  const char order = descr.empty() ? '\0' : descr[0];
  if (!type || std::string_view("<>|=").find(order) == std::string_view::npos) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format(
            "{}: descr: '{}': expected booleans, integers of 1 to 8 bytes, or floats of 4 or 8",
            name, descr.substr(0, 40)));
  }
  const bool is_native_big = std::endian::native == std::endian::big;
  return {*type, order == '>' || (order != '<' && is_native_big), is_boolean};
}

// [a, b] -> [b, a] for items of `item_size` bytes: reverses the order of two groups of axes. Works
// on square blocks, so that reads and writes both stay in the cache.
void transpose(const std::byte* from, std::byte* to, std::int64_t rows, std::int64_t columns,
               std::size_t item_size) {
  constexpr std::int64_t kBlock = 32;
  for (std::int64_t row0 = 0; row0 < rows; row0 += kBlock) {
    for (std::int64_t column0 = 0; column0 < columns; column0 += kBlock) {
      for (std::int64_t row = row0; row < std::min(rows, row0 + kBlock); ++row) {
        for (std::int64_t column = column0; column < std::min(columns, column0 + kBlock);
             ++column) {
          std::memcpy(to + static_cast<std::size_t>(column * rows + row) * item_size,
                      from + static_cast<std::size_t>(row * columns + column) * item_size,
                      item_size);
        }
      }
    }
  }
}

// Fortran order, first axis fastest, to C order, last axis fastest.
Bytes reverse_axes(SampleBuffer& samples, const std::vector<std::int64_t>& shape,
                   std::size_t item_size) {
  SampleBuffer result;
  const auto size = samples.size();
  const auto to = result.extend(size, size);
  const auto from = samples.bytes();
  // In memory the shape reads, slowest first, (c, x, y, z) and shall become (z, y, x, c): for every
  // (c, y), an x-z plane is transposed.
  const std::int64_t nz = shape[0], ny = shape[1], nx = shape[2],
                     nc = shape.size() == 4 ? shape[3] : 1;
  std::vector<std::byte> rows(static_cast<std::size_t>(nx * nz) * item_size);
  std::vector<std::byte> columns(rows.size());
  for (std::int64_t c = 0; c < nc; ++c) {
    for (std::int64_t y = 0; y < ny; ++y) {
      for (std::int64_t x = 0; x < nx; ++x) {
        std::memcpy(
            rows.data() + static_cast<std::size_t>(x * nz) * item_size,
            from.data() + static_cast<std::size_t>(((c * nx + x) * ny + y) * nz) * item_size,
            static_cast<std::size_t>(nz) * item_size);
      }
      transpose(rows.data(), columns.data(), nx, nz, item_size);
      for (std::int64_t z = 0; z < nz; ++z) {
        for (std::int64_t x = 0; x < nx; ++x) {
          std::memcpy(
              to.data() + static_cast<std::size_t>(((z * ny + y) * nx + x) * nc + c) * item_size,
              columns.data() + static_cast<std::size_t>(z * nx + x) * item_size, item_size);
        }
      }
    }
  }
  return result.release();
}

Dataset describe(const ByteSource& source, const NpyHeader& header, const ReadOptions& options) {
  const auto& shape = header.shape;
  const std::string text = fmt::format("({})", fmt::join(shape, ", "));
  if (shape.size() != 3 && !(shape.size() == 4 && shape[3] <= kMaxComponents)) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format(
            "{}: shape: {}: expected (z, y, x), or (z, y, x, component) with up to {} components",
            source.name(), text, kMaxComponents));
  }
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "NPY";
  dataset.lattice.dims = {shape[2], shape[1], shape[0]};
  if (options.raw.spacing)
    dataset.lattice.world_from_index.linear() = options.raw.spacing->asDiagonal();
  check_geometry("spacing", dataset.lattice.world_from_index);
  if (shape.size() == 4) {
    dataset.notes.push_back(
        fmt::format("{}: shape {} taken as (z, y, x, component)", source.name(), text));
  }
  return dataset;
}

}  // namespace

bool looks_like_npy(std::string_view start) noexcept { return start.starts_with(kMagic); }

Dataset read_npy(const ByteSource& source, const ReadOptions& options) {
  const NpyHeader header = read_header(source);
  const NpyType type = parse_descr(source.name(), header.descr);
  Dataset dataset = describe(source, header, options);
  const std::int64_t num_bytes =
      checked_num_bytes(source.name() + ": shape", header.shape, type.type);
  const std::int64_t available = source.size() - header.data_offset;
  if (available != num_bytes) {
    throw Error(
        ErrorCode::kFileFormat,
        fmt::format("{}: holds {} bytes of samples, shape ({}) of {} needs {}", source.name(),
                    available, fmt::join(header.shape, ", "), name_of(type.type), num_bytes));
  }
  SampleBuffer samples;
  ReadProgress progress(options, num_bytes);
  append_plain(source, header.data_offset, num_bytes, samples, progress);
  const std::size_t item_size = size_of(type.type);
  if (type.is_big_endian != (std::endian::native == std::endian::big))
    swap_bytes(samples.bytes(), item_size);

  DataArray array{"values", type.type, 1, num_samples(dataset.lattice.dims), "", false, {}};
  if (header.shape.size() == 4) array.num_components = static_cast<int>(header.shape[3]);
  array.bytes =
      header.is_fortran_order ? reverse_axes(samples, header.shape, item_size) : samples.release();
  if (type.is_boolean)
    dataset.notes.push_back(fmt::format("{}: booleans become uint8", source.name()));
  dataset.arrays.push_back(std::move(array));
  return dataset;
}

std::string npy_header(ScalarType type, std::span<const std::int64_t> shape) {
  static constexpr const char* kCodes[] = {"u1", "i1", "u2", "i2", "u4",
                                           "i4", "u8", "i8", "f4", "f8"};
  const char* const order = size_of(type) == 1                           ? "|"
                            : std::endian::native == std::endian::little ? "<"
                                                                         : ">";
  std::string dict = fmt::format("{{'descr': '{}{}', 'fortran_order': False, 'shape': ({}{}), }}",
                                 order, kCodes[static_cast<std::size_t>(type)],
                                 fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  // Samples start at a multiple of 64 bytes.
  constexpr std::size_t kPrefix = 10;
  dict.append(63 - (kPrefix + dict.size()) % 64, ' ');
  dict += '\n';
  std::string result(kMagic);
  result +=
      {'\x01', '\x00', static_cast<char>(dict.size() % 256), static_cast<char>(dict.size() / 256)};
  return result + dict;
}

void write_npy(const Index3& dims, const DataArray& array, const std::string& path) {
  std::vector<std::int64_t> shape{dims[2], dims[1], dims[0]};
  if (array.num_components > 1) shape.push_back(array.num_components);
  AtomicFile file(path);
  file.write(npy_header(array.type, shape));
  file.write(array.bytes.view.data(), array.bytes.view.size());
  file.commit();
}

}  // namespace ovoid::io
