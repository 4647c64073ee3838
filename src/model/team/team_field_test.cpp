// SPDX-License-Identifier: Apache-2.0
// Fields that several processes make together, against the one that one process makes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "data/kernels/some_kernels.h"
#include "model/lattice/noise.h"
#include "model/team/test_teams.h"
#include "model/test_datasets.h"
#include "ovoid/look.h"

namespace ovoid::model {
namespace team_field_test {

using ovoid::testing::Room;
using ovoid::testing::run_as_team;

// Two crowds and a few that lie far from both.
std::vector<Vec3> crowds(int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double size = i % 50 == 0 ? 5 : i % 2 == 0 ? 0.3 : 0.02;
    const Vec3 middle = i % 2 == 0 ? Vec3(1, 2, 3) : Vec3(1.4, 2.2, 2.9);
    const Vec3 offset(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    points.push_back(middle + size * offset.norm() * offset);
  }
  return points;
}

void add_column(Dataset& dataset, const char* name, const std::function<float(std::size_t)>& at) {
  std::vector<float> values;
  for (std::size_t i = 0; i < static_cast<std::size_t>(dataset.num_positions()); ++i)
    values.push_back(at(i));
  dataset.arrays.push_back(array_of_numbers(name, 1, std::move(values)));
}

DataArray rows_of(const DataArray& array, std::int64_t first, std::int64_t last) {
  const std::size_t row =
      size_of(array.type) * static_cast<std::size_t>(std::max(array.num_components, 1));
  DataArray rows = array;
  rows.num_tuples = last - first;
  rows.bytes.view = array.bytes.view.subspan(static_cast<std::size_t>(first) * row,
                                             static_cast<std::size_t>(last - first) * row);
  return rows;
}

Dataset share_of(const Dataset& whole, int number, int count) {
  const std::int64_t total = whole.num_positions();
  const std::int64_t first = total * number / count, last = total * (number + 1) / count;
  Dataset share = whole;
  share.positions = rows_of(whole.positions, first, last);
  for (DataArray& array : share.arrays) array = rows_of(array, first, last);
  share.share = DatasetShare{first, total};
  return share;
}

void expect_same_by_rows(const Dataset& whole, const KernelModelOptions& options = {}) {
  expect_same_together(
      whole, [&](int number, int count) { return share_of(whole, number, count); }, options);
}

std::vector<Made> made_by_rows(const Dataset& whole, int count, const KernelModelOptions& options) {
  return made_together([&](int number, int of) { return share_of(whole, number, of); }, count,
                       options);
}

TEST(TeamField, ParticlesWithSizesFromTheirNeighbors) {
  expect_same_by_rows(points_dataset(DatasetKind::kParticles, crowds(5000, 1)));
}

TEST(TeamField, DensityOfParticles) {
  Dataset dataset = points_dataset(DatasetKind::kParticles, crowds(5000, 2));
  expect_same_by_rows(dataset, {.is_density = true});
  add_column(dataset, "mass", [](std::size_t i) { return 1e-3F + 1e-4F * (i % 7); });
  expect_same_by_rows(dataset);
}

TEST(TeamField, ParticlesWithSizesAndVolumes) {
  Dataset dataset = points_dataset(DatasetKind::kParticles, crowds(1500, 3));
  add_column(dataset, "h", [](std::size_t i) { return 0.004F * (1 + i % 5); });
  expect_same_by_rows(dataset, {.array = "v"});
  add_column(dataset, "mass", [](std::size_t i) { return 1.0F + i % 3; });
  add_column(dataset, "rho", [](std::size_t i) { return 1e5F * (1 + i % 11); });
  expect_same_by_rows(dataset, {.array = "v", .color_array = "mass"});
}

TEST(TeamField, PeriodicBox) {
  Dataset dataset = points_dataset(DatasetKind::kParticles, crowds(3000, 4));
  dataset.periodic_box = Bounds3(Vec3(0.8, 1.9, 2.5), Vec3(1.5, 2.6, 3.4));
  expect_same_by_rows(dataset);
}

// Heaps have one kernel each; what is missing has none.
TEST(TeamField, HeapsAndWhatIsMissing) {
  std::vector<Vec3> points = crowds(3000, 5);
  for (std::size_t i = 100; i < 400; ++i) points[7 * i] = points[700];
  points[30][1] = std::nan("");
  Dataset dataset = points_dataset(DatasetKind::kParticles, points);
  dataset.arrays.clear();
  add_column(dataset, "v", [](std::size_t i) {
    return i % 100 == 17 ? std::nanf("") : static_cast<float>(i % 13);
  });
  expect_same_by_rows(dataset);
}

TEST(TeamField, StoredKernels) {
  const KernelField field = make_kernel_field(
      points_dataset(DatasetKind::kParticles, crowds(3000, 6)), {.anisotropic = true});
  expect_same_by_rows(make_kernel_dataset(field));
}

// Fewer rows than processes, and a column that varies from share to share alone.
TEST(TeamField, FewRows) {
  Dataset dataset = points_dataset(DatasetKind::kParticles, crowds(5, 7));
  dataset.arrays.insert(dataset.arrays.begin(), dataset.arrays[0]);
  dataset.arrays[0].name = "first";
  dataset.arrays[0] = array_of_numbers("first", 1, std::vector<float>{1, 2, 3, 4, 5});
  expect_same_by_rows(dataset);
  expect_same_by_rows(share_of(dataset, 0, 5));  // one row
}

// Each keeps its share; the others' bricks are fetched. Neighbours are asked for in several rounds.
TEST(TeamField, KeepsAShare) {
  const Dataset whole = points_dataset(DatasetKind::kParticles, crowds(120'000, 8));
  const KernelField alone = make_kernel_field(whole);
  Room room(4);
  const auto fields = run_as_team(room, [&](const std::shared_ptr<KernelTeam>& team) {
    const Dataset share = share_of(whole, team->number(), 4);
    return make_team_field(share, {{.array = "v"}, 1}, team);
  });
  expect_same(fields[1], alone);
  const auto limit = 0.6 * static_cast<double>(alone.source().resident_bytes());
  for (const KernelField& field : fields)
    EXPECT_LT(static_cast<double>(field.source().resident_bytes()), limit);
}

// Centres and values of every `stride`-th kernel.
std::vector<Eigen::Vector4d> every_kernel(const KernelSource& source, std::int64_t stride) {
  std::vector<Eigen::Vector4d> kernels;
  data::for_every_kernel(
      source, stride, [&](const KernelBrick& brick, const KernelView& view, std::int32_t i) {
        kernels.emplace_back();
        kernels.back() << brick.origin + data::offset_of(view, i), view.value[0][i];
      });
  return kernels;
}

// Which one process counts out of all of them. Bricks have fewer than some of the strides, and a
// process as few as none.
TEST(TeamField, EverySoManyth) {
  const Dataset whole = points_dataset(DatasetKind::kParticles, crowds(3000, 11));
  const KernelField alone = make_kernel_field(whole);
  const std::vector<Eigen::Vector4d> all = every_kernel(alone.source(), 1);
  for (const int count : {1, 3, 7}) {
    Room room(count);
    const auto fields = run_as_team(room, [&](const std::shared_ptr<KernelTeam>& team) {
      return make_team_field(share_of(whole, team->number(), count), {}, team);
    });
    for (const std::int64_t stride : {2, 5, 64, 1000, 2999, 4000}) {
      SCOPED_TRACE(::testing::Message() << count << " processes, every " << stride << "th");
      const std::vector<Eigen::Vector4d> found = every_kernel(fields.back().source(), stride);
      ASSERT_EQ(found.size(), (all.size() + stride - 1) / stride);
      for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_LE((found[i] - all[i * stride]).norm(), 1e-6 * all[i * stride].norm());
    }
  }
}

// To make the field and to choose a look, each process looks at the kernels around its part alone,
// and at every so many-th of all.
TEST(TeamField, LooksAreMadeTogether) {
  constexpr int kProcesses = 4;
  Random random(12);
  std::vector<Vec3> points;
  for (int i = 0; i < 150'000; ++i)
    points.emplace_back(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1));
  Dataset whole = points_dataset(DatasetKind::kParticles, points);
  add_column(whole, "h", [](std::size_t) { return 0.02F; });
  KernelModelOptions options;
  options.is_density = true;
  const Look alone = default_look(Field(make_kernel_field(whole, options)));
  Room room(kProcesses);
  const auto looks = run_as_team(room, [&](const std::shared_ptr<KernelTeam>& team) {
    KernelModelReport report;
    const KernelField field =
        make_team_field(share_of(whole, team->number(), kProcesses), {options, 1}, team, &report);
    return default_look(Field(field));
  });
  for (const Look& look : looks) {
    ASSERT_EQ(look.transfer_function.opacities.size(), alone.transfer_function.opacities.size());
    for (std::size_t i = 0; i < alone.transfer_function.opacities.size(); ++i)
      EXPECT_NEAR(look.transfer_function.opacities[i].x, alone.transfer_function.opacities[i].x,
                  1e-3 * alone.transfer_function.hi());
  }
  // Twice what it is if each fetches all of the others' once.
  constexpr std::int64_t kColumns = 3 + 1 + 1 + 1;
  const auto num_bytes = std::ssize(points) * kColumns * std::int64_t{sizeof(float)};
  EXPECT_LT(room.num_fetched_bytes(), 2 * (kProcesses - 1) * num_bytes);
  EXPECT_GT(room.num_fetched_bytes(), 0);
}

TEST(TeamField, OneThatFailsEndsAll) {
  Dataset whole = points_dataset(DatasetKind::kParticles, crowds(100, 9));
  add_column(whole, "h", [](std::size_t i) { return i == 70 ? 0.0F : 1.0F; });
  try {
    made_by_rows(whole, 3, {});
    ADD_FAILURE() << "was accepted";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "h[70] = 0: must be > 0");
  }
}

TEST(TeamField, RefusesWhatCannotBeShared) {
  const Dataset whole = points_dataset(DatasetKind::kParticles, crowds(100, 10));
  EXPECT_THROW(made_by_rows(whole, 2, {.anisotropic = true}), Error);
  Room room(1);
  EXPECT_THROW(run_as_team(room,
                           [&](const std::shared_ptr<KernelTeam>& team) {
                             return make_team_field(whole, {}, team);
                           }),
               Error);
}

}  // namespace team_field_test
}  // namespace ovoid::model
