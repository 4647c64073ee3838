// SPDX-License-Identifier: Apache-2.0
// netCDF-4 files, and other HDF5 files whose arrays lie along named axes.
#include <gtest/gtest.h>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

#ifdef OVOID_IO_HDF5
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "io/netcdf/test_netcdf4.h"

namespace ovoid::io {
namespace netcdf4_test {

// A dataset in words, without the name of its file.
std::string told(const Dataset& dataset) {
  std::string text = dataset.format;
  const auto add = [&](const auto& value) {
    if constexpr (requires { std::string(value); })
      text += " " + std::string(value);
    else
      text += " " + std::to_string(value);
  };
  add(static_cast<int>(dataset.kind));
  for (const std::int64_t size : dataset.lattice.dims) add(size);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      add(dataset.lattice.world_from_index.matrix()(row, column));
  add(dataset.num_steps);
  add(dataset.step);
  for (const double time : dataset.times) add(time);
  add(dataset.time_unit);
  const auto add_array = [&](const DataArray& array) {
    add("| " + array.name + " " + std::string(name_of(array.type)) + " " + array.unit);
    add(array.value_scale);
    add(array.value_offset);
    for (const std::byte byte : array.bytes.view) add(std::to_integer<int>(byte));
  };
  add_array(dataset.positions);
  for (const std::int64_t size : dataset.cells.dims) add(size);
  for (const DataArray& array : dataset.arrays) add_array(array);
  for (const std::string& note : dataset.notes) add("\n" + note.substr(note.find(": ")));
  return text;
}

// The error of a read, or what is read.
std::string read_told(const std::string& path, const ReadOptions& options) {
  std::string text;
  const std::string error = error_of([&] { text = told(read_dataset({path}, options)); });
  return text.empty()
             ? error.substr(error.find(path) == std::string::npos ? 0
                                                                  : error.find(path) + path.size())
             : text;
}

// Fails if netCDF-4 says anything else than the classic file of the same data.
void expect_as_classic(const TestNc& nc, const ReadOptions& options = {}) {
  const TestFolder folder;
  const std::string classic = read_told(folder.write("a.nc", nc.bytes()), options);
  ASSERT_FALSE(classic.empty());
  for (const bool is_packed : {false, true}) {
    for (const bool has_strings : {false, true}) {
      SCOPED_TRACE(is_packed);
      SCOPED_TRACE(has_strings);
      const std::string path = folder.file("a.nc4");
      { const TestNc4Writer writer(path, nc, {is_packed, has_strings}); }
      EXPECT_EQ(read_told(path, options), classic);
    }
  }
}

Dataset read_nc4(const TestNc& nc, const ReadOptions& options = {}) {
  const TestFolder folder;
  const std::string path = folder.file("a.nc");
  { const TestNc4Writer writer(path, nc); }
  return read_dataset({path}, options);
}

// The attributes of a variable of the example.
std::vector<TestNcAttribute>& attributes_of(TestNc& nc, const std::string& name) {
  for (TestNcVariable& one : nc.variables)
    if (one.name == name) return one.attributes;
  throw std::logic_error(name);
}

TEST(Netcdf4, IsReadAsClassicFilesAre) {
  expect_as_classic(test_climate());
  ReadOptions options;
  options.step = 1;
  expect_as_classic(test_climate(), options);
  options.raw.axis_order = "zyxt";
  options.step = 3;
  expect_as_classic(test_climate(), options);
  options = {};
  options.raw.spacing = Vec3(1, 2, 3);
  expect_as_classic(test_simulation({1, 2, 4}), options);
  expect_as_classic(test_simulation({1, 2, 3}));
  expect_as_classic(test_simulation({1, 2, 4}));
  expect_as_classic(test_simulation({1, 3, 2}));
}

// Maps in time; a dimension that has no variable; axes in another order.
TEST(Netcdf4, DimensionsAreAsClassicFilesHaveThem) {
  TestNc maps;
  maps.dims = {{"time", 0}, {"lat", 3}, {"lon", 4}};
  maps.num_records = 2;
  std::vector<float> counted(24);
  for (std::size_t i = 0; i < counted.size(); ++i) counted[i] = static_cast<float>(i);
  maps.variables = {
      {"time",
       {0},
       kNcDouble,
       big_endian<double>({0, 6}),
       {nc_text("units", "hours since 2000-1-1")}},
      {"lat", {1}, kNcFloat, big_endian<float>({50, 49, 48}), {nc_text("units", "degrees_north")}},
      {"lon",
       {2},
       kNcFloat,
       big_endian<float>({358, 359, 0, 1}),
       {nc_text("units", "degrees_east")}},
      {"sst", {0, 1, 2}, kNcFloat, big_endian(counted)}};
  expect_as_classic(maps);
  const Dataset dataset = read_nc4(maps);
  EXPECT_EQ(dataset.format, "netCDF");
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 1}));
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_EQ(dataset.time_unit, "h");
  EXPECT_EQ(dataset.lattice.world_from_index * Vec3(3, 2, 0), Vec3(361, 48, 0));
  maps.variables.erase(maps.variables.begin());  // time is a dimension alone
  expect_as_classic(maps);
  maps.dims[0].second = 2;
  maps.variables.back().dims = {2, 1, 0};  // the first varies slowest
  expect_as_classic(maps);
  EXPECT_EQ(read_nc4(maps).lattice.dims, (Index3{4, 3, 1}));
}

