// SPDX-License-Identifier: Apache-2.0
// Lattice files: what is written comes back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "data/scalar_visit.h"
#include "io/core/test_folder.h"
#include "io/hdf5/test_lattice_files.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"
#include "ovoid/lattice_file.h"

#ifdef OVOID_IO_HDF5
namespace ovoid::io {
namespace hdf5_lattice_test {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(LatticeFile, AllTypesAndKindsComeBack) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  for (const LatticeKind kind : {LatticeKind::kCartesian, LatticeKind::kBodyCentred}) {
    Dataset dataset = lattice_dataset({5, 4, 7}, kind);
    dataset.arrays.clear();
    for (int t = 0; t <= static_cast<int>(ScalarType::kFloat64); ++t) {
      const auto type = static_cast<ScalarType>(t);
      dataset.arrays.push_back(array_of(name_of(type), type, 140, 1 + t % 3));
      dataset.arrays.back().unit = t % 2 == 0 ? "" : "kg/m^3";
      dataset.arrays.back().value_scale = t % 2 == 0 ? 1 : -0.1;
      dataset.arrays.back().value_offset = t;
    }
    write_dataset(dataset, path);
    const Dataset back = read_dataset({path});
    EXPECT_EQ(back.kind, DatasetKind::kLattice);
    EXPECT_EQ(back.format, "HDF5 lattice, dense");
    EXPECT_EQ(back.lattice.kind, kind);
    EXPECT_EQ(back.lattice.dims, dataset.lattice.dims);
    EXPECT_TRUE(back.lattice.world_from_index.isApprox(oblique(), 0));
    EXPECT_EQ(back.space, Space::kLps);
    EXPECT_EQ(back.series, SeriesKind::kSteps);
    EXPECT_EQ(back.num_steps, 1);
    EXPECT_TRUE(back.notes.empty());
    ASSERT_EQ(back.arrays.size(), dataset.arrays.size());
    for (std::size_t i = 0; i < back.arrays.size(); ++i)
      expect_same_array(back.arrays[i], dataset.arrays[i]);
    ReadOptions options;
    options.array = "int16";
    EXPECT_EQ(read_dataset({path}, options).arrays.size(), 1U);
    options.array = "none";
    EXPECT_THAT(lattice_error(path, options), HasSubstr("array 'none': not in 'F', which has"));
    EXPECT_EQ(folder.count(), 1);
  }
}

TEST(LatticeFile, MissingSamplesStay) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Dataset dataset = lattice_dataset({2, 1, 2});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  dataset.arrays = {
      make_array("v", ScalarType::kFloat32, std::vector<float>{nan, 1, -infinity, 2})};
  write_dataset(dataset, path);
  expect_same_array(read_dataset({path}).arrays[0], dataset.arrays[0]);
}

// Chunks that the sizes do not divide: several layers, and several rows of a layer.
TEST(LatticeFile, LayersOfSeveralChunks) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  for (const Index3& dims : {Index3{300, 200, 40}, Index3{700, 900, 2}, Index3{1, 1, 1}}) {
    Dataset dataset = lattice_dataset(dims);
    dataset.arrays.push_back(array_of("v", ScalarType::kUInt8, num_samples(dims), 2));
    write_dataset(dataset, path);
    const Dataset back = read_dataset({path});
    for (std::size_t i = 0; i < 2; ++i) expect_same_array(back.arrays[i], dataset.arrays[i]);
  }
}

TEST(LatticeFile, SameBytesTwice) {
  const TestFolder folder;
  const Dataset dataset = lattice_dataset({5, 4, 3});
  write_dataset(dataset, folder.file("a.h5"));
  write_dataset(dataset, folder.file("b.h5"));
  EXPECT_EQ(folder.read("a.h5"), folder.read("b.h5"));
  EXPECT_LT(folder.read("a.h5").size(), 12000U) << "what the library needs beside the samples";
}

