// SPDX-License-Identifier: Apache-2.0
// Snapshots in several files, and what smoothing lengths of codes mean.
#include "io/foreign/hdf5_snapshot.h"

#include <gtest/gtest.h>

#ifdef OVOID_IO_HDF5
#include <hdf5.h>

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "data/kernels/smoothing_codes.h"
#include "io/core/test_folder.h"
#include "io/foreign/hdf5_handle.h"
#include "io/images/test_volumes.h"
#include "io/points/test_shares.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

namespace ovoid::io {
namespace hdf5_snapshot_test {

using Doubles = std::vector<double>;

// A file of a simulation, written through the library.
class SnapshotFile {
 public:
  explicit SnapshotFile(const std::string& path)
      : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose) {}

  SnapshotFile& group(const char* path) {
    H5Gclose(H5Gcreate2(file_.get(), path, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    return *this;
  }
  SnapshotFile& number(const char* group, const char* name, const Doubles& values,
                       hid_t type = H5T_STD_I32LE) {
    const hsize_t size = values.size();
    const Hdf5Handle space(size == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr),
                           H5Sclose);
    const Hdf5Handle made(H5Acreate_by_name(file_.get(), group, name, type, space.get(),
                                            H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                          H5Aclose);
    H5Awrite(made.get(), H5T_NATIVE_DOUBLE, values.data());
    return *this;
  }
  SnapshotFile& text(const char* group, const char* name, const std::string& value) {
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type.get(), value.size());
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle made(H5Acreate_by_name(file_.get(), group, name, type.get(), space.get(),
                                            H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                          H5Aclose);
    H5Awrite(made.get(), type.get(), value.data());
    return *this;
  }
  SnapshotFile& values(const std::string& path, const Doubles& values, int width = 1,
                       hid_t type = H5T_IEEE_F64LE) {
    const std::vector<hsize_t> dims{values.size() / static_cast<std::size_t>(width),
                                    static_cast<hsize_t>(width)};
    const Hdf5Handle space(H5Screate_simple(width == 1 ? 1 : 2, dims.data(), nullptr), H5Sclose);
    const Hdf5Handle made(H5Dcreate2(file_.get(), path.c_str(), type, space.get(), H5P_DEFAULT,
                                     H5P_DEFAULT, H5P_DEFAULT),
                          H5Dclose);
    H5Dwrite(made.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    return *this;
  }

 private:
  Hdf5Handle file_;
};

// One of `count` files of a snapshot of `total` gas particles, which has those with these numbers.
SnapshotFile part(const std::string& path, double count, double total, const Doubles& numbers) {
  SnapshotFile file(path);
  file.group("/Header")
      .number("/Header", "NumFilesPerSnapshot", {count})
      .number("/Header", "NumPart_Total", {total, 3, 0, 0, 0, 0}, H5T_STD_U32LE)
      .number("/Header", "MassTable", {0, 2, 0, 0, 0, 0}, H5T_IEEE_F64BE)
      .number("/Header", "BoxSize", {10}, H5T_IEEE_F64LE)
      .number("/Header", "Time", {1}, H5T_IEEE_F64LE);
  if (numbers.empty()) {
    file.group("/PartType1").values("/PartType1/Coordinates", {1, 1, 1, 2, 2, 2, 3, 3, 3}, 3);
    return file;
  }
  Doubles places;
  for (const double number : numbers) places.insert(places.end(), {number, 1, 2});
  file.group("/PartType0")
      .values("/PartType0/Coordinates", places, 3)
      .values("/PartType0/ParticleIDs", numbers, 1, H5T_STD_U64LE)
      .values("/PartType0/Masses", numbers, 1, H5T_IEEE_F32LE);
  return file;
}

Doubles first_axis(const Dataset& dataset) {
  const auto all = values_of<double>(dataset.positions);
  Doubles x;
  for (std::size_t i = 0; i < all.size(); i += 3) x.push_back(all[i]);
  return x;
}

class Snapshots : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return folder.file(name); }
  // A note without the folder.
  static std::string plain(std::string note, const TestFolder& folder) {
    const std::string prefix = folder.file("");
    for (auto at = note.find(prefix); at != std::string::npos; at = note.find(prefix))
      note.erase(at, prefix.size());
    return note;
  }

  TestFolder folder;
};

TEST_F(Snapshots, PartsAreOneStepInAnyOrder) {
  part(file("s.0.hdf5"), 3, 6, {1, 2, 3});
  part(file("s.1.hdf5"), 3, 6, {4});
  part(file("s.2.hdf5"), 3, 6, {5, 6});
  const std::vector<std::string> paths{file("s.2.hdf5"), file("s.0.hdf5"), file("s.1.hdf5")};
  const Dataset all = read_dataset(paths);
  EXPECT_EQ(all.num_steps, 1);
  EXPECT_EQ(first_axis(all), (Doubles{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(values_of<float>(all.array("Masses")), (std::vector<float>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(all.array("ParticleIDs").type, ScalarType::kUInt64);
  ASSERT_TRUE(all.periodic_box.has_value());
  EXPECT_TRUE(all.notes.empty());
  EXPECT_EQ(open_steps(paths)->num_steps(), 1);
  expect_shares([&](const ReadOptions& own) { return read_dataset(paths, own); });
}

// The first file alone stands for all, as in other programs.
TEST_F(Snapshots, FilesBesideAreRead) {
  part(file("s.0.hdf5"), 2, 3, {1, 2});
  part(file("s.1.hdf5"), 2, 3, {3});
  part(file("s.2.hdf5"), 5, 9, {7});  // another snapshot's
  const Dataset all = read_dataset({file("s.0.hdf5")});
  EXPECT_EQ(first_axis(all), (Doubles{1, 2, 3}));
  EXPECT_EQ(all.source, file("s.0.hdf5"));
  ASSERT_EQ(all.notes.size(), 1U);
  EXPECT_EQ(plain(all.notes[0], folder),
            "s.0.hdf5: is one of 2 files of a snapshot: those beside it are read, too");
  EXPECT_EQ(first_axis(read_dataset({file("s.1.hdf5")})), (Doubles{1, 2, 3}));
  const std::vector<std::string> listed = files_read_for(file("s.0.hdf5"));
  EXPECT_EQ(listed.size(), 3U) << "a writer must not replace a part";
}

TEST_F(Snapshots, MissingFileIsNamed) {
  part(file("s.0.hdf5"), 3, 6, {1, 2, 3});
  part(file("s.2.hdf5"), 3, 6, {5, 6});
  const Dataset some = read_dataset({file("s.0.hdf5"), file("s.2.hdf5")});
  EXPECT_EQ(first_axis(some), (Doubles{1, 2, 3, 5, 6}));
  ASSERT_EQ(some.notes.size(), 1U);
  EXPECT_EQ(plain(some.notes[0], folder),
            "s.0.hdf5: of 3 files of the snapshot 1 is not there ('s.1.hdf5'): 1 of 6 particles "
            "are missing");
}

// A file without gas is passed over, and the kind of particles is that of all files.
TEST_F(Snapshots, PartsWithoutTheParticles) {
  part(file("s.0.hdf5"), 3, 3, {});
  part(file("s.1.hdf5"), 3, 3, {1, 2});
  part(file("s.2.hdf5"), 3, 3, {3}).values("/PartType0/Extra", {1});
  const Dataset gas = read_dataset({file("s.0.hdf5")});
  EXPECT_EQ(first_axis(gas), (Doubles{1, 2, 3}));
  EXPECT_EQ(gas.arrays.size(), 2U);
  ASSERT_EQ(gas.notes.size(), 2U);
  EXPECT_EQ(plain(gas.notes[0], folder),
            "s.0.hdf5: of 2 kinds of particles '/PartType0' is read; choose with --positions");
  ReadOptions options;
  options.hdf5.positions = "PartType1/Coordinates";
  const Dataset halo = read_dataset({file("s.0.hdf5")}, options);
  EXPECT_EQ(first_axis(halo), (Doubles{1, 2, 3}));
  EXPECT_EQ(values_of<float>(halo.array("mass")), (std::vector<float>{2, 2, 2}));
  options.hdf5.positions = "PartType5/Coordinates";
  EXPECT_NE(error_of([&] { read_dataset({file("s.0.hdf5")}, options); }).find("no such dataset"),
            std::string::npos);
}

TEST_F(Snapshots, StepsOfDifferentNumbersOfFiles) {
  part(file("a_000.0.hdf5"), 2, 3, {1, 2});
  part(file("a_000.1.hdf5"), 2, 3, {3});
  part(file("a_001.0.hdf5"), 3, 4, {4});
  part(file("a_001.1.hdf5"), 3, 4, {5});
  part(file("a_001.2.hdf5"), 3, 4, {6, 7});
  part(file("a_002.hdf5"), 1, 2, {8, 9});
  const std::vector<std::string> paths{file("a_000.0.hdf5"), file("a_000.1.hdf5"),
                                       file("a_001.0.hdf5"), file("a_001.1.hdf5"),
                                       file("a_001.2.hdf5"), file("a_002.hdf5")};
  const auto steps = open_steps(paths);
  ASSERT_EQ(steps->num_steps(), 3);
  EXPECT_EQ(first_axis(steps->read(0)), (Doubles{1, 2, 3}));
  EXPECT_EQ(first_axis(steps->read(1)), (Doubles{4, 5, 6, 7}));
  EXPECT_EQ(first_axis(steps->read(2)), (Doubles{8, 9}));
  EXPECT_EQ(steps->read(2).step, 2);
  ReadOptions options;
  options.step = 3;
  EXPECT_NE(error_of([&] { read_dataset(paths, options); }).find("step 3: expected 0 to 2"),
            std::string::npos);
}

// Files of other names belong together by their headers, as many as these say.
TEST_F(Snapshots, OtherNames) {
  part(file("one.hdf5"), 2, 4, {1, 2});
  part(file("two.hdf5"), 2, 4, {3, 4});
  const Dataset all = read_dataset({file("one.hdf5"), file("two.hdf5")});
  EXPECT_EQ(all.num_steps, 1);
  EXPECT_EQ(first_axis(all), (Doubles{1, 2, 3, 4}));
  const Dataset half = read_dataset({file("two.hdf5")});
  ASSERT_EQ(half.notes.size(), 1U);
  EXPECT_EQ(plain(half.notes[0], folder),
            "two.hdf5: of 2 files of the snapshot 1 is not there: 2 of 4 particles are missing");
}

TEST_F(Snapshots, SingleFilesAreSteps) {
  part(file("a_000.hdf5"), 1, 2, {1, 2});
  part(file("a_001.hdf5"), 1, 1, {3});
  const Dataset first = read_dataset({file("a_000.hdf5"), file("a_001.hdf5")});
  EXPECT_EQ(first.num_steps, 2);
  SnapshotFile(file("c.hdf5")).group("/Header").number("/Header", "NumFilesPerSnapshot", {1e6});
  EXPECT_NE(error_of([&] {
              read_dataset({file("c.hdf5")});
            }).find("NumFilesPerSnapshot 1000000: expected 1 to 65536"),
            std::string::npos);
}

// Arrays of one kind may have another type in each part.
TEST_F(Snapshots, TypesThatDiffer) {
  part(file("s.0.hdf5"), 2, 2, {1}).values("/PartType0/u", {0.5}, 1, H5T_IEEE_F32LE);
  part(file("s.1.hdf5"), 2, 2, {2}).values("/PartType0/u", {7}, 1, H5T_STD_I32LE);
  EXPECT_EQ(values_of<double>(read_dataset({file("s.0.hdf5")}).array("u")), (Doubles{0.5, 7}));
}

// The format, after the one note is seen to be this, or none.
std::string format_of(const std::string& path, std::string_view note) {
  const Dataset dataset = read_dataset({path});
  EXPECT_EQ(dataset.notes.size(), note.empty() ? 0U : 1U);
  if (dataset.notes.size() == 1) {
    EXPECT_EQ(dataset.notes[0].substr(path.size() + 2), note);
  }
  return dataset.format;
}

TEST_F(Snapshots, SmoothingLengthsOfCodes) {
  const std::string path = file("a.hdf5");
  const auto note = [](const std::string& name, const std::string& code, const std::string& reach) {
    return "'" + name + "' are taken for those of " + code + ": kernels end at " + reach +
           " of these lengths (--smoothing-ends says otherwise)";
  };
  part(path, 1, 1, {1}).values("/PartType0/SmoothingLength", {1});
  EXPECT_EQ(format_of(path, note("SmoothingLength", "Gadget", "1")), "HDF5 (Gadget)");
  for (const auto& [kernel, code, reach] : std::vector<std::array<std::string, 3>>{
           {"Cubic spline (M4)", "cubic spline", "1.825742"},
           {"Quartic spline (M5)", "quartic spline", "2.018932"},
           {"Quintic spline (M6)", "quintic spline", "2.195775"},
           {"Wendland C2", "Wendland C2", "1.936492"},
           {"Wendland C4", "Wendland C4", "2.20794"},
           {"Wendland C6", "Wendland C6", "2.44949"}}) {
    part(path, 1, 1, {1})
        .values("/PartType0/SmoothingLengths", {1})
        .group("/HydroScheme")
        .text("/HydroScheme", "Kernel function", kernel);
    const std::string format = format_of(path, note("SmoothingLengths", "SWIFT, " + code, reach));
    EXPECT_EQ(format, "HDF5 (SWIFT, " + code + ")");
    EXPECT_EQ(data::smoothing_reach(format), std::stod(reach));
  }
  part(path, 1, 1, {1})
      .values("/PartType0/SmoothingLength", {1})
      .group("/Code")
      .text("/Code", "Code", "SWIFT");
  EXPECT_EQ(
      format_of(path, note("SmoothingLength",
                           "SWIFT, cubic spline, since the file names no kernel that is known",
                           "1.825742")),
      "HDF5 (SWIFT, cubic spline)");
  part(path, 1, 1, {1});
  EXPECT_EQ(format_of(path, ""), "HDF5");
}

TEST_F(Snapshots, FactorsOfCosmology) {
  const std::string path = file("a.hdf5");
  SnapshotFile(path)
      .group("/Header")
      .number("/Header", "Time", {0.5}, H5T_IEEE_F64LE)
      .number("/Header", "Redshift", {1}, H5T_IEEE_F64LE)
      .number("/Header", "Omega0", {0.3}, H5T_IEEE_F64LE)
      .number("/Header", "HubbleParam", {0.7}, H5T_IEEE_F64LE)
      .group("/PartType0")
      .values("/PartType0/Coordinates", {1, 2, 3, 4, 5, 6}, 3);
  EXPECT_EQ(format_of(path,
                      "a cosmological run: numbers are as the file has them, factors of the "
                      "scale factor (0.5) and of Hubble's h (0.7) are not applied"),
            "HDF5");
}

}  // namespace hdf5_snapshot_test
}  // namespace ovoid::io
#endif