// What stands for samples that nobody has written or that are not valid.
TEST(Netcdf4, MissingNumbersAreAsInClassicFiles) {
  TestNc nc = test_climate();
  std::vector<TestNcAttribute>& attributes = attributes_of(nc, "temp");
  attributes = {nc_text("units", "K"),
                {"missing_value", kNcShort, big_endian<std::int16_t>({3, 31})},
                {"valid_range", kNcShort, big_endian<std::int16_t>({2, 40})}};
  expect_as_classic(nc);
  attributes = {nc_text("missing_value", " 5 ")};
  expect_as_classic(nc);
  EXPECT_TRUE(std::isnan(values_of<float>(read_nc4(nc).arrays[0])[5]));
  TestNc filled = test_simulation({1, 2, 3});
  std::vector<float> values(12, 1.5F);
  values[4] = 9.9692099683868690e+36F;
  filled.variables[0].bytes = big_endian(values);
  expect_as_classic(filled);
  EXPECT_TRUE(std::isnan(values_of<float>(read_nc4(filled).arrays[0])[4]));
}

TEST(Netcdf4, ChoicesAndRefusalsAreAsOfClassicFiles) {
  TestNc nc = test_simulation({1, 2, 3});
  nc.variables.push_back({"area", {1, 2}, kNcFloat, big_endian<float>({1, 2, 3, 4, 5, 6})});
  nc.variables.push_back({"u", {0, 1, 2}, kNcDouble, big_endian(std::vector<double>(12, 9.9))});
  for (const char* const name : {"", "area", "u", "v"}) {
    SCOPED_TRACE(name);
    ReadOptions options;
    options.array = name;
    expect_as_classic(nc, options);
  }
}

// Fails if axes that are as long as each other are taken for the positions of particles.
TEST(Netcdf4, CubesAreNoParticles) {
  TestNc nc;
  nc.dims = {{"z", 2}, {"y", 2}, {"x", 2}, {"n", 3}};
  nc.variables = {{"x", {2}, kNcFloat, big_endian<float>({0, 1})},
                  {"y", {1}, kNcFloat, big_endian<float>({0, 2})},
                  {"z", {0}, kNcFloat, big_endian<float>({0, 3})},
                  {"rho", {0, 1, 2}, kNcFloat, big_endian(std::vector<float>(8, 1))}};
  expect_as_classic(nc);
  EXPECT_EQ(read_nc4(nc).lattice.world_from_index * Vec3(1, 1, 1), Vec3(1, 2, 3));
}

