// SPDX-License-Identifier: Apache-2.0
// OpenVDB files, written by its library (tests/vdb/make_vdb.cpp) and read in the process of their
// own. What would make it fail: a voxel's value at another place or of another voxel, a tile or a
// background that is passed over, a transform taken by columns, a lattice that is not the series'.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/points/test_shares.h"
#include "ovoid/io.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"
#include "ovoid/series.h"

#ifdef OVOID_MAKE_VDB
#include <spawn.h>
#include <sys/wait.h>

#include <cstdlib>
#include <memory>
#include <random>

#include "data/scalar_visit.h"
#include "fuzz/targets.h"
#include "io/reader/reader_session.h"
#include "support/where.h"

namespace ovoid::io {
namespace vdb_test {

using testing::ElementsAre;
using testing::HasSubstr;

class VdbFiles : public testing::Test {
 protected:
  void SetUp() override {
    std::string program = OVOID_MAKE_VDB, where = folder.file("");
    char* arguments[] = {program.data(), where.data(), nullptr};
    pid_t pid = -1;
    ASSERT_EQ(::posix_spawn(&pid, program.c_str(), nullptr, nullptr, arguments, environ), 0);
    int status = -1;
    ASSERT_EQ(::waitpid(pid, &status, 0), pid);
    ASSERT_EQ(status, 0);
  }

  Dataset read(const std::string& name, const std::string& array = {},
               const std::string& block = {}) const {
    ReadOptions options;
    options.array = array;
    options.block = block;
    return read_dataset({folder.file(name)}, options);
  }
  std::string error(const std::string& name, const std::string& array = {},
                    const std::string& block = {}) const {
    return error_of([&] { read(name, array, block); });
  }

  TestFolder folder;
};

// A voxel by OpenVDB's own indices.
struct Voxel {
  std::int64_t x, y, z;
  double value = 0;
};

double counted(const Voxel& at) {
  return static_cast<double>(at.x) + 0.5 * static_cast<double>(at.y) +
         0.25 * static_cast<double>(at.z);
}

double sample(const DataArray& array, std::int64_t index, int component = 0) {
  return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(
        data::load_scalar<T>(array.bytes.view.data(), index * array.num_components + component));
  });
}

// Every sample of a component is the value that `expected` has at its place, which is counted from
// `first`, the box's first voxel, whose margin comes before it.
template <typename Expected>
void expect_samples(const Dataset& dataset, const std::string& name, const Index3& first,
                    const Expected& expected, int component = 0) {
  const DataArray& array = dataset.array(name);
  const Index3 dims = dataset.lattice.dims;
  ASSERT_EQ(array.num_tuples, dims[0] * dims[1] * dims[2]);
  std::int64_t index = 0;
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      for (std::int64_t x = 0; x < dims[0]; ++x, ++index) {
        const Voxel at{first[0] + x - 1, first[1] + y - 1, first[2] + z - 1};
        ASSERT_EQ(sample(array, index, component), expected(at))
            << name << " at " << at.x << " " << at.y << " " << at.z;
      }
    }
  }
}

bool is_within(const Voxel& at, const Index3& first, const Index3& last) {
  return at.x >= first[0] && at.x <= last[0] && at.y >= first[1] && at.y <= last[1] &&
         at.z >= first[2] && at.z <= last[2];
}

// Of the grid that most files have: voxels (-3, 2, 0) to (8, 9, 20), 0 elsewhere.
double counted_density(const Voxel& at) {
  return is_within(at, {-3, 2, 0}, {8, 9, 20}) ? counted(at) : 0;
}

void expect_counted(const Dataset& dataset, const std::string& name = {}) {
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(14, 10, 23));
  expect_samples(dataset, name, {-3, 2, 0}, counted_density);
}

