// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace ovoid::io {
namespace {

// A number of a frame that may tell it from others.
using Label = std::function<std::optional<double>(const DicomFrame&)>;

std::size_t most_frames(const std::vector<DicomFrames>& places) {
  std::size_t most = 0;
  for (const DicomFrames& place : places) most = std::max(most, place.size());
  return most;
}

bool have_equal_counts(const std::vector<DicomFrames>& places) {
  return std::all_of(places.begin(), places.end(),
                     [&](const auto& place) { return place.size() == places[0].size(); });
}

class Orderer {
 public:
  Orderer(const std::vector<DicomFile>& files, const std::vector<DicomFrames>& places)
      : files_(files), places_(places), num_steps_(most_frames(places)) {}

  std::vector<DicomFrames> run() const {
    for (const Label& label : telling_labels())
      if (auto steps = by_value(label)) return std::move(*steps);
    if (!have_equal_counts(places_)) {
      for (const Label& label : {number_in_volumes(), number_in_places()})
        if (auto steps = by_value(label)) return std::move(*steps);
      return rank_dicom_frames(places_);
    }
    const Label number = [this](const DicomFrame& f) { return number_of(f); };
    for (const Label& label :
         {of_plane(&DicomPlane::trigger_time), of_plane(&DicomPlane::acquisition_time), number,
          of_plane(&DicomPlane::content_time)}) {
      if (const auto sorted = sorted_by(label)) return with_even_weighting(*sorted);
    }
    return with_even_weighting(places_);
  }

 private:
  const DicomPlane& plane(const DicomFrame& frame) const {
    return files_[frame.file].planes[frame.frame];
  }
  Label of_plane(std::optional<double> DicomPlane::*member) const {
    return [this, member](const DicomFrame& f) { return plane(f).*member; };
  }

  std::vector<Label> telling_labels() const {
    const Label acquisition = [this](const DicomFrame& f) {
      return files_[f.file].acquisition_number;
    };
    return {of_plane(&DicomPlane::temporal_position), dimension_label(),
            of_plane(&DicomPlane::trigger_time),      of_plane(&DicomPlane::acquisition_time),
            of_plane(&DicomPlane::content_time),      acquisition};
  }

  // The indices of a frame in all dimensions that are not of its place, as one number.
  Label dimension_label() const {
    std::map<std::vector<std::uint32_t>, double> ranks;
    for (const DicomFrames& place : places_)
      for (const DicomFrame& frame : place) ranks.emplace(plane(frame).dimensions, 0.0);
    double next = 0;
    for (auto& [indices, rank] : ranks) rank = next++;
    return [this, ranks = std::move(ranks)](const DicomFrame& f) -> std::optional<double> {
      const auto& indices = plane(f).dimensions;
      return indices.empty() ? std::nullopt : std::optional(ranks.at(indices));
    };
  }

  // The number that frames have been given in their order: of a file, else in the file.
  std::optional<double> number_of(const DicomFrame& frame) const {
    const DicomFile& file = files_[frame.file];
    if (file.num_frames > 1) return static_cast<double>(frame.frame);
    return file.instance_number;
  }

  // Numbers that run through all places of a volume before the next volume.
  Label number_in_volumes() const {
    const double first = least_number(), count = static_cast<double>(places_.size());
    return [this, first, count](const DicomFrame& f) -> std::optional<double> {
      const auto number = number_of(f);
      return number ? std::optional(std::floor((*number - first) / count)) : std::nullopt;
    };
  }
  // Numbers that run through all times of a place before the next place; no label if some place has
  // numbers of two such runs.
  Label number_in_places() const {
    const double first = least_number(), count = static_cast<double>(num_steps_);
    for (const DicomFrames& place : places_) {
      std::set<double> runs;
      for (const DicomFrame& frame : place)
        runs.insert(std::floor((number_of(frame).value_or(0) - first) / count));
      if (runs.size() != 1) return [](const DicomFrame&) { return std::optional<double>(); };
    }
    return [this, first, count](const DicomFrame& f) -> std::optional<double> {
      const auto number = number_of(f);
      return number ? std::optional(std::fmod(*number - first, count)) : std::nullopt;
    };
  }
  double least_number() const {
    double least = std::numeric_limits<double>::infinity();
    for (const DicomFrames& place : places_)
      for (const DicomFrame& frame : place) least = std::min(least, number_of(frame).value_or(0));
    return least;
  }

