// SPDX-License-Identifier: Apache-2.0
#include "io/vtk_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/samples.h"
#include "io/xml_tags.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

[[noreturn]] void fail(const ByteSource& source, const std::string& what,
                       ErrorCode code = ErrorCode::kFileFormat) {
  throw Error(code, fmt::format("{}: {}", source.name(), what));
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

std::vector<std::string_view> words(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::vector<std::string_view> result;
  while (true) {
    const auto begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return result;
    const auto end = std::min(text.find_first_of(kBlanks, begin), text.size());
    result.push_back(text.substr(begin, end - begin));
    text.remove_prefix(end);
  }
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  std::int64_t value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

// Samples along each axis of "i0 i1 j0 j1 k0 k1"; zeros if the extent is empty, as pieces may be.
std::array<std::int64_t, 3> extent_dims(const ByteSource& source, const std::string& field,
                                        const std::string& text) {
  const auto parts = words(text);
  std::array<std::int64_t, 3> dims{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::optional<std::int64_t> lo, hi;
    if (parts.size() == 6) {
      lo = parse_integer(parts[2 * axis]);
      hi = parse_integer(parts[2 * axis + 1]);
    }
    constexpr std::int64_t kInt = kMaxAxisSize;  // VTK keeps extents in 32-bit integers
    if (!lo || !hi || *lo < -kInt || *lo > kInt || *hi < -kInt || *hi > kInt) {
      fail(source, fmt::format("{}=\"{}\": expected six integers", field, text.substr(0, 80)));
    }
    if (*hi < *lo) return {0, 0, 0};
    dims[axis] = *hi - *lo + 1;
  }
  return dims;
}

std::int64_t num_points(const ByteSource& source, const std::string& field,
                        const std::array<std::int64_t, 3>& dims) {
  if (dims[0] == 0) return 0;
  checked_num_bytes(source.name() + ": " + field, dims, ScalarType::kFloat64);
  return *checked_product(dims);
}

std::int64_t num_cells(const std::array<std::int64_t, 3>& dims) {
  if (dims[0] == 0) return 0;
  std::int64_t result = 1;
  for (const std::int64_t dim : dims) result *= std::max<std::int64_t>(1, dim - 1);
  return result;
}

// Bytes of one value of VTK's XML types; 0 for what is no number (String, Bit).
std::int64_t xml_type_size(const std::string& type) {
  static const std::map<std::string, std::int64_t> kSizes{
      {"Int8", 1},   {"UInt8", 1}, {"Int16", 2},  {"UInt16", 2},  {"Int32", 4},
      {"UInt32", 4}, {"Int64", 8}, {"UInt64", 8}, {"Float32", 4}, {"Float64", 8}};
  const auto found = kSizes.find(type);
  return found == kSizes.end() ? 0 : found->second;
}

// What one DataArray element says, and where its bytes begin.
struct StoredArray {
  std::string name;
  std::string layout;  // "262144 tuples of 1 Float32"
  std::int64_t num_values = 0;
  std::int64_t num_bytes = 0;
  std::string format;         // ascii, binary, appended
  bool is_opaque = false;     // bits or strings: num_bytes is the least they can take
  std::int64_t position = 0;  // inline: offset in the file; appended: from the '_'
};

class VtiChecker {
 public:
  explicit VtiChecker(const ByteSource& source) : source_(source) {}

  void run() {
    scan();
    if (!has_image_) fail(source_, "holds no ImageData element: is the file truncated?");
    if (num_piece_points_ < num_whole_points_) {
      fail(source_, fmt::format("the pieces cover {} of the {} samples of WholeExtent",
                                num_piece_points_, num_whole_points_));
    }
    std::int64_t total = 0;
    for (const StoredArray& array : arrays_) {
      check(array);
      total += std::min(array.num_bytes, kMaxNumBytes / 1024);
      check_ratio("all arrays together", std::min(total, kMaxNumBytes));
    }
  }

 private:
  void scan() {
    XmlTagReader reader(source_);
    std::string section;  // PointData, CellData or FieldData while inside it
    while (auto tag = reader.next()) {
      const std::string& name = tag->name;
      if (name == "PointData" || name == "CellData" || name == "FieldData") {
        section = tag->is_empty_element ? "" : name;
        continue;
      }
      if (name == "/" + section) section.clear();
      if (name.starts_with('/')) continue;
      refuse_references(*tag);
      if (name == "VTKFile") read_root(*tag);
      if (name == "ImageData") read_image(*tag);
      if (name == "Piece") read_piece(*tag);
      // To VTK every element here is an array, whatever it is called; these two stand within one.
      if (!section.empty() && name != "InformationKey" && name != "Value")
        read_array(*tag, section);
      if (name == "AppendedData") {
        is_appended_raw_ = tag->attribute("encoding") == "raw";
        find_appended(tag->end);
        return;  // bytes that may look like anything follow
      }
    }
  }

  // "&#49;" is 1 to VTK and not to this checker; no writer makes such numbers.
  void refuse_references(const XmlTag& tag) const {
    for (const auto& [key, value] : tag.attributes) {
      if (key == "Name" || value.find('&') == std::string::npos) continue;
      fail(source_, fmt::format("{}: {}=\"{}\": character references are not expected here",
                                tag.name.substr(0, 40), key.substr(0, 40), value.substr(0, 40)));
    }
  }

  // Behind blanks, an underscore stands before the first byte. VTK reads on from any other
  // character, out of step.
  void find_appended(std::int64_t position) {
    constexpr std::int64_t kMostBlanks = 4096;
    const std::string text = source_.text(position, kMostBlanks);
    const auto mark = text.find_first_not_of(" \t\r\n");
    if (mark == std::string::npos || text[mark] != '_')
      fail(source_, "AppendedData: do not begin with '_'");
    appended_begin_ = position + static_cast<std::int64_t>(mark) + 1;
  }

  void read_root(const XmlTag& tag) {
    const std::string type = tag.attribute("type");
    if (type != "ImageData") {
      fail(source_, fmt::format("VTKFile type '{}': expected ImageData", type.substr(0, 40)),
           ErrorCode::kUnsupported);
    }
    is_big_endian_ = tag.attribute("byte_order") == "BigEndian";
    word_size_ = tag.attribute("header_type", "UInt32") == "UInt64" ? 8 : 4;
    const std::string compressor = tag.attribute("compressor");
    is_compressed_ = !compressor.empty();
    // Bytes out per byte in, at most. zlib: 1032 (its technical notes); LZ4: 255 (a match grows by
    // 255 per byte); LZMA: 7090 measured on zeros, doubled.
    max_ratio_ = !is_compressed_                         ? 1
                 : compressor == "vtkZLibDataCompressor" ? 1032
                 : compressor == "vtkLZ4DataCompressor"  ? 255
                                                         : 14180;
  }

  void read_image(const XmlTag& tag) {
    has_image_ = true;
    num_whole_points_ = num_points(
        source_, "WholeExtent", extent_dims(source_, "WholeExtent", tag.attribute("WholeExtent")));
    if (num_whole_points_ == 0)
      fail(source_, fmt::format("WholeExtent=\"{}\": is empty", tag.attribute("WholeExtent")));
  }

  void read_piece(const XmlTag& tag) {
    piece_dims_ = extent_dims(source_, "Extent", tag.attribute("Extent"));
    num_piece_points_ += num_points(source_, "Extent", piece_dims_);
    if (num_piece_points_ > kMaxNumBytes) fail(source_, "the pieces are larger than any file");
  }

  void read_array(const XmlTag& tag, const std::string& section) {
    StoredArray array;
    array.name = tag.attribute("Name").substr(0, 80);
    array.format = tag.attribute("format", "ascii");
    if (array.format != "ascii" && array.format != "binary" && array.format != "appended") {
      fail(source_, fmt::format("array '{}': format=\"{}\": expected ascii, binary or appended",
                                array.name, array.format.substr(0, 40)));
    }
    const auto integer = [&](const char* key, const char* otherwise, std::int64_t least,
                             std::int64_t most) {
      const std::string text = tag.attribute(key, otherwise);
      const auto parts = words(text);
      const auto value = parts.size() == 1 ? parse_integer(parts[0]) : std::nullopt;
      if (!value || *value < least || *value > most) {
        fail(source_, fmt::format("array '{}': {}=\"{}\": expected {} to {}", array.name, key,
                                  text.substr(0, 40), least, most));
      }
      return *value;
    };
    const std::int64_t num_components = integer("NumberOfComponents", "1", 1, kMaxComponents);
    const std::int64_t num_tuples =
        section == "FieldData"  ? integer("NumberOfTuples", "1", 0, kMaxNumBytes)
        : section == "CellData" ? num_cells(piece_dims_)
                                : num_points(source_, "Extent", piece_dims_);
    const std::string type = tag.attribute("type");
    // What is no number (bits, strings) takes an eighth of a byte at least; VTK reads it and it is
    // left out afterwards.
    const std::int64_t value_size = xml_type_size(type);
    array.is_opaque = value_size == 0;
    array.layout =
        fmt::format("{} tuples of {} {}", num_tuples, num_components, type.substr(0, 40));
    const auto num_values = checked_product(std::array{num_tuples, num_components});
    const auto num_bytes =
        checked_product(std::array{num_values.value_or(-1), std::max<std::int64_t>(value_size, 1)});
    if (!num_bytes || *num_bytes > kMaxNumBytes) {
      fail(source_,
           fmt::format("array '{}': {} are larger than any file", array.name, array.layout));
    }
    array.num_values = *num_values;
    array.num_bytes = array.is_opaque ? *num_bytes / 8 : *num_bytes;
    array.position = array.format == "appended" ? integer("offset", "0", 0, kMaxNumBytes) : tag.end;
    arrays_.push_back(array);
    if (arrays_.size() > kMaxArrays) {
      fail(source_, fmt::format("has more than {} arrays", kMaxArrays), ErrorCode::kUnsupported);
    }
  }

  void check_ratio(const std::string& what, std::int64_t num_bytes) const {
    if (num_bytes / max_ratio_ > source_.size()) {
      fail(source_,
           fmt::format("{}: need {} bytes, which a file of {} bytes cannot hold: is it truncated?",
                       what, num_bytes, source_.size()));
    }
  }

  // `count` words of the array's own header; empty if they are not there (then VTK will say what is
  // wrong with the text).
  std::vector<std::uint64_t> read_words(const StoredArray& array, std::size_t count) const {
    const bool is_appended = array.format == "appended";
    std::int64_t begin =
        is_appended ? appended_begin_ + std::min(array.position, source_.size()) : array.position;
    const std::size_t num_bytes = count * static_cast<std::size_t>(word_size_);
    std::string bytes;
    if (is_appended && is_appended_raw_) {
      bytes = source_.text(begin, static_cast<std::int64_t>(num_bytes));
    } else {
      // Blanks and line breaks may stand before the digits.
      std::string text = source_.text(begin, 4096 + static_cast<std::int64_t>(num_bytes * 4 / 3));
      text.erase(0, std::min(text.find_first_not_of(" \t\r\n"), text.size()));
      bytes = decode_base64(text, num_bytes);
    }
    if (bytes.size() < num_bytes) return {};
    std::vector<std::uint64_t> result;
    for (std::size_t i = 0; i < count; ++i) {
      std::uint64_t word = 0;
      for (std::int64_t j = 0; j < word_size_; ++j) {
        const std::int64_t k = is_big_endian_ ? j : word_size_ - 1 - j;
        word = word << 8U |
               static_cast<unsigned char>(
                   bytes[i * static_cast<std::size_t>(word_size_) + static_cast<std::size_t>(k)]);
      }
      result.push_back(word);
    }
    return result;
  }

  // The first `num_bytes` of the text, fewer if it ends or has other characters.
  static std::string decode_base64(std::string_view text, std::size_t num_bytes) {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string result;
    std::uint32_t bits = 0;
    int num_bits = 0;
    for (const char c : text) {
      const auto digit = kDigits.find(c);
      if (digit == std::string_view::npos || result.size() == num_bytes) break;
      bits = (bits << 6U | static_cast<std::uint32_t>(digit)) & 0xffffffU;
      num_bits += 6;
      if (num_bits >= 8) {
        num_bits -= 8;
        result += static_cast<char>(bits >> static_cast<unsigned>(num_bits) & 0xffU);
      }
    }
    return result;
  }

  void check(const StoredArray& array) const {
    const std::string what = fmt::format("array '{}'", array.name);
    if (array.num_bytes == 0) return;
    if (array.format == "ascii") {
      // A digit and a separator for every number but the last.
      if (array.num_values > (source_.size() + 1) / 2) {
        fail(source_, fmt::format("{}: a file of {} bytes cannot hold {} as text", what,
                                  source_.size(), array.layout));
      }
      return;
    }
    check_ratio(what, array.num_bytes);
    if (array.is_opaque) return;
    if (array.format == "appended" && appended_begin_ == 0)
      fail(source_, what + ": its data are appended, but no AppendedData follow");
    const std::uint64_t num_stated =
        is_compressed_ ? stated_in_blocks(array) : stated_words(array, 1)[0];
    if (num_stated != static_cast<std::uint64_t>(array.num_bytes)) {
      fail(source_, fmt::format("{}: states {} bytes, {} need {}", what, num_stated, array.layout,
                                array.num_bytes));
    }
  }

  std::vector<std::uint64_t> stated_words(const StoredArray& array, std::size_t count) const {
    auto result = read_words(array, count);
    if (result.empty()) {
      fail(source_,
           fmt::format("array '{}': its data are missing: is the file truncated?", array.name));
    }
    return result;
  }

  // Compressed arrays begin with: number of blocks, size of each, size of the last if it is
  // shorter, compressed size of every block. Returns the sum of the sizes.
  std::uint64_t stated_in_blocks(const StoredArray& array) const {
    const auto head = stated_words(array, 3);
    const auto [num_blocks, block_size, last_size] = std::array{head[0], head[1], head[2]};
    const auto file_size = static_cast<std::uint64_t>(source_.size());
    constexpr std::uint64_t kLargestBlock = std::uint64_t{1}
                                            << 31;  // VTK's writers make blocks of 32 KiB to 4 MiB
    const bool fits = num_blocks > 0 &&
                      num_blocks <= file_size / static_cast<std::uint64_t>(word_size_) &&
                      block_size <= kLargestBlock && last_size <= block_size &&
                      num_blocks <= static_cast<std::uint64_t>(kMaxNumBytes) / kLargestBlock;
    if (!fits) {
      fail(source_,
           fmt::format(
               "array '{}': states {} blocks of {} bytes, the last of {}: the file has {} bytes",
               array.name, num_blocks, block_size, last_size, file_size));
    }
    const auto all = stated_words(array, 3 + static_cast<std::size_t>(num_blocks));
    for (std::size_t i = 3; i < all.size(); ++i) {
      if (all[i] > file_size) {
        fail(source_, fmt::format("array '{}': states that block {} has {} bytes: the file has {}",
                                  array.name, i - 3, all[i], file_size));
      }
    }
    // At most kMaxNumBytes.
    return (last_size > 0 ? num_blocks - 1 : num_blocks) * block_size + last_size;
  }

  static constexpr std::size_t kMaxArrays = 10000;
  static constexpr std::int64_t kMaxComponents =
      1 << 20;  // VTK works through the components' names one by one

  const ByteSource& source_;
  bool has_image_ = false;
  bool is_big_endian_ = false;
  bool is_compressed_ = false;
  bool is_appended_raw_ = false;
  std::int64_t word_size_ = 4;
  std::int64_t max_ratio_ = 1;
  std::int64_t appended_begin_ = 0;
  std::int64_t num_whole_points_ = 0;
  std::int64_t num_piece_points_ = 0;
  std::array<std::int64_t, 3> piece_dims_{};
  std::vector<StoredArray> arrays_;
};

// Bytes of one value of the legacy format's types; 0 for what is no number. A bit counts as
// nothing.
std::int64_t legacy_type_size(std::string_view type) {
  static const std::map<std::string, std::int64_t> kSizes{
      {"char", 1},           {"signed_char", 1},  {"unsigned_char", 1}, {"short", 2},
      {"unsigned_short", 2}, {"int", 4},          {"unsigned_int", 4},  {"long", 4},
      {"unsigned_long", 4},  {"float", 4},        {"double", 8},        {"vtkidtype", 4},
      {"vtktypeint64", 8},   {"vtktypeuint64", 8}};
  const auto found = kSizes.find(lower(type));
  return found == kSizes.end() ? 0 : found->second;
}

// Walks the words of a legacy header as VTK does, which minds no lines after the first two.
class LegacyChecker {
 public:
  // Field data may stand before the dimensions; more than a MiB of it would be no image's.
  explicit LegacyChecker(const ByteSource& source)
      : source_(source), text_(source.text(0, std::int64_t{1} << 20)) {}

  void run() {
    skip_line();  // magic
    skip_line();  // title
    const std::string encoding = word();
    if (encoding != "ascii" && encoding != "binary") {
      fail(source_,
           fmt::format("'{}' after the title: expected ASCII or BINARY", encoding.substr(0, 40)));
    }
    is_binary_ = encoding == "binary";
    for (std::string keyword = word(); !keyword.empty(); keyword = word()) {
      if (keyword == "dataset") check_kind(word());
      if (keyword == "dimensions") read_dimensions();
      if (keyword == "point_data") return check_samples("POINT_DATA", num_points_);
      if (keyword == "cell_data") return check_samples("CELL_DATA", num_cells_);
    }
    fail(source_, "has no POINT_DATA or CELL_DATA: is the file truncated?");
  }

 private:
  void skip_line() { position_ = std::min(text_.find('\n', position_), text_.size() - 1) + 1; }

  // In lower case; empty at the end.
  std::string word() {
    constexpr std::string_view kBlanks = " \t\r\n";
    const auto begin = text_.find_first_not_of(kBlanks, position_);
    if (begin == std::string::npos) return {};
    position_ = std::min(text_.find_first_of(kBlanks, begin), text_.size());
    return lower(std::string_view(text_).substr(begin, position_ - begin));
  }

  void check_kind(const std::string& kind) const {
    if (kind == "structured_points") return;
    fail(source_, fmt::format("DATASET '{}': expected STRUCTURED_POINTS", kind.substr(0, 40)),
         ErrorCode::kUnsupported);
  }

  void read_dimensions() {
    std::array<std::int64_t, 3> dims{};
    for (std::int64_t& dim : dims) {
      const std::string text = word();
      const auto value = parse_integer(text);
      if (!value || *value < 1 || *value > kMaxAxisSize) {
        fail(source_,
             fmt::format("DIMENSIONS: '{}': expected 1 to {}", text.substr(0, 40), kMaxAxisSize));
      }
      dim = *value;
    }
    num_points_ = num_points(source_, "DIMENSIONS", dims);
    num_cells_ = num_cells(dims);
  }

  void check_samples(const char* keyword, std::optional<std::int64_t> expected) {
    if (!expected) fail(source_, fmt::format("{} before DIMENSIONS", keyword));
    const std::string text = word();
    if (parse_integer(text) != expected) {
      fail(source_,
           fmt::format("{}: '{}': DIMENSIONS need {}", keyword, text.substr(0, 40), *expected));
    }
    // A bit is the smallest sample there is.
    if (*expected / 8 > source_.size()) {
      fail(source_, fmt::format("{}: {} samples do not fit a file of {} bytes: is it truncated?",
                                keyword, *expected, source_.size()));
    }
    check_first_array(*expected);
  }

  // "SCALARS name type [components]" and its kin say how many bytes must follow.
  void check_first_array(std::int64_t num_tuples) {
    const std::string keyword = word();
    const bool is_scalars = keyword == "scalars";
    if (!is_scalars && keyword != "vectors" && keyword != "normals" && keyword != "tensors") return;
    std::string_view name = std::string_view(text_);
    word();
    name = name.substr(0, position_);
    name.remove_prefix(name.find_last_of(" \t\r\n") + 1);
    const std::string type = word();
    std::int64_t num_components = is_scalars ? 1 : keyword == "tensors" ? 9 : 3;
    const std::size_t line_end = std::min(text_.find('\n', position_), text_.size());
    if (is_scalars) {
      const auto rest = words(std::string_view(text_).substr(position_, line_end - position_));
      if (!rest.empty()) num_components = parse_integer(rest[0]).value_or(1);
    }
    const std::int64_t available = source_.size() - static_cast<std::int64_t>(line_end);
    // As text, a digit and a separator for every number but the last.
    const auto needed = checked_product(
        std::array{num_tuples, num_components, is_binary_ ? legacy_type_size(type) : 2});
    if (!needed || *needed - (is_binary_ ? 0 : 1) > available) {
      fail(source_, fmt::format("array '{}': {} tuples of {} {} do not fit the {} bytes behind it: "
                                "is the file truncated?",
                                name.substr(0, 80), num_tuples, num_components, type.substr(0, 40),
                                available));
    }
  }

  const ByteSource& source_;
  std::string text_;
  std::size_t position_ = 0;
  bool is_binary_ = false;
  std::optional<std::int64_t> num_points_, num_cells_;
};

}  // namespace

void check_vti(const ByteSource& source) { VtiChecker(source).run(); }

void check_legacy_vtk(const ByteSource& source) { LegacyChecker(source).run(); }

}  // namespace ovoid::io