TEST(LatticeFile, CellsAreALatticeOfTheirOwn) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Dataset dataset = lattice_dataset({3, 3, 2});
  const DataArray points = dataset.arrays[0];
  dataset.arrays = {array_of("cells", ScalarType::kInt16, 4)};
  dataset.arrays[0].is_cell_data = true;
  write_dataset(dataset, path);
  const Dataset back = read_dataset({path});
  EXPECT_EQ(back.lattice.dims, (Index3{2, 2, 1}));
  EXPECT_TRUE(
      back.lattice.world_from_index.translation().isApprox(oblique() * Vec3(0.5, 0.5, 0.5)));
  EXPECT_FALSE(back.arrays[0].is_cell_data);
  dataset.arrays.push_back(points);
  EXPECT_THAT(error_of([&] { write_dataset(dataset, path); }),
              HasSubstr("arrays 'cells' and 'density': one has its samples in the cells"));
}

TEST(LatticeFile, StepsInSpaceAndTime) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  for (const SeriesKind series : {SeriesKind::kSteps, SeriesKind::kStaggered}) {
    LatticeFileWriter writer(path, series_header(series, {1, 1.5, 2}));
    for (std::int64_t step = 0; step < 3; ++step) {
      EXPECT_EQ(writer.num_steps(), step);
      writer.write_step(step_of(step));
    }
    writer.finish();
    for (std::int64_t step = 0; step < 3; ++step) {
      ReadOptions options;
      options.step = step;
      const Dataset back = read_dataset({path}, options);
      EXPECT_EQ(back.series, series);
      EXPECT_EQ(back.num_steps, 3);
      EXPECT_EQ(back.step, step);
      EXPECT_THAT(back.times, ElementsAre(1, 1.5, 2));
      EXPECT_EQ(back.time_unit, "ms");
      const bool is_shifted = series == SeriesKind::kStaggered && step == 1;
      const Vec3 first = Vec3::Constant(is_shifted ? 0.5 : 0.0);
      EXPECT_EQ(back.lattice.world_from_index.translation(), oblique() * first);
      EXPECT_EQ(back.lattice.world_from_index.linear(), oblique().linear());
      DataArray expected = step_of(step).arrays[0];
      expected.unit = "K";
      expected.value_scale = 0.5;
      expected.value_offset = 1;
      expect_same_array(back.arrays[0], expected);
      expect_same_array(back.arrays[1], step_of(step).arrays[1]);
    }
    ReadOptions options;
    options.step = 3;
    EXPECT_EQ(lattice_error(path, options), "invalid-argument: F: step 3: expected 0 to 2");
  }
}

TEST(LatticeFile, FirstStepThatVaries) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  LatticeFileHeader header = series_header(SeriesKind::kSteps, {});
  header.arrays.resize(1);
  LatticeFileWriter writer(path, header);
  Dataset still;
  still.arrays = {make_array("a", ScalarType::kUInt16, std::vector<std::uint16_t>(24, 7))};
  writer.write_step(still);
  Dataset moving = step_of(0);
  moving.arrays.resize(1);
  writer.write_step(moving);
  writer.finish();
  const Dataset back = read_dataset({path});
  EXPECT_EQ(back.step, 1);
  EXPECT_TRUE(back.times.empty());
  ASSERT_EQ(back.notes.size(), 1U);
  EXPECT_THAT(back.notes[0], HasSubstr("step 1 of 2, the first that varies"));
}

// Of another step's samples nothing is looked at: they may be broken.
TEST(LatticeFile, OneStepIsReadAlone) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  LatticeFileHeader header = series_header(SeriesKind::kSteps, {});
  header.arrays.resize(1);
  LatticeFileWriter writer(path, header);
  for (std::int64_t step = 0; step < 2; ++step) {
    Dataset dataset = step_of(step);
    dataset.arrays.resize(1);
    writer.write_step(dataset);
  }
  writer.finish();
  std::string bytes = folder.read("a.h5");
  for (auto at = bytes.find("\x78\x5e"); at != std::string::npos; at = bytes.find("\x78\x5e", at)) {
    bytes[at] = 0;  // the first chunk's header: no deflate any more
    break;
  }
  folder.write("a.h5", bytes);
  ReadOptions options;
  options.step = 1;
  EXPECT_EQ(lattice_error(path, options), "");
  options.step = 0;
  EXPECT_THAT(lattice_error(path, options),
              HasSubstr("'array0/step0': cannot be read: is the file damaged?"));
}

