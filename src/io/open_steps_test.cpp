// SPDX-License-Identifier: Apache-2.0
// Fails if a step is not the one that read_dataset reads, if times are made up or believed that do
// not rise, or if an error does not name its file and step.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "io/core/test_data.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/step_times.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

namespace ovoid::io {
namespace open_steps_test {

// 2 x 2 x 1 samples, all `value`.
std::string nrrd(int value, const std::string& type = "uint8", const std::string& sizes = "2 2 1") {
  const std::string header =
      fmt::format("NRRD0004\ntype: {}\ndimension: 3\nsizes: {}\nencoding: raw\nendian: little\n\n",
                  type, sizes);
  return header + std::string(type == "uint8" ? 4 : 8, static_cast<char>(value));
}

int first_value(const Dataset& dataset) {
  return std::to_integer<int>(dataset.arrays.at(0).bytes.view.front());
}

// A VTI of one sample, with what stands in its field data.
std::string vti(const std::string& field_data) {
  return "<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\">"
         "<ImageData WholeExtent=\"0 1 0 0 0 0\" Origin=\"0 0 0\" Spacing=\"1 1 1\">" +
         field_data +
         "<Piece Extent=\"0 1 0 0 0 0\"><PointData>"
         "<DataArray type=\"UInt8\" Name=\"v\" format=\"ascii\">1 2</DataArray>"
         "</PointData></Piece></ImageData></VTKFile>";
}

std::string time_value(const std::string& text) {
  return "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
         "format=\"ascii\"> " +
         text + " </DataArray></FieldData>";
}

std::string frame(const std::string& time, int num_atoms = 2) {
  std::string text = fmt::format(
      "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n0 9\n"
      "ITEM: ATOMS id x y z q\n",
      time, num_atoms);
  for (int i = 0; i < num_atoms; ++i) text += fmt::format("{} {} 1 2 0.5\n", i + 1, i);
  return text;
}

TEST(OpenSteps, FilesKeepTheirOrderAndNumbers) {
  const TestFolder folder;
  std::vector<std::string> paths;
  for (const int number : {1, 10, 2})
    paths.push_back(folder.write(fmt::format("s{}.nrrd", number), nrrd(number)));
  const auto steps = open_steps(paths);
  EXPECT_EQ(steps->num_steps(), 3);
  EXPECT_FALSE(steps->has_times());
  EXPECT_EQ(steps->times(), (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(steps->kind(), SeriesKind::kSteps);
  EXPECT_EQ(steps->name(), paths[0] + " and 2 more");
  EXPECT_EQ(first_value(steps->read(1)), 10);
  EXPECT_EQ(steps->read(2).source, paths[2]);
  EXPECT_EQ(steps->read(2).step, 2);
}

TEST(OpenSteps, OneVolumeIsASeriesOfOne) {
  const TestFolder folder;
  const std::string path = folder.write("a.nrrd", nrrd(7));
  const auto steps = open_steps({path});
  EXPECT_EQ(steps->num_steps(), 1);
  EXPECT_EQ(steps->times(), std::vector<double>{0});
  EXPECT_EQ(first_value(steps->read(0)), 7);
  EXPECT_NE(error_of([&] { steps->read(1); }).find("step 1: expected 0 to 0"), std::string::npos);
}

TEST(OpenSteps, WhatIsMissingIsNamedAtOnce) {
  const TestFolder folder;
  const std::string path = folder.write("a.nrrd", nrrd(7));
  const std::string missing = folder.file("b.nrrd");
  EXPECT_NE(error_of([&] { open_steps({path, missing}); }).find(missing), std::string::npos);
  // What is there and cannot be read is named when it is.
  const std::string broken = folder.write("c.nrrd", "NRRD0004\ntype: mango\n\n");
  const auto steps = open_steps({path, broken});
  EXPECT_NE(error_of([&] { steps->read(1); }).find(broken), std::string::npos);
}

TEST(OpenSteps, StepsOfOtherSizesAndTypesAreNamed) {
  const TestFolder folder;
  const std::string a = folder.write("a.nrrd", nrrd(1));
  const std::string b = folder.write("b.nrrd", nrrd(1, "uint8", "4 1 1"));
  const std::string c = folder.write("c.nrrd", nrrd(1, "uint16"));
  EXPECT_EQ(error_of([&] {
              open_steps({a, c, b});
            }),
            "invalid-argument: " + b + ": is 4x1x1, " + a +
                " is 2x2x1: several inputs are steps of one dataset, alike in kind, dimensions and "
                "spacing");
  const Series series(open_steps({a, c}), {.prefetch = false});
  series.step(0);
  EXPECT_EQ(error_of([&] { series.step(1); }),
            "file-format: " + c +
                ": step 1: array 'values' is uint16, in step 0 uint8: the steps "
                "of a series are alike");
}

// Fails if the first of files that cannot be steps of one dataset is read without a word.
TEST(OpenSteps, FilesThatAreNoStepsAreNamed) {
  const TestFolder folder;
  const auto meta = [](const std::string& spacing) {
    return "ObjectType = Image\nNDims = 3\nDimSize = 2 2 1\nElementSpacing = " + spacing +
           "\nElementType = MET_UCHAR\nElementDataFile = LOCAL\nabcd";
  };
  const auto legacy = [](const std::string& dims) {
    return "# vtk DataFile Version 3.0\na dataset\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS " +
           dims +
           "\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 4\nSCALARS v unsigned_char\n"
           "LOOKUP_TABLE default\n1 2 3 4\n";
  };
  const std::string lattice = folder.write("a.nrrd", nrrd(1));
  const std::string particles = folder.write("b.csv", "x,y,z\n1,2,3\n");
  const std::vector<std::vector<std::string>> cases = {
      {lattice, particles, "holds particles, " + lattice + " lattice"},
      {particles, lattice, "holds lattice, " + particles + " particles"},
      {lattice, folder.write("c.dump", frame("0")), "holds particles"},
      {folder.write("a.mha", meta("1 1 1")), folder.write("b.mha", meta("1 2 1")),
       "has spacings 1 2 1, " + folder.file("a.mha") + " has 1 1 1"},
      {folder.write("a.vti", vti("")), folder.write("b.vti", with(vti(""), "\"0 1 0", "\"0 7 0")),
       "is 8x1x1, " + folder.file("a.vti") + " is 2x1x1"},
      {folder.file("a.vti"),
       folder.write("c.vti", with(vti(""), "Spacing=\"1 1 1\"", "Spacing=\"2 1 1\"")),
       "has spacings 2 1 1"},
      {folder.write("a.vtk", legacy("2 2 1")), folder.write("b.vtk", legacy("4 1 1")),
       "is 4x1x1, " + folder.file("a.vtk") + " is 2x2x1"},
      {particles, folder.file("a.vtk"), "holds lattice"},
      {folder.write("a.ply", "ply\nformat ascii 1.0\n"), folder.file("a.vti"), "holds lattice"}};
  for (const auto& files : cases) {
    const std::string error = error_of([&] { read_dataset({files[0], files[1]}); });
    EXPECT_EQ(error.find("invalid-argument: " + files[1] + ": " + files[2]), 0U) << error;
    ReadOptions last;
    last.step = 1;
    EXPECT_EQ(error_of([&] { read_dataset({files[0], files[1]}, last); }), error);
  }
  // Rounded otherwise, and what cannot be told.
  EXPECT_EQ(
      open_steps({folder.file("a.mha"), folder.write("c.mha", meta("1 1.0001 1"))})->num_steps(),
      2);
  EXPECT_EQ(open_steps({lattice, folder.write("d.nrrd", "broken")})->num_steps(), 2);
}

TEST(OpenSteps, OneStepOfManyInAFile) {
  const TestFolder folder;
  // Three steps of a NRRD file with times 0.5, 0.75, 1.
  const std::string header =
      "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 1 1 3\nkinds: space space space time\n"
      "spacings: 1 1 1 0.25\naxis mins: 0 0 0 0.5\ncenterings: node node node node\n"
      "encoding: raw\n\n";
  const auto steps = open_steps({folder.write("a.nrrd", header + "aabbcc")});
  EXPECT_EQ(steps->num_steps(), 3);
  EXPECT_TRUE(steps->has_times());
  EXPECT_EQ(steps->times(), (std::vector<double>{0.5, 0.75, 1}));
  EXPECT_EQ(first_value(steps->read(1)), 'b');
  const std::string falling = with(header, "1 1 1 0.25", "1 1 1 -0.25");
  EXPECT_FALSE(open_steps({folder.write("b.nrrd", falling + "aabbcc")})->has_times());
}

TEST(OpenSteps, FramesOfADumpNameTheirTimes) {
  const TestFolder folder;
  const auto steps =
      open_steps({folder.write("a.dump", frame("0") + frame("50", 3) + frame("75"))});
  EXPECT_EQ(steps->times(), (std::vector<double>{0, 50, 75}));
  EXPECT_EQ(steps->read(1).num_positions(), 3);
  const std::string twice = folder.write("b.dump", frame("0") + frame("50") + frame("50"));
  EXPECT_EQ(error_of([&] { open_steps({twice}); }),
            "file-format: " + twice +
                ": step 2: time 50 is not after 50, the time of step 1: expected rising times");
}

TEST(OpenSteps, FilesThatAllNameATimeHaveIt) {
  const TestFolder folder;
  const std::string a = folder.write("a.dump", frame("100"));
  const std::string b = folder.write("b.dump", frame("250"));
  const std::string c = folder.write("c.dump", frame("100"));
  EXPECT_EQ(open_steps({a, b})->times(), (std::vector<double>{100, 250}));
  EXPECT_EQ(error_of([&] {
              open_steps({b, a});
            }),
            "file-format: " + a + ": step 1: time 100 is not after 250, the time of step 0 (" + b +
                "): expected rising times");
  // The same in all: nobody knew it.
  EXPECT_FALSE(open_steps({a, c})->has_times());
}

TEST(StepTimes, OfVtkFilesStandInTheirFieldData) {
  const auto time_in = [](const std::string& text) {
    return named_time(*open_memory("a.vti", std::as_bytes(std::span(text))));
  };
  EXPECT_EQ(time_in(vti(time_value("0.125"))), 0.125);
  EXPECT_EQ(time_in(vti("<FieldData><DataArray Name=\"TimeValue\" NumberOfTuples=\"1\" "
                        "format=\"appended\" RangeMin=\"2.5\" RangeMax=\"2.5\" offset=\"0\"/>"
                        "</FieldData>")),
            2.5);
  EXPECT_EQ(time_in(vti("")), std::nullopt);
  EXPECT_EQ(time_in(vti("<FieldData></FieldData>")), std::nullopt);
  EXPECT_EQ(time_in(vti(time_value("soon"))), std::nullopt);
  EXPECT_NE(error_of([&] { time_in("<VTKFile"); }).find("a.vti: the tag"), std::string::npos);
  EXPECT_NE(error_of([] {
              check_step_times({"a.vti", "b.vti"}, {0.0, std::numeric_limits<double>::infinity()});
            }).find("b.vti: step 1: time inf: expected a finite number"),
            std::string::npos);
}

// With VTK, real files of every kind that has steps.
TEST(OpenSteps, RealSeriesAreReadStepByStep) {
  const std::vector<std::pair<std::vector<std::string>, std::int64_t>> inputs = {
      {{"isabel/isabel_30.vti", "isabel/isabel_31.vti"}, 2},
      {{"mug/mug.e"}, 21},
      {{"can/can_0.hdf", "can/can_1.hdf", "can/can_2.hdf"}, 3},
      {{"md_water/spce_all_coords.lammpstrj.bz2"}, 11},
      {{"mri_nifti/example4d.nii.gz"}, 2},
      {{"disk_out_ref/disk_out_ref.ex2"}, 1}};
  for (const auto& [names, num_steps] : inputs) {
    std::vector<std::string> paths;
    for (const std::string& name : names) paths.push_back(real_data_path(name));
    if (paths[0].empty()) GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
    try {
      const Series series(open_steps(paths));
      EXPECT_EQ(series.num_steps(), num_steps) << paths[0];
      for (std::int64_t step = 0; step < std::min<std::int64_t>(num_steps, 3); ++step)
        EXPECT_EQ(series.step(step)->step, step) << paths[0];
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kUnsupported) throw;  // built without its reader
    }
  }
}

}  // namespace open_steps_test
}  // namespace ovoid::io
