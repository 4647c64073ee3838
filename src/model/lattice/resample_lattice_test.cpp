// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>

#include "ovoid/error.h"
#include "ovoid/resample.h"

namespace ovoid {
namespace resample_lattice_test {

using Signal = std::function<double(const Vec3& index)>;

template <class T>
Dataset sampled(const Index3& dims, const Signal& signal) {
  Dataset dataset;
  dataset.source = "signal";
  dataset.lattice.dims = dims;
  dataset.lattice.world_from_index =
      Eigen::Translation3d(3, -2, 5) * Eigen::Scaling(Vec3(0.5, 1.0, 2.0));
  const auto count = static_cast<std::size_t>(num_samples(dims));
  const auto memory = std::make_shared<T[]>(count);
  std::size_t at = 0;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const double value = signal(dataset.lattice.index_position({i, j, k}));
        memory[at++] = static_cast<T>(std::is_integral_v<T> ? std::round(value) : value);
      }
    }
  }
  DataArray array;
  array.name = "signal";
  array.type = std::is_same_v<T, float> ? ScalarType::kFloat32 : ScalarType::kUInt8;
  array.num_tuples = num_samples(dims);
  array.bytes = {memory, std::as_bytes(std::span<const T>(memory.get(), count))};
  dataset.arrays.push_back(array);
  return dataset;
}

// A wave that a cosine transform of n samples keeps as one coefficient, `cycles` per sample.
double wave(double index, double cycles) {
  return std::cos(2 * std::numbers::pi * cycles * (index + 0.5));
}
double cycles_of(int k, std::int64_t n) { return k / (2.0 * static_cast<double>(n)); }

// Greatest difference to the signal, `margin` samples of the source from the faces or farther.
double greatest_error(const Dataset& from, const Dataset& to, const Signal& signal, double margin) {
  const auto* values = reinterpret_cast<const float*>(to.arrays[0].bytes.view.data());
  const Affine3 from_to = from.lattice.world_from_index.inverse() * to.lattice.world_from_index;
  double error = 0;
  std::size_t at = 0;
  for (std::int64_t k = 0; k < to.lattice.dims[2]; ++k) {
    for (std::int64_t j = 0; j < to.lattice.dims[1]; ++j) {
      for (std::int64_t i = 0; i < to.lattice.dims[0]; ++i, ++at) {
        const Vec3 index = from_to * to.lattice.index_position({i, j, k});
        bool is_inside = true;
        for (int a = 0; a < 3; ++a) {
          const auto n = static_cast<double>(from.lattice.dims[static_cast<std::size_t>(a)]);
          is_inside = is_inside && index[a] >= margin && index[a] <= n - 1 - margin;
        }
        if (is_inside)
          error = std::max(error, std::abs(static_cast<double>(values[at]) - signal(index)));
      }
    }
  }
  return error;
}

// Fails if sublattices are misplaced, or if what lies inside the ball of frequencies is changed.
TEST(ResampleLattice, KeepsWhatLiesInTheBall) {
  const Index3 dims{32, 30, 28};
  const Signal signal = [&](const Vec3& u) {
    return wave(u[0], cycles_of(14, 32)) * wave(u[1], cycles_of(10, 30)) +
           wave(u[2], cycles_of(12, 28));
  };
  const Dataset from = sampled<float>(dims, signal);
  const Dataset to = resample_lattice(from, LatticeKind::kBodyCentred);
  EXPECT_EQ(to.lattice.dims, (Index3{23, 22, 39}));
  EXPECT_EQ(to.lattice.kind, LatticeKind::kBodyCentred);
  // Cubic splines err by 1 % of a wave of 0.22 cycles per sample, of which the sum has two.
  EXPECT_LT(greatest_error(from, to, signal, 6), 0.04);
}

// Fails if the corners of the frequencies' cube are left in, which alias on the sparser lattice.
TEST(ResampleLattice, TakesWhatLiesOutsideOfTheBall) {
  const Index3 dims{32, 32, 32};
  const double high = cycles_of(24, 32);  // 0.375; 0.65 along the diagonal
  const Signal corner = [&](const Vec3& u) {
    return wave(u[0], high) * wave(u[1], high) * wave(u[2], high);
  };
  const Signal zero = [](const Vec3&) { return 0.0; };
  const Dataset from = sampled<float>(dims, corner);
  EXPECT_LT(greatest_error(from, resample_lattice(from, LatticeKind::kBodyCentred), zero, 0), 1e-4);
  LatticeResampleOptions open;
  open.band_limit = false;
  EXPECT_GT(greatest_error(from, resample_lattice(from, LatticeKind::kBodyCentred, open), zero, 0),
            0.3);
  LatticeResampleOptions coarse;
  coarse.spacing = 2;  // what one axis alone keeps at a spacing of 1
  const double along = cycles_of(20, 32);
  const Dataset axis = sampled<float>(dims, [&](const Vec3& u) { return wave(u[0], along); });
  EXPECT_LT(greatest_error(axis, resample_lattice(axis, LatticeKind::kCartesian, coarse), zero, 0),
            1e-4);
}

