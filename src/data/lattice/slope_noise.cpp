// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/slope_noise.h"

#include <algorithm>

#include "data/field_samples.h"

namespace ovoid::data {
namespace {

constexpr std::size_t kParts = 10;
constexpr std::size_t kFewestThatRise = 512;  // to find anything in

// Waves of a few samples' length: wide slopes go against narrow ones, which takes order, too.
bool are_waves(std::span<const RiseSample> by_rise) {
  constexpr double kAgainst = -0.05;
  const std::size_t part = by_rise.size() / kParts;
  for (std::size_t i = 0; i < kParts; ++i) {
    if (mean_agreement(by_rise.subspan(i * part, part)) < kAgainst) return true;
  }
  return false;
}

}  // namespace

double mean_agreement(std::span<const RiseSample> samples) {
  double sum = 0;
  for (const RiseSample& sample : samples) sum += sample.agreement;
  return sum / static_cast<double>(samples.size());
}

std::vector<RiseSample> those_that_rise(std::span<const RiseSample> samples) {
  std::vector<RiseSample> rising;
  for (const RiseSample& sample : samples) {
    if (sample.gradient.squaredNorm() > 0) rising.push_back(sample);
  }
  std::sort(rising.begin(), rising.end(), [](const RiseSample& a, const RiseSample& b) {
    return a.gradient.squaredNorm() < b.gradient.squaredNorm();
  });
  return rising;
}

double slope_of_noise(std::span<const RiseSample> by_rise, std::size_t num_samples) {
  constexpr double kDisagree = 0.5;
  if (!can_tell_noise(by_rise)) return 0;
  std::vector<float> rises;
  for (const RiseSample& sample : by_rise) {
    if (sample.agreement < kDisagree) rises.push_back(sample.gradient.norm());
  }
  if (static_cast<double>(rises.size()) < 0.05 * static_cast<double>(num_samples)) return 0;
  return quantile(rises, 0.5);  // they come in order
}

bool can_tell_noise(std::span<const RiseSample> by_rise) {
  return by_rise.size() >= kFewestThatRise && !are_waves(by_rise);
}

bool has_noise(const BrickSource& source) {
  const std::vector<RiseSample> samples = take_rises(source);
  return slope_of_noise(those_that_rise(samples), samples.size()) > 0;
}

}  // namespace ovoid::data
