// SPDX-License-Identifier: Apache-2.0
#include "experiments/kernel_choice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace ovoid::experiments {

namespace {

using reference::FieldSample;
using std::numbers::pi;

using MakePoints = std::function<PointField(const Dataset&, GradientMethod)>;

// Places are kept this far from the faces, where a field has fewer samples to go by.
constexpr double kMargin = 4;

struct Truth {
  double value;
  Vec3 gradient;
};

// [Marschner 1994] and its derivative, on the cube [-1, 1]^3.
Truth marschner_lobb(const Vec3& p) {
  constexpr double kFrequency = 6;
  constexpr double kAmplitude = 0.25;
  constexpr double kScale = 1 / (2 * (1 + kAmplitude));
  const double radius = std::max(std::hypot(p.x(), p.y()), 1e-12);
  const double phase = 2 * pi * kFrequency * std::cos(pi * radius / 2);
  const double along_radius =
      kAmplitude * std::sin(phase) * pi * pi * kFrequency * std::sin(pi * radius / 2);
  return {kScale * (1 - std::sin(pi * p.z() / 2) + kAmplitude * (1 + std::cos(phase))),
          kScale * Vec3(along_radius * p.x() / radius, along_radius * p.y() / radius,
                        -pi / 2 * std::cos(pi * p.z() / 2))};
}

double angle_deg(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / pi;
}

class Places {
 public:
  explicit Places(const Index3& dims) : dims_(dims) {}

  Vec3 next() {
    Vec3 place;
    for (int a = 0; a < 3; ++a) {
      std::uniform_real_distribution<double> along(kMargin,
                                                   static_cast<double>(dims_[a] - 1) - kMargin);
      place[a] = along(random_);
    }
    return place;
  }

 private:
  Index3 dims_;
  std::mt19937_64 random_{1};
};

void measure_marschner_lobb(const MakePoints& make, int num_points, KernelErrors& errors) {
  const Dataset dataset = make_sample("marschner-lobb", {{40, 40, 40}});
  const PointField field = make(dataset, GradientMethod::kExact);
  const PointField corrected = make(dataset, GradientMethod::kCorrected);
  const double spacing = dataset.lattice.spacing()[0];
  Places places(dataset.lattice.dims);
  double squares = 0;
  for (int n = 0; n < num_points; ++n) {
    const Vec3 place = places.next();
    const Truth truth = marschner_lobb(dataset.lattice.world_from_index * place);
    const FieldSample sample = field(place);
    const double error = std::abs(sample.value - truth.value);
    squares += error * error;
    errors.greatest = std::max(errors.greatest, error);
    Vec3 central;
    for (int a = 0; a < 3; ++a) {
      const Vec3 step = Vec3::Unit(a);
      central[a] = (field(place + step).value - field(place - step).value) / 2;
    }
    errors.exact_deg += angle_deg(sample.gradient, truth.gradient * spacing) / num_points;
    errors.corrected_deg +=
        angle_deg(corrected(place).gradient, truth.gradient * spacing) / num_points;
    errors.central_deg += angle_deg(central, truth.gradient * spacing) / num_points;
  }
  errors.rms = std::sqrt(squares / num_points);
}

// The share of the wave in the field, by projection on it over whole periods.
double transfer(const MakePoints& make, double cycles_per_sample) {
  constexpr std::int64_t kPeriodsEnd = 28;  // whole periods of both waves lie between 12 and this
  constexpr std::int64_t kPeriodsBegin = 12;
  constexpr int kStepsPerSample = 64;
  const auto wave = [&](double x) { return std::cos(2 * pi * cycles_per_sample * x); };
  const PointField field =
      make(dataset_of({41, 13, 13}, [&](std::int64_t i, std::int64_t,
                                        std::int64_t) { return wave(static_cast<double>(i)); }),
           GradientMethod::kExact);
  double product = 0;
  double norm = 0;
  for (int n = 0; n < (kPeriodsEnd - kPeriodsBegin) * kStepsPerSample; ++n) {
    const double x = static_cast<double>(kPeriodsBegin) + (n + 0.5) / kStepsPerSample;
    product += field({x, 6.3, 6.7}).value * wave(x);
    norm += wave(x) * wave(x);
  }
  return product / norm;
}

void measure_constant(const MakePoints& make, int num_points, KernelErrors& errors) {
  const Index3 dims{16, 16, 16};
  const PointField field =
      make(dataset_of(dims, [](std::int64_t, std::int64_t, std::int64_t) { return 1.0; }),
           GradientMethod::kExact);
  Places places(dims);
  // Where the ripple of a sum of Gaussians is greatest and least.
  double least = field({8, 8, 8}).value;
  double greatest = least;
  double sum = 0;
  for (int n = 0; n < num_points; ++n) {
    const double value = field(n == 0 ? Vec3(7.5, 7.5, 7.5) : places.next()).value;
    least = std::min(least, value);
    greatest = std::max(greatest, value);
    sum += value;
  }
  errors.ripple = (greatest - least) / (sum / num_points);
}

void measure_ramp(const MakePoints& make, int num_points, KernelErrors& errors) {
  const Index3 dims{16, 16, 16};
  const Vec3 slope(3, 2, 1);
  const Dataset dataset = dataset_of(dims, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return slope.dot(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k))) /
           90;
  });
  const PointField exact = make(dataset, GradientMethod::kExact);
  const PointField corrected = make(dataset, GradientMethod::kCorrected);
  Places places(dims);
  for (int n = 0; n < num_points; ++n) {
    const Vec3 place = places.next();
    errors.ramp_deg = std::max(errors.ramp_deg, angle_deg(exact(place).gradient, slope));
    errors.corrected_ramp_deg =
        std::max(errors.corrected_ramp_deg, angle_deg(corrected(place).gradient, slope));
  }
}

void measure_step(const MakePoints& make, KernelErrors& errors) {
  const PointField field = make(
      dataset_of({24, 13, 13},
                 [](std::int64_t i, std::int64_t, std::int64_t) { return i < 12 ? 0.0 : 1.0; }),
      GradientMethod::kExact);
  for (double x = 4; x <= 19; x += 1.0 / 64) {
    const double value = field({x, 6, 6}).value;
    errors.overshoot = std::max({errors.overshoot, value - 1, -value});
  }
}

KernelErrors measure(const MakePoints& make, int num_points) {
  KernelErrors errors;
  measure_marschner_lobb(make, num_points, errors);
  errors.quarter = transfer(make, 0.25);
  errors.half = transfer(make, 0.5);
  measure_constant(make, num_points, errors);
  measure_ramp(make, num_points, errors);
  measure_step(make, errors);
  return errors;
}

}  // namespace

KernelErrors measure_trilinear(int num_points) {
  return measure([](const Dataset& dataset, GradientMethod) { return trilinear_points(dataset); },
                 num_points);
}

KernelErrors measure_kernel(const KernelChoice& choice, int num_points) {
  return measure([&](const Dataset& dataset,
                     GradientMethod gradient) { return kernel_points(dataset, choice, gradient); },
                 num_points);
}

}  // namespace ovoid::experiments
