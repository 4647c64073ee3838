// SPDX-License-Identifier: Apache-2.0
// For tests and fuzzing: DICOM files, written element by element. Knows nothing of the reader.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/core/test_deflate.h"

namespace ovoid::io {

// Data elements in one of the syntaxes; the caller writes them in the order of their tags.
class DicomElements {
 public:
  enum class Syntax { kImplicit, kExplicit, kBig };

  DicomElements() = default;
  explicit DicomElements(Syntax syntax) : syntax_(syntax) {}

  const std::string& bytes() const { return bytes_; }
  Syntax syntax() const { return syntax_; }

  DicomElements& text(std::uint32_t tag, const std::string& vr, std::string value) {
    if (value.size() % 2 != 0) value += vr == "UI" ? '\0' : ' ';
    return raw(tag, vr, value);
  }
  DicomElements& us(std::uint32_t tag, std::uint16_t value) { return raw(tag, "US", word(value)); }
  DicomElements& raw(std::uint32_t tag, const std::string& vr, const std::string& value) {
    header(tag, vr, static_cast<std::uint32_t>(value.size()));
    bytes_ += value;
    return *this;
  }
  // A value of undefined length, as it stands: a delimiter of its own ends it.
  DicomElements& undefined(std::uint32_t tag, const std::string& vr, const std::string& value) {
    header(tag, vr, 0xFFFFFFFF);
    bytes_ += value;
    return *this;
  }
  // A sequence of items with these elements, all lengths defined or none.
  DicomElements& sequence(std::uint32_t tag, const std::vector<DicomElements>& items,
                          bool is_defined = true) {
    std::string value;
    for (const DicomElements& item : items) {
      const auto size = static_cast<std::uint32_t>(item.bytes_.size());
      value += tag_bytes(0xFFFEE000) + long_word(is_defined ? size : 0xFFFFFFFF) + item.bytes_;
      if (!is_defined) value += tag_bytes(0xFFFEE00D) + long_word(0);
    }
    if (is_defined) return raw(tag, "SQ", value);
    return undefined(tag, "SQ", value + tag_bytes(0xFFFEE0DD) + long_word(0));
  }
  DicomElements& operator+=(const DicomElements& other) {
    bytes_ += other.bytes_;
    return *this;
  }

  // Numbers in the byte order of the syntax.
  std::string word(std::uint16_t value) const {
    const char low = static_cast<char>(value & 0xFF), high = static_cast<char>(value >> 8);
    return syntax_ == Syntax::kBig ? std::string{high, low} : std::string{low, high};
  }
  std::string long_word(std::uint32_t value) const {
    const auto low = static_cast<std::uint16_t>(value & 0xFFFF);
    const auto high = static_cast<std::uint16_t>(value >> 16);
    return syntax_ == Syntax::kBig ? word(high) + word(low) : word(low) + word(high);
  }

 private:
  std::string tag_bytes(std::uint32_t tag) const {
    return word(static_cast<std::uint16_t>(tag >> 16)) +
           word(static_cast<std::uint16_t>(tag & 0xFFFF));
  }
  void header(std::uint32_t tag, const std::string& vr, std::uint32_t length) {
    bytes_ += tag_bytes(tag);
    if (syntax_ == Syntax::kImplicit) {
      bytes_ += long_word(length);
      return;
    }
    const bool is_long = vr == "OB" || vr == "OW" || vr == "OF" || vr == "OD" || vr == "SQ" ||
                         vr == "UN" || vr == "UT";
    bytes_ +=
        vr + (is_long ? word(0) + long_word(length) : word(static_cast<std::uint16_t>(length)));
  }

