// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_collector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMaxOffsetVector = std::int64_t{1} << 20;  // GridFrameOffsetVector
constexpr std::int64_t kMaxCsaHeader = std::int64_t{1} << 20;
constexpr std::size_t kMaxGridSlices = 65535;
constexpr std::size_t kMaxPrivateOwners = 256;

// Elements and sequences by their names in the standard's data dictionary.
enum : DicomTag {
  kImageType = 0x00080008,
  kSopInstanceUid = 0x00080018,
  kAcquisitionDate = 0x00080022,
  kContentDate = 0x00080023,
  kAcquisitionDateTime = 0x0008002A,
  kAcquisitionTime = 0x00080032,
  kContentTime = 0x00080033,
  kModality = 0x00080060,
  kSeriesDescription = 0x0008103E,
  kFrameType = 0x00089007,
  kComplexImageComponent = 0x00089208,
  kMrAcquisitionType = 0x00180023,
  kSliceThickness = 0x00180050,
  kRepetitionTime = 0x00180080,
  kEchoTime = 0x00180081,
  kEchoNumbers = 0x00180086,
  kSpacingBetweenSlices = 0x00180088,
  kTriggerTime = 0x00181060,
  kFrameTime = 0x00181063,
  kImagerPixelSpacing = 0x00181164,
  kFrameAcquisitionDateTime = 0x00189074,
  kEffectiveEchoTime = 0x00189082,
  kDiffusionBValue = 0x00189087,
  kFrameReferenceDateTime = 0x00189151,
  kSeriesInstanceUid = 0x0020000E,
  kSeriesNumber = 0x00200011,
  kAcquisitionNumber = 0x00200012,
  kInstanceNumber = 0x00200013,
  kImagePosition = 0x00200032,
  kImageOrientation = 0x00200037,
  kTemporalPosition = 0x00200100,
  kTemporalResolution = 0x00200110,
  kSliceLocation = 0x00201041,
  kStackId = 0x00209056,
  kInStackPosition = 0x00209057,
  kTemporalPositionIndex = 0x00209128,
  kNominalTriggerDelay = 0x00209153,
  kDimensionIndexValues = 0x00209157,
  kDimensionIndexPointer = 0x00209165,
  kTemporalPositionOffset = 0x0020930D,
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
  kMrTiming = 0x00189112,
  kMrEcho = 0x00189114,
  kMrDiffusion = 0x00189117,
  kCardiacSynchronization = 0x00189118,
  kMrFrameType = 0x00189226,
  kCtFrameType = 0x00189329,
  kPetFrameType = 0x00189751,
  kFrameContent = 0x00209111,
  kPlanePosition = 0x00209113,
  kPlaneOrientation = 0x00209116,
  kDimensionIndex = 0x00209222,
  kTemporalPositions = 0x00209310,
  kPixelMeasures = 0x00289110,
  kPixelValueTransformation = 0x00289145,
  kDetectorInformation = 0x00540022,
  kSharedGroups = 0x52009229,
  kPerFrameGroups = 0x52009230,
};

bool is_functional_group(DicomTag tag) noexcept {
  constexpr DicomTag kGroups[] = {kMrTiming,
                                  kMrEcho,
                                  kMrDiffusion,
                                  kCardiacSynchronization,
                                  kMrFrameType,
                                  kCtFrameType,
                                  kPetFrameType,
                                  kFrameContent,
                                  kPlanePosition,
                                  kPlaneOrientation,
                                  kTemporalPositions,
                                  kPixelMeasures,
                                  kPixelValueTransformation};
  return std::find(std::begin(kGroups), std::end(kGroups), tag) != std::end(kGroups);
}

// Dimensions along which frames lie at several places.
bool is_place(DicomTag pointer) noexcept {
  return pointer == kImagePosition || pointer == kImageOrientation || pointer == kSliceLocation ||
         pointer == kStackId || pointer == kInStackPosition || pointer == kPlanePosition ||
         pointer == kPlaneOrientation;
}

bool is_pixels(DicomTag tag) noexcept {
  return tag == kPixelData || tag == kFloatPixelData || tag == kDoublePixelData;
}

// United Imaging's sequence with an item for each slice of a grid, in any block of its group.
bool is_grid_slices(DicomTag tag) noexcept {
  return tag >> 16U == 0x0065U && (tag & 0xFFU) == 0x51U && (tag & 0xFFFFU) >= 0x1000U;
}

}  // namespace

bool DicomCollector::enter_outermost(DicomTag sequence) {
  if (sequence == kModalityLut) file_.has_modality_lut = true;
  if (sequence >> 16U == 0x0004U) file_.is_directory = true;
  return sequence == kSharedGroups || sequence == kPerFrameGroups ||
         sequence == kDetectorInformation || sequence == kDimensionIndex ||
         (tiles.is_grid && is_grid_slices(sequence));
}

