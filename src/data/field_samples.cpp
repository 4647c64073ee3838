// SPDX-License-Identifier: Apache-2.0
#include "data/field_samples.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <new>

#include "data/out_of_memory.h"
#include "data/sample_reader.h"

namespace ovoid::data {
namespace {

constexpr std::size_t kFewLabels = 64;
constexpr int kGreatestLabel = (1 << 24) - 1;  // float tells all whole numbers up to here apart
// Neighbours that are equal: regions of labels have it, quantized fields do not.
constexpr double kEqualsOfLabels = 0.8;
constexpr double kJumpsOfLabels = 0.05;
constexpr std::size_t kFewestLabels = 3;
// In fewer samples nobody sees regions.
constexpr std::size_t kFewestForLabels = 512;

std::int64_t one_in(std::int64_t count) {
  return std::max<std::int64_t>(1, (count + kWantedSamples - 1) / kWantedSamples);
}

void take_face_samples(SampleReader& reader, const Index3& dims, std::vector<float>& values) {
  const std::int64_t area = 2 * (dims[0] * dims[1] + dims[1] * dims[2] + dims[2] * dims[0]);
  const std::int64_t every = one_in(area);
  for (std::size_t a = 0; a < 3; ++a) {
    for (const std::int64_t place : {std::int64_t{0}, dims[a] - 1}) {
      Index3 lo{0, 0, 0};
      Index3 hi = dims;
      lo[a] = place;
      hi[a] = place + 1;
      visit_some(lo, hi, every, [&](const Index3& index) {
        const float value = reader.at(index);
        if (!std::isnan(value)) values.push_back(value);
      });
      if (dims[a] == 1) break;
    }
  }
}

}  // namespace

FieldSamples take_samples(const BrickSource& source) try {
  const LatticeGeometry& geometry = source.geometry();
  SampleReader reader(source);
  FieldSamples samples;
  std::int64_t num_pairs = 0;
  std::int64_t num_equal = 0;
  std::int64_t num_jumps = 0;
  visit_some({0, 0, 0}, geometry.dims, one_in(num_samples(geometry.dims)),
             [&](const Index3& index) {
               const float value = reader.at(index);
               if (std::isnan(value)) return;
               samples.values.push_back(value);
               const float next = reader.at({index[0] + 1, index[1], index[2]});
               if (std::isnan(next)) return;
               ++num_pairs;
               if (next == value) ++num_equal;
               if (std::abs(next - value) > 1.5F) ++num_jumps;
             });
  take_face_samples(reader, geometry.dims, samples.on_faces);
  samples.is_counted = reader.is_counted();
  for (std::vector<float>* list : {&samples.values, &samples.on_faces})
    std::sort(list->begin(), list->end());
  samples.share_of_equals =
      num_pairs > 0 ? static_cast<double>(num_equal) / static_cast<double>(num_pairs) : 0.0;
  samples.share_of_jumps = num_pairs > num_equal ? static_cast<double>(num_jumps) /
                                                       static_cast<double>(num_pairs - num_equal)
                                                 : 0.0;
  return samples;
} catch (const std::bad_alloc&) {
  throw_out_of_memory("samples of the field", 2 * kWantedSamples * sizeof(float));
}

std::vector<int> few_integers(const BrickSource& source, std::size_t most) {
  constexpr int kGreatest = 65535;
  const Index3& dims = source.geometry().dims;
  SampleReader reader(source);
  std::vector<int> found;
  std::bitset<kGreatest + 1> is_found;
  Index3 index{};
  for (index[2] = 0; index[2] < dims[2]; ++index[2]) {
    for (index[1] = 0; index[1] < dims[1]; ++index[1]) {
      for (index[0] = 0; index[0] < dims[0]; ++index[0]) {
        const float value = reader.at(index);
        if (std::isnan(value)) continue;
        if (!(value >= 0 && value <= kGreatest) || value != std::floor(value)) return {};
        const auto number = static_cast<std::size_t>(value);
        if (is_found[number]) continue;
        if (found.size() == most) return {};
        is_found[number] = true;
        found.push_back(static_cast<int>(number));
      }
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

namespace {

bool is_label(float value) {
  return value >= 0 && value <= kGreatestLabel && value == std::floor(value);
}

// Four samples in a row, of which the middle two are a pair.
using Row = std::array<float, 4>;

// Rows from all over the lattice, those left out whose pair is not there; none if a sample is no
// label.
std::vector<Row> rows_of_labels(const BrickSource& source) {
  constexpr std::int64_t kWantedRows = 1 << 16;
  const Index3& dims = source.geometry().dims;
  SampleReader reader(source);
  std::vector<Row> rows;
  bool are_labels = true;
  const std::int64_t every = std::max<std::int64_t>(1, num_samples(dims) / kWantedRows);
  visit_some({0, 0, 0}, dims, every, [&](const Index3& index) {
    if (!are_labels) return;
    Row row;
    for (std::size_t i = 0; i < row.size(); ++i) {
      row[i] = reader.at({index[0] + static_cast<std::int64_t>(i) - 1, index[1], index[2]});
      if (!std::isnan(row[i]) && !is_label(row[i])) are_labels = false;
    }
    if (!std::isnan(row[1]) && !std::isnan(row[2])) rows.push_back(row);
  });
  return are_labels ? rows : std::vector<Row>{};
}

// The value that most rows' pairs begin with.
float most_common(const std::vector<Row>& rows) {
  std::vector<float> values(rows.size());
  std::transform(rows.begin(), rows.end(), values.begin(), [](const Row& row) { return row[1]; });
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

// Whether values are flat within regions and change between them from one sample to the next. A
// scan in whole numbers is not flat within things, and takes several samples from one to the other.
// A smooth field of many samples is flat wherever rounding leaves it a step of one; where it
// changes by more it changes on both sides. What lies within the background tells nothing.
bool has_sharp_regions(const BrickSource& source) {
  constexpr double kFlat = 0.4;   // of pairs: regions three samples wide have it
  constexpr double kSharp = 0.7;  // of steps: flat on one side at least
  const std::vector<Row> rows = rows_of_labels(source);
  if (rows.empty()) return false;
  const float background = most_common(rows);
  std::size_t num_pairs = 0;
  std::size_t num_steps = 0;
  std::size_t num_sharp = 0;
  std::size_t num_jumps = 0;
  std::size_t num_sharp_jumps = 0;
  for (const Row& row : rows) {
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

// The different values of all samples, rising; empty if one is no label.
std::vector<int> all_labels(const BrickSource& source) {
  SampleReader reader(source);
  std::vector<bool> is_found(static_cast<std::size_t>(kGreatestLabel) + 1);
  bool are_labels = true;
  visit_some({0, 0, 0}, source.geometry().dims, 1, [&](const Index3& index) {
    const float value = reader.at(index);
    if (std::isnan(value)) return;
    if (is_label(value)) {
      is_found[static_cast<std::size_t>(value)] = true;
    } else {
      are_labels = false;
    }
  });
  std::vector<int> labels;
  for (int label = 0; are_labels && label <= kGreatestLabel; ++label) {
    if (is_found[static_cast<std::size_t>(label)]) labels.push_back(label);
  }
  return labels;
}

}  // namespace

std::vector<int> labels_of(const BrickSource& source) {
  std::vector<int> labels = few_integers(source, kFewLabels);
  if (labels.empty()) return has_sharp_regions(source) ? all_labels(source) : labels;
  if (labels.size() < kFewestLabels) return {};
  const FieldSamples samples = take_samples(source);
  const bool has_regions =
      samples.values.size() >= kFewestForLabels && samples.share_of_equals >= kEqualsOfLabels;
  return has_regions && samples.share_of_jumps >= kJumpsOfLabels ? labels : std::vector<int>{};
}

double quantile(std::span<const float> sorted, double q) {
  const double place = std::clamp(q, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(static_cast<double>(sorted[below]), static_cast<double>(sorted[above]),
                   place - static_cast<double>(below));
}

}  // namespace ovoid::data
