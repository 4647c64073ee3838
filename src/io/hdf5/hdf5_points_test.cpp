// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/hdf5_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"

#ifdef OVOID_IO_HDF5
#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <utility>

#include "fuzz/targets.h"
#include "io/foreign/hdf5_file.h"
#include "io/formats.h"
#include "io/points/test_shares.h"
#include "io/reader/reader_session.h"
#include "support/where.h"

namespace ovoid::io {
namespace hdf5_points_test {

using Floats = std::vector<float>;

// A file, group by group, written through the library.
class Hdf5Maker {
 public:
  explicit Hdf5Maker(const std::string& path)
      : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose) {}

  Hdf5Maker& group(const std::string& path) {
    H5Gclose(H5Gcreate2(file_.get(), path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    return *this;
  }
  // Floats counted from 1, or with a chunk deflated.
  Hdf5Maker& floats(const std::string& path, const std::vector<hsize_t>& dims,
                    const std::vector<hsize_t>& chunk = {}) {
    hsize_t count = 1;
    for (const hsize_t dim : dims) count *= dim;
    const auto values = counting<float>(count);
    const Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (!chunk.empty()) {
      H5Pset_chunk(plist.get(), static_cast<int>(chunk.size()), chunk.data());
      H5Pset_deflate(plist.get(), 6);
    }
    const Hdf5Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
                           H5Sclose);
    const Hdf5Handle dataset(H5Dcreate2(file_.get(), path.c_str(), H5T_IEEE_F32BE, space.get(),
                                        H5P_DEFAULT, plist.get(), H5P_DEFAULT),
                             H5Dclose);
    H5Dwrite(dataset.get(), H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    return *this;
  }
  // A dataset whose numbers were never written.
  Hdf5Maker& claim(const std::string& path, const std::vector<hsize_t>& dims,
                   const std::vector<hsize_t>& chunk) {
    const Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (!chunk.empty()) H5Pset_chunk(plist.get(), static_cast<int>(chunk.size()), chunk.data());
    const Hdf5Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
                           H5Sclose);
    const Hdf5Handle dataset(H5Dcreate2(file_.get(), path.c_str(), H5T_IEEE_F64LE, space.get(),
                                        H5P_DEFAULT, plist.get(), H5P_DEFAULT),
                             H5Dclose);
    return *this;
  }
  Hdf5Maker& attribute(const std::string& object, const char* name,
                       const std::vector<double>& values) {
    const hsize_t size = values.size();
    const Hdf5Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
    const Hdf5Handle made(H5Acreate_by_name(file_.get(), object.c_str(), name, H5T_NATIVE_DOUBLE,
                                            space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                          H5Aclose);
    H5Awrite(made.get(), H5T_NATIVE_DOUBLE, values.data());
    return *this;
  }

 private:
  Hdf5Handle file_;
};

std::vector<std::string> array_names(const Dataset& dataset) {
  std::vector<std::string> names;
  for (const DataArray& array : dataset.arrays) names.push_back(array.name);
  return names;
}

std::string hdf5_error(const std::string& path, const ReadOptions& options = {}) {
  const std::string message = error_of([&] { read_dataset({path}, options); });
  const auto at = message.find(path);
  return at == std::string::npos ? message
                                 : message.substr(0, at) + "F" + message.substr(at + path.size());
}

TEST(Hdf5Points, GadgetSnapshot) {
  const TestFolder folder;
  const std::string path = folder.file("a.hdf5");
  Hdf5Maker(path)
      .group("/Header")
      .attribute("/Header", "BoxSize", {100})
      .attribute("/Header", "MassTable", {0, 2.5, 0, 0, 0, 0})
      .group("/PartType0")
      .floats("/PartType0/Coordinates", {4, 3}, {2, 3})
      .floats("/PartType0/Density", {4})
      .floats("/PartType0/Velocities", {4, 3})
      .floats("/PartType0/Other", {5})
      .group("/PartType1")
      .floats("/PartType1/Coordinates", {2, 3})
      .group("/PartType4")
      .floats("/PartType4/Coordinates", {1, 3});
  const Dataset gas = read_dataset({path});
  EXPECT_EQ(gas.kind, DatasetKind::kParticles);
  EXPECT_EQ(values_of<float>(gas.positions), counting<float>(12));
  EXPECT_EQ(array_names(gas), (std::vector<std::string>{"Density", "Velocities"}));
  EXPECT_EQ(gas.array("Velocities").num_components, 3);
  ASSERT_TRUE(gas.periodic_box.has_value());
  EXPECT_EQ(gas.periodic_box->max(), Vec3(100, 100, 100));
  ASSERT_EQ(gas.notes.size(), 1U);
  ReadOptions options;
  options.hdf5.positions = "PartType1/Coordinates";
  const Dataset halo = read_dataset({path}, options);
  EXPECT_EQ(values_of<float>(halo.array("mass")), (Floats{2.5F, 2.5F}));
  options.hdf5.positions = "/PartType0/Coordinates";
  options.hdf5.values = {"Density"};
  EXPECT_EQ(array_names(read_dataset({path}, options)), std::vector<std::string>{"Density"});
  options.hdf5.values = {"Other"};
  EXPECT_EQ(hdf5_error(path, options),
            "invalid-argument: F: values 'Other': has shape [5]: expected 4 rows of numbers");
}

TEST(Hdf5Points, OneDatasetPerAxisAndTransposed) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Hdf5Maker(path).floats("/x", {4}).floats("/y", {4}).floats("/Z", {4}).floats("/v", {4});
  const Dataset dataset = read_dataset({path});
  EXPECT_EQ(values_of<double>(dataset.positions),
            (std::vector<double>{1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4}));
  EXPECT_EQ(array_names(dataset), std::vector<std::string>{"v"});
  Hdf5Maker(path).floats("/pos", {3, 4});
  EXPECT_EQ(values_of<float>(read_dataset({path}).positions),
            (Floats{1, 5, 9, 2, 6, 10, 3, 7, 11, 4, 8, 12}));
}

TEST(Hdf5Points, BoxOfOthersIsNotPeriodic) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Hdf5Maker(path).group("/Header").attribute("/Header", "BoxSize", {2}).floats("/pos", {2, 3});
  const Dataset dataset = read_dataset({path});
  EXPECT_FALSE(dataset.periodic_box.has_value());
  ASSERT_EQ(dataset.notes.size(), 1U);
}

TEST(Hdf5Points, PhantomMassesAndDensities) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Hdf5Maker(path)
      .group("/header")
      .floats("/header/massoftype", {3})
      .floats("/header/hfact", {1})
      .group("/particles")
      .floats("/particles/xyz", {3, 3})
      .floats("/particles/itype", {3})
      .floats("/particles/h", {3});
  const Dataset dataset = read_dataset({path});
  EXPECT_EQ(values_of<float>(dataset.array("mass")), (Floats{1, 2, 3}));
  EXPECT_EQ(values_of<float>(dataset.array("density")), (Floats{1, 2.0F / 8, 3.0F / 27}));
}

