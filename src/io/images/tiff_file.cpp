// SPDX-License-Identifier: Apache-2.0
#include "io/images/tiff_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "io/core/samples.h"
#include "io/core/signatures.h"
#include "io/images/tiff_blocks.h"
#include "io/images/tiff_jpeg.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Tags, as TIFF numbers them.
enum TiffTag : std::uint16_t {
  kSubfileType = 254,
  kWidth = 256,
  kHeight = 257,
  kBits = 258,
  kCompression = 259,
  kPhotometric = 262,
  kFillOrder = 266,
  kDescription = 270,
  kStripOffsets = 273,
  kSamplesPerPixel = 277,
  kRowsPerStrip = 278,
  kStripByteCounts = 279,
  kXResolution = 282,
  kYResolution = 283,
  kPlanar = 284,
  kResolutionUnit = 296,
  kPredictor = 317,
  kTileWidth = 322,
  kTileHeight = 323,
  kTileOffsets = 324,
  kTileByteCounts = 325,
  kExtraSamples = 338,
  kSampleFormat = 339,
  kJpegTables = 347,
  kImageDepth = 32997,
};

// Bytes of a value, by its type; 0 for an unknown one.
int size_of_tiff_type(std::uint16_t type) noexcept {
  static constexpr std::array<int, 19> kSizes{0, 1, 1, 2, 4, 8, 1, 1, 2, 4,
                                              8, 4, 8, 4, 0, 0, 8, 8, 8};
  return type < kSizes.size() ? kSizes[type] : 0;
}

constexpr std::uint64_t kMostFields = 4096;
constexpr std::uint64_t kMostSamples = 4096;  // of a pixel

std::uint64_t number_of(std::span<const std::byte> bytes, bool is_big_endian) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    value =
        value << 8U | static_cast<std::uint64_t>(bytes[is_big_endian ? i : bytes.size() - 1 - i]);
  return value;
}

}  // namespace

// One directory: its fields, and where the next one is (0: nowhere).
struct TiffFile::Directory {
  std::int64_t at = 0, next = 0;
  std::int64_t num_bytes = 0;  // that it takes
  std::vector<TiffField> fields;

  const TiffField* find(std::uint16_t tag) const noexcept {
    const auto found = std::find_if(fields.begin(), fields.end(),
                                    [&](const TiffField& field) { return field.tag == tag; });
    return found == fields.end() ? nullptr : &*found;
  }
};

bool looks_like_tiff(std::string_view start) { return picture_format_of(start) == "TIFF"; }

void TiffFile::fail(const std::string& what) const {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source_.name(), what));
}

void TiffFile::refuse(std::int64_t page, const std::string& what) const {
  throw Error(ErrorCode::kUnsupported, fmt::format("{}: page {}: {}", source_.name(), page, what));
}

void TiffFile::check_inside(std::int64_t at, std::uint64_t size, const char* what) const {
  if (at >= 0 && at <= source_.size() && size <= static_cast<std::uint64_t>(source_.size() - at))
    return;
  fail(fmt::format("its {} would end behind the file, which has {} bytes", what, source_.size()));
}

std::uint64_t TiffFile::number_at(std::int64_t at, int size) const {
  check_inside(at, static_cast<std::uint64_t>(size), "header");
  std::array<std::byte, 8> bytes{};
  const std::span<std::byte> used = std::span(bytes).first(static_cast<std::size_t>(size));
  source_.read(at, used);
  return number_of(used, is_big_endian_);
}

