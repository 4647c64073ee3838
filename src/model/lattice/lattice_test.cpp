// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "data/scalar_visit.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"
#include "support/numbers.h"

namespace ovoid {
namespace lattice_test {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

template <class T>
DataArray array_of(ScalarType type, std::vector<T> values, int components = 1) {
  const auto owner = std::make_shared<std::vector<T>>(std::move(values));
  DataArray array;
  array.name = std::string("x");
  array.type = type;
  array.num_components = components;
  array.num_tuples = static_cast<std::int64_t>(owner->size()) / components;
  array.bytes = {owner, std::as_bytes(std::span<const T>(*owner))};
  return array;
}

Dataset dataset_of(DataArray array, const Index3& dims) {
  Dataset dataset;
  dataset.source = "some.nrrd";
  dataset.lattice.dims = dims;
  dataset.arrays.push_back(std::move(array));
  return dataset;
}

// The stored numbers of a source.
std::vector<float> numbers_of(const BrickSource& source) {
  const BrickView view = source.acquire(0, 0, 0, 0.0);
  return data::visit_scalar(view.type, [&]<class T>(std::type_identity<T>) {
    const auto* data = static_cast<const T*>(view.data);
    std::vector<float> numbers;
    for (std::int64_t i = 0; i < num_samples(source.geometry().dims); ++i)
      numbers.push_back(static_cast<float>(data[i]));
    return numbers;
  });
}
std::vector<float> samples_of(const LatticeField& field) { return numbers_of(field.samples()); }

std::string refusal(const Dataset& dataset, const LatticeModelOptions& options = {}) {
  try {
    make_lattice_field(dataset, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "accepted";
}

// Fails if the scale of a file is lost on the way to the field, or applied twice.
TEST(MakeLatticeField, AppliesTheScaleOfTheArray) {
  const auto scaled = [](auto array) {
    array.value_scale = -2;
    array.value_offset = 10;
    return dataset_of(std::move(array), {3, 2, 1});
  };
  const std::vector<std::int16_t> stored{0, 1, 2, 3, 4, 5};
  // Samples that can be shown stay as they are, with the scale beside them.
  const Dataset shorts = scaled(array_of<std::int16_t>(ScalarType::kInt16, stored));
  const LatticeField field = make_lattice_field(shorts);
  EXPECT_EQ(field.samples().acquire(0, 0, 0, 0.0).data, shorts.arrays[0].bytes.view.data());
  EXPECT_EQ(field.samples().value_scale(), -2);
  EXPECT_EQ(field.samples().value_offset(), 10);
  EXPECT_EQ(field.value_range().lo, 0);
  EXPECT_EQ(field.value_range().hi, 10);
  // Those that become float32 are values then.
  const Dataset doubles = scaled(array_of<double>(ScalarType::kFloat64, {0, 1, 2, 3, 4, 5}));
  const LatticeField converted = make_lattice_field(doubles);
  const double scale = converted.samples().value_scale();
  const double offset = converted.samples().value_offset();
  EXPECT_EQ(samples_of(converted)[5] * scale + offset, 0);
  EXPECT_EQ(samples_of(converted)[0] * scale + offset, 10);
  EXPECT_EQ(converted.value_range().lo, 0);
  // The norm is taken of values: (-2 * 2 + 10, -2 * 1 + 10) is (6, 8).
  LatticeModelOptions norm;
  norm.component = LatticeModelOptions::kMagnitude;
  const Dataset pairs =
      scaled(array_of<std::int16_t>(ScalarType::kInt16, {2, 1, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5}, 2));
  const LatticeField lengths = make_lattice_field(pairs, norm);
  EXPECT_EQ(lengths.samples().value_scale(), 1);
  EXPECT_EQ(samples_of(lengths)[0], 10);
  EXPECT_EQ(samples_of(lengths)[1], 0);
}

// Fails if a slice, a line or one sample has no field, or another one than its samples.
TEST(MakeLatticeField, FlatLatticesHaveAField) {
  for (const Index3& dims : {Index3{7, 5, 1}, Index3{1, 6, 1}, Index3{1, 1, 1}, Index3{2, 2, 2}}) {
    std::vector<float> values;
    for (std::int64_t i = 0; i < num_samples(dims); ++i)
      values.push_back(static_cast<float>(i * 7 % 11) + 0.5F);
    const LatticeField field =
        make_lattice_field(dataset_of(array_of<float>(ScalarType::kFloat32, values), dims));
    const FieldSampler sampler(field);
    for (std::int64_t i = 0; i < num_samples(dims); ++i) {
      const Index3 at{i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])};
      const FieldSample found =
          sampler.at(field.geometry().world_from_index * field.geometry().index_position(at));
      EXPECT_TRUE(found.is_defined) << dims[0] << " " << dims[1] << " " << i;
      EXPECT_NEAR(found.value, values[static_cast<std::size_t>(i)], 1e-5);
    }
  }
}

// Prefiltering is linear, and so is the scale: it must not matter which comes first.
TEST(MakeLatticeField, PrefiltersScaledSamples) {
  LatticeModelOptions options;
  options.prefilter = true;
  Dataset scaled =
      dataset_of(array_of<std::int16_t>(ScalarType::kInt16, {0, 1, 5, 3, 4, 2, 9, 1}), {2, 2, 2});
  scaled.arrays[0].value_scale = 0.5;
  scaled.arrays[0].value_offset = -3;
  const Dataset plain = dataset_of(
      array_of<float>(ScalarType::kFloat32, {-3, -2.5F, -0.5F, -1.5F, -1, -2, 1.5F, -2.5F}),
      {2, 2, 2});
  const LatticeField a = make_lattice_field(scaled, options);
  const LatticeField b = make_lattice_field(plain, options);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(numbers_of(a.source())[i] * a.source().value_scale() + a.source().value_offset(),
                numbers_of(b.source())[i], 2e-4);  // the whole numbers' are rounded
  }
}

// Fails if samples that can be shown are copied, or are let go with the dataset.
TEST(MakeLatticeField, BorrowsWhatItCan) {
  LatticeField field;
  const void* stored = nullptr;
  {
    const Dataset dataset =
        dataset_of(array_of<std::uint16_t>(ScalarType::kUInt16, {1, 2, 3, 4, 5, 60000}), {3, 2, 1});
    stored = dataset.arrays[0].bytes.view.data();
    LatticeModelReport report;
    field = make_lattice_field(dataset, {}, &report);
    EXPECT_EQ(report.array, "x");
    EXPECT_EQ(report.num_missing, 0);
    EXPECT_EQ(report.source_bytes, 12U);
    EXPECT_EQ(report.resident_bytes, field.source().resident_bytes());
    EXPECT_TRUE(report.notes.empty());
  }
  const BrickView view = field.samples().acquire(0, 0, 0, 0.0);
  EXPECT_EQ(view.data, stored);
  EXPECT_EQ(view.type, ScalarType::kUInt16);
  EXPECT_EQ(static_cast<const std::uint16_t*>(view.data)[5], 60000);
  EXPECT_EQ(field.value_range().hi, 60000);
}

TEST(MakeLatticeField, CopiesWhatIsNotAligned) {
  std::vector<float> values = {1, 2, 3, 4};
  std::vector<std::byte> shifted(values.size() * sizeof(float) + 1);
  std::memcpy(shifted.data() + 1, values.data(), values.size() * sizeof(float));
  DataArray array = array_of(ScalarType::kFloat32, values);
  array.bytes = {nullptr, std::span<const std::byte>(shifted).subspan(1)};
  EXPECT_EQ(samples_of(make_lattice_field(dataset_of(array, {4, 1, 1}))), values);
}

TEST(MakeLatticeField, OtherTypesBecomeFloat) {
  const Index3 dims = {3, 1, 1};
  EXPECT_EQ(samples_of(make_lattice_field(
                dataset_of(array_of<std::int32_t>(ScalarType::kInt32, {-5, 0, 1 << 24}), dims))),
            (std::vector<float>{-5, 0, 16777216}));
  EXPECT_EQ(samples_of(make_lattice_field(dataset_of(
                array_of<std::uint64_t>(ScalarType::kUInt64, {0, 1, ~std::uint64_t{0}}), dims))),
            (std::vector<float>{0, 1, 0x1p64F}));
}

// Fails if a double beyond float32's range becomes an infinite or undefined value, or is not
// counted.
TEST(MakeLatticeField, CountsWhatIsMissing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LatticeModelReport report;
  const LatticeField field = make_lattice_field(
      dataset_of(array_of<double>(ScalarType::kFloat64, {1e39, 1, nan, -1e300, 2, 3.5}), {6, 1, 1}),
      {}, &report);
  const std::vector<float> samples = samples_of(field);
  EXPECT_TRUE(std::isnan(samples[0]) && std::isnan(samples[2]) && std::isnan(samples[3]));
  EXPECT_EQ(samples[5], 3.5F);
  EXPECT_EQ(field.value_range().lo, 1.0F);
  EXPECT_EQ(field.value_range().hi, 3.5F);
  EXPECT_TRUE(field.source().has_missing(0, 0, 0));
  EXPECT_EQ(report.num_missing, 3);
  ASSERT_EQ(report.notes.size(), 1U);
  EXPECT_EQ(report.notes[0],
            "array 'x': 3 of 6 samples are not finite or beyond float32's range and are treated as "
            "missing");
}

TEST(MakeLatticeField, TakesAComponentOrTheMagnitude) {
  const Dataset vectors = dataset_of(
      array_of<float>(ScalarType::kFloat32, {3, 4, 0, -6, 1e-30F, 0, kInfinity, 1}, 2), {4, 1, 1});
  LatticeModelOptions options;
  options.component = 1;
  EXPECT_EQ(samples_of(make_lattice_field(vectors, options)), (std::vector<float>{4, -6, 0, 1}));
  options.component = LatticeModelOptions::kMagnitude;
  const std::vector<float> norms = samples_of(make_lattice_field(vectors, options));
  EXPECT_EQ(norms[0], 5.0F);
  EXPECT_EQ(norms[1], 6.0F);
  EXPECT_EQ(norms[2], 1e-30F);  // its square is no float
  EXPECT_FALSE(std::isfinite(norms[3]));
  // A component of bytes stays bytes.
  const LatticeField red = make_lattice_field(
      dataset_of(array_of<std::uint8_t>(ScalarType::kUInt8, {1, 2, 3, 4, 5, 6}, 3), {2, 1, 1}));
  const BrickView view = red.samples().acquire(0, 0, 0, 0.0);
  ASSERT_EQ(view.type, ScalarType::kUInt8);
  EXPECT_EQ(static_cast<const std::uint8_t*>(view.data)[1], 4);
}

// 4 x 3 x 1 points: 3 x 2 cells in a plane, the first centre at (1/2, 1/2, 0) in index space.
TEST(MakeLatticeField, CellsHaveTheirOwnLattice) {
  DataArray cells = array_of<float>(ScalarType::kFloat32, {1, 2, 3, 4, 5, 6});
  cells.is_cell_data = true;
  Dataset dataset = dataset_of(cells, {4, 3, 1});
  dataset.lattice.world_from_index =
      Eigen::Translation3d(10, 20, 30) * Eigen::Scaling(2.0, 4.0, 8.0);
  const LatticeField field = make_lattice_field(dataset);
  EXPECT_EQ(field.geometry().dims, (Index3{3, 2, 1}));
  EXPECT_EQ(Vec3(field.geometry().world_from_index * Vec3(0, 0, 0)), Vec3(11, 22, 30));
  EXPECT_EQ(Vec3(field.geometry().world_from_index * Vec3(2, 1, 0)), Vec3(15, 26, 30));
}

TEST(MakeLatticeField, DrawsOneVoxel) {
  const LatticeField field =
      make_lattice_field(dataset_of(array_of<std::int8_t>(ScalarType::kInt8, {-7}), {1, 1, 1}));
  EXPECT_EQ(field.num_kernels(), 1);
  EXPECT_EQ(field.value_range().lo, -7);
}

// Balls of label 7 and 3 in a background of 0, or the same smoothed and quantized.
Dataset balls(bool are_labels) {
  std::vector<std::uint8_t> values;
  for (int z = 0; z < 24; ++z) {
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 24; ++x) {
        const double a = (Vec3(x, y, z) - Vec3(8, 8, 8)).norm();
        const double b = (Vec3(x, y, z) - Vec3(16, 15, 14)).norm();
        const double smooth = 120 / (1 + 0.02 * a * a) + 90 / (1 + 0.03 * b * b);
        values.push_back(static_cast<std::uint8_t>(are_labels ? (a < 6   ? 7
                                                                 : b < 5 ? 3
                                                                         : 0)
                                                              : smooth));
      }
    }
  }
  return dataset_of(array_of(ScalarType::kUInt8, values), {24, 24, 24});
}