bool DicomCollector::enter(DicomTag sequence, std::span<const DicomLevel> path) {
  if (path.empty()) return enter_outermost(sequence);
  return path.size() == 1 &&
         (path[0].sequence == kSharedGroups || path[0].sequence == kPerFrameGroups) &&
         is_functional_group(sequence);
}

void DicomCollector::visit(const DicomElement& element, std::span<const DicomLevel> path) {
  if (element.length < 0 && !is_pixels(element.tag)) return;
  if (path.empty()) {
    visit_general(element);
    return visit_plane(element, general);
  }
  const DicomLevel& outer = path[0];
  if (path.size() == 1) {
    const bool is_detector = outer.sequence == kDetectorInformation && outer.item == 0;
    if (is_detector && (element.tag == kImagePosition || element.tag == kImageOrientation))
      visit_plane(element, general);
    if (outer.sequence == kDimensionIndex && element.tag == kDimensionIndexPointer) {
      is_place_.resize(static_cast<std::size_t>(std::min<std::int64_t>(outer.item, 255)));
      is_place_.push_back(is_place(tag_value(element)));
    }
    if (is_grid_slices(outer.sequence)) visit_grid_slice(element, outer.item);
    return;
  }
  if (path.size() != 2 || path[1].item != 0) return;
  if (outer.sequence == kSharedGroups) return visit_plane(element, shared);
  if (outer.sequence != kPerFrameGroups || outer.item >= kMaxDicomFrames) return;
  const auto frame = static_cast<std::size_t>(outer.item);
  if (own.size() <= frame) own.resize(frame + 1);
  visit_plane(element, own[frame]);
  has_own_positions = has_own_positions || own[frame].position;
}

void DicomCollector::visit_grid_slice(const DicomElement& element, std::int64_t item) {
  if (element.tag != kImagePosition || item < 0 ||
      item >= static_cast<std::int64_t>(kMaxGridSlices))
    return;
  const auto slice = static_cast<std::size_t>(item);
  if (tiles.positions.size() <= slice) tiles.positions.resize(slice + 1);
  if (const auto p = values_.exactly<3>(element))
    tiles.positions[slice] = Vec3((*p)[0], (*p)[1], (*p)[2]);
}

// Two words, the group first.
DicomTag DicomCollector::tag_value(const DicomElement& element) const {
  const auto words = values_.words_if_any(element);
  if (words.size() != 1) return 0;
  return element.is_big_endian ? words[0] : words[0] << 16U | words[0] >> 16U;
}

void DicomCollector::visit_plane(const DicomElement& element, DicomPlane& plane) {
  switch (element.tag) {
    case kImagePosition:
      if (const auto p = values_.exactly<3>(element))
        plane.position = Vec3((*p)[0], (*p)[1], (*p)[2]);
      break;
    case kImageOrientation:
      if (const auto o = values_.exactly<6>(element)) {
        plane.orientation = {Vec3((*o)[0], (*o)[1], (*o)[2]), Vec3((*o)[3], (*o)[4], (*o)[5])};
      }
      break;
    case kPixelSpacing:
      if (const auto spacing = values_.exactly<2>(element)) plane.spacing = spacing;
      break;
    case kSliceThickness:
      plane.slice_thickness = values_.number_if_any(element);
      break;
    case kSpacingBetweenSlices:
      plane.slice_spacing = values_.number_if_any(element);
      break;
    case kRescaleSlope:
    case kDoseGridScaling:
      plane.slope = values_.number(element);
      break;
    case kRescaleIntercept:
      plane.intercept = values_.number(element);
      break;
    case kRescaleType:
      plane.rescale_type = values_.text(element);
      break;
    default:
      visit_moment(element, plane);
      break;
  }
}

