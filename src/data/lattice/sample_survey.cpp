// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/sample_survey.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "data/kernels/letters.h"

namespace ovoid::data {
namespace {

// In fewer samples nobody sees regions.
constexpr std::size_t kFewestForLabels = 512;
constexpr double kJumpsOfLabels = 0.05;
constexpr std::size_t kMostFewIntegers = 64;
constexpr std::int64_t kWantedRows = 1 << 16;

std::int64_t one_in(std::int64_t count) {
  return std::max<std::int64_t>(1, (count + kWantedSamples - 1) / kWantedSamples);
}

// The value that most rows' pairs begin with.
float most_common(std::vector<float> values) {
  std::sort(values.begin(), values.end());
  float best = values.front();
  std::ptrdiff_t most = 0;
  for (auto i = values.begin(); i != values.end();) {
    const auto end = std::upper_bound(i, values.end(), *i);
    if (end - i > most) {
      most = end - i;
      best = *i;
    }
    i = end;
  }
  return best;
}

double share_of(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

bool FewIntegers::add(float value) {
  fit_ = fit_ && value >= 0 && value < static_cast<float>(is_found_.size()) &&
         value == std::floor(value);
  if (!fit_) return false;
  const auto number = static_cast<std::size_t>(value);
  if (is_found_[number]) return true;
  fit_ = count_ < most_;
  if (!fit_) return false;
  is_found_[number] = true;
  ++count_;
  return true;
}

std::vector<int> FewIntegers::found() const {
  std::vector<int> numbers;
  for (std::size_t number = 0; fit_ && number < is_found_.size(); ++number)
    if (is_found_[number]) numbers.push_back(static_cast<int>(number));
  return numbers;
}

SampleSurvey::SampleSurvey(const Index3& dims) : dims_(dims), integers_(kMostFewIntegers) {}

void SampleSurvey::take_samples(SampleReader& reader, std::int64_t first, std::int64_t end) {
  visit_some({0, 0, first}, {dims_[0], dims_[1], end}, one_in(num_samples(dims_)),
             [&](const Index3& index) {
               const float value = reader.at(index);
               if (std::isnan(value)) return;
               values_.push_back(value);
               const float next = reader.at({index[0] + 1, index[1], index[2]});
               if (std::isnan(next)) return;
               ++counts_.num_pairs;
               if (next == value) ++counts_.num_equal;
               if (std::abs(next - value) > 1.5F) ++counts_.num_jumps;
             });
  counts_.is_counted = counts_.is_counted || reader.is_counted();
  const std::int64_t every =
      one_in(2 * (dims_[0] * dims_[1] + dims_[1] * dims_[2] + dims_[2] * dims_[0]));
  for (std::size_t a = 0; a < 3; ++a) {
    for (const std::int64_t place : {std::int64_t{0}, dims_[a] - 1}) {
      Index3 lo{0, 0, first};
      Index3 hi{dims_[0], dims_[1], end};
      lo[a] = std::max(lo[a], place);
      hi[a] = std::min(hi[a], place + 1);
      visit_some(lo, hi, every, [&](const Index3& index) {
        const float value = reader.at(index);
        if (!std::isnan(value)) on_faces_.push_back(value);
      });
      if (dims_[a] == 1) break;
    }
  }
}

// Rows from all over the lattice, those left out whose pair is not there; none once a sample is no
// label.
void SampleSurvey::take_rows(SampleReader& reader, std::int64_t first, std::int64_t end) {
  const std::int64_t every = std::max<std::int64_t>(1, num_samples(dims_) / kWantedRows);
  visit_some({0, 0, first}, {dims_[0], dims_[1], end}, every, [&](const Index3& index) {
    if (!counts_.are_labels) return;
    Row row;
    for (std::size_t i = 0; i < row.size(); ++i) {
      row[i] = reader.at({index[0] + static_cast<std::int64_t>(i) - 1, index[1], index[2]});
      if (!std::isnan(row[i]) && !is_label(row[i])) counts_.are_labels = false;
    }
    if (!std::isnan(row[1]) && !std::isnan(row[2])) rows_.push_back(row);
  });
}

void SampleSurvey::find_integers(SampleReader& reader, std::int64_t first, std::int64_t end) {
  Index3 index{};
  for (index[2] = first; index[2] < end; ++index[2]) {
    for (index[1] = 0; index[1] < dims_[1]; ++index[1]) {
      for (index[0] = 0; index[0] < dims_[0]; ++index[0]) {
        const float value = reader.at(index);
        if (!std::isnan(value) && !integers_.add(value)) return;
      }
    }
  }
}

void SampleSurvey::join(KernelTeam& team) {
  counts_.are_few = integers_.fit();
  const std::vector<int> integers = integers_.found();
  values_ = joined(team, std::span<const float>(values_));
  on_faces_ = joined(team, std::span<const float>(on_faces_));
  rows_ = joined(team, std::span<const Row>(rows_));
  for (const int number : joined(team, std::span<const int>(integers)))
    integers_.add(static_cast<float>(number));
  Counts all;
  for (const Counts& own : joined(team, std::span<const Counts>(&counts_, 1))) {
    all.num_pairs += own.num_pairs;
    all.num_equal += own.num_equal;
    all.num_jumps += own.num_jumps;
    all.is_counted = all.is_counted || own.is_counted;
    all.are_labels = all.are_labels && own.are_labels;
    all.are_few = all.are_few && own.are_few;
  }
  counts_ = all;
  if (!all.are_few) integers_.add(-1);  // which does not fit
}

FieldSamples SampleSurvey::samples() const {
  FieldSamples samples;
  samples.values = values_;
  samples.on_faces = on_faces_;
  samples.is_counted = counts_.is_counted;
  for (std::vector<float>* list : {&samples.values, &samples.on_faces})
    std::sort(list->begin(), list->end());
  samples.share_of_equals = share_of_equals();
  samples.share_of_jumps = share_of_jumps();
  return samples;
}

double SampleSurvey::share_of_equals() const {
  return share_of(counts_.num_equal, counts_.num_pairs);
}

double SampleSurvey::share_of_jumps() const {
  return share_of(counts_.num_jumps, counts_.num_pairs - counts_.num_equal);
}

bool SampleSurvey::has_regions() const {
  constexpr double kEqualsOfLabels = 0.8;  // quantized fields have fewer
  return values_.size() >= kFewestForLabels && share_of_equals() >= kEqualsOfLabels &&
         share_of_jumps() >= kJumpsOfLabels;
}

// Whether values are flat within regions and change between them from one sample to the next. A
// scan in whole numbers is not flat within things, and takes several samples from one to the other.
// A smooth field of many samples is flat wherever rounding leaves it a step of one; where it
// changes by more it changes on both sides. What lies within the background tells nothing.
bool SampleSurvey::has_sharp_regions() const {
  constexpr double kFlat = 0.4;   // of pairs: regions three samples wide have it
  constexpr double kSharp = 0.7;  // of steps: flat on one side at least
  if (rows_.empty() || !counts_.are_labels) return false;
  std::vector<float> firsts(rows_.size());
  std::transform(rows_.begin(), rows_.end(), firsts.begin(), [](const Row& row) { return row[1]; });
  const float background = most_common(std::move(firsts));
  std::size_t num_pairs = 0;
  std::size_t num_steps = 0;
  std::size_t num_sharp = 0;
  std::size_t num_jumps = 0;
  std::size_t num_sharp_jumps = 0;
  for (const Row& row : rows_) {
    if (row[1] == background && row[2] == background) continue;
    ++num_pairs;
    if (row[1] == row[2]) continue;
    ++num_steps;
    const bool is_sharp = row[0] == row[1] || row[2] == row[3];
    const bool is_jump = std::abs(row[2] - row[1]) > 1.5F;
    num_sharp += is_sharp ? 1 : 0;
    num_jumps += is_jump ? 1 : 0;
    num_sharp_jumps += is_sharp && is_jump ? 1 : 0;
  }
  const auto exceeds = [](std::size_t count, double share, std::size_t of) {
    return static_cast<double>(count) >= share * static_cast<double>(of);
  };
  return num_pairs >= kFewestForLabels && num_steps > 0 &&
         exceeds(num_pairs - num_steps, kFlat, num_pairs) &&
         exceeds(num_sharp, kSharp, num_steps) && exceeds(num_jumps, kJumpsOfLabels, num_steps) &&
         exceeds(num_sharp_jumps, kSharp, num_jumps);
}

}  // namespace ovoid::data
