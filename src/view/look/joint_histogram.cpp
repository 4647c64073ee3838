// SPDX-License-Identifier: Apache-2.0
// The histogram has kBins bins of values, each with how many samples lie in it, and how much those
// rise on the mean that lie on something ordered. Materials are its peaks, boundaries the steepest
// bins between two peaks. docs/looks.md, "Materials and noise", says on which data thresholds were
// chosen, and on which they were judged.
#include "view/look/joint_histogram.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "data/lattice/slope_noise.h"
#include "view/look/field_samples.h"

namespace ovoid::view {
namespace {

using data::mean_agreement;
using data::RiseSample;

constexpr std::size_t kFewest = 512;  // samples, to find anything in

// --- order and noise

constexpr std::size_t kParts = 10;

// On a surface the narrow slope goes where the wide one does; noise, even if it is smoothed, has
// nothing to agree on. The steepest samples are surfaces if there are any.
double order_of(std::span<const RiseSample> by_rise) {
  const std::size_t part = by_rise.size() / kParts;
  return std::clamp(std::max(mean_agreement(by_rise.last(part)),
                             mean_agreement(by_rise.last(std::max<std::size_t>(64, part / 10)))),
                    0.0, 1.0);
}

// What has little order at its steepest places is noisy, from 0.7 on, which scans have, to 0.45,
// which speckle stays below; and where noise takes 8 to 15 % of all values in a step, as
// speckle in a frame of nothing does, whose edges have order.
double noisiness_of(double order, double noise, std::span<const RiseSample> samples) {
  std::vector<float> values;
  for (const RiseSample& sample : samples) values.push_back(sample.value);
  std::sort(values.begin(), values.end());
  const double range = quantile(values, 0.9995) - quantile(values, 0.0005);
  const double by_order = (0.7 - order) / 0.25;
  const double by_noise = range > 0 ? (noise / range - 0.08) / 0.07 : 0;
  return std::clamp(std::max(by_order, by_noise), 0.0, 1.0);
}

// --- materials

constexpr int kBins = 128;

struct Bins {
  double lo = 0, width = 1;
  std::array<double, kBins> counts{};
  std::array<double, kBins> rises{};  // mean, of samples on something ordered; 0: none

  double value(int bin) const { return lo + (bin + 0.5) * width; }
};

// A binomial filter, some times over.
void smooth(std::array<double, kBins>& x, int times) {
  for (; times > 0; --times) {
    const std::array<double, kBins> old = x;
    for (std::size_t i = 0; i < kBins; ++i)
      x[i] = 0.25 * old[i == 0 ? 0 : i - 1] + 0.5 * old[i] +
             0.25 * old[std::min<std::size_t>(i + 1, kBins - 1)];
  }
}

Bins bins_of(std::span<const RiseSample> samples, double lo, double hi, double noise) {
  Bins bins{.lo = lo, .width = (hi - lo) / kBins};
  std::array<double, kBins> ordered{};
  // What rises more lies between materials, and may share a value nevertheless: where a flat side
  // lies along the lattice, whole layers do.
  const double most_rise = 0.05 * (hi - lo) + noise;
  for (const RiseSample& sample : samples) {
    const double place = (static_cast<double>(sample.around) - lo) / bins.width;
    const auto bin = static_cast<std::size_t>(std::clamp(place, 0.0, kBins - 1.0));
    if (static_cast<double>(sample.gradient.norm()) < most_rise) bins.counts[bin] += 1;
    if (sample.agreement < 0.5F) continue;
    ordered[bin] += 1;
    bins.rises[bin] += static_cast<double>(sample.gradient.norm());
  }
  constexpr int kTimes = 3;  // a deviation of 1.2 bins: coarser than whole numbers in 8 bits
  smooth(bins.counts, kTimes);
  smooth(ordered, kTimes);
  smooth(bins.rises, kTimes);
  for (std::size_t i = 0; i < kBins; ++i) {
    bins.rises[i] = ordered[i] > 0 ? bins.rises[i] / ordered[i] : 0;
  }
  return bins;
}

// The bins of peaks, rising. Between two neighbours the histogram falls to less than kValley of the
// lower one; a peak has at least kLeastShare of the samples about it.
std::vector<int> peaks_of(const Bins& bins, double num_samples) {
  constexpr double kValley = 0.7;
  constexpr double kLeastShare = 0.004;
  constexpr int kReach = 3;
  std::vector<int> peaks;
  int lowest = 0;  // since the last peak
  for (int i = 0; i < kBins; ++i) {
    const auto at = [&](int bin) { return bins.counts[static_cast<std::size_t>(bin)]; };
    if (at(i) < at(lowest)) lowest = i;
    const bool is_top = (i == 0 || at(i) > at(i - 1)) && (i + 1 == kBins || at(i) >= at(i + 1));
    double about = 0;
    for (int k = std::max(0, i - kReach); k <= std::min(kBins - 1, i + kReach); ++k) about += at(k);
    if (!is_top || about < kLeastShare * num_samples) continue;
    const bool is_apart = peaks.empty() || at(lowest) < kValley * std::min(at(i), at(peaks.back()));
    if (is_apart) {
      peaks.push_back(i);
    } else if (at(i) > at(peaks.back())) {
      peaks.back() = i;
    }
    lowest = i;
  }
  return peaks;
}

// Where samples between two peaks rise most; halfway if none of them is on anything ordered.
double boundary_between(const Bins& bins, int lo, int hi) {
  int steepest = (lo + hi) / 2;
  const int margin = (hi - lo) / 4;  // near a peak its own noise is the steepest
  for (int i = lo + margin; i <= hi - margin; ++i) {
    if (bins.rises[static_cast<std::size_t>(i)] > bins.rises[static_cast<std::size_t>(steepest)])
      steepest = i;
  }
  return bins.value(steepest);
}

}  // namespace

Materials find_materials(std::span<const RiseSample> samples) {
  Materials found;
  if (samples.size() < kFewest) return found;
  const std::vector<RiseSample> rising = data::those_that_rise(samples);
  if (data::can_tell_noise(rising)) {
    found.noise = data::slope_of_noise(rising, samples.size());
    found.noisiness = noisiness_of(order_of(rising), found.noise, samples);
  }
  std::vector<float> values;
  for (const RiseSample& sample : samples) values.push_back(sample.around);
  std::sort(values.begin(), values.end());
  const double lo = quantile(values, 0.0005);
  const double hi = quantile(values, 0.9995);
  if (!(lo < hi)) return found;
  const Bins bins = bins_of(samples, lo, hi, found.noise);
  const std::vector<int> peaks = peaks_of(bins, static_cast<double>(samples.size()));
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    found.values.push_back(bins.value(peaks[i]));
    if (i > 0) found.boundaries.push_back(boundary_between(bins, peaks[i - 1], peaks[i]));
  }
  return found;
}

double one_sidedness(std::span<const RiseSample> samples) {
  Vec3 sum = Vec3::Zero();
  double lengths = 0;
  for (const RiseSample& sample : samples) {
    sum += sample.gradient.cast<double>();
    lengths += static_cast<double>(sample.gradient.norm());
  }
  return lengths > 0 ? sum.norm() / lengths : 0;
}

}  // namespace ovoid::view
