// SPDX-License-Identifier: Apache-2.0
// read_dataset and write_dataset as callers see them: files, formats, round trips.
#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>
#include <string>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"
#include "support/where.h"

namespace ovoid::io {
namespace dataset_files_test {

Dataset oblique_dataset() {
  Dataset dataset;
  dataset.lattice.dims = {4, 3, 2};
  dataset.lattice.world_from_index = Eigen::Translation3d(10, -20, 30) *
                                     Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()) *
                                     Eigen::Scaling(0.5, 1.0, 2.5);
  dataset.arrays.push_back(make_array("speed", ScalarType::kFloat32, counting<float>(24)));
  return dataset;
}

// A build without VTK can write its files, but not read them.
bool has_vtk() {
  const TestFolder folder;
  Dataset dataset;
  dataset.lattice.dims = {1, 1, 1};
  dataset.arrays = {make_array<float>("a", ScalarType::kFloat32, {1})};
  write_dataset(dataset, folder.file("probe.vti"));
  return error_of([&] { read_dataset({folder.file("probe.vti")}); }).find("no VTK") ==
         std::string::npos;
}

void expect_same_array(const DataArray& a, const DataArray& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.type, b.type);
  EXPECT_EQ(a.num_components, b.num_components);
  EXPECT_EQ(a.num_tuples, b.num_tuples);
  EXPECT_EQ(a.unit, b.unit);
  EXPECT_EQ(a.is_cell_data, b.is_cell_data);
  EXPECT_EQ(values_of<std::uint8_t>(a), values_of<std::uint8_t>(b));
}

TEST(DatasetFiles, EveryFormatKeepsTheSamples) {
  const TestFolder folder;
  const Dataset dataset = oblique_dataset();
  for (const char* name : {"a.nrrd", "a.nhdr", "a.npy", "b_4x3x2_float32.raw", "A.NRRD"}) {
    write_dataset(dataset, folder.file(name));
    const Dataset back = read_dataset({folder.file(name)});
    EXPECT_EQ(back.lattice.dims, dataset.lattice.dims) << name;
    EXPECT_EQ(values_of<float>(back.array()), values_of<float>(dataset.array())) << name;
    EXPECT_EQ(back.source, folder.file(name));
  }
}

TEST(DatasetFiles, VtiKeepsEverything) {
  if (!has_vtk()) GTEST_SKIP() << "this build has no VTK";
  const TestFolder folder;
  Dataset dataset = oblique_dataset();
  dataset.arrays[0].unit = "m/s";
  // Every type; vectors; cells, of which there are 3 x 2 x 1.
  dataset.arrays.push_back(make_array("u8", ScalarType::kUInt8, counting<std::uint8_t>(24)));
  dataset.arrays.push_back(make_array("i8", ScalarType::kInt8, counting<std::int8_t>(24)));
  dataset.arrays.push_back(make_array("u16", ScalarType::kUInt16, counting<std::uint16_t>(24)));
  dataset.arrays.push_back(make_array("i16", ScalarType::kInt16, counting<std::int16_t>(24)));
  dataset.arrays.push_back(make_array("u32", ScalarType::kUInt32, counting<std::uint32_t>(24)));
  dataset.arrays.push_back(make_array("i32", ScalarType::kInt32, counting<std::int32_t>(24)));
  dataset.arrays.push_back(make_array("u64", ScalarType::kUInt64, counting<std::uint64_t>(24)));
  dataset.arrays.push_back(make_array("i64", ScalarType::kInt64, counting<std::int64_t>(24)));
  dataset.arrays.push_back(make_array("vector", ScalarType::kFloat64, counting<double>(72), 3));
  dataset.arrays.push_back(make_array("cells", ScalarType::kInt16, counting<std::int16_t>(6)));
  dataset.arrays.back().is_cell_data = true;
  write_dataset(dataset, folder.file("a.vti"));
  EXPECT_EQ(folder.count(), 1);
  const Dataset back = read_dataset({folder.file("a.vti")});
  EXPECT_EQ(back.lattice.dims, dataset.lattice.dims);
  EXPECT_EQ(back.lattice.world_from_index.matrix(), dataset.lattice.world_from_index.matrix());
  ASSERT_EQ(back.arrays.size(), dataset.arrays.size());
  for (std::size_t i = 0; i < back.arrays.size(); ++i)
    expect_same_array(back.arrays[i], dataset.arrays[i]);
  EXPECT_TRUE(back.notes.empty());
  // The same dataset gives the same bytes.
  write_dataset(dataset, folder.file("b.vti"));
  EXPECT_EQ(folder.read("a.vti"), folder.read("b.vti"));
}

