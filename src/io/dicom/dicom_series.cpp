// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kMaxGroups = 1000;

// Two frames lie at the same place if they are closer than this part of the sample distance.
constexpr double kSamePlace = 1e-3;

using Frames = std::vector<DicomFrame>;

// The frames that can be slices of one volume.
struct Stack {
  const DicomFile* file = nullptr;  // its first frame's
  std::optional<std::array<Vec3, 2>> orientation;
  std::optional<std::array<double, 2>> spacing;
  bool has_positions = false;
  Frames frames;
};

class Grouper {
 public:
  Grouper(const std::vector<DicomFile>& files, const SameFrame& is_same)
      : files_(files), is_same_(is_same) {}

  std::vector<DicomGroup> run() {
    for (std::size_t file = 0; file < files_.size(); ++file) {
      for (std::size_t frame = 0; frame < files_[file].planes.size(); ++frame)
        stack_for({file, frame}).frames.push_back({file, frame});
    }
    std::vector<Stack> ordered;
    for (auto& [key, stacks] : stacks_)
      for (Stack& stack : stacks) ordered.push_back(std::move(stack));
    std::stable_sort(ordered.begin(), ordered.end(), [](const Stack& a, const Stack& b) {
      return std::pair(a.file->series_number.value_or(0), a.file->series_uid) <
             std::pair(b.file->series_number.value_or(0), b.file->series_uid);
    });
    for (Stack& stack : ordered) split(stack);
    return std::move(groups_);
  }

 private:
  const DicomPlane& plane(const DicomFrame& frame) const {
    return files_[frame.file].planes[frame.frame];
  }

  static bool is_close(const std::optional<std::array<Vec3, 2>>& a,
                       const std::optional<std::array<Vec3, 2>>& b) {
    if (!a || !b) return !a && !b;
    return ((*a)[0] - (*b)[0]).norm() < kDicomOrientationTolerance &&
           ((*a)[1] - (*b)[1]).norm() < kDicomOrientationTolerance;
  }
  static bool is_close(const std::optional<std::array<double, 2>>& a,
                       const std::optional<std::array<double, 2>>& b) {
    if (!a || !b) return !a && !b;
    return std::abs((*a)[0] - (*b)[0]) <= 1e-4 * std::abs((*a)[0]) &&
           std::abs((*a)[1] - (*b)[1]) <= 1e-4 * std::abs((*a)[1]);
  }

