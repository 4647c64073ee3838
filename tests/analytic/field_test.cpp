// SPDX-License-Identifier: Apache-2.0
// Values, gradients and borders of fields at points, against formulas that do not share the
// reference's sums.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/model.h"
#include "render/reference/field_evaluator.h"
#include "support/tolerances.h"
#include "support/volumes.h"

namespace ovoid::test {
namespace field_test {

using reference::FieldEvaluator;
using reference::FieldSample;

double bumpy(std::int64_t i, std::int64_t j, std::int64_t k) {
  return 40 * std::sin(1.3 * static_cast<double>(i) - 0.7 * static_cast<double>(j)) +
         25 * std::cos(0.8 * static_cast<double>(k) + 0.6 * static_cast<double>(i));
}

// mu(t): the normalized field of the samples 0, 1, 2, ... of one endless axis, by the definition in
// one dimension; and its derivative. Positions whose support ends on a sample are the caller's to
// avoid.
struct AxisRamp {
  double value = 0;
  double slope = 0;

  AxisRamp(double t, double sigma, double reach) {
    double n = 0, d = 0, dn = 0, dd = 0;
    for (auto i = static_cast<int>(std::ceil(t - reach)); i <= t + reach; ++i) {
      const double g = std::exp(-0.5 * (t - i) * (t - i) / (sigma * sigma));
      const double dg = -(t - i) / (sigma * sigma) * g;
      n += i * g;
      d += g;
      dn += i * dg;
      dd += dg;
    }
    value = n / d;
    slope = (dn * d - n * dd) / (d * d);
  }
};

// A linear volume c . i comes out as sum_a c_a mu(u_a), its gradient as A^-T (c_a mu'(u_a)), A the
// axes. Fails for any mix-up of axes, spacings, handedness or transposes.
TEST(LatticeField, LinearVolumeOnObliqueAxes) {
  const Vec3 c(3, -2, 5);
  const auto ramp = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return c.dot(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
  };
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  const FieldEvaluator field(make_field({12, 12, 12}, ramp, setup));
  const Mat3 to_world = setup.world_from_index.linear().inverse().transpose();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> inside(3.0, 8.0);
  for (int n = 0; n < 200; ++n) {
    const Vec3 u(inside(random), inside(random), inside(random));
    double value = 0;
    Vec3 slope;
    for (int a = 0; a < 3; ++a) {
      const AxisRamp mu(u[a], 0.5, 2.0);
      value += c[a] * mu.value;
      slope[a] = c[a] * mu.slope;
    }
    const FieldSample sample = field.at_world(setup.world_from_index * u);
    ASSERT_TRUE(sample.is_defined);
    ASSERT_NEAR(sample.value, value, 100 * kDoubleRelative);
    ASSERT_NEAR((sample.gradient - to_world * slope).norm(), 0, 100 * kDoubleRelative);
  }
}

// Where all three axes have the same phase the slopes agree, and the gradient has exactly the
// direction of the linear function's own; the mean slope over a period is 1.
TEST(LatticeField, GradientOfALinearVolumePointsTheRightWay) {
  const Vec3 world_slope(0.7, -1.1, 0.4);
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  const Vec3 c = setup.world_from_index.linear().transpose() * world_slope;
  const auto ramp = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return c.dot(
        Vec3(static_cast<double>(i - 6), static_cast<double>(j - 6), static_cast<double>(k - 6)));
  };
  const FieldEvaluator field(make_field({13, 13, 13}, ramp, setup));
  // The samples are floats of up to 20: 1e-6 each.
  for (const double t : {0.1, 0.25, 0.5, 0.8}) {
    const Vec3 gradient = field.at_index({5 + t, 6 + t, 7 + t}).gradient;
    EXPECT_NEAR((gradient.normalized() - world_slope.normalized()).norm(), 0, 1e-5) << t;
  }
}

// ---- Gradients
// -------------------------------------------------------------------------------------------------------

// Fourth-order difference of `f` along each world axis.
Vec3 difference_gradient(const std::function<double(const Vec3&)>& f, const Vec3& at, double h) {
  Vec3 gradient;
  for (int a = 0; a < 3; ++a) {
    const Vec3 e = h * Vec3::Unit(a);
    gradient[a] = (8 * (f(at + e) - f(at - e)) - (f(at + 2 * e) - f(at - 2 * e))) / (12 * h);
  }
  return gradient;
}

// True if no support ends within `margin` of the position, so that the field is smooth there.
bool is_off_cut_offs(const Vec3& u, const Vec3& reach, double margin) {
  for (int a = 0; a < 3; ++a) {
    for (const double end : {u[a] + reach[a], u[a] - reach[a]}) {
      if (std::abs(end - std::round(end)) < margin) return false;
    }
  }
  return true;
}

struct GradientCase {
  const char* name;
  Reconstruction reconstruction;
  Vec3 widening;
  bool has_holes;
};

class FieldGradient : public testing::TestWithParam<GradientCase> {};

// The gradient is the value's own derivative: inside, at faces and around holes, widened or not, on
// oblique axes. Fails if any term of the quotient rule, a widening or the transform is left out.
TEST_P(FieldGradient, IsTheDerivativeOfTheValue) {
  const GradientCase& param = GetParam();
  FieldSetup setup;
  setup.world_from_index = oblique_axes();
  setup.reconstruction = param.reconstruction;
  const auto volume = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return param.has_holes && (i + 2 * j + 3 * k) % 11 == 0 ? kMissing : bumpy(i, j, k);
  };
  const FieldEvaluator field(make_field({8, 9, 7}, volume, setup));
  const auto value = [&](const Vec3& p) { return field.at_world(p, param.widening).value; };
  constexpr double kStep = 1e-3;
  const Vec3 reach = 2.0 * param.widening;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> anywhere(-0.4, 8.4);
  int num_checked = 0;
  for (int n = 0; n < 400; ++n) {
    const Vec3 u(anywhere(random), anywhere(random), anywhere(random));
    if (!is_off_cut_offs(u, reach, 10 * kStep)) continue;
    const Vec3 p = setup.world_from_index * u;
    // All points of the difference must be defined: the border is a jump.
    bool is_defined = field.at_world(p, param.widening).is_defined;
    for (int a = 0; a < 3; ++a) {
      is_defined &= field.at_world(p + 2 * kStep * Vec3::Unit(a), param.widening).is_defined;
      is_defined &= field.at_world(p - 2 * kStep * Vec3::Unit(a), param.widening).is_defined;
    }
    if (!is_defined) continue;
    ++num_checked;
    const Vec3 gradient = field.at_world(p, param.widening).gradient;
    ASSERT_NEAR((gradient - difference_gradient(value, p, kStep)).norm(), 0, 65 * kGradientRelative)
        << param.name << " at " << u.transpose();
  }
  EXPECT_GT(num_checked, 80);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, FieldGradient,
    testing::Values(GradientCase{"normalized", Reconstruction::kNormalized, {1, 1, 1}, false},
                    GradientCase{"normalized_holes", Reconstruction::kNormalized, {1, 1, 1}, true},
                    GradientCase{
                        "normalized_widened", Reconstruction::kNormalized, {1.7, 1, 2.3}, true},
                    GradientCase{"sum", Reconstruction::kSum, {1, 1, 1}, false},
                    GradientCase{"sum_widened_holes", Reconstruction::kSum, {1.2, 2.1, 1}, true}),
    [](const auto& kind) { return std::string(kind.param.name); });