TEST(DatasetFiles, VtiReadsOneArrayIfAsked) {
  if (!has_vtk()) GTEST_SKIP() << "this build has no VTK";
  const TestFolder folder;
  Dataset dataset = oblique_dataset();
  dataset.arrays.push_back(make_array("other", ScalarType::kUInt8, counting<std::uint8_t>(24)));
  write_dataset(dataset, folder.file("a.vti"));
  ReadOptions options;
  options.array = "other";
  const Dataset back = read_dataset({folder.file("a.vti")}, options);
  ASSERT_EQ(back.arrays.size(), 1U);
  expect_same_array(back.arrays[0], dataset.arrays[1]);
  options.array = "none";
  EXPECT_EQ(error_of([&] { read_dataset({folder.file("a.vti")}, options); }),
            "invalid-argument: " + folder.file("a.vti") +
                ": array 'none': not there: expected one of 'speed', 'other'");
}

TEST(DatasetFiles, LegacyVtkKeepsAxisAlignedVolumes) {
  if (!has_vtk()) GTEST_SKIP() << "this build has no VTK";
  const TestFolder folder;
  Dataset dataset = oblique_dataset();
  EXPECT_EQ(
      error_of([&] { write_dataset(dataset, folder.file("a.vtk")); }),
      "unsupported: " + folder.file("a.vtk") +
          ": legacy VTK knows no axis directions, the lattice is rotated or flipped: write .vti");
  EXPECT_EQ(folder.count(), 0);
  dataset.lattice.world_from_index =
      Eigen::Translation3d(10, -20, 30) * Eigen::Scaling(0.5, 1.0, 2.5);
  dataset.arrays.push_back(make_array("vector", ScalarType::kFloat64, counting<double>(72), 3));
  write_dataset(dataset, folder.file("a.vtk"));
  const Dataset back = read_dataset({folder.file("a.vtk")});
  EXPECT_EQ(back.lattice.world_from_index.matrix(), dataset.lattice.world_from_index.matrix());
  ASSERT_EQ(back.arrays.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) expect_same_array(back.arrays[i], dataset.arrays[i]);
}

// Directions that are the world's axes must not look turned for rounding, nor lose digits.
TEST(DatasetFiles, LegacyVtkKeepsEveryDigitOfThePlace) {
  if (!has_vtk()) GTEST_SKIP() << "this build has no VTK";
  const TestFolder folder;
  Dataset dataset = oblique_dataset();
  for (const double size : {93.0, 61.0, 49.0, 127.0}) {
    dataset.lattice.world_from_index =
        Eigen::Translation3d(-1 / 3.0, 1e6 / 7, 0.1) * Eigen::Scaling(2 / size, 1 / size, size / 3);
    write_dataset(dataset, folder.file("a.vtk"));
    EXPECT_EQ(read_dataset({folder.file("a.vtk")}).lattice.world_from_index.matrix(),
              dataset.lattice.world_from_index.matrix())
        << size;
  }
}

// What only VTK finds is said in its words, without its sources, lines and addresses.
TEST(DatasetFiles, VtkIsQuotedWithoutItsSources) {
  if (!has_vtk()) GTEST_SKIP() << "this build has no VTK";
  const TestFolder folder;
  const std::string path = folder.write(
      "a.vtk",
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 1 "
      "1\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 2\nSCALARS a float\nLOOKUP_TABLE "
      "default\n1 1e999\n");
  EXPECT_EQ(error_of([&] { read_dataset({path}); }),
            "file-format: " + path +
                ": Error reading ascii data. Possible mismatch of datasize with declaration");
}

