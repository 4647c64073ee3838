// SPDX-License-Identifier: Apache-2.0
// HDF5 files that say in words of their own how their arrays lie.
#ifdef OVOID_IO_HDF5
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/hdf5/test_hdf5.h"

namespace ovoid::io {
namespace hdf5_dialects_test {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> names_of(const Dataset& dataset) {
  std::vector<std::string> names;
  for (const DataArray& array : dataset.arrays) names.push_back(array.name);
  return names;
}

Vec3 spacing_of(const Dataset& dataset) {
  return dataset.lattice.world_from_index.linear().diagonal();
}

Vec3 origin_of(const Dataset& dataset) { return dataset.lattice.world_from_index.translation(); }

class Hdf5Dialects : public testing::Test {
 protected:
  Dataset read(const ReadOptions& options = {}) const { return read_dataset({path}, options); }

  TestFolder folder;
  std::string path = folder.file("a.h5");
};

// --- axes ---------------------------------------------------------------------------------------

TEST_F(Hdf5Dialects, AxisTagsSayAxesAndSpacing) {
  TestHdf5(path)
      .floats("/v", {3, 4, 5, 2})
      .text("/v", "axistags",
            R"({"axes": [{"key": "x", "resolution": 2}, {"key": "y", "resolution": 3.5},)"
            R"( {"key": "z", "resolution": 4}, {"key": "c", "resolution": 0}]})",
            true);
  const Dataset dataset = read();
  EXPECT_EQ(dataset.lattice.dims, (Index3{3, 4, 5}));
  EXPECT_EQ(dataset.array("v").num_components, 2);
  EXPECT_EQ(spacing_of(dataset), Vec3(2, 3.5, 4));
  EXPECT_EQ(values_of<float>(dataset.array("v"))[2], 41) << "the second along x";
  TestHdf5(path).floats("/v", {3, 4, 5}).text("/v", "axistags", "{\"axes\": 7", true);
  EXPECT_EQ(read().lattice.dims, (Index3{5, 4, 3}));
}

TEST_F(Hdf5Dialects, LabelsOfDimensionsSayAxes) {
  TestHdf5(path)
      .floats("/v", {2, 3, 4, 5})
      .texts("/v", "DIMENSION_LABELS", {"c", "Z", "lat", "lon"});
  EXPECT_THAT(names_of(read()), ElementsAre("v channel 1", "v channel 2"));
  TestHdf5(path).floats("/v", {2, 3, 4}).texts("/v", "DIMENSION_LABELS", {"a", "b", "c"});
  EXPECT_EQ(read().lattice.dims, (Index3{4, 3, 2})) << "words that say nothing";
}

// --- openPMD ------------------------------------------------------------------------------------

class OpenPmd : public Hdf5Dialects {
 protected:
  // A file with these words alone.
  TestHdf5 begin() const {
    TestHdf5 file(path);
    file.text("/", "openPMD", "1.1.0")
        .text("/", "basePath", "/data/%T/")
        .text("/", "meshesPath", "fields/");
    return file;
  }
  static void place(TestHdf5& file, const std::string& record,
                    const std::vector<std::string>& labels, const std::string& order = "C") {
    file.text(record, "geometry", "cartesian")
        .text(record, "dataOrder", order, true)
        .texts(record, "axisLabels", labels)
        .numbers(record, "gridSpacing", {4, 3, 2})
        .numbers(record, "gridGlobalOffset", {30, 20, 10})
        .number(record, "gridUnitSI", 1);
  }
};

TEST_F(OpenPmd, LabelsSayWhichAxisIsWhich) {
  const std::string rho = "/data/100/fields/rho";
  const auto read_with = [&](const std::vector<std::string>& labels, const std::string& order) {
    TestHdf5 file = begin();
    file.floats(rho, {2, 3, 4});
    place(file, rho, labels, order);
    file.numbers(rho, "position", {0.5, 0, 0});
    file.close();
    return read();
  };
  Dataset dataset = read_with({"z", "y", "x"}, "C");
  EXPECT_EQ(dataset.format, "HDF5 grid (openPMD)");
  EXPECT_THAT(names_of(dataset), ElementsAre("rho"));
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(spacing_of(dataset), Vec3(2, 3, 4));
  EXPECT_EQ(origin_of(dataset), Vec3(10, 20, 32));
  EXPECT_EQ(values_of<float>(dataset.array()), counting<float>(24));
  dataset = read_with({"x", "y", "z"}, "C");
  EXPECT_EQ(dataset.lattice.dims, (Index3{2, 3, 4}));
  EXPECT_EQ(spacing_of(dataset), Vec3(4, 3, 2));
  EXPECT_EQ(origin_of(dataset), Vec3(32, 20, 10));
  EXPECT_EQ(values_of<float>(dataset.array())[1], 13);
  dataset = read_with({"y", "z", "x"}, "C");
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 2, 3}));
  EXPECT_EQ(origin_of(dataset), Vec3(10, 32, 20));
  // Written by Fortran, whose first axis is the last of the file.
  dataset = read_with({"x", "y", "z"}, "F");
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(spacing_of(dataset), Vec3(4, 3, 2));
  EXPECT_EQ(origin_of(dataset), Vec3(32, 20, 10));
}

