// SPDX-License-Identifier: Apache-2.0
#include "fit/fit_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/fit_goal.h"

namespace ovoid::fit {
namespace {

// Kernels are looked for around a hole up to so many times their cutoff.
constexpr double kBeyondCutoff = 3.5;
// Holes are closed by widening kernels by this factor, so many times at most.
constexpr float kWidening = 1.1F;
constexpr int kMostWidenings = 30;
// The search for the greatest error keeps so many places, looks beside each of them so many times,
// within so many sigmas of its kernel.
constexpr std::size_t kWorstPlaces = 2048;
constexpr int kLooksBeside = 4;
constexpr double kSigmasBeside[] = {0.6, 0.3, 0.1};
// Wrongly full places are looked for on a lattice of so many nodes a side.
constexpr int kSide = 32;

std::vector<double> places_at(const Places& places, std::span<const std::uint32_t> which) {
  std::vector<double> at;
  at.reserve(3 * which.size());
  for (const std::uint32_t k : which)
    at.insert(at.end(), places.at.data() + std::size_t{3} * k,
              places.at.data() + std::size_t{3} * k + 3);
  return at;
}

}  // namespace

FitJudge::FitJudge(const KernelField& field, const SourceKernels& source, double range, int threads,
                   const std::stop_token& stop)
    : field_(field), source_(source), range_(range), threads_(threads), stop_(stop) {
  double whole = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < source.count(); ++i) {
    whole += source.volumes[i];
    mean += source.volumes[i] * static_cast<double>(source.values[0][i]);
  }
  mean /= whole;
  for (std::size_t i = 0; i < source.count(); ++i) {
    const double apart = static_cast<double>(source.values[0][i]) - mean;
    square += source.volumes[i] * apart * apart;
  }
  deviation_ = std::sqrt(square / whole);
}

std::vector<std::uint32_t> FitJudge::holes(const Places& places, const KernelOperator& rows,
                                           float margin) const {
  std::vector<std::uint32_t> empty;
  if (is_sum()) return empty;
  for (std::uint32_t k = 0; k < rows.num_places(); ++k) {
    if (rows.weights()[k] < margin * KernelField::kLeastWeight) empty.push_back(k);
  }
  const std::vector<KernelSample> samples = sampled(field_, places_at(places, empty));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < empty.size(); ++i) {
    if (samples[i].is_defined) empty[kept++] = empty[i];
  }
  empty.resize(kept);
  return empty;
}

std::vector<std::uint32_t> FitJudge::owners_of_holes(const Places& places,
                                                     std::span<const std::uint32_t> holes,
                                                     const MergedKernels& kernels) const {
  const double reach = std::min(kBeyondCutoff * source_.cutoff, KernelColumns::kMaxCutoff);
  const std::vector<double> at = places_at(places, holes);
  const KernelOperator near(kernels.columns(reach), Reconstruction::kSum, at, threads_, stop_);
  std::vector<std::uint32_t> owners(holes.size(), kNoSite);
  for (std::size_t r = 0; r < near.num_places(); ++r) {
    const KernelOperator::Row row = near.row(r);
    const auto most = std::ranges::max_element(row.entries);
    if (most != row.entries.end())
      owners[row.place] = row.kernels[static_cast<std::size_t>(most - row.entries.begin())];
  }
  return owners;
}

bool FitJudge::close_holes(const Places& places, MergedKernels& kernels, float margin) const {
  Places open;  // the places that were holes the last time
  open.at = places.at;
  for (int pass = 0;; ++pass) {
    const KernelOperator rows(kernels.columns(source_.cutoff), source_.reconstruction, open.at,
                              threads_, stop_);
    const std::vector<std::uint32_t> found = holes(open, rows, margin);
    if (found.empty() || pass == kMostWidenings) return pass > 0;
    std::vector<std::uint32_t> owners = owners_of_holes(open, found, kernels);
    std::ranges::sort(owners);
    owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
    for (const std::size_t owner : owners) {
      if (owner == kNoSite) continue;
      kernels.weights[owner] *= kWidening;
      for (std::size_t n = 0; n < 6; ++n) kernels.shapes[6 * owner + n] *= kWidening;
    }
    open.at = places_at(open, found);
  }
}

std::vector<double> FitJudge::errors(const Places& places, const JudgedKernels& fitted) const {
  const KernelOperator rows(fitted.kernels.columns(source_.cutoff), source_.reconstruction,
                            places.at, threads_, stop_);
  std::vector<double> errors = rows.gather(fitted.values);
  for (std::size_t k = 0; k < errors.size(); ++k) {
    errors[k] = is_sum() || rows.is_defined(k) ? std::abs(errors[k] - places.targets[0][k])
                                               : std::numeric_limits<double>::quiet_NaN();
  }
  for (const std::uint32_t hole : holes(places, rows))
    errors[hole] = std::numeric_limits<double>::infinity();
  return errors;
}

