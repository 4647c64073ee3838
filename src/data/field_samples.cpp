// SPDX-License-Identifier: Apache-2.0
#include "data/field_samples.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <new>

#include "data/out_of_memory.h"
#include "data/sample_reader.h"

namespace ovoid::data {
namespace {

constexpr std::size_t kMostLabels = 64;
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

std::vector<int> labels_of(const BrickSource& source) {
  std::vector<int> labels = few_integers(source, kMostLabels);
  if (labels.size() < kFewestLabels) return {};
  const FieldSamples samples = take_samples(source);
  const bool has_regions =
      samples.values.size() >= kFewestForLabels && samples.share_of_equals >= kEqualsOfLabels;
  return has_regions && samples.share_of_jumps >= kJumpsOfLabels ? labels : std::vector<int>{};
}

}  // namespace ovoid::data
