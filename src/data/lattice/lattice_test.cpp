// SPDX-License-Identifier: Apache-2.0
#include "ovoid/lattice.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "data/scalar_visit.h"
#include "data/validate.h"
#include "ovoid/error.h"
#include "ovoid/kernels.h"
#include "support/numbers.h"

namespace ovoid {
namespace lattice_test {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The message of the Error(kInvalidArgument) that `call` throws; empty if it throws none.
template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return {};
}

testing::AssertionResult names(const std::string& message, const std::string& word) {
  if (message.find(word) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << message << "' does not name '" << word << "'";
}

// Fails if the tables are not in the order of the enumeration.
TEST(ScalarTypes, SizesAndNamesBelongToTheirTypes) {
  EXPECT_STREQ(name_of(ScalarType::kUInt8), "uint8");
  EXPECT_STREQ(name_of(ScalarType::kInt64), "int64");
  EXPECT_STREQ(name_of(ScalarType::kFloat32), "float32");
  EXPECT_STREQ(name_of(ScalarType::kFloat64), "float64");
  for (int i = 0; i < 10; ++i) {
    const auto type = static_cast<ScalarType>(i);
    data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
      EXPECT_EQ(size_of(type), sizeof(T)) << name_of(type);
      EXPECT_EQ(is_floating(type), std::is_floating_point_v<T>) << name_of(type);
      const std::string name = name_of(type);
      EXPECT_EQ(name.starts_with("uint"), std::is_unsigned_v<T>) << name;
      EXPECT_TRUE(name.ends_with(std::to_string(8 * sizeof(T)))) << name;
    });
  }
}

LatticeGeometry oblique_lattice() {
  LatticeGeometry geometry;
  geometry.dims = {3, 4, 5};
  geometry.world_from_index.linear() << 2, 1, 0,  //
      0, 1, 0,                                    //
      0, 0, -3;
  geometry.world_from_index.translation() = Vec3(10, 20, 30);
  return geometry;
}

TEST(LatticeGeometry, SpacingIsTheLengthOfTheAxes) {
  EXPECT_TRUE(oblique_lattice().spacing().isApprox(Vec3(2, std::sqrt(2.0), 3), 1e-15));
}

// By hand: x from 2 (-1/2) + (-1/2) to 2 (5/2) + 7/2, y from -1/2 to 7/2, z from -3 (9/2) to 3/2,
// from (10, 20, 30) on.
TEST(LatticeGeometry, WorldBoundsHoldTheSamplesCells) {
  const LatticeGeometry geometry = oblique_lattice();
  EXPECT_EQ(geometry.index_bounds().min(), Vec3(-0.5, -0.5, -0.5));
  EXPECT_EQ(geometry.index_bounds().max(), Vec3(2.5, 3.5, 4.5));
  EXPECT_TRUE(geometry.world_bounds().min().isApprox(Vec3(8.5, 19.5, 16.5), 1e-15));
  EXPECT_TRUE(geometry.world_bounds().max().isApprox(Vec3(18.5, 23.5, 31.5), 1e-15));
}

LatticeGeometry cube_of(std::int64_t n) {
  LatticeGeometry geometry;
  geometry.dims = {n, n, n};
  return geometry;
}

// Fails if counts are rounded in another way, or the lattice is coarser or finer than the one that
// keeps the same signals.
TEST(BodyCentred, HasTheCountsOfThePublishedTables) {
  EXPECT_EQ(body_centred_like(cube_of(128)).dims, (Index3{91, 91, 181}));
  EXPECT_EQ(body_centred_like(cube_of(256)).dims, (Index3{181, 181, 362}));
  EXPECT_EQ(body_centred_like(cube_of(128), 2.0).dims, (Index3{46, 46, 91}));
  EXPECT_DOUBLE_EQ(body_centred_like(cube_of(128)).spacing()[0], 1.0);
  EXPECT_DOUBLE_EQ(body_centred_like(cube_of(128), 2.0).spacing()[2], 2.0);
  EXPECT_THROW(body_centred_like(body_centred_like(cube_of(8))), Error);
  EXPECT_THROW(body_centred_like(cube_of(8), 0), Error);
}

// Fails if layers do not alternate, or lie at another distance: every sample inside has eight
// neighbours at sqrt(3/2) T and six at sqrt(2) T.
TEST(BodyCentred, SamplesHaveTheNeighboursOfTheLattice) {
  const LatticeGeometry lattice = body_centred_like(cube_of(10));
  for (const Index3& middle : {Index3{3, 3, 6}, Index3{3, 3, 7}}) {
    const Vec3 at = lattice.world_from_index * lattice.index_position(middle);
    int num_near = 0;
    int num_next = 0;
    for (std::int64_t k = 0; k < lattice.dims[2]; ++k) {
      for (std::int64_t j = 0; j < lattice.dims[1]; ++j) {
        for (std::int64_t i = 0; i < lattice.dims[0]; ++i) {
          const Vec3 other = lattice.world_from_index * lattice.index_position({i, j, k});
          const double square = (other - at).squaredNorm();
          if (std::abs(square - 1.5) < 1e-9) ++num_near;
          if (std::abs(square - 2.0) < 1e-9) ++num_next;
        }
      }
    }
    EXPECT_EQ(num_near, 8);
    EXPECT_EQ(num_next, 6);
  }
}

