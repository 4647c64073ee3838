// SPDX-License-Identifier: Apache-2.0
// Coarse fields of lattices.
#include "ovoid/coarse.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "data/lattice/resident_lattice.h"
#include "ovoid/camera.h"
#include "ovoid/error.h"
#include "ovoid/look.h"
#include "ovoid/model.h"
#include "ovoid/renderer.h"
#include "support/volumes.h"
#include "support/where.h"

namespace ovoid {
namespace coarse_test {

using test::FieldSetup;
using test::make_field;

constexpr double kNoSample = std::numeric_limits<double>::quiet_NaN();

template <class T>
LatticeField stored_field(const LatticeGeometry& geometry, ScalarType type,
                          const std::vector<T>& numbers, const FieldSetup& setup = {}) {
  const auto owner = std::make_shared<std::vector<T>>(numbers);
  ResidentLatticeOptions options;
  options.value_scale = setup.value_scale;
  options.value_offset = setup.value_offset;
  const Bytes bytes{owner, std::as_bytes(std::span<const T>(*owner))};
  return {std::make_shared<ResidentLattice>(geometry, type, bytes, options), setup.kernel,
          setup.reconstruction};
}

LatticeField coarser(const Field& field, const CoarseOptions& options = {}) {
  return *coarse_field(field, options).lattice();
}

// Of a coarse field, which is one array in memory.
template <class T>
std::vector<T> numbers_in(const LatticeField& field) {
  const BrickView view = field.source().acquire(0, 0, 0, 0.0);
  const auto* const data = static_cast<const T*>(view.data);
  return {data, data + field.num_kernels()};
}

std::vector<std::byte> bytes_in(const LatticeField& field) {
  const BrickView view = field.source().acquire(0, 0, 0, 0.0);
  std::vector<std::byte> bytes(static_cast<std::size_t>(field.num_kernels()) * size_of(view.type));
  std::memcpy(bytes.data(), view.data, bytes.size());
  return bytes;
}

// Calls body(place in the world, value) for every sample of a coarse field of floats.
template <class Body>
void for_coarse_samples(const LatticeField& field, const Body& body) {
  const LatticeGeometry& geometry = field.geometry();
  const std::vector<float> numbers = numbers_in<float>(field);
  std::size_t at = 0;
  for (std::int64_t k = 0; k < geometry.dims[2]; ++k) {
    for (std::int64_t j = 0; j < geometry.dims[1]; ++j) {
      for (std::int64_t i = 0; i < geometry.dims[0]; ++i)
        body(geometry.world_from_index * geometry.index_position({i, j, k}),
             numbers[at++] * field.source().value_scale() + field.source().value_offset());
    }
  }
}

// Fails if a mean takes other samples than its 2 x 2 x 2, or is rounded but to the nearest, to even
// half-way.
template <class T>
void expect_means(ScalarType type) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> any(std::numeric_limits<T>::lowest(),
                                         std::numeric_limits<T>::max());
  LatticeGeometry geometry;
  geometry.dims = {10, 6, 14};
  std::vector<T> numbers(static_cast<std::size_t>(num_samples(geometry.dims)));
  for (T& number : numbers) number = static_cast<T>(any(random));
  FieldSetup setup;
  setup.value_scale = -0.5;
  setup.value_offset = 3;
  const LatticeField field = stored_field(geometry, type, numbers, setup);
  const LatticeField coarse = coarser(field);
  EXPECT_EQ(coarse.source().acquire(0, 0, 0, 0.0).type, type);
  EXPECT_EQ(coarse.source().value_scale(), -0.5);
  EXPECT_EQ(coarse.source().value_offset(), 3);
  EXPECT_EQ(coarse.kernel(), field.kernel());
  EXPECT_EQ(coarse.value_range().lo, field.value_range().lo);
  EXPECT_EQ(coarse.value_range().hi, field.value_range().hi);
  EXPECT_EQ(coarse.default_sampling_distance(), 2 * field.default_sampling_distance());
  ASSERT_EQ(coarse.geometry().dims, (Index3{5, 3, 7}));
  const std::vector<T> means = numbers_in<T>(coarse);
  std::size_t at = 0;
  for (std::int64_t k = 0; k < 14; k += 2) {
    for (std::int64_t j = 0; j < 6; j += 2) {
      for (std::int64_t i = 0; i < 10; i += 2) {
        double sum = 0;
        for (std::int64_t n = 0; n < 8; ++n)
          sum += numbers[static_cast<std::size_t>((i + n % 2) + 10 * (j + n / 2 % 2) +
                                                  60 * (k + n / 4))];
        EXPECT_EQ(means[at++], static_cast<T>(std::nearbyint(sum / 8)));
      }
    }
  }
}

TEST(CoarseLattice, SamplesAreTheMeansOfEight) {
  expect_means<std::uint8_t>(ScalarType::kUInt8);
  expect_means<std::int8_t>(ScalarType::kInt8);
  expect_means<std::uint16_t>(ScalarType::kUInt16);
  expect_means<std::int16_t>(ScalarType::kInt16);
}

// Fails if weights do not add up to one, on axes of even and odd size and of one sample.
TEST(CoarseLattice, AConstantStaysConstantAndBoundsAreKept) {
  for (const Index3& dims : {Index3{8, 8, 8}, {9, 8, 7}, {1, 5, 2}, {3, 1, 1}, {33, 21, 17}}) {
    for (const auto how : {Reconstruction::kNormalized, Reconstruction::kSum}) {
      FieldSetup setup;
      setup.world_from_index = test::oblique_axes();
      setup.reconstruction = how;
      const LatticeField field = test::constant_field(dims, 0.1, setup);
      const LatticeField coarse = coarser(field);
      EXPECT_EQ(coarse.reconstruction(), how);
      for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(coarse.geometry().dims[a], (dims[a] + 1) / 2);
      // Doubles of some tens: 1e-12 is a thousand times their rounding.
      const Bounds3 old = field.world_bounds(), bounds = coarse.world_bounds();
      EXPECT_LT((bounds.min() - old.min()).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_LT((bounds.max() - old.max()).cwiseAbs().maxCoeff(), 1e-12);
      for (const float number : numbers_in<float>(coarse)) EXPECT_EQ(number, 0.1F);
    }
  }
}

// Fails if samples come to lie beside what they are the mean of. Of n samples, n odd, a part is 2n
// / (n + 1) long, and the mean of the staircase of cells over it differs from the ramp by 1 / (2n)
// of a spacing at most: over two spacings the difference is zero, over the 2 / (n + 1) that are
// left out it is 1/2 at most.
TEST(CoarseLattice, ARampStaysARamp) {
  const auto ramp = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return 3.0 * static_cast<double>(i) - 2.0 * static_cast<double>(j) + static_cast<double>(k);
  };
  for (const Index3& dims : {Index3{12, 8, 20}, {13, 9, 5}}) {
    FieldSetup setup;
    setup.world_from_index = test::oblique_axes();
    const LatticeField field = make_field(dims, ramp, setup);
    double bound = 1e-5;  // float32 of values up to 50
    if (dims[0] % 2 == 1) bound += 3 / (2.0 * 13) + 2 / (2.0 * 9) + 1 / (2.0 * 5);
    const Affine3 index_from_world = test::oblique_axes().inverse();
    for_coarse_samples(coarser(field), [&](const Vec3& world, double value) {
      const Vec3 u = index_from_world * world;
      EXPECT_NEAR(value, 3 * u[0] - 2 * u[1] + u[2], bound);
    });
  }
}

// The integral of a sum: samples that exist, times the cell.
double lattice_mass(const LatticeField& field) {
  double sum = 0;
  const BrickSource& source = field.source();
  const LatticeGeometry& geometry = field.geometry();
  const std::int64_t edge = source.brick_edge();
  for (std::int64_t k = 0; k < geometry.dims[2]; ++k) {
    for (std::int64_t j = 0; j < geometry.dims[1]; ++j) {
      for (std::int64_t i = 0; i < geometry.dims[0]; ++i) {
        const BrickView view =
            source.acquire(i / edge, j / edge, k / geometry.num_sublattices() / edge, 0.0);
        const auto number = static_cast<const float*>(
            view.data)[(i - view.lo[0]) + (j - view.lo[1]) * view.stride_y +
                       (k - view.lo[2]) * view.stride_z];
        if (std::isfinite(number)) sum += number * source.value_scale() + source.value_offset();
      }
    }
  }
  return sum * std::abs(geometry.world_from_index.linear().determinant()) / geometry.density();
}

// Fails if a sample of a sum's lattice counts more or less than once, holes and odd sizes included,
// or if a missing sample counts as the stored number 0 and not as the value 0.
TEST(CoarseLattice, TheIntegralOfASumIsKept) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(0, 1);
  for (const Index3& dims : {Index3{16, 12, 8}, {17, 11, 9}, {5, 1, 3}}) {
    for (const bool has_holes : {false, true}) {
      FieldSetup setup;
      setup.reconstruction = Reconstruction::kSum;
      setup.value_scale = 2;
      setup.value_offset = 7;
      const LatticeField field = make_field(
          dims,
          [&](std::int64_t, std::int64_t, std::int64_t) {
            return has_holes && any(random) < 0.3 ? kNoSample : any(random);
          },
          setup);
      const LatticeField coarse = coarser(field);
      // Rounding of floats, 6e-8 each.
      EXPECT_NEAR(lattice_mass(coarse) / lattice_mass(field), 1, 1e-6);
      EXPECT_NEAR(lattice_mass(coarser(coarse)) / lattice_mass(field), 1, 1e-6);
    }
  }
}

