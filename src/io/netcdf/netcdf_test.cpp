// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "io/core/memory.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/netcdf/netcdf_grid.h"
#include "io/netcdf/netcdf_header.h"
#include "io/netcdf/test_netcdf.h"
#include "io/read_source.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

namespace ovoid::io {
namespace netcdf_test {

Dataset read_nc(const TestNc& nc, const ReadOptions& options = {}) {
  const std::string bytes = nc.bytes();
  return read_source(*open_memory("a.nc", std::as_bytes(std::span(bytes))), options);
}

std::string error_of_nc(const TestNc& nc, const ReadOptions& options = {}) {
  return error_of([&] { read_nc(nc, options); });
}

bool has_note(const Dataset& dataset, const std::string& part) {
  for (const std::string& note : dataset.notes)
    if (note.find(part) != std::string::npos) return true;
  return false;
}

TestNcVariable& variable_of(TestNc& nc, const std::string& name) {
  for (TestNcVariable& one : nc.variables)
    if (one.name == name) return one;
  throw std::logic_error(name);
}

// Fails if axes are told by anything but the attributes, or records do not lie where they do in one
// of the three versions.
TEST(Netcdf, AxesTimesAndValuesFollowTheAttributes) {
  for (const int version : {1, 2, 5}) {
    SCOPED_TRACE(version);
    ReadOptions options;
    options.step = 1;
    const Dataset dataset = read_nc(test_climate(version), options);
    EXPECT_EQ(dataset.format, "netCDF");
    EXPECT_EQ(dataset.lattice.dims, (Index3{4, 2, 3}));
    EXPECT_EQ(dataset.num_steps, 2);
    EXPECT_EQ(dataset.times, (std::vector<double>{10, 10.5}));
    EXPECT_EQ(dataset.time_unit, "d");
    EXPECT_TRUE(has_note(dataset, "days since 2000-01-01"));
    ASSERT_EQ(dataset.arrays.size(), 1U);
    const DataArray& temp = dataset.arrays[0];
    EXPECT_EQ(temp.name, "temp");
    EXPECT_EQ(temp.unit, "K");
    EXPECT_EQ(temp.value_scale, 0.5);
    EXPECT_EQ(temp.value_offset, 200);
    ASSERT_EQ(temp.type, ScalarType::kFloat32);  // of shorts, for the missing one
    const auto values = values_of<float>(temp);
    EXPECT_EQ(values[0], 24);
    EXPECT_EQ(values[23], 47);
    EXPECT_TRUE(std::isnan(values[7]));
  }
}

// Fails if levels in hPa are taken for degrees, or pressure for height.
TEST(Netcdf, LevelsBesideDegreesAreEven) {
  const Dataset dataset = read_nc(test_climate());
  const auto& world = dataset.lattice.world_from_index;
  EXPECT_EQ(world * Vec3(0, 0, 0), Vec3(0, 45, 0));
  EXPECT_EQ(world * Vec3(1, 1, 1), Vec3(2.5, 40, 2.5));
  EXPECT_TRUE(has_note(dataset, "'hPa' is no unit beside 'degrees'"));
  ReadOptions options;
  options.raw.spacing = Vec3(1, 2, 3);
  EXPECT_EQ(read_nc(test_climate(), options).lattice.world_from_index * Vec3(1, 1, 1),
            Vec3(1, 2, 3));
  TestNc deep = test_climate();
  variable_of(deep, "plev").attributes = {nc_text("units", "m"), nc_text("positive", "down")};
  variable_of(deep, "plev").bytes = big_endian<float>({1, 5, 100});
  EXPECT_EQ(read_nc(deep).lattice.world_from_index * Vec3(0, 0, 1), Vec3(0, 45, -2.5));
}

// Fails if depth goes up, lengths are not brought to one unit, or the mesh of an uneven axis lies
// elsewhere than its samples.
TEST(Netcdf, LengthsArePlaces) {
  const Dataset even = read_nc(test_simulation({1, 2, 3}));
  ASSERT_EQ(even.kind, DatasetKind::kLattice);
  EXPECT_EQ(even.lattice.world_from_index * Vec3(2, 1, 1), Vec3(3, 3, -0.5));
  EXPECT_EQ(values_of<float>(even.arrays[0])[11], 11);
  const Dataset uneven = read_nc(test_simulation({1, 2, 4}));
  ASSERT_EQ(uneven.kind, DatasetKind::kMesh);
  EXPECT_EQ(uneven.cells.dims, (Index3{3, 2, 2}));
  const auto places = values_of<float>(uneven.positions);
  ASSERT_EQ(places.size(), 36U);
  EXPECT_EQ((std::vector<float>(places.end() - 3, places.end())), (std::vector<float>{4, 3, -0.5}));
  EXPECT_EQ(values_of<float>(uneven.arrays[0])[2], 2);
  EXPECT_TRUE(has_note(uneven, "--spacing"));
  ReadOptions options;
  options.raw.spacing = Vec3(1, 1, 1);
  EXPECT_EQ(read_nc(test_simulation({1, 2, 4}), options).kind, DatasetKind::kLattice);
  for (const std::vector<float>& none :
       {std::vector<float>{1, 3, 2}, {1, 2, std::numeric_limits<float>::quiet_NaN()}}) {
    const Dataset dataset = read_nc(test_simulation(none));
    EXPECT_EQ(dataset.lattice.world_from_index * Vec3(1, 1, 1), Vec3(2, 3, -0.5));
    EXPECT_TRUE(has_note(dataset, "nothing says where samples of 'rho' lie along x"));
  }
}

TEST(Netcdf, DimensionsWithoutNamesAreInOrder) {
  TestNc nc;
  nc.dims = {{"Time", 0}, {"bottom_top", 2}, {"south_north", 3}, {"west_east", 2}};
  nc.num_records = 3;
  std::vector<std::int8_t> bytes(36);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::int8_t>(i - 3);
  nc.variables = {{"Q",
                   {0, 1, 2, 3},
                   kNcByte,
                   big_endian(bytes),
                   {nc_text("_Unsigned", "true"), {"_FillValue", kNcByte, "\xff"}}}};
  // The records of a lone variable are not padded; how many there are is not said.
  nc.is_being_written = true;
  ReadOptions options;
  options.step = 0;
  Dataset dataset = read_nc(nc, options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{2, 3, 2}));
  EXPECT_EQ(dataset.num_steps, 3);
  auto values = values_of<float>(dataset.arrays[0]);
  EXPECT_EQ(values[0], 253);
  EXPECT_TRUE(std::isnan(values[2]));
  options.step = 2;
  EXPECT_EQ(values_of<std::uint8_t>(read_nc(nc, options).arrays[0])[0], 21);
  options.raw.axis_order = "zyxc";
  options.step = {};
  dataset = read_nc(nc, options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{3, 2, 3}));
  EXPECT_EQ(dataset.arrays[0].num_components, 2);
  options.raw.axis_order = "zyxx";
  EXPECT_NE(error_of_nc(nc, options).find("each once"), std::string::npos);
}

