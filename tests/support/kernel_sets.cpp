// SPDX-License-Identifier: Apache-2.0
#include "support/kernel_sets.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <random>

namespace ovoid::test {
namespace {

float first_function(const Vec3& p) {
  return static_cast<float>(0.5 + 0.3 * std::sin(5 * p.x() + 1) * std::cos(4 * p.y()) +
                            0.2 * std::sin(6 * p.z()));
}
float second_function(const Vec3& p) { return static_cast<float>(p.x() + 2 * p.y() - p.z()); }

}  // namespace

std::shared_ptr<const KernelSource> KernelNumbers::source() const {
  KernelColumns columns;
  columns.shape = shape;
  columns.profile = profile;
  columns.cutoff = cutoff;
  columns.centers = centers;
  columns.shapes = shapes;
  columns.weights = weights;
  for (std::size_t a = 0; a < values.size(); ++a) {
    columns.values.emplace_back(values[a]);
    columns.attributes.push_back({"attribute " + std::to_string(a), "", {}});
  }
  return make_kernel_source(columns);
}

void KernelNumbers::add(const Vec3& center, const Vec3& sigmas, const Mat3& rotation,
                        std::vector<float> of) {
  centers.insert(centers.end(), center.data(), center.data() + 3);
  const Mat3 covariance = rotation * sigmas.cwiseAbs2().asDiagonal() * rotation.transpose();
  if (shape == KernelShape::kBalls) {
    shapes.push_back(static_cast<float>(sigmas[0]));
  } else {
    const Mat3 factor = covariance.llt().matrixL();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) shapes.push_back(static_cast<float>(factor(r, c)));
    }
  }
  // A cell of twice the sigma on each side.
  weights.push_back(static_cast<float>(8 / profile_integral(profile, cutoff)));
  values.resize(of.size());
  for (std::size_t a = 0; a < of.size(); ++a) values[a].push_back(of[a]);
}

Mat3 some_rotation(int number) {
  const Vec3 axis(std::sin(1.3 * number), std::cos(0.7 * number), std::sin(2.1 * number + 1));
  return Eigen::AngleAxisd(0.9 * number, axis.normalized()).toRotationMatrix();
}

KernelNumbers jittered_ellipsoids(int edge, double stretch) {
  KernelNumbers set;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  const double cell = 1.0 / edge;
  for (int i = 0; i < edge * edge * edge; ++i) {
    const Vec3 center(cell * (i % edge + 0.5 + jitter(random)),
                      cell * (i / edge % edge + 0.5 + jitter(random)),
                      cell * (i / (edge * edge) + 0.5 + jitter(random)));
    const double s = std::pow(stretch, jitter(random) / 0.3);
    set.add(center, 0.5 * cell * Vec3(s, 1 / s, 1), some_rotation(i),
            {first_function(center), second_function(center)});
  }
  return set;
}

KernelNumbers jittered_balls(int edge) {
  const KernelNumbers from = jittered_ellipsoids(edge);
  KernelNumbers set;
  set.shape = KernelShape::kBalls;
  for (std::size_t i = 0; i < from.weights.size(); ++i) {
    const Vec3 center(from.centers[3 * i], from.centers[3 * i + 1], from.centers[3 * i + 2]);
    set.add(center, Vec3::Constant((0.45 + 0.03 * static_cast<double>(i % 7)) / edge),
            Mat3::Identity(), {from.values[0][i], from.values[1][i]});
  }
  return set;
}

KernelNumbers balls_of_all_sizes(int count, double least) {
  KernelNumbers set;
  set.shape = KernelShape::kBalls;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(0, 1);
  for (int i = 0; i < count; ++i) {
    const Vec3 center(place(random), place(random), place(random));
    const double sigma = least * std::pow(0.1 / least, place(random));
    set.add(center, Vec3::Constant(sigma), Mat3::Identity(),
            {first_function(center), second_function(center)});
  }
  return set;
}

KernelNumbers lattice_balls(int edge, double cutoff) {
  KernelNumbers set;
  set.shape = KernelShape::kBalls;
  set.cutoff = cutoff;
  for (int i = 0; i < edge * edge * edge; ++i) {
    const Vec3 center(i % edge, i / edge % edge, i / (edge * edge));
    set.add(center, Vec3::Constant(0.5), Mat3::Identity(), {first_function(center / edge)});
  }
  return set;
}

}  // namespace ovoid::test