TiffFile::Directory TiffFile::directory_at(std::int64_t at) const {
  const int count_size = is_big_tiff_ ? 8 : 2, field_size = is_big_tiff_ ? 20 : 12,
            offset_size = is_big_tiff_ ? 8 : 4;
  check_inside(at, static_cast<std::uint64_t>(count_size), "directory of a page");
  const std::uint64_t count = number_at(at, count_size);
  if (count > kMostFields)
    fail(fmt::format("a directory has {} fields, more than any page", count));
  const std::uint64_t size = count * static_cast<std::uint64_t>(field_size);
  check_inside(at + count_size, size + static_cast<std::uint64_t>(offset_size),
               "directory of a page");
  std::vector<std::byte> bytes(size + static_cast<std::size_t>(offset_size));
  source_.read(at + count_size, bytes);
  Directory directory;
  directory.at = at;
  directory.num_bytes = count_size + static_cast<std::int64_t>(bytes.size());
  const auto number = [&](std::size_t from, int num_bytes) {
    return number_of(std::span(bytes).subspan(from, static_cast<std::size_t>(num_bytes)),
                     is_big_endian_);
  };
  for (std::size_t from = 0; from < size; from += static_cast<std::size_t>(field_size)) {
    TiffField field;
    field.tag = static_cast<std::uint16_t>(number(from, 2));
    field.type = static_cast<std::uint16_t>(number(from + 2, 2));
    field.count = number(from + 4, offset_size);
    const auto value = from + 4 + static_cast<std::size_t>(offset_size);
    const auto value_size = static_cast<std::uint64_t>(size_of_tiff_type(field.type));
    if (value_size == 0) continue;  // none of those that are looked at
    // Values that fit stand in the field itself.
    const bool is_here = field.count <= static_cast<std::uint64_t>(offset_size) / value_size;
    const std::uint64_t offset =
        is_here ? static_cast<std::uint64_t>(at + count_size) + value : number(value, offset_size);
    if (offset > static_cast<std::uint64_t>(kMaxNumBytes)) continue;
    field.at = static_cast<std::int64_t>(offset);
    directory.fields.push_back(field);
  }
  const std::uint64_t next = number(size, offset_size);
  if (next > static_cast<std::uint64_t>(kMaxNumBytes)) fail("its next page is behind its end");
  directory.next = static_cast<std::int64_t>(next);
  return directory;
}

std::vector<std::uint64_t> TiffFile::numbers(const TiffField& field, const char* what) const {
  const auto size = static_cast<std::size_t>(size_of_tiff_type(field.type));
  if (field.type == 2 || field.type == 5 || field.type == 10 || field.type == 11 ||
      field.type == 12)
    fail(fmt::format("its {} are no whole numbers", what));
  if (field.count > static_cast<std::uint64_t>(source_.size()) / size)
    fail(fmt::format("its {} would end behind the file, which has {} bytes", what, source_.size()));
  check_inside(field.at, field.count * size, what);
  std::vector<std::byte> bytes(field.count * size);
  source_.read(field.at, bytes);
  std::vector<std::uint64_t> values;
  values.reserve(field.count);
  for (std::size_t at = 0; at < bytes.size(); at += size)
    values.push_back(number_of(std::span(bytes).subspan(at, size), is_big_endian_));
  return values;
}

std::uint64_t TiffFile::number(const TiffField& field) const {
  TiffField first = field;
  first.count = std::min<std::uint64_t>(field.count, 1);
  const std::vector<std::uint64_t> values = numbers(first, "fields");
  return values.empty() ? 0 : values[0];
}

std::optional<double> TiffFile::rational(const TiffField& field) const {
  if (field.type != 5 || field.count == 0) return std::nullopt;
  const auto upper = static_cast<double>(number_at(field.at, 4));
  const auto lower = static_cast<double>(number_at(field.at + 4, 4));
  if (!(upper > 0 && lower > 0)) return std::nullopt;
  return upper / lower;
}