// What tells frames at one place apart.
void DicomCollector::visit_moment(const DicomElement& element, DicomPlane& plane) {
  switch (element.tag) {
    case kTemporalPosition:
      plane.temporal_position = values_.number_if_any(element);
      break;
    case kTemporalPositionIndex:
      plane.temporal_position = values_.integer_if_any(element);
      break;
    case kTriggerTime:
      plane.trigger_time = values_.number_if_any(element);
      break;
    case kNominalTriggerDelay:
      plane.trigger_time = values_.real_if_any(element);
      break;
    case kTemporalPositionOffset:
      plane.acquisition_time = values_.real_if_any(element);
      break;
    case kFrameAcquisitionDateTime:
    case kFrameReferenceDateTime:
      if (!plane.acquisition_time)
        plane.acquisition_time = dicom_date_time_seconds(values_.text_if_any(element));
      break;
    case kEchoNumbers:
      plane.echo_number = values_.number_if_any(element);
      break;
    case kEchoTime:
      plane.echo_time = values_.number_if_any(element);
      break;
    case kEffectiveEchoTime:
      plane.echo_time = values_.real_if_any(element);
      break;
    case kDiffusionBValue:
      plane.b_value = values_.real_if_any(element);
      break;
    case kRepetitionTime:
      file_.repetition_time = values_.number_if_any(element);
      break;
    case kImageType:
    case kFrameType:
    case kComplexImageComponent:
      visit_image_type(element, plane);
      break;
    case kDimensionIndexValues: {
      const auto indices = values_.words_if_any(element);
      if (indices.size() != is_place_.size()) break;
      plane.dimensions.clear();
      for (std::size_t i = 0; i < indices.size(); ++i)
        if (!is_place_[i]) plane.dimensions.push_back(indices[i]);
      break;
    }
    default:
      break;
  }
}

// The first two values, ORIGINAL or DERIVED, PRIMARY or SECONDARY, are the picture's history.
void DicomCollector::visit_image_type(const DicomElement& element, DicomPlane& plane) {
  std::string type = values_.text_if_any(element);
  if (element.tag == kImageType) {
    const std::string all = "\\" + type + "\\";
    tiles.is_mosaic = all.find("\\MOSAIC\\") != std::string::npos;
    tiles.is_grid = all.find("\\VFRAME\\") != std::string::npos;
  }
  if (element.tag != kComplexImageComponent) {
    for (int i = 0; i < 2; ++i) {
      const auto end = type.find('\\');
      type.erase(0, end == std::string::npos ? end : end + 1);
    }
  }
  if (!plane.image_type.empty() && !type.empty()) plane.image_type += '\\';
  plane.image_type += type;
}

void DicomCollector::visit_general(const DicomElement& element) {
  const DicomTag group = element.tag >> 16U;
  if (is_pixels(element.tag)) return visit_pixels(element);
  if (group == 0x0028U) return visit_image(element);
  if (group % 2 == 1) return visit_private(element);
  if (group == 0x0004U) file_.is_directory = true;
  switch (element.tag) {
    case kSopInstanceUid:
      file_.sop_uid = values_.text(element);
      break;
    case kSeriesInstanceUid:
      file_.series_uid = values_.text(element);
      break;
    case kModality:
      file_.modality = values_.text(element);
      break;
    case kSeriesDescription:
      file_.series_description = values_.text(element);
      break;
    case kUnits:
    case kDoseUnits:
      file_.units = values_.text(element);
      break;
    case kSeriesNumber:
      file_.series_number = values_.number_if_any(element);
      break;
    case kInstanceNumber:
      file_.instance_number = values_.number_if_any(element);
      break;
    case kAcquisitionNumber:
      file_.acquisition_number = values_.number_if_any(element);
      break;
    case kGridFrameOffsets:
      frame_offsets = values_.numbers(element, kMaxOffsetVector);
      break;
    case kImagerPixelSpacing:
      imager_spacing_ = values_.exactly<2>(element);
      break;
    default:
      visit_time(element);
      break;
  }
}

void DicomCollector::visit_time(const DicomElement& element) {
  switch (element.tag) {
    case kAcquisitionDateTime:
      general.acquisition_time = dicom_date_time_seconds(values_.text_if_any(element));
      break;
    case kAcquisitionDate:
      acquisition_day_ = dicom_date_seconds(values_.text_if_any(element));
      break;
    case kAcquisitionTime:
      acquisition_time_ = dicom_time_seconds(values_.text_if_any(element));
      break;
    case kContentDate:
      content_day_ = dicom_date_seconds(values_.text_if_any(element));
      break;
    case kContentTime:
      content_time_ = dicom_time_seconds(values_.text_if_any(element));
      break;
    case kTemporalResolution:
      file_.temporal_resolution = values_.number_if_any(element);
      break;
    case kFrameTime:
      file_.frame_time = values_.number_if_any(element);
      break;
    case kMrAcquisitionType:
      file_.is_3d_acquisition = values_.text_if_any(element) == "3D";
      break;
    default:
      break;
  }
}

// Of every group the first block stands for the owner that usually has it, where none is named.
bool DicomCollector::is_owned_by(const DicomElement& element, std::string_view owner) const {
  const auto found =
      private_owners_.find((element.tag & 0xFFFF0000U) | (element.tag >> 8U & 0xFFU));
  if (found != private_owners_.end()) return found->second == owner;
  return (element.tag >> 8U & 0xFFU) == 0x10U;
}

