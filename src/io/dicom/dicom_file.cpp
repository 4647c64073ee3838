// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "io/dicom/dicom_codec.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr const char* kImplicitSyntax = "1.2.840.10008.1.2";
constexpr const char* kBigSyntax = "1.2.840.10008.1.2.2";

// Longer values of the elements that are read are not what they should be.
constexpr std::int64_t kMaxValue = 1024;
constexpr std::int64_t kMaxOffsetVector = std::int64_t{1} << 20;  // GridFrameOffsetVector

// Elements and sequences by their names in the standard's data dictionary.
enum : DicomTag {
  kSopInstanceUid = 0x00080018,
  kAcquisitionTime = 0x00080032,
  kModality = 0x00080060,
  kSeriesDescription = 0x0008103E,
  kSliceThickness = 0x00180050,
  kEchoTime = 0x00180081,
  kSpacingBetweenSlices = 0x00180088,
  kTriggerTime = 0x00181060,
  kImagerPixelSpacing = 0x00181164,
  kSeriesInstanceUid = 0x0020000E,
  kSeriesNumber = 0x00200011,
  kAcquisitionNumber = 0x00200012,
  kInstanceNumber = 0x00200013,
  kImagePosition = 0x00200032,
  kImageOrientation = 0x00200037,
  kTemporalPosition = 0x00200100,
  kTemporalPositionIndex = 0x00209128,
  kSamplesPerPixel = 0x00280002,
  kPhotometric = 0x00280004,
  kNumberOfFrames = 0x00280008,
  kFrameIncrementPointer = 0x00280009,
  kRows = 0x00280010,
  kColumns = 0x00280011,
  kPixelSpacing = 0x00280030,
  kBitsAllocated = 0x00280100,
  kBitsStored = 0x00280101,
  kHighBit = 0x00280102,
  kPixelRepresentation = 0x00280103,
  kRescaleIntercept = 0x00281052,
  kRescaleSlope = 0x00281053,
  kRescaleType = 0x00281054,
  kModalityLut = 0x00283000,
  kUnits = 0x00541001,
  kDoseUnits = 0x30040002,
  kGridFrameOffsets = 0x3004000C,
  kDoseGridScaling = 0x3004000E,
  kFloatPixelData = 0x7FE00008,
  kDoublePixelData = 0x7FE00009,
  kPixelData = 0x7FE00010,
  // Sequences
  kFrameContent = 0x00209111,
  kPlanePosition = 0x00209113,
  kPlaneOrientation = 0x00209116,
  kPixelMeasures = 0x00289110,
  kPixelValueTransformation = 0x00289145,
  kDetectorInformation = 0x00540022,
  kSharedGroups = 0x52009229,
  kPerFrameGroups = 0x52009230,
};

bool is_functional_group(DicomTag tag) noexcept {
  return tag == kFrameContent || tag == kPlanePosition || tag == kPlaneOrientation ||
         tag == kPixelMeasures || tag == kPixelValueTransformation;
}

std::string_view without_padding(std::string_view text) noexcept {
  constexpr std::string_view kPadding(" \0\t\r\n", 5);
  const auto first = text.find_first_not_of(kPadding);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kPadding) - first + 1);
}

// Gathers the wanted values while the elements are walked.
class Collector final : public DicomVisitor {
 public:
  Collector(const ByteSource& source, DicomFile& file) : source_(source), file_(file) {}

  DicomPlane general, shared;
  std::vector<DicomPlane> own;        // of the first frames; the rest have none
  std::vector<double> frame_offsets;  // GridFrameOffsetVector
  bool has_own_positions = false;

  bool enter(DicomTag sequence, std::span<const DicomLevel> path) override {
    if (sequence == kModalityLut && path.empty()) file_.has_modality_lut = true;
    if (path.empty()) {
      return sequence == kSharedGroups || sequence == kPerFrameGroups ||
             sequence == kDetectorInformation;
    }
    return path.size() == 1 && path[0].sequence != kDetectorInformation &&
           is_functional_group(sequence);
  }

