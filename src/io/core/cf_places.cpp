// SPDX-License-Identifier: Apache-2.0
#include "io/core/cf_places.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "io/core/axis_order.h"
#include "io/core/length_units.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostCoordinates = 1'000'000;  // along an axis, that are looked at

bool is_named_in(const std::vector<std::string>& words, const CfVariable& variable) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return word == variable.own_name() || word == variable.name || word == "/" + variable.name;
  });
}

// The axis that a variable says it is; none for one that measures something along it.
std::optional<char> letter_of(const CfVariable& coordinate) {
  if (const auto letter = cf_axis(cf_axis_of(coordinate.attributes))) return letter;
  return axis_called(coordinate.own_name());
}

// One that is not called like its dimension has to say more: a pressure along time is no height.
std::optional<char> sure_letter_of(const CfVariable& variable,
                                   const std::vector<std::string>& listed) {
  const auto letter = letter_of(variable);
  const bool is_sure =
      letter && (*letter != 'z' || is_named_in(listed, variable) ||
                 !variable.text("axis").empty() || axis_called(variable.own_name()).has_value());
  return is_sure ? letter : std::nullopt;
}

std::string_view group_of(const CfVariable& variable) {
  const std::string_view name = variable.name;
  return name.substr(0, name.size() - variable.own_name().size());
}

// Which of some coordinates lie along which dimensions, by how long they are.
class LengthMatch {
 public:
  LengthMatch(const CfDescription& file, const CfVariable& variable,
              const std::vector<const CfVariable*>& coordinates)
      : shape_(file.shape(variable)), now_(shape_.size()), best_(shape_.size()) {
    for (const CfVariable* const one : coordinates)
      candidates_.push_back({one, *letter_of(*one), file.shape(*one)[0]});
  }

  // Most of them, then those in the usual order, then those that the file has first.
  CfCoordinates run() {
    constexpr std::size_t kMost = 6;  // dimensions; the tries grow fast
    if (shape_.size() <= kMost && !candidates_.empty()) try_from(0);
    CfCoordinates found;
    for (const Candidate* const one : best_) found.push_back(one ? one->variable : nullptr);
    return found;
  }

 private:
  struct Candidate {
    const CfVariable* variable;
    char letter;
    std::int64_t size;
  };

  void try_from(std::size_t axis) {
    if (axis == shape_.size()) {
      const int score = score_of_now();
      if (score <= best_score_) return;
      best_score_ = score;
      best_ = now_;
      return;
    }
    std::string tried;  // a letter once: the first of those of one length
    for (const Candidate& one : candidates_) {
      const bool is_taken = std::any_of(
          now_.begin(), now_.begin() + static_cast<std::ptrdiff_t>(axis),
          [&](const Candidate* other) { return other != nullptr && other->letter == one.letter; });
      if (is_taken || one.size != shape_[axis] || tried.find(one.letter) != std::string::npos)
        continue;
      tried += one.letter;
      now_[axis] = &one;
      try_from(axis + 1);
    }
    now_[axis] = nullptr;
    try_from(axis + 1);
  }

  int score_of_now() const {
    int score = 0;
    std::size_t last = 0;
    for (const Candidate* const one : now_) {
      if (one == nullptr) continue;
      const std::size_t place = kAxisLetters.find(one->letter);
      constexpr int kMatched = 100;
      score += kMatched - (place < last ? 1 : 0);
      last = place;
    }
    return score;
  }

  std::vector<std::int64_t> shape_;
  std::vector<Candidate> candidates_;
  std::vector<const Candidate*> now_, best_;
  int best_score_ = 0;
};

// Finite, and rising or falling.
bool are_places(const std::vector<double>& places) {
  if (places.empty()) return false;
  const double sign = places.back() < places.front() ? -1 : 1;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!std::isfinite(places[i])) return false;
    if (i > 0 && !(sign * places[i] > sign * places[i - 1])) return false;
  }
  return true;
}

// Longitudes go on behind the meridian where they begin anew.
void unwind(std::vector<double>& longitudes) {
  for (std::size_t i = 1; i < longitudes.size(); ++i) {
    const double turns = std::round((longitudes[i - 1] - longitudes[i]) / 360);
    if (std::isfinite(turns)) longitudes[i] += 360 * turns;
  }
}

// Where it says samples lie; empty where it says nothing that can be.
std::vector<double> places_of(const CfFile& file, const CfVariable& coordinate) {
  std::vector<double> places = file.numbers(coordinate, kMostCoordinates);
  const double factor = cf_number(coordinate.attributes, "scale_factor").value_or(1);
  const double offset = cf_number(coordinate.attributes, "add_offset").value_or(0);
  for (double& place : places) place = place * factor + offset;
  if (!are_places(places) && coordinate.text("units").starts_with("degree") &&
      letter_of(coordinate) == 'x')
    unwind(places);
  if (!are_places(places)) places.clear();
  return places;
}