// Fails if labels are interpolated by kernels that overshoot, scans are not interpolated, or what
// is asked for does not count.
TEST(MakeLatticeField, ChoosesTheKernelByTheData) {
  LatticeModelReport report;
  EXPECT_EQ(make_lattice_field(balls(false), {}, &report).kernel(), kBSplineKernel);
  EXPECT_TRUE(report.is_prefiltered);
  EXPECT_EQ(make_lattice_field(balls(true), {}, &report).kernel(), LatticeKernel{});
  EXPECT_FALSE(report.is_prefiltered);
  LatticeModelOptions options;
  options.kernel = kBSplineKernel;
  EXPECT_EQ(make_lattice_field(balls(true), options, &report).kernel(), kBSplineKernel);
  EXPECT_TRUE(report.is_prefiltered);
  options.prefilter = false;
  EXPECT_EQ(make_lattice_field(balls(false), options, &report).source().samples(), nullptr);
  EXPECT_FALSE(report.is_prefiltered);
  options = {};
  options.kernel = kCatmullRomKernel;
  make_lattice_field(balls(false), options, &report);
  EXPECT_FALSE(report.is_prefiltered);
  options = {};
  options.relevant = RelevantSamples{0.5};
  EXPECT_EQ(make_lattice_field(balls(false), options, &report).kernel(), LatticeKernel{});
  options.kernel = kBSplineKernel;
  EXPECT_THROW(make_lattice_field(balls(false), options), Error);
}