TEST_F(VdbFiles, GridsOfAllKindsOfNumbersShareALattice) {
  const Dataset dataset = read("kinds.vdb");
  EXPECT_EQ(dataset.format, "OpenVDB");
  EXPECT_TRUE(dataset.notes.empty()) << dataset.notes.front();
  EXPECT_EQ(dataset.array().name, "density");
  EXPECT_LE((dataset.lattice.world_from_index.linear() - 0.5 * Mat3::Identity()).norm(), 1e-15);
  // Voxel (-4, 1, -1), the first with its margin.
  EXPECT_LE((dataset.lattice.world_from_index.translation() - Vec3(-1, 2.5, 2.5)).norm(), 1e-15);
  expect_counted(dataset, "density");
  const auto in_box = [](const Voxel& at) { return is_within(at, {0, 3, 1}, {2, 5, 4}); };
  const auto sum = [](const Voxel& at) {
    return static_cast<double>(at.x + 10 * at.y + 100 * at.z);
  };
  const auto expect = [&](const char* name, ScalarType type, double background, auto value,
                          int component = 0) {
    SCOPED_TRACE(name);
    EXPECT_EQ(dataset.array(name).type, type);
    expect_samples(
        dataset, name, {-3, 2, 0},
        [&](const Voxel& at) { return in_box(at) ? value(at) : background; }, component);
  };
  using enum ScalarType;
  expect("temperature", kFloat64, 300, [&](const Voxel& at) { return 0.1 * sum(at); });
  expect("number", kInt32, -1, sum);
  expect("large", kInt64, -1, [&](const Voxel& at) { return 0x1p40 + sum(at); });
  expect("inside", kUInt8, 0, [](const Voxel& at) { return at.x != 1 ? 1.0 : 0.0; });
  expect("mask", kUInt8, 0, [](const Voxel&) { return 1.0; });
  for (const auto& [name, type] : {std::pair{"v", kFloat32}, std::pair{"vd", kFloat64}}) {
    EXPECT_EQ(dataset.array(name).num_components, 3);
    expect(name, type, 0, counted, 0);
    expect(
        name, type, 0, [](const Voxel&) { return -2.0; }, 2);
  }
  expect(
      "vi", kInt32, 7, [](const Voxel& at) { return static_cast<double>(at.y); }, 1);
}

TEST_F(VdbFiles, OneGridHasABoxOfItsOwn) {
  const Dataset dataset = read("kinds.vdb", "number");
  ASSERT_EQ(dataset.arrays.size(), 1U);
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(5, 5, 6));
  EXPECT_LE((dataset.lattice.world_from_index.translation() - Vec3(0.5, 3, 3)).norm(), 1e-15);
}

TEST_F(VdbFiles, AreReadHoweverTheyAreStored) {
  for (const char* const name : {"plain.vdb", "zip.vdb", "blosc.vdb", "stream.vdb", "half.vdb"}) {
    SCOPED_TRACE(name);
    expect_counted(read(name));  // exact in 16 bits, too
  }
}

TEST_F(VdbFiles, AreWhereTheirTransformSays) {
  const Dataset dataset = read("affine.vdb");
  expect_counted(dataset);
  Mat3 axes;  // as make_vdb has them, a voxel's three in columns
  axes.col(0) = Vec3(0.5, 0.25, 0);
  axes.col(1) = Vec3(-0.5, 1, 0.125);
  axes.col(2) = Vec3(0, 0.5, 2);
  EXPECT_EQ(dataset.lattice.world_from_index.linear(), axes);
  const Vec3 first = axes * Vec3(-4, 1, -1) + Vec3(4, 5, 6);
  EXPECT_LE((dataset.lattice.world_from_index.translation() - first).norm(), 1e-12);
}

TEST_F(VdbFiles, OfSeveralLatticesOneIsChosen) {
  const Dataset first = read("places.vdb");
  EXPECT_EQ(first.block, "coarse");
  ASSERT_EQ(first.blocks.size(), 3U);
  EXPECT_EQ(first.blocks[1].description, "voxels of 1 x 1 x 1: 'density[1]', 'moved'");
  EXPECT_THAT(first.notes, testing::Contains(HasSubstr("choose with --block")));
  EXPECT_THAT(first.notes, testing::Contains(HasSubstr("frustum are not read: 'density[0]'")));
  expect_counted(first);
  // Whole voxels apart: one lattice, whose box has both.
  const Dataset both = read("places.vdb", {}, "density[1]");
  EXPECT_THAT(both.lattice.dims, ElementsAre(16, 10, 24));
  EXPECT_LE((both.lattice.world_from_index.translation() - Vec3(-4, 1, -2)).norm(), 1e-12);
  expect_samples(both, "density[1]", {-3, 2, -1}, counted_density);
  expect_samples(both, "moved", {-3, 2, -1}, [](const Voxel& at) {
    return counted_density({at.x - 2, at.y, at.z + 1});
  });
  expect_counted(read("places.vdb", "moved"));
  EXPECT_THAT(error("places.vdb", "density[0]"), HasSubstr("unsupported: "));
  EXPECT_THAT(error("frustum.vdb"), HasSubstr("lies in a camera's frustum"));
  EXPECT_THAT(error("places.vdb", {}, "nowhere"), HasSubstr("expected one of 'coarse', 'density"));
  EXPECT_THAT(error("places.vdb", "nothing"), HasSubstr("array 'nothing': not there"));
}