  Syntax syntax_ = Syntax::kExplicit;
  std::string bytes_;
};

inline constexpr const char* kImplicitUid = "1.2.840.10008.1.2";
inline constexpr const char* kExplicitUid = "1.2.840.10008.1.2.1";
inline constexpr const char* kBigUid = "1.2.840.10008.1.2.2";
inline constexpr const char* kDeflatedUid = "1.2.840.10008.1.2.1.99";

// Preamble and meta information before a data set.
inline std::string dicom_file(const std::string& uid, const std::string& data_set) {
  DicomElements rest;
  rest.text(0x00020010, "UI", uid);
  DicomElements meta;
  meta.raw(0x00020000, "UL", rest.long_word(static_cast<std::uint32_t>(rest.bytes().size())));
  return std::string(128, '\0') + "DICM" + meta.bytes() + rest.bytes() + data_set;
}

// One CT slice of 3 x 2 samples of 16 bits; empty texts are left out.
struct TestSlice {
  std::string uid = kExplicitUid;  // transfer syntax
  std::string sop = "1.2.3";
  std::string series = "1.2";
  std::string series_number = "4";
  std::string instance = "1";
  std::string position = "-10\\20\\5";
  std::string orientation = "1\\0\\0\\0\\1\\0";
  std::string spacing = "2\\0.5";  // rows, columns
  std::string thickness = "3";
  std::string slope = "2", intercept = "-1000";
  std::string photometric = "MONOCHROME2";
  std::string trigger_time, echo_time, temporal_position, num_frames;
  std::uint16_t rows = 2, columns = 3;
  std::uint16_t allocated = 16, stored = 12, high_bit = 11, is_signed = 0, samples = 1;
  std::string pixels;            // in the syntax's byte order; empty: 1, 2, 3, ...
  DicomElements groups;          // elements between those of group 0028 and the pixels
  bool is_encapsulated = false;  // `pixels` is the items' bytes with the delimiter
};

inline DicomElements::Syntax syntax_of(const std::string& uid) {
  return uid == kImplicitUid ? DicomElements::Syntax::kImplicit
         : uid == kBigUid    ? DicomElements::Syntax::kBig
                             : DicomElements::Syntax::kExplicit;
}

inline std::string data_set_of(const TestSlice& slice) {
  DicomElements e(syntax_of(slice.uid));
  const auto text = [&](std::uint32_t tag, const char* vr, const std::string& value) {
    if (!value.empty()) e.text(tag, vr, value);
  };
  text(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2");
  text(0x00080018, "UI", slice.sop);
  text(0x00080060, "CS", "CT");
  text(0x0008103E, "LO", "Abdomen");
  text(0x00091001, "LO", "a private element");
  text(0x00180050, "DS", slice.thickness);
  text(0x00180081, "DS", slice.echo_time);
  text(0x00181060, "DS", slice.trigger_time);
  text(0x0020000E, "UI", slice.series);
  text(0x00200011, "IS", slice.series_number);
  text(0x00200013, "IS", slice.instance);
  text(0x00200032, "DS", slice.position);
  text(0x00200037, "DS", slice.orientation);
  text(0x00200100, "IS", slice.temporal_position);
  e.us(0x00280002, slice.samples);
  text(0x00280004, "CS", slice.photometric);
  text(0x00280008, "IS", slice.num_frames);
  e.us(0x00280010, slice.rows).us(0x00280011, slice.columns);
  text(0x00280030, "DS", slice.spacing);
  e.us(0x00280100, slice.allocated).us(0x00280101, slice.stored).us(0x00280102, slice.high_bit);
  e.us(0x00280103, slice.is_signed);
  text(0x00281052, "DS", slice.intercept);
  text(0x00281053, "DS", slice.slope);
  e += slice.groups;
  std::string pixels = slice.pixels;
  if (pixels.empty()) {
    const int count = slice.rows * slice.columns;
    for (int i = 1; i <= count; ++i) {
      pixels += slice.allocated == 8 ? std::string(1, static_cast<char>(i))
                                     : e.word(static_cast<std::uint16_t>(i));
    }
  }
  if (slice.is_encapsulated) {
    e.undefined(0x7FE00010, "OB", pixels);
  } else {
    e.raw(0x7FE00010, "OW", pixels + std::string(pixels.size() % 2, '\0'));
  }
  return e.bytes();
}

inline std::string dicom_slice(const TestSlice& slice) {
  const std::string data_set = data_set_of(slice);
  return dicom_file(slice.uid, slice.uid == kDeflatedUid ? deflated(data_set, -15) : data_set);
}

// Items of encapsulated pixel data: a table of offsets, fragments, the delimiter.
inline std::string encapsulated(const std::vector<std::string>& fragments,
                                const std::string& table = {}) {
  const DicomElements e;
  const auto item = [&](std::uint16_t element, std::string value) {
    if (value.size() % 2 != 0) value += '\0';
    return e.word(0xFFFE) + e.word(element) +
           e.long_word(static_cast<std::uint32_t>(value.size())) + value;
  };
  std::string result = item(0xE000, table);
  for (const std::string& fragment : fragments) result += item(0xE000, fragment);
  return result + item(0xE0DD, "");
}

// An RLE frame of 16-bit little-endian samples: a segment of high bytes, one of low bytes, all as
// literals but for runs of three and more.
inline std::string rle_frame(const std::string& little_endian) {
  const auto packed = [](const std::string& plane) {
    std::string out;
    for (std::size_t i = 0; i < plane.size();) {
      std::size_t run = 1;
      while (i + run < plane.size() && run < 128 && plane[i + run] == plane[i]) ++run;
      if (run >= 3) {
        out += static_cast<char>(1 - static_cast<int>(run));
      } else {
        run = 1;
        out += '\0';
      }
      out += plane[i];
      i += run;
    }
    return out;
  };
  std::string low, high;
  for (std::size_t i = 0; i < little_endian.size(); i += 2) {
    low += little_endian[i];
    high += little_endian[i + 1];
  }
  const std::string first = packed(high), second = packed(low);
  const DicomElements e;
  std::string header =
      e.long_word(2) + e.long_word(64) + e.long_word(static_cast<std::uint32_t>(64 + first.size()));
  return header + std::string(64 - header.size(), '\0') + first + second;
}

// Three frames of an enhanced CT, 3 mm apart, the lowest in the middle of the file.
inline TestSlice enhanced_slices(bool is_defined = true, const std::string& uid = kExplicitUid) {
  const auto syntax = syntax_of(uid);
  const auto elements = [&] { return DicomElements(syntax); };
  DicomElements shared = elements();
  shared.sequence(0x00209116, {elements().text(0x00200037, "DS", "1\\0\\0\\0\\1\\0")}, is_defined);
  shared.sequence(0x00289110,
                  {elements().text(0x00180050, "DS", "3").text(0x00280030, "DS", "2\\0.5")},
                  is_defined);
  shared.sequence(0x00289145,
                  {elements()
                       .text(0x00281052, "DS", "-1000")
                       .text(0x00281053, "DS", "2")
                       .text(0x00281054, "LO", "HU")},
                  is_defined);
  std::vector<DicomElements> frames;
  for (const char* position : {"0\\0\\3", "0\\0\\0", "0\\0\\6"}) {
    DicomElements frame = elements();
    frame.sequence(0x00209113, {elements().text(0x00200032, "DS", position)}, is_defined);
    frames.push_back(frame);
  }
  TestSlice slice;
  slice.uid = uid;
  slice.num_frames = "3";
  slice.position = slice.orientation = slice.spacing = slice.thickness = "";
  slice.slope = slice.intercept = "";
  slice.groups = elements();
  slice.groups.sequence(0x52009229, {shared}, is_defined);
  slice.groups.sequence(0x52009230, frames, is_defined);
  for (std::uint16_t i = 1; i <= 18; ++i) slice.pixels += elements().word(i);
  return slice;
}

}  // namespace ovoid::io