void TiffFile::set_type(TiffPage& page, const Directory& directory) const {
  const auto value = [&](std::uint16_t tag, std::uint64_t otherwise) {
    const TiffField* const field = directory.find(tag);
    return field == nullptr ? otherwise : number(*field);
  };
  const std::uint64_t num_samples = value(kSamplesPerPixel, 1), bits = value(kBits, 1);
  if (num_samples == 0 || num_samples > kMostSamples)
    refuse(page.number, fmt::format("has {} samples in each pixel", num_samples));
  page.num_samples = static_cast<int>(num_samples);
  if (const TiffField* const all = directory.find(kBits)) {
    for (const std::uint64_t other : numbers(*all, "bits of samples"))
      if (other != bits) refuse(page.number, "has samples of several sizes in a pixel");
  }
  enum : std::uint64_t { kUnsigned = 1, kSigned = 2, kFloat = 3, kUnknown = 4 };
  std::uint64_t kind = value(kSampleFormat, kUnsigned);
  if (kind == kUnknown) kind = kUnsigned;
  page.bits = static_cast<int>(std::min<std::uint64_t>(bits, 1000));
  const auto fits = [&](std::uint64_t wanted_bits, std::uint64_t wanted_kind, ScalarType type) {
    if (bits != wanted_bits || kind != wanted_kind) return false;
    page.type = type;
    return true;
  };
  if (bits == 16 && kind == kFloat) page.short_float = ShortFloat::kHalf;
  const bool is_known =
      fits(16, kFloat, ScalarType::kUInt16) || fits(8, kUnsigned, ScalarType::kUInt8) ||
      fits(8, kSigned, ScalarType::kInt8) || fits(16, kUnsigned, ScalarType::kUInt16) ||
      fits(16, kSigned, ScalarType::kInt16) || fits(32, kUnsigned, ScalarType::kUInt32) ||
      fits(32, kSigned, ScalarType::kInt32) || fits(64, kUnsigned, ScalarType::kUInt64) ||
      fits(64, kSigned, ScalarType::kInt64) || fits(32, kFloat, ScalarType::kFloat32) ||
      fits(64, kFloat, ScalarType::kFloat64) || fits(1, kUnsigned, ScalarType::kUInt8) ||
      fits(2, kUnsigned, ScalarType::kUInt8) || fits(4, kUnsigned, ScalarType::kUInt8) ||
      fits(10, kUnsigned, ScalarType::kUInt16) || fits(12, kUnsigned, ScalarType::kUInt16) ||
      fits(14, kUnsigned, ScalarType::kUInt16);
  if (!is_known) {
    refuse(
        page.number,
        fmt::format("has {} of {} bits: expected integers of 8, 16, 32 or 64 bits, unsigned ones "
                    "of 1, 2, 4, 10, 12 or 14 too, or floats of 16, 32 or 64",
                    kind == kFloat      ? "floats"
                    : kind == kSigned   ? "integers with sign"
                    : kind == kUnsigned ? "integers"
                                        : "complex numbers or samples of another kind",
                    bits));
  }
  page.num_components = page.num_samples;
  if (const TiffField* const extra = directory.find(kExtraSamples)) {
    const std::vector<std::uint64_t> kinds = numbers(*extra, "extra samples");
    for (std::size_t i = kinds.size(); i-- > 0 && page.num_components > 1;) {
      if (kinds[i] != 1 && kinds[i] != 2) break;  // transparency
      --page.num_components;
    }
  }
}

// After the type and compression.
void TiffFile::set_colours(TiffPage& page, const Directory& directory) const {
  enum : std::uint64_t { kWhiteIsZero, kBlackIsZero, kRgb, kPalette, kMask, kYcbcr = 6 };
  const TiffField* const field = directory.find(kPhotometric);
  const std::uint64_t photometric = field == nullptr ? kBlackIsZero : number(*field);
  const bool is_jpeg = page.compression == kTiffJpeg;
  page.is_ycbcr = is_jpeg && photometric == kYcbcr;
  if (photometric > kMask && photometric < 32768 && !page.is_ycbcr) {
    refuse(page.number,
           fmt::format("has colours of kind {}: expected grey, red, green and blue, or "
                       "numbers of a palette",
                       photometric));
  }
  page.is_white_zero = photometric == kWhiteIsZero;
  page.is_palette = photometric == kPalette;
  page.is_stretched = page.bits < 8 && photometric <= kBlackIsZero;
  if (is_jpeg && (page.bits != 8 || page.type != ScalarType::kUInt8)) {
    refuse(page.number, fmt::format("has JPEG of {} in {} bits: expected uint8 in 8",
                                    name_of(page.type), page.bits));
  }
  if (page.is_ycbcr && (page.num_samples != 3 || page.is_planar)) {
    refuse(page.number, fmt::format("has YCbCr colours of {} samples{}: expected three, together",
                                    page.num_samples, page.is_planar ? ", in planes" : ""));
  }
}

