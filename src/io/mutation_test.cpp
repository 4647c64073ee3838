// SPDX-License-Identifier: Apache-2.0
// Readers against damaged files: a short, reproducible form of fuzzing that runs with every build
// (`make fuzz` is the long one). Valid inputs are cut, flipped, spliced and given absurd numbers; a
// reader must throw ovoid::Error or return something consistent. What would make it fail: a size
// that is believed before it is checked, an index one too far, another exception.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "fuzz/seeds.h"
#include "fuzz/targets.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/reader/reader_session.h"
#include "ovoid/io.h"
#include "support/where.h"

namespace ovoid::io {
namespace mutation_test {

constexpr std::uint64_t kSeed = 20240229;

class Mutator {
 public:
  explicit Mutator(std::vector<std::string> seeds) : seeds_(std::move(seeds)) {}

  // One of the seeds with one to four changes.
  std::string next() {
    std::string input = seeds_[below(seeds_.size())];
    for (std::size_t i = 1 + below(4); i > 0; --i) mutate(input);
    return input;
  }

 private:
  std::size_t below(std::size_t count) { return count == 0 ? 0 : random_() % count; }

  void mutate(std::string& input) {
    const std::size_t position = below(input.size());
    switch (below(8)) {
      case 0:
        input.resize(position);
        break;
      case 1:
        if (!input.empty()) input[position] = static_cast<char>(input[position] ^ (1 << below(8)));
        break;
      case 2:
        input.insert(position, 1, static_cast<char>(below(256)));
        break;
      case 3:
        input.erase(position, 1 + below(8));
        break;
      case 4:
        splice(input, position);
        break;
      case 5:
        swap_lines(input, position);
        break;
      default:
        replace_number(input);
        break;  // twice as often: sizes are where readers break
    }
  }

  void splice(std::string& input, std::size_t position) {
    const std::string& other = seeds_[below(seeds_.size())];
    const std::size_t begin = below(other.size());
    input.insert(position, other.substr(begin, 1 + below(64)));
  }

  // The line at `position` goes to the front of the line before it, or is doubled.
  void swap_lines(std::string& input, std::size_t position) {
    const std::size_t begin = input.rfind('\n', position) + 1;
    if (begin >= input.size()) return;
    const std::size_t end = std::min(input.find('\n', begin), input.size() - 1) + 1;
    const std::string line = input.substr(begin, end - begin);
    if (below(2) == 0) input.erase(begin, line.size());
    const std::size_t before = begin < 2 ? 0 : input.rfind('\n', begin - 2) + 1;
    input.insert(before, line);
  }

  void replace_number(std::string& input) {
    static const std::vector<std::string> kNumbers{"0",
                                                   "-1",
                                                   "1",
                                                   "3",
                                                   "65536",
                                                   "2147483647",
                                                   "2147483648",
                                                   "4294967295",
                                                   "4294967296",
                                                   "9223372036854775807",
                                                   "18446744073709551616",
                                                   "99999999999999999999999",
                                                   "1e308",
                                                   "-1e-320",
                                                   "nan",
                                                   "inf",
                                                   "0.5",
                                                   ""};
    const std::size_t from = below(input.size());
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    const auto begin =
        std::find_if(input.begin() + static_cast<std::ptrdiff_t>(from), input.end(), is_digit);
    const auto end = std::find_if_not(begin, input.end(), is_digit);
    input.replace(begin, end, kNumbers[below(kNumbers.size())]);
  }

