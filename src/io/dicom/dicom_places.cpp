// SPDX-License-Identifier: Apache-2.0
// Where the slices of a group lie: the lattice, and which of its planes they are.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/core/samples.h"
#include "io/dicom/dicom_series.h"
#include "io/dicom/even_planes.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

[[noreturn]] void fail_placing(const std::string& name, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", name, what));
}

// Directions of unit length and at right angles, from ones that nearly are.
std::array<Vec3, 2> straightened(const DicomFile& file, const std::array<Vec3, 2>& given,
                                 std::vector<std::string>& notes) {
  const double off = std::max({std::abs(given[0].norm() - 1), std::abs(given[1].norm() - 1),
                               std::abs(given[0].dot(given[1]))});
  if (!(off <= kDicomOrientationTolerance)) {
    fail_placing(
        file.name,
        fmt::format("ImageOrientationPatient ({:.6g}, {:.6g}, {:.6g}) ({:.6g}, {:.6g}, {:.6g}): "
                    "expected two directions of length 1 at a right angle",
                    given[0].x(), given[0].y(), given[0].z(), given[1].x(), given[1].y(),
                    given[1].z()));
  }
  if (off > 1e-4) {
    notes.push_back(fmt::format(
        "{}: ImageOrientationPatient is off unit length or a right angle by {:.2g}: straightened",
        file.name, off));
  }
  const Vec3 row = given[0].normalized();
  return {row, (given[1] - row * row.dot(given[1])).normalized()};
}

// Slices in their order, and what the lattice makes of it.
class Placer {
 public:
  Placer(const std::vector<DicomFile>& files, DicomGroup group)
      : files_(files), group_(std::move(group)) {}

  DicomVolume run() {
    volume_.name = std::move(group_.name);
    volume_.description = std::move(group_.description);
    volume_.times = std::move(group_.times);
    volume_.notes = std::move(group_.notes);
    find_places();
    const DicomFile& file = files_[places_[0].file];
    const DicomPlane& plane = plane_of(0);
    num_slices_ = places_.size();
    for (std::size_t i = 0; i < num_slices_; ++i)
      volume_.planes.push_back(static_cast<std::int64_t>(i));
    find_plane(file, plane);
    if (!file.tiles.note.empty()) note(fmt::format("{}: {}", file.name, file.tiles.note));
    if (plane.position && plane.orientation) {
      place_slices(file, plane);
      note_moves();
    } else {
      stack_by_number(file, plane);
    }
    volume_.lattice.dims = {file.slice_columns(), file.slice_rows(), volume_.planes.back() + 1};
    check_geometry(file.name + ": positions and sample distances",
                   volume_.lattice.world_from_index);
    volume_.steps = std::move(group_.steps);
    return std::move(volume_);
  }

 private:
  const DicomPlane& plane_of(std::size_t slice) const {
    const DicomFrame& frame = places_[slice];
    return files_[frame.file].planes[frame.frame];
  }
  const std::string& name_of_slice(std::size_t slice) const {
    return files_[places_[slice].file].name;
  }
  // The first frame at each place stands for all of them.
  void find_places() {
    places_.resize(group_.steps[0].size());
    for (const DicomFrames& step : group_.steps)
      for (std::size_t i = 0; i < places_.size(); ++i)
        if (places_[i].is_missing()) places_[i] = step[i];
  }

  void note(std::string text) { volume_.notes.push_back(std::move(text)); }

  // The first two axes.
  void find_plane(const DicomFile& file, const DicomPlane& plane) {
    std::array<double, 2> spacing = plane.spacing.value_or(std::array<double, 2>{1, 1});
    if (!plane.spacing) {
      note(fmt::format("{}: no PixelSpacing: samples are taken to be 1 mm apart", file.name));
    } else if (file.spacing_is_imager) {
      note(
          fmt::format("{}: no PixelSpacing: ImagerPixelSpacing, measured at the detector, is "
                      "taken instead",
                      file.name));
    }
    if (!(spacing[0] > 0 && spacing[1] > 0)) {
      fail_placing(file.name, fmt::format("PixelSpacing {:.6g}, {:.6g}: expected two numbers > 0",
                                          spacing[0], spacing[1]));
    }
    std::array<Vec3, 2> directions{Vec3::UnitX(), Vec3::UnitY()};
    if (plane.orientation) {
      directions = straightened(file, *plane.orientation, volume_.notes);
    } else {
      volume_.space = Space::kNone;
      note(fmt::format("{}: no ImageOrientationPatient: the place in the patient is not known",
                       file.name));
    }
    // The distance of rows is named first; along a row samples are columns apart.
    volume_.lattice.world_from_index.linear().col(0) = directions[0] * spacing[1];
    volume_.lattice.world_from_index.linear().col(1) = directions[1] * spacing[0];
    normal_ = directions[0].cross(directions[1]);
  }