TEST_F(VdbFiles, TilesAndWhatIsNotActiveHaveValues) {
  const Dataset dataset = read("tiles.vdb");
  EXPECT_THAT(dataset.lattice.dims, ElementsAre(42, 11, 10));
  expect_samples(dataset, "tiles", {0, 0, 0}, [](const Voxel& at) {
    if (is_within(at, {16, 0, 0}, {23, 7, 7})) return -2.0;
    return is_within(at, {0, 0, 0}, {39, 8, 7}) ? 4.0 : 1.0;
  });
}

// Within the band the distance is exact but for float rounding, and kernels that pass through the
// samples bend a sphere of 20 voxels by less than a hundredth of one.
TEST_F(VdbFiles, LevelSetsAreDistances) {
  const Dataset dataset = read("sphere.vdb");
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("--mode isosurface --iso 0")));
  const FieldProbe field(Field(make_lattice_field(dataset)));
  const Vec3 middle(1, 2, 3);
  for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0.6, 0, 0.8), Vec3(-1, 1, 1)}) {
    const auto at = [&](double radius) {
      return field.at(middle + radius * way.normalized()).value;
    };
    EXPECT_NEAR(at(5), 0, 0.0025);
    EXPECT_NEAR(at(4.75), -0.25, 0.0025);
    EXPECT_NEAR(at(2), -0.75, 1e-5);  // inside, where no voxel is active
  }
}

TEST_F(VdbFiles, NamesThatGridsShareAreNumbered) {
  const Dataset dataset = read("names.vdb");
  std::vector<std::string> names;
  for (const DataArray& array : dataset.arrays) names.push_back(array.name);
  EXPECT_THAT(names, ElementsAre("density[0]", "density[1]", "values", "shared", "instance"));
  for (const std::string& name : names) expect_counted(dataset, name);
  expect_counted(read("names.vdb", "values"));
}

TEST_F(VdbFiles, ThatHoldNothingAreErrors) {
  EXPECT_THAT(error("empty.vdb"), HasSubstr("has no active voxels in 'empty'"));
  EXPECT_THAT(error("nothing.vdb"), HasSubstr("has no grids"));
}

TEST_F(VdbFiles, BoxesThatMemoryDoesNotHoldAreErrors) {
  const std::string text = error("far.vdb");
  EXPECT_THAT(text, HasSubstr("out-of-memory: "));
  EXPECT_THAT(text, HasSubstr("2 voxels of grid 'far' are active, in a box of "
                              "2000003x1000003x1000003"));
}

TEST_F(VdbFiles, StaggeredGridsAreToldOf) {
  EXPECT_THAT(read("staggered.vdb").notes, ElementsAre(HasSubstr("'v' is staggered")));
}

TEST_F(VdbFiles, PointsAreParticles) {
  for (const char* const name : {"points.vdb", "both.vdb"}) {
    SCOPED_TRACE(name);
    const Dataset dataset = read(name, {}, *name == 'b' ? "points" : "");
    EXPECT_EQ(dataset.kind, DatasetKind::kParticles);
    ASSERT_EQ(dataset.num_positions(), 40);
    // In the order of voxels: the attribute says which point it is.
    for (std::int64_t row = 0; row < 40; ++row) {
      const double i = sample(dataset.array("size"), row);
      const Vec3 place(sample(dataset.positions, row, 0), sample(dataset.positions, row, 1),
                       sample(dataset.positions, row, 2));
      const Vec3 expected(0.25 * i, 1 - 0.125 * i, 0.0625 * i * i);
      EXPECT_LE((place - expected).norm(), 1e-5) << i;  // stored as float within a voxel
      EXPECT_EQ(sample(dataset.array("v"), row, 0), i);
      EXPECT_EQ(sample(dataset.array("v"), row, 2), 1);
    }
  }
  EXPECT_EQ(read("both.vdb").block, "density");
  expect_shares([&](const ReadOptions& options) {
    return read_dataset({folder.file("points.vdb")}, options);
  });
}

