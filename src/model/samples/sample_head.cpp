// SPDX-License-Identifier: Apache-2.0
//
// A head made of ellipsoids and tubes. Each part is a signed distance (negative inside), the parts
// are laid over one another in order, and each covers what lies below by the share of a soft edge:
// the partial volume of a scanner's voxel.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "model/lattice/noise.h"
#include "model/samples/sample_formulas.h"

namespace ovoid::model {

namespace {

using std::numbers::pi;

// Hounsfield units.
constexpr double kAir = -1000;
constexpr double kSkin = 60;
constexpr double kFat = -90;
constexpr double kMuscle = 50;
constexpr double kBone = 1000;
constexpr double kMarrow = 350;
constexpr double kTeeth = 1450;
constexpr double kBrain = 38;
constexpr double kFluid = 8;
constexpr double kEye = 20;

// Width of an edge, and of the head's own: 2.5 and 4 voxels of the default size, 2 / 127. A scanner
// blurs more than its voxels are wide; what it did not blur would be sampled to terraces.
constexpr double kEdge = 0.04;
constexpr double kOuterEdge = 0.064;

// The brain case's inside.
const Vec3 kCavityCentre{0, 0.05, 0.25};
const Vec3 kCavityRadii{0.445, 0.575, 0.535};

// First-order distance to an ellipsoid: f / |grad f| with f = |p / r| - 1. Exact on the surface and
// for spheres.
double ellipsoid(const Vec3& p, const Vec3& centre, const Vec3& radii) {
  const Vec3 d = p - centre;
  const double scaled = d.cwiseQuotient(radii).norm();
  const double slope = d.cwiseQuotient(radii.cwiseProduct(radii)).norm();
  return slope > 0 ? scaled * (scaled - 1) / slope : -radii.minCoeff();
}

double sphere(const Vec3& p, const Vec3& centre, double radius) {
  return (p - centre).norm() - radius;
}

// The points within `radius` of the line from a to b.
double tube(const Vec3& p, const Vec3& a, const Vec3& b, double radius) {
  const Vec3 axis = b - a;
  const double t = std::clamp(axis.dot(p - a) / axis.squaredNorm(), 0.0, 1.0);
  return (p - a - t * axis).norm() - radius;
}

// Union whose crease is rounded over a width k.
double blend_union(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k / 4;
}

double carve(double solid, double hole) { return std::max(solid, -hole); }

double cover(double below, double value, double distance, double edge = kEdge) {
  const double t = std::clamp(0.5 - distance / edge, 0.0, 1.0);
  return std::lerp(below, value, t * t * (3 - 2 * t));
}

// Left and right are alike: parts are placed on the left, x >= 0.
Vec3 mirrored(const Vec3& p) { return {std::abs(p.x()), p.y(), p.z()}; }

double skin(const Vec3& p) {
  const Vec3 m = mirrored(p);
  double d = ellipsoid(p, {0, 0.05, 0.24}, {0.56, 0.69, 0.65});
  if (d < -0.15) return d;  // as deep as this no other part matters
  d = blend_union(d, ellipsoid(p, {0, -0.20, -0.22}, {0.40, 0.44, 0.52}), 0.15);
  d = blend_union(d, tube(p, {0, 0.16, -0.2}, {0, 0.22, -2}, 0.34), 0.15);
  d = blend_union(d, tube(m, {0.10, -0.46, -0.55}, {0.31, -0.10, -0.46}, 0.10), 0.14);  // jaw
  d = blend_union(d, tube(m, {0.31, -0.10, -0.46}, {0.38, 0.02, -0.05}, 0.11), 0.14);
  d = blend_union(d, tube(m, {0.30, -0.40, -0.08}, {0.42, -0.10, -0.04}, 0.10), 0.10);  // cheek
  d = blend_union(d, tube(m, {0.28, -0.42, 0.15}, {0.31, -0.34, 0.10}, 0.10), 0.10);    // temple
  d = blend_union(d, tube(p, {0, -0.63, 0.04}, {0, -0.74, -0.16}, 0.055), 0.08);        // nose
  d = blend_union(d, sphere(m, {0.06, -0.68, -0.18}, 0.05), 0.05);                      // nostrils
  d = blend_union(d, ellipsoid(p, {0, -0.64, -0.36}, {0.14, 0.05, 0.035}), 0.04);       // lips
  d = blend_union(d, ellipsoid(p, {0, -0.64, -0.42}, {0.12, 0.05, 0.035}), 0.02);
  d = blend_union(d, sphere(p, {0, -0.56, -0.60}, 0.09), 0.12);                        // chin
  d = blend_union(d, tube(m, {0.10, -0.62, 0.13}, {0.28, -0.54, 0.12}, 0.045), 0.08);  // brow
  d = blend_union(d, sphere(m, {0.20, -0.525, 0.03}, 0.10), 0.03);                     // lids
  const double ear = carve(ellipsoid(m, {0.58, 0.10, -0.02}, {0.05, 0.13, 0.19}),
                           ellipsoid(m, {0.63, 0.08, 0.0}, {0.045, 0.08, 0.12}));
  return blend_union(d, ear, 0.04);
}

// Outer face of the brain case and the bones of the face; holes for eyes, nose and cheeks are
// carved out.
double skull(const Vec3& p) {
  const Vec3 m = mirrored(p);
  const double outside = ellipsoid(p, {0, 0.05, 0.25}, {0.50, 0.63, 0.59});
  const double inside = ellipsoid(p, kCavityCentre, kCavityRadii);
  double face = ellipsoid(p, {0, -0.32, -0.14}, {0.30, 0.27, 0.30});
  face = blend_union(face, tube(m, {0.12, -0.55, 0.15}, {0.33, -0.42, 0.12}, 0.05), 0.06);  // brow
  face =
      blend_union(face, tube(m, {0.26, -0.47, -0.10}, {0.47, -0.05, -0.06}, 0.04), 0.05);  // zygoma
  face = blend_union(face, tube(m, {0.33, -0.42, 0.12}, {0.31, -0.45, -0.08}, 0.04), 0.05);
  double d = carve(blend_union(outside, face, 0.08), inside);
  d = carve(d, ellipsoid(m, {0.19, -0.53, 0.02}, {0.13, 0.14, 0.115}));  // orbits
  d = carve(d, ellipsoid(p, {0, -0.55, -0.14}, {0.075, 0.25, 0.12}));    // nose
  d = carve(d, ellipsoid(m, {0.17, -0.36, -0.17}, {0.08, 0.12, 0.09}));  // sinuses
  return carve(d, tube(p, {0, 0.18, -0.2}, {0, 0.2, -0.6}, 0.08));       // to the spine
}

double jaw(const Vec3& p) {
  const Vec3 m = mirrored(p);
  double d = tube(m, {0, -0.545, -0.58}, {0.16, -0.47, -0.57}, 0.055);
  d = blend_union(d, tube(m, {0.16, -0.47, -0.57}, {0.34, -0.10, -0.50}, 0.055), 0.05);
  d = blend_union(d, tube(m, {0.34, -0.10, -0.50}, {0.41, 0.02, -0.10}, 0.05), 0.05);
  return d;
}

// Two rows along an ellipse around the mouth, cut into teeth by their angle.
double teeth(const Vec3& p) {
  constexpr double kHalfTeeth = 14;  // per half turn
  const double x = p.x() / 0.22;
  const double y = (p.y() + 0.20) / 0.34;
  const double rows = std::abs(p.z() + 0.435) - 0.095;
  const double gap = 0.008 - std::abs(p.z() + 0.44);
  const double ring = std::abs(std::hypot(x, y) - 1) * 0.25 - 0.03;
  const double between = 0.012 * (1 - std::abs(std::sin(kHalfTeeth * std::atan2(x, -y)))) - 0.004;
  return std::max({rows, gap, ring + between, p.y() + 0.22});
}

// Vertebrae and, between them, discs: returns the distance to the column and sets the share of
// bone.
double spine(const Vec3& p, double& bone) {
  constexpr double kPeriod = 0.17;
  bone = std::clamp(0.5 + 4 * (std::cos(2 * pi * p.z() / kPeriod) + 0.6), 0.0, 1.0);
  const double body = tube(p, {0, 0.20, -0.42}, {0, 0.24, -2}, 0.11 + 0.015 * bone);
  const double arch = tube(p, {0, 0.34, -0.45}, {0, 0.38, -2}, 0.055 * bone);
  const double canal = tube(p, {0, 0.325, -0.3}, {0, 0.365, -2}, 0.035);
  return carve(std::min(body, arch), canal);
}

double airways(const Vec3& p) {
  double d = tube(p, {0, -0.62, -0.17}, {0, -0.16, -0.36}, 0.05);
  d = blend_union(d, tube(p, {0, -0.14, -0.36}, {0, -0.06, -0.50}, 0.055), 0.06);
  return blend_union(d, tube(p, {0, -0.06, -0.50}, {0, -0.04, -2}, 0.065), 0.06);
}

constexpr double kSulcusDepth = 0.2;

// Folded grey matter around white matter and ventricles.
double brain_value(const Vec3& p, std::uint64_t seed) {
  const double depth = -ellipsoid(p, kCavityCentre, kCavityRadii);
  // Sulci are the zero crossings of the noise near the surface, filled with fluid, and so is the
  // gap between the halves.
  double sulcus = 0;
  if (depth < kSulcusDepth) {
    const double folds = smooth_noise(9 * p, seed) + 0.5 * smooth_noise(18 * p, seed + 1);
    sulcus = std::clamp(1 - std::abs(folds) / 0.25, 0.0, 1.0) *
             std::clamp(1 - depth / kSulcusDepth, 0.0, 1.0);
  }
  const double fissure =
      std::clamp(1 - std::abs(p.x()) / 0.015, 0.0, 1.0) * std::clamp(1 - depth / 0.22, 0.0, 1.0);
  double value = kBrain - 8 * std::clamp((depth - 0.06) / 0.03, 0.0, 1.0);
  value = std::lerp(value, kFluid, std::max(sulcus, fissure));
  const Vec3 m = mirrored(p);
  const double ventricle = blend_union(ellipsoid(m, {0.06, -0.05, 0.32}, {0.04, 0.17, 0.06}),
                                       ellipsoid(m, {0.10, 0.20, 0.28}, {0.04, 0.12, 0.05}), 0.05);
  return cover(value, kFluid, ventricle);
}

double head_value(const Vec3& p, std::uint64_t seed) {
  const bool is_in_box = std::abs(p.x()) < 0.66 && p.y() > -0.84 && p.y() < 0.78 && p.z() < 0.93;
  if (!is_in_box) return kAir;
  const double cavity = ellipsoid(p, kCavityCentre, kCavityRadii);
  if (cavity < -kEdge) return brain_value(p, seed);
  const double surface = skin(p);
  if (surface > kOuterEdge) return kAir;
  const double grain = smooth_noise(24 * p, seed + 2);

  double value = cover(kSkin, kFat, surface + 0.025);
  value = cover(value, kMuscle + 12 * grain, surface + 0.045);
  if (cavity < kEdge) value = cover(value, brain_value(p, seed), cavity);

  const double socket = ellipsoid(mirrored(p), {0.19, -0.45, 0.02}, {0.13, 0.16, 0.115});
  value = cover(value, kFat, std::max(socket, surface + 0.02));
  value = cover(value, kEye, sphere(mirrored(p), {0.20, -0.50, 0.03}, 0.10));

  const double bone = skull(p);
  value = cover(value, kBone + 60 * grain, bone);
  value = cover(value, kMarrow + 150 * grain, bone + 0.022);
  value = cover(value, kBone + 60 * grain, jaw(p));
  double share = 0;
  const double column = spine(p, share);
  value = cover(value, std::lerp(kMuscle + 40, 0.7 * kBone + 120 * grain, share), column);
  value = cover(value, kTeeth, teeth(p));

  value = cover(value, kAir, airways(p));
  value = cover(value, kAir, ellipsoid(mirrored(p), {0.17, -0.36, -0.17}, {0.065, 0.10, 0.075}));
  return cover(kAir, value, surface, kOuterEdge);
}

// Which part a place is in.
enum HeadLabel {
  kNothing,
  kOfSkin,
  kOfSkull,
  kOfSpine,
  kOfTeeth,
  kOfBrain,
  kOfFluid,
  kOfEyes,
  kOfAirways
};

HeadLabel head_label(const Vec3& p, std::uint64_t seed) {
  constexpr double kLeastSkin = 0.02;
  const double surface = skin(p);
  if (surface > 0) return kNothing;
  if (airways(p) < 0) return kOfAirways;
  if (ellipsoid(mirrored(p), {0.17, -0.36, -0.17}, {0.065, 0.10, 0.075}) < 0) return kOfAirways;
  if (surface > -kLeastSkin) return kOfSkin;
  if (teeth(p) < 0) return kOfTeeth;
  double bone = 0;
  const double column = spine(p, bone);
  if (column < 0 && bone > 0.5) return kOfSpine;
  if (jaw(p) < 0 || skull(p) < 0) return kOfSkull;
  if (sphere(mirrored(p), {0.20, -0.50, 0.03}, 0.10) < 0) return kOfEyes;
  if (ellipsoid(p, kCavityCentre, kCavityRadii) > 0) return kOfSkin;
  return brain_value(p, seed) > 0.5 * (kBrain + kFluid) ? kOfBrain : kOfFluid;
}

}  // namespace

Formula make_head_labels(std::uint64_t seed, double) {
  return [seed](const Vec3& p) { return static_cast<double>(head_label(p, seed)); };
}

Formula make_head(std::uint64_t seed, double) {
  return [seed](const Vec3& p) { return head_value(p, seed); };
}

}  // namespace ovoid::model