  // A step for each value; none if a place has a value twice, or there are more values than frames
  // at any place.
  std::optional<std::vector<DicomFrames>> by_value(const Label& label) const {
    std::map<double, DicomFrames> found;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      for (const DicomFrame& frame : places_[i]) {
        const auto value = label(frame);
        if (!value) return std::nullopt;
        DicomFrames& step = found.try_emplace(*value, DicomFrames(places_.size())).first->second;
        if (!step[i].is_missing() || found.size() > num_steps_) return std::nullopt;
        step[i] = frame;
      }
    }
    if (found.size() != num_steps_) return std::nullopt;
    std::vector<DicomFrames> steps;
    steps.reserve(found.size());
    for (auto& [value, step] : found) steps.push_back(std::move(step));
    return steps;
  }

  // Every place's frames by a value; none if a place has a value twice.
  std::optional<std::vector<DicomFrames>> sorted_by(const Label& label) const {
    std::vector<DicomFrames> sorted;
    for (const DicomFrames& place : places_) {
      std::map<double, DicomFrame> found;
      for (const DicomFrame& frame : place) {
        const auto value = label(frame);
        if (!value || !found.emplace(*value, frame).second) return std::nullopt;
      }
      sorted.emplace_back();
      for (const auto& [value, frame] : found) sorted.back().push_back(frame);
    }
    return sorted;
  }

  bool is_evenly_weighted(const std::vector<DicomFrames>& places) const {
    return std::all_of(places.begin(), places.end(), [&](const DicomFrames& place) {
      return std::equal(place.begin(), place.end(), places[0].begin(),
                        [&](const DicomFrame& a, const DicomFrame& b) {
                          return plane(a).b_value == plane(b).b_value;
                        });
    });
  }

  // By rank; by b-value first where that alone gives each step one diffusion weighting.
  std::vector<DicomFrames> with_even_weighting(const std::vector<DicomFrames>& places) const {
    if (is_evenly_weighted(places)) return rank_dicom_frames(places);
    std::vector<DicomFrames> sorted = places;
    for (DicomFrames& place : sorted) {
      std::stable_sort(place.begin(), place.end(), [&](const auto& a, const auto& b) {
        return plane(a).b_value < plane(b).b_value;
      });
    }
    return rank_dicom_frames(is_evenly_weighted(sorted) ? sorted : places);
  }

  const std::vector<DicomFile>& files_;
  const std::vector<DicomFrames>& places_;
  std::size_t num_steps_;
};

// --- kinds --------------------------------------------------------------------------------------

// What a kind is called and sorted by.
struct KindKey {
  double number = 0, amount = 0;
  std::string text;
  auto operator<=>(const KindKey&) const = default;
};

using KeyOf = std::function<KindKey(const DicomPlane&)>;
using KindText = std::function<std::string(const KindKey&, const std::vector<KindKey>& all)>;

KindKey echo_key(const DicomPlane& plane) {
  return {plane.echo_number.value_or(0), plane.echo_time.value_or(0), {}};
}
std::string echo_text(const KindKey& key, const std::vector<KindKey>& all) {
  const auto rank = std::find(all.begin(), all.end(), key) - all.begin() + 1;
  return fmt::format("echo {} ({:.6g} ms)", rank, key.amount);
}

KindKey image_type_key(const DicomPlane& plane) { return {0, 0, plane.image_type}; }

