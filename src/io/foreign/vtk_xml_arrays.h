// SPDX-License-Identifier: Apache-2.0
// The arrays of VTK's XML files as they are stored: within the tags or appended, as text, base64 or
// bytes, compressed or not.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/text_scanner.h"

namespace ovoid::io {

inline constexpr std::int64_t kZlibRatio =
    1032;  // bytes out per byte in, at most (its technical notes)

// What one DataArray element says, and where its bytes begin.
struct StoredArray {
  std::string name;
  std::string layout;  // "262144 tuples of 1 Float32"
  std::int64_t num_values = 0;
  std::int64_t num_bytes = 0;
  std::string format;  // ascii, binary, appended
  NumberKind kind = NumberKind::kInteger;
  bool is_text = false;  // strings: num_bytes is the least they can take
  int cell_list = -1;    // which list of cells it belongs to, as offsets or node numbers
  bool are_offsets = false;
  bool has_free_size = false;  // node numbers: as many as the last offset says
  std::int64_t value_size = 0;
  std::int64_t position = 0;  // inline: offset in the file; appended: from the '_'
  std::int64_t text_end = 0;  // inline: offset behind the text
};

// Looks at stored arrays without reading them. What the file says of all its arrays is set before.
class XmlArrays {
 public:
  explicit XmlArrays(const ByteSource& source) : source_(source) {}

  bool is_big_endian = false;
  bool is_compressed = false;
  bool is_appended_raw = false;
  std::int64_t word_size = 4;  // bytes of a number in an array's own header
  std::int64_t max_ratio = 1;  // bytes out per byte in, at most
  std::int64_t appended_begin = 0;

  // Throws Error(kFileFormat) unless the array's own header states its size and its numbers are all
  // there.
  void check(const StoredArray& array) const;

  // Throws Error(kFileFormat) if no file of this size can hold so many bytes.
  void check_ratio(const std::string& what, std::int64_t num_bytes) const;

  // Bytes of samples that the array's own header states.
  std::int64_t num_stated(const StoredArray& array) const;

  // The last of the integers of an array that check() has passed; empty if a compressor other than
  // zlib hides it, -1 if it is larger than any file.
  std::optional<std::int64_t> last_value(const StoredArray& array) const;

 private:
  // What an array's own header says.
  struct StoredSize {
    std::uint64_t num_stated = 0;  // bytes of samples
    std::int64_t num_header = 0;   // bytes of the header
    std::int64_t num_data = 0;     // bytes behind it
  };
  std::string stored_bytes(const StoredArray& array, std::int64_t offset, std::size_t count) const;
  std::string inflated_end(const StoredArray& array, std::size_t count) const;
  std::string base64_behind(const StoredArray& array, std::int64_t num_digits, std::int64_t offset,
                            std::size_t count) const;
  bool is_base64(const StoredArray& array) const;
  std::int64_t data_begin(const StoredArray& array) const;
  std::int64_t data_end(const StoredArray& array) const;
  std::vector<std::uint64_t> read_words(const StoredArray& array, std::size_t count) const;
  void check_text(const StoredArray& array, const std::string& what) const;
  StoredSize plain_size(const StoredArray& array) const;
  std::vector<std::uint64_t> stated_words(const StoredArray& array, std::size_t count) const;
  StoredSize compressed_size(const StoredArray& array) const;
  void check_stored(const StoredArray& array, const std::string& what,
                    const StoredSize& size) const;
  std::int64_t num_base64_digits(std::int64_t begin, std::int64_t end,
                                 std::int64_t num_bytes) const;

  const ByteSource& source_;
};

}  // namespace ovoid::io
