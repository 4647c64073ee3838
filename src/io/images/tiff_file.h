// SPDX-License-Identifier: Apache-2.0
// TIFF [TIFF 1992] as it holds samples: pages of strips or tiles, of integers and floats. Read here
// and not by libtiff, which distributions build on JBIG-KIT, which is GPL. Nothing is believed
// before it has been compared with the file's size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/short_floats.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// At most so many pages; a page has a description in memory.
inline constexpr std::size_t kMaxTiffPages = 1'000'000;

bool looks_like_tiff(std::string_view start);

// A field of a directory: where its values are.
struct TiffField {
  std::uint16_t tag = 0, type = 0;
  std::uint64_t count = 0;
  std::int64_t at = 0;
};

// What one page holds, and how.
struct TiffPage {
  std::int64_t number = 0;  // in the file, from 0, for messages
  std::int64_t directory = 0;
  std::int64_t width = 0, height = 0;
  std::int64_t block_width = 0, block_height = 0;  // of strips or tiles
  int bits = 1;                                    // of a sample, as stored
  int num_samples = 1;                             // of a pixel, as stored
  int num_components = 1;                          // without transparency, which comes last
  ScalarType type = ScalarType::kUInt8;            // that samples become; of halves, their bits
  ShortFloat short_float = ShortFloat::kNone;
  int compression = 1, predictor = 1;
  bool is_planar = false;     // each component has blocks of its own
  bool is_stretched = false;  // grey of fewer than 8 bits becomes one of 8
  bool is_white_zero = false, is_palette = false;
  bool is_ycbcr = false;           // in JPEG; read as red, green and blue
  TiffField offsets, byte_counts;  // of the blocks
  TiffField jpeg_tables;           // that the blocks share

  std::int64_t num_pixels() const noexcept { return width * height; }
  std::int64_t num_bytes() const noexcept {
    return num_pixels() * num_components * static_cast<std::int64_t>(size_of(type));
  }
};

// Where one page begins behind another without anything between: samples of many pages in a row.
struct TiffRun {
  std::int64_t offset = 0;
  std::int64_t num_pages = 0;
};

// The pages of a file, which must outlive it. All members throw Error(kFileFormat) that names the
// file and what is wrong, kUnsupported for what is sound and is not read. May be used from many
// threads.
class TiffFile {
 public:
  // Reads all directories; pages in miniature and of lower resolution are passed over.
  explicit TiffFile(const ByteSource& source);

  const ByteSource& source() const noexcept { return source_; }
  bool is_big_endian() const noexcept { return is_big_endian_; }
  // At least one; all of one size, kind and type, else the constructor throws.
  const std::vector<TiffPage>& pages() const noexcept { return pages_; }
  std::int64_t num_left_out() const noexcept { return num_left_out_; }
  std::size_t page_of_directory(std::int64_t number) const;

  // Of the first page; empty if it has none.
  const std::string& description() const noexcept { return description_; }
  // All that a page has: some writers put a second one behind the user's.
  std::vector<std::string> descriptions(const TiffPage& page) const;
  // How many values the first page's field of this tag has; 0 if there is none.
  bool has_field(std::uint16_t tag) const noexcept { return num_values(tag) > 0; }
  std::uint64_t num_values(std::uint16_t tag) const noexcept;
  // Pixels per unit along x and y, where both are there and greater than 0; the unit as TIFF
  // numbers it: 1 none, 2 inch, 3 centimetre.
  struct Resolution {
    double x = 0, y = 0;
    int unit = 2;
  };
  const std::optional<Resolution>& resolution() const noexcept { return resolution_; }

  // A page's samples to `out`, of page.num_bytes(): row by row, components interleaved, native
  // byte order. Memory: a strip or tile.
  void read(const TiffPage& page, std::span<std::byte> out) const;

  // Where the samples of all pages lie in a row and uncompressed, as they are to be.
  // A file of ImageJ's with one directory may hold `num_pages` of them.
  std::optional<TiffRun> run(std::int64_t num_pages) const;
  // Do these bytes hold the first page's directory, or begin a value of its fields? Then they are
  // no samples.
  bool is_described_within(std::int64_t begin, std::int64_t end) const noexcept;

 private:
  struct Directory;
  struct Blocks;
  struct BlockPlace;

  std::uint64_t number_at(std::int64_t at, int size) const;
  void check_inside(std::int64_t at, std::uint64_t size, const char* what) const;
  Directory directory_at(std::int64_t at) const;
  std::vector<std::uint64_t> numbers(const TiffField& field, const char* what) const;
  std::uint64_t number(const TiffField& field) const;
  std::optional<double> rational(const TiffField& field) const;
  TiffPage page_of(const Directory& directory, std::int64_t number) const;
  void set_compression(TiffPage& page, const Directory& directory) const;
  void set_type(TiffPage& page, const Directory& directory) const;
  void set_colours(TiffPage& page, const Directory& directory) const;
  void set_blocks(TiffPage& page, const Directory& directory) const;
  std::string text(const TiffField& field) const;
  void describe(const Directory& directory);
  Blocks blocks_of(const TiffPage& page) const;
  void read_block(const TiffPage& page, const BlockPlace& at, Blocks& blocks) const;
  static void place_block(const TiffPage& page, const BlockPlace& at, Blocks& blocks,
                          std::span<std::byte> out);
  void check_sizes() const;
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void refuse(std::int64_t page, const std::string& what) const;

  const ByteSource& source_;
  bool is_big_endian_ = false;
  bool is_big_tiff_ = false;
  std::vector<TiffPage> pages_;
  std::int64_t num_left_out_ = 0;
  std::string description_;
  std::vector<TiffField> first_fields_;  // of the first page
  std::optional<Resolution> resolution_;
};

// Whether the file has several pages; false for what cannot be read.
bool has_tiff_pages(const ByteSource& source);

}  // namespace ovoid::io