  void visit(const DicomElement& element, std::span<const DicomLevel> path) override {
    if (element.length < 0 && !is_pixels(element.tag)) return;
    if (path.empty()) {
      visit_general(element);
      return visit_plane(element, general);
    }
    if (path.size() == 1 && path[0].sequence == kDetectorInformation && path[0].item == 0) {
      if (element.tag == kImagePosition || element.tag == kImageOrientation)
        visit_plane(element, general);
      return;
    }
    if (path.size() != 2 || path[1].item != 0) return;
    if (path[0].sequence == kSharedGroups) return visit_plane(element, shared);
    if (path[0].sequence != kPerFrameGroups || path[0].item >= kMaxDicomFrames) return;
    const auto frame = static_cast<std::size_t>(path[0].item);
    if (own.size() <= frame) own.resize(frame + 1);
    visit_plane(element, own[frame]);
    has_own_positions = has_own_positions || own[frame].position;
  }

 private:
  static bool is_pixels(DicomTag tag) {
    return tag == kPixelData || tag == kFloatPixelData || tag == kDoublePixelData;
  }

  [[noreturn]] void fail(const DicomElement& element, const std::string& what) const {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: {}: {}", source_.name(), tag_text(element.tag), what));
  }

  std::string text(const DicomElement& element, std::int64_t limit = kMaxValue) const {
    if (element.length > limit)
      fail(element, fmt::format("{} bytes: expected at most {}", element.length, limit));
    return std::string(without_padding(source_.text(element.offset, element.length)));
  }

  // An unsigned short, or whatever else of up to four bytes a writer took for it.
  std::int64_t integer(const DicomElement& element) const {
    const std::string bytes =
        source_.text(element.offset, std::min<std::int64_t>(element.length, 4));
    if (bytes.size() != 2 && bytes.size() != 4)
      fail(element, fmt::format("{} bytes: expected an integer of 2 or 4", element.length));
    return static_cast<std::int64_t>(unsigned_of(bytes, element.is_big_endian));
  }

  // Numbers between backslashes. Empty if the value is.
  std::vector<double> numbers(const DicomElement& element, std::int64_t limit = kMaxValue) const {
    const std::string all = text(element, limit);
    std::vector<double> result;
    if (all.empty()) return result;
    for (std::size_t begin = 0; begin <= all.size();) {
      const std::size_t end = std::min(all.find('\\', begin), all.size());
      const std::string_view one =
          without_padding(std::string_view(all).substr(begin, end - begin));
      const auto value = parse_number<double>(one);
      if (!value) fail(element, fmt::format("'{}' is not a number", one.substr(0, 40)));
      // Products of a few stay finite.
      if (!(std::abs(*value) <= 1e30))
        fail(element, fmt::format("{} is beyond 1e30", one.substr(0, 40)));
      result.push_back(*value);
      begin = end + 1;
    }
    return result;
  }

  template <std::size_t count>
  std::optional<std::array<double, count>> exactly(const DicomElement& element) const {
    const std::vector<double> values = numbers(element);
    if (values.empty()) return std::nullopt;
    if (values.size() != count)
      fail(element, fmt::format("{} numbers: expected {}", values.size(), count));
    std::array<double, count> result;
    std::copy(values.begin(), values.end(), result.begin());
    return result;
  }

  std::optional<double> number(const DicomElement& element) const {
    const auto value = exactly<1>(element);
    return value ? std::optional((*value)[0]) : std::nullopt;
  }

  // Numbers that only sort or describe: odd ones are passed over.
  std::optional<double> number_if_any(const DicomElement& element) const {
    try {
      return number(element);
    } catch (const Error&) {
      return std::nullopt;
    }
  }

  // HHMMSS.FFFFFF
  std::optional<double> time_of_day(const DicomElement& element) const {
    const auto value = number_if_any(element);
    if (!value) return value;
    const double hours = std::floor(*value / 10000);
    const double minutes = std::floor((*value - hours * 10000) / 100);
    return hours * 3600 + minutes * 60 + (*value - hours * 10000 - minutes * 100);
  }

  void visit_plane(const DicomElement& element, DicomPlane& plane) {
    switch (element.tag) {
      case kImagePosition:
        if (const auto p = exactly<3>(element)) plane.position = Vec3((*p)[0], (*p)[1], (*p)[2]);
        break;
      case kImageOrientation:
        if (const auto o = exactly<6>(element)) {
          plane.orientation = {Vec3((*o)[0], (*o)[1], (*o)[2]), Vec3((*o)[3], (*o)[4], (*o)[5])};
        }
        break;
      case kPixelSpacing:
        if (const auto spacing = exactly<2>(element)) plane.spacing = spacing;
        break;
      case kSliceThickness:
        plane.slice_thickness = number_if_any(element);
        break;
      case kSpacingBetweenSlices:
        plane.slice_spacing = number_if_any(element);
        break;
      case kRescaleSlope:
      case kDoseGridScaling:
        plane.slope = number(element);
        break;
      case kRescaleIntercept:
        plane.intercept = number(element);
        break;
      case kRescaleType:
        plane.rescale_type = text(element);
        break;
      case kTemporalPosition:
        plane.temporal_position = number_if_any(element);
        break;
      case kTemporalPositionIndex:
        plane.temporal_position = static_cast<double>(integer(element));
        break;
      default:
        break;
    }
  }