TEST_F(OpenPmd, IterationsAreStepsAndComponentsArrays) {
  TestHdf5 file = begin();
  for (const char* const number : {"100", "20"}) {
    const std::string root = std::string("/data/") + number, e = root + "/fields/E";
    file.group(root).number(root, "time", number[0] - '0').number(root, "timeUnitSI", 1e-15);
    file.floats(e + "/x", {2, 3, 4}).group(e + "/y").group(e + "/z");
    place(file, e, {"z", "y", "x"});
    file.number(e + "/y", "value", 2.5).numbers(e + "/y", "shape", {2, 3, 4});
    file.number(e + "/z", "value", 0).numbers(e + "/z", "shape", {2, 3, 5});
    file.number(e + "/x", "unitSI", 3e8).numbers(e + "/x", "position", {0, 0, 0.5});
  }
  file.close();
  // The one of 20, whose time comes later, is the first.
  ReadOptions options;
  options.array = "E/x";
  const Dataset dataset = read(options);
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_TRUE(dataset.times.empty()) << "they fall";
  EXPECT_THAT(names_of(dataset), ElementsAre("E/x"));
  EXPECT_EQ(origin_of(dataset), Vec3(11, 20, 30));
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("values of 'E/x' are in units of 3e+08")));
  options.array.clear();
  EXPECT_THAT(hdf5_error_of(path, options), HasSubstr("'E/z' [2, 3, 5] lies elsewhere"));
  options.array = "E/q";
  EXPECT_THAT(hdf5_error_of(path, options), HasSubstr("it has 'E/x', 'E/y', 'E/z'"));
}

TEST_F(OpenPmd, ConstantsStandBesideOthers) {
  TestHdf5 file = begin();
  file.floats("/data/1/fields/E/x", {2, 3, 4}).group("/data/1/fields/E/y");
  file.group("/data/1/fields/T");
  place(file, "/data/1/fields/E", {"z", "y", "x"});
  place(file, "/data/1/fields/T", {"z", "y", "x"});
  for (const char* const constant : {"/data/1/fields/E/y", "/data/1/fields/T"})
    file.number(constant, "value", 2.5).numbers(constant, "shape", {2, 3, 4});
  file.number("/data/1", "time", 7);
  file.close();
  const Dataset dataset = read();
  EXPECT_THAT(names_of(dataset), ElementsAre("E/x", "E/y", "T"));
  EXPECT_EQ(values_of<float>(dataset.array("T")), std::vector<float>(24, 2.5F));
  EXPECT_EQ(dataset.times, std::vector<double>{7});
}

TEST_F(OpenPmd, OtherGeometriesAreNamed) {
  TestHdf5 file = begin();
  file.floats("/data/1/fields/E/r", {3, 4, 5});
  file.text("/data/1/fields/E", "geometry", "thetaMode");
  file.close();
  EXPECT_THAT(hdf5_error_of(path),
              HasSubstr("nothing in '/data/1/fields' is drawn: 'E/r' is given by modes around an "
                        "axis (geometry thetaMode)"));
  TestHdf5 other = begin();
  other.floats("/data/1/fields/T", {3, 4, 5});
  place(other, "/data/1/fields/T", {"phi", "r", "z"});
  H5Adelete_by_name(other.id(), "/data/1/fields/T", "geometry", H5P_DEFAULT);
  other.text("/data/1/fields/T", "geometry", "cylindrical");
  other.close();
  EXPECT_THAT(read().notes, Contains(HasSubstr("'T' is in cylindrical coordinates (phi, r, z)")));
}