class Hdf5Shares : public testing::Test {
 protected:
  Dataset expect_all(ReadOptions options = {}) const {
    options.session = std::make_shared<ReaderSession>(std::vector{path});
    return expect_shares([this](const ReadOptions& own) { return read_dataset({path}, own); },
                         options);
  }

  TestFolder folder;
  std::string path = folder.file("a.h5");
};

TEST_F(Hdf5Shares, GadgetSnapshot) {
  Hdf5Maker(path)
      .group("/Header")
      .attribute("/Header", "BoxSize", {30})
      .attribute("/Header", "MassTable", {0.5, 0, 0, 0, 0, 0})
      .group("/PartType0")
      .floats("/PartType0/Coordinates", {10, 3}, {4, 3})
      .floats("/PartType0/Density", {10})
      .floats("/PartType0/Velocities", {10, 3}, {3, 2})
      .group("/PartType1")
      .floats("/PartType1/Coordinates", {2, 3});
  const Dataset whole = expect_all();
  EXPECT_TRUE(whole.periodic_box.has_value());
  EXPECT_EQ(whole.arrays.size(), 3U);
  ReadOptions options;
  options.hdf5.positions = "/PartType1/Coordinates";
  EXPECT_EQ(expect_all(options).num_positions(), 2);
}

// Fails if a share asks its own rows about the box: the last particle alone is outside.
TEST_F(Hdf5Shares, OneParticleOutsideIsKnownToAll) {
  const auto with_box = [&](double size) {
    return std::move(Hdf5Maker(path).group("/Header").attribute("/Header", "BoxSize", {size}));
  };
  with_box(29).floats("/pos", {10, 3}, {4, 3});
  EXPECT_FALSE(expect_all().periodic_box.has_value());
  with_box(29).floats("/pos", {3, 10}, {2, 4});
  EXPECT_FALSE(expect_all().periodic_box.has_value());
  with_box(9).floats("/x", {10}).floats("/y", {10}, {3}).floats("/z", {10}).floats("/v", {10});
  EXPECT_FALSE(expect_all().periodic_box.has_value());
  with_box(10).floats("/x", {10}).floats("/y", {10}, {3}).floats("/z", {10}).floats("/v", {10});
  EXPECT_TRUE(expect_all().periodic_box.has_value());
}