// Fails if a sublattice's samples are not those of its layers.
TEST(BodyCentred, SublatticesShareTheLayers) {
  LatticeGeometry lattice;
  lattice.kind = LatticeKind::kBodyCentred;
  lattice.dims = {5, 4, 7};
  EXPECT_EQ(lattice.dims_of(0), (Index3{5, 4, 4}));
  EXPECT_EQ(lattice.dims_of(1), (Index3{5, 4, 3}));
  EXPECT_EQ(lattice.index_position({2, 1, 3}), Vec3(2.5, 1.5, 1.5));
  EXPECT_EQ(lattice.index_position({2, 1, 4}), Vec3(2, 1, 2));
  EXPECT_EQ(lattice.index_bounds().min(), Vec3(-0.25, -0.25, -0.25));
  EXPECT_EQ(lattice.index_bounds().max(), Vec3(4.75, 3.75, 3.25));
}

TEST(ValidateGeometry, AcceptsWhatCanBeDrawn) {
  EXPECT_NO_THROW(data::validate_geometry(oblique_lattice()));
  LatticeGeometry voxel;
  voxel.dims = {1, 1, 1};
  EXPECT_NO_THROW(data::validate_geometry(voxel));
  voxel.world_from_index.linear() *= 1e-90;  // tiny, but as good as any
  EXPECT_NO_THROW(data::validate_geometry(voxel));
}

TEST(ValidateGeometry, NamesWhatIsWrong) {
  const auto with = [](const auto& change) {
    LatticeGeometry geometry = oblique_lattice();
    change(geometry);
    return refusal([&] { data::validate_geometry(geometry); });
  };
  EXPECT_TRUE(names(with([](auto& g) { g.dims[1] = 0; }), "dims[1] = 0"));
  EXPECT_TRUE(names(with([](auto& g) { g.dims[2] = -7; }), "dims[2] = -7"));
  const std::int64_t huge = std::int64_t{1} << 62;  // the product overflows 64 bits
  EXPECT_TRUE(names(with([=](auto& g) { g.dims = {huge, huge, huge}; }), "at most"));
  EXPECT_TRUE(names(with([](auto& g) { g.world_from_index.matrix()(0, 3) = kNan; }), "finite"));
  EXPECT_TRUE(
      names(with([](auto& g) { g.world_from_index.matrix()(2, 2) = kInfinity; }), "finite"));
  EXPECT_TRUE(
      names(with([](auto& g) { g.world_from_index.linear().col(2).setZero(); }), "spacing[2] = 0"));
  EXPECT_TRUE(
      names(with([](auto& g) { g.world_from_index.linear().col(0) *= 1e-300; }), "spacing[0]"));
  EXPECT_TRUE(names(with([](auto& g) { g.world_from_index.linear().col(2) *= 1e14; }),
                    "differ by a factor"));
  EXPECT_TRUE(names(with([](auto& g) {
                      g.world_from_index.linear().col(1) = 3 * g.world_from_index.linear().col(0);
                    }),
                    "plane"));
}

TEST(ValidateKernel, NamesWhatIsWrong) {
  const auto with = [](double sigma, double cutoff) {
    return refusal([&] { data::validate_kernel({sigma, cutoff}); });
  };
  EXPECT_EQ(with(0.5, 4), "");
  EXPECT_EQ(with(LatticeKernel::kMinSigma, 5), "");
  EXPECT_EQ(with(LatticeKernel::kMaxSigma, LatticeKernel::kMaxCutoff), "");
  for (const double sigma : {0.0, -0.5, 0.09, 4.1, kNan, kInfinity}) {
    EXPECT_TRUE(names(with(sigma, 4), "sigma = "));
  }
  for (const double cutoff : {0.0, -4.0, 16.5, kNan, kInfinity}) {
    EXPECT_TRUE(names(with(0.5, cutoff), "cutoff = "));
  }
  EXPECT_TRUE(names(with(0.1, 4.9), "sigma * cutoff"));
}

TEST(ErrorCodes, HaveDistinctNames) {
  EXPECT_STREQ(name_of(ErrorCode::kInvalidArgument), "invalid-argument");
  EXPECT_STREQ(name_of(ErrorCode::kFileNotFound), "file-not-found");
  EXPECT_STREQ(name_of(ErrorCode::kFileFormat), "file-format");
  EXPECT_STREQ(name_of(ErrorCode::kUnsupported), "unsupported");
  EXPECT_STREQ(name_of(ErrorCode::kFileWrite), "file-write");
  EXPECT_STREQ(name_of(ErrorCode::kOutOfMemory), "out-of-memory");
  EXPECT_STREQ(name_of(ErrorCode::kCancelled), "cancelled");
}

}  // namespace lattice_test
}  // namespace ovoid