// Fails if half of the samples are too few or less than half enough, or if what is missing counts.
TEST(CoarseLattice, AMeanIsOfTheSamplesThatExist) {
  const auto with_missing = [](std::int64_t count, Reconstruction how) {
    FieldSetup setup;
    setup.reconstruction = how;
    const LatticeField field = make_field(
        {2, 2, 4},
        [count](std::int64_t i, std::int64_t j, std::int64_t k) {
          const std::int64_t at = i + 2 * j + 4 * k;
          return at < count ? kNoSample : static_cast<double>(at);
        },
        setup);
    return numbers_in<float>(coarser(field))[0];
  };
  EXPECT_EQ(with_missing(0, Reconstruction::kNormalized), 3.5F);
  EXPECT_EQ(with_missing(4, Reconstruction::kNormalized), 5.5F);
  EXPECT_TRUE(std::isnan(with_missing(5, Reconstruction::kNormalized)));
  EXPECT_EQ(with_missing(5, Reconstruction::kSum), (5.0F + 6 + 7) / 8);
  EXPECT_TRUE(std::isnan(with_missing(8, Reconstruction::kSum)));
}

// Fails if bricks, which hold samples of their own here, are put together wrongly.
TEST(CoarseLattice, BricksAreOneLattice) {
  for (const LatticeKind kind : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
    for (const Index3& dims : {Index3{40, 26, 33}, {150, 9, 8}}) {
      std::vector<std::vector<std::byte>> results;
      for (const int edge : {4, 8, 32}) {
        FieldSetup setup;
        setup.brick_edge = edge;
        setup.lattice = kind;
        results.push_back(bytes_in(coarser(make_field(
            dims,
            [](std::int64_t i, std::int64_t j, std::int64_t k) {
              return i % 7 == 3 && j % 3 == 0
                         ? kNoSample
                         : std::sin(static_cast<double>(3 * i + 7 * j - 2 * k));
            },
            setup))));
      }
      EXPECT_EQ(results[0], results[1]);
      EXPECT_EQ(results[0], results[2]);
    }
  }
}

