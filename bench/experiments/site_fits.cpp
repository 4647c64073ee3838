// SPDX-License-Identifier: Apache-2.0
#include "experiments/site_fits.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "experiments/natural_neighbors.h"
#include "model/lattice/noise.h"
#include "ovoid/fit.h"

namespace ovoid::experiments {

namespace {

constexpr double kJitter = 0.4;
constexpr int kErrorPlaces = 20000;
// Ridges that leave values to the sites, and iterations that change nothing any more.
constexpr double kNoRidge = 1e-6;
constexpr int kAllSteps = 60;
// dB from the last error.
constexpr double kThere = 0.1;

Vec3 place_of(const std::vector<double>& at, std::size_t i) {
  return {at[3 * i], at[3 * i + 1], at[3 * i + 2]};
}

std::vector<double> values_at(const TestField& field, const std::vector<double>& at) {
  std::vector<double> values;
  for (std::size_t i = 0; 3 * i < at.size(); ++i) values.push_back(field.value(place_of(at, i)));
  return values;
}

double range_of(const std::vector<double>& values) {
  const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
  return *hi - *lo;
}

double rms(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

// Least squares at the sites, from `values` on.
ValueSolution fit_at_sites(const KernelOperator& kernels, const std::vector<double>& targets,
                           int steps, std::vector<double>& values) {
  const std::vector<double> shares(targets.size(), 1 / static_cast<double>(targets.size()));
  ValueProblem problem;
  problem.targets = targets;
  problem.shares = shares;
  problem.ridge = kNoRidge;
  problem.iterations = steps;
  problem.tolerance = 0;
  return fit_values(kernels, problem, values);
}

Sites centers_near(const Sites& sites, int side, Centers centers) {
  Sites moved;
  model::Random random(8);
  if (centers == Centers::kMoved) {
    moved.at = sites.at;
    for (double& x : moved.at) x += random.uniform(-0.5, 0.5);
    return moved;
  }
  const auto count = static_cast<std::size_t>(side);
  for (std::size_t k = 0; k + 1 < count; k += 2) {
    for (std::size_t j = 0; j + 1 < count; j += 2) {
      for (std::size_t i = 0; i + 1 < count; i += 2) {
        Vec3 sum = Vec3::Zero();
        for (std::size_t corner = 0; corner < 8; ++corner) {
          const std::size_t x = i + corner % 2, y = j + corner / 2 % 2, z = k + corner / 4;
          sum += place_of(sites.at, x + count * (y + count * z));
        }
        for (const double x : Vec3(sum / 8)) moved.at.push_back(x);
      }
    }
  }
  return moved;
}

std::vector<double> first_values(const Sites& sites, const std::vector<double>& values,
                                 const std::vector<double>& at, FirstValues first) {
  if (first == FirstValues::kSibson) return natural_neighbor_values(sites.at, values, at);
  if (first == FirstValues::kMean) {
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    return std::vector<double>(at.size() / 3, sum / static_cast<double>(values.size()));
  }
  const SiteKernels kernels = kernels_of_sites(sites, SiteShape::kScaledPca);
  return KernelOperator(kernels.columns(), Reconstruction::kNormalized, at).gather(values);
}

}  // namespace

TestField franke_field(int side) {
  const auto value = [side](const Vec3& at) {
    const Vec3 p = 9 * at / (side - 1);
    const auto bump = [&](double x, double y, double z) {
      return std::exp(-(p - Vec3(x, y, z)).squaredNorm() / 4);
    };
    return 0.75 * bump(2, 2, 2) +
           0.75 * std::exp(-(p[0] + 1) * (p[0] + 1) / 49 - (p[1] + 1) / 10 - (p[2] + 1) / 10) +
           0.5 * bump(7, 3, 5) - 0.2 * bump(4, 7, 5);
  };
  return {"Franke", side, value};
}

TestField marschner_lobb_field(int side) {
  const auto value = [side](const Vec3& at) {
    const Vec3 p = 2 * at / (side - 1) - Vec3::Ones();
    constexpr double kAlpha = 0.25, kFrequency = 6;
    const double ring = std::cos(2 * std::numbers::pi * kFrequency *
                                 std::cos(std::numbers::pi / 2 * std::hypot(p[0], p[1])));
    return (1 - std::sin(std::numbers::pi / 2 * p[2]) + kAlpha * (1 + ring)) / (2 * (1 + kAlpha));
  };
  return {"Marschner-Lobb", side, value};
}

SiteErrors measure_site_errors(const TestField& field, SiteShape shape) {
  const Sites sites = jittered_sites(field.side, kJitter, 1);
  const SiteKernels kernels = kernels_of_sites(sites, shape);
  const std::vector<double> values = values_at(field, sites.at);
  std::vector<double> places;
  model::Random random(4);
  for (int i = 0; i < kErrorPlaces; ++i) {
    Vec3 u;
    for (double& x : u) x = random.uniform(0, 1);
    for (const double x : sites.inside(u)) places.push_back(x);
  }
  const std::vector<double> truth = values_at(field, places);
  const double range = range_of(truth);
  SiteErrors errors;
  for (const Reconstruction how : {Reconstruction::kSum, Reconstruction::kNormalized}) {
    const KernelOperator at_places(kernels.columns(), how, places);
    const KernelOperator at_sites(kernels.columns(), how, sites.at);
    std::vector<double> fitted = values;
    fit_at_sites(at_sites, values, kAllSteps, fitted);
    const bool is_sum = how == Reconstruction::kSum;
    (is_sum ? errors.raw : errors.normalized) = rms(at_places.gather(values), truth) / range;
    (is_sum ? errors.fitted_sum : errors.fitted) = rms(at_places.gather(fitted), truth) / range;
  }
  return errors;
}

const char* name_of(Centers centers) { return centers == Centers::kMoved ? "moved" : "merged"; }

const char* name_of(FirstValues first) {
  switch (first) {
    case FirstValues::kMean:
      return "mean";
    case FirstValues::kNormalized:
      return "Shepard";
    case FirstValues::kSibson:
      return "Sibson";
  }
  return "";
}

Convergence measure_convergence(const TestField& field, Centers centers, FirstValues first,
                                int steps) {
  const Sites sites = jittered_sites(field.side, kJitter, 1);
  const std::vector<double> values = values_at(field, sites.at);
  const double range = range_of(values);
  const SiteKernels kernels =
      kernels_of_sites(centers_near(sites, field.side, centers), SiteShape::kScaledPca);
  const KernelOperator at_sites(kernels.columns(), Reconstruction::kNormalized, sites.at);
  const std::vector<double> start = first_values(sites, values, kernels.centers, first);
  const auto error_after = [&](int count) {
    std::vector<double> fitted = start;
    fit_at_sites(at_sites, values, count, fitted);
    return rms(at_sites.gather(fitted), values) / range;
  };
  Convergence convergence;
  for (int count = 0; count <= steps; ++count) convergence.errors.push_back(error_after(count));
  const double enough = error_after(kAllSteps) * std::pow(10, kThere / 20);
  while (convergence.steps < steps &&
         convergence.errors[static_cast<std::size_t>(convergence.steps)] > enough)
    ++convergence.steps;
  return convergence;
}

}  // namespace ovoid::experiments