TEST(DatasetFiles, LegacyVtkListsItsArrays) {
  if (!has_vtk()) GTEST_SKIP() << "this build has no VTK";
  const TestFolder folder;
  Dataset dataset = oblique_dataset();
  dataset.lattice.world_from_index = Affine3::Identity();
  dataset.arrays.push_back(make_array("other", ScalarType::kUInt8, counting<std::uint8_t>(24)));
  write_dataset(dataset, folder.file("a.vtk"));
  ReadOptions options;
  options.array = "other";
  EXPECT_EQ(read_dataset({folder.file("a.vtk")}, options).arrays.size(), 1U);
  options.array = "none";
  EXPECT_EQ(error_of([&] { read_dataset({folder.file("a.vtk")}, options); }),
            "invalid-argument: " + folder.file("a.vtk") +
                ": array 'none': not there: expected one of 'speed', 'other'");
}

// A damaged file must become one Error and not a word on stderr, whatever VTK thinks of it.
TEST(DatasetFiles, DamagedVtkFilesAreErrorsAndVtkIsSilent) {
  OVOID_NOT_UNDER_TSAN();
  if (!has_vtk()) GTEST_SKIP() << "this build has no VTK";
  const TestFolder folder;
  Dataset dataset;
  dataset.lattice.dims = {20, 20, 20};
  dataset.arrays.push_back(make_array("v", ScalarType::kInt32, counting<std::int32_t>(8000)));
  write_dataset(dataset, folder.file("a.vti"));
  write_dataset(dataset, folder.file("a.vtk"));
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  for (const char* name : {"a.vti", "a.vtk"}) {
    const std::string whole = folder.read(name);
    for (const double part : {0.02, 0.1, 0.5, 0.9}) {
      const std::string path = folder.write(
          std::string("cut") + name,
          whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
      EXPECT_NE(error_of([&] { read_dataset({path}); }).find(path + ": "), std::string::npos)
          << name << " " << part;
    }
  }
  std::string broken = folder.read("a.vti");
  broken[broken.size() - 200] ^= 1;
  const std::string path = folder.write("broken.vti", broken);
  EXPECT_EQ(error_of([&] { read_dataset({path}); }).substr(0, 12), "file-format:");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(DatasetFiles, DetachedSamplesReplaceTheirOwnFileOnly) {
  const TestFolder folder;
  const std::string header = folder.file("a.nhdr");
  const std::string samples = folder.write("a.raw", "precious");
  const std::string refusal = "file-write: " + header + ": its samples would replace " + samples +
                              ", which belongs to something else: choose another name, or .nrrd";
  EXPECT_EQ(error_of([&] { check_dataset_path(header); }), refusal);
  EXPECT_EQ(error_of([&] { write_dataset(oblique_dataset(), header); }), refusal);
  EXPECT_EQ(folder.read("a.raw"), "precious");
  folder.write(
      "a.nhdr",
      "NRRD0001\ntype: uint8\nencoding: raw\ndimension: 2\nsizes: 2 4\ndata file: b.raw\n");
  EXPECT_EQ(error_of([&] { check_dataset_path(header); }), refusal);
  std::filesystem::remove(samples);
  write_dataset(oblique_dataset(), header);
  write_dataset(oblique_dataset(), header);
  EXPECT_EQ(folder.count(), 2);
}

TEST(DatasetFiles, TellsWhatIsReadAndWritten) {
  const TestFolder folder;
  const auto in_folder = [&](const std::vector<std::string>& names) {
    std::vector<std::string> paths;
    for (const std::string& name : names) paths.push_back(folder.file(name));
    return paths;
  };
  const std::string start = "NRRD0001\ntype: uint8\nencoding: raw\ndimension: 3\nsizes: 2 2 4\n";
  for (const char* name : {"s1", "s2", "s4"}) folder.write(name, "1234");
  folder.write("numbered.nhdr", start + "data file: s%d 1 4 1\n");
  folder.write("list.nhdr", start + "data file: LIST\ns4\ns2\n");
  folder.write("attached.nrrd", start + "\n1234123412341234");
  EXPECT_EQ(files_read_for(folder.file("numbered.nhdr")), in_folder({"numbered.nhdr", "s1", "s2"}));
  EXPECT_EQ(files_read_for(folder.file("list.nhdr")), in_folder({"list.nhdr", "s4", "s2"}));
  for (const char* name : {"attached.nrrd", "s1", "missing"})
    EXPECT_EQ(files_read_for(folder.file(name)), in_folder({name}));
  EXPECT_EQ(files_written_for("a.nhdr"), (std::vector<std::string>{"a.nhdr", "a.raw"}));
  EXPECT_EQ(files_written_for("a.nrrd"), (std::vector<std::string>{"a.nrrd"}));
}

TEST(DatasetFiles, CellsAreWrittenWithTheirOwnLattice) {
  const TestFolder folder;
  Dataset dataset = oblique_dataset();
  dataset.arrays = {make_array("c", ScalarType::kInt16, counting<std::int16_t>(6))};
  dataset.arrays[0].is_cell_data = true;
  write_dataset(dataset, folder.file("a.nrrd"));
  const Dataset back = read_dataset({folder.file("a.nrrd")});
  EXPECT_EQ(back.lattice.dims, (Index3{3, 2, 1}));
  EXPECT_TRUE((back.lattice.world_from_index * Vec3(0, 0, 0))
                  .isApprox(dataset.lattice.world_from_index * Vec3(0.5, 0.5, 0.5), 1e-14));
}

TEST(DatasetFiles, FormatIsToldFromTheContent) {
  const TestFolder folder;
  write_dataset(oblique_dataset(), folder.file("a.nrrd"));
  std::filesystem::rename(folder.file("a.nrrd"), folder.file("a.vti"));
  EXPECT_EQ(read_dataset({folder.file("a.vti")}).format, "NRRD");
}

TEST(DatasetFiles, ReadErrors) {
  const TestFolder folder;
  const auto error = [&](const std::string& path, const ReadOptions& options = {}) {
    return error_of([&] { read_dataset({path}, options); });
  };
  const auto expect = [&](const std::string& name, const std::string& code,
                          const std::string& what) {
    EXPECT_EQ(error(folder.file(name)), code + ": " + folder.file(name) + ": " + what);
  };
  folder.write("empty", "");
  folder.write("unknown", "hello");
  folder.write("name.vti", "hello");
  folder.write("a.gz", "\x1f\x8b\x08");
  const std::string readable =
      "NRRD, NIfTI, MetaImage, SLC, NPY, TIFF, Zarr, netCDF, OpenVDB, folder of slices, VTK XML, "
      "VTK file series, "
      "legacy "
      "VTK, "
      "VTKHDF, "
      "Exodus, "
      "EnSight, XDMF, Enzo, STL, OBJ, glTF, "
      "PLOT3D, HDF5, CSV and other text, NPZ, PLY, LAMMPS dump, DICOM, or raw samples with "
      "dimensions and type";
  expect("missing.nrrd", "file-not-found", "no such file");
  expect("", "unsupported", "none of its 4 files is DICOM: a folder is read as DICOM slices");
  expect("empty", "file-format", "is empty");
  expect("unknown", "unsupported", "the format is not known: expected " + readable);
  expect("name.vti", "file-format", "the name ends in .vti but the content does not begin like it");
  folder.write("case.foam", "");
  expect("case.foam", "unsupported",
         "is an OpenFOAM case, which is not read: expected what foamToVTK makes of it");
  expect("a.gz", "unsupported",
         "is a gzip file of something other than NIfTI or text, which is not read: expected " +
             readable);
  EXPECT_EQ(error_of([] { read_dataset({}); }), "invalid-argument: input: no file is named");
  write_dataset(oblique_dataset(), folder.file("a.nrrd"));
  ReadOptions options;
  options.raw.dims = Index3{1, 1, 1};
  EXPECT_EQ(
      error(folder.file("a.nrrd"), options),
      "invalid-argument: " + folder.file("a.nrrd") +
          ": the format NRRD states its own layout: dimensions can be given for raw files only");
}

// Fails if another file is read than the one that was asked for, or the first that varies.
TEST(DatasetFiles, SeveralFilesAreSteps) {
  const TestFolder folder;
  Dataset dataset = oblique_dataset();
  std::vector<std::string> paths;
  for (const std::vector<float>& values :
       {std::vector<float>(24, 1.0F), counting<float>(24), std::vector<float>(24, 2.0F)}) {
    dataset.arrays[0] = make_array("speed", ScalarType::kFloat32, values);
    paths.push_back(folder.file(std::to_string(paths.size()) + ".nrrd"));
    write_dataset(dataset, paths.back());
  }
  const Dataset found = read_dataset(paths);
  EXPECT_EQ(found.source, paths[1]);
  EXPECT_EQ(found.num_steps, 3);
  EXPECT_EQ(found.step, 1);
  EXPECT_EQ(
      found.notes,
      (std::vector<std::string>{paths[1] + ": step 1 of 3, the first that varies; choose with "
                                           "--step"}));
  ReadOptions options;
  options.step = 2;
  folder.write("0.nrrd", "broken");  // and not looked at
  const Dataset chosen = read_dataset(paths, options);
  EXPECT_EQ(chosen.step, 2);
  EXPECT_EQ(values_of<float>(chosen.array())[0], 2);
  options.step = 3;
  EXPECT_EQ(error_of([&] { read_dataset(paths, options); }),
            "invalid-argument: " + paths[0] + " and 2 more: step 3: expected 0 to 2");
  options.step = 1;
  paths.push_back(folder.file("missing.nrrd"));
  EXPECT_EQ(error_of([&] { read_dataset(paths, options); }),
            "file-not-found: " + paths[3] + ": no such file");
}

TEST(DatasetFiles, WriteErrors) {
  const TestFolder folder;
  Dataset dataset = oblique_dataset();
  const auto error = [&](const std::string& path) {
    return error_of([&] { write_dataset(dataset, path); });
  };
  EXPECT_EQ(
      error("a.mhd"),
      "unsupported: a.mhd: the ending '.mhd' names no format that is written: expected .nrrd, "
      ".nhdr, .nii, .nii.gz, .npy, .raw, .vti, .vtk or .h5 for volumes, .vtu for meshes, .csv, "
      ".npz or .ply for particles, .ply for kernels");
  EXPECT_EQ(error_of([] { check_dataset_path("a"); }).substr(0, 12), "unsupported:");
  EXPECT_EQ(error(folder.file("no/a.nrrd")).substr(0, 11), "file-write:");
  dataset.arrays.push_back(dataset.arrays[0]);
  EXPECT_EQ(
      error(folder.file("a.npy")),
      "unsupported: " + folder.file("a.npy") +
          ": .npy holds one array, the dataset has 2 ('speed', 'speed'): keep one, or write .vti");
  dataset.arrays.resize(1);
  dataset.arrays[0].num_tuples = 23;
  EXPECT_EQ(error(folder.file("a.npy")),
            "invalid-argument: array 'speed': has 23 tuples in 96 bytes: expected 24 tuples in 96 "
            "bytes for 4x3x2 float32");
  dataset.arrays.clear();
  EXPECT_EQ(error(folder.file("a.npy")),
            "invalid-argument: " + folder.file("a.npy") + ": the dataset has no array to write");
  EXPECT_EQ(folder.count(), 0);
}

TEST(ScalarTypeNames, AreFound) {
  for (int i = 0; i <= static_cast<int>(ScalarType::kFloat64); ++i) {
    const auto type = static_cast<ScalarType>(i);
    EXPECT_EQ(find_scalar_type(name_of(type)), type);
  }
  EXPECT_EQ(find_scalar_type("double"), ScalarType::kFloat64);
  EXPECT_FALSE(find_scalar_type("").has_value());
  EXPECT_FALSE(find_scalar_type("Float32").has_value());
}

}  // namespace dataset_files_test
}  // namespace ovoid::io