void TiffFile::set_blocks(TiffPage& page, const Directory& directory) const {
  const auto size = [&](std::uint16_t tag, std::int64_t otherwise) {
    const TiffField* const field = directory.find(tag);
    const std::uint64_t value =
        field == nullptr ? static_cast<std::uint64_t>(otherwise) : number(*field);
    return static_cast<std::int64_t>(
        std::min<std::uint64_t>(value, static_cast<std::uint64_t>(kMaxNumBytes)));
  };
  const bool is_tiled = directory.find(kTileOffsets) != nullptr;
  const TiffField* const offsets = directory.find(is_tiled ? kTileOffsets : kStripOffsets);
  if (offsets == nullptr) fail(fmt::format("page {} has no samples", page.number));
  page.offsets = *offsets;
  const TiffField* byte_counts = directory.find(is_tiled ? kTileByteCounts : kStripByteCounts);
  // Some writers put tiles' byte counts under the name of strips'.
  if (byte_counts == nullptr) byte_counts = directory.find(kStripByteCounts);
  if (byte_counts != nullptr) page.byte_counts = *byte_counts;
  page.block_width = is_tiled ? size(kTileWidth, 0) : page.width;
  page.block_height = is_tiled ? size(kTileHeight, 0) : size(kRowsPerStrip, page.height);
  if (!is_tiled) page.block_height = std::min(page.block_height, page.height);
  if (page.block_width < 1 || page.block_height < 1 || page.block_width > kMaxAxisSize ||
      page.block_height > kMaxAxisSize)
    fail(fmt::format("page {} has strips or tiles of no size", page.number));
}

void TiffFile::set_compression(TiffPage& page, const Directory& directory) const {
  const auto value = [&](std::uint16_t tag) {
    const TiffField* const field = directory.find(tag);
    return static_cast<int>((field == nullptr ? 1 : number(*field)) & 0xffffU);
  };
  page.compression = value(kCompression);
  if (!is_read_compression(page.compression)) {
    refuse(page.number,
           fmt::format("is compressed by {}, which is not read: expected none, LZW, deflate (zip), "
                       "Zstandard, PackBits or JPEG",
                       tiff_compression_name(page.compression)));
  }
  page.predictor = value(kPredictor);
  if (page.compression != kTiffLzw && page.compression != kTiffDeflate &&
      page.compression != kTiffOldDeflate && page.compression != kTiffZstandard)
    page.predictor = 1;
  const bool is_integer = !is_floating(page.type) && page.short_float == ShortFloat::kNone;
  if (page.predictor != 1 && !(page.predictor == 2 && page.bits % 8 == 0 && page.bits != 24) &&
      !(page.predictor == 3 && !is_integer))
    refuse(page.number, fmt::format("has predictor {} of {} bits", page.predictor, page.bits));
  if (page.compression != kTiffJpeg) return;
  if (const TiffField* const tables = directory.find(kJpegTables)) page.jpeg_tables = *tables;
}

TiffPage TiffFile::page_of(const Directory& directory, std::int64_t number_in_file) const {
  TiffPage page;
  page.number = number_in_file;
  page.directory = directory.at;
  const auto value = [&](std::uint16_t tag, std::uint64_t otherwise) {
    const TiffField* const field = directory.find(tag);
    return field == nullptr ? otherwise : number(*field);
  };
  const std::uint64_t width = value(kWidth, 0), height = value(kHeight, 0);
  constexpr auto kMost = static_cast<std::uint64_t>(kMaxAxisSize);
  if (width == 0 || height == 0 || width > kMost || height > kMost) {
    fail(fmt::format("page {} has {} x {} pixels: expected 1 to {} each", number_in_file, width,
                     height, kMaxAxisSize));
  }
  page.width = static_cast<std::int64_t>(width);
  page.height = static_cast<std::int64_t>(height);
  set_type(page, directory);
  checked_num_bytes(fmt::format("{}: page {}", source_.name(), page.number),
                    std::array{page.width, page.height}, page.type, page.num_samples);
  set_compression(page, directory);
  if (const std::uint64_t depth = value(kImageDepth, 1); depth > 1) {
    refuse(page.number,
           fmt::format("holds {} slices in one page (ImageDepth), which is not read: expected a "
                       "page for each slice",
                       depth));
  }
  if (value(kFillOrder, 1) != 1 && page.bits < 8)
    refuse(page.number, "has its bits in the other order (FillOrder 2)");
  page.is_planar = value(kPlanar, 1) == 2 && page.num_samples > 1;
  set_colours(page, directory);
  set_blocks(page, directory);
  return page;
}

std::string TiffFile::text(const TiffField& field) const {
  check_inside(field.at, field.count, "description");
  std::string result = source_.text(field.at, static_cast<std::int64_t>(field.count));
  while (result.ends_with('\0')) result.pop_back();
  return result;
}

std::vector<std::string> TiffFile::descriptions(const TiffPage& page) const {
  std::vector<std::string> result;
  for (const TiffField& field : directory_at(page.directory).fields)
    if (field.tag == kDescription) result.push_back(text(field));
  return result;
}