TEST(LatticeFile, WriterLeavesNothingBehind) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  folder.write("a.h5", "before");
  {
    LatticeFileWriter writer(path, series_header(SeriesKind::kSteps, {1, 2}));
    writer.write_step(step_of(0));
    EXPECT_EQ(folder.count(), 2);
    EXPECT_EQ(error_of([&] { writer.finish(); }),
              "invalid-argument: times: there are 2: expected one for each of 1 steps");
  }
  EXPECT_EQ(folder.read("a.h5"), "before");
  EXPECT_EQ(folder.count(), 1);
  {
    LatticeFileWriter writer(path, series_header(SeriesKind::kSteps, {}));
    writer.write_step(step_of(0));
    remove_partial_files();
    EXPECT_EQ(folder.count(), 1);
  }
  EXPECT_EQ(folder.read("a.h5"), "before");
  LatticeFileWriter writer(path, series_header(SeriesKind::kSteps, {}));
  EXPECT_EQ(error_of([&] { writer.finish(); }), "invalid-argument: finish: no step was written");
  writer.write_step(step_of(0));
  writer.finish();
  EXPECT_THAT(error_of([&] { writer.write_step(step_of(0)); }), HasSubstr("is finished"));
  EXPECT_THAT(error_of([&] { writer.finish(); }), HasSubstr("is finished"));
  EXPECT_EQ(lattice_error(path), "");
}

TEST(LatticeFile, WriterRefusesWhatIsNotAsItSays) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  const auto error = [&](const std::function<void(LatticeFileHeader&)>& change) {
    LatticeFileHeader header = series_header(SeriesKind::kStaggered, {1, 2});
    change(header);
    return error_of([&] { LatticeFileWriter(path, header); });
  };
  EXPECT_EQ(error([](auto&) {}), "");
  EXPECT_THAT(error([](auto& h) { h.arrays.clear(); }), HasSubstr("arrays: there are none"));
  EXPECT_THAT(error([](auto& h) { h.lattice.dims[1] = 0; }), HasSubstr("axis of 0 samples"));
  EXPECT_THAT(error([](auto& h) { h.lattice.world_from_index.matrix()(0, 0) = NAN; }),
              HasSubstr("is not finite"));
  EXPECT_THAT(error([](auto& h) { h.lattice.kind = LatticeKind::kBodyCentred; }),
              HasSubstr("must be cartesian"));
  EXPECT_THAT(error([](auto& h) { h.times[1] = NAN; }), HasSubstr("times[1] = nan"));
  EXPECT_THAT(error([](auto& h) { h.times = {1, 2, 4}; }), HasSubstr("equal distances"));
  EXPECT_THAT(error([](auto& h) { h.arrays[1].num_components = 0; }),
              HasSubstr("arrays[1].num_components = 0"));
  EXPECT_THAT(error([](auto& h) { h.arrays[0].value_scale = 0; }),
              HasSubstr("arrays[0].value_scale = 0"));
  EXPECT_THAT(error([](auto& h) { h.arrays[0].value_offset = INFINITY; }),
              HasSubstr("arrays[0].value_offset = inf"));
  EXPECT_THAT(error([](auto& h) { h.arrays[0].name = std::string(5000, 'x'); }),
              HasSubstr("arrays[0].name: has 5000 bytes"));
  EXPECT_THAT(error([](auto& h) { h.lattice.dims[0] = 1 << 30; }), HasSubstr("more than 1 GiB"));
  EXPECT_THAT(error_of([&] { LatticeFileWriter(folder.file("no/a.h5"), series_header({}, {})); }),
              HasSubstr("file-write: "));
  EXPECT_EQ(folder.count(), 0);

  LatticeFileWriter writer(path, series_header(SeriesKind::kSteps, {}));
  Dataset step = step_of(0);
  EXPECT_THAT(error_of([&] { writer.write_step(std::vector<Bytes>{step.arrays[0].bytes}); }),
              HasSubstr("samples: 1 arrays: expected 2"));
  step.arrays[1].bytes = step.arrays[0].bytes;
  EXPECT_THAT(error_of([&] { writer.write_step(step); }), HasSubstr("samples[1]: 48 bytes"));
  step.arrays[1].type = ScalarType::kInt8;
  EXPECT_THAT(error_of([&] { writer.write_step(step); }), HasSubstr("arrays[1] is 'b', int8"));
}

