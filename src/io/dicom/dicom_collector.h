// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/dicom/dicom_file.h"
#include "io/dicom/dicom_values.h"

namespace ovoid::io {

// Gathers what a volume needs while the elements of a file are walked.
class DicomCollector final : public DicomVisitor {
 public:
  DicomCollector(const ByteSource& source, DicomFile& file)
      : source_(source), values_(source), file_(file) {}

  DicomPlane general, shared;
  std::vector<DicomPlane> own;        // of the first frames; the rest have none
  std::vector<double> frame_offsets;  // GridFrameOffsetVector
  StatedTiles tiles;
  bool has_own_positions = false;

  bool enter(DicomTag sequence, std::span<const DicomLevel> path) override;
  void visit(const DicomElement& element, std::span<const DicomLevel> path) override;
  // After the walk: what several elements say together.
  void finish();

 private:
  bool enter_outermost(DicomTag sequence);
  void visit_plane(const DicomElement& element, DicomPlane& plane);
  void visit_moment(const DicomElement& element, DicomPlane& plane);
  void visit_general(const DicomElement& element);
  void visit_time(const DicomElement& element);
  void visit_image(const DicomElement& element);
  void visit_image_type(const DicomElement& element, DicomPlane& plane);
  void visit_private(const DicomElement& element);
  void visit_siemens(DicomTag group, DicomTag number, const DicomElement& element);
  void visit_grid_slice(const DicomElement& element, std::int64_t item);
  void visit_pixels(const DicomElement& element);
  DicomTag tag_value(const DicomElement& element) const;
  bool is_owned_by(const DicomElement& element, std::string_view owner) const;

  const ByteSource& source_;
  DicomValues values_;
  DicomFile& file_;
  std::optional<std::array<double, 2>> imager_spacing_;
  std::optional<double> acquisition_day_, acquisition_time_, content_day_, content_time_;
  std::map<DicomTag, std::string> private_owners_;  // by group and block
  std::vector<bool> is_place_;  // of each dimension of an enhanced file: the frames' places
  bool has_high_bit_ = false;
};

}  // namespace ovoid::io