// Fails if samples at samples are not the samples, or integers are cut off instead of rounded.
TEST(ResampleLattice, GivesSamplesBackAtTheirPlaces) {
  LatticeResampleOptions same;
  same.band_limit = false;
  const Signal steep = [](const Vec3& u) {
    return std::fmod(37 * u[0] + 91 * u[1] + 53 * u[2], 251.0);
  };
  const Dataset floats = sampled<float>({9, 8, 7}, steep);
  EXPECT_LT(
      greatest_error(floats, resample_lattice(floats, LatticeKind::kCartesian, same), steep, 0),
      1e-3);
  const Dataset bytes = sampled<std::uint8_t>({9, 8, 7}, steep);
  const Dataset again = resample_lattice(bytes, LatticeKind::kCartesian, same);
  ASSERT_EQ(again.arrays[0].type, ScalarType::kUInt8);
  EXPECT_TRUE(std::equal(bytes.arrays[0].bytes.view.begin(), bytes.arrays[0].bytes.view.end(),
                         again.arrays[0].bytes.view.begin()));
}

// Fails if overshoots wrap around in the type.
TEST(ResampleLattice, StaysWithinTheType) {
  const Dataset edge =
      sampled<std::uint8_t>({16, 16, 16}, [](const Vec3& u) { return u[0] < 8 ? 0.0 : 255.0; });
  const Dataset to = resample_lattice(edge, LatticeKind::kBodyCentred);
  const auto* values = reinterpret_cast<const std::uint8_t*>(to.arrays[0].bytes.view.data());
  for (std::int64_t i = 0; i < num_samples(to.lattice.dims); ++i) {
    const std::int64_t x = i % to.lattice.dims[0];
    if (x <= 3) {
      EXPECT_LT(values[i], 40);
    }
    if (x >= 8) {
      EXPECT_GT(values[i], 215);
    }
  }
}

// Fails if what is missing spoils what is there, or is made up.
TEST(ResampleLattice, LeavesHolesWhereTheyWere) {
  const Signal holed = [](const Vec3& u) {
    return (u - Vec3(8, 8, 8)).norm() < 2.5 ? std::numeric_limits<double>::quiet_NaN() : 7.0;
  };
  const Dataset to =
      resample_lattice(sampled<float>({17, 17, 17}, holed), LatticeKind::kBodyCentred);
  const auto* values = reinterpret_cast<const float*>(to.arrays[0].bytes.view.data());
  std::int64_t num_missing = 0;
  for (std::int64_t i = 0; i < num_samples(to.lattice.dims); ++i) {
    if (std::isnan(values[i])) {
      ++num_missing;
    } else {
      EXPECT_NEAR(values[i], 7.0, 1e-3);
    }
  }
  EXPECT_GT(num_missing, 30);
  EXPECT_LT(num_missing, 80);
}

// Fails if a request that cannot be met is met by something.
TEST(ResampleLattice, NamesWhatIsWrong) {
  const Dataset fine = sampled<float>({5, 5, 5}, [](const Vec3& u) { return u[0]; });
  LatticeResampleOptions options;
  options.spacing = 0;
  EXPECT_THROW(resample_lattice(fine, LatticeKind::kBodyCentred, options), Error);
  options = {};
  options.array = "other";
  EXPECT_THROW(resample_lattice(fine, LatticeKind::kBodyCentred, options), Error);
  const Dataset body = resample_lattice(fine, LatticeKind::kBodyCentred);
  EXPECT_THROW(resample_lattice(body, LatticeKind::kBodyCentred), Error);
  const Dataset slice = sampled<float>({5, 5, 1}, [](const Vec3& u) { return u[0]; });
  EXPECT_THROW(resample_lattice(slice, LatticeKind::kBodyCentred), Error);
}

}  // namespace resample_lattice_test
}  // namespace ovoid
