// SPDX-License-Identifier: Apache-2.0
// `ovoid make solid` on the command line. Fails if a flag does not reach the solid, if what is
// written cannot be read and drawn, or if what cannot be leaves a file.
#include <gtest/gtest.h>

#include <filesystem>

#include "program.h"

namespace ovoid::cli_tests {
namespace make_solid_test {

class MakeSolid : public testing::Test {
 protected:
  bool reads_vtu() {
    const std::string path = folder_ / "star.vtu";
    expect_success({"make", "solid", "--levels", "0", "-o", path});
    return run({"info", path}).err.find("no VTK") == std::string::npos;
  }

  // A mesh of text, legacy VTK: one row of cells along x with a value per node.
  std::string row_of_cells(const std::string& cells, const std::string& values) {
    std::string points =
        "# vtk DataFile Version 3.0\nrow\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        "POINTS 12 float\n";
    for (int x = 0; x < 3; ++x) {
      for (const char* const corner : {"0 0", "1 0", "1 1", "0 1"})
        points += std::to_string(x) + " " + corner + "\n";
    }
    const std::string path = folder_ / "row.vtk";
    write_file(path, points + cells + "POINT_DATA 12\nSCALARS rho float 1\nLOOKUP_TABLE default\n" +
                         values + "\n");
    return path;
  }

  Folder folder_;
};

constexpr const char* kTwoCells =
    "CELLS 2 18\n8 0 1 2 3 4 5 6 7\n8 4 5 6 7 8 9 10 11\nCELL_TYPES 2\n12 12\n";
constexpr const char* kValues = "0 0 0 0 1 1 1 1 0 0 0 0";

TEST_F(MakeSolid, KernelsAreDrawn) {
  const std::string solid = folder_ / "solid.ply";
  expect_success({"make", "solid", "-o", solid});
  const auto field = facts_of(solid)["field"];
  EXPECT_EQ(field["num_kernels"], 1405);
  EXPECT_EQ(field["reconstruction"], "sum");
  EXPECT_EQ(field["array"], "density");
  EXPECT_GT(draw(folder_, {solid}).num_covered(), 100U);
  expect_success({"make", "solid", "-o", solid, "--levels", "0", "--basis", "two"});
  EXPECT_EQ(facts_of(solid)["field"]["num_kernels"], 2 * 258);
  // As published: what is even comes out a third too dense.
  const auto greatest = [&](const char* basis) {
    expect_success({"make", "solid", "-o", solid, "--basis", basis});
    return facts_of(solid)["field"]["range"][1].get<double>();
  };
  EXPECT_GT(greatest("one"), 1.1 * greatest("interpolating"));
}

TEST_F(MakeSolid, ALimitOfMemoryIsHeldBeforeAnyWork) {
  const std::string solid = folder_ / "solid.ply";
  expect_failure({"make", "solid", "-o", solid, "--levels", "2", "--memory-limit", "1M"}, 3,
                 {"7040", "memory limit of 1048576"});
  EXPECT_FALSE(std::filesystem::exists(solid));
}

TEST_F(MakeSolid, MeshesAreWrittenAndRead) {
  if (!reads_vtu()) GTEST_SKIP() << "this build reads no VTU";
  const std::string star = folder_ / "star.vtu", level = folder_ / "level.vtu",
                    solid = folder_ / "solid.ply";
  expect_success({"make", "solid", "--control", star, "--levels", "2", "-o", level});
  EXPECT_EQ(facts_of(level)["cells"]["count"], 64 * 110);
  expect_success({"make", "solid", "--control", star, "-o", solid});
  EXPECT_EQ(facts_of(solid)["field"]["num_kernels"], 1405);
}

TEST_F(MakeSolid, TakesAMeshOfHexahedra) {
  if (!reads_vtu()) GTEST_SKIP() << "this build reads no VTK";
  const std::string row = row_of_cells(kTwoCells, kValues), solid = folder_ / "solid.ply";
  expect_success({"make", "solid", "--control", row, "--array", "rho", "-o", solid});
  EXPECT_EQ(facts_of(solid)["field"]["array"], "rho");
  expect_failure({"make", "solid", "--control", row, "--array", "none", "-o", folder_ / "x.ply"}, 1,
                 {"row.vtk", "none", "rho"});
}

TEST_F(MakeSolid, RefusesWhatCannotBe) {
  const std::string solid = folder_ / "x.ply";
  expect_failure({"make", "solid", "-o", folder_ / "x.nrrd"}, 2, {"--output", ".ply", ".vtu"});
  expect_failure({"make", "solid", "-o", solid, "--levels", "9"}, 2, {"--levels"});
  expect_failure({"make", "solid", "-o", solid, "--basis", "three"}, 2, {"--basis"});
  expect_failure({"make", "solid", "-o", solid, "--array", "a"}, 2, {"--array", "--control"});
  expect_failure({"make", "solid", "-o", solid, "--size", "8"}, 2, {"--size", "'solid'"});
  expect_failure({"make", "blobs", "-o", solid, "--levels", "1"}, 2, {"--levels", "'solid'"});
  expect_failure({"make", "solid", "-o", solid, "--levels", "8"}, 3, {"110 cells", "memory limit"});
  expect_failure({"make", "solid", "--control", folder_ / "no.vtu", "-o", solid}, 1, {"no.vtu"});
  expect_failure({"make", "solid", "--control", write_ball(folder_), "-o", solid}, 1,
                 {"is of kind lattice", "mesh of hexahedra"});
  EXPECT_FALSE(std::filesystem::exists(solid));
}

TEST_F(MakeSolid, RefusesMeshesThatAreNoControlMesh) {
  if (!reads_vtu()) GTEST_SKIP() << "this build reads no VTK";
  const std::string solid = folder_ / "x.ply";
  const auto refused = [&](const std::string& mesh, const Words& words) {
    expect_failure({"make", "solid", "--control", mesh, "-o", solid}, 1, words);
  };
  refused(row_of_cells("CELLS 1 5\n4 0 1 3 4\nCELL_TYPES 1\n10\n", kValues),
          {"cells[0]: is a tetrahedron", "hexahedra"});
  refused(row_of_cells("CELLS 1 9\n8 0 1 2 3 4 5 7 6\nCELL_TYPES 1\n12\n", kValues),
          {"cells[0]: inside out at vertex"});
  const std::string star = folder_ / "star.vtu";
  expect_failure({"make", "solid", "--control", star, "-o", star}, 2, {"is an input"});
}

}  // namespace make_solid_test
}  // namespace ovoid::cli_tests