double mean_distance(const std::vector<double>& places) {
  return places.size() < 2
             ? 0
             : std::abs(places.back() - places.front()) / static_cast<double>(places.size() - 1);
}

// How many of x's unit one of z's is; none if the two cannot be told from each other.
std::optional<double> factor_of(const CfVariable* x, const CfVariable* z) {
  const auto unit_of = [](const CfVariable* coordinate) {
    return coordinate == nullptr ? std::string() : plain_unit(coordinate->text("units"));
  };
  const std::string ours = unit_of(x), theirs = unit_of(z);
  if (ours == theirs) return 1;
  const auto our_metres = metres_in(ours), their_metres = metres_in(theirs);
  if (!our_metres || !their_metres) return std::nullopt;
  return *their_metres / *our_metres;
}

std::vector<double> even_from_zero(std::int64_t count, double step) {
  std::vector<double> places;
  for (std::int64_t i = 0; i < count; ++i) places.push_back(0 + static_cast<double>(i) * step);
  return places;
}

// Why nothing says where samples of a map lie.
std::string why_no_places(const CfDescription& file, const CfVariable& variable) {
  for (const std::string& word : cf_words(variable.attributes, "coordinates")) {
    const CfVariable* const named = file.variable(word);
    if (named != nullptr && named->dims.size() == 2)
      return fmt::format(
          "'{}', which '{}' names as places along an axis, has two axes, as of a curved grid, and "
          "is "
          "not looked at: samples lie at equal distances",
          word, variable.name);
  }
  return fmt::format(
      "no variables called like the axes of '{}' say where samples lie along x and y: they lie at "
      "equal distances; --spacing says which",
      variable.name);
}

}  // namespace

std::vector<std::string> cf_words(const CfAttributes& attributes, std::string_view name) {
  const std::string text = cf_text(attributes, name);
  std::vector<std::string> found;
  for (const std::string_view word : words(text)) found.emplace_back(word);
  return found;
}

CfCoordinateFinder::CfCoordinateFinder(const CfDescription& file)
    : file_(file), along_(file.dimensions.size()) {
  constexpr std::size_t kMostOfGroup = 32;
  for (const CfVariable& variable : file.variables) {
    if (variable.dims.size() != 1) continue;
    along_[variable.dims[0]].push_back(&variable);
    if (!file.dimensions[variable.dims[0]].name.empty() || !variable.type || !letter_of(variable))
      continue;
    auto& of_group = called_like_axes_[std::string(group_of(variable))];
    if (of_group.size() < kMostOfGroup) of_group.push_back(&variable);
  }
}

CfCoordinates CfCoordinateFinder::of(const CfVariable& variable) const {
  const bool has_names =
      std::any_of(variable.dims.begin(), variable.dims.end(),
                  [&](std::size_t dimension) { return !file_.dimensions[dimension].name.empty(); });
  if (!has_names) {
    const auto found = called_like_axes_.find(group_of(variable));
    if (found == called_like_axes_.end()) return CfCoordinates(variable.dims.size());
    return LengthMatch(file_, variable, found->second).run();
  }
  const std::vector<std::string> listed = cf_words(variable.attributes, "coordinates");
  CfCoordinates coordinates;
  for (const std::size_t dimension : variable.dims) coordinates.push_back(along(dimension, listed));
  return coordinates;
}

const CfVariable* CfCoordinateFinder::along(std::size_t dimension,
                                            const std::vector<std::string>& listed) const {
  const CfVariable* other = nullptr;
  std::optional<char> other_letter;
  for (const CfVariable* const variable : along_[dimension]) {
    if (variable->own_name() == file_.dimensions[dimension].name) return variable;
    const auto letter = variable->type ? sure_letter_of(*variable, listed) : std::nullopt;
    if (!letter) continue;
    if (other == nullptr || (other_letter == letter && is_named_in(listed, *variable)))
      other = variable;
    // Two axes along one dimension are the places of single samples, as of stations or cells.
    other_letter = other_letter.value_or(*letter) == *letter ? *letter : kPassedAxis;
  }
  return other_letter == kPassedAxis ? nullptr : other;
}

std::string cf_told_axes(const CfDescription& file, const CfVariable& variable,
                         const CfCoordinates& coordinates) {
  std::string axes(variable.dims.size(), kPassedAxis);
  for (std::size_t a = 0; a < axes.size(); ++a) {
    auto letter = coordinates[a] == nullptr ? std::nullopt : letter_of(*coordinates[a]);
    if (!letter) letter = axis_called(file.dimensions[variable.dims[a]].name);
    if (letter && !axis_place(axes, *letter)) axes[a] = *letter;
  }
  return axes;
}

