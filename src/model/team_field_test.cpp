// SPDX-License-Identifier: Apache-2.0
// Fields that several processes make together, against the one that one process makes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "data/kernel_shape.h"
#include "data/some_kernels.h"
#include "model/noise.h"
#include "model/test_datasets.h"
#include "ovoid/kernel_team.h"
#include "ovoid/look.h"
#include "ovoid/model.h"
#include "support/thread_team.h"

namespace ovoid::model {
namespace {

using testing::Room;
using testing::run_as_team;

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

struct Made {
  KernelField field;
  KernelModelReport report;
};

std::vector<Made> made_together(const Dataset& whole, int count,
                                const KernelModelOptions& options) {
  Room room(count);
  return run_as_team(room, [&](const std::shared_ptr<KernelTeam>& team) {
    Dataset share = share_of(whole, team->number(), count);
    agree_on_array(share, *team);
    Made made;
    made.field = make_team_field(share, {options, 1 << 20}, team, &made.report);
    return made;
  });
}

// One after the other, in the order of the bricks.
void expect_same(const KernelField& field, const KernelField& expected) {
  const KernelSource& a = field.source();
  const KernelSource& b = expected.source();
  ASSERT_EQ(a.num_kernels(), b.num_kernels());
  ASSERT_EQ(a.num_bricks(), b.num_bricks());
  for (std::int64_t i = 0; i < a.num_bricks(); ++i) {
    const KernelBrick& brick = a.brick(i);
    const KernelBrick& other = b.brick(i);
    ASSERT_EQ(brick.count, other.count) << "brick " << i;
    ASSERT_EQ(brick.origin, other.origin);
    const double sigma = static_cast<double>(other.least_sigma);
    ASSERT_LE((brick.support.min() - other.support.min()).norm(), 1e-4 * sigma);
    ASSERT_LE((brick.cells.max() - other.cells.max()).norm(), 1e-4 * sigma);
    const KernelView view = a.acquire(i, 0), wanted = b.acquire(i, 0);
    ASSERT_EQ(view.count, wanted.count);
    for (std::int32_t k = 0; k < view.count; ++k) {
      ASSERT_EQ(data::offset_of(view, k), data::offset_of(wanted, k));
      const auto shape = data::shape_numbers(view, a.shape(), k);
      const auto other_shape = data::shape_numbers(wanted, b.shape(), k);
      for (std::size_t c = 0; c < 6; ++c)
        ASSERT_NEAR(shape[c], other_shape[c], 1e-5 * std::abs(other_shape[0]));
      ASSERT_NEAR(data::weight_of(view, k) / data::weight_of(wanted, k), 1, 1e-4);
      for (std::size_t v = 0; v < a.attributes().size(); ++v)
        ASSERT_NEAR(view.value[v][k], wanted.value[v][k], 1e-5 * std::abs(wanted.value[v][k]));
    }
  }
  const auto expect_range = [](const ValueRange& range, const ValueRange& other) {
    EXPECT_NEAR(range.lo, other.lo, 1e-4 * std::abs(other.hi));
    EXPECT_NEAR(range.hi, other.hi, 1e-4 * std::abs(other.hi));
  };
  expect_range(field.value_range(), expected.value_range());
  expect_range(field.color_range(), expected.color_range());
  for (std::size_t v = 0; v < a.attributes().size(); ++v)
    expect_range(a.attributes()[v].range, b.attributes()[v].range);
  ASSERT_EQ(field.sums() == nullptr, expected.sums() == nullptr);
  if (expected.sums() != nullptr) {
    ASSERT_EQ(field.sums()->values.size(), expected.sums()->values.size());
    for (std::size_t i = 0; i < expected.sums()->values.size(); ++i) {
      const float sum = expected.sums()->values[i];
      ASSERT_NEAR(field.sums()->values[i], sum, 1e-4 * std::abs(sum));
    }
  }
  EXPECT_NEAR(field.default_sampling_distance() / expected.default_sampling_distance(), 1, 1e-5);
  EXPECT_NEAR(field.refined_sampling_distance() / expected.refined_sampling_distance(), 1, 1e-5);
}

void expect_same_together(const Dataset& whole, const KernelModelOptions& options = {}) {
  Made alone;
  alone.field = make_kernel_field(whole, options, &alone.report);
  for (const int count : {1, 2, 3, 4, 7}) {
    SCOPED_TRACE(::testing::Message() << count << " processes");
    for (const Made& made : made_together(whole, count, options)) {
      expect_same(made.field, alone.field);
      EXPECT_EQ(made.report.array, alone.report.array);
      EXPECT_EQ(made.report.num_sites, alone.report.num_sites);
      EXPECT_EQ(made.report.num_missing, alone.report.num_missing);
      EXPECT_EQ(made.report.num_merged, alone.report.num_merged);
      EXPECT_EQ(made.report.num_copies, alone.report.num_copies);
      EXPECT_EQ(made.report.notes, alone.report.notes);
    }
  }
}

TEST(TeamField, ParticlesWithSizesFromTheirNeighbors) {
  expect_same_together(points_dataset(DatasetKind::kParticles, crowds(5000, 1)));
}

TEST(TeamField, DensityOfParticles) {
  Dataset dataset = points_dataset(DatasetKind::kParticles, crowds(5000, 2));
  expect_same_together(dataset, {.is_density = true});
  add_column(dataset, "mass", [](std::size_t i) { return 1e-3F + 1e-4F * (i % 7); });
  expect_same_together(dataset);
}

TEST(TeamField, ParticlesWithSizesAndVolumes) {
  Dataset dataset = points_dataset(DatasetKind::kParticles, crowds(1500, 3));
  add_column(dataset, "h", [](std::size_t i) { return 0.004F * (1 + i % 5); });
  expect_same_together(dataset, {.array = "v"});
  add_column(dataset, "mass", [](std::size_t i) { return 1.0F + i % 3; });
  add_column(dataset, "rho", [](std::size_t i) { return 1e5F * (1 + i % 11); });
  expect_same_together(dataset, {.array = "v", .color_array = "mass"});
}

TEST(TeamField, PeriodicBox) {
  Dataset dataset = points_dataset(DatasetKind::kParticles, crowds(3000, 4));
  dataset.periodic_box = Bounds3(Vec3(0.8, 1.9, 2.5), Vec3(1.5, 2.6, 3.4));
  expect_same_together(dataset);
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
  expect_same_together(dataset);
}

TEST(TeamField, StoredKernels) {
  const KernelField field = make_kernel_field(
      points_dataset(DatasetKind::kParticles, crowds(3000, 6)), {.anisotropic = true});
  expect_same_together(make_kernel_dataset(field));
}

// Fewer rows than processes, and a column that varies from share to share alone.
TEST(TeamField, FewRows) {
  Dataset dataset = points_dataset(DatasetKind::kParticles, crowds(5, 7));
  dataset.arrays.insert(dataset.arrays.begin(), dataset.arrays[0]);
  dataset.arrays[0].name = "first";
  dataset.arrays[0] = array_of_numbers("first", 1, std::vector<float>{1, 2, 3, 4, 5});
  expect_same_together(dataset);
  expect_same_together(share_of(dataset, 0, 5));  // one row
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
    made_together(whole, 3, {});
    ADD_FAILURE() << "was accepted";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "h[70] = 0: must be > 0");
  }
}

TEST(TeamField, RefusesWhatCannotBeShared) {
  const Dataset whole = points_dataset(DatasetKind::kParticles, crowds(100, 10));
  EXPECT_THROW(made_together(whole, 2, {.anisotropic = true}), Error);
  Room room(1);
  EXPECT_THROW(run_as_team(room,
                           [&](const std::shared_ptr<KernelTeam>& team) {
                             return make_team_field(whole, {}, team);
                           }),
               Error);
}

}  // namespace
}  // namespace ovoid::model