// Particles alone are read as before.
TEST_F(OpenPmd, ParticlesAreNamedWhereMeshesAreRead) {
  const auto write = [&](bool has_meshes) {
    TestHdf5 file = begin();
    file.text("/", "particlesPath", "particles/");
    for (const char* const axis : {"x", "y", "z"})
      file.floats(std::string("/data/1/particles/e/position/") + axis, {5});
    if (has_meshes) file.floats("/data/1/fields/T", {3, 4, 5});
  };
  write(false);
  EXPECT_EQ(read().kind, DatasetKind::kParticles);
  write(true);
  const Dataset dataset = read();
  EXPECT_EQ(dataset.kind, DatasetKind::kLattice);
  EXPECT_THAT(dataset.notes,
              Contains(HasSubstr("--positions /data/1/particles/e/position/x takes particles")));
  ReadOptions options;
  options.hdf5.positions = "/data/1/particles/e/position/x";
  EXPECT_EQ(read(options).num_positions(), 5);
}

// --- Imaris -------------------------------------------------------------------------------------

TEST_F(Hdf5Dialects, ImarisIsCroppedPlacedAndInTime) {
  TestHdf5 file(path);
  file.characters("/", "ImarisDataSet", "ImarisDataSet");
  for (int level = 0; level < 2; ++level) {
    for (int point = 0; point < 2; ++point) {
      for (int channel = 0; channel < 2; ++channel) {
        const std::string group = "/DataSet/ResolutionLevel " + std::to_string(level) +
                                  "/TimePoint " + std::to_string(point) + "/Channel " +
                                  std::to_string(channel);
        file.dataset(group + "/Data", {4, 4, 4}, counting<std::uint16_t>(64));
        file.characters(group, "ImageSizeX", level == 0 ? "3" : "2")
            .characters(group, "ImageSizeY", "2")
            .characters(group, "ImageSizeZ", "1");
      }
    }
  }
  const std::string image = "/DataSetInfo/Image";
  file.group(image).group("/DataSetInfo/Channel 1").group("/DataSetInfo/TimeInfo");
  const char* const extents[][2] = {{"ExtMin0", "9"},   {"ExtMax0", "15"}, {"ExtMin1", "-3"},
                                    {"ExtMax1", "3.5"}, {"ExtMin2", "28"}, {"ExtMax2", "44"}};
  for (const auto& [name, value] : extents) file.characters(image, name, value);
  file.characters(image, "Unit", "um").characters("/DataSetInfo/Channel 1", "Name", "GFP");
  file.characters("/DataSetInfo/TimeInfo", "TimePoint1", "2017-05-03 23:59:59.500")
      .characters("/DataSetInfo/TimeInfo", "TimePoint2", "2017-05-04 00:00:02.000");
  file.close();
  ReadOptions options;
  options.step = 1;
  Dataset dataset = read(options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{3, 2, 1}));
  EXPECT_EQ(spacing_of(dataset), Vec3(2, 3.25, 16));
  EXPECT_EQ(origin_of(dataset), Vec3(10, -1.375, 36));
  EXPECT_THAT(names_of(dataset), ElementsAre("Channel 0", "GFP"));
  EXPECT_EQ(values_of<std::uint16_t>(dataset.array("GFP")),
            (std::vector<std::uint16_t>{1, 2, 3, 5, 6, 7}));
  EXPECT_EQ(dataset.times, (std::vector<double>{0, 2.5}));
  EXPECT_EQ(dataset.time_unit, "s");
  EXPECT_EQ(dataset.block, "ResolutionLevel 0");
  options.block = "ResolutionLevel 1";
  options.array = "GFP";
  dataset = read(options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{2, 2, 1}));
  EXPECT_EQ(spacing_of(dataset), Vec3(3, 3.25, 16));
  EXPECT_THAT(names_of(dataset), ElementsAre("GFP"));
  options.array = "RFP";
  EXPECT_THAT(hdf5_error_of(path, options), HasSubstr("it has 'Channel 0', 'GFP'"));
}