// Fails if the field's range is that of the coefficients, or the caller's samples are written to.
TEST(MakeLatticeField, PrefilteredKeepsTheSamplesRange) {
  std::vector<float> values(32, 0.0F);
  values[16] = 1.0F;
  values[3] = kNanF;
  const Dataset dataset = dataset_of(array_of(ScalarType::kFloat32, values), {32, 1, 1});
  LatticeModelOptions options;
  options.kernel = kBSplineKernel;
  options.prefilter = true;
  LatticeModelReport report;
  const LatticeField field = make_lattice_field(dataset, options, &report);
  EXPECT_EQ(field.value_range().lo, 0.0F);
  EXPECT_EQ(field.value_range().hi, 1.0F);
  EXPECT_LT(field.source().brick_range(4, 0, 0).lo, -0.1F);  // bounds are of coefficients
  EXPECT_GT(field.source().brick_range(4, 0, 0).hi, 1.1F);
  EXPECT_EQ(report.num_missing, 1);
  EXPECT_TRUE(std::isnan(samples_of(field)[3]));
  const auto* stored = reinterpret_cast<const float*>(dataset.arrays[0].bytes.view.data());
  EXPECT_EQ(stored[16], 1.0F);
  EXPECT_EQ(stored[15], 0.0F);
}

