// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_elements.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/core/numbers.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr DicomTag kItem = 0xFFFEE000, kItemEnd = 0xFFFEE00D, kSequenceEnd = 0xFFFEE0DD;
constexpr DicomTag kTransferSyntax = 0x00020010;
constexpr std::uint32_t kUndefined32 = 0xFFFFFFFF;
constexpr std::int64_t kPreamble = 132;

// The value representations whose length has 16 bits. Later ones have 32, as all to come will.
constexpr std::string_view kShortNames =
    "AE AS AT CS DA DS DT FD FL IS LO LT PN SH SL SS ST TM UI UL US";
constexpr std::string_view kLongNames = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";

bool is_in(std::string_view list, std::string_view vr) noexcept {
  for (std::size_t i = 0; i + 2 <= list.size(); i += 3)
    if (list.substr(i, 2) == vr) return true;
  return false;
}

bool is_pixel_data(DicomTag tag) noexcept {
  return tag == 0x7FE00010 || tag == 0x7FE00009 || tag == 0x7FE00008;
}

[[noreturn]] void fail(const ByteSource& source, std::int64_t offset, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: byte {}: {}", source.name(), offset, what));
}

// Headers of elements are a few bytes each: they are read from a window that moves forwards.
class Window {
 public:
  explicit Window(const ByteSource& source) : source_(source) {}

  // `count` bytes, which the caller knows to be there.
  const char* at(std::int64_t offset, std::int64_t count) {
    if (offset < begin_ || offset + count > begin_ + static_cast<std::int64_t>(text_.size())) {
      begin_ = offset;
      text_ = source_.text(offset, kSize);
    }
    return text_.data() + (offset - begin_);
  }

 private:
  static constexpr std::int64_t kSize = 16384;  // most slices' headers fit

  const ByteSource& source_;
  std::int64_t begin_ = 0;
  std::string text_;
};

DicomTag tag_at(const char* bytes, bool is_big_endian) noexcept {
  return static_cast<DicomTag>(number_at<std::uint16_t>(bytes, is_big_endian)) << 16U |
         number_at<std::uint16_t>(bytes + 2, is_big_endian);
}

// The header of the element at `at`; all of it lies before `limit`, and so does its value.
DicomElement element_at(const ByteSource& source, Window& window, std::int64_t at,
                        std::int64_t limit, DicomSyntax syntax) {
  if (limit - at < 8) {
    fail(source, at,
         fmt::format("{} bytes are left where a data element should begin", limit - at));
  }
  const char* bytes = window.at(at, 8);
  DicomElement element;
  element.is_big_endian = syntax == DicomSyntax::kExplicitBig;
  element.tag = tag_at(bytes, element.is_big_endian);
  std::int64_t header = 8;
  std::uint32_t length = 0;
  if (syntax == DicomSyntax::kImplicitLittle || element.tag >> 16U == 0xFFFEU) {
    length = number_at<std::uint32_t>(bytes + 4, element.is_big_endian);
  } else {
    std::copy_n(bytes + 4, 2, element.vr.begin());
    const auto is_letter = [](char c) { return c >= 'A' && c <= 'Z'; };
    if (!is_letter(element.vr[0]) || !is_letter(element.vr[1])) {
      fail(source, at,
           fmt::format("{}: value representation {:02x} {:02x}: expected two letters",
                       tag_text(element.tag), static_cast<unsigned char>(element.vr[0]),
                       static_cast<unsigned char>(element.vr[1])));
    }
    if (is_in(kShortNames, {element.vr.data(), 2})) {
      length = number_at<std::uint16_t>(bytes + 6, element.is_big_endian);
    } else {
      header = 12;
      if (limit - at < header)
        fail(source, at, fmt::format("{}: the file ends in its length", tag_text(element.tag)));
      length = number_at<std::uint32_t>(window.at(at, header) + 8, element.is_big_endian);
    }
  }
  element.offset = at + header;
  element.length = length == kUndefined32 ? DicomElement::kUndefined : length;
  if (element.length > limit - element.offset) {
    fail(source, at,
         fmt::format("{}: states {} bytes, {} are left: the file is cut short or damaged",
                     tag_text(element.tag), element.length, limit - element.offset));
  }
  return element;
}