FitJudge::Errors FitJudge::sum_up(const Places& places, const JudgedKernels& fitted) const {
  const std::vector<double> of_places = errors(places, fitted);
  Errors errors;
  double share = 0;
  for (std::size_t k = 0; k < of_places.size(); ++k) {
    if (std::isnan(of_places[k])) continue;
    const bool is_hole = std::isinf(of_places[k]);
    const double error = is_hole ? deviation_ : of_places[k];
    errors.mean_square += places.shares[k] * error * error;
    if (!is_hole) errors.greatest = std::max(errors.greatest, error);
    share += places.shares[k];
  }
  // Nothing to judge by is no success.
  errors.mean_square =
      share > 0 ? errors.mean_square / share : std::numeric_limits<double>::infinity();
  return errors;
}

FitJudge::Worst FitJudge::worst_of(const Places& places, const std::vector<double>& errors) const {
  std::vector<std::uint32_t> order;
  for (std::uint32_t k = 0; k < errors.size(); ++k) {
    if (!std::isnan(errors[k])) order.push_back(k);
  }
  const std::size_t count = std::min(order.size(), kWorstPlaces);
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                    [&](std::uint32_t a, std::uint32_t b) {
                      return errors[a] != errors[b] ? errors[a] > errors[b] : a < b;
                    });
  Worst worst;
  worst.places.targets.resize(places.targets.size());
  for (std::size_t i = 0; i < count; ++i) {
    worst.places.append(places, order[i], places.shares[order[i]]);
    worst.errors.push_back(errors[order[i]]);
  }
  return worst;
}

FitJudge::Worst FitJudge::look_for_worst(const PlaceMaker& maker,
                                         std::span<const Places* const> places,
                                         const JudgedKernels& fitted, std::uint64_t seed) const {
  Worst worst;
  worst.places.targets.resize(source_.values.size());
  double greatest = 0;
  const auto add = [&](const Places& more) {
    const std::vector<double> of_more = errors(more, fitted);
    for (const double error : of_more) {
      if (std::isfinite(error)) greatest = std::max(greatest, error);
    }
    Worst both = worst_of(more, of_more);
    for (std::size_t i = 0; i < worst.errors.size(); ++i) {
      both.places.append(worst.places, i, worst.places.shares[i]);
      both.errors.push_back(worst.errors[i]);
    }
    worst = worst_of(both.places, both.errors);
  };
  for (const Places* const some : places) add(*some);
  for (const double sigmas : kSigmasBeside) {
    for (int n = 0; n < kLooksBeside; ++n) add(maker.make_beside(worst.places, sigmas, ++seed));
  }
  worst.greatest_but_for_holes = greatest;
  return worst;
}

void FitJudge::report(const KernelField& fitted, const Places& places, FitReport& report) const {
  const std::vector<KernelSample> ours = sampled(fitted, places.at);
  const std::vector<KernelSample> theirs = sampled(field_, places.at);
  double square = 0, whole = 0, square_nonempty = 0, nonempty = 0, square_source = 0;
  const double empty = static_cast<double>(field_.value_range().lo) + 1e-3 * range_;
  for (std::size_t k = 0; k < places.count(); ++k) {
    if (!is_sum() && !theirs[k].is_defined) continue;
    const double share = places.shares[k];
    const double target = places.targets[0][k];
    const bool is_hole = !is_sum() && !ours[k].is_defined;
    const double error = is_hole ? deviation_ : std::abs(ours[k].value - target);
    const double of_source = theirs[k].value - target;
    if (!is_hole) report.greatest_error = std::max(report.greatest_error, error);
    report.wrongly_empty += is_hole ? share : 0;
    square += share * error * error;
    square_source += share * of_source * of_source;
    whole += share;
    if (target <= empty) continue;
    square_nonempty += share * error * error;
    nonempty += share;
  }
  const auto mean = [](double sum, double of) { return of > 0 ? sum / of : 0; };
  report.wrongly_empty = mean(report.wrongly_empty, whole);
  report.psnr = psnr_of(range_, mean(square, whole));
  report.psnr_of_nonempty = psnr_of(range_, mean(square_nonempty, nonempty));
  report.source_psnr = psnr_of(range_, mean(square_source, whole));
  report_full(fitted, report);
}

// At the nodes of a lattice over the bounding box.
void FitJudge::report_full(const KernelField& fitted, FitReport& report) const {
  if (is_sum()) return;
  const Bounds3 bounds = field_.world_bounds();
  std::vector<double> at;
  for (int k = 0; k < kSide; ++k) {
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        const Vec3 share = (Vec3(i, j, k) + Vec3::Constant(0.5)) / kSide;
        const Vec3 place = bounds.min() + share.cwiseProduct(bounds.sizes());
        at.insert(at.end(), {place[0], place[1], place[2]});
      }
    }
  }
  const std::vector<KernelSample> ours = sampled(fitted, at), theirs = sampled(field_, at);
  double full = 0;
  for (std::size_t i = 0; i < ours.size(); ++i)
    full += ours[i].is_defined && !theirs[i].is_defined ? 1 : 0;
  report.wrongly_full = full / static_cast<double>(ours.size());
}

}  // namespace ovoid::fit