TEST(Netcdf, VariablesAreChosen) {
  TestNc nc = test_simulation({1, 2, 3});
  nc.variables.push_back({"area", {1, 2}, kNcFloat, big_endian<float>({1, 2, 3, 4, 5, 6})});
  nc.variables.push_back({"u", {0, 1, 2}, kNcDouble, big_endian(std::vector<double>(12, 9.9))});
  Dataset dataset = read_nc(nc);
  ASSERT_EQ(dataset.arrays.size(), 2U);  // of three axes
  EXPECT_EQ(dataset.arrays[1].name, "u");
  ReadOptions options;
  options.array = "area";
  dataset = read_nc(nc, options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{3, 2, 1}));
  EXPECT_EQ(dataset.lattice.world_from_index * Vec3(1, 1, 0), Vec3(2, 3, 0));
  options.array = "v";
  EXPECT_EQ(error_of_nc(nc, options),
            "invalid-argument: a.nc: array 'v': no such variable of numbers: expected one of 'rho' "
            "(2, 2, 3), 'area' (2, 3), 'u' (2, 2, 3)");
  nc.dims.emplace_back("x2", 4);
  nc.variables.push_back({"w", {0, 1, 3}, kNcFloat, big_endian(std::vector<float>(16, 1))});
  EXPECT_EQ(error_of_nc(nc),
            "invalid-argument: a.nc: holds grids of several sizes: choose one with --array: 'rho' "
            "(2, 2, 3), 'u' (2, 2, 3), 'w' (2, 2, 4)");
  nc.variables = {{"list", {2}, kNcFloat, big_endian<float>({1, 2, 3})}};
  EXPECT_NE(error_of_nc(nc).find("unsupported: a.nc: is netCDF and holds no grid"),
            std::string::npos);
}

// What the library writes where nobody has.
TEST(Netcdf, UnwrittenFloatsAreMissing) {
  TestNc nc = test_simulation({1, 2, 3});
  std::vector<float> values(12, 1.5F);
  values[4] = 9.9692099683868690e+36F;
  variable_of(nc, "rho").bytes = big_endian(values);
  EXPECT_TRUE(std::isnan(values_of<float>(read_nc(nc).arrays[0])[4]));
}