std::uint64_t TiffFile::num_values(std::uint16_t tag) const noexcept {
  const auto found = std::find_if(first_fields_.begin(), first_fields_.end(),
                                  [&](const TiffField& field) { return field.tag == tag; });
  return found == first_fields_.end() ? 0 : found->count;
}

bool TiffFile::is_described_within(std::int64_t begin, std::int64_t end) const noexcept {
  const auto is_within = [&](std::int64_t at) { return at >= begin && at < end; };
  return is_within(pages_[0].directory) ||
         std::any_of(first_fields_.begin(), first_fields_.end(),
                     [&](const TiffField& field) { return is_within(field.at); });
}

void TiffFile::describe(const Directory& directory) {
  first_fields_ = directory.fields;
  if (const TiffField* const field = directory.find(kDescription)) description_ = text(*field);
  const TiffField* const x = directory.find(kXResolution);
  const TiffField* const y = directory.find(kYResolution);
  if (x == nullptr || y == nullptr) return;
  const auto along_x = rational(*x), along_y = rational(*y);
  if (!along_x || !along_y) return;
  resolution_ = {*along_x, *along_y, 2};
  if (const TiffField* const unit = directory.find(kResolutionUnit))
    resolution_->unit = static_cast<int>(number(*unit) & 0xffU);
}

TiffFile::TiffFile(const ByteSource& source) : source_(source) {
  const std::string start = source_.text(0, 16);
  if (!looks_like_tiff(start)) fail("is no TIFF file");
  is_big_endian_ = start[0] == 'M';
  is_big_tiff_ = start[is_big_endian_ ? 3 : 2] == '+';
  if (is_big_tiff_ && (number_at(4, 2) != 8 || number_at(6, 2) != 0))
    fail("has BigTIFF's number, but offsets of another size than 8 bytes");
  std::uint64_t next = number_at(is_big_tiff_ ? 8 : 4, is_big_tiff_ ? 8 : 4);
  // Each byte belongs to one directory at most: what takes more is a loop.
  std::int64_t num_bytes = 0;
  for (std::int64_t i = 0; next != 0; ++i) {
    if (next > static_cast<std::uint64_t>(source_.size())) fail("its next page is behind its end");
    const Directory directory = directory_at(static_cast<std::int64_t>(next));
    num_bytes += directory.num_bytes;
    if (num_bytes > source_.size()) fail("its pages lead back to each other");
    next = static_cast<std::uint64_t>(directory.next);
    const TiffField* const kind = directory.find(kSubfileType);
    constexpr std::uint64_t kReduced = 1, kMask = 4;
    if (kind != nullptr && (number(*kind) & (kReduced | kMask)) != 0) {
      ++num_left_out_;
      continue;
    }
    if (pages_.size() == kMaxTiffPages)
      refuse(i, fmt::format("the file has more than {} pages", kMaxTiffPages));
    pages_.push_back(page_of(directory, i));
    if (pages_.size() == 1) describe(directory);
  }
  if (pages_.empty()) fail("has no pages");
  check_sizes();
}

void TiffFile::check_sizes() const {
  const TiffPage& first = pages_[0];
  const auto text = [](const TiffPage& page) {
    return fmt::format("{} x {} pixels of {}{}", page.width, page.height,
                       stored_name(page.type, page.short_float),
                       page.num_components > 1 ? fmt::format(" x {}", page.num_components) : "");
  };
  for (const TiffPage& page : pages_) {
    if (page.width == first.width && page.height == first.height && page.type == first.type &&
        page.short_float == first.short_float && page.num_components == first.num_components &&
        page.bits == first.bits)
      continue;
    refuse(page.number, fmt::format("has {}, page {} has {}: the pages of a volume are of one size "
                                    "and type",
                                    text(page), first.number, text(first)));
  }
}

std::size_t TiffFile::page_of_directory(std::int64_t number_in_file) const {
  const auto found = std::lower_bound(
      pages_.begin(), pages_.end(), number_in_file,
      [](const TiffPage& page, std::int64_t wanted) { return page.number < wanted; });
  if (found == pages_.end() || found->number != number_in_file)
    fail(fmt::format("its description names page {}, which is not there", number_in_file));
  return static_cast<std::size_t>(found - pages_.begin());
}

