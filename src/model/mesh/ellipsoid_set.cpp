// SPDX-License-Identifier: Apache-2.0
#include "model/mesh/ellipsoid_set.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "model/mesh/amplitudes.h"
#include "model/particles/particle_lengths.h"
#include "model/team/kernel_halo.h"
#include "model/team/team_run.h"
#include "model/team/team_sites.h"

namespace ovoid::model {

namespace {

// Sites without a neighbourhood become balls as particles do.
void make_balls_of_lone(const ModelRun& run, EllipsoidSites& sites) {
  const std::span<const double> centers = sites.parts.centers;
  std::vector<float> lengths =
      run.team == nullptr
          ? nearest_statistics(run, centers, std::nullopt, WithCovariances::kNo).lengths
          : team_lengths(run, centers,
                         total_of(run, static_cast<std::int64_t>(sites.parts.count())),
                         std::nullopt);
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
  double count = 0, total = 0, square = 0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sites.kernels[i].target < 0.99) continue;
    const auto sum = static_cast<double>(sums[i]);
    count += 1;
    total += sum;
    square += sum * sum;
  }
  count = total_of(run, count);
  total = total_of(run, total);
  square = total_of(run, square);
  if (count == 0) return;
  const double mean = total / count;
  run.report.constant_mean = mean;
  run.report.constant_deviation = std::sqrt(std::max(0.0, square / count - mean * mean));
}

}  // namespace

KernelParts fit_ellipsoids(const ModelRun& run, EllipsoidSites sites) {
  KernelParts& parts = sites.parts;
  const std::size_t count = parts.count();
  const auto num_alone = std::count_if(sites.kernels.begin(), sites.kernels.end(),
                                       [](const SiteKernel& kernel) { return kernel.is_alone; });
  if (total_of(run, std::int64_t{num_alone}) > 0) make_balls_of_lone(run, sites);
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
  std::optional<KernelHalo> halo;
  if (run.team != nullptr) halo.emplace(run, parts);
  AmplitudeProblem problem{
      parts.centers, parts.shapes, targets, parts.cutoff, run.options.amplitude_passes,
      run.threads,   run.stop};
  if (halo) {
    problem.num_others = parts.count() - count;
    problem.renew = [&](std::vector<float>& weights) { halo->renew(weights); };
  }
  const std::vector<float> sums = fit_amplitudes(problem, parts.weights);
  if (halo) halo->remove_from(parts);
  report_sums(run, sites, sums);
  return std::move(parts);
}

}  // namespace ovoid::model