// Fails if the shares of a cell's neighbours do not add up to one, or lie to one side.
TEST(CoarseLattice, BodyCentredRampsStayRampsInside) {
  FieldSetup setup;
  setup.lattice = LatticeKind::kBodyCentred;
  const auto ramp = [](const Vec3& u) { return 5 - 3 * u[0] + 2 * u[1] + u[2]; };
  LatticeGeometry geometry;
  geometry.kind = LatticeKind::kBodyCentred;
  const LatticeField field = make_field(
      {12, 13, 25},
      [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        return ramp(geometry.index_position({i, j, k}));
      },
      setup);
  const LatticeField coarse = coarser(field);
  EXPECT_EQ(coarse.geometry().kind, LatticeKind::kBodyCentred);
  EXPECT_EQ(coarse.geometry().dims, (Index3{6, 7, 13}));
  EXPECT_EQ(coarse.default_sampling_distance(), 2 * field.default_sampling_distance());
  const Bounds3 inside(Vec3(1, 1, 1), Vec3(10.5, 11.5, 11));
  int count = 0;
  for_coarse_samples(coarse, [&](const Vec3& at, double value) {
    if (!inside.contains(at)) return;
    ++count;
    EXPECT_NEAR(value, ramp(at), 1e-5);
  });
  EXPECT_GT(count, 200);
}