TEST_F(Hdf5Shares, PhantomMassesAndDensities) {
  Hdf5Maker(path)
      .group("/header")
      .floats("/header/massoftype", {5})
      .floats("/header/hfact", {1})
      .group("/particles")
      .floats("/particles/xyz", {5, 3})
      .floats("/particles/itype", {5})
      .floats("/particles/h", {5}, {2});
  EXPECT_EQ(expect_all().arrays.size(), 4U);
}

TEST_F(Hdf5Shares, GridIsReadWhole) {
  Hdf5Maker(path).floats("/v", {2, 3, 4});
  ReadOptions options;
  options.share = RowShare{1, 2};
  const Dataset grid = read_dataset({path}, options);
  EXPECT_EQ(grid.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_FALSE(grid.share.has_value());
}

// The most memory that each child of this process has held, in bytes, by its number.
std::map<int, std::int64_t> peaks_of_children() {
  std::map<int, std::int64_t> peaks;
  const std::string parent = "\nPPid:\t" + std::to_string(::getpid()) + "\n";
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream stream(entry.path() / "status");
    const std::string status{std::istreambuf_iterator<char>(stream), {}};
    const std::size_t at = status.find("\nVmHWM:");
    if (status.find(parent) != std::string::npos && at != std::string::npos)
      peaks[std::stoi(entry.path().filename())] = std::stoll(status.substr(at + 7)) * 1024;
  }
  return peaks;
}

// Fails if the process that reads takes memory for other shares' rows, also where it looks at all
// of them for the box.
TEST_F(Hdf5Shares, OthersRowsTakeNoMemory) {
#ifdef OVOID_SANITIZED_ADDRESS
  GTEST_SKIP() << "AddressSanitizer keeps what was freed";
#endif
  constexpr hsize_t kMany = 2000000;
  constexpr std::int64_t kNumBytes = std::int64_t{kMany} * 4 * 4;
  const auto peak = [&](const ReadOptions& asked) {
    const std::map<int, std::int64_t> others = peaks_of_children();  // that other tests left
    ReadOptions options = asked;
    options.session = std::make_shared<ReaderSession>(std::vector{path});
    const Dataset dataset = read_dataset({path}, options);
    EXPECT_TRUE(dataset.periodic_box.has_value());
    std::int64_t most = 0;
    for (const auto& [number, peak] : peaks_of_children())
      if (!others.contains(number)) most = std::max(most, peak);
    return most;
  };
  for (const std::vector<hsize_t>& chunk : {std::vector<hsize_t>{}, {100000, 3}}) {
    Hdf5Maker(path)
        .group("/Header")
        .attribute("/Header", "BoxSize", {static_cast<double>(3 * kMany)})
        .floats("/pos", {kMany, 3}, chunk)
        .floats("/v", {kMany});
    ReadOptions options;
    const std::int64_t of_whole = peak(options);
    options.share = RowShare{3, 8};
    const std::int64_t of_share = peak(options);
    ASSERT_GT(of_whole, kNumBytes);
    EXPECT_LT(of_share + kNumBytes, of_whole);
    RecordProperty("peak_of_whole", std::to_string(of_whole));
    RecordProperty("peak_of_share", std::to_string(of_share));
  }
}