  Stack& stack_for(const DicomFrame& frame) {
    const DicomFile& file = files_[frame.file];
    const DicomPlane& own = plane(frame);
    const Key key{file.series_uid, file.rows, file.columns, file.scalar_type()};
    std::vector<Stack>& stacks = stacks_[key];
    for (Stack& stack : stacks) {
      if (stack.has_positions == own.position.has_value() &&
          is_close(stack.orientation, own.orientation) && is_close(stack.spacing, own.spacing)) {
        return stack;
      }
    }
    if (++num_stacks_ > kMaxGroups) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: the input has more than {} volumes that differ in series, size "
                              "or orientation",
                              file.name, kMaxGroups));
    }
    stacks.push_back({&file, own.orientation, own.spacing, own.position.has_value(), {}});
    return stacks.back();
  }

  // The frames of a stack by place, each place's by their numbers.
  std::vector<Frames> places_of(Stack& stack) const {
    const auto number = [&](const DicomFrame& frame) {
      return std::tuple(files_[frame.file].instance_number.value_or(0), frame.file, frame.frame);
    };
    std::sort(stack.frames.begin(), stack.frames.end(),
              [&](const auto& a, const auto& b) { return number(a) < number(b); });
    std::vector<Frames> places;
    if (!stack.has_positions || !stack.orientation) {
      // Moments of one place are said to be so; else every frame is a slice.
      const bool is_one_place = stack.file->frames_are_times;
      for (const DicomFrame& frame : stack.frames) {
        if (places.empty() || !is_one_place) places.emplace_back();
        places.back().push_back(frame);
      }
      return places;
    }
    const Vec3 normal = (*stack.orientation)[0].cross((*stack.orientation)[1]);
    const auto height = [&](const DicomFrame& f) { return normal.dot(*plane(f).position); };
    std::stable_sort(stack.frames.begin(), stack.frames.end(),
                     [&](const auto& a, const auto& b) { return height(a) < height(b); });
    const double slack =
        kSamePlace * (stack.spacing ? std::min((*stack.spacing)[0], (*stack.spacing)[1]) : 1.0);
    for (const DicomFrame& frame : stack.frames) {
      if (places.empty() || height(frame) - height(places.back().front()) > slack)
        places.emplace_back();
      places.back().push_back(frame);
    }
    for (Frames& place : places) {
      std::sort(place.begin(), place.end(),
                [&](const auto& a, const auto& b) { return number(a) < number(b); });
    }
    return places;
  }

  // Leaves out frames of another file that holds the same instance; returns how many.
  std::int64_t drop_same_instances(std::vector<Frames>& places) const {
    std::int64_t count = 0;
    for (Frames& place : places) {
      std::set<std::pair<std::string, std::size_t>> seen;
      count += std::erase_if(place, [&](const DicomFrame& frame) {
        const std::string& uid = files_[frame.file].sop_uid;
        return !uid.empty() && !seen.insert({uid, frame.frame}).second;
      });
    }
    return count;
  }

  // Leaves one of those with the same pixels at every place; returns how many went.
  std::int64_t drop_same_pixels(std::vector<Frames>& places) const {
    constexpr std::size_t kMost = 16;  // every frame is compared with every other
    std::int64_t count = 0;
    for (Frames& place : places) {
      if (place.size() > kMost) continue;
      Frames kept;
      for (const DicomFrame& frame : place) {
        const bool is_known = std::any_of(kept.begin(), kept.end(), [&](const DicomFrame& other) {
          return is_same_(frame, other);
        });
        if (!is_known) kept.push_back(frame);
      }
      count += static_cast<std::int64_t>(place.size() - kept.size());
      place = std::move(kept);
    }
    return count;
  }

  static bool is_uniform(const std::vector<Frames>& places) {
    return std::all_of(places.begin(), places.end(),
                       [&](const Frames& p) { return p.size() == places[0].size(); });
  }

  void split(Stack& stack) {
    std::vector<Frames> places = places_of(stack);
    std::vector<std::string> notes;
    const auto note = [&](std::int64_t count, const char* what) {
      if (count > 0)
        notes.push_back(
            fmt::format("{} {} left out: {}", count, count == 1 ? "slice is" : "slices are", what));
    };
    note(drop_same_instances(places), "another file holds the same SOP instance");
    if (!is_uniform(places))
      note(drop_same_pixels(places), "another file holds the same pixels at the same place");
    const std::size_t num_repeats =
        std::max_element(places.begin(), places.end(), [](const auto& a, const auto& b) {
          return a.size() < b.size();
        })->size();
    if (num_repeats == 1) return add_group(stack, {places}, {}, std::move(notes));
    if (is_uniform(places) && split_by_time(stack, places, num_repeats, notes)) return;
    split_by_order(stack, places, num_repeats, notes);
  }

  using Value = std::function<std::optional<double>(const DicomFrame&)>;

  // The frames of every place by a value that tells them apart, if the same values are found at
  // every place: values to steps.
  static std::optional<std::map<double, std::vector<Frames>>> sort_by(
      const std::vector<Frames>& places, std::size_t num_repeats, const Value& value) {
    std::map<double, std::vector<Frames>> result;
    for (const Frames& place : places) {
      for (const DicomFrame& frame : place) {
        const auto v = value(frame);
        if (!v) return std::nullopt;
        result[*v].push_back({frame});
      }
      if (result.size() != num_repeats) return std::nullopt;
    }
    for (const auto& [v, step] : result)
      if (step.size() != places.size()) return std::nullopt;
    return result;
  }

  bool split_by_time(Stack& stack, const std::vector<Frames>& places, std::size_t num_repeats,
                     std::vector<std::string>& notes) {
    const auto of_file = [this](std::optional<double> DicomFile::*member) {
      return [this, member](const DicomFrame& f) { return files_[f.file].*member; };
    };
    const Value by_position = [this](const DicomFrame& f) { return plane(f).temporal_position; };
    const std::pair<Value, bool> times[] = {{by_position, false},
                                            {of_file(&DicomFile::trigger_time), true},
                                            {of_file(&DicomFile::acquisition_time), true}};
    // Different echoes are no moments, even if each has a time of its own.
    const Value volumes[] = {of_file(&DicomFile::echo_time),
                             of_file(&DicomFile::acquisition_number)};
    if (const auto found = sort_by(places, num_repeats, volumes[0]))
      return add_volumes(stack, *found, notes);
    for (const auto& [value, is_time] : times) {
      const auto found = sort_by(places, num_repeats, value);
      if (!found) continue;
      std::vector<std::vector<Frames>> steps;
      std::vector<double> values;
      for (const auto& [v, step] : *found) {
        steps.push_back(step);
        if (is_time) values.push_back(v);
      }
      add_group(stack, steps, std::move(values), std::move(notes));
      return true;
    }
    const auto found = sort_by(places, num_repeats, volumes[1]);
    return found && add_volumes(stack, *found, notes);
  }

  bool add_volumes(const Stack& stack, const std::map<double, std::vector<Frames>>& volumes,
                   const std::vector<std::string>& notes) {
    for (const auto& [value, places] : volumes) add_group(stack, {places}, {}, notes);
    return true;
  }

  // Nothing tells them apart but their numbers: the first of each place, the second of each ...
  void split_by_order(const Stack& stack, const std::vector<Frames>& places,
                      std::size_t num_repeats, const std::vector<std::string>& notes) {
    for (std::size_t i = 0; i < num_repeats; ++i) {
      std::vector<Frames> own;
      for (const Frames& place : places)
        if (i < place.size()) own.push_back({place[i]});
      std::vector<std::string> own_notes = notes;
      own_notes.push_back(fmt::format(
          "up to {} slices lie at the same place: divided by their instance numbers", num_repeats));
      add_group(stack, {own}, {}, std::move(own_notes));
    }
  }

  // `steps`: of places with one frame each.
  void add_group(const Stack& stack, const std::vector<std::vector<Frames>>& steps,
                 std::vector<double> times, std::vector<std::string> notes) {
    if (groups_.size() >= kMaxGroups) {
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: the input has more than {} volumes",
                                                      stack.file->name, kMaxGroups));
    }
    DicomGroup group;
    for (const auto& places : steps) {
      group.steps.emplace_back();
      for (const Frames& place : places) group.steps.back().push_back(place.front());
    }
    group.times = std::move(times);
    group.notes = std::move(notes);
    group.name = unique_name(*stack.file);
    group.description = description_of(stack, group);
    groups_.push_back(std::move(group));
  }

  std::string unique_name(const DicomFile& file) {
    const std::string base = file.series_number && std::abs(*file.series_number) < 1e15
                                 ? fmt::format("{:.0f}", *file.series_number)
                                 : "series";
    std::string name = base;
    for (int i = 2; !names_.insert(name).second; ++i) name = fmt::format("{}.{}", base, i);
    return name;
  }

  std::string description_of(const Stack& stack, const DicomGroup& group) const {
    const DicomFile& file = *stack.file;
    std::string text =
        fmt::format("{} {}x{}x{} {}", file.modality.empty() ? "?" : file.modality, file.columns,
                    file.rows, group.steps[0].size(), name_of(file.scalar_type()));
    if (!file.series_description.empty()) text += fmt::format(", '{}'", file.series_description);
    if (group.steps.size() > 1) text += fmt::format(", {} time steps", group.steps.size());
    if (!stack.orientation) return text;
    const Vec3 normal = (*stack.orientation)[0].cross((*stack.orientation)[1]).cwiseAbs();
    Eigen::Index axis = 0;
    if (normal.maxCoeff(&axis) > 0.9) {
      constexpr const char* kPlanes[] = {"sagittal", "coronal", "axial"};
      text += fmt::format(", {}", kPlanes[axis]);
    }
    return text;
  }

  using Key = std::tuple<std::string, std::int64_t, std::int64_t, ScalarType>;

  const std::vector<DicomFile>& files_;
  const SameFrame& is_same_;
  std::map<Key, std::vector<Stack>> stacks_;
  std::size_t num_stacks_ = 0;
  std::set<std::string> names_;
  std::vector<DicomGroup> groups_;
};

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", name, what));
}

