// SPDX-License-Identifier: Apache-2.0
// Sample data that moves: formulas of place and time, smooth in both, so that they can be sampled
// on any lattice in four dimensions.
#include "model/samples/sample_flows.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/lattice/noise.h"

namespace ovoid::model {
namespace {

using std::numbers::pi;

// A smooth step from 0 to 1, about `width` to either side.
double smooth_step(double x, double width) { return 0.5 * (1 + std::tanh(2 * x / width)); }

}  // namespace

// The speed of the air around a funnel: the core wanders on a circle that widens upwards and turns
// once; around it the speed rises to the core's edge and falls off as 1 / r [Lamb 1932], and
// three spiral bands turn with it.
FormulaInTime make_tornado(std::uint64_t seed) {
  Random random(seed);
  const double phase = random.uniform(0, 2 * pi);
  return [phase](const Vec3& p, double time) {
    const double height = 0.5 * (p.z() + 1);
    const double lean = 0.08 + 0.22 * height * height;
    const double turn = 2 * pi * (time - 0.6 * height) + phase;
    const double x = p.x() - lean * std::cos(turn);
    const double y = p.y() - lean * std::sin(turn);
    const double r = std::hypot(x, y);
    const double core = 0.06 + 0.16 * height * height;
    const double q = r / core;
    // (1 - exp(-q^2)) / q is 0.638 at its greatest.
    const double swirl = q < 1e-6 ? 0.0 : (1 - std::exp(-q * q)) / q / 0.6382;
    const double bands =
        1 + 0.18 * std::exp(-0.25 * q) * (1 - std::exp(-q * q)) *
                std::cos(3 * std::atan2(y, x) + 5 * q - 2 * pi * 2 * time + 4 * pi * height);
    const double ground = 1 - std::exp(-8 * height - 0.4);
    const double rim = smooth_step(0.98 - std::hypot(p.x(), p.y()), 0.15);
    return std::clamp(swirl * bands * ground * rim / 1.18, 0.0, 1.0);
  };
}

// What a nozzle below throws upwards: a plume that widens; rings roll up on its surface and break
// into lobes on their way. Outside of it, most of the volume, there is nothing.
FormulaInTime make_jet(std::uint64_t seed) {
  struct Billow {
    double wave_number, lobes, amplitude, speed, phase;
  };
  Random random(seed);
  std::vector<Billow> billows;
  for (int i = 0; i < 7; ++i) {
    const double order = i + 1;
    billows.push_back({pi * (1.5 + 0.8 * order), static_cast<double>(i % 4), 0.30 / order,
                       random.uniform(0.8, 1.2), random.uniform(0, 2 * pi)});
  }
  return [billows](const Vec3& p, double time) {
    const double height = 0.5 * (p.z() + 1);
    const double angle = std::atan2(p.y(), p.x());
    const double r = std::hypot(p.x(), p.y());
    const double radius = 0.07 + 0.20 * height;
    const double growth = height * height * (3 - 2 * height);
    // Near the axis there are no lobes: they would meet in a point.
    const double away = 1 - std::exp(-8 * r * r / (radius * radius));
    double ripple = 0;
    for (const Billow& b : billows) {
      const double along = b.wave_number * (2 * height - b.speed * time) + b.phase;
      const double around = b.lobes == 0 ? 1.0 : away * std::cos(b.lobes * angle + 1.7 * b.phase);
      ripple += b.amplitude * growth * std::cos(along) * around;
    }
    const double edge = radius * (1 + ripple);
    const double inside = smooth_step(edge - r, 0.35 * radius);
    const double mixed = 0.75 + 0.25 * std::cos(9 * height - 6 * time + 2 * ripple);
    return std::clamp(inside * mixed * (1 - 0.45 * growth), 0.0, 1.0);
  };
}

}  // namespace ovoid::model