TEST(Hdf5Points, ErrorsListWhatThereIs) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Hdf5Maker(path)
      .group("/a")
      .floats("/a/pos", {2, 3})
      .group("/b")
      .floats("/b/xyz", {2, 3})
      .floats("/c", {2});
  EXPECT_EQ(hdf5_error(path),
            "file-format: F: several datasets may be the positions: '/a/pos', "
            "'/b/xyz': choose one with --positions");
  ReadOptions options;
  options.hdf5.positions = "/c";
  EXPECT_EQ(hdf5_error(path, options).substr(0, 54),
            "invalid-argument: F: positions '/c': has shape [2]: ex");
  options.hdf5.positions = "/d";
  EXPECT_EQ(hdf5_error(path, options),
            "invalid-argument: F: positions '/d': the file has no such dataset");
  Hdf5Maker(path).floats("/c", {2});
  EXPECT_EQ(hdf5_error(path).substr(0, 64),
            "file-format: F: nothing in it is drawn: '/c' [2] has one axis: e");
  EXPECT_EQ(hdf5_error(folder.write("b.h5", "\x89HDF\r\n\x1a\n garbage")),
            "file-format: F: the HDF5 library cannot open it: is the file truncated?");
  Hdf5Maker(path).group("/VTKHDF").floats("/VTKHDF/Points", {2, 3});
  const auto source = open_file(path);
  EXPECT_EQ(format_by_content(*source), &format_called("VTKHDF"));
}

// Arrays of three axes that other programs write.
TEST(Hdf5Grid, ArraysAreVolumes) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Hdf5Maker(path)
      .group("/g")
      .floats("/g/raw", {2, 3, 4}, {1, 3, 4})
      .floats("/g/flow", {2, 3, 4, 3})
      .floats("/times", {5})
      .attribute("/g/raw", "scale_factor", {2})
      .attribute("/g/raw", "add_offset", {-1})
      .attribute("/g/flow", "resolution", {40, 5, 4})
      .attribute("/g/flow", "offset", {1, 2, 3});
  Dataset dataset = read_dataset({path});
  EXPECT_EQ(dataset.format, "HDF5 grid");
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(array_names(dataset), (std::vector<std::string>{"g/flow", "g/raw"}));
  EXPECT_EQ(dataset.arrays[0].num_components, 3);
  EXPECT_EQ(values_of<float>(dataset.arrays[1]), counting<float>(24));
  EXPECT_EQ(dataset.arrays[1].value_scale, 2);
  EXPECT_EQ(dataset.arrays[1].value_offset, -1);
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(4, 5, 40));
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(3, 2, 1));
  ASSERT_EQ(dataset.notes.size(), 1U);
  ReadOptions options;
  options.raw.spacing = Vec3(1, 2, 3);
  for (const char* name : {"raw", "g/raw", "/g/raw"}) {
    options.array = name;
    dataset = read_dataset({path}, options);
    EXPECT_EQ(array_names(dataset), std::vector<std::string>{name});
    EXPECT_EQ(values_of<float>(dataset.array(name)), counting<float>(24));
    EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(1, 2, 3));
  }
}

TEST(Hdf5Grid, AxesBesideTheArraySayThePlace) {
  const TestFolder folder;
  const std::string path = folder.file("a.nc");
  Hdf5Maker(path).floats("/x", {3}).floats("/y", {3}).floats("/z", {3}).floats("/v", {3, 3, 3});
  Dataset dataset = read_dataset({path});
  EXPECT_EQ(dataset.kind, DatasetKind::kLattice);
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(1, 1, 1));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(1, 1, 1));
  // Without the cube they are positions.
  Hdf5Maker(path).floats("/x", {3}).floats("/y", {3}).floats("/z", {3}).floats("/v", {3, 3, 2});
  EXPECT_EQ(read_dataset({path}).kind, DatasetKind::kParticles);
}

// As netCDF-4 files have them.
TEST(Hdf5Grid, ArraysInTimeAreSteps) {
  const TestFolder folder;
  const std::string path = folder.file("a.nc");
  Hdf5Maker(path)
      .floats("/time", {2})
      .floats("/v", {2, 3, 4, 5}, {1, 2, 4, 5})
      .attribute("/v", "_FillValue", {62})
      .attribute("/v", "missing_value", {63});
  ReadOptions options;
  options.step = 1;
  Dataset dataset = read_dataset({path}, options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{5, 4, 3}));
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_EQ(dataset.times, (std::vector<double>{1, 2}));
  std::vector<float> values = values_of<float>(dataset.array("v"));
  ASSERT_EQ(values.size(), 60U);
  EXPECT_EQ(values[0], 61);
  EXPECT_TRUE(std::isnan(values[1]) && std::isnan(values[2]));
  EXPECT_EQ(values[59], 120);
  options.step.reset();
  options.raw.axis_order = "czyx";
  dataset = read_dataset({path}, options);
  EXPECT_EQ(array_names(dataset), (std::vector<std::string>{"v channel 1", "v channel 2"}));
  options.raw.axis_order = "zyxt";
  EXPECT_EQ(read_dataset({path}, options).num_steps, 5);
}