TEST(LatticeFile, OthersRefuseBodyCentred) {
  const TestFolder folder;
  const Dataset dataset = lattice_dataset({3, 3, 4}, LatticeKind::kBodyCentred);
  for (const char* ending : {".nrrd", ".nhdr", ".npy", ".raw", ".nii", ".nii.gz", ".vti", ".vtk"}) {
    const std::string message =
        error_of([&] { write_dataset(dataset, folder.file("a") + ending); });
    EXPECT_THAT(message, HasSubstr("unsupported: ")) << ending;
    EXPECT_THAT(message, HasSubstr("the dataset is body-centred: write .h5, or resample it with "
                                   "convert --size"))
        << ending;
  }
  EXPECT_EQ(folder.count(), 0);
}

// What reading gives back of an array of which the values above 0 were kept.
DataArray with_background(const DataArray& array, double background) {
  return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    std::vector<T> values = values_of<T>(array);
    for (T& number : values) {
      const double value = static_cast<double>(number) * array.value_scale + array.value_offset;
      if (std::isfinite(value) && !(value > 0))
        number = static_cast<T>((background - array.value_offset) / array.value_scale);
    }
    DataArray result = make_array(array.name, array.type, values);
    result.unit = array.unit;
    result.value_scale = array.value_scale;
    result.value_offset = array.value_offset;
    return result;
  });
}

TEST(LatticeFile, RunsOfAllTypesComeBack) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  for (const double scale : {1.0, -0.5}) {
    Dataset dataset = lattice_dataset({31, 17, 9}, LatticeKind::kBodyCentred);
    dataset.arrays.clear();
    for (int t = 0; t <= static_cast<int>(ScalarType::kFloat64); ++t) {
      const auto type = static_cast<ScalarType>(t);
      dataset.arrays.push_back(array_of(name_of(type), type, 31 * 17 * 9));
      dataset.arrays.back().unit = "K";
      dataset.arrays.back().value_scale = scale;
      dataset.arrays.back().value_offset = scale > 0 ? -60 : 20;
    }
    write_runs(dataset, path, -40);
    const Dataset back = read_dataset({path});
    EXPECT_EQ(back.format, "HDF5 lattice, runs");
    EXPECT_EQ(back.lattice.kind, LatticeKind::kBodyCentred);
    ASSERT_EQ(back.arrays.size(), dataset.arrays.size());
    for (std::size_t i = 0; i < back.arrays.size(); ++i)
      expect_same_array(back.arrays[i], with_background(dataset.arrays[i], -40));
    ASSERT_EQ(back.notes.size(), back.arrays.size());
    EXPECT_THAT(back.notes[0], HasSubstr("'uint8' is stored as runs: "));
    EXPECT_THAT(back.notes[0], HasSubstr("; the others are -40"));
  }
}

TEST(LatticeFile, BackgroundIsTheLeastValue) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Dataset dataset = lattice_dataset({3, 2, 1});
  const auto kept = [&](const std::vector<float>& values, double scale) {
    dataset.arrays = {make_array("v", ScalarType::kFloat32, values)};
    dataset.arrays[0].value_scale = scale;
    write_runs(dataset, path);
    return values_of<float>(read_dataset({path}).arrays[0]);
  };
  EXPECT_THAT(kept({1, -2, -7, 0, 3, -5}, 1), ElementsAre(1, -7, -7, -7, 3, -7));
  EXPECT_THAT(kept({1, -2, -7, 0, 3, -5}, -1), ElementsAre(3, -2, -7, 3, 3, -5));
  EXPECT_THAT(kept({-1, -2, -7, 0, -3, -5}, 1), Each(-7.0F)) << "nothing is relevant";
  EXPECT_THAT(kept({1, 2, 7, 10, 3, 5}, 1), ElementsAre(1, 2, 7, 10, 3, 5));
  const std::vector<float> missing = kept({nan, -2, 5, nan, 3, 5}, 1);
  EXPECT_TRUE(std::isnan(missing[0]) && std::isnan(missing[3])) << "missing samples stay missing";
}