// The mean's gradient is the derivative of the mean with respect to moving the whole segment. The
// cut-off is at 9 sigmas, because its jumps are not differentiated.
TEST(LatticeField, GradientOfAMeanIsItsDerivative) {
  for (const Reconstruction reconstruction : {Reconstruction::kNormalized, Reconstruction::kSum}) {
    FieldSetup setup;
    setup.world_from_index = oblique_axes();
    setup.kernel.cutoff = 9;
    setup.reconstruction = reconstruction;
    const FieldEvaluator field(make_field({8, 9, 7}, bumpy, setup));
    const Affine3 index_from_world = setup.world_from_index.inverse();
    const Vec3 half(0.3, -0.4, 0.6);
    const auto mean = [&](const Vec3& p) {
      return field.mean_over(index_from_world * (p - half), index_from_world * (p + half));
    };
    for (const Vec3& u : {Vec3(3.2, 4.1, 2.7), Vec3(0.3, 5.2, 3.3), Vec3(6.4, 7.1, 5.6)}) {
      const Vec3 p = setup.world_from_index * u;
      ASSERT_TRUE(mean(p).is_defined);
      const Vec3 expected =
          difference_gradient([&](const Vec3& q) { return mean(q).value; }, p, 1e-3);
      EXPECT_NEAR((mean(p).gradient - expected).norm(), 0, 65 * kGradientRelative);
    }
  }
}

// ---- Borders
// ---------------------------------------------------------------------------------------------------------

// A normalized field ends just beyond the face of its last samples' cells, a sum where the last
// kernel's box does.
TEST(LatticeField, EndsAtItsFaces) {
  FieldSetup setup;
  const FieldEvaluator normalized(constant_field({6, 7, 8}, 3, setup));
  setup.reconstruction = Reconstruction::kSum;
  const FieldEvaluator sum(constant_field({6, 7, 8}, 3, setup));
  const Vec3 middle(2.5, 3, 3.5);
  const std::array<double, 3> last{5, 6, 7};
  for (int a = 0; a < 3; ++a) {
    const auto at = [&](double u) {
      Vec3 position = middle;
      position[a] = u;
      return position;
    };
    const double end = last[static_cast<std::size_t>(a)];
    for (const double inside : {-0.5, end + 0.5}) {
      EXPECT_TRUE(normalized.at_index(at(inside)).is_defined) << a << " " << inside;
    }
    for (const double outside : {-0.55, end + 0.55, -3.0, end + 1.9}) {
      EXPECT_FALSE(normalized.at_index(at(outside)).is_defined) << a << " " << outside;
    }
    EXPECT_TRUE(sum.at_index(at(-1.999)).is_defined);
    EXPECT_TRUE(sum.at_index(at(end + 1.999)).is_defined);
    EXPECT_FALSE(sum.at_index(at(-2.001)).is_defined);
    EXPECT_FALSE(sum.at_index(at(end + 2.001)).is_defined);
  }
}