// How a page's strips or tiles cover it, and memory for one of them.
struct TiffFile::Blocks {
  std::vector<std::uint64_t> offsets, byte_counts;
  std::int64_t across = 1, down = 1, planes = 1;
  TiffRows rows;
  std::vector<std::byte> jpeg_tables, packed, unpacked, spread;
};

// One of them: its place in the grid of blocks.
struct TiffFile::BlockPlace {
  std::int64_t plane = 0, y = 0, x = 0;
};

TiffFile::Blocks TiffFile::blocks_of(const TiffPage& page) const {
  Blocks blocks;
  blocks.offsets = numbers(page.offsets, "offsets of strips or tiles");
  if (page.byte_counts.count > 0)
    blocks.byte_counts = numbers(page.byte_counts, "byte counts of strips or tiles");
  if (page.jpeg_tables.count > 0) {
    constexpr std::uint64_t kMostTables = std::uint64_t{1} << 20;  // a few thousand in practice
    check_inside(page.jpeg_tables.at, page.jpeg_tables.count, "JPEG tables");
    if (page.jpeg_tables.count > kMostTables)
      fail(fmt::format("its JPEG tables have {} bytes, more than any", page.jpeg_tables.count));
    blocks.jpeg_tables.resize(static_cast<std::size_t>(page.jpeg_tables.count));
    source_.read(page.jpeg_tables.at, blocks.jpeg_tables);
  }
  const auto up = [](std::int64_t a, std::int64_t b) { return (a - 1) / b + 1; };
  blocks.across = up(page.width, page.block_width);
  blocks.down = up(page.height, page.block_height);
  blocks.planes = page.is_planar ? page.num_samples : 1;
  const std::array counts{blocks.across, blocks.down, blocks.planes};
  if (checked_product(counts).value_or(kMaxNumBytes) >
      static_cast<std::int64_t>(blocks.offsets.size())) {
    fail(fmt::format("page {} has {} strips or tiles, too few for its size", page.number,
                     blocks.offsets.size()));
  }
  const std::int64_t in_pixel = page.is_planar ? 1 : page.num_samples;
  const std::int64_t row_bits = page.block_width * in_pixel * page.bits;  // below 2^49
  blocks.rows.row_size = static_cast<std::size_t>(up(row_bits, 8));
  blocks.rows.num_in_row = static_cast<std::size_t>(page.block_width * in_pixel);
  blocks.rows.num_samples = static_cast<int>(in_pixel);
  blocks.rows.bits = page.bits;
  blocks.rows.is_big_endian = is_big_endian_;
  return blocks;
}

// Unpacks the rows of a block that lie within the page. The last strip is short, tiles are whole.
void TiffFile::read_block(const TiffPage& page, const BlockPlace& at, Blocks& blocks) const {
  const auto index =
      static_cast<std::size_t>((at.plane * blocks.down + at.y) * blocks.across + at.x);
  const std::int64_t num_rows = std::min(page.block_height, page.height - at.y * page.block_height);
  const std::array sizes{static_cast<std::int64_t>(blocks.rows.row_size), num_rows};
  const std::int64_t size = checked_product(sizes).value_or(kMaxNumBytes);
  const std::uint64_t count = index < blocks.byte_counts.size() ? blocks.byte_counts[index]
                                                                : static_cast<std::uint64_t>(size);
  const std::uint64_t used =
      page.compression == kTiffPlain ? std::min(count, static_cast<std::uint64_t>(size)) : count;
  if (blocks.offsets[index] > static_cast<std::uint64_t>(kMaxNumBytes))
    fail(fmt::format("page {}: a strip or tile is behind its end", page.number));
  const auto offset = static_cast<std::int64_t>(blocks.offsets[index]);
  check_inside(offset, used, fmt::format("page {}", page.number).c_str());
  if (size / max_tiff_ratio(page.compression) > static_cast<std::int64_t>(used) + 16) {
    fail(fmt::format("page {}: a strip or tile has {} bytes, too few for its {}", page.number, used,
                     size));
  }
  blocks.packed.resize(static_cast<std::size_t>(used));
  source_.read(offset, blocks.packed);
  blocks.unpacked.resize(static_cast<std::size_t>(size));
  const std::string wrong =
      page.compression == kTiffJpeg
          ? unpack_tiff_jpeg({blocks.jpeg_tables, page.block_width, page.block_height,
                              blocks.rows.num_samples, page.is_ycbcr},
                             blocks.packed, blocks.unpacked)
          : unpack_tiff(page.compression, blocks.packed, blocks.unpacked);
  if (!wrong.empty()) fail(fmt::format("page {}: a strip or tile {}", page.number, wrong));
  finish_tiff_rows(page.predictor, blocks.rows, blocks.unpacked);
}