// Fails if what one sample is shared among takes more or less than it has.
TEST(CoarseLattice, BodyCentredMassIsKeptInside) {
  for (const Index3& peak : {Index3{4, 4, 8}, {4, 4, 9}, {5, 4, 8}, {5, 5, 10}, {5, 5, 8}}) {
    FieldSetup setup;
    setup.lattice = LatticeKind::kBodyCentred;
    setup.reconstruction = Reconstruction::kSum;
    const LatticeField field = make_field(
        {10, 10, 20},
        [&](std::int64_t i, std::int64_t j, std::int64_t k) {
          return Index3{i, j, k} == peak ? 1.0 : 0.0;
        },
        setup);
    EXPECT_NEAR(lattice_mass(coarser(field)), lattice_mass(field), 1e-7);
  }
}

// Fails if tasks share anything they write.
TEST(CoarseLattice, ThreadsDoNotMatter) {
  const LatticeField field =
      make_lattice_field(make_sample("marschner-lobb", {.size = {65, 64, 63}}));
  EXPECT_EQ(bytes_in(coarser(field, {.threads = 1})), bytes_in(coarser(field, {.threads = 7})));
}

TEST(CoarseLattice, ProgressRisesToOne) {
  const LatticeField field =
      make_lattice_field(make_sample("marschner-lobb", {.size = {64, 64, 64}}));
  double last = 0;
  coarse_field(field, {.progress = [&](double fraction) {
                 EXPECT_GT(fraction, last);
                 last = fraction;
               }});
  EXPECT_EQ(last, 1);
}

TEST(CoarseLattice, RefusesAndStops) {
  const LatticeField field = test::constant_field({8, 8, 8}, 1);
  const auto code_of = [&](const CoarseOptions& options) {
    try {
      coarse_field(field, options);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kFileWrite;
  };
  EXPECT_EQ(code_of({.length = -1}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code_of({.length = kNoSample}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code_of({.threads = -1}), ErrorCode::kInvalidArgument);
  std::stop_source stopped;
  stopped.request_stop();
  EXPECT_EQ(code_of({.stop = stopped.get_token()}), ErrorCode::kCancelled);
}

// A picture where a pixel is 2.7 spacings wide, against the whole field's. Measured: 29.0 dB. Of
// the whole field, too, the kernels are as wide as the pixel, so what differs is that the sheets
// are twice as far apart, which alone costs all beyond 29.7 dB, and that samples are means, 31.0 dB
// on sheets as near as the whole field's. What lies one spacing beside has 20.0.
// The published kernel: coefficients of a prefiltered field are averaged, which loses 1.7 dB more.
TEST(CoarseLattice, FromFarItLooksTheSame) {
  OVOID_NOT_UNDER_TSAN();
  LatticeModelOptions published;
  published.kernel = LatticeKernel{};
  const LatticeField field =
      make_lattice_field(make_sample("head", {.size = {96, 96, 96}}), published);
  Look look = default_look(field);
  look.unit_distance = default_unit_distance(field);
  Camera camera = default_camera(field.world_bounds());
  RenderOptions options;
  options.width = options.height = 64;
  Renderer renderer(Backend::kCpu);
  const Image full = renderer.render({field, look}, camera, options).image;
  const Field coarse = coarse_field(field);
  constexpr double kBound = 28;
  EXPECT_GT(psnr(full, renderer.render({coarse, look}, camera, options).image), kBound);
  const Vec3 aside(field.default_sampling_distance(), 0, 0);
  camera.position += aside;
  camera.focal_point += aside;
  EXPECT_LT(psnr(full, renderer.render({coarse, look}, camera, options).image), kBound);
}

}  // namespace coarse_test
}  // namespace ovoid