  void visit_general(const DicomElement& element) {
    if (is_pixels(element.tag)) return visit_pixels(element);
    if (element.tag >> 16U == 0x0028U) return visit_image(element);
    switch (element.tag) {
      case kSopInstanceUid:
        file_.sop_uid = text(element);
        break;
      case kSeriesInstanceUid:
        file_.series_uid = text(element);
        break;
      case kModality:
        file_.modality = text(element);
        break;
      case kSeriesDescription:
        file_.series_description = text(element);
        break;
      case kUnits:
      case kDoseUnits:
        file_.units = text(element);
        break;
      case kSeriesNumber:
        file_.series_number = number_if_any(element);
        break;
      case kInstanceNumber:
        file_.instance_number = number_if_any(element);
        break;
      case kAcquisitionNumber:
        file_.acquisition_number = number_if_any(element);
        break;
      case kEchoTime:
        file_.echo_time = number_if_any(element);
        break;
      case kTriggerTime:
        file_.trigger_time = number_if_any(element);
        break;
      case kAcquisitionTime:
        file_.acquisition_time = time_of_day(element);
        break;
      case kGridFrameOffsets:
        frame_offsets = numbers(element, kMaxOffsetVector);
        break;
      case kImagerPixelSpacing:
        imager_spacing_ = exactly<2>(element);
        break;
      default:
        break;
    }
  }

  void visit_image(const DicomElement& element) {
    switch (element.tag) {
      case kPhotometric:
        file_.photometric = text(element);
        break;
      case kNumberOfFrames:
        if (const auto count = number(element)) {
          if (!(*count >= 1 && *count <= static_cast<double>(kMaxDicomFrames)))
            fail(element, fmt::format("{} frames: expected 1 to {}", *count, kMaxDicomFrames));
          file_.num_frames = static_cast<std::int64_t>(*count);
        }
        break;
      case kFrameIncrementPointer:
        // FrameTime or FrameTimeVector: two words, the group first.
        if (element.length == 4) {
          const std::int64_t word = integer(element);
          const std::int64_t low = word & 0xFFFF, high = word >> 16;
          const std::int64_t number = element.is_big_endian ? low : high;
          const std::int64_t group = element.is_big_endian ? high : low;
          file_.frames_are_times = group == 0x0018 && (number == 0x1063 || number == 0x1065);
        }
        break;
      case kSamplesPerPixel:
        file_.samples_per_pixel = static_cast<int>(std::min<std::int64_t>(integer(element), 65535));
        break;
      case kRows:
        file_.rows = integer(element);
        break;
      case kColumns:
        file_.columns = integer(element);
        break;
      case kBitsAllocated:
        file_.bits_allocated = static_cast<int>(std::min<std::int64_t>(integer(element), 65535));
        break;
      case kBitsStored:
        file_.bits_stored = static_cast<int>(std::min<std::int64_t>(integer(element), 65535));
        break;
      case kHighBit:
        file_.high_bit = static_cast<int>(std::min<std::int64_t>(integer(element), 65535));
        has_high_bit_ = true;
        break;
      case kPixelRepresentation:
        file_.is_signed = integer(element) == 1;
        break;
      case kModalityLut:
        file_.has_modality_lut = true;
        break;
      default:
        break;
    }
  }

  void visit_pixels(const DicomElement& element) {
    file_.pixels = element.tag == kPixelData        ? DicomPixels::kInteger
                   : element.tag == kFloatPixelData ? DicomPixels::kFloat32
                                                    : DicomPixels::kFloat64;
    file_.pixel_data = element;
    if (element.length < 0) {
      file_.is_encapsulated = true;
      file_.fragments = read_dicom_fragments(source_, element.offset);
    }
    if (file_.pixels != DicomPixels::kInteger) {
      file_.bits_allocated = file_.pixels == DicomPixels::kFloat32 ? 32 : 64;
      file_.bits_stored = file_.bits_allocated;
      has_high_bit_ = false;
    }
    if (!has_high_bit_) file_.high_bit = file_.bits_stored - 1;
    if (!general.spacing && imager_spacing_) {
      general.spacing = imager_spacing_;
      file_.spacing_is_imager = true;
    }
  }