// Walks without recursion, so that a file cannot choose how deep the stack grows.
class Walker {
 public:
  Walker(const ByteSource& source, DicomVisitor& visitor)
      : source_(source), visitor_(visitor), window_(source) {}

  void run(std::int64_t begin, DicomSyntax syntax) {
    at_ = begin;
    scopes_.push_back({Kind::kContent, source_.size(), source_.size(), syntax, false});
    for (;;) {
      const Scope& scope = scopes_.back();
      if (scope.end >= 0 && at_ >= scope.end) {
        if (scopes_.size() == 1) return;
        close();
        continue;
      }
      const DicomElement element = element_at(source_, window_, at_, scope.limit, scope.syntax);
      if (scope.kind == Kind::kContent ? !in_item(element) : !in_sequence(element)) return;
    }
  }

 private:
  enum class Kind { kContent, kSequence, kFragments };
  struct Scope {
    Kind kind = Kind::kContent;
    std::int64_t end = 0;    // -1: at a delimiter
    std::int64_t limit = 0;  // the nearest end that is known
    DicomSyntax syntax = DicomSyntax::kImplicitLittle;
    bool is_silent = false;  // nobody wants what is in here
  };

  void open(Kind kind, const DicomElement& element, DicomSyntax syntax, bool is_silent) {
    if (scopes_.size() >= kMaxDicomDepth) {
      fail(source_, at_,
           fmt::format("{}: sequences lie more than {} deep in each other",
                       tag_text(path_.back().sequence), kMaxDicomDepth / 2));
    }
    const std::int64_t end = element.length < 0 ? -1 : element.offset + element.length;
    scopes_.push_back({kind, end, end < 0 ? scopes_.back().limit : end, syntax, is_silent});
    at_ = element.offset;
  }

  void close() {
    if (scopes_.back().kind != Kind::kContent) path_.pop_back();
    scopes_.pop_back();
  }

  // Both return false when the walk is over.
  bool in_item(const DicomElement& element) {
    const Scope scope = scopes_.back();
    if (element.tag == kItemEnd && scope.end < 0) {
      at_ = element.offset;
      close();
      return true;
    }
    if (element.tag >> 16U == 0xFFFEU)
      fail(source_, at_, fmt::format("{}: stands outside a sequence", tag_text(element.tag)));
    const bool is_outermost = scopes_.size() == 1;
    if (is_outermost && is_pixel_data(element.tag)) {
      visitor_.visit(element, path_);
      return false;
    }
    const bool is_undefined = element.length < 0;
    if (is_pixel_data(element.tag) && is_undefined) {  // an icon's, in a sequence
      path_.push_back({element.tag, -1});
      open(Kind::kFragments, element, scope.syntax, true);
      return true;
    }
    // Without a representation a sequence of known length cannot be told from bytes: the visitor
    // knows the tags that it is after.
    const bool is_sequence = element.has_vr("SQ") || is_undefined || element.vr[0] == '\0';
    const bool is_wanted = is_sequence && !scope.is_silent && visitor_.enter(element.tag, path_);
    if (is_wanted || is_undefined) {
      // What nobody knew the representation of is written without any, in little endian.
      const bool is_unknown = element.has_vr("UN") && is_undefined;
      path_.push_back({element.tag, -1});
      open(Kind::kSequence, element, is_unknown ? DicomSyntax::kImplicitLittle : scope.syntax,
           !is_wanted);
      return true;
    }
    if (!scope.is_silent && !element.has_vr("SQ")) visitor_.visit(element, path_);
    at_ = element.offset + element.length;
    return true;
  }

  bool in_sequence(const DicomElement& element) {
    const Scope scope = scopes_.back();
    if (element.tag == kSequenceEnd && scope.end < 0) {
      at_ = element.offset;
      close();
      return true;
    }
    if (element.tag != kItem) {
      fail(source_, at_,
           fmt::format("{}: expected an item of the sequence {}", tag_text(element.tag),
                       tag_text(path_.back().sequence)));
    }
    ++path_.back().item;
    if (scope.kind == Kind::kSequence) {
      open(Kind::kContent, element, scope.syntax, scope.is_silent);
    } else if (element.length >= 0) {
      at_ = element.offset + element.length;
    } else {
      fail(source_, at_, "a fragment of pixel data has no length");
    }
    return true;
  }

