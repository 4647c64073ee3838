// SPDX-License-Identifier: Apache-2.0
#include "model/samples/sample_formulas.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/lattice/noise.h"
#include "model/samples/sample_flows.h"

namespace ovoid::model {

namespace {

using std::numbers::pi;

// [Marschner 1994]: nearly all its energy lies just below the band limit of 40 samples.
Formula make_marschner_lobb(std::uint64_t, double) {
  return [](const Vec3& p) {
    constexpr double kFrequency = 6;
    constexpr double kAmplitude = 0.25;
    const double radius = std::hypot(p.x(), p.y());
    const double ripple = std::cos(2 * pi * kFrequency * std::cos(pi * radius / 2));
    return (1 - std::sin(pi * p.z() / 2) + kAmplitude * (1 + ripple)) / (2 * (1 + kAmplitude));
  };
}

Formula make_constant(std::uint64_t, double) {
  return [](const Vec3&) { return 1.0; };
}

Formula make_box(std::uint64_t, double) {
  return [](const Vec3& p) { return p.cwiseAbs().maxCoeff() <= 0.5 ? 1.0 : 0.0; };
}

Formula make_ball(std::uint64_t, double) {
  return [](const Vec3& p) { return std::max(0.0, 1 - p.norm()); };
}

// |psi|^2 of hydrogen's 3d_z2 is proportional to (3 z^2 - r^2)^2 exp(-2 r / 3) in Bohr radii. On
// the z axis, (2 z^2)^2 exp(-2 z / 3), it is greatest at z = 6: 5184 exp(-4), to which it is
// scaled.
Formula make_orbital(std::uint64_t, double) {
  return [](const Vec3& p) {
    constexpr double kBohrRadii = 24;  // per unit: the outer 2e-3 of the peak stay inside the cube
    const double z = p.z() * kBohrRadii;
    const double r = p.norm() * kBohrRadii;
    const double angular = 3 * z * z - r * r;
    return angular * angular * std::exp(4 - 2 * r / 3) / 5184;
  };
}

Formula make_sphere_shell(std::uint64_t, double) {
  return [](const Vec3& p) {
    const double t = (p.norm() - 0.6) / 0.1;
    return std::exp(-0.5 * t * t);
  };
}

// 1 - exp(-sum) keeps any sum of blobs within [0, 1) without a maximum that would have to be
// searched for.
Formula make_gaussians(std::uint64_t seed, double) {
  struct Blob {
    Vec3 centre;
    double inverse_sigma;
    double height;
  };
  constexpr int kNumBlobs = 24;
  Random random(seed);
  std::vector<Blob> blobs(kNumBlobs);
  for (Blob& blob : blobs) {
    for (int a = 0; a < 3; ++a) blob.centre[a] = random.uniform(-0.65, 0.65);
    blob.inverse_sigma = 1 / random.uniform(0.06, 0.18);
    blob.height = random.uniform(0.3, 1.5);
  }
  return [blobs = std::move(blobs)](const Vec3& p) {
    double sum = 0;
    for (const Blob& blob : blobs) {
      const double t = (p - blob.centre).norm() * blob.inverse_sigma;
      sum += blob.height * std::exp(-0.5 * t * t);
    }
    return 1 - std::exp(-sum);
  };
}

// A zone plate: its wave number grows as 2 k r, to half a cycle per sample of the default size (pi
// / spacing) at r = 1.
constexpr std::int64_t kFrequencySize = 64;
Formula make_frequency(std::uint64_t, double) {
  return [](const Vec3& p) {
    constexpr double kRate = pi * (kFrequencySize - 1) / 4;
    return 0.5 + 0.5 * std::cos(kRate * p.squaredNorm());
  };
}

// Exactly linear; reaches 0 and 1 in two opposite corners.
Formula make_flat(std::uint64_t, double) {
  return [](const Vec3& p) { return 0.5 + (3 * p.x() + 2 * p.y() + p.z()) / 12; };
}

template <FormulaInTime (*kMake)(std::uint64_t)>
Formula at_time(std::uint64_t seed, double time) {
  return [formula = kMake(seed), time](const Vec3& p) { return formula(p, time); };
}

constexpr SampleKind kKinds[] = {
    {"marschner-lobb", "the Marschner-Lobb test signal, close to the band limit", 40, 0, 1, "",
     Space::kNone, &make_marschner_lobb},
    {"constant", "the value 1 everywhere", 32, 0, 1, "", Space::kNone, &make_constant},
    {"box", "a homogeneous box: 1 where |x|, |y|, |z| <= 0.5, else 0", 64, 0, 1, "", Space::kNone,
     &make_box},
    {"ball", "a ramp, 1 in the centre and 0 at radius 1: every isosurface is a sphere", 64, 0, 1,
     "", Space::kNone, &make_ball},
    {"orbital", "electron density of hydrogen's 3d_z2 orbital, its peak scaled to 1", 64, 0, 1, "",
     Space::kNone, &make_orbital},
    {"sphere-shell", "a spherical shell of radius 0.6 with Gaussian profile", 64, 0, 1, "",
     Space::kNone, &make_sphere_shell},
    {"gaussians", "1 - exp(-s), s the sum of 24 random Gaussians (seed)", 64, 0, 1, "",
     Space::kNone, &make_gaussians},
    {"head", "a synthetic CT of a head in Hounsfield units (seed: texture)", 128, -1000, 1500, "HU",
     Space::kLps, &make_head},
    {"head-labels", "the parts of that head as labels, 0 to 8 (seed: folds of the brain)", 128, 0,
     255, "", Space::kLps, &make_head_labels},
    {"cells", "two stains of a cluster of cells, nuclei and membranes (seed), two channels", 96, 0,
     1, "", Space::kNone, &make_nuclei, false, &make_membranes},
    {"frequency", "a zone plate, 0.5 + 0.5 cos(k r^2): the default size's band limit at radius 1",
     kFrequencySize, 0, 1, "", Space::kNone, &make_frequency},
    {"flat", "a linear ramp in an oblique direction", 64, 0, 1, "", Space::kNone, &make_flat},
    {"tornado", "the speed of air around a funnel that wanders; moves", 128, 0, 1, "", Space::kNone,
     &at_time<make_tornado>, true},
    {"jet", "what a nozzle throws upwards, in billows, among nothing; moves", 128, 0, 1, "",
     Space::kNone, &at_time<make_jet>, true},
};

}  // namespace

std::span<const SampleKind> sample_kinds() noexcept { return kKinds; }

}  // namespace ovoid::model