// A block's pixels to their places, without transparency.
void TiffFile::place_block(const TiffPage& page, const BlockPlace& at, Blocks& blocks,
                           std::span<std::byte> out) {
  const std::size_t size = size_of(page.type), row_size = blocks.rows.row_size;
  const std::int64_t x0 = at.x * page.block_width, y0 = at.y * page.block_height;
  const auto num_columns = static_cast<std::size_t>(std::min(page.block_width, page.width - x0));
  const std::size_t num_rows = blocks.unpacked.size() / row_size;
  const std::size_t stride = static_cast<std::size_t>(page.num_components) * size;
  const std::size_t kept = page.is_planar ? size : stride;
  const std::size_t from_stride = static_cast<std::size_t>(blocks.rows.num_samples) * size;
  for (std::size_t y = 0; y < num_rows; ++y) {
    std::span<const std::byte> row = std::span(blocks.unpacked).subspan(y * row_size, row_size);
    if (page.bits % 8 != 0) {
      blocks.spread.resize(blocks.rows.num_in_row * size);
      spread_tiff_bits(row, page.bits, page.is_stretched ? 255 : 0, blocks.spread);
      row = blocks.spread;
    }
    const std::int64_t pixel = (y0 + static_cast<std::int64_t>(y)) * page.width + x0;
    const std::size_t to =
        static_cast<std::size_t>(pixel) * stride + static_cast<std::size_t>(at.plane) * size;
    if (kept == stride && from_stride == stride) {
      std::memcpy(&out[to], row.data(), num_columns * stride);
      continue;
    }
    for (std::size_t x = 0; x < num_columns; ++x)
      std::memcpy(&out[to + x * stride], &row[x * from_stride], kept);
  }
}

void TiffFile::read(const TiffPage& page, std::span<std::byte> out) const {
  Blocks blocks = blocks_of(page);
  const std::int64_t num_planes = std::min<std::int64_t>(blocks.planes, page.num_components);
  for (BlockPlace at; at.plane < num_planes; ++at.plane) {
    for (at.y = 0; at.y < blocks.down; ++at.y) {
      for (at.x = 0; at.x < blocks.across; ++at.x) {
        read_block(page, at, blocks);
        place_block(page, at, blocks, out);
      }
    }
  }
}

std::optional<TiffRun> TiffFile::run(std::int64_t num_pages) const {
  const TiffPage& first = pages_[0];
  if (num_pages != static_cast<std::int64_t>(pages_.size()) && pages_.size() != 1)
    return std::nullopt;
  if (first.compression != kTiffPlain || first.bits % 8 != 0 || first.is_planar ||
      first.num_components != first.num_samples || first.block_width != first.width)
    return std::nullopt;
  TiffRun run{0, num_pages};
  std::int64_t next = -1;
  for (const TiffPage& page : pages_) {
    if (page.compression != kTiffPlain || page.is_planar || page.block_width != page.width ||
        page.num_samples != first.num_samples)
      return std::nullopt;
    const std::vector<std::uint64_t> offsets = numbers(page.offsets, "offsets of strips or tiles");
    const std::int64_t strip_bytes =
        page.block_height * page.width * page.num_components *
        static_cast<std::int64_t>(size_of(page.type));  // below num_bytes(), which was checked
    const auto num_strips = static_cast<std::size_t>((page.height - 1) / page.block_height + 1);
    if (offsets.size() < num_strips) return std::nullopt;
    for (std::size_t i = 0; i < num_strips; ++i) {
      if (offsets[i] > static_cast<std::uint64_t>(kMaxNumBytes)) return std::nullopt;
      const auto at = static_cast<std::int64_t>(offsets[i]);
      if (next >= 0 && at != next) return std::nullopt;
      if (next < 0) run.offset = at;
      next =
          at + (i + 1 < num_strips ? strip_bytes
                                   : page.num_bytes() - static_cast<std::int64_t>(i) * strip_bytes);
    }
  }
  return run;
}

bool has_tiff_pages(const ByteSource& source) {
  try {
    return TiffFile(source).pages().size() > 1;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace ovoid::io