// Fails if a step of samples that stay in their file is read from another place.
TEST(Netcdf4, StepsStayInTheirFile) {
  TestNc nc = test_climate();
  attributes_of(nc, "temp").clear();
  for (const bool is_packed : {false, true}) {
    SCOPED_TRACE(is_packed);
    const TestFolder folder;
    const std::string path = folder.file("a.nc");
    { const TestNc4Writer writer(path, nc, {is_packed, false}); }
    ReadOptions options;
    options.step = 1;
    options.may_stay_in_file = true;
    options.memory_limit = 1;
    const Dataset dataset = read_dataset({path}, options);
    if (dataset.arrays[0].stored == nullptr) continue;  // memory holds it
    std::vector<std::int16_t> values(24);
    dataset.arrays[0].stored->read(0, std::as_writable_bytes(std::span(values)));
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_EQ(values[i], static_cast<std::int16_t>(24 + i));
  }
}

// A file written by other hands: scales for some axes alone, a link that leads nowhere, an array
// that is shorter than its dimension.
TEST(Netcdf4, WhatIsOddSpoilsNothing) {
  const TestFolder folder;
  const std::string path = folder.file("a.nc");
  {
    const TestNc4Writer writer(path, test_simulation({1, 2, 3}));
    H5Lcreate_soft("/nowhere", writer.file(), "soft", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_external("other.h5", "/x", writer.file(), "away", H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t dims[] = {2, 2, 3};
    const Hdf5Handle space(H5Screate_simple(3, dims, nullptr), H5Sclose);
    const Hdf5Handle half(H5Dcreate2(writer.file(), "half", H5T_IEEE_F32LE, space.get(),
                                     H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                          H5Dclose);
    const std::vector<float> values(12, 2.5F);
    H5Dwrite(half.get(), H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5DSattach_scale(half.get(), writer.dataset("x"), 2);
  }
  ReadOptions options;
  options.array = "half";
  const Dataset dataset = read_dataset({path}, options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{3, 2, 2}));
  EXPECT_EQ((dataset.lattice.world_from_index * Vec3(2, 1, 1)).x(), 3);
  EXPECT_EQ(values_of<float>(dataset.arrays[0])[11], 2.5F);
}

// --- arrays without scales ----------------------------------------------------------------------

// Writes arrays of floats, counted from 0, as they stand.
void write_bare(const std::string& path,
                const std::vector<std::pair<std::string, std::vector<hsize_t>>>& arrays) {
  const Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  for (const auto& [name, dims] : arrays) {
    const Hdf5Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
                           H5Sclose);
    const Hdf5Handle dataset(H5Dcreate2(file.get(), name.c_str(), H5T_IEEE_F32LE, space.get(),
                                        H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                             H5Dclose);
    std::vector<float> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
    H5Dwrite(dataset.get(), H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  }
}

// Fails if an array called as times are is taken for them.
TEST(Hdf5Beside, AxesAreToldByNamesAndLengths) {
  const TestFolder folder;
  const std::string path = folder.file("a.nc");
  write_bare(path,
             {{"t", {2, 5, 8, 10}}, {"time", {2}}, {"level", {5}}, {"lat", {8}}, {"lon", {10}}});
  Dataset dataset = read_dataset({path});
  EXPECT_EQ(dataset.lattice.dims, (Index3{10, 8, 5}));
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_EQ(dataset.times, (std::vector<double>{0, 1}));
  ASSERT_EQ(dataset.arrays.size(), 1U);
  EXPECT_EQ(dataset.arrays[0].name, "t");
  // The first axis is that of x, as its length says.
  write_bare(path, {{"T", {6, 4, 3}}, {"x", {6}}, {"y", {4}}, {"z", {3}}});
  dataset = read_dataset({path});
  EXPECT_EQ(dataset.lattice.dims, (Index3{6, 4, 3}));
  EXPECT_EQ(values_of<float>(dataset.arrays[0])[1], 12);
  // Vectors, whose last axis no other is as long as.
  write_bare(path, {{"v", {3, 4, 6, 2}}, {"x", {6}}, {"y", {4}}, {"z", {3}}});
  EXPECT_EQ(read_dataset({path}).arrays[0].num_components, 2);
}

}  // namespace netcdf4_test
}  // namespace ovoid::io
#endif