// Directions of unit length and at right angles, from ones that nearly are.
std::array<Vec3, 2> straightened(const DicomFile& file, const std::array<Vec3, 2>& given,
                                 std::vector<std::string>& notes) {
  const double off = std::max({std::abs(given[0].norm() - 1), std::abs(given[1].norm() - 1),
                               std::abs(given[0].dot(given[1]))});
  if (!(off <= kDicomOrientationTolerance)) {
    fail(file.name,
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
    const DicomFile& file = files_[group_.steps[0][0].file];
    const DicomPlane& plane = plane_of(0);
    num_slices_ = group_.steps[0].size();
    volume_.lattice.dims = {file.columns, file.rows, static_cast<std::int64_t>(num_slices_)};
    find_plane(file, plane);
    if (plane.position && plane.orientation) {
      place_slices(file, plane);
    } else {
      stack_by_number(file, plane);
    }
    check_geometry(file.name + ": positions and sample distances",
                   volume_.lattice.world_from_index);
    if (volume_.steps.empty()) volume_.steps = std::move(group_.steps);
    return std::move(volume_);
  }

 private:
  const DicomPlane& plane_of(std::size_t slice) const {
    const DicomFrame& frame = group_.steps[0][slice];
    return files_[frame.file].planes[frame.frame];
  }
  const std::string& name_of_slice(std::size_t slice) const {
    return files_[group_.steps[0][slice].file].name;
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
      fail(file.name, fmt::format("PixelSpacing {:.6g}, {:.6g}: expected two numbers > 0",
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
    const std::vector<std::int64_t> indices = slice_indices();
    const Vec3 step = span / static_cast<double>(indices.back());
    check_places(first, step, indices);
    world.linear().col(2) = step;
    fill_gaps(indices);
  }

  // The distance of neighbours: that of most, or of the nearest if most have a gap between them.
  static double usual_distance(std::vector<double> distances) {
    std::sort(distances.begin(), distances.end());
    const double median = distances[distances.size() / 2], least = distances.front();
    if (median < 1.5 * least) return median;
    double sum = 0, count = 0;
    for (const double d : distances) {
      if (d > 1.4 * least) break;
      sum += d;
      ++count;
    }
    return sum / count;
  }

  // Which slice of the lattice each one is: distances are one or several of the usual.
  std::vector<std::int64_t> slice_indices() const {
    std::vector<double> distances;
    for (std::size_t i = 1; i < num_slices_; ++i)
      distances.push_back(normal_.dot(*plane_of(i).position - *plane_of(i - 1).position));
    const double base = usual_distance(distances);
    if (!(base > 0)) fail(name_of_slice(0), "slices of its series lie at the same place");
    // As many may be missing as there are: more is not a volume with gaps.
    const auto most = static_cast<double>(2 * num_slices_);
    std::vector<std::int64_t> indices{0};
    for (std::size_t i = 0; i < distances.size(); ++i) {
      const double steps = std::max(1.0, std::round(distances[i] / base));
      if (!(static_cast<double>(indices.back()) + steps < most)) {
        fail(
            name_of_slice(i),
            fmt::format("the next slice, {}, lies {:.6g} mm away, others {:.6g} mm: more than half "
                        "of the volume would be missing",
                        name_of_slice(i + 1), distances[i], base));
      }
      indices.push_back(indices.back() + static_cast<std::int64_t>(steps));
    }
    return indices;
  }

  void check_places(const Vec3& first, const Vec3& step, const std::vector<std::int64_t>& indices) {
    double worst = 0;
    std::size_t at = 0;
    for (std::size_t i = 0; i < num_slices_; ++i) {
      const Vec3 wanted = first + step * static_cast<double>(indices[i]);
      const double off = (*plane_of(i).position - wanted).norm() / step.norm();
      if (off > worst) {
        worst = off;
        at = i;
      }
    }
    const double distance = step.norm();
    if (!(worst <= kDicomTolerance)) {
      fail(name_of_slice(at),
           fmt::format("lies {:.4g} mm beside its place between {} and {}, in slices {:.6g} mm "
                       "apart: expected even distances",
                       worst * distance, name_of_slice(at == 0 ? 0 : at - 1),
                       name_of_slice(std::min(at + 1, num_slices_ - 1)), distance));
    }
    if (worst > kDicomSlack) {
      note(
          fmt::format("{}: slices are not evenly spaced: this one is {:.4g} mm off; the mean "
                      "distance, {:.6g} mm, is taken",
                      name_of_slice(at), worst * distance, distance));
    }
  }

  void fill_gaps(const std::vector<std::int64_t>& indices) {
    const std::int64_t num_places = indices.back() + 1;
    volume_.num_missing = num_places - static_cast<std::int64_t>(num_slices_);
    if (volume_.num_missing == 0) return;
    volume_.lattice.dims[2] = num_places;
    for (const auto& step : group_.steps) {
      std::vector<DicomFrame> all(static_cast<std::size_t>(num_places));
      for (std::size_t i = 0; i < step.size(); ++i)
        all[static_cast<std::size_t>(indices[i])] = step[i];
      volume_.steps.push_back(std::move(all));
    }
    for (std::size_t i = 1; i < indices.size(); ++i) {
      const std::int64_t gap = indices[i] - indices[i - 1] - 1;
      if (gap == 0) continue;
      note(fmt::format("{} of {} slices {} missing between {} and {}: nothing is drawn there", gap,
                       num_places, gap == 1 ? "is" : "are", name_of_slice(i - 1),
                       name_of_slice(i)));
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
  Vec3 normal_ = Vec3::UnitZ();
  std::size_t num_slices_ = 0;
};

}  // namespace

std::vector<DicomGroup> group_dicom_frames(const std::vector<DicomFile>& files,
                                           const SameFrame& is_same) {
  return Grouper(files, is_same).run();
}

DicomVolume place_dicom_group(const std::vector<DicomFile>& files, DicomGroup group) {
  return Placer(files, std::move(group)).run();
}

}  // namespace ovoid::io