  // The third axis where positions do not give it.
  double stated_step(const DicomFile& file, const DicomPlane& plane) {
    const auto& axes = volume_.lattice.world_from_index.linear();
    const auto is_length = [](const std::optional<double>& x) { return x && *x > 0; };
    const double thin = std::min(axes.col(0).norm(), axes.col(1).norm());
    if (is_length(plane.slice_spacing)) return *plane.slice_spacing;
    if (is_length(plane.slice_thickness)) return *plane.slice_thickness;
    if (num_slices_ > 1) {
      note(
          fmt::format("{}: neither positions nor SpacingBetweenSlices nor SliceThickness: slices "
                      "are taken to be {:.6g} mm apart",
                      file.name, thin));
    }
    return thin;
  }

  void place_slices(const DicomFile& file, const DicomPlane& plane) {
    auto& world = volume_.lattice.world_from_index;
    world.translation() = *plane.position;
    if (file.guesses_frame_positions) {
      note(
          fmt::format("{}: only the first frame's position is stated: frames are taken to follow "
                      "it along the normal",
                      file.name));
    }
    if (num_slices_ == 1) {
      world.linear().col(2) = normal_ * stated_step(file, plane);
      return;
    }
    const Vec3 first = *plane.position;
    const Vec3 span = *plane_of(num_slices_ - 1).position - first;
    std::vector<double> heights;
    for (std::size_t i = 0; i < num_slices_; ++i)
      heights.push_back(normal_.dot(*plane_of(i).position - first));
    EvenPlanes even = find_even_planes(heights, kDicomTolerance);
    const Vec3 step = span / static_cast<double>(even.planes.back());
    world.linear().col(2) = step;
    note_planes(even, heights);
    check_slant(first, step / even.distance, heights);
    volume_.planes = std::move(even.planes);
  }

  void note_planes(const EvenPlanes& even, const std::vector<double>& heights) {
    if (even.is_usual) {
      note_gaps(even);
      note_uneven(even, heights);
      return;
    }
    double least = heights[1] - heights[0], most = least;
    for (std::size_t i = 2; i < heights.size(); ++i) {
      least = std::min(least, heights[i] - heights[i - 1]);
      most = std::max(most, heights[i] - heights[i - 1]);
    }
    const auto num_left_out =
        std::count(even.planes.begin(), even.planes.end(), EvenPlanes::kLeftOut);
    std::string text = fmt::format(
        "{}: slices lie {:.6g} to {:.6g} mm apart: {} of {:.6g} mm are made of them, those between "
        "by linear interpolation",
        name_of_slice(0), least, most, even.count(), even.distance);
    if (even.worst > kDicomSlack * even.distance)
      text += fmt::format("; slices lie up to {:.4g} mm beside their places", even.worst);
    if (num_left_out > 0)
      text += fmt::format("; {} that have no place of their own are left out", num_left_out);
    note(text);
  }

  void note_gaps(const EvenPlanes& even) {
    for (std::size_t i = 1; i < even.planes.size(); ++i) {
      const std::int64_t gap = even.planes[i] - even.planes[i - 1] - 1;
      if (gap == 0) continue;
      note(fmt::format("{} of {} slices {} missing between {} and {}: interpolated", gap,
                       even.count(), gap == 1 ? "is" : "are", name_of_slice(i - 1),
                       name_of_slice(i)));
    }
  }

  void note_uneven(const EvenPlanes& even, const std::vector<double>& heights) {
    if (even.worst <= kDicomSlack * even.distance) return;
    const auto off = [&](std::size_t i) {
      return std::abs(heights[i] - even.distance * static_cast<double>(even.planes[i]));
    };
    std::size_t at = 0;
    for (std::size_t i = 1; i < heights.size(); ++i)
      if (off(i) > off(at)) at = i;
    note(
        fmt::format("{}: slices are not evenly spaced: this one is {:.4g} mm off; the mean "
                    "distance, {:.6g} mm, is taken",
                    name_of_slice(at), off(at), even.distance));
  }

