// SPDX-License-Identifier: Apache-2.0
#include "io/points/npy_points.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fuzz/seeds.h"
#include "io/core/short_floats.h"
#include "io/core/test_folder.h"
#include "io/images/npy.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"

namespace ovoid::io {
namespace npy_points_test {

using Floats = std::vector<float>;

std::string npy_of(ScalarType type, const std::vector<std::int64_t>& shape,
                   const std::string& bytes) {
  return npy_header(type, shape) + bytes;
}

Dataset read_named(const std::string& name, const std::string& bytes,
                   const ReadOptions& options = {}) {
  return read_source(*open_memory(name, std::as_bytes(std::span(bytes))), options);
}

std::string npz_error(const std::string& bytes) {
  return error_of([&] { read_named("a.npz", bytes); });
}

TEST(NpyPoints, ThreeAndFourColumns) {
  const auto values = counting<float>(20);
  const Dataset four = read_named("a.npy", npy_of(ScalarType::kFloat32, {5, 4}, bytes_of(values)));
  EXPECT_EQ(four.kind, DatasetKind::kParticles);
  EXPECT_EQ(four.num_positions(), 5);
  EXPECT_EQ(values_of<float>(four.positions)[3], 5);
  EXPECT_EQ(values_of<float>(four.array("value")), (Floats{4, 8, 12, 16, 20}));
  const auto integers = counting<std::int32_t>(15);
  const Dataset three = read_named("a.npy", npy_of(ScalarType::kInt32, {5, 3}, bytes_of(integers)));
  EXPECT_EQ(three.positions.type, ScalarType::kFloat64);
  EXPECT_EQ(values_of<double>(three.positions)[14], 15);
  EXPECT_TRUE(three.arrays.empty());
  ReadOptions options;
  options.raw.spacing = Vec3(1, 1, 1);
  EXPECT_EQ(error_of([&] {
              read_named("a.npy", npy_of(ScalarType::kInt32, {5, 3}, bytes_of(integers)), options);
            }),
            "invalid-argument: a.npy: holds points: a spacing can be given for volumes only");
}

TEST(NpyPoints, HalvesBecomeFloat32) {
  std::vector<std::uint16_t> halves;
  for (const float value : counting<float>(15)) halves.push_back(bits_of(value, ShortFloat::kHalf));
  const std::string bytes =
      with(npy_of(ScalarType::kUInt16, {5, 3}, bytes_of(halves)), "<u2", "<f2");
  EXPECT_EQ(values_of<float>(read_named("a.npy", bytes).positions), counting<float>(15));
  EXPECT_EQ(values_of<float>(read_named("a.npy", with(bytes, "False, ", "True,  ")).positions)[1],
            6);
}

TEST(NpyPoints, FortranOrder) {
  std::string bytes = npy_of(ScalarType::kFloat32, {5, 3}, bytes_of(counting<float>(15)));
  bytes = with(bytes, "False, ", "True,  ");
  EXPECT_EQ(values_of<float>(read_named("a.npy", bytes).positions),
            (Floats{1, 6, 11, 2, 7, 12, 3, 8, 13, 4, 9, 14, 5, 10, 15}));
}

std::vector<std::pair<std::string, std::string>> two_arrays() {
  return {{"radii.npy", npy_of(ScalarType::kUInt8, {2}, "\x05\x06")},
          {"positions.npy", npy_of(ScalarType::kFloat32, {2, 3}, bytes_of(counting<float>(6)))},
          {"other.npy", npy_of(ScalarType::kUInt8, {3}, "abc")},
          {"notes.txt", "text"}};
}

TEST(Npz, StoredAndDeflated) {
  for (const bool is_deflated : {false, true}) {
    const Dataset dataset = read_named("a.npz", fuzz::zip_file(two_arrays(), is_deflated));
    EXPECT_EQ(values_of<float>(dataset.positions), counting<float>(6));
    ASSERT_EQ(dataset.arrays.size(), 1U);
    EXPECT_EQ(values_of<std::uint8_t>(dataset.array("radii")), (std::vector<std::uint8_t>{5, 6}));
    ASSERT_EQ(dataset.notes.size(), 2U);
    EXPECT_EQ(dataset.notes[0], "a.npz: 'other' is left out: its shape is (3): expected 2 rows");
    EXPECT_EQ(dataset.notes[1], "a.npz: 'notes.txt' is left out: it is no array");
  }
}

TEST(Npz, ErrorsSayWhatIsWrong) {
  const std::string good = fuzz::zip_file(two_arrays(), true);
  EXPECT_EQ(npz_error(fuzz::zip_file({{"v.npy", npy_of(ScalarType::kUInt8, {1}, "a")}}, false)),
            "file-format: a.npz: has neither an array 'positions' of shape (N, 3) nor a volume of "
            "three axes; it has 'v'");
  EXPECT_EQ(
      npz_error(fuzz::zip_file({{"pos.npy", npy_of(ScalarType::kUInt8, {2, 2}, "abcd")}}, false)),
      "file-format: a.npz: pos.npy: shape (2, 2): expected (N, 3)");
  EXPECT_EQ(npz_error(good.substr(0, good.size() - 1)),
            "file-format: a.npz: zip: has no directory at its end: is the file truncated?");
  std::string broken = good;
  broken[broken.find("PK\x03\x04", broken.find("positions.npy")) - 4] ^= 0x10;  // among the samples
  EXPECT_EQ(npz_error(broken).substr(0, 53),
            "file-format: a.npz: zip: 'positions.npy' is broken: i")
      << npz_error(broken);
  std::string large = good;
  const std::size_t entry = large.find("PK\x01\x02");
  large.replace(entry + 24, 4, "\xff\xff\xff\x7f");
  EXPECT_EQ(npz_error(large).find("do not fit the file") != std::string::npos, true)
      << npz_error(large);
  std::string method = good;
  method[entry + 10] = 12;
  EXPECT_EQ(npz_error(method),
            "unsupported: a.npz: zip: 'radii.npy': compression 12: expected stored or deflated");
}

std::string volume_of(char first, const std::vector<std::int64_t>& shape) {
  std::int64_t count = 1;
  for (const std::int64_t size : shape) count *= size;
  std::string samples;
  for (std::int64_t i = 0; i < count; ++i) samples += static_cast<char>(first + i);
  return npy_of(ScalarType::kUInt8, shape, samples);
}

TEST(Npz, ArraysOfOneSizeAreALattice) {
  const std::vector<std::int64_t> shape{3, 2, 5};
  for (const bool is_deflated : {false, true}) {
    const std::string one = fuzz::zip_file({{"arr_0.npy", volume_of('a', shape)}}, is_deflated);
    const Dataset dataset = read_named("a.npz", one);
    EXPECT_EQ(dataset.kind, DatasetKind::kLattice);
    EXPECT_EQ(dataset.lattice.dims, (Index3{5, 2, 3}));
    EXPECT_EQ(dataset.array().name, "arr_0");
    EXPECT_EQ(values_of<char>(dataset.array())[29], 'a' + 29);
    EXPECT_TRUE(dataset.notes.empty());
    const std::string several = fuzz::zip_file({{"small.npy", volume_of('z', {2, 2, 2})},
                                                {"label.npy", npy_of(ScalarType::kUInt8, {1}, "a")},
                                                {"vol.npy", volume_of('a', shape)},
                                                {"seg.npy", volume_of('A', {1, 3, 2, 5})}},
                                               is_deflated);
    const Dataset both = read_named("a.npz", several);
    ASSERT_EQ(both.arrays.size(), 2U);
    EXPECT_EQ(both.arrays[0].name, "vol");
    EXPECT_EQ(values_of<char>(both.array("seg"))[5], 'F');
    EXPECT_EQ(both.notes[0],
              "a.npz: volumes of another size are left out: 'small'; choose with --array");
    EXPECT_EQ(both.notes[1], "a.npz: what is no volume is left out: 'label'");
    ReadOptions options;
    options.array = "small";
    EXPECT_EQ(read_named("a.npz", several, options).lattice.dims, (Index3{2, 2, 2}));
    options.array = "nothing";
    EXPECT_EQ(error_of([&] { read_named("a.npz", several, options); }).find("expected one of") !=
                  std::string::npos,
              true);
  }
  const std::string moving = fuzz::zip_file({{"v.npy", volume_of('a', {2, 3, 2, 5})}}, true);
  ReadOptions options;
  options.step = 1;
  EXPECT_EQ(values_of<char>(read_named("a.npz", moving, options).array())[0], 'a' + 30);
  options = {};
  options.raw.axis_order = "czyx";
  EXPECT_EQ(read_named("a.npz", moving, options).arrays[1].name, "v channel 2");
}

// Fails if places are taken along the wrong axes: those of a matrix are the array's, the others x,
// y and z.
TEST(Npz, SmallArraysPlaceTheSamples) {
  const std::string volume = volume_of('a', {3, 2, 4});
  const auto numbers = [](const std::vector<std::int64_t>& shape, const std::vector<double>& all) {
    return npy_of(ScalarType::kFloat64, shape, bytes_of(all));
  };
  const Dataset along = read_named(
      "a.npz", fuzz::zip_file({{"v.npy", volume},
                               {"spacing.npy", numbers({3}, {2, 3, 4})},
                               {"origin.npy", numbers({3}, {10, 20, 30})},
                               {"direction.npy", numbers({3, 3}, {0, 1, 0, -1, 0, 0, 0, 0, 1})}},
                              true));
  EXPECT_EQ(along.lattice.world_from_index * Vec3(1, 1, 1), Vec3(13, 18, 34));
  EXPECT_EQ(along.notes.size(), 1U);
  const std::string affine = fuzz::zip_file(
      {{"v.npy", volume},
       {"affine.npy", numbers({4, 4}, {4, 0, 0, 10, 0, 3, 0, 20, 0, 0, 2, 30, 0, 0, 0, 1})}},
      true);
  EXPECT_EQ(read_named("a.npz", affine).lattice.world_from_index * Vec3(1, 0, 2), Vec3(18, 20, 32));
  ReadOptions options;
  options.raw.spacing = Vec3(1, 2, 3);
  EXPECT_EQ(read_named("a.npz", affine, options).lattice.spacing(), Vec3(1, 2, 3));
  const Dataset flat = read_named(
      "a.npz", fuzz::zip_file({{"v.npy", volume}, {"spacing.npy", numbers({3}, {2, 0, 4})}}, true));
  EXPECT_EQ(flat.lattice.spacing(), Vec3(1, 1, 1));
  EXPECT_EQ(flat.notes.size(), 1U);
}

TEST(Npz, WhatIsNoArrayIsNamed) {
  const std::string object = "\x93NUMPY\x01" + std::string("\0\x40\0", 3) +
                             "{'descr': '|O', 'fortran_order': False, 'shape': (1, 1, 1), }   \n";
  EXPECT_EQ(npz_error(fuzz::zip_file({{"a.npy", object}}, false)),
            "unsupported: a.npz: 'a' is left out: descr: '|O' (Python objects, which are pickled): "
            "expected booleans, integers of 1 to 8 bytes, or floats of 2 to 8");
  EXPECT_EQ(
      npz_error(fuzz::zip_file({{"m/data.pkl", "."}, {"m/data/0", "1234"}}, false)),
      "unsupported: a.npz: is a file of PyTorch's (.pt), which is not read: expected an array, "
      "by numpy.save('a.npy', torch.load('a.pt').numpy())");
  EXPECT_EQ(npz_error(fuzz::zip_file({{"readme.txt", "hello"}}, false)),
            "unsupported: a.npz: is a zip file without arrays of NumPy's (.npy); it has "
            "'readme.txt'");
}

TEST(Npz, RoundTrip) {
  const TestFolder folder;
  Dataset dataset;
  dataset.kind = DatasetKind::kParticles;
  dataset.positions = make_array("positions", ScalarType::kFloat64, counting<double>(9), 3);
  dataset.arrays.push_back(make_array("v", ScalarType::kInt64, counting<std::int64_t>(6), 2));
  write_dataset(dataset, folder.file("a.npz"));
  const Dataset again = read_dataset({folder.file("a.npz")});
  EXPECT_EQ(values_of<double>(again.positions), counting<double>(9));
  EXPECT_EQ(values_of<std::int64_t>(again.array("v")), counting<std::int64_t>(6));
  EXPECT_EQ(again.array("v").num_components, 2);
  EXPECT_EQ(again.array("v").type, ScalarType::kInt64);
}

// An archive of very many arrays, or of very long names, is told of in a line.
TEST(Npz, MessagesAreShortWhateverTheArchiveHolds) {
  std::vector<std::pair<std::string, std::string>> entries;
  for (int i = 0; i < 3000; ++i)
    entries.emplace_back(std::to_string(i) + std::string(i == 0 ? 30000 : 1, 'n'), "no array");
  const std::string error = npz_error(fuzz::zip_file(entries, false));
  EXPECT_LT(error.size(), 500U);
  EXPECT_NE(error.find("'9n' and 2990 more"), std::string::npos) << error;
  entries.emplace_back("positions.npy",
                       npy_of(ScalarType::kFloat32, {1, 3}, bytes_of(counting<float>(3))));
  const Dataset dataset = read_named("a.npz", fuzz::zip_file(entries, false));
  EXPECT_EQ(dataset.notes.size(), 11U);
  for (const std::string& note : dataset.notes) EXPECT_LT(note.size(), 200U);
}

}  // namespace npy_points_test
}  // namespace ovoid::io