TEST(MakeLatticeField, NamesWhatIsWrong) {
  const auto values = [](std::size_t count) {
    return array_of(ScalarType::kFloat32, std::vector<float>(count, 1.0F));
  };
  const Dataset good = dataset_of(values(8), {2, 2, 2});
  EXPECT_EQ(refusal(good), "accepted");
  LatticeModelOptions options;
  options.array = "y";
  EXPECT_EQ(refusal(good, options), "array 'y': not in 'some.nrrd', which has 'x'");
  options = {};
  options.component = 1;
  EXPECT_TRUE(refusal(good, options).starts_with("component = 1: array 'x'"));
  options.component = -2;
  EXPECT_TRUE(refusal(good, options).starts_with("component = -2: array 'x'"));
  options = {};
  options.kernel = LatticeKernel{.sigma = 0};
  EXPECT_TRUE(refusal(good, options).starts_with("kernel sigma = 0"));
  options = {};
  options.kernel = LatticeKernel{.sigma = 2};
  EXPECT_EQ(refusal(good, options), "accepted");
  options.prefilter = true;
  EXPECT_TRUE(refusal(good, options).starts_with("kernel sigma = 2: its samples cannot"));
  options = {};
  options.kernel = LatticeKernel{.cutoff = 3, .kind = LatticeKernelKind::kBSpline};
  EXPECT_TRUE(refusal(good, options).starts_with("kernel bspline with sigma = 0.5, cutoff = 3"));
  options = {};
  options.threads = -1;
  EXPECT_TRUE(refusal(good, options).starts_with("threads = -1"));

  EXPECT_TRUE(
      refusal(dataset_of(values(7), {2, 2, 2})).starts_with("array 'x': 7 tuples, must be 8"));
  EXPECT_TRUE(refusal(dataset_of(values(0), {2, 2, 0})).starts_with("lattice dims[2] = 0"));
  Dataset liar = good;  // claims more than it holds
  liar.lattice.dims = {1000, 1000, 1000};
  liar.arrays[0].num_tuples = 1'000'000'000;
  EXPECT_TRUE(refusal(liar).starts_with("array 'x': 32 bytes, must be 1000000000 tuples"));
  liar.lattice.dims = {std::int64_t{1} << 40, std::int64_t{1} << 40, 4};
  EXPECT_NE(refusal(liar), "accepted");
  liar = good;
  liar.arrays[0].num_components = 0;
  EXPECT_TRUE(refusal(liar).starts_with("array 'x': 0 components"));
  Dataset flat = good;
  flat.lattice.world_from_index.linear().col(1).setZero();
  EXPECT_TRUE(refusal(flat).starts_with("lattice spacing[1] = 0"));
  EXPECT_EQ(
      refusal(dataset_of(array_of<float>(ScalarType::kFloat32, {kNanF, kInfinity}), {2, 1, 1})),
      "array 'x': none of its 2 samples is finite");
}

TEST(MakeLatticeField, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const Dataset dataset = dataset_of(array_of<float>(ScalarType::kFloat32, {1, 2}), {2, 1, 1});
  try {
    make_lattice_field(dataset, {}, nullptr, source.get_token());
    FAIL() << "not cancelled";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
}

}  // namespace lattice_test
}  // namespace ovoid
