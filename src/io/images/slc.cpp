// SPDX-License-Identifier: Apache-2.0
// An SLC file: numbers as text (magic, samples along x y z, bits, spacing, unit, origin and history
// of the data, compression, size of the icon), an 'X', three planes of the icon's bytes, the
// slices. A compressed slice is its size in bytes as text, an 'X', and runs: a byte whose low seven
// bits are a count and whose high bit says whether that many bytes follow or one that is repeated.
// A count of 0 ends the slice.
#include "io/images/slc.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::string_view kMagic = "11111";

// At most 127 bytes come of two.
constexpr std::int64_t kMaxRatio = 64;

struct SlcHeader {
  Index3 dims{};
  Vec3 spacing = Vec3::Ones();
  bool is_compressed = false;
  std::int64_t data_offset = 0;
};

class SlcReader {
 public:
  SlcReader(const ByteSource& source, const ReadOptions& options)
      : source_(source), text_(source, 0, source.size()), progress_(options, source.size()) {}

  SlcHeader read_header() {
    SlcHeader header;
    text_.word();  // magic
    for (std::size_t axis = 0; axis < 3; ++axis) {
      constexpr std::array kFields{"samples along x", "samples along y", "samples along z"};
      header.dims[axis] = integer(kFields[axis], 1, kMaxAxisSize);
    }
    const std::int64_t num_bits = integer("bits per sample", 1, 64);
    if (num_bits != 8)
      fail(fmt::format("has {} bits per sample: expected 8", num_bits), ErrorCode::kUnsupported);
    for (int axis = 0; axis < 3; ++axis) header.spacing[axis] = real("spacing");
    for (const char* field : {"unit", "origin of the data", "history of the data"})
      integer(field, INT32_MIN, INT32_MAX);
    const std::int64_t compression = integer("compression", 0, INT32_MAX);
    if (compression > 1) {
      fail(fmt::format("compression {}: expected 0, none, or 1, run lengths", compression),
           ErrorCode::kUnsupported);
    }
    header.is_compressed = compression == 1;
    const std::int64_t icon_width = integer("width of the icon", 0, kMaxAxisSize / 4);
    const std::int64_t icon_height = digits("height of the icon", kMaxAxisSize / 4);
    pass_mark("the icon");
    const std::int64_t num_icon_bytes = 3 * icon_width * icon_height;
    if (num_icon_bytes > text_.num_left())
      fail(fmt::format("an icon of {} x {} pixels does not fit the file: is it truncated?",
                       icon_width, icon_height));
    text_.skip(num_icon_bytes);
    header.data_offset = text_.position();
    return header;
  }

