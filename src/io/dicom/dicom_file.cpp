// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/core/samples.h"
#include "io/dicom/dicom_codec.h"
#include "io/dicom/dicom_collector.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr const char* kImplicitSyntax = "1.2.840.10008.1.2";
constexpr const char* kBigSyntax = "1.2.840.10008.1.2.2";

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

void complete_planes(DicomCollector& found, DicomFile& file) {
  const auto num_frames = static_cast<std::size_t>(file.num_frames);
  found.shared.complete_from(found.general);
  file.planes = std::move(found.own);
  file.planes.resize(num_frames);
  for (DicomPlane& plane : file.planes) plane.complete_from(found.shared);
  if (num_frames == 1 || found.has_own_positions) return;
  if (file.frames_are_times) {
    for (std::size_t i = 0; i < num_frames; ++i) {
      file.planes[i].temporal_position = static_cast<double>(i);
      if (file.frame_time) file.planes[i].trigger_time = *file.frame_time * static_cast<double>(i);
    }
  } else {
    stack_frames(found.frame_offsets, file);
  }
}

// The place of a mosaic's first slice. What its file states is the first sample's place of a slice
// as large as the whole picture, with the same centre.
Vec3 mosaic_start(const DicomFile& file, const DicomPlane& plane) {
  const double right =
      static_cast<double>(file.columns - file.slice_columns()) / 2 * (*plane.spacing)[1];
  const double down = static_cast<double>(file.rows - file.slice_rows()) / 2 * (*plane.spacing)[0];
  return *plane.position + (*plane.orientation)[0] * right + (*plane.orientation)[1] * down;
}

// From slice to slice: along the normal, against it where the CSA header says so.
std::optional<Vec3> mosaic_step(const DicomPlane& plane, const CsaHeader& csa) {
  const auto distance = plane.slice_spacing ? plane.slice_spacing : plane.slice_thickness;
  if (!distance || *distance == 0) return std::nullopt;
  const Vec3 normal = (*plane.orientation)[0].cross((*plane.orientation)[1]);
  const bool is_against = csa.normal && csa.normal->dot(normal) < 0;
  return normal * (is_against ? -std::abs(*distance) : std::abs(*distance));
}

// A plane for each tile of a picture of many.
void divide_plane(const StatedTiles& stated, DicomFile& file) {
  const DicomPlane whole = file.planes.front();
  file.planes.assign(static_cast<std::size_t>(file.tiles.count), whole);
  if (stated.is_grid) {
    for (std::size_t i = 0; i < file.planes.size(); ++i)
      file.planes[i].position = stated.positions[i];
    return;
  }
  const bool is_placed = whole.position && whole.orientation && whole.spacing;
  const auto step = is_placed ? mosaic_step(whole, stated.csa) : std::nullopt;
  const Vec3 start = step ? mosaic_start(file, whole) : Vec3::Zero();
  for (std::size_t i = 0; i < file.planes.size(); ++i) {
    file.planes[i].position.reset();
    if (step) file.planes[i].position = start + *step * static_cast<double>(i);
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
  fill(trigger_time, general.trigger_time);
  fill(acquisition_time, general.acquisition_time);
  fill(content_time, general.content_time);
  fill(echo_number, general.echo_number);
  fill(echo_time, general.echo_time);
  fill(b_value, general.b_value);
  if (rescale_type.empty()) rescale_type = general.rescale_type;
  if (image_type.empty()) image_type = general.image_type;
  if (dimensions.empty()) dimensions = general.dimensions;
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
  DicomCollector found(data, file);
  walk_dicom(data, meta.end, dicom_syntax_at(data, meta.end, claimed), found);
  found.finish();
  file.tiles = divide_tiles(found.tiles, file.rows, file.columns, file.num_frames);
  if (file.pixels == DicomPixels::kNone || !unreadable_reason(file).empty()) return file;
  check_image(file);
  if (file.is_encapsulated) {
    assign_fragments(data, file);
  } else {
    check_native_length(file);
  }
  complete_planes(found, file);
  if (file.is_tiled()) divide_plane(found.tiles, file);
  return file;
}

std::string unreadable_reason(const DicomFile& file) {
  if (file.samples_per_pixel != 1) {
    return fmt::format("colour picture ({}, {} samples per pixel)", file.photometric,
                       file.samples_per_pixel);
  }
  if (!file.tiles.fault.empty()) return file.tiles.fault;
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