  const ByteSource& source_;
  DicomFile& file_;
  std::optional<std::array<double, 2>> imager_spacing_;
  bool has_high_bit_ = false;
};

[[noreturn]] void fail(const DicomFile& file, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", file.name, what));
}

void check_image(const DicomFile& file) {
  if (file.rows < 1 || file.rows > 65535 || file.columns < 1 || file.columns > 65535) {
    fail(file, fmt::format("Rows {}, Columns {}: expected 1 to 65535", file.rows, file.columns));
  }
  if (file.bits_stored < 1 || file.bits_stored > file.bits_allocated ||
      file.high_bit < file.bits_stored - 1 || file.high_bit >= file.bits_allocated) {
    fail(file, fmt::format("BitsAllocated {}, BitsStored {}, HighBit {} contradict each other",
                           file.bits_allocated, file.bits_stored, file.high_bit));
  }
}

// Native pixel data must hold all frames; a byte of padding is usual, more is some writers' habit.
void check_native_length(const DicomFile& file) {
  const std::int64_t wanted = file.frame_bytes() * file.num_frames;
  if (file.pixel_data.length < wanted) {
    fail(file, fmt::format("pixel data have {} bytes: expected {} for {}x{}, {} frames of {} bits",
                           file.pixel_data.length, wanted, file.columns, file.rows, file.num_frames,
                           file.bits_allocated));
  }
}

std::uint32_t little_word(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;) word = word << 8U | static_cast<unsigned char>(bytes[at + i]);
  return word;
}

// Which fragments are which frame's. One each is the rule; else the table of offsets says it.
void assign_fragments(const ByteSource& source, DicomFile& file) {
  if (file.fragments.empty()) fail(file, "compressed pixel data have no table of offsets");
  const DicomFragment table = file.fragments.front();
  file.fragments.erase(file.fragments.begin());
  const auto num_fragments = static_cast<std::int64_t>(file.fragments.size());
  if (num_fragments < file.num_frames) {
    fail(file, fmt::format("compressed pixel data have {} fragments: expected at least one for "
                           "each of {} frames",
                           num_fragments, file.num_frames));
  }
  std::vector<std::int64_t>& starts = file.fragment_starts;
  if (file.num_frames == 1 || num_fragments == file.num_frames) {
    for (std::int64_t i = 0; i < file.num_frames; ++i) starts.push_back(i);
    starts.push_back(num_fragments);
    return;
  }
  if (table.length != 4 * file.num_frames) {
    fail(file, fmt::format("{} fragments for {} frames, and the table of offsets has {} entries: "
                           "cannot tell which belong together",
                           num_fragments, file.num_frames, table.length / 4));
  }
  const std::string offsets = source.text(table.offset, table.length);
  const std::int64_t first = file.fragments.front().offset - 8;
  std::size_t fragment = 0;
  for (std::int64_t i = 0; i < file.num_frames; ++i) {
    const std::int64_t wanted = first + little_word(offsets, static_cast<std::size_t>(4 * i));
    while (fragment < file.fragments.size() && file.fragments[fragment].offset - 8 < wanted)
      ++fragment;
    const bool is_there =
        fragment < file.fragments.size() && file.fragments[fragment].offset - 8 == wanted;
    if (!is_there || (!starts.empty() && starts.back() == static_cast<std::int64_t>(fragment)))
      fail(file, fmt::format("the table of offsets misses the fragment of frame {}", i));
    starts.push_back(static_cast<std::int64_t>(fragment));
  }
  starts.push_back(num_fragments);
}

