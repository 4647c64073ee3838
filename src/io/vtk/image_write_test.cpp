// SPDX-License-Identifier: Apache-2.0
// VTI and legacy VTK as they are written without VTK. Fails if anything that the program's own
// reader gets back is not what was written, to the bit.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <limits>
#include <string>

#include "data/scalar_visit.h"
#include "io/core/test_folder.h"
#include "io/hdf5/test_lattice_files.h"

namespace ovoid::io {
namespace image_write_test {

// A build without VTK can write these files, but not read them.
bool can_read(const std::string& path) {
  return error_of([&] { read_dataset({path}); }).find("no VTK") == std::string::npos;
}

constexpr ScalarType kTypes[] = {ScalarType::kUInt8,  ScalarType::kInt8,   ScalarType::kUInt16,
                                 ScalarType::kInt16,  ScalarType::kUInt32, ScalarType::kInt32,
                                 ScalarType::kUInt64, ScalarType::kInt64,  ScalarType::kFloat32,
                                 ScalarType::kFloat64};

// The ends of the type's range among the samples.
DataArray extremes(ScalarType type, std::int64_t count, int num_components) {
  return data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    using Limits = std::numeric_limits<T>;
    std::vector<T> values = values_of<T>(array_of("", type, count, num_components));
    values[0] = Limits::lowest();
    values[1] = Limits::max();
    values[2] = Limits::is_integer ? Limits::min() : Limits::denorm_min();
    return make_array(fmt::format("{} x {}", name_of(type), num_components), type, values,
                      num_components);
  });
}

// Every type, one and several values per sample, on samples and cells (3 x 2 x 1 of them).
Dataset every_type() {
  Dataset dataset;
  dataset.lattice.dims = {4, 3, 2};
  for (const int num_components : {1, 2, 3, 9}) {
    for (const ScalarType type : kTypes)
      dataset.arrays.push_back(extremes(type, 24, num_components));
  }
  for (const ScalarType type : kTypes) {
    dataset.arrays.push_back(extremes(type, 6, 1));
    dataset.arrays.back().is_cell_data = true;
  }
  return dataset;
}

const DataArray* find_array(const Dataset& dataset, const DataArray& like) {
  for (const DataArray& array : dataset.arrays) {
    if (array.name == like.name && array.is_cell_data == like.is_cell_data) return &array;
  }
  return nullptr;
}

// Arrays are found by their names: legacy files have theirs in an order of their own.
void expect_comes_back(const Dataset& dataset, const std::string& path) {
  write_dataset(dataset, path);
  if (!can_read(path)) return;
  const Dataset back = read_dataset({path});
  EXPECT_EQ(back.lattice.dims, dataset.lattice.dims);
  EXPECT_EQ(back.lattice.world_from_index.matrix(), dataset.lattice.world_from_index.matrix());
  EXPECT_EQ(back.arrays.size(), dataset.arrays.size());
  EXPECT_TRUE(back.notes.empty()) << back.notes[0];
  for (const DataArray& array : dataset.arrays) {
    const DataArray* const found = find_array(back, array);
    ASSERT_NE(found, nullptr) << array.name;
    expect_same_array(*found, array);
  }
}

class ImageWrite : public testing::TestWithParam<const char*> {
 protected:
  std::string path() const { return folder_.file(GetParam()); }
  bool is_xml() const { return std::string(GetParam()) == "a.vti"; }

  TestFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(Formats, ImageWrite, testing::Values("a.vti", "a.vtk"),
                         [](const auto& info) { return info.index == 0 ? "Vti" : "LegacyVtk"; });

TEST_P(ImageWrite, EveryTypeComesBackToTheBit) { expect_comes_back(every_type(), path()); }

TEST_P(ImageWrite, OddNamesAndUnitsComeBack) {
  Dataset dataset;
  dataset.lattice.dims = {4, 3, 2};
  const std::string odd[] = {"two words",
                             "q\"uo'te",
                             "<a> & b;",
                             "&amp;",
                             "100 %%20",
                             "\xc3\xa9\xe2\x82\xac",
                             "a/b\\c",
                             "]]>",
                             "-1",
                             "NULL_ARRAY",
                             std::string(200, 'n')};
  for (const std::string& name : odd) {
    dataset.arrays.push_back(array_of(name, ScalarType::kInt16, 24));
    dataset.arrays.back().unit = name;
  }
  expect_comes_back(dataset, path());
}

// More than one block of zlib data, and more than is turned round at a time; not a whole number of
// either.
TEST_P(ImageWrite, LargeArraysComeBack) {
  Dataset dataset;
  dataset.lattice.dims = {101, 97, 53};
  const std::int64_t count = num_samples(dataset.lattice.dims);
  dataset.arrays = {array_of("a", ScalarType::kFloat32, count, 1),
                    array_of("b", ScalarType::kUInt8, count, 3),
                    array_of("c", ScalarType::kFloat64, count, 1)};
  expect_comes_back(dataset, path());
}

// 2^18 bytes are one block of zlib data, which must not be followed by an empty one.
TEST_P(ImageWrite, WholeBlocksComeBack) {
  Dataset dataset;
  dataset.lattice.dims = {64, 64, 128};
  dataset.arrays = {array_of("a", ScalarType::kUInt8, num_samples(dataset.lattice.dims))};
  expect_comes_back(dataset, path());
}

TEST_P(ImageWrite, PlacesComeBackToTheBit) {
  Dataset dataset;
  dataset.lattice.dims = {2, 3, 1};
  dataset.arrays = {array_of("a", ScalarType::kUInt8, 6)};
  for (const int i : {1, 3, 7, 10, 49, 98, 127, 199}) {  // each starts a process that reads it back
    Affine3& place = dataset.lattice.world_from_index;
    place.setIdentity();
    place.translation() = Vec3(-1.0 / i, 1e6 / i, 0.1 * i);
    place.linear() = Vec3(2.0 / i, i / 3.0, 1e-5 * i).asDiagonal();
    if (is_xml())
      place.linear() =
          Mat3(Eigen::AngleAxisd(0.1 * i, Vec3(1, 2, i).normalized()) * place.linear());
    expect_comes_back(dataset, path());
    if (testing::Test::HasFailure()) break;
  }
}

TEST_P(ImageWrite, ScaledArraysAreWrittenAsTheirValues) {
  Dataset dataset;
  dataset.lattice.dims = {3, 1, 1};
  dataset.arrays = {make_array<std::uint8_t>("a", ScalarType::kUInt8, {0, 1, 2})};
  dataset.arrays[0].value_scale = 0.5;
  dataset.arrays[0].value_offset = 10;
  write_dataset(dataset, path());
  if (!can_read(path())) GTEST_SKIP() << "this build has no VTK to read with";
  const Dataset back = read_dataset({path()});
  EXPECT_EQ(back.array().type, ScalarType::kFloat32);
  EXPECT_EQ(values_of<float>(back.array()), (std::vector<float>{10, 10.5, 11}));
}

TEST_P(ImageWrite, RefusesTwoArraysOfOneName) {
  Dataset dataset;
  dataset.lattice.dims = {4, 3, 2};
  dataset.arrays = {array_of("a", ScalarType::kUInt8, 24), array_of("a", ScalarType::kInt8, 24)};
  EXPECT_EQ(error_of([&] { write_dataset(dataset, path()); }),
            "unsupported: " + path() +
                ": two arrays are called 'a', of which VTK reads one: keep one, or write .h5");
  EXPECT_EQ(folder_.count(), 0);
}

TEST_P(ImageWrite, TheSameDatasetGivesTheSameBytes) {
  write_dataset(every_type(), path());
  const std::string first = folder_.read(GetParam());
  write_dataset(every_type(), path());
  EXPECT_EQ(folder_.read(GetParam()), first);
  EXPECT_EQ(folder_.count(), 1);
}

// The array's block table and blocks, read without VTK.
TEST(VtiWrite, HoldsBlocksOfZlibDataWhereItsHeaderSays) {
  const TestFolder folder;
  Dataset dataset;
  dataset.lattice.dims = {300000, 1, 1};
  dataset.arrays = {array_of("first", ScalarType::kUInt16, 300000),
                    array_of("second & last", ScalarType::kUInt8, 300000)};
  dataset.arrays[1].unit = "\"<K>\"";
  write_dataset(dataset, folder.file("a.vti"));
  const std::string text = folder.read("a.vti");
  EXPECT_NE(text.find("<PointData Scalars=\"first\">"), std::string::npos);
  EXPECT_NE(text.find("&quot;&lt;K&gt;&quot;</InformationKey>"), std::string::npos);
  const std::size_t at = text.find("Name=\"second &amp; last\"");
  ASSERT_NE(at, std::string::npos);
  const std::size_t offset = std::stoul(text.substr(text.find("offset=\"", at) + 8, 20));
  const char* data = text.data() + text.find('_', text.find("<AppendedData")) + 1 + offset;
  std::uint64_t table[5];
  std::memcpy(table, data, sizeof(table));
  EXPECT_EQ(table[0], 2U);
  EXPECT_EQ(table[1] + table[2], 300000U);
  data += sizeof(table);
  std::string whole;
  for (const int block : {0, 1}) {
    std::string part(table[1 + block], '\0');
    uLongf size = part.size();
    ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(part.data()), &size,
                         reinterpret_cast<const Bytef*>(data), table[3 + block]),
              Z_OK);
    EXPECT_EQ(size, part.size());
    whole += part;
    data += table[3 + block];
  }
  EXPECT_EQ(whole, bytes_of(values_of<std::uint8_t>(dataset.arrays[1])));
  EXPECT_EQ(std::string(data).substr(0, 17), "\n  </AppendedData");
}

