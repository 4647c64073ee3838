// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "io/dicom/dicom_steps.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kMaxGroups = 1000;

// Two frames lie at the same place if they are closer than this part of the sample distance.
constexpr double kSamePlace = 1e-3;

// Volumes of tiles may have been turned a little between two times, after the patient.
constexpr double kSameTurn = 0.1;

using Frames = DicomFrames;

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
                       const std::optional<std::array<Vec3, 2>>& b, double tolerance) {
    if (!a || !b) return !a && !b;
    return ((*a)[0] - (*b)[0]).norm() < tolerance && ((*a)[1] - (*b)[1]).norm() < tolerance;
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
    const Key key{file.series_uid, file.slice_rows(), file.slice_columns(), file.tiles.count,
                  file.scalar_type()};
    const double tolerance = file.is_tiled() ? kSameTurn : kDicomOrientationTolerance;
    std::vector<Stack>& stacks = stacks_[key];
    for (Stack& stack : stacks) {
      if (stack.has_positions == own.position.has_value() &&
          is_close(stack.orientation, own.orientation, tolerance) &&
          is_close(stack.spacing, own.spacing)) {
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
    if (stack.file->is_tiled()) return places_of_tiles(stack);
    if (!stack.has_positions || !stack.orientation) return places_by_number(stack);
    std::vector<Frames> places;
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

  // Without positions every frame is a slice, but for those that are said to be moments.
  std::vector<Frames> places_by_number(const Stack& stack) const {
    if (stack.file->frames_are_times) return {stack.frames};
    std::map<double, Frames> times;
    bool are_told = true;
    for (const DicomFrame& frame : stack.frames) {
      const auto& time = plane(frame).temporal_position;
      are_told = are_told && time;
      times[time.value_or(0)].push_back(frame);
    }
    const std::size_t num_places = times.begin()->second.size();
    const bool are_equal = std::all_of(times.begin(), times.end(), [&](const auto& time) {
      return time.second.size() == num_places;
    });
    std::vector<Frames> places;
    if (!are_told || !are_equal) {
      for (const DicomFrame& frame : stack.frames) places.push_back({frame});
      return places;
    }
    places.resize(num_places);
    for (const auto& [time, frames] : times)
      for (std::size_t i = 0; i < num_places; ++i) places[i].push_back(frames[i]);
    return places;
  }

  // Every file has all places, wherever the patient has moved.
  std::vector<Frames> places_of_tiles(const Stack& stack) const {
    std::vector<Frames> places(static_cast<std::size_t>(stack.file->tiles.count));
    for (const DicomFrame& frame : stack.frames) places[frame.frame].push_back(frame);
    if (!stack.has_positions || !stack.orientation) return places;
    const Vec3 normal = (*stack.orientation)[0].cross((*stack.orientation)[1]);
    const Vec3 span = *plane(places.back()[0]).position - *plane(places.front()[0]).position;
    if (normal.dot(span) < 0) std::reverse(places.begin(), places.end());
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

  // Leaves one of those with the same pixels at every place, if all places then have as many;
  // returns how many went. Slices of a series in time may be the same, too, where nothing is.
  std::int64_t drop_same_pixels(std::vector<Frames>& places) const {
    constexpr std::size_t kMost = 4;  // every frame is compared with every other
    std::vector<Frames> kept;
    std::int64_t count = 0;
    for (const Frames& place : places) {
      if (place.size() > kMost) return 0;
      kept.emplace_back();
      for (const DicomFrame& frame : place) {
        const bool is_known =
            std::any_of(kept.back().begin(), kept.back().end(),
                        [&](const DicomFrame& other) { return is_same_(frame, other); });
        if (!is_known) kept.back().push_back(frame);
      }
      count += static_cast<std::int64_t>(place.size() - kept.back().size());
    }
    if (!is_uniform(kept)) return 0;
    places = std::move(kept);
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
    for (DicomKind& kind : split_dicom_kinds(files_, std::move(places)))
      add_kind(stack, kind, notes);
  }

  // Frames of one kind: a volume, steps of one, or, where fewer than two steps are whole, volumes
  // of their own.
  void add_kind(const Stack& stack, DicomKind& kind, std::vector<std::string> notes) {
    drop_stray_places(kind.places, notes);
    std::vector<Frames> steps = order_dicom_steps(files_, kind.places);
    DicomTimes times = times_of_dicom_steps(files_, steps);
    if (steps.size() > 1) {
      const auto num_whole = std::count_if(steps.begin(), steps.end(), is_whole);
      if (num_whole < 2) return add_parts(stack, kind, std::move(steps), notes);
      leave_out_parts(steps, times, notes);
      const std::string weighting = diffusion_text(files_, steps);
      if (!weighting.empty())
        notes.push_back(
            fmt::format("its steps are diffusion weightings, b = {} s/mm^2", weighting));
    }
    add_group(stack, kind, std::move(steps), std::move(times), std::move(notes));
  }

  // Places of a series in time that most times lack, as of a slice that was taken to plan it.
  static void drop_stray_places(std::vector<Frames>& places, std::vector<std::string>& notes) {
    constexpr std::size_t kSeries = 3;
    std::size_t most = 0, num_slices = 0;
    for (const Frames& place : places) most = std::max(most, place.size());
    if (most < kSeries) return;
    const auto num_places = std::erase_if(places, [&](const Frames& place) {
      const bool is_stray = 2 * place.size() < most;
      if (is_stray) num_slices += place.size();
      return is_stray;
    });
    if (num_places == 0) return;
    notes.push_back(
        fmt::format("{} {} left out: the series has {} volumes in time, of which most "
                    "have none at {}",
                    num_slices, num_slices == 1 ? "slice is" : "slices are", most,
                    num_places == 1 ? "that place" : "those places"));
  }

  // Whether a step can be drawn: its ends are there, and nine of ten slices.
  static bool is_whole(const Frames& step) {
    const auto num_missing =
        std::count_if(step.begin(), step.end(), [](const DicomFrame& f) { return f.is_missing(); });
    return !step.front().is_missing() && !step.back().is_missing() &&
           10 * num_missing <= static_cast<std::ptrdiff_t>(step.size());
  }

  static void leave_out_parts(std::vector<Frames>& steps, DicomTimes& times,
                              std::vector<std::string>& notes) {
    std::vector<Frames> kept;
    std::vector<double> kept_times;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const auto num_missing = std::count_if(steps[i].begin(), steps[i].end(),
                                             [](const DicomFrame& f) { return f.is_missing(); });
      const bool is_kept = is_whole(steps[i]);
      if (num_missing > 0) {
        notes.push_back(fmt::format("volume {} of {} in time lacks {} of {} slices: {}", i + 1,
                                    steps.size(), num_missing, steps[i].size(),
                                    is_kept ? "they are interpolated" : "it is left out"));
      }
      if (!is_kept) continue;
      kept.push_back(std::move(steps[i]));
      if (!times.values.empty()) kept_times.push_back(times.values[i]);
    }
    steps = std::move(kept);
    times.values = std::move(kept_times);
  }

  // Nothing makes steps of them: each is what it is. Where few places have several frames, those
  // are taken out of one volume.
  void add_parts(const Stack& stack, const DicomKind& kind, std::vector<Frames> steps,
                 const std::vector<std::string>& notes) {
    const auto num_several = std::count_if(kind.places.begin(), kind.places.end(),
                                           [](const Frames& place) { return place.size() > 1; });
    if (4 * num_several <= static_cast<std::ptrdiff_t>(kind.places.size()))
      steps = rank_dicom_frames(kind.places);
    for (const Frames& step : steps) {
      Frames own;
      for (const DicomFrame& frame : step)
        if (!frame.is_missing()) own.push_back(frame);
      std::vector<std::string> own_notes = notes;
      own_notes.push_back(
          fmt::format("up to {} slices lie at the same place: divided by their instance numbers",
                      steps.size()));
      add_group(stack, kind, {std::move(own)}, {}, std::move(own_notes));
    }
  }

  void add_group(const Stack& stack, const DicomKind& kind, std::vector<Frames> steps,
                 DicomTimes times, std::vector<std::string> notes) {
    if (groups_.size() >= kMaxGroups) {
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: the input has more than {} volumes",
                                                      stack.file->name, kMaxGroups));
    }
    DicomGroup group;
    group.steps = std::move(steps);
    group.times = std::move(times);
    group.notes = std::move(notes);
    group.name = unique_name(*stack.file);
    group.description = description_of(stack, group);
    if (!kind.what.empty()) group.description += ", " + kind.what;
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
    std::string text = fmt::format("{} {}x{}x{} {}", file.modality.empty() ? "?" : file.modality,
                                   file.slice_columns(), file.slice_rows(), group.steps[0].size(),
                                   name_of(file.scalar_type()));
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

  using Key = std::tuple<std::string, std::int64_t, std::int64_t, std::int64_t, ScalarType>;

  const std::vector<DicomFile>& files_;
  const SameFrame& is_same_;
  std::map<Key, std::vector<Stack>> stacks_;
  std::size_t num_stacks_ = 0;
  std::set<std::string> names_;
  std::vector<DicomGroup> groups_;
};

}  // namespace

std::vector<DicomGroup> group_dicom_frames(const std::vector<DicomFile>& files,
                                           const SameFrame& is_same) {
  return Grouper(files, is_same).run();
}

}  // namespace ovoid::io
