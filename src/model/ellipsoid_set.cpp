// SPDX-License-Identifier: Apache-2.0
#include "model/ellipsoid_set.h"

#include <algorithm>
#include <cmath>

#include "model/amplitudes.h"
#include "model/particle_lengths.h"

namespace ovoid::model {

namespace {

// Sites without a neighbourhood become balls as particles do.
void make_balls_of_lone(const ModelRun& run, EllipsoidSites& sites) {
  std::vector<float> lengths =
      nearest_statistics(run, sites.parts.centers, std::nullopt, WithCovariances::kNo).lengths;
  raise_zero_lengths(run, lengths);
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    SiteKernel& kernel = sites.kernels[i];
    if (!kernel.is_alone) continue;
    kernel.factor = Mat3::Identity() * static_cast<double>(lengths[i] / 2);
    kernel.weight = kLatticeWeight;
    kernel.is_degenerate = false;
  }
}

void report_sums(const ModelRun& run, const EllipsoidSites& sites, const std::vector<float>& sums) {
  double count = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sites.kernels[i].target < 0.99) continue;
    const auto sum = static_cast<double>(sums[i]);
    count += 1;
    mean += sum;
    square += sum * sum;
  }
  if (count == 0) return;
  mean /= count;
  run.report.constant_mean = mean;
  run.report.constant_deviation = std::sqrt(std::max(0.0, square / count - mean * mean));
}

}  // namespace

KernelParts fit_ellipsoids(const ModelRun& run, EllipsoidSites sites) {
  KernelParts& parts = sites.parts;
  const std::size_t count = parts.count();
  if (std::any_of(sites.kernels.begin(), sites.kernels.end(),
                  [](const SiteKernel& kernel) { return kernel.is_alone; }))
    make_balls_of_lone(run, sites);
  parts.shape = KernelShape::kEllipsoids;
  parts.cutoff = run.options.cutoff.value_or(kMeshCutoff);
  parts.reconstruction = run.options.reconstruction.value_or(Reconstruction::kNormalized);
  parts.shapes.reserve(6 * count);
  parts.weights.resize(count);
  std::vector<float> targets(count);
  // Kernels are of the uncut Gaussian's mass until here.
  const double kept = profile_integral(KernelProfile::kGaussian, parts.cutoff) /
                      profile_integral(KernelProfile::kGaussian, KernelColumns::kMaxCutoff);
  for (std::size_t i = 0; i < count; ++i) {
    const SiteKernel& kernel = sites.kernels[i];
    append_factor(kernel.factor, parts.shapes);
    parts.weights[i] = static_cast<float>(kernel.weight / kept);
    targets[i] = static_cast<float>(kernel.target);
    if (kernel.is_degenerate) ++run.report.num_degenerate;
  }
  const std::vector<float> sums =
      fit_amplitudes({parts.centers, parts.shapes, targets, parts.cutoff,
                      run.options.amplitude_passes, run.threads, run.stop},
                     parts.weights);
  report_sums(run, sites, sums);
  return std::move(parts);
}

}  // namespace ovoid::model