// What no XML file may hold is not written into one: such files cannot be read at all.
TEST(VtiWrite, NamesThatAreNoTextAreMadeText) {
  const TestFolder folder;
  Dataset dataset;
  dataset.lattice.dims = {4, 3, 2};
  dataset.arrays = {array_of("tab\tline\nbell\a", ScalarType::kUInt8, 24),
                    array_of("latin \xe9t\xe9", ScalarType::kUInt8, 24),
                    array_of("half \xe2\x82", ScalarType::kUInt8, 24),
                    array_of("long \xc0\x80\xed\xa0\x80", ScalarType::kUInt8, 24)};
  write_dataset(dataset, folder.file("a.vti"));
  const std::string text = folder.read("a.vti");
  EXPECT_NE(text.find("Name=\"tab line bell \""), std::string::npos);
  EXPECT_NE(text.find("Name=\"latin ?t?\""), std::string::npos);
  EXPECT_NE(text.find("Name=\"half ??\""), std::string::npos);
  EXPECT_NE(text.find("Name=\"long ?????\""), std::string::npos);
  if (!can_read(folder.file("a.vti"))) return;
  EXPECT_EQ(read_dataset({folder.file("a.vti")}).arrays.size(), 4U);
}

// Byte for byte what VTK 9.1's writer made of the same lattice.
TEST(LegacyVtkWrite, WritesWhatVtkWrites) {
  const TestFolder folder;
  Dataset dataset;
  dataset.lattice.dims = {2, 1, 1};
  dataset.lattice.world_from_index =
      Eigen::Translation3d(10, -20, 0.5) * Eigen::Scaling(0.5, 1., 2.);
  dataset.arrays = {make_array<std::int16_t>("v v", ScalarType::kInt16, {1, 2, 3, 4}, 2),
                    make_array<float>("q\"%", ScalarType::kFloat32, {1, -2}),
                    make_array<std::int8_t>("c", ScalarType::kInt8, {7})};
  dataset.arrays[1].unit = "m / s";
  dataset.arrays[2].is_cell_data = true;
  write_dataset(dataset, folder.file("a.vtk"));
  using namespace std::string_literals;
  EXPECT_EQ(folder.read("a.vtk"),
            "# vtk DataFile Version 5.1\nvtk output\nBINARY\nDATASET STRUCTURED_POINTS\n"
            "DIMENSIONS 2 1 1\nSPACING 0.5 1 2\nORIGIN 10 -20 0.5\n"
            "CELL_DATA 1\nSCALARS c signed_char\nLOOKUP_TABLE default\n\a\n"
            "POINT_DATA 2\nSCALARS q%22%25 float\nLOOKUP_TABLE default\n"
            "\x3f\x80\0\0\xc0\0\0\0\nMETADATA\nINFORMATION 1\n"
            "NAME UNITS_LABEL LOCATION vtkDataArray\nDATA m%20/%20s\n\n"
            "FIELD FieldData 1\nv%20v 2 2 short\n\0\1\0\2\0\3\0\4\n"s);
}

TEST(LegacyVtkWrite, RefusesWhatItCannotHold) {
  const TestFolder folder;
  Dataset dataset;
  dataset.lattice.dims = {4, 3, 2};
  dataset.arrays = {array_of("a", ScalarType::kUInt8, 24)};
  const auto refusal = [&] {
    const std::string error = error_of([&] { write_dataset(dataset, folder.file("a.vtk")); });
    const std::string front = "unsupported: " + folder.file("a.vtk") + ": ";
    EXPECT_EQ(error.substr(0, front.size()), front);
    EXPECT_EQ(folder.count(), 0);
    return error.substr(std::min(front.size(), error.size()));
  };
  dataset.arrays[0].name = std::string(83, ' ');
  EXPECT_EQ(refusal(), "the name '" + std::string(40, ' ') +
                           "...' takes 249 characters, legacy VTK takes at most 248: shorten it, "
                           "or write .vti");
  dataset.arrays[0].name = "a";
  dataset.arrays[0].unit = std::string(249, 'u');
  EXPECT_NE(refusal().find("the unit"), std::string::npos);
  dataset.arrays[0].unit = "";
  for (const int entry : {0, 1, 4, 8}) {
    Mat3 axes = Mat3::Identity();
    axes(entry / 3, entry % 3) = entry % 4 == 0 ? -1 : 1e-9;
    dataset.lattice.world_from_index.linear() = axes;
    EXPECT_EQ(refusal(),
              "legacy VTK knows no axis directions, the lattice is rotated or flipped: write .vti");
  }
}

}  // namespace image_write_test
}  // namespace ovoid::io