TEST_F(Hdf5Dialects, ImarisSizesBeyondTheDataAreRefused) {
  const std::string group = "/DataSet/ResolutionLevel 0/TimePoint 0/Channel 0";
  TestHdf5(path)
      .characters("/", "ImarisVersion", "5.5.0")
      .floats(group + "/Data", {4, 4, 4})
      .characters(group, "ImageSizeX", "5");
  EXPECT_THAT(hdf5_error_of(path), HasSubstr("ImageSizeX = 5: expected 1 to 4"));
}

// --- BigDataViewer ------------------------------------------------------------------------------

TEST_F(Hdf5Dialects, BigDataViewerHasResolutionsSetupsAndTime) {
  TestHdf5 file(path);
  for (const char* const group : {"/t00000/s00", "/t00000/s01", "/t00001/s00", "/t00001/s01"}) {
    std::vector<std::int16_t> values(24, -1);
    values[0] = 5;
    file.dataset(std::string(group) + "/0/cells", {2, 3, 4}, values);
    file.dataset(std::string(group) + "/1/cells", {1, 2, 2}, std::vector<std::int16_t>(4, 3));
  }
  file.dataset("/s00/resolutions", {2, 3}, std::vector<double>{1, 1, 1, 2, 2, 2});
  file.close();
  Dataset dataset = read();
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_THAT(names_of(dataset), ElementsAre("s00", "s01"));
  EXPECT_EQ(values_of<std::uint16_t>(dataset.array("s00"))[1], 65535) << "unsigned";
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("stand in the XML file beside it")));
  ReadOptions options;
  options.block = "1";
  options.step = 0;
  dataset = read(options);
  EXPECT_EQ(spacing_of(dataset), Vec3(2, 2, 2));
  EXPECT_EQ(origin_of(dataset), Vec3(0.5, 0.5, 0.5));
  options.raw.spacing = Vec3(1, 2, 3);
  EXPECT_EQ(spacing_of(read(options)), Vec3(1, 2, 3));
}

// --- FLASH --------------------------------------------------------------------------------------

// A block of 2, of which the lower half is refined once: rows 0 (a parent), 1 and 2 (leaves).
TEST_F(Hdf5Dialects, FlashLeavesAreBoxes) {
  const Hdf5Handle text(H5Tcopy(H5T_C_S1), H5Tclose), scalar(H5Tcreate(H5T_COMPOUND, 88), H5Tclose);
  H5Tset_size(text.get(), 80);
  H5Tinsert(scalar.get(), "name", 0, text.get());
  H5Tinsert(scalar.get(), "value", 80, H5T_NATIVE_DOUBLE);
  std::string time(88, ' ');
  const double now = 2.5;
  time.replace(0, 4, "time").replace(80, 8, bytes_of(std::vector<double>{now}));
  TestHdf5(path)
      .dataset("/node type", {3}, std::vector<std::int32_t>{2, 1, 1})
      .dataset("/bounding box", {3, 3, 2},
               std::vector<double>{0, 4, 0, 1, 0, 1, 0, 2, 0, 1, 0, 1, 2, 4, 0, 1, 0, 1})
      .dataset("/refine level", {3}, std::vector<std::int32_t>{1, 2, 2})
      .floats("/dens", {3, 1, 1, 2})
      .floats("/c12 ", {3, 1, 1, 2})
      .floats("/face", {3, 1, 1, 3})
      .raw("/real scalars", {1}, time, scalar.get());
  Dataset dataset = read();
  EXPECT_EQ(dataset.format, "FLASH");
  EXPECT_EQ(dataset.kind, DatasetKind::kBoxes);
  EXPECT_THAT(names_of(dataset), ElementsAre("c12", "dens"));
  EXPECT_EQ(values_of<double>(dataset.positions),
            (std::vector<double>{0.5, 0.5, 0.5, 1.5, 0.5, 0.5, 2.5, 0.5, 0.5, 3.5, 0.5, 0.5}));
  EXPECT_EQ(values_of<double>(dataset.box_sizes), std::vector<double>(12, 1));
  EXPECT_EQ(values_of<float>(dataset.array("dens")), (std::vector<float>{3, 4, 5, 6}));
  EXPECT_EQ(dataset.times, std::vector<double>{2.5});
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("'/face' [3, 1, 1, 3] is left out")));
  ReadOptions options;
  options.array = "dens";
  EXPECT_THAT(names_of(read(options)), ElementsAre("dens"));
  options.array = "pres";
  EXPECT_THAT(hdf5_error_of(path, options), HasSubstr("array 'pres': no such array: it has"));
  options.array = "dens";
  options.share = RowShare{1, 2};
  EXPECT_EQ(values_of<float>(read(options).array("dens")), (std::vector<float>{5, 6}));
}

