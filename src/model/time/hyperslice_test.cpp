// SPDX-License-Identifier: Apache-2.0
#include "ovoid/hyperslice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "model/test_steps.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"

namespace ovoid {
namespace hyperslice_test {

using ::testing::HasSubstr;

constexpr Index3 kDims{9, 8, 7};

Affine3 unlike_axes() {
  Affine3 world = Affine3::Identity();
  world.linear() = Vec3(0.5, 2, 1.25).asDiagonal();
  world.translation() = Vec3(-3, 1, 10);
  return world;
}

// A function of world and time, sampled on either lattice; times from 2 on.
struct Sampled {
  explicit Sampled(SeriesKind kind, std::function<double(const Vec3&, double)> function,
                   const Affine3& world = unlike_axes(), int num_steps = 12)
      : times(kind == SeriesKind::kStaggered ? staggered_times(num_steps) : even_times(num_steps)),
        series([&] {
          for (double& time : times) time = 2 + 0.25 * time;
          return std::make_shared<FormulaSteps>(
              kind, kDims, times,
              [times = times, world, function](const Vec3& position, std::int64_t step) {
                return function(world * position, times[static_cast<std::size_t>(step)]);
              },
              world);
        }()) {}
  std::vector<double> times;
  Series series;
};

const SeriesKind kKinds[] = {SeriesKind::kSteps, SeriesKind::kStaggered};

double mixed(const Vec3& p, double t) {
  return std::sin(0.9 * p.x() + 0.2 * p.y() - 0.4 * p.z()) + std::cos(1.7 * t + 0.3 * p.x());
}

std::string error_of(const Series& series, const Hyperplane& plane,
                     const HypersliceOptions& options = {}) {
  try {
    hyperslice(series, plane, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// Fails if a plane at a time is not the volume of that time, whatever the length of its normal.
TEST(Hyperslice, AcrossTimeIsATimeSlice) {
  for (const SeriesKind kind : kKinds) {
    const Sampled data(kind, mixed);
    for (const TimeFilter filter :
         {TimeFilter::kFourSteps, TimeFilter::kTwoSteps, TimeFilter::kGaussian}) {
      const double time = 3.1;
      TimeSliceOptions slice_options;
      slice_options.filter = filter;
      const Dataset expected = slice_at_time(data.series, time, slice_options);
      HypersliceOptions options;
      options.filter = filter;
      const Dataset found = hyperslice(data.series, {{0, 0, 0, -3}, -3 * time}, options);
      EXPECT_EQ(found.lattice.kind, expected.lattice.kind);
      EXPECT_EQ(found.lattice.dims, expected.lattice.dims);
      EXPECT_TRUE(
          found.lattice.world_from_index.isApprox(expected.lattice.world_from_index, 1e-12));
      const auto a = values_of(found);
      const auto b = values_of(expected);
      for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5);
    }
  }
}

// Fails if time is not in the place of the axis that is cut, or halves lose their shift.
TEST(Hyperslice, AcrossAnAxisTimeStandsInItsPlace) {
  for (const SeriesKind kind : kKinds) {
    for (int axis = 0; axis < 3; ++axis) {
      // Linear in all but the axis.
      Vec3 slope(1, 10, 100);
      slope[axis] = 0;
      const Sampled data(kind, [&](const Vec3& p, double t) { return slope.dot(p) + 1000 * t; });
      Hyperplane plane{{0, 0, 0, 0}, 0};
      const Affine3 world = unlike_axes();
      plane.normal[static_cast<std::size_t>(axis)] = 2;
      plane.offset = 2 * (world * Vec3::Constant(2.3))[axis];
      const Dataset slice = hyperslice(data.series, plane);
      const auto num_steps = static_cast<std::int64_t>(data.times.size());
      const bool is_staggered = kind == SeriesKind::kStaggered;
      Index3 dims = kDims;
      dims[static_cast<std::size_t>(axis)] = is_staggered ? num_steps / 2 : num_steps;
      if (is_staggered) dims[2] *= 2;
      EXPECT_EQ(slice.lattice.dims, dims);
      const std::vector<float> values = values_of(slice);
      const double per_index =
          is_staggered ? data.times[2] - data.times[0] : data.times[1] - data.times[0];
      std::size_t n = 0;
      for (std::int64_t k = 0; k < dims[2]; ++k) {
        for (std::int64_t j = 0; j < dims[1]; ++j) {
          for (std::int64_t i = 0; i < dims[0]; ++i) {
            const Vec3 at = slice.lattice.index_position({i, j, k});
            const double time = data.times[0] + per_index * at[axis];
            ASSERT_NEAR(values[n++], slope.dot(world * at) + 1000 * time, 0.05)
                << axis << ": " << i << " " << j << " " << k;
          }
        }
      }
    }
  }
}

// Fails if samples of an oblique slice do not lie in the plane, a T apart along axes at right
// angles, or sums lean to a side: positions are read back from slices of the coordinates.
TEST(Hyperslice, ObliqueSlicesLieInThePlane) {
  const Affine3 world = unlike_axes();
  const Hyperplane plane{{0.8, 0.1, -0.5, 1.5}, 0.8 * -1.2 + 0.1 * 9 - 0.5 * 13.5 + 1.5 * 3.2};
  for (const SeriesKind kind : kKinds) {
    for (const LatticeKind lattice : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
      HypersliceOptions options;
      options.lattice = lattice;
      options.spacing = 0.75;
      std::vector<std::vector<float>> coordinates;
      Dataset slice;
      for (int c = 0; c < 4; ++c) {
        const Sampled data(kind, [c](const Vec3& p, double t) { return c < 3 ? p[c] : t; });
        slice = hyperslice(data.series, plane, options);
        coordinates.push_back(values_of(slice));
      }
      EXPECT_EQ(slice.lattice.kind, lattice);
      const Sampled data(kind, mixed);
      const Vec3 unit =
          world.linear().diagonal() / (kind == SeriesKind::kStaggered ? std::sqrt(2.0) : 1.0);
      const double per_time = kind == SeriesKind::kStaggered
                                  ? 1 / ((data.times[1] - data.times[0]) * std::sqrt(2.0))
                                  : 1 / (data.times[1] - data.times[0]);
      const auto position = [&](std::size_t n) {
        return Eigen::Vector4d(coordinates[0][n] / unit.x(), coordinates[1][n] / unit.y(),
                               coordinates[2][n] / unit.z(), coordinates[3][n] * per_time);
      };
      // Away from the faces, where sums are of one side alone.
      const auto is_inside = [&](std::size_t n) {
        const Vec3 at(coordinates[0][n], coordinates[1][n], coordinates[2][n]);
        const Vec3 u = world.inverse() * at;
        return u.minCoeff() > 2 && u.x() < 6 && u.y() < 5 && u.z() < 4 &&
               coordinates[3][n] > data.times[3] && coordinates[3][n] < data.times[8];
      };
      const Index3& dims = slice.lattice.dims;
      const double neighbour = 0.75 * (lattice == LatticeKind::kBodyCentred ? std::sqrt(2.0) : 1.0);
      // Sums over the kernels of D4* lean to samples nearby, more than those of a Cartesian
      // lattice.
      const double ripple = kind == SeriesKind::kStaggered ? 0.18 : 0.07;
      int num_inside = 0;
      for (std::int64_t k = 0; k < dims[2]; ++k) {
        for (std::int64_t j = 0; j + 1 < dims[1]; ++j) {
          for (std::int64_t i = 0; i + 1 < dims[0]; ++i) {
            const auto n = static_cast<std::size_t>(i + dims[0] * (j + dims[1] * k));
            const auto right = n + 1;
            const auto below = n + static_cast<std::size_t>(dims[0]);
            if (!is_inside(n) || !is_inside(right) || !is_inside(below)) continue;
            ++num_inside;
            double sum = 0;
            for (std::size_t c = 0; c < 4; ++c)
              sum += plane.normal[c] * static_cast<double>(coordinates[c][n]);
            ASSERT_NEAR(sum, plane.offset, 0.08);
            const Eigen::Vector4d x = position(right) - position(n);
            const Eigen::Vector4d y = position(below) - position(n);
            ASSERT_NEAR(x.norm(), neighbour, ripple);
            ASSERT_NEAR(y.norm(), neighbour, ripple);
            ASSERT_NEAR(x.dot(y), 0, ripple);
          }
        }
      }
      EXPECT_GT(num_inside, 20) << name_of(lattice) << " " << name_of(kind);
    }
  }
}

// Fails if the general sum over the four-dimensional lattice is another than the one over a moment.
TEST(Hyperslice, TiltedByNextToNothingIsExact) {
  const Sampled data(SeriesKind::kStaggered, mixed, Affine3::Identity());
  HypersliceOptions options;
  options.filter = TimeFilter::kExact;
  const Hyperplane plane{{0, 0, 0, 1}, 3.1};
  const std::vector<float> expected = values_of(hyperslice(data.series, plane, options));
  const Dataset tilted = hyperslice(data.series, {{1e-7, 0, 0, 1}, 3.1}, options);
  EXPECT_EQ(tilted.lattice.kind, LatticeKind::kBodyCentred);
  const std::vector<float> found = values_of(tilted);
  // The lattice that is laid over the plane may have one row more at its far side.
  const Dataset same = hyperslice(data.series, plane, options);
  int num_compared = 0;
  for (std::int64_t k = 0; k < std::min(same.lattice.dims[2], tilted.lattice.dims[2]); ++k) {
    for (std::int64_t j = 0; j < std::min(same.lattice.dims[1], tilted.lattice.dims[1]); ++j) {
      for (std::int64_t i = 0; i < std::min(same.lattice.dims[0], tilted.lattice.dims[0]); ++i) {
        const float value = found[static_cast<std::size_t>(
            i + tilted.lattice.dims[0] * (j + tilted.lattice.dims[1] * k))];
        if (std::isnan(value)) continue;
        ++num_compared;
        ASSERT_NEAR(value,
                    expected[static_cast<std::size_t>(i + same.lattice.dims[0] *
                                                              (j + same.lattice.dims[1] * k))],
                    1e-4)
            << i << " " << j << " " << k;
      }
    }
  }
  EXPECT_GT(num_compared, 800);
}

// Fails if a constant is not one, at faces and beside holes, or where the plane leaves the data.
TEST(Hyperslice, ConstantsStay) {
  for (const SeriesKind kind : kKinds) {
    int num_samples_read = 0;
    const Sampled data(kind, [&num_samples_read](const Vec3&, double) {
      return ++num_samples_read % 11 == 0 ? std::numeric_limits<double>::quiet_NaN() : 4.5;
    });
    const Dataset slice = hyperslice(data.series, {{0.5, 0.3, 0.4, 1}, 9});
    int num_defined = 0;
    for (const float value : values_of(slice)) {
      if (std::isnan(value)) continue;
      ++num_defined;
      ASSERT_NEAR(value, 4.5, 1e-5);
    }
    EXPECT_GT(num_defined, 50);
  }
}

// Fails if an extracted sample is not where the plane has it, or counts as if it were nearer.
TEST(Hyperslice, ExtractsWhatIsNear) {
  const Sampled data(SeriesKind::kSteps, mixed);
  HypersliceOptions options;
  options.method = SliceMethod::kExtracted;
  const double time = data.times[4] + 0.3 * 0.25;  // 0.3 T behind step 4
  const Dataset slice = hyperslice(data.series, {{0, 0, 0, 1}, time}, options);
  EXPECT_EQ(slice.kind, DatasetKind::kKernels);
  const std::int64_t volume = num_samples(kDims);
  ASSERT_EQ(slice.num_positions(), 4 * volume);
  const auto* positions = reinterpret_cast<const double*>(slice.positions.bytes.view.data());
  const auto* weights = reinterpret_cast<const float*>(slice.array("weight").bytes.view.data());
  const auto* values = reinterpret_cast<const float*>(slice.array("value").bytes.view.data());
  const Affine3 world = unlike_axes();
  const double per_kernel = std::pow(2 / std::numbers::pi, 2);
  for (int step = 3; step <= 6; ++step) {
    const std::int64_t n = (step - 3) * volume + 100;
    const Vec3 expected = world * Vec3(100 % 9, 100 / 9 % 8, 100 / 72);
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(positions[3 * n + a], expected[a], 1e-9);
    EXPECT_NEAR(weights[n], std::exp(-2 * std::pow(step - 4.3, 2)) * per_kernel, 1e-5);
    EXPECT_NEAR(values[n], mixed(expected, data.times[static_cast<std::size_t>(step)]), 1e-5);
  }
  const auto* scales = reinterpret_cast<const float*>(slice.array("scale").bytes.view.data());
  EXPECT_NEAR(scales[0], 1.0, 1e-6);  // half of the greatest spacing, 2
  EXPECT_NEAR(scales[2], 0.25, 1e-6);
}

// Fails if extracted kernels are summed where they are meant to be averaged, or if their weights
// are not such that their sum is about 1 inside, as sets are defined.
TEST(Hyperslice, ExtractedFieldsHaveTheSamplesValues) {
  HypersliceOptions options;
  options.method = SliceMethod::kExtracted;
  for (const SeriesKind kind : kKinds) {
    SCOPED_TRACE(name_of(kind));
    constexpr double kLeast = 1.000, kGreatest = 1.007;
    const Sampled data(kind, [](const Vec3& p, double t) {
      return kLeast + (kGreatest - kLeast) * (0.5 + 0.25 * mixed(p, t));
    });
    for (const Hyperplane& plane : {Hyperplane{{0, 0, 0, 1}, 3.3}, {{0, 1, 0, 1}, 12.3}}) {
      const KernelField field = make_kernel_field(hyperslice(data.series, plane, options));
      EXPECT_EQ(field.reconstruction(), Reconstruction::kNormalized);
      const FieldProbe probe{field};
      const Bounds3 bounds = field.world_bounds();
      for (const double share : {0.4, 0.45, 0.5, 0.55, 0.6}) {
        for (int axis = 0; axis < 3; ++axis) {
          Vec3 at = bounds.center();
          at[axis] = bounds.min()[axis] + share * bounds.sizes()[axis];
          const FieldSample sample = probe.at(at);
          ASSERT_TRUE(sample.is_defined);
          EXPECT_GE(sample.value, kLeast - 1e-6);
          EXPECT_LE(sample.value, kGreatest + 1e-6);
          EXPECT_NEAR(sample.weight, 1, 0.1);
        }
      }
    }
  }
}

// Fails if a step is not the slice at its time, or the samples' planes are not found.
TEST(HypersliceSteps, AreSlicesOneAfterTheOther) {
  for (const SeriesKind kind : kKinds) {
    auto series = std::make_shared<const Series>(Sampled(kind, mixed).series);
    for (const Hyperplane plane :
         {Hyperplane{{0, -2, 0, 0}, 0}, Hyperplane{{0, 0, 0, 3}, 0}, Hyperplane{{1, 0, 0, 0}, 7}}) {
      const auto steps = hyperslice_steps(series, plane);
      const std::size_t axis = plane.normal[3] != 0 ? 3 : plane.normal[1] != 0 ? 1 : 0;
      ASSERT_EQ(steps->num_steps(), axis == 3 ? series->num_steps() : kDims[axis]);
      EXPECT_TRUE(std::is_sorted(steps->times().begin(), steps->times().end()));
      const Dataset step = steps->read(2);
      Hyperplane third = plane;
      third.offset = steps->times()[2];
      const Dataset slice = hyperslice(*series, third);
      EXPECT_EQ(step.lattice.dims, slice.lattice.dims);
      EXPECT_TRUE(std::ranges::equal(step.array().bytes.view, slice.array().bytes.view));
      EXPECT_EQ(step.num_steps, steps->num_steps());
      EXPECT_EQ(step.step, 2);
      EXPECT_EQ(Series(steps).step(1)->step, 1);  // what a series asks of its steps holds
    }
  }
  // World y of samples is 1 + 2 j; times begin at 2.
  const auto series = std::make_shared<const Series>(Sampled(SeriesKind::kSteps, mixed).series);
  EXPECT_EQ(hyperslice_steps(series, {{0, -2, 0, 0}, 0})->times().front(), -30);
  EXPECT_EQ(hyperslice_steps(series, {{0, 0, 0, 3}, 0})->times()[1], 6.75);
}

TEST(HypersliceSteps, RefuseWhatMovesSideways) {
  const auto series = std::make_shared<const Series>(Sampled(SeriesKind::kSteps, mixed).series);
  const auto refusal = [&](const Hyperplane& plane, const std::vector<double>& offsets,
                           const HypersliceOptions& options = {}) -> std::string {
    try {
      hyperslice_steps(series, plane, offsets, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "made";
  };
  EXPECT_EQ(refusal({{0, 0, 0, 1}, 0}, {2, 3}), "made");
  EXPECT_THAT(refusal({{1, 0, 0, 1}, 0}, {}), HasSubstr("across one axis"));
  EXPECT_THAT(refusal({{0, 0, 0, 1}, 0}, {3, 2}), HasSubstr("must rise"));
  EXPECT_THAT(refusal({{0, 0, 0, 1}, 0}, {3, 200}), HasSubstr("misses the data"));
  EXPECT_THAT(refusal({{0, 0, 0, 1}, 0}, {}, {.method = SliceMethod::kExtracted}),
              HasSubstr("no lattices"));
}

TEST(Hyperslice, RefusesWhatIsNoPlaneOrMisses) {
  const Sampled data(SeriesKind::kSteps, mixed);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error_of(data.series, {{0, 0, 0, 0}, 1}), HasSubstr("has no direction"));
  EXPECT_THAT(error_of(data.series, {{0, nan, 0, 1}, 1}), HasSubstr("must be finite"));
  EXPECT_THAT(error_of(data.series, {{1, 0, 0, 0}, 1.5}),
              HasSubstr("misses the data, over which 1 x + 0 y + 0 z + 0 t goes from -3 to 1"));
  EXPECT_THAT(error_of(data.series, {{0, 0, 0, 1}, 1.9}), HasSubstr("goes from 2 to 4.75"));
  EXPECT_EQ(error_of(data.series, {{1, 0, 0, 0}, 1}), "");
  HypersliceOptions options;
  for (const double spacing : {0.0, -1.0, nan}) {
    options.spacing = spacing;
    EXPECT_THAT(error_of(data.series, {{0, 0, 0, 1}, 3}, options), HasSubstr("spacing"));
  }
  options.spacing = 1e-4;
  EXPECT_THAT(error_of(data.series, {{0, 0, 0, 1}, 3}, options), HasSubstr("samples, more than"));
}

TEST(Hyperslice, TakesEvenStepsButForPlanesAcrossTime) {
  const Series series(std::make_shared<FormulaSteps>(
      SeriesKind::kSteps, kDims, std::vector<double>{0, 1, 3, 4},
      [](const Vec3&, std::int64_t step) { return static_cast<double>(step); }));
  EXPECT_NEAR(values_of(hyperslice(series, {{0, 0, 0, 1}, 2}))[0], 1.5, 1e-6);
  EXPECT_THAT(error_of(series, {{1, 0, 0, 0}, 2}), HasSubstr("steps must be even"));
  EXPECT_THAT(error_of(series, {{1, 0, 0, 1}, 2}), HasSubstr("steps must be even"));
}

}  // namespace hyperslice_test
}  // namespace ovoid
