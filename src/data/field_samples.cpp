// SPDX-License-Identifier: Apache-2.0
#include "data/field_samples.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "data/lattice/paged_lattice.h"
#include "data/lattice/sample_reader.h"
#include "data/lattice/sample_survey.h"
#include "data/lattice/shared_layers.h"
#include "data/out_of_memory.h"

namespace ovoid::data {
namespace {

constexpr std::size_t kFewestLabels = 3;

// The different values of all samples, rising; empty if one is no label.
std::vector<int> all_labels(const BrickSource& source) {
  const SharedLayers layers = shared_layers(source);
  const Index3& dims = source.geometry().dims;
  SampleReader reader(source);
  std::vector<bool> is_found(static_cast<std::size_t>(kGreatestLabel) + 1);
  constexpr int kNone = -1;  // of what is no label
  bool are_labels = true;
  visit_some({0, 0, layers.first}, {dims[0], dims[1], layers.end}, 1, [&](const Index3& index) {
    const float value = reader.at(index);
    if (std::isnan(value)) return;
    if (is_label(value)) {
      is_found[static_cast<std::size_t>(value)] = true;
    } else {
      are_labels = false;
    }
  });
  std::vector<int> labels;
  if (!are_labels) labels.push_back(kNone);
  for (int label = 0; are_labels && label <= kGreatestLabel; ++label) {
    if (is_found[static_cast<std::size_t>(label)]) labels.push_back(label);
  }
  labels = layers.of_all(std::move(labels));
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  if (!labels.empty() && labels.front() == kNone) labels.clear();
  return labels;
}

}  // namespace

FieldSamples take_samples(const BrickSource& source) try {
  if (const auto* const paged = dynamic_cast<const PagedLattice*>(&source))
    return paged->field_samples();
  SampleSurvey survey(source.geometry().dims);
  SampleReader reader(source);
  survey.take_samples(reader, 0, source.geometry().dims[2]);
  return survey.samples();
} catch (const std::bad_alloc&) {
  throw_out_of_memory("samples of the field", 2 * kWantedSamples * sizeof(float));
}

std::vector<int> labels_of(const BrickSource& source) {
  if (const auto* const paged = dynamic_cast<const PagedLattice*>(&source)) return paged->labels();
  const std::int64_t end = source.geometry().dims[2];
  SampleReader reader(source);
  SampleSurvey survey(source.geometry().dims);
  survey.find_integers(reader, 0, end);
  if (survey.few_integers().empty())
    survey.take_rows(reader, 0, end);
  else
    survey.take_samples(reader, 0, end);
  return labels_told_by(survey, source);
}

std::vector<int> labels_told_by(const SampleSurvey& survey, const BrickSource& source) {
  std::vector<int> labels = survey.few_integers();
  if (labels.empty()) return survey.has_sharp_regions() ? all_labels(source) : labels;
  return labels.size() >= kFewestLabels && survey.has_regions() ? labels : std::vector<int>{};
}

double quantile(std::span<const float> sorted, double q) {
  const double place = std::clamp(q, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(static_cast<double>(sorted[below]), static_cast<double>(sorted[above]),
                   place - static_cast<double>(below));
}

}  // namespace ovoid::data
