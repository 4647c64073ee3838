// SPDX-License-Identifier: Apache-2.0
// The data elements of a DICOM file: where they are, not what they mean. Values are left in the
// file; what a header says about lengths is checked before it is followed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"

namespace ovoid::io {

// Group in the upper 16 bits, element in the lower.
using DicomTag = std::uint32_t;

// How data elements are written. The deflated syntax is kExplicitLittle once it is inflated.
enum class DicomSyntax { kImplicitLittle, kExplicitLittle, kExplicitBig };

struct DicomElement {
  static constexpr std::int64_t kUndefined = -1;

  DicomTag tag = 0;
  std::array<char, 2> vr{};  // value representation; two zeros where the syntax writes none
  bool is_big_endian = false;
  std::int64_t offset = 0;  // of the value, from the start of the source
  std::int64_t length = 0;  // of the value in bytes; kUndefined: up to a delimiter

  bool has_vr(std::string_view name) const noexcept {
    return std::string_view(vr.data(), 2) == name;
  }
};

// One enclosing sequence of an element: which, and in which of its items, from 0.
struct DicomLevel {
  DicomTag sequence = 0;
  std::int64_t item = -1;
};

// One item of encapsulated pixel data.
struct DicomFragment {
  std::int64_t offset = 0;
  std::int64_t length = 0;
};

class DicomVisitor {
 public:
  virtual ~DicomVisitor() = default;
  // Whether the elements within a sequence are wanted. `path`: outermost first.
  virtual bool enter(DicomTag sequence, std::span<const DicomLevel> path) = 0;
  // An element that is no sequence.
  virtual void visit(const DicomElement& element, std::span<const DicomLevel> path) = 0;
};

// Levels of sequences and items within each other.
inline constexpr std::size_t kMaxDicomDepth = 32;
// Items of encapsulated pixel data in one file.
inline constexpr std::size_t kMaxDicomFragments = 1'000'000;

// Whether the first 512 bytes begin a DICOM file: with its preamble, or without but clearly.
bool looks_like_dicom(std::string_view start) noexcept;

// What (0002,xxxx) says.
struct DicomMeta {
  std::string transfer_syntax;  // empty: the file has no such element
  std::int64_t end = 0;         // where the data set begins
};

// Throws Error(kFileFormat).
DicomMeta read_dicom_meta(const ByteSource& source);

// The syntax that the data set's first element is written in, if it tells; else `claimed`. Some
// writers state another one than they use.
DicomSyntax dicom_syntax_at(const ByteSource& source, std::int64_t begin, DicomSyntax claimed);

// Visits the elements from `begin` to the pixel data of the outermost level, which are visited
// last, or to the end. Takes time in proportion to the number of elements, and no memory for them.
// Throws Error(kFileFormat) naming tag and place.
void walk_dicom(const ByteSource& source, std::int64_t begin, DicomSyntax syntax,
                DicomVisitor& visitor);

// The items of encapsulated pixel data, whose value begins at `offset`; the first is the table of
// offsets. Throws Error(kFileFormat).
std::vector<DicomFragment> read_dicom_fragments(const ByteSource& source, std::int64_t offset);

// "(0028,0010)"
std::string tag_text(DicomTag tag);

}  // namespace ovoid::io