// What is active moves, and at last there is nothing: the lattice is that of all steps, whatever
// their metadata say of it.
TEST_F(VdbFiles, StepsShareALattice) {
  std::vector<std::string> paths;
  for (int step = 0; step < 4; ++step)
    paths.push_back(folder.file("step" + std::to_string(step) + ".vdb"));
  const Series series(open_steps(paths));
  for (std::int64_t step = 0; step < 4; ++step) {
    SCOPED_TRACE(step);
    const auto dataset = series.step(step);
    EXPECT_THAT(dataset->lattice.dims, ElementsAre(14, 6, 8));
    EXPECT_LE((dataset->lattice.world_from_index.translation() - Vec3(-0.5, -0.5, -1.5)).norm(),
              1e-15);
    const Index3 first{4 * step, 0, -step};
    expect_samples(*dataset, "density", {0, 0, -2}, [&](const Voxel& at) {
      const bool is_active =
          step < 3 && is_within(at, first, {first[0] + 3, first[1] + 3, first[2] + 3});
      return is_active ? counted(at) : 0;
    });
  }
  // By itself a step has its own.
  EXPECT_THAT(read("step1.vdb").lattice.dims, ElementsAre(6, 6, 6));
}

TEST_F(VdbFiles, StepsOfOtherLatticesAreErrors) {
  const Series series(open_steps({folder.file("step0.vdb"), folder.file("plain.vdb")}));
  series.step(0);
  EXPECT_THAT(error_of([&] { series.step(1); }), HasSubstr("step 1"));
}

TEST_F(VdbFiles, ThatAreCutShortAreErrors) {
  const std::string whole = folder.read("kinds.vdb");
  for (std::size_t size = 16; size < whole.size(); size += whole.size() / 8) {
    folder.write("cut.vdb", whole.substr(0, size));
    EXPECT_THAT(error("cut.vdb"), HasSubstr("is the file truncated?")) << size;
  }
}

// Whatever a byte says, reading ends, with something consistent or one line. OVOID_MUTATIONS=n asks
// for n times as many.
TEST_F(VdbFiles, ThatAreDamagedEndInAnError) {
  OVOID_NOT_UNDER_TSAN();
  const char* const factor = std::getenv("OVOID_MUTATIONS");
  const int count = 40 * (factor == nullptr ? 1 : std::max(1, std::atoi(factor)));
  std::mt19937_64 random(20261127);
  const auto below = [&](std::size_t end) { return static_cast<std::size_t>(random() % end); };
  ReadOptions options;
  const std::string path = folder.file("damaged.vdb");
  options.session = std::make_shared<ReaderSession>(std::vector{path});
  for (const char* const name : {"kinds.vdb", "zip.vdb", "plain.vdb", "points.vdb", "names.vdb"}) {
    const std::string whole = folder.read(name);
    for (int i = 0; i < count; ++i) {
      std::string damaged = whole;
      // Mostly in what says how the rest lies.
      const std::size_t end = i % 3 == 0 ? whole.size() : std::min<std::size_t>(whole.size(), 2000);
      for (std::size_t n = 1 + below(3); n > 0; --n) {
        const std::size_t at = below(end - 4);
        if (below(2) == 0)
          damaged[at] = static_cast<char>(damaged[at] ^ (1 << below(8)));
        else
          for (std::size_t j = 0; j < 4; ++j) damaged[at + j] = static_cast<char>(below(2) * 255);
      }
      folder.write("damaged.vdb", damaged);
      EXPECT_NO_THROW(fuzz::expect_dataset_or_error([&] { return read_dataset({path}, options); }))
          << name << " " << i;
    }
  }
}

}  // namespace vdb_test
}  // namespace ovoid::io

#else

TEST(VdbFiles, NeedOpenVdb) { GTEST_SKIP() << "this build has no OpenVDB"; }

#endif