std::vector<std::string> words_of_type(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\\', begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

// The words that not all of the kinds have.
std::string image_type_text(const KindKey& key, const std::vector<KindKey>& all) {
  std::string text;
  for (const std::string& part : words_of_type(key.text)) {
    const bool is_common = std::all_of(all.begin(), all.end(), [&](const KindKey& other) {
      const auto parts = words_of_type(other.text);
      return std::find(parts.begin(), parts.end(), part) != parts.end();
    });
    if (!is_common) text += (text.empty() ? "" : " ") + part;
  }
  return text.empty() ? "others" : text;
}

class KindSplitter {
 public:
  explicit KindSplitter(const std::vector<DicomFile>& files) : files_(files) {}

  std::vector<DicomKind> split(const DicomKind& kind, const KeyOf& key_of,
                               const KindText& text_of) const {
    constexpr std::size_t kMostKinds = 64;  // more are a series of some parameter
    if (most_frames(kind.places) < 2) return {kind};
    std::map<KindKey, std::size_t> num_places;
    bool differ_at_a_place = false;
    for (const DicomFrames& place : kind.places) {
      std::set<KindKey> keys;
      for (const DicomFrame& frame : place) keys.insert(key(frame, key_of));
      for (const KindKey& own : keys) ++num_places[own];
      differ_at_a_place = differ_at_a_place || keys.size() > 1;
      if (num_places.size() > kMostKinds) return {kind};
    }
    const bool are_whole = std::all_of(num_places.begin(), num_places.end(), [&](const auto& one) {
      return 2 * one.second >= kind.places.size();
    });
    if (!differ_at_a_place || !are_whole) return {kind};
    std::vector<KindKey> all;
    all.reserve(num_places.size());
    for (const auto& [own, count] : num_places) all.push_back(own);
    std::vector<DicomKind> result;
    for (const KindKey& own : all) {
      const std::string what = text_of(own, all);
      result.push_back({{}, kind.what.empty() ? what : kind.what + ", " + what});
      for (const DicomFrames& place : kind.places) {
        DicomFrames kept;
        for (const DicomFrame& frame : place)
          if (key(frame, key_of) == own) kept.push_back(frame);
        if (!kept.empty()) result.back().places.push_back(std::move(kept));
      }
    }
    return result;
  }

 private:
  KindKey key(const DicomFrame& frame, const KeyOf& key_of) const {
    return key_of(files_[frame.file].planes[frame.frame]);
  }

  const std::vector<DicomFile>& files_;
};

// A place that all steps have; the first where there is none.
std::size_t common_place(const std::vector<DicomFrames>& steps) {
  for (std::size_t place = 0; place < steps[0].size(); ++place) {
    const bool is_common = std::none_of(steps.begin(), steps.end(),
                                        [&](const auto& step) { return step[place].is_missing(); });
    if (is_common) return place;
  }
  return 0;
}

// The values of the steps at one place, if each has one and they rise.
std::optional<std::vector<double>> rising_values(const std::vector<DicomFile>& files,
                                                 const std::vector<DicomFrames>& steps,
                                                 std::optional<double> DicomPlane::*member) {
  const std::size_t place = common_place(steps);
  std::vector<double> values;
  for (const DicomFrames& step : steps) {
    if (step[place].is_missing()) return std::nullopt;
    const auto value = files[step[place].file].planes[step[place].frame].*member;
    if (!value || (!values.empty() && !(*value > values.back()))) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

}  // namespace

std::vector<DicomKind> split_dicom_kinds(const std::vector<DicomFile>& files,
                                         std::vector<DicomFrames> places) {
  const KindSplitter splitter(files);
  std::vector<DicomKind> kinds;
  for (const DicomKind& echo : splitter.split({std::move(places), {}}, echo_key, echo_text)) {
    for (DicomKind& kind : splitter.split(echo, image_type_key, image_type_text))
      kinds.push_back(std::move(kind));
  }
  return kinds;
}

std::vector<DicomFrames> order_dicom_steps(const std::vector<DicomFile>& files,
                                           const std::vector<DicomFrames>& places) {
  return Orderer(files, places).run();
}

std::vector<DicomFrames> rank_dicom_frames(const std::vector<DicomFrames>& places) {
  std::vector<DicomFrames> steps(most_frames(places), DicomFrames(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t rank = 0; rank < places[i].size(); ++rank) steps[rank][i] = places[i][rank];
  return steps;
}

DicomTimes times_of_dicom_steps(const std::vector<DicomFile>& files,
                                const std::vector<DicomFrames>& steps) {
  if (steps.size() < 2) return {};
  if (auto times = rising_values(files, steps, &DicomPlane::trigger_time)) return {*times, "ms"};
  if (auto times = rising_values(files, steps, &DicomPlane::acquisition_time)) {
    const double first = times->front();
    for (double& time : *times) time = std::round((time - first) * 1e6) / 1e6;
    return {*times, "s"};
  }
  const DicomFrame& first = steps[0][common_place(steps)];
  if (first.is_missing()) return {};
  const DicomFile& file = files[first.file];
  auto interval = file.temporal_resolution;
  if (!interval && !file.is_3d_acquisition) interval = file.repetition_time;
  if (!interval || !(*interval > 0)) return {};
  DicomTimes times{{}, "ms"};
  for (std::size_t i = 0; i < steps.size(); ++i)
    times.values.push_back(*interval * static_cast<double>(i));
  return times;
}

std::string diffusion_text(const std::vector<DicomFile>& files,
                           const std::vector<DicomFrames>& steps) {
  constexpr std::size_t kMostNamed = 16;
  std::string text;
  std::set<double> all;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const DicomFrame& frame = steps[i][0];
    if (frame.is_missing()) return {};
    const auto b = files[frame.file].planes[frame.frame].b_value;
    if (!b) return {};
    all.insert(*b);
    if (i < kMostNamed) text += fmt::format("{}{:.6g}", i == 0 ? "" : ", ", *b);
    if (i == kMostNamed) text += ", ...";
  }
  return all.size() < 2 ? std::string() : text;
}

}  // namespace ovoid::io