// Fails if the library's own fill value is a sample, or a byte's is none.
TEST(Netcdf, UnwrittenIntegersAreMissingButForBytes) {
  TestNc nc = test_simulation({1, 2, 3});
  std::vector<std::int16_t> shorts(12, 3);
  shorts[4] = -32767;
  variable_of(nc, "rho").type = kNcShort;
  variable_of(nc, "rho").bytes = big_endian(shorts);
  EXPECT_TRUE(std::isnan(values_of<float>(read_nc(nc).arrays[0])[4]));
  variable_of(nc, "rho").attributes = {{"_FillValue", kNcShort, big_endian<std::int16_t>({9})}};
  EXPECT_EQ(read_nc(nc).arrays[0].type, ScalarType::kInt16);
  variable_of(nc, "rho").type = kNcByte;
  variable_of(nc, "rho").attributes.clear();
  variable_of(nc, "rho").bytes = big_endian(std::vector<std::int8_t>(12, -127));
  EXPECT_EQ(read_nc(nc).arrays[0].type, ScalarType::kInt8);
}

// Fails if a valid range is passed over, or taken for one of unpacked values.
TEST(Netcdf, SamplesOutsideOfTheValidRangeAreMissing) {
  TestNc nc = test_climate();
  variable_of(nc, "temp").attributes = {
      {"valid_range", kNcShort, big_endian<std::int16_t>({2, 40})},
      {"missing_value", kNcShort, big_endian<std::int16_t>({5, 7})}};
  Dataset dataset = read_nc(nc);
  auto values = values_of<float>(dataset.arrays[0]);
  EXPECT_TRUE(std::isnan(values[1]) && std::isnan(values[5]) && std::isnan(values[7]));
  EXPECT_EQ(values[2], 2);
  EXPECT_TRUE(has_note(dataset, "2 samples are outside of the valid range, 2 to 40"));
  variable_of(nc, "temp").attributes = {
      {"scale_factor", kNcDouble, big_endian<double>({0.5})},
      {"valid_max", kNcDouble, big_endian<double>({10})}};  // of 0.5 times the numbers
  values = values_of<float>(read_nc(nc).arrays[0]);
  EXPECT_EQ(values[20], 20);
  EXPECT_TRUE(std::isnan(values[21]));
  variable_of(nc, "temp").attributes = {{"valid_min", kNcShort, big_endian<std::int16_t>({99})}};
  dataset = read_nc(nc);
  EXPECT_EQ(dataset.arrays[0].type, ScalarType::kInt16);
  EXPECT_TRUE(has_note(dataset, "no sample lies in the valid range"));
}

// Fails if one axis without places drops those of the other, or longitudes end at a meridian.
TEST(Netcdf, PlacesOfOneAxisStay) {
  TestNc nc = test_climate();
  variable_of(nc, "rows").bytes = big_endian<float>({40, std::nanf("")});
  Dataset dataset = read_nc(nc);
  EXPECT_EQ(dataset.lattice.world_from_index * Vec3(1, 1, 0), Vec3(2.5, 2.5, 0));
  EXPECT_TRUE(has_note(dataset, "nothing says where samples of 'temp' lie along y"));
  nc = test_climate();
  variable_of(nc, "cols").bytes = big_endian<double>({350, 357.5, 5, 12.5});
  EXPECT_EQ(read_nc(nc).lattice.world_from_index * Vec3(3, 0, 0), Vec3(372.5, 45, 0));
  variable_of(nc, "rows").type = kNcShort;
  variable_of(nc, "rows").bytes = big_endian<std::int16_t>({450, 400});
  variable_of(nc, "rows")
      .attributes.push_back({"scale_factor", kNcDouble, big_endian<double>({0.1})});
  EXPECT_NEAR((read_nc(nc).lattice.world_from_index * Vec3(0, 1, 0)).y(), 40, 1e-9);
}