void DicomCollector::visit_private(const DicomElement& element) {
  const DicomTag group = element.tag >> 16U, place = element.tag & 0xFFFFU;
  if (place >= 0x10U && place <= 0xFFU) {
    if (private_owners_.size() < kMaxPrivateOwners)
      private_owners_[element.tag] = values_.text_if_any(element, 64);
    return;
  }
  if (place < 0x1000U) return;
  const DicomTag number = place & 0xFFU;
  if (group == 0x0019U || group == 0x0029U) return visit_siemens(group, number, element);
  if (group == 0x0043U && is_owned_by(element, "GEMS_PARM_01")) {
    if (number == 0x39U) {
      // GE adds 10^9 to the b-value of some pulse sequences.
      const auto b = values_.number_if_any(element);
      if (b && *b >= 0) general.b_value = std::fmod(*b, 1e8);
    }
    constexpr const char* kComponents[] = {"MAGNITUDE", "PHASE", "REAL", "IMAGINARY"};
    const auto kind = number == 0x2FU ? values_.integer_if_any(element) : std::nullopt;
    if (kind && *kind < 4) {
      if (!general.image_type.empty()) general.image_type += '\\';
      general.image_type += kComponents[static_cast<std::size_t>(*kind)];
    }
  }
  if (group == 0x2001U && number == 0x03U && is_owned_by(element, "Philips Imaging DD 001"))
    general.b_value = values_.real_if_any(element);
  if (group == 0x0065U) {
    if (number == 0x50U) tiles.num_slices = values_.number_if_any(element);
    if (number == 0x09U) general.b_value = values_.real_if_any(element);
  }
}

void DicomCollector::visit_siemens(DicomTag group, DicomTag number, const DicomElement& element) {
  if (group == 0x0029U) {
    if (number != 0x10U || element.length > kMaxCsaHeader) return;
    if (is_owned_by(element, "SIEMENS CSA HEADER"))
      tiles.csa = read_csa_header(source_.text(element.offset, element.length));
    return;
  }
  if (!is_owned_by(element, "SIEMENS MR HEADER")) return;
  if (number == 0x0AU) tiles.num_slices = values_.count_if_any(element);
  if (number == 0x0CU) general.b_value = values_.number_if_any(element);
  if (number == 0x29U && element.length % 8 == 0)
    tiles.num_slice_times = static_cast<double>(element.length) / 8;
}

void DicomCollector::visit_image(const DicomElement& element) {
  const auto small_integer = [&] {
    return static_cast<int>(std::min<std::int64_t>(values_.integer(element), 65535));
  };
  switch (element.tag) {
    case kPhotometric:
      file_.photometric = values_.text(element);
      break;
    case kNumberOfFrames:
      if (const auto count = values_.number(element)) {
        if (!(*count >= 1 && *count <= static_cast<double>(kMaxDicomFrames)))
          values_.fail(element,
                       fmt::format("{} frames: expected 1 to {}", *count, kMaxDicomFrames));
        file_.num_frames = static_cast<std::int64_t>(*count);
      }
      break;
    case kFrameIncrementPointer: {
      constexpr DicomTag kFrameTimeVector = 0x00181065;
      const DicomTag pointer = tag_value(element);
      file_.frames_are_times = pointer == kFrameTime || pointer == kFrameTimeVector;
      break;
    }
    case kSamplesPerPixel:
      file_.samples_per_pixel = small_integer();
      break;
    case kRows:
      file_.rows = values_.integer(element);
      break;
    case kColumns:
      file_.columns = values_.integer(element);
      break;
    case kBitsAllocated:
      file_.bits_allocated = small_integer();
      break;
    case kBitsStored:
      file_.bits_stored = small_integer();
      break;
    case kHighBit:
      file_.high_bit = small_integer();
      has_high_bit_ = true;
      break;
    case kPixelRepresentation:
      file_.is_signed = values_.integer(element) == 1;
      break;
    case kModalityLut:
      file_.has_modality_lut = true;
      break;
    default:
      break;
  }
}

void DicomCollector::visit_pixels(const DicomElement& element) {
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
}

void DicomCollector::finish() {
  if (!general.spacing && imager_spacing_) {
    general.spacing = imager_spacing_;
    file_.spacing_is_imager = true;
  }
  // Without its date a time of day begins anew at midnight.
  if (!general.acquisition_time && acquisition_time_)
    general.acquisition_time = *acquisition_time_ + acquisition_day_.value_or(0);
  if (content_time_) general.content_time = *content_time_ + content_day_.value_or(0);
  if (!general.b_value) general.b_value = tiles.csa.b_value;
}

}  // namespace ovoid::io