TEST_F(Hdf5Dialects, FlashOfTwoDimensionsIsALayer) {
  TestHdf5(path)
      .dataset("/node type", {1}, std::vector<std::int32_t>{1})
      .dataset("/bounding box", {1, 3, 2}, std::vector<double>{0, 4, 0, 3, 0, 0})
      .floats("/dens", {1, 1, 3, 2});
  const Dataset dataset = read();
  EXPECT_EQ(values_of<double>(dataset.box_sizes)[0], 2);
  EXPECT_EQ(values_of<double>(dataset.box_sizes)[1], 1);
  EXPECT_EQ(values_of<double>(dataset.box_sizes)[2], 1);
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("fewer than three dimensions")));
}

TEST_F(Hdf5Dialects, FlashThatContradictsItselfIsRefused) {
  TestHdf5(path)
      .dataset("/node type", {2}, std::vector<std::int32_t>{1, 1})
      .dataset("/bounding box", {2, 3, 2}, std::vector<double>{0, 1, 0, 1, 0, 1, 0, 1, 1, 0, 0, 1})
      .floats("/dens", {2, 2, 2, 2});
  EXPECT_THAT(hdf5_error_of(path), HasSubstr("block 1: its cells have no size"));
  TestHdf5(path)
      .dataset("/node type", {2}, std::vector<std::int32_t>{3, 2})
      .dataset("/bounding box", {2, 3, 2}, std::vector<double>(12, 1))
      .floats("/dens", {2, 2, 2, 2});
  EXPECT_THAT(hdf5_error_of(path), HasSubstr("has no blocks"));
  TestHdf5(path)
      .dataset("/node type", {2}, std::vector<std::int32_t>{1, 1})
      .dataset("/bounding box", {1, 3, 2}, std::vector<double>(6, 1));
  EXPECT_THAT(hdf5_error_of(path), HasSubstr("looks like FLASH's"));
}

// --- Athena++ -----------------------------------------------------------------------------------

TEST_F(Hdf5Dialects, AthenaBlocksAreBoxes) {
  const auto write = [&](const std::vector<double>& counts) {
    TestHdf5(path)
        .dataset("/Levels", {2}, std::vector<std::int32_t>{0, 1})
        .dataset("/LogicalLocations", {2, 3}, std::vector<std::int64_t>(6, 0))
        .dataset("/x1f", {2, 3}, std::vector<float>{0, 1, 3, 3, 4, 5})
        .dataset("/x2f", {2, 2}, std::vector<float>{0, 1, 0, 1})
        .dataset("/x3f", {2, 2}, std::vector<float>{-0.5, 0.5, -0.5, 0.5})
        .floats("/prim", {2, 2, 1, 1, 2})
        .floats("/B", {1, 2, 1, 1, 2})
        .texts("/", "DatasetNames", {"prim", "B"})
        .texts("/", "VariableNames", {"rho", "press", "Bcc1"})
        .numbers("/", "NumVariables", counts)
        .text("/", "Coordinates", "cartesian")
        .number("/", "Time", 1.5);
  };
  write({2, 1});
  const Dataset dataset = read();
  EXPECT_EQ(dataset.kind, DatasetKind::kBoxes);
  EXPECT_THAT(names_of(dataset), ElementsAre("rho", "press", "Bcc1"));
  EXPECT_EQ(values_of<float>(dataset.array("press")), (std::vector<float>{5, 6, 7, 8}));
  EXPECT_EQ(values_of<double>(dataset.positions),
            (std::vector<double>{0.5, 0.5, 0, 2, 0.5, 0, 3.5, 0.5, 0, 4.5, 0.5, 0}));
  EXPECT_EQ(values_of<double>(dataset.box_sizes)[3], 2) << "cells of their own size";
  EXPECT_EQ(dataset.times, std::vector<double>{1.5});
  write({2, 2});
  EXPECT_THAT(hdf5_error_of(path), HasSubstr("'B' has 1 variables"));
}

}  // namespace hdf5_dialects_test
}  // namespace ovoid::io
#endif