TEST(Hdf5Grid, AnAxisOrderIsForGridsAlone) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Hdf5Maker(path).floats("/pos", {5, 3});
  ReadOptions options;
  options.raw.axis_order = "zyx";
  EXPECT_EQ(hdf5_error(path, options),
            "invalid-argument: F: is HDF5: an axis order can be given for NPY, NPZ, TIFF, Zarr, "
            "netCDF and "
            "grids in HDF5 only");
}

TEST(Hdf5Grid, OneIsChosen) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Hdf5Maker(path).floats("/a", {2, 3, 4}).floats("/b", {4, 3, 2}).floats("/c", {2, 3, 4, 5});
  EXPECT_EQ(hdf5_error(path),
            "invalid-argument: F: holds several grids: '/a' [2, 3, 4], '/b' [4, 3, 2]: choose one "
            "with --array");
  ReadOptions options;
  options.array = "b";
  EXPECT_EQ(read_dataset({path}, options).lattice.dims, (Index3{2, 3, 4}));
  options.array = "c";  // in time, which is left out where there are others
  EXPECT_EQ(read_dataset({path}, options).num_steps, 2);
  options.array = "d";
  EXPECT_EQ(hdf5_error(path, options).substr(0, 53),
            "invalid-argument: F: array 'd': the file has no such ");
  Hdf5Maker(path).claim("/a", {1000000, 1000000, 1000}, {});
  EXPECT_EQ(hdf5_error(path).substr(0, 22), "unsupported: F: '/a': ");
  Hdf5Maker(path).floats("/pos", {5, 3}).floats("/grid", {2, 3, 4});
  EXPECT_EQ(read_dataset({path}).kind, DatasetKind::kParticles);
  options.array = "grid";
  EXPECT_EQ(read_dataset({path}, options).kind, DatasetKind::kLattice);
  options.array.clear();
  options.raw.spacing = Vec3(1, 1, 1);
  EXPECT_EQ(hdf5_error(path, options),
            "invalid-argument: F: the format HDF5 states its own spacing: one can be given only "
            "where the format states none");
}

TEST(Hdf5Points, ClaimsThatTheFileCannotHold) {
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Hdf5Maker(path).claim("/pos", {hsize_t{1} << 30, 3}, {1024, 3});
  EXPECT_NE(hdf5_error(path).find("more than a file of"), std::string::npos) << hdf5_error(path);
  Hdf5Maker(path).claim("/pos", {10, 3}, {});
  EXPECT_EQ(hdf5_error(path), "unsupported: F: '/pos': was never written");
}