  // Slices of a tilted gantry are displaced sideways in proportion to their heights: a lattice may
  // be sheared, but not bent. `slant`: the way for each mm of height.
  void check_slant(const Vec3& first, const Vec3& slant, const std::vector<double>& heights) {
    const auto& axes = volume_.lattice.world_from_index.linear();
    double worst = 0;
    std::size_t at = 0;
    for (std::size_t i = 0; i < num_slices_; ++i) {
      const Vec3 off = *plane_of(i).position - first - slant * heights[i];
      if (off.norm() > worst) {
        worst = off.norm();
        at = i;
      }
    }
    const double distance = heights.back() / static_cast<double>(num_slices_ - 1);
    const double sample = std::min(axes.col(0).norm(), axes.col(1).norm());
    if (!(worst <= std::max(kDicomTolerance * distance, sample / 2))) {
      fail_placing(
          name_of_slice(at),
          fmt::format("lies {:.4g} mm beside the line between the first and the last of its "
                      "slices: expected slices that are not displaced sideways, or evenly",
                      worst));
    }
    if (worst > std::max(kDicomSlack * distance, 0.1 * sample)) {
      note(
          fmt::format("{}: lies {:.4g} mm beside the line between the first and the last of its "
                      "slices: it is drawn on the line",
                      name_of_slice(at), worst));
    }
  }

  // How far the frames of other steps lie from the first ones, whose places are taken.
  void note_moves() {
    const auto& axes = volume_.lattice.world_from_index.linear();
    double worst = 0;
    for (const DicomFrames& step : group_.steps) {
      for (std::size_t i = 0; i < step.size(); ++i) {
        if (step[i].is_missing()) continue;
        const DicomPlane& plane = files_[step[i].file].planes[step[i].frame];
        if (plane.position)
          worst = std::max(worst, (*plane.position - *plane_of(i).position).norm());
      }
    }
    if (worst > 0.1 * std::min(axes.col(0).norm(), axes.col(1).norm())) {
      note(
          fmt::format("its volumes lie up to {:.4g} mm from the first, whose place is taken for "
                      "all of them",
                      worst));
    }
  }

  void stack_by_number(const DicomFile& file, const DicomPlane& plane) {
    if (num_slices_ > 1) {
      const bool is_numbered = file.planes.size() > 1 || file.instance_number;
      note(fmt::format("{}: no ImagePositionPatient: slices are ordered by {}", file.name,
                       is_numbered ? "their numbers" : "the files' names"));
    }
    if (plane.position) volume_.lattice.world_from_index.translation() = *plane.position;
    volume_.lattice.world_from_index.linear().col(2) = normal_ * stated_step(file, plane);
  }

  const std::vector<DicomFile>& files_;
  DicomGroup group_;
  DicomVolume volume_;
  DicomFrames places_;  // of each place the first frame
  Vec3 normal_ = Vec3::UnitZ();
  std::size_t num_slices_ = 0;
};

}  // namespace

bool DicomVolume::is_resampled() const {
  for (std::size_t i = 0; i < planes.size(); ++i)
    if (planes[i] != static_cast<std::int64_t>(i)) return true;
  return std::any_of(steps.begin(), steps.end(), [](const DicomFrames& step) {
    return std::any_of(step.begin(), step.end(),
                       [](const DicomFrame& frame) { return frame.is_missing(); });
  });
}

std::vector<DicomPlaneParts> parts_of_planes(const DicomVolume& volume, std::size_t step) {
  std::vector<DicomPlaneParts> parts;
  parts.reserve(static_cast<std::size_t>(volume.lattice.dims[2]));
  DicomFrame below;
  for (std::size_t i = 0; i < volume.planes.size(); ++i) {
    const DicomFrame& above = volume.steps[step][i];
    if (above.is_missing() || volume.planes[i] == DicomVolume::kLeftOut) continue;
    const auto first = static_cast<std::int64_t>(parts.size());
    for (std::int64_t plane = first; plane < volume.planes[i]; ++plane) {
      const double weight = static_cast<double>(plane - first + 1) /
                            static_cast<double>(volume.planes[i] - first + 1);
      parts.push_back({below, above, weight});
    }
    parts.push_back({above, {}, 0});
    below = above;
  }
  return parts;
}

DicomVolume place_dicom_group(const std::vector<DicomFile>& files, DicomGroup group) {
  return Placer(files, std::move(group)).run();
}

}  // namespace ovoid::io