TEST(LatticeFile, RunsOfStaggeredSteps) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  LatticeFileHeader header = series_header(SeriesKind::kStaggered, {1, 2, 3});
  header.arrays.resize(1);
  header.arrays[0].value_offset = -50;
  header.relevant = RelevantSamples{0, -50};
  LatticeFileWriter writer(path, header);
  std::int64_t num_relevant = 0;
  for (std::int64_t step = 0; step < 3; ++step) {
    Dataset dataset = step_of(step);
    dataset.arrays.resize(1);
    for (const std::uint16_t number : values_of<std::uint16_t>(dataset.arrays[0]))
      num_relevant += number > 100 ? 1 : 0;
    writer.write_step(dataset);
  }
  writer.finish();
  EXPECT_EQ(writer.counts().num_samples, 72);
  EXPECT_EQ(writer.counts().num_relevant, num_relevant);
  EXPECT_EQ(writer.counts().dense_bytes, 144);
  for (std::int64_t step = 0; step < 3; ++step) {
    ReadOptions options;
    options.step = step;
    const Dataset back = read_dataset({path}, options);
    DataArray expected = step_of(step).arrays[0];
    expected.unit = "K";
    expected.value_scale = 0.5;
    expected.value_offset = -50;
    expect_same_array(back.arrays[0], with_background(expected, -50));
    EXPECT_EQ(back.series, SeriesKind::kStaggered);
    EXPECT_EQ(back.notes.size(), 1U);
  }
}