std::string cf_axes(const CfDescription& file, const CfVariable& variable,
                    const CfCoordinates& coordinates) {
  std::string axes = cf_told_axes(file, variable, coordinates);
  const auto dimension = [&](std::size_t a) -> const CfDimension& {
    return file.dimensions[variable.dims[a]];
  };
  // Files grow along time; one that grows along all axes says nothing.
  const bool has_records = !axes.empty() && dimension(0).is_unlimited && axes[0] == kPassedAxis &&
                           (axes.size() == 1 || !dimension(axes.size() - 1).is_unlimited);
  if (has_records && !axis_place(axes, 't')) axes[0] = 't';
  const bool are_components = !axes.empty() && dimension(axes.size() - 1).name.empty() &&
                              axes.back() == kPassedAxis && axis_place(axes, 'x') &&
                              axis_place(axes, 'y') &&
                              is_component_axis(dimension(axes.size() - 1).size);
  if (are_components && !axis_place(axes, 'c')) axes.back() = 'c';
  for (std::size_t a = axes.size(); a-- > 0;) {
    // A plane's x and y may have one sample; other dimensions of one sample say nothing.
    const bool is_single = dimension(a).size == 1;
    for (const char letter : {'x', 'y', 'z', 't', 'c'}) {
      if (axes[a] != kPassedAxis || axis_place(axes, letter)) continue;
      if (!is_single || letter == 'x' || letter == 'y') axes[a] = letter;
      if (is_single) break;
    }
  }
  return axes;
}

std::optional<CfPlaces> cf_places(const CfFile& file, const CfVariable& variable,
                                  const std::string& axes, const CfCoordinates& coordinates,
                                  std::vector<std::string>& notes) {
  CfPlaces places;
  std::array<const CfVariable*, 3> along{};
  Index3 sizes{1, 1, 1};
  constexpr std::string_view kLetters = "xyz";
  const std::vector<std::int64_t> shape = file.description().shape(variable);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto place = axis_place(axes, kLetters[i]);
    if (!place) continue;
    sizes[i] = shape[*place];
    along[i] = coordinates[*place];
    if (along[i] == nullptr) continue;
    places.along[i] = places_of(file, *along[i]);
    if (along[i]->type == ScalarType::kFloat64) places.is_float64 = true;
  }
  auto& [x, y, z] = places.along;
  if (x.empty() && y.empty()) {
    notes.push_back(
        fmt::format("{}: {}", file.name(), why_no_places(file.description(), variable)));
    return std::nullopt;
  }
  const double along_x = mean_distance(x), along_y = mean_distance(y);
  double step = along_x > 0 && along_y > 0 ? std::min(along_x, along_y) : along_x + along_y;
  if (!(step > 0)) step = 1;
  for (std::size_t i = 0; i < 2; ++i) {
    if (!places.along[i].empty()) continue;
    places.along[i] = even_from_zero(sizes[i], step);
    notes.push_back(fmt::format(
        "{}: nothing says where samples of '{}' lie along {}: they lie {:.6g} apart; --spacing "
        "A,B,C says another",
        file.name(), variable.name, kLetters[i], step));
  }
  const auto factor = factor_of(along[0] != nullptr ? along[0] : along[1], along[2]);
  const bool is_down = along[2] != nullptr && counts_down(cf_axis_of(along[2]->attributes));
  if (!z.empty() && factor) {
    for (double& place : z) place *= is_down ? -*factor : *factor;
  } else if (sizes[2] == 1) {
    z.assign(1, 0);
  } else {
    const bool is_falling = !z.empty() && (z.back() < z.front()) != is_down;
    z = even_from_zero(sizes[2], is_falling ? -step : step);
    const std::string unit = along[2] == nullptr ? "" : along[2]->text("units");
    notes.push_back(fmt::format(
        "{}: levels lie {:.6g} apart{}: {}; --spacing A,B,C says another", file.name(), step,
        is_falling ? ", downwards" : "",
        unit.empty() ? "nothing says where"
                     : fmt::format("'{}' is no unit beside '{}'", unit,
                                   along[0] == nullptr ? "" : along[0]->text("units"))));
  }
  for (const std::vector<double>& one : places.along)
    places.are_even = places.are_even && (one.size() < 2 || even_places(one));
  return places;
}

CfTimes cf_times(const CfFile& file, const std::string& axes, const CfCoordinates& coordinates) {
  const auto place = axis_place(axes, 't');
  if (!place || coordinates[*place] == nullptr) return {};
  const CfVariable& time = *coordinates[*place];
  return {file.numbers(time, kMostCoordinates), time.text("units")};
}

}  // namespace ovoid::io