// Only the file says where the frames are: as a stack upon the first one.
void stack_frames(const std::vector<double>& offsets, DicomFile& file) {
  const DicomPlane& first = file.planes.front();
  if (!first.position || !first.orientation) return;
  const Vec3 normal = (*first.orientation)[0].cross((*first.orientation)[1]);
  const Vec3 start = *first.position;
  const bool has_offsets = offsets.size() == file.planes.size();
  const auto step = first.slice_spacing ? first.slice_spacing : first.slice_thickness;
  if (!has_offsets && (!step || *step == 0)) {
    for (DicomPlane& plane : file.planes) plane.position.reset();
    return;
  }
  file.guesses_frame_positions = !has_offsets;
  for (std::size_t i = 0; i < file.planes.size(); ++i) {
    // Offsets are from the first frame, or, where the first is not 0, along the axis itself.
    const double offset = has_offsets ? offsets[i] - offsets[0] : *step * static_cast<double>(i);
    file.planes[i].position = start + normal * offset;
  }
}

void complete_planes(Collector& found, DicomFile& file) {
  const auto num_frames = static_cast<std::size_t>(file.num_frames);
  found.shared.complete_from(found.general);
  file.planes = std::move(found.own);
  file.planes.resize(num_frames);
  for (DicomPlane& plane : file.planes) plane.complete_from(found.shared);
  if (num_frames == 1 || found.has_own_positions) return;
  if (file.frames_are_times) {
    for (std::size_t i = 0; i < num_frames; ++i)
      file.planes[i].temporal_position = static_cast<double>(i);
  } else {
    stack_frames(found.frame_offsets, file);
  }
}

}  // namespace

void DicomPlane::complete_from(const DicomPlane& general) {
  const auto fill = [](auto& own, const auto& other) {
    if (!own) own = other;
  };
  fill(position, general.position);
  fill(orientation, general.orientation);
  fill(spacing, general.spacing);
  fill(slice_spacing, general.slice_spacing);
  fill(slice_thickness, general.slice_thickness);
  fill(slope, general.slope);
  fill(intercept, general.intercept);
  fill(temporal_position, general.temporal_position);
  if (rescale_type.empty()) rescale_type = general.rescale_type;
}

ScalarType DicomFile::scalar_type() const noexcept {
  if (pixels == DicomPixels::kFloat32) return ScalarType::kFloat32;
  if (pixels == DicomPixels::kFloat64) return ScalarType::kFloat64;
  if (bits_allocated == 8) return is_signed ? ScalarType::kInt8 : ScalarType::kUInt8;
  if (bits_allocated == 16) return is_signed ? ScalarType::kInt16 : ScalarType::kUInt16;
  return is_signed ? ScalarType::kInt32 : ScalarType::kUInt32;
}

DicomFile read_dicom_file(const ByteSource& data) {
  const DicomMeta meta = read_dicom_meta(data);
  DicomFile file;
  file.name = data.name();
  file.transfer_syntax = meta.transfer_syntax.empty() ? kImplicitSyntax : meta.transfer_syntax;
  const DicomSyntax claimed = file.transfer_syntax == kImplicitSyntax ? DicomSyntax::kImplicitLittle
                              : file.transfer_syntax == kBigSyntax    ? DicomSyntax::kExplicitBig
                                                                   : DicomSyntax::kExplicitLittle;
  Collector found(data, file);
  walk_dicom(data, meta.end, dicom_syntax_at(data, meta.end, claimed), found);
  if (file.pixels == DicomPixels::kNone || !unreadable_reason(file).empty()) return file;
  check_image(file);
  if (file.is_encapsulated) {
    assign_fragments(data, file);
  } else {
    check_native_length(file);
  }
  complete_planes(found, file);
  return file;
}

std::string unreadable_reason(const DicomFile& file) {
  if (file.samples_per_pixel != 1) {
    return fmt::format("colour picture ({}, {} samples per pixel)", file.photometric,
                       file.samples_per_pixel);
  }
  if (file.photometric.starts_with("PALETTE")) return "colour picture (PALETTE COLOR)";
  const int bits = file.bits_allocated;
  if (file.pixels == DicomPixels::kInteger && bits != 8 && bits != 16 && bits != 32) {
    return fmt::format("BitsAllocated {}, which is not read (8, 16 and 32 are)", bits);
  }
  const bool is_native_syntax = !is_compressed_syntax(file.transfer_syntax);
  if (is_native_syntax == file.is_encapsulated) {
    return file.is_encapsulated
               ? fmt::format("compressed pixel data, but transfer syntax {}", file.transfer_syntax)
               : fmt::format("plain pixel data, but transfer syntax {}", file.transfer_syntax);
  }
  return file.is_encapsulated ? unreadable_syntax_reason(file.transfer_syntax) : std::string();
}

}  // namespace ovoid::io