TEST(LatticeFile, RunsOfLongRowsAndBytes) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Dataset dataset = lattice_dataset({70'000, 2, 1});
  std::vector<std::uint8_t> values(140'000);
  values[0] = values[69'999] = values[139'999] = 9;
  std::fill(values.begin() + 80'000, values.begin() + 130'000, std::uint8_t{7});
  dataset.arrays = {make_array("v", ScalarType::kUInt8, values)};
  write_runs(dataset, path);
  expect_same_array(read_dataset({path}).arrays[0], dataset.arrays[0]);
}

TEST(LatticeFile, RunsThatCannotBe) {
  const TestFolder folder;
  const auto error = [&](const std::function<void(LatticeFileHeader&)>& change) {
    LatticeFileHeader header = series_header(SeriesKind::kSteps, {});
    header.arrays.resize(1);
    header.relevant = RelevantSamples{};
    change(header);
    return error_of([&] { LatticeFileWriter(folder.file("a.h5"), header); });
  };
  EXPECT_EQ(error([](auto&) {}), "");
  EXPECT_THAT(error([](auto& h) { h.arrays[0].num_components = 2; }),
              HasSubstr("array 'a': has 2 components: runs hold arrays of one"));
  EXPECT_THAT(error([](auto& h) { h.relevant->above = NAN; }), HasSubstr("relevant.above = nan"));
  EXPECT_THAT(error([](auto& h) { h.relevant->background = INFINITY; }),
              HasSubstr("relevant.background = inf"));
}

LatticeLevels some_levels(const Index3& dims) {
  LatticeLevels levels;
  levels.dims = dims;
  levels.offset = -3;
  levels.least = -10;
  levels.greatest = 900;
  levels.step = 0.25;
  levels.levels.resize(4);
  for (std::uint32_t i = 0; i < 5000; ++i) {
    levels.levels[0].nodes.push_back(7 * i + i * i % 5);
    levels.levels[0].weights.push_back(static_cast<std::int32_t>(i * i % 251) - 125);
  }
  levels.levels[1] = {{0, 300, 3999}, {-40000, 1, 90000}};  // gaps and weights of more bytes
  levels.levels[3] = {{70}, {3}};
  return levels;
}

LatticeFileHeader header_of_levels(const Dataset& dataset) {
  LatticeFileHeader header = lattice_file_header(dataset);
  header.content = LatticeContent::kLevels;
  return header;
}

// What is read is what the levels stand for; and the file is no larger than was said, and hardly
// smaller.
TEST(LatticeFile, LevelsAreReadAsTheirSamples) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  const Dataset dataset = lattice_dataset({41, 40, 39});
  const LatticeLevels levels = some_levels(dataset.lattice.dims);
  LatticeFileWriter writer(path, header_of_levels(dataset));
  writer.write_levels({&levels, 1});
  writer.finish();
  EXPECT_EQ(writer.counts().num_relevant, 5004);
  const auto bytes = static_cast<std::int64_t>(folder.read("a.h5").size());
  EXPECT_LE(bytes, lattice_levels_bytes(levels));
  EXPECT_GT(bytes, lattice_levels_bytes(levels) - 8192);
  const Dataset back = read_dataset({path});
  EXPECT_EQ(back.format, "HDF5 lattice, levels");
  EXPECT_EQ(back.space, Space::kLps);
  EXPECT_EQ(values_of<float>(back.array()), samples_of(levels));
  ASSERT_FALSE(back.notes.empty());
  EXPECT_NE(back.notes.back().find("'density' is stored as levels: 5004 kernels for 63960 samples"),
            std::string::npos)
      << back.notes.back();
}

// Samples that are missing, the first and the last among them, stay so.
TEST(LatticeFile, LevelsKeepHoles) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  const Dataset dataset = lattice_dataset({41, 40, 39});
  LatticeLevels levels = some_levels(dataset.lattice.dims);
  levels.holes = {0, 3, 63949, 6, 1, 1};
  LatticeFileWriter writer(path, header_of_levels(dataset));
  writer.write_levels({&levels, 1});
  writer.finish();
  EXPECT_LE(static_cast<std::int64_t>(folder.read("a.h5").size()), lattice_levels_bytes(levels));
  const std::vector<float> read = values_of<float>(read_dataset({path}).array());
  levels.holes.clear();
  const std::vector<float> whole = samples_of(levels);
  for (std::size_t i = 0; i < read.size(); ++i) {
    const bool is_hole = i < 3 || (i >= 63952 && i < 63958) || i == 63959;
    ASSERT_EQ(std::isnan(read[i]), is_hole) << i;
    if (is_hole) continue;
    ASSERT_EQ(read[i], whole[i]) << i;
  }
}

TEST(LatticeFile, LevelsOfWholeNumbersKeepTypeAndScale) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Dataset dataset = lattice_dataset({41, 40, 39});
  LatticeLevels levels = some_levels(dataset.lattice.dims);
  levels.whole = true;
  dataset.arrays = {array_of("hu", ScalarType::kInt16, num_samples(dataset.lattice.dims))};
  dataset.arrays[0].value_scale = 2;
  dataset.arrays[0].value_offset = -1000;
  LatticeFileWriter writer(path, header_of_levels(dataset));
  writer.write_levels({&levels, 1});
  writer.finish();
  const Dataset back = read_dataset({path});
  EXPECT_EQ(back.array().type, ScalarType::kInt16);
  EXPECT_EQ(back.array().value_scale, 2);
  EXPECT_EQ(back.array().value_offset, -1000);
  const std::vector<float> samples = samples_of(levels);
  EXPECT_EQ(values_of<std::int16_t>(back.array()),
            std::vector<std::int16_t>(samples.begin(), samples.end()));
  levels.whole = false;
  LatticeFileWriter other(folder.file("b.h5"), header_of_levels(dataset));
  EXPECT_NE(error_of([&] {
              other.write_levels({&levels, 1});
            }).find("whole = false"),
            std::string::npos);
}

