// SPDX-License-Identifier: Apache-2.0
#include "io/images/npy_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <span>
#include <utility>

#include "io/core/memory.h"
#include "io/core/samples.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMaxNpyHeaderSize = 65536;  // numpy itself refuses more than 10 000

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

}  // namespace

NpyHeader read_npy_header(const ByteSource& source) {
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

namespace {

// What NumPy's letter for a type that is not read stands for.
std::string meaning_of(const std::string& descr) {
  static constexpr std::pair<char, const char*> kLetters[] = {
      {'O', "Python objects, which are pickled"},
      {'U', "text"},
      {'S', "bytes of text"},
      {'a', "bytes of text"},
      {'c', "complex numbers"},
      {'V', "records or raw bytes"},
      {'M', "dates"},
      {'m', "spans of time"}};
  const char letter = descr.size() > 1 ? descr[1] : '\0';
  for (const auto& [known, meaning] : kLetters)
    if (letter == known) return fmt::format(" ({})", meaning);
  return {};
}

}  // namespace

NpyType npy_type_of(const std::string& name, const std::string& descr) {
  const std::string code = descr.size() > 1 ? descr.substr(1) : "";
  const bool is_boolean = code == "b1";
  const bool is_half = code == "f2";
  const auto type = is_boolean ? ScalarType::kUInt8
                    : is_half  ? ScalarType::kUInt16
                               : find_scalar_type(code.size() == 2 ? code : "");
  const char order = descr.empty() ? '\0' : descr[0];
  if (!type || std::string_view("<>|=").find(order) == std::string_view::npos) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format(
            "{}: descr: '{}'{}: expected booleans, integers of 1 to 8 bytes, or floats of 2 "
            "to 8",
            name, descr.substr(0, 40), meaning_of(descr)));
  }
  const bool is_native_big = std::endian::native == std::endian::big;
  return {*type, order == '>' || (order != '<' && is_native_big), is_boolean,
          is_half ? ShortFloat::kHalf : ShortFloat::kNone};
}

const char* NpyType::name() const noexcept { return stored_name(type, short_float); }

std::optional<std::string> NpyType::note(const std::string& source) const {
  if (is_boolean) return fmt::format("{}: booleans become uint8", source);
  if (short_float == ShortFloat::kNone) return std::nullopt;
  return fmt::format("{}: {} becomes float32", source, name_of(short_float));
}

void check_npy_size(const ByteSource& source, const NpyHeader& header, const NpyType& type,
                    std::int64_t num_bytes) {
  const std::int64_t available = source.size() - header.data_offset;
  if (available == num_bytes) return;
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: holds {} bytes of samples, shape ({}) of {} needs {}", source.name(),
                          available, fmt::join(header.shape, ", "), type.name(), num_bytes));
}

NpySamples read_npy_samples(const ByteSource& source, const ReadOptions& options,
                            const std::optional<RowShare>& share) {
  NpySamples result;
  result.header = read_npy_header(source);
  const NpyType type = npy_type_of(source.name(), result.header.descr);
  result.type = type;
  const auto& shape = result.header.shape;
  const std::int64_t num_bytes = checked_num_bytes(source.name() + ": shape", shape, type.type);
  check_npy_size(source, result.header, type, num_bytes);
  result.rows = rows_of_share(share, shape[0]);
  const std::int64_t row_size = num_bytes / shape[0];
  const std::int64_t num_read = result.rows.count * row_size;
  require_memory(fmt::format("{}: {}", source.name(), layout_text(shape, type.type)), num_read);
  ReadProgress progress(options, num_read);
  result.samples.reserve(num_read);
  // In Fortran order the rows of a share are a run of each column.
  const bool is_by_column = share && result.header.is_fortran_order;
  const std::int64_t step = is_by_column ? static_cast<std::int64_t>(size_of(type.type)) : row_size;
  for (std::int64_t run = 0; run < row_size / step; ++run) {
    append_plain(source, result.header.data_offset + (run * shape[0] + result.rows.first) * step,
                 result.rows.count * step, result.samples, progress);
  }
  if (type.is_big_endian != (std::endian::native == std::endian::big))
    swap_bytes(result.samples.bytes(), size_of(type.type));
  return result;
}

}  // namespace ovoid::io
