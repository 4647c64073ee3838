// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vtk_xml_base64.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string_view>
#include <vector>

#include "io/core/base64.h"
#include "io/core/memory.h"
#include "io/core/numbers.h"
#include "io/core/text_scanner.h"
#include "io/core/xml_tags.h"

namespace ovoid::io {
namespace {

// Where base64 stands in the file, and how its arrays begin.
struct Base64Places {
  struct Piece {
    std::size_t begin = 0, end = 0;
  };
  std::vector<Piece> within_tags;
  std::set<std::size_t> offsets;  // of appended arrays
  Piece appended;                 // behind '_'; empty: none in base64
  std::size_t word_size = 4;      // bytes of a number in an array's header
  bool is_compressed = false;
  bool is_big_endian = false;
};

void read_appended(const ByteSource& source, const XmlTag& tag, Base64Places& places) {
  if (tag.attribute("encoding") == "raw") return;
  const std::string text = source.text(tag.end, source.size());
  const std::size_t begin = text.find('_');
  if (begin == std::string::npos) return;
  const auto at = static_cast<std::size_t>(tag.end);
  places.appended = {at + begin + 1, at + std::min(text.find('<'), text.size())};
}

Base64Places base64_places(const ByteSource& source) {
  Base64Places places;
  XmlTagReader reader(source);
  bool is_open = false;  // the last piece within tags, until the next tag comes
  while (const auto tag = reader.next()) {
    if (is_open) places.within_tags.back().end = static_cast<std::size_t>(tag->begin);
    is_open = false;
    if (tag->name == "VTKFile") {
      places.word_size = tag->attribute("header_type", "UInt32") == "UInt64" ? 8 : 4;
      places.is_compressed = !tag->attribute("compressor").empty();
      places.is_big_endian = tag->attribute("byte_order") == "BigEndian";
    }
    const std::string format = tag->attribute("format");
    if (format == "binary" && !tag->is_empty_element) {
      places.within_tags.push_back({static_cast<std::size_t>(tag->end), 0});
      is_open = true;
    }
    if (format == "appended") {
      const auto offset = parse_integer(tag->attribute("offset"));
      if (offset && *offset >= 0) places.offsets.insert(static_cast<std::size_t>(*offset));
    }
    if (tag->name == "AppendedData") {
      read_appended(source, *tag, places);
      break;  // bytes that may look like anything follow
    }
  }
  if (is_open) places.within_tags.pop_back();
  return places;
}

class ArrayBytes {
 public:
  ArrayBytes(const Base64Places& places, std::string_view text)
      : places_(places), bytes_(decoded_base64(text)) {}

  // Whether the array's own header states what there is.
  bool is_whole() const {
    const std::size_t header = header_size();
    if (header == 0 || header > bytes_.size()) return false;
    std::uint64_t stated = places_.is_compressed ? 0 : word(0);
    for (std::size_t i = 3; places_.is_compressed && i < header / places_.word_size; ++i)
      stated += std::min<std::uint64_t>(word(i), bytes_.size() + 1);
    return stated == bytes_.size() - header;
  }

  // As VTK writes it; all together where the header is none.
  std::string text() const {
    const std::size_t header = places_.is_compressed ? header_size() : 0;
    if (header == 0 || header > bytes_.size()) return encoded_base64(bytes_);
    const std::string_view all = bytes_;
    return encoded_base64(all.substr(0, header)) + encoded_base64(all.substr(header));
  }

 private:
  // Of compressed arrays: the number of blocks, two sizes, and that of each block.
  std::size_t header_size() const {
    if (bytes_.size() < places_.word_size) return 0;
    if (!places_.is_compressed) return places_.word_size;
    const std::uint64_t num_blocks = word(0);
    return num_blocks > bytes_.size() ? 0 : (3 + num_blocks) * places_.word_size;
  }

  std::uint64_t word(std::size_t index) const {
    return unsigned_of(
        std::string_view(bytes_).substr(index * places_.word_size, places_.word_size),
        places_.is_big_endian);
  }

  const Base64Places& places_;
  std::string bytes_;
};

// The pieces of appended text between the offsets, each as VTK writes it and with blanks behind it,
// so that the next stays where it is. Empty unless each piece is a whole array that has room.
std::optional<std::string> plain_pieces(const Base64Places& places, std::string_view text) {
  std::string plain(text.size(), ' ');
  for (auto offset = places.offsets.begin(); offset != places.offsets.end(); ++offset) {
    const auto next = std::next(offset);
    const std::size_t end = next == places.offsets.end() ? text.size() : *next;
    if (*offset >= text.size() || end > text.size()) return std::nullopt;
    const ArrayBytes bytes(places, text.substr(*offset, end - *offset));
    const std::string piece = bytes.text();
    if (!bytes.is_whole() || piece.size() > end - *offset) return std::nullopt;
    plain.replace(*offset, piece.size(), piece);
  }
  return plain;
}

std::string without_blanks(std::string_view text) {
  std::string result(text);
  std::erase_if(result, [](char c) { return is_blank(c); });
  return result;
}

}  // namespace

std::optional<std::string> with_plain_base64(const ByteSource& source) {
  const Base64Places places = base64_places(source);
  if (places.within_tags.empty() && places.appended.end == 0) return std::nullopt;
  require_memory(source.name() + ": its base64", 2 * source.size());
  const std::string whole = source.text(0, source.size());
  const std::string_view all = whole;
  std::string plain;
  plain.reserve(whole.size());
  std::size_t copied = 0;
  const auto replace = [&](const Base64Places::Piece& piece, std::string_view text) {
    plain += all.substr(copied, piece.begin - copied);
    plain += text;
    copied = piece.end;
  };
  for (const Base64Places::Piece& piece : places.within_tags) {
    const std::string_view text = all.substr(piece.begin, piece.end - piece.begin);
    replace(piece, ArrayBytes(places, text).text() + "\n");
  }
  if (places.appended.end > places.appended.begin && !places.offsets.empty()) {
    const Base64Places::Piece& piece = places.appended;
    const std::string_view text = all.substr(piece.begin, piece.end - piece.begin);
    auto pieces = plain_pieces(places, text);
    if (!pieces) pieces = plain_pieces(places, without_blanks(text));
    if (pieces) replace(piece, *pieces);
  }
  plain += all.substr(copied);
  return plain;
}

}  // namespace ovoid::io