  Bytes read_samples(const SlcHeader& header, std::int64_t num_bytes) {
    const std::int64_t num_left = text_.num_left();
    const std::int64_t most = header.is_compressed ? num_left * kMaxRatio : num_left;
    if (num_bytes > most) {
      fail(fmt::format("{} bytes hold at most {} samples, {} needs {}: is the file truncated?",
                       num_left, most, dims_text(header.dims), num_bytes));
    }
    SampleBuffer samples;
    if (!header.is_compressed) {
      append_plain(source_, header.data_offset, num_bytes, samples, progress_);
      return samples.release();
    }
    const std::int64_t slice_size = header.dims[0] * header.dims[1];
    for (std::int64_t z = 0; z < header.dims[2]; ++z) append_slice(z, slice_size, samples);
    return samples.release();
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const {
    throw Error(code, fmt::format("{}: {}", source_.name(), what));
  }

  std::int64_t integer(const char* field, std::int64_t least, std::int64_t most) {
    const std::string text(text_.word());
    const auto value = parse_integer(text);
    if (!value || *value < least || *value > most)
      fail(fmt::format("{}: '{}': expected {} to {}", field, text.substr(0, 40), least, most));
    return *value;
  }

  double real(const char* field) {
    const std::string text(text_.word());
    const auto value = parse_number<double>(text);
    if (!value) fail(fmt::format("{}: '{}': expected a number", field, text.substr(0, 40)));
    return *value;
  }

  // Bytes follow it at once.
  void pass_mark(const std::string& what) {
    text_.skip_blanks();
    if (text_.ahead(1) != "X") fail(fmt::format("no 'X' stands before {}", what));
    text_.skip(1);
  }

  // Digits that a mark may follow at once.
  std::int64_t digits(const std::string& what, std::int64_t most) {
    text_.skip_blanks();
    const std::string_view ahead = text_.ahead(20);
    std::int64_t value = -1;
    const auto result = std::from_chars(ahead.data(), ahead.data() + ahead.size(), value);
    if (result.ec != std::errc{} || value < 0 || value > most)
      fail(fmt::format("{}: expected a number from 0 to {}", what, most));
    text_.skip(result.ptr - ahead.data());
    return value;
  }

  std::int64_t packed_size(const std::string& what) {
    const std::int64_t size = digits(what + ": its size", kMaxNumBytes);
    pass_mark(what);
    if (size > text_.num_left()) {
      fail(fmt::format("{}: has {} bytes, {} are left: is the file truncated?", what, size,
                       text_.num_left()));
    }
    return size;
  }

  void append_slice(std::int64_t z, std::int64_t slice_size, SampleBuffer& samples) {
    const std::string what = fmt::format("slice {}", z);
    const std::int64_t num_packed = packed_size(what);
    const std::string packed = source_.text(text_.position(), num_packed);
    text_.skip(num_packed);
    progress_.advance(num_packed);
    const std::int64_t end = samples.size() + slice_size;
    std::size_t at = 0;
    while (at < packed.size()) {
      const auto code = static_cast<unsigned char>(packed[at++]);
      const std::size_t count = code & 0x7fU;
      if (count == 0) break;
      const bool is_literal = (code & 0x80U) != 0;
      const std::size_t num_needed = is_literal ? count : 1;
      if (num_needed > packed.size() - at) fail(fmt::format("{}: ends within a run", what));
      if (static_cast<std::int64_t>(count) > end - samples.size())
        fail(fmt::format("{}: has more than its {} samples", what, slice_size));
      std::byte* const out = samples.extend(static_cast<std::int64_t>(count), end).data();
      if (is_literal)
        std::memcpy(out, packed.data() + at, count);
      else
        std::memset(out, static_cast<unsigned char>(packed[at]), count);
      at += num_needed;
    }
    if (samples.size() < end) {
      fail(fmt::format("{}: has {} of its {} samples", what, samples.size() - (end - slice_size),
                       slice_size));
    }
  }

  const ByteSource& source_;
  TextScanner text_;
  ReadProgress progress_;
};

}  // namespace

bool looks_like_slc(std::string_view start) noexcept {
  if (!start.starts_with(kMagic) || start.size() == kMagic.size() ||
      !is_blank(start[kMagic.size()]))
    return false;
  // Fourteen numbers, then the mark: a table that begins with the same number is none.
  std::size_t at = 0;
  for (int i = 0; i < 14; ++i) {
    at = std::min(start.find_first_not_of(" \t\r\n", at), start.size());
    at = std::min(start.find_first_not_of("0123456789+-.eE", at), start.size());
  }
  at = std::min(start.find_first_not_of(" \t\r\n", at), start.size());
  return at < start.size() && start[at] == 'X';
}

Dataset read_slc(const ByteSource& source, const ReadOptions& options) {
  SlcReader reader(source, options);
  const SlcHeader header = reader.read_header();
  const std::int64_t num_bytes = checked_num_bytes(source.name(), header.dims, ScalarType::kUInt8);
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "SLC";
  dataset.lattice.dims = header.dims;
  dataset.lattice.world_from_index.linear() = header.spacing.asDiagonal();
  check_geometry(source.name() + ": spacing", dataset.lattice.world_from_index);
  dataset.arrays.push_back({"values", ScalarType::kUInt8, 1, num_bytes, "", false,
                            reader.read_samples(header, num_bytes)});
  return dataset;
}

}  // namespace ovoid::io