// A variable along a dimension says where it lies if it is alone in saying which axis it is.
TEST(Netcdf, CoordinatesAreToldByWhatTheySay) {
  TestNc nc;
  nc.dims = {{"i", 2}, {"j", 3}};
  nc.variables = {
      {"v",
       {0, 1},
       kNcFloat,
       big_endian<float>({0, 1, 2, 3, 4, 5}),
       {nc_text("coordinates", "b a")}},
      {"a", {0}, kNcFloat, big_endian<float>({5, 7}), {nc_text("units", "degrees_east ")}},
      {"b", {1}, kNcFloat, big_endian<float>({3, 4, 5}), {nc_text("standard_name", "latitude")}}};
  Dataset dataset = read_nc(nc);
  EXPECT_EQ(dataset.lattice.dims, (Index3{2, 3, 1}));
  EXPECT_EQ(dataset.lattice.world_from_index * Vec3(1, 2, 0), Vec3(7, 5, 0));
  EXPECT_EQ(values_of<float>(dataset.arrays[0]), (std::vector<float>{0, 3, 1, 4, 2, 5}));
  variable_of(nc, "b").dims = {0};  // the places of cells: neither is an axis
  variable_of(nc, "b").bytes = big_endian<float>({3, 4});
  EXPECT_EQ(read_nc(nc).lattice.dims, (Index3{3, 2, 1}));
  variable_of(nc, "b").dims = {0, 1};  // of a curved grid
  variable_of(nc, "b").bytes = big_endian(std::vector<float>(6, 1));
  variable_of(nc, "a").attributes.clear();
  EXPECT_TRUE(has_note(read_nc(nc), "'b', which 'v' names as places along an axis, has two axes"));
}

TEST(Netcdf, FilesAreSteps) {
  const TestFolder folder;
  TestNc nc = test_climate();
  nc.num_records = 1;
  variable_of(nc, "temp").bytes.resize(48);
  for (const double day : {3, 7}) {
    variable_of(nc, "when").bytes = big_endian<double>({day});
    folder.write(day == 3 ? "a.nc" : "b.nc", nc.bytes());
  }
  EXPECT_EQ(open_steps({folder.file("a.nc"), folder.file("b.nc")})->times(),
            (std::vector<double>{3, 7}));
}

// Fails if a step is read whole where it may stay in its file, or from another place.
TEST(Netcdf, StaysInItsFile) {
  const TestFolder folder;
  TestNc nc = test_climate();
  variable_of(nc, "temp").attributes.clear();
  ReadOptions options;
  options.step = 1;
  options.may_stay_in_file = true;
  options.memory_limit = 1;
  const Dataset dataset = read_dataset({folder.write("a.nc", nc.bytes())}, options);
  ASSERT_NE(dataset.arrays[0].stored, nullptr);
  std::vector<std::int16_t> values(24);
  dataset.arrays[0].stored->read(0, std::as_writable_bytes(std::span(values)));
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_EQ(values[i], static_cast<std::int16_t>(24 + i));
}

TEST(Netcdf, HostileHeaders) {
  const std::string whole = test_climate(2).bytes();
  for (std::size_t size = 4; size < whole.size(); ++size) {
    const std::string cut = whole.substr(0, size);
    EXPECT_NE(error_of([&] {
                read_netcdf_grid(*open_memory("a.nc", std::as_bytes(std::span(cut))), {});
              }).find("file-format: a.nc: "),
              std::string::npos)
        << size;
  }
  TestNc nc = test_simulation({1, 2, 3});
  nc.dims[0].second = 0x7fffffff;
  EXPECT_EQ(error_of_nc(nc),
            "file-format: a.nc: netCDF variable 'rho' needs 51539607528 bytes from 316 on, the "
            "file has 392: is it truncated?");
  nc.version = 5;
  for (auto& dim : nc.dims) dim.second = std::int64_t{1} << 59;
  EXPECT_NE(error_of_nc(nc).find("are more than any file holds"), std::string::npos);
  nc = test_simulation({1, 2, 3});
  nc.variables[0].dims[2] = 7;
  EXPECT_EQ(error_of_nc(nc), "file-format: a.nc: netCDF variable 'rho': dimension 7 of 3");
  nc = test_climate();
  nc.num_records = 0;
  for (TestNcVariable& one : nc.variables)
    one.bytes.resize(one.dims[0] == 0 ? 0 : one.bytes.size());
  EXPECT_NE(error_of_nc(nc), "");
}

TEST(Netcdf, ExodusIsAnotherFormat) {
  TestNc nc = test_simulation({1, 2, 3});
  nc.attributes = {{"api_version", kNcFloat, big_endian<float>({5.1F})}};
  const std::string bytes = nc.bytes();
  const auto source = open_memory("a.nc", std::as_bytes(std::span(bytes)));
  EXPECT_FALSE(is_netcdf_grid(*source, source->text(0, 512)));
  EXPECT_TRUE(is_exodus_header(read_netcdf_header(*source)));
}

}  // namespace netcdf_test
}  // namespace ovoid::io