  const ByteSource& source_;
  DicomVisitor& visitor_;
  Window window_;
  std::int64_t at_ = 0;
  std::vector<Scope> scopes_;
  std::vector<DicomLevel> path_;
};

// The first elements that data sets begin with: SpecificCharacterSet, ImageType, SOPClassUID and
// others of group 8. Too little to go by alone, so that the header must be one of theirs, too.
bool begins_like_data_set(std::string_view start) noexcept {
  if (start.size() < 16) return false;
  const DicomTag tag = tag_at(start.data(), false);
  if (tag != 0x00080000 && tag != 0x00080001 && tag != 0x00080005 && tag != 0x00080008 &&
      tag != 0x00080012 && tag != 0x00080016) {
    return false;
  }
  const std::string_view vr = start.substr(4, 2);
  if (vr == "CS" || vr == "UI" || vr == "UL" || vr == "DA") return true;
  const auto length = number_at<std::uint32_t>(start.data() + 4, false);
  return length % 2 == 0 && length >= 2 && length <= 128;
}

}  // namespace

std::string tag_text(DicomTag tag) {
  return fmt::format("({:04x},{:04x})", tag >> 16U, tag & 0xFFFFU);
}

bool looks_like_dicom(std::string_view start) noexcept {
  if (start.size() >= static_cast<std::size_t>(kPreamble) && start.substr(128, 4) == "DICM")
    return true;
  using namespace std::string_view_literals;
  return start.starts_with("\x02\0\0\0UL\x04\0"sv) || begins_like_data_set(start);
}

DicomMeta read_dicom_meta(const ByteSource& source) {
  DicomMeta meta;
  if (source.text(128, 4) == "DICM") meta.end = kPreamble;
  Window window(source);
  while (source.size() - meta.end >= 8 && tag_at(window.at(meta.end, 8), false) >> 16U == 2U) {
    const DicomElement element =
        element_at(source, window, meta.end, source.size(), DicomSyntax::kExplicitLittle);
    if (element.length < 0)
      fail(source, meta.end, fmt::format("{}: has no length", tag_text(element.tag)));
    if (element.tag == kTransferSyntax) {
      meta.transfer_syntax =
          source.text(element.offset, std::min<std::int64_t>(element.length, 64));
      const auto last = meta.transfer_syntax.find_last_not_of(std::string_view("\0 ", 2));
      meta.transfer_syntax.resize(last == std::string::npos ? 0 : last + 1);
    }
    meta.end = element.offset + element.length;
  }
  return meta;
}

DicomSyntax dicom_syntax_at(const ByteSource& source, std::int64_t begin, DicomSyntax claimed) {
  const std::string start = source.text(begin, 8);
  if (start.size() < 8 || claimed == DicomSyntax::kExplicitBig) return claimed;
  const std::string_view vr = std::string_view(start).substr(4, 2);
  return is_in(kShortNames, vr) || is_in(kLongNames, vr) ? DicomSyntax::kExplicitLittle
                                                         : DicomSyntax::kImplicitLittle;
}

void walk_dicom(const ByteSource& source, std::int64_t begin, DicomSyntax syntax,
                DicomVisitor& visitor) {
  Walker(source, visitor).run(begin, syntax);
}

std::vector<DicomFragment> read_dicom_fragments(const ByteSource& source, std::int64_t offset) {
  std::vector<DicomFragment> fragments;
  Window window(source);
  for (;;) {
    // Encapsulated pixel data are always in little endian; items have no representation.
    const DicomElement item =
        element_at(source, window, offset, source.size(), DicomSyntax::kImplicitLittle);
    if (item.tag == kSequenceEnd) return fragments;
    if (item.tag != kItem || item.length < 0) {
      fail(source, offset,
           fmt::format("{}: expected a fragment of pixel data", tag_text(item.tag)));
    }
    if (fragments.size() >= kMaxDicomFragments) {
      fail(source, offset,
           fmt::format("pixel data have more than {} fragments", kMaxDicomFragments));
    }
    fragments.push_back({item.offset, item.length});
    offset = item.offset + item.length;
  }
}

}  // namespace ovoid::io