TEST(LatticeFile, LevelsOfNothingAreTheirOffset) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  const Dataset dataset = lattice_dataset({4, 3, 2});
  LatticeLevels levels;
  levels.dims = dataset.lattice.dims;
  levels.least = levels.greatest = levels.offset = 2.5;
  LatticeFileWriter writer(path, header_of_levels(dataset));
  writer.write_levels({&levels, 1});
  writer.finish();
  EXPECT_LE(static_cast<std::int64_t>(folder.read("a.h5").size()), lattice_levels_bytes(levels));
  EXPECT_EQ(values_of<float>(read_dataset({path}).array()), std::vector<float>(24, 2.5F));
}

TEST(LatticeFile, LevelsAreNotForEveryLattice) {
  const TestFolder folder;
  const auto expect_refusal = [&](const LatticeFileHeader& header, const std::string& words) {
    const std::string error = error_of([&] { LatticeFileWriter(folder.file("a.h5"), header); });
    EXPECT_NE(error.find(words), std::string::npos) << error;
  };
  const Dataset dataset = lattice_dataset({4, 3, 2});
  LatticeFileHeader header = header_of_levels(dataset);
  header.lattice.kind = LatticeKind::kBodyCentred;
  expect_refusal(header, "lattice: must be cartesian");
  header = header_of_levels(dataset);
  header.arrays[0].type = ScalarType::kInt32;
  expect_refusal(header, "levels hold float32 and integers of 1 or 2 bytes");
  header = header_of_levels(dataset);
  header.relevant = RelevantSamples{1.0};
  expect_refusal(header, "runs or as levels");
  LatticeFileWriter writer(folder.file("b.h5"), header_of_levels(dataset));
  EXPECT_NE(error_of([&] { writer.write_step(dataset); }).find("levels are written"),
            std::string::npos);
  const LatticeLevels other = some_levels({5, 3, 2});
  EXPECT_NE(error_of([&] {
              writer.write_levels({&other, 1});
            }).find("expected 4 x 3 x 2"),
            std::string::npos);
}

LatticeBoxes some_boxes(const Index3& dims) {
  LatticeBoxes all;
  all.dims = dims;
  all.least = -10;
  all.greatest = 900;
  all.background = 3;
  all.step = 0.25;
  for (std::int32_t i = 0; i < 300; ++i) {
    all.boxes.push_back({.gap = 2 + i % 3,
                         .size = {i < 5 ? 2 : 1, 1, 1 + i % 7},
                         .first = i * i % 3000 - 100,
                         .rise = {i % 11 - 5, 0, 40000 - 500 * (i % 150)}});
  }
  all.boxes[7].first = LatticeBox::kMissing;
  return all;
}

// Fails if a number of a box is cut, or put in another's place.
TEST(LatticeFile, BoxesAreReadAsTheirSamples) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  const Dataset dataset = lattice_dataset({41, 40, 39});
  LatticeFileHeader header =
      lattice_file_header(dataset, "density", LatticeContent::kBoxes, /*whole=*/false);
  EXPECT_EQ(header.arrays[0].type, ScalarType::kFloat32);
  const LatticeBoxes boxes = some_boxes(dataset.lattice.dims);
  LatticeFileWriter writer(path, header);
  EXPECT_NE(error_of([&] { writer.write_step(dataset); }).find("boxes are written"),
            std::string::npos);
  writer.write_boxes({&boxes, 1});
  writer.finish();
  EXPECT_EQ(writer.counts().num_relevant, 300);
  const Dataset back = read_dataset({path});
  EXPECT_EQ(back.format, "HDF5 lattice, boxes");
  const std::vector<float> read = values_of<float>(back.array()), samples = samples_of(boxes);
  ASSERT_EQ(read.size(), samples.size());
  EXPECT_EQ(std::memcmp(read.data(), samples.data(), read.size() * sizeof(float)), 0);
  ASSERT_FALSE(back.notes.empty());
  EXPECT_NE(back.notes.back().find("'density' is stored as boxes: 300 for 63960 samples"),
            std::string::npos)
      << back.notes.back();
}

}  // namespace hdf5_lattice_test
}  // namespace ovoid::io
#endif