// One slice is seen from half a spacing away; a single sample only close to its centre, where its
// kernel is half of all.
TEST(LatticeField, ThinLatticesAreDefined) {
  const FieldEvaluator slice(constant_field({9, 9, 1}, 7));
  EXPECT_TRUE(slice.at_index({4, 4, 0.5}).is_defined);
  EXPECT_TRUE(slice.at_index({4, 4, -0.5}).is_defined);
  EXPECT_FALSE(slice.at_index({4, 4, 0.6}).is_defined);
  const FieldEvaluator one(constant_field({1, 1, 1}, 7));
  EXPECT_EQ(one.at_index({0, 0, 0}).value, 7);
}

// Positions that are no place at all.
TEST(LatticeField, HostilePositionsAreUndefined) {
  const FieldEvaluator field(constant_field({4, 4, 4}, 1));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(), 1e300, -1e300}) {
    EXPECT_FALSE(field.at_index({bad, 1, 1}).is_defined);
    EXPECT_FALSE(field.at_index({1, 1, bad}).is_defined);
  }
  EXPECT_FALSE(field.mean_over({1, 1, 0}, {1, NAN, 1}).is_defined);
  EXPECT_THROW(field.mean_over({1, 1, 0}, {1, 1e300, 1}), Error);
}

// ---- Where samples come from
// -----------------------------------------------------------------------------------------

// Stored numbers stand for number * scale + offset.
TEST(LatticeField, ScaleAndOffsetApply) {
  FieldSetup setup;
  setup.value_scale = -0.25;
  setup.value_offset = 100;
  const FieldEvaluator scaled(make_field({6, 6, 6}, bumpy, setup));
  const FieldEvaluator plain(make_field({6, 6, 6}, bumpy));
  for (const Vec3& u : {Vec3(2.2, 3.1, 1.7), Vec3(-0.3, 5.2, 2.5)}) {
    EXPECT_NEAR(scaled.at_index(u).value, 100 - 0.25 * plain.at_index(u).value,
                200 * kDoubleRelative);
    EXPECT_NEAR((scaled.at_index(u).gradient + 0.25 * plain.at_index(u).gradient).norm(), 0,
                200 * kDoubleRelative);
  }
}

// The library's own resident source and the tests' brick by brick one hold the same field, for each
// stored type.
TEST(LatticeField, ResidentAndBrickedSourcesAgree) {
  const Index3 dims{13, 9, 18};
  std::vector<std::uint8_t> stored;
  for (std::int64_t n = 0; n < num_samples(dims); ++n)
    stored.push_back(static_cast<std::uint8_t>(n * 37 % 251));
  const auto volume = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return static_cast<double>(stored[static_cast<std::size_t>(i + dims[0] * (j + dims[1] * k))]);
  };
  for (const ScalarType type :
       {ScalarType::kUInt8, ScalarType::kInt16, ScalarType::kUInt16, ScalarType::kFloat32}) {
    std::vector<std::byte> bytes(stored.size() * size_of(type));
    for (std::size_t n = 0; n < stored.size(); ++n) {
      const auto put = [&](auto number) {
        std::memcpy(bytes.data() + n * sizeof number, &number, sizeof number);
      };
      if (type == ScalarType::kUInt8) put(stored[n]);
      if (type == ScalarType::kInt16) put(static_cast<std::int16_t>(stored[n]));
      if (type == ScalarType::kUInt16) put(static_cast<std::uint16_t>(stored[n]));
      if (type == ScalarType::kFloat32) put(static_cast<float>(stored[n]));
    }
    Dataset dataset;
    dataset.lattice.dims = dims;
    dataset.arrays.push_back({"a", type, 1, num_samples(dims), "", false, {nullptr, bytes}});
    LatticeModelOptions published;
    published.kernel = LatticeKernel{};
    const FieldEvaluator resident(make_lattice_field(dataset, published));
    const FieldEvaluator bricked(make_field(dims, volume));
    for (double t = 0; t <= 1; t += 0.05) {
      const Vec3 u(12 * t, 8 - 8 * t, 17 * t);
      ASSERT_EQ(resident.at_index(u).value, bricked.at_index(u).value) << name_of(type) << " " << t;
    }
  }
}

}  // namespace field_test
}  // namespace ovoid::test