// A file may say that its numbers lie in others, which VTK and the library follow. Without leave
// nothing of those is in what is read, nor in the error.
class Hdf5Elsewhere : public testing::Test {
 protected:
  // A VTKHDF image of 4 x 4 x 4 bytes, which `file` holds.
  std::string image_from(const std::string& file) const {
    const std::string path = folder.file("a.vtkhdf");
    const Hdf5Handle whole(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
                           H5Fclose);
    const Hdf5Handle root = group_in(whole.get(), "VTKHDF");
    numbers(root.get(), "Version", H5T_NATIVE_INT64, std::vector<std::int64_t>{1, 0});
    numbers(root.get(), "WholeExtent", H5T_NATIVE_INT64,
            std::vector<std::int64_t>{0, 3, 0, 3, 0, 3});
    numbers(root.get(), "Origin", H5T_NATIVE_DOUBLE, std::vector<double>{0, 0, 0});
    numbers(root.get(), "Spacing", H5T_NATIVE_DOUBLE, std::vector<double>{1, 1, 1});
    numbers(root.get(), "Direction", H5T_NATIVE_DOUBLE,
            std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1});
    text(root.get(), "Type", "ImageData");
    const Hdf5Handle points = group_in(root.get(), "PointData");
    const Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_external(plist.get(), file.c_str(), 0, 64);
    const std::array<hsize_t, 3> dims{4, 4, 4};
    const Hdf5Handle space(H5Screate_simple(3, dims.data(), nullptr), H5Sclose);
    const Hdf5Handle made(H5Dcreate2(points.get(), "v", H5T_NATIVE_UINT8, space.get(), H5P_DEFAULT,
                                     plist.get(), H5P_DEFAULT),
                          H5Dclose);
    EXPECT_TRUE(made.is_open());
    return path;
  }

  TestFolder folder;

 private:
  static Hdf5Handle group_in(hid_t place, const char* name) {
    return {H5Gcreate2(place, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose};
  }
  template <typename T>
  static void numbers(hid_t place, const char* name, hid_t type, const std::vector<T>& values) {
    const hsize_t count = values.size();
    const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Handle made(H5Acreate2(place, name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                          H5Aclose);
    EXPECT_GE(H5Awrite(made.get(), type, values.data()), 0);
  }
  static void text(hid_t place, const char* name, const std::string& value) {
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type.get(), value.size());
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle made(
        H5Acreate2(place, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    EXPECT_GE(H5Awrite(made.get(), type.get(), value.data()), 0);
  }
};

TEST_F(Hdf5Elsewhere, OtherFilesNeedLeave) {
  const std::string secret = folder.write("secret", std::string(64, 's'));
  const std::string path = image_from(secret);
  const std::string message = error_of([&] { read_dataset({path}); });
  if (message.find("no VTK") != std::string::npos) GTEST_SKIP() << "this build has no VTK";
  EXPECT_NE(message.find("takes data from '" + std::filesystem::canonical(secret).string() + "'"),
            std::string::npos)
      << message;
  ReadOptions options;
  options.data_folders = {folder.file("")};
  const Dataset dataset = read_dataset({path}, options);
  EXPECT_EQ(values_of<char>(dataset.array("v")), std::vector<char>(64, 's'));
}

TEST_F(Hdf5Elsewhere, EnvironmentIsOutOfReach) {
  ::setenv("OVOID_TEST_SECRET", "secret", 1);
  const std::string path = image_from("/proc/self/environ");
  const std::string message = error_of([&] { read_dataset({path}); });
  ReadOptions options;
  options.data_folders = {"/proc"};
  const std::string with_leave = error_of([&] {
    const Dataset dataset = read_dataset({path}, options);
    const auto values = values_of<char>(dataset.array("v"));
    EXPECT_EQ(std::string(values.begin(), values.end()).find("OVOID_TEST_SECRET"),
              std::string::npos);
  });
  ::unsetenv("OVOID_TEST_SECRET");
  if (message.find("no VTK") != std::string::npos) GTEST_SKIP() << "this build has no VTK";
  EXPECT_NE(message.find("/environ'"), std::string::npos) << message;
}

// The library reads what the file says, in a process of its own; whatever that is, we return
// something consistent or throw.
TEST(Hdf5Points, DamagedFiles) {
  OVOID_NOT_UNDER_TSAN();
  const TestFolder folder;
  const std::string path = folder.file("a.h5");
  Hdf5Maker(path)
      .group("/Header")
      .attribute("/Header", "BoxSize", {100})
      .group("/PartType0")
      .floats("/PartType0/Coordinates", {40, 3}, {8, 3})
      .floats("/PartType0/Density", {40});
  const std::string good = folder.read("a.h5");
  const auto session = std::make_shared<ReaderSession>(std::vector{path});
  std::mt19937_64 random(20240229);
  int num_read = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string bytes = good;
    for (std::size_t k = 1 + random() % 4; k > 0; --k)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    if (i % 10 == 0) bytes.resize(random() % bytes.size());
    ReadOptions options;
    options.session = session;
    if (i % 2 == 0) options.share = RowShare{i % 3, 3};
    folder.write("a.h5", bytes);
    fuzz::expect_dataset_or_error([&] {
      Dataset dataset = read_dataset({path}, options);
      ++num_read;
      return dataset;
    });
  }
  EXPECT_GT(num_read, 300) << "most damage hits nothing that matters";
}

}  // namespace hdf5_points_test
}  // namespace ovoid::io
#endif