  std::vector<std::string> seeds_;
  std::mt19937_64 random_{kSeed};
};

// OVOID_MUTATIONS=n in the environment asks for n times as many.
int wanted(int count) {
  const char* const factor = std::getenv("OVOID_MUTATIONS");
  return factor == nullptr ? count : count * std::max(1, std::atoi(factor));
}

void run(const std::vector<std::string>& seeds, void (*target)(fuzz::Input), int count = 2000) {
  OVOID_NOT_UNDER_TSAN();
  for (const std::string& seed : seeds) target(std::as_bytes(std::span(seed)));
  Mutator mutator(seeds);
  for (int i = 0; i < wanted(count); ++i) {
    const std::string input = mutator.next();
    try {
      target(std::as_bytes(std::span(input)));
    } catch (const std::exception& error) {
      FAIL() << "mutation " << i << " of seed " << kSeed << ": " << error.what() << "\n"
             << testing::PrintToString(input);
    }
  }
}

TEST(Mutation, Nrrd) { run(fuzz::nrrd_seeds(), fuzz::nrrd); }
TEST(Mutation, Npy) { run(fuzz::npy_seeds(), fuzz::npy); }
TEST(Mutation, Nifti) { run(fuzz::nifti_seeds(), fuzz::nifti, 4000); }
TEST(Mutation, MetaImage) { run(fuzz::metaimage_seeds(), fuzz::metaimage); }
TEST(Mutation, Slc) { run(fuzz::slc_seeds(), fuzz::slc); }
TEST(Mutation, Slice) { run(fuzz::slice_seeds(), fuzz::slice, 2000); }
TEST(Mutation, Tiff) { run(fuzz::tiff_seeds(), fuzz::tiff, 6000); }
TEST(Mutation, Zarr) { run(fuzz::zarr_seeds(), fuzz::zarr, 4000); }
TEST(Mutation, Xdmf) { run(fuzz::xdmf_seeds(), fuzz::xdmf, 4000); }
TEST(Mutation, RawName) { run(fuzz::raw_name_seeds(), fuzz::raw_name); }
TEST(Mutation, Dicom) { run(fuzz::dicom_seeds(), fuzz::dicom); }
TEST(Mutation, VtkHeader) { run(fuzz::vtk_header_seeds(), fuzz::vtk_header); }
TEST(Mutation, Plot3d) { run(fuzz::plot3d_seeds(), fuzz::plot3d); }
TEST(Mutation, Netcdf) { run(fuzz::netcdf_seeds(), fuzz::netcdf, 4000); }
TEST(Mutation, NetcdfHeader) { run(fuzz::netcdf_header_seeds(), fuzz::netcdf_header, 4000); }
TEST(Mutation, Look2D) { run(fuzz::look_2d_seeds(), fuzz::look_2d, 3000); }
TEST(Mutation, LabelTable) { run(fuzz::label_table_seeds(), fuzz::label_table, 3000); }
TEST(Mutation, Gltf) { run(fuzz::gltf_seeds(), fuzz::gltf, 4000); }
TEST(Mutation, VdbHeader) { run(fuzz::vdb_header_seeds(), fuzz::vdb_header, 4000); }
TEST(Mutation, PictureParts) { run(fuzz::picture_part_seeds(), fuzz::picture_part, 400); }
TEST(Mutation, Look) { run(fuzz::look_seeds(), fuzz::look, 4000); }
TEST(Mutation, Camera) { run(fuzz::camera_seeds(), fuzz::camera); }
TEST(Mutation, PointText) { run(fuzz::point_text_seeds(), fuzz::point_text, 4000); }
TEST(Mutation, Npz) { run(fuzz::npz_seeds(), fuzz::npz, 4000); }
TEST(Mutation, Ply) { run(fuzz::ply_seeds(), fuzz::ply, 4000); }
TEST(Mutation, RelevantRuns) { run(fuzz::relevant_runs_seeds(), fuzz::relevant_runs); }
TEST(Mutation, Lammps) { run(fuzz::lammps_seeds(), fuzz::lammps, 4000); }

// Through HDF5's library: see Hdf5Points.DamagedFiles.
TEST(Mutation, Hdf5Lattice) {
  const std::vector<std::string> seeds = fuzz::hdf5_lattice_seeds();
  if (seeds.empty()) GTEST_SKIP() << "this build has no HDF5";
  const TestFolder folder;
  for (const std::string& seed : seeds)
    EXPECT_EQ(error_of([&] { read_dataset({folder.write("a.h5", seed)}); }), "");
  run(seeds, fuzz::hdf5_lattice);
}

// The seeds are worth nothing if they are refused at the door.
TEST(Mutation, SeedsAreValid) {
  for (const std::string& seed : fuzz::npy_seeds()) {
    EXPECT_EQ(
        error_of([&] { read_source(*open_memory("a.npy", std::as_bytes(std::span(seed))), {}); }),
        "");
  }
  for (const std::string& seed : fuzz::dicom_seeds()) {
    EXPECT_EQ(
        error_of([&] { read_source(*open_memory("a.dcm", std::as_bytes(std::span(seed))), {}); }),
        "");
  }
  const auto nrrd = fuzz::nrrd_seeds();
  for (std::size_t i = 0; i < 7; ++i) {  // the attached ones
    EXPECT_EQ(error_of([&] {
                read_source(*open_memory("a.nrrd", std::as_bytes(std::span(nrrd[i]))), {});
              }),
              "")
        << i;
  }
  const std::pair<const char*, std::vector<std::string>> whole[] = {
      {"a.nii", fuzz::nifti_seeds()},      {"a.mha", fuzz::metaimage_seeds()},
      {"a.nc", fuzz::netcdf_seeds()},      {"a.slc", fuzz::slc_seeds()},
      {"a.csv", fuzz::point_text_seeds()}, {"a.npz", fuzz::npz_seeds()},
      {"a.ply", fuzz::ply_seeds()},        {"a.dump", fuzz::lammps_seeds()}};
  for (const auto& format : whole) {
    const std::vector<std::string>& seeds = format.second;
    for (std::size_t i = 0; i < std::min<std::size_t>(seeds.size(), 5); ++i) {  // in one file
      const auto source = open_memory(format.first, std::as_bytes(std::span(seeds[i])));
      EXPECT_EQ(error_of([&] { read_source(*source, {}); }), "") << format.first << i;
    }
  }
  const auto vtk = fuzz::vtk_header_seeds();
  for (std::size_t i = 0; i < vtk.size(); ++i) {
    const auto source = open_memory("a.vti", std::as_bytes(std::span(vtk[i])));
    EXPECT_EQ(error_of([&] {
                vtk[i].starts_with("# vtk") ? check_legacy_vtk(*source)
                                            : check_vtk_xml(*source).grid;
              }),
              "")
        << i;
  }
  for (const std::string& seed : fuzz::plot3d_seeds()) {
    const auto bytes = std::as_bytes(std::span(seed));
    ASSERT_FALSE(seed.empty());
    const std::size_t split = 1 + (seed.size() - 1) * static_cast<std::size_t>(bytes[0]) / 255;
    const fuzz::MemoryFile grid(bytes.subspan(1, split - 1)), solution(bytes.subspan(split));
    EXPECT_EQ(error_of([&] { read_plot3d(grid.path(), {solution.path()}, {}); }), "");
  }
  const auto netcdf = fuzz::netcdf_header_seeds();
  for (std::size_t i = 0; i < 2; ++i) {  // the third is HDF5
    EXPECT_EQ(
        error_of([&] { check_exodus(*open_memory("a.e", std::as_bytes(std::span(netcdf[i])))); }),
        "")
        << i;
  }
  for (const std::string& seed : fuzz::gltf_seeds()) {
    const auto bytes = std::as_bytes(std::span(seed));
    EXPECT_EQ(error_of([&] { read_source(*open_memory("a.gltf", bytes), {}); }), "");
  }
  for (const std::string& seed : fuzz::vdb_header_seeds()) {
    EXPECT_EQ(
        error_of([&] { read_vdb_header(*open_memory("a.vdb", std::as_bytes(std::span(seed)))); }),
        "");
  }
  for (const std::string& seed : fuzz::look_2d_seeds()) {
    const fuzz::MemoryFile file(std::as_bytes(std::span(seed)));
    EXPECT_EQ(error_of([&] { read_transfer_function_2d(file.path()); }), "") << seed;
  }
  for (const std::string& seed : fuzz::label_table_seeds()) {
    const fuzz::MemoryFile file(std::as_bytes(std::span(seed)));
    EXPECT_EQ(error_of([&] { read_label_table(file.path()); }), "") << seed;
  }
  for (const std::string& seed : fuzz::look_seeds()) {
    const fuzz::MemoryFile file(std::as_bytes(std::span(seed)));
    EXPECT_EQ(error_of([&] { read_look(file.path()); }), "") << seed;
  }
  for (const std::string& seed : fuzz::camera_seeds()) {
    const fuzz::MemoryFile file(std::as_bytes(std::span(seed)));
    EXPECT_EQ(error_of([&] { read_camera(file.path()); }), "") << seed;
  }
}

// Through VTK itself, silently.
TEST(Mutation, VtkFiles) {
  const TestFolder folder;
  testing::internal::CaptureStderr();
  const std::string first = folder.write("seed.vti", fuzz::vtk_header_seeds()[0]);
  const bool has_vtk = error_of([&] { read_dataset({first}); }).find("no VTK") == std::string::npos;
  const std::string path = folder.file("a.vti");
  ReadOptions options;
  options.session = std::make_shared<ReaderSession>(std::vector{path});
  Mutator mutator(fuzz::vtk_header_seeds());
  for (int i = 0; has_vtk && i < wanted(1000); ++i) {
    const std::string input = mutator.next();
    folder.write("a.vti", input);
    try {
      fuzz::expect_dataset_or_error([&] { return read_dataset({path}, options); });
    } catch (const std::exception& error) {
      ADD_FAILURE() << "mutation " << i << " of seed " << kSeed << ": " << error.what() << "\n"
                    << testing::PrintToString(input);
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  if (!has_vtk) GTEST_SKIP() << "this build has no VTK";
}

}  // namespace mutation_test
}  // namespace ovoid::io
