// SPDX-License-Identifier: Apache-2.0
// What one DICOM file says about its frames: the elements that a volume needs, found and checked.
// Pixel data stay in the file.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/dicom/dicom_elements.h"
#include "io/dicom/dicom_tiles.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// What is said of one frame: by a functional group of its own, by the shared one, or by the file.
struct DicomPlane {
  std::optional<Vec3> position;                    // of the first sample's centre, LPS, mm
  std::optional<std::array<Vec3, 2>> orientation;  // directions of a row and of a column
  std::optional<std::array<double, 2>> spacing;    // distance of rows, of columns, mm
  std::optional<double> slice_spacing;             // as stated; positions say it better
  std::optional<double> slice_thickness;
  std::optional<double> slope;
  std::optional<double> intercept;
  std::string rescale_type;  // unit of the rescaled values

  // What tells frames at one place apart. Of times only differences mean something.
  std::optional<double> temporal_position;  // number of the time step
  std::optional<double> trigger_time;       // ms
  std::optional<double> acquisition_time;   // s
  std::optional<double> content_time;       // s
  std::optional<double> echo_number;
  std::optional<double> echo_time;        // ms
  std::optional<double> b_value;          // s/mm^2
  std::string image_type;                 // what the values are: ImageType from the third on
  std::vector<std::uint32_t> dimensions;  // DimensionIndexValues but those that say the place

  // Takes what is open here from what holds for more frames.
  void complete_from(const DicomPlane& general);
};

// Which element holds the pixels.
enum class DicomPixels { kNone, kInteger, kFloat32, kFloat64 };

struct DicomFile {
  std::string name;
  std::string transfer_syntax;  // UID
  std::string series_uid, sop_uid, modality, series_description, photometric, units;
  std::optional<double> series_number, instance_number, acquisition_number;
  std::optional<double> repetition_time, temporal_resolution, frame_time;  // ms
  bool is_directory = false;                                               // a DICOMDIR
  bool is_3d_acquisition = false;        // RepetitionTime is not that of the volume
  bool spacing_is_imager = false;        // the spacing is the detector's, not the patient's
  bool has_modality_lut = false;         // values are to be looked up in a table: not done
  bool frames_are_times = false;         // the frames are moments of one place
  bool guesses_frame_positions = false;  // only the first frame's is stated

  std::int64_t rows = 0, columns = 0, num_frames = 1;  // as stored
  DicomTiles tiles;                                    // of each of them
  int samples_per_pixel = 1, bits_allocated = 0, bits_stored = 0, high_bit = 0;
  bool is_signed = false;

  DicomPixels pixels = DicomPixels::kNone;
  DicomElement pixel_data;
  bool is_encapsulated = false;
  bool is_deflated = false;
  std::vector<DicomFragment> fragments;       // without the table of offsets
  std::vector<std::int64_t> fragment_starts;  // for each frame: its first fragment; and the end
  std::vector<DicomPlane> planes;             // [num_frames * tiles.count], tiles fastest

  ScalarType scalar_type() const noexcept;
  bool is_tiled() const noexcept { return tiles.count > 1; }
  // Of a slice: a frame or a tile.
  std::int64_t slice_rows() const noexcept { return rows / tiles.down; }
  std::int64_t slice_columns() const noexcept { return columns / tiles.across; }
  std::int64_t slice_bytes() const noexcept {
    return slice_rows() * slice_columns() * bits_allocated / 8;
  }
  std::int64_t frame_bytes() const noexcept { return rows * columns * bits_allocated / 8; }
};

// Frames of one file.
inline constexpr std::int64_t kMaxDicomFrames = 100'000;

// The source that a file's offsets count in: the file itself, or what its deflated data set holds.
std::shared_ptr<const ByteSource> dicom_data_source(std::shared_ptr<const ByteSource> file);

// Reads everything but the pixels. A file without pixels (a report, a directory) has
// DicomPixels::kNone and is not checked further. `data` is what dicom_data_source returned. Throws
// Error(kFileFormat) naming file and element.
DicomFile read_dicom_file(const ByteSource& data);

// Why the frames of a file, which is sound, cannot become a volume ("colour picture (RGB)"); empty
// if they can.
std::string unreadable_reason(const DicomFile& file);

}  // namespace ovoid::io
