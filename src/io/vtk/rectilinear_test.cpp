// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/rectilinear.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/foreign/vtk_header.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace rectilinear_test {

using Axes = std::array<AxisCoordinates, 3>;

std::string axes_error(const Axes& axes) {
  return error_of([&] { lattice_of_coordinates("a.vtr", axes); });
}

bool is_lattice(const Axes& axes) { return lattice_of_coordinates("a.vtr", axes).has_value(); }

TEST(Rectilinear, EqualSpacingIsALattice) {
  const LatticeGeometry lattice =
      lattice_of_coordinates("a.vtr", {{{{1, 1.5, 2}}, {{5, 3}}, {{7}}}}).value();
  EXPECT_EQ(lattice.dims, (Index3{3, 2, 1}));
  EXPECT_EQ(lattice.world_from_index * Vec3(1, 1, 1), Vec3(1.5, 3, 7.5));
  // Rounded to float32 far from the origin, they are as equal as that type can say.
  AxisCoordinates far{{}, true};
  for (int i = 0; i < 300; ++i) far.values.push_back(static_cast<float>(1000 + 0.01 * i));
  EXPECT_NEAR(lattice_of_coordinates("a.vtr", {{far, {{0, 1}}, {{0, 1}}}})->spacing()[0], 0.01,
              1e-6);
  far.is_float32 = false;
  EXPECT_FALSE(is_lattice({{far, {{0, 1}}, {{0, 1}}}}));
}

// At the bound and beyond it.
TEST(Rectilinear, OtherGridsAreNone) {
  const double bound = kMaxUnevenness;
  EXPECT_TRUE(is_lattice({{{{0, 1 + 0.9 * bound, 2}}, {{0, 1}}, {{0, 1}}}}));
  EXPECT_FALSE(is_lattice({{{{0, 1 + 1.1 * bound, 2}}, {{0, 1}}, {{0, 1}}}}));
  EXPECT_FALSE(is_lattice({{{{0, 1}}, {{0, 1, 2, 6}}, {{0, 1}}}}));
  EXPECT_EQ(axes_error({{{{0, 1}}, {{0, 1}}, {{3, 3}}}}),
            "file-format: a.vtr: coordinates: the samples of axis z are 0 apart: expected 1e-90 to "
            "1e90");
  EXPECT_EQ(axes_error({{{{0, NAN}}, {{0, 1}}, {{0, 1}}}}),
            "file-format: a.vtr: x coordinates: nan: is not finite");
}

const std::string kVtr =
    R"(<VTKFile type="RectilinearGrid" version="0.1" byte_order="LittleEndian">
<RectilinearGrid WholeExtent="1 3 0 1 0 0"><Piece Extent="1 3 0 1 0 0">
<PointData><DataArray type="UInt8" Name="v" format="ascii">1 2 3 4 5 6</DataArray></PointData>
<Coordinates><DataArray type="Float32" Name="x" format="ascii">0 0.5 1</DataArray>
<DataArray type="Float64" Name="y" format="ascii">-1 1</DataArray>
<DataArray type="Int32" Name="z" format="ascii">5</DataArray></Coordinates>
</Piece></RectilinearGrid></VTKFile>
)";

const std::string kLegacy =
    "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 3 2 1\n"
    "X_COORDINATES 3 float\n0 0.5 1\nY_COORDINATES 2 double\n-1 1\nZ_COORDINATES 1 int\n5\n"
    "POINT_DATA 6\nSCALARS v unsigned_char\nLOOKUP_TABLE default\n1 2 3 4 5 6\n";

TEST(Rectilinear, FilesOfBothKindsAreRead) {
  const TestFolder folder;
  const std::string first = folder.write("a.vtr", kVtr);
  if (error_of([&] { read_dataset({first}); }).find("no VTK") != std::string::npos)
    GTEST_SKIP() << "this build has no VTK";
  for (const std::string& path : {first, folder.write("a.vtk", kLegacy)}) {
    const Dataset dataset = read_dataset({path});
    EXPECT_EQ(dataset.format, path == first ? "VTR" : "legacy VTK");
    EXPECT_EQ(dataset.lattice.dims, (Index3{3, 2, 1}));
    EXPECT_EQ(dataset.lattice.spacing(), Vec3(0.5, 2, 0.5));
    EXPECT_EQ(Vec3(dataset.lattice.world_from_index.translation()), Vec3(0, -1, 5));
    EXPECT_EQ(values_of<std::uint8_t>(dataset.array()), counting<std::uint8_t>(6));
  }
  // Of unequal spacing: a structured mesh whose nodes are where the samples are.
  for (const std::string& path : {folder.write("b.vtr", with(kVtr, "0 0.5 1", "0 0.6 1")),
                                  folder.write("b.vtk", with(kLegacy, "0 0.5 1", "0 0.6 1"))}) {
    const Dataset mesh = read_dataset({path});
    EXPECT_EQ(mesh.kind, DatasetKind::kMesh);
    EXPECT_EQ(mesh.cells.dims, (Index3{3, 2, 1}));
    ASSERT_EQ(mesh.positions.type, ScalarType::kFloat64);
    const auto positions = values_of<double>(mesh.positions);
    EXPECT_NEAR(positions[3], 0.6, 1e-7);
    EXPECT_EQ(positions[4], -1);
    EXPECT_EQ(positions[5], 5);
    EXPECT_EQ(values_of<std::uint8_t>(mesh.array()), counting<std::uint8_t>(6));
  }
}

TEST(Rectilinear, CoordinatesAreMeasuredBeforeVtkSeesThem) {
  const auto vtr_error = [](const std::string& content) {
    return error_of(
        [&] { check_vtk_xml(*open_memory("a.vtr", std::as_bytes(std::span(content)))); });
  };
  EXPECT_EQ(vtr_error(kVtr), "");
  EXPECT_EQ(vtr_error(with(kVtr, "0 0.5 1", "0 0.5")),
            "file-format: a.vtr: array 'x': holds 2 numbers, 3 tuples of 1 Float32 need more");
  EXPECT_EQ(
      vtr_error(with(kVtr, R"(<DataArray type="Int32" Name="z" format="ascii">5</DataArray>)", "")),
      "file-format: a.vtr: Coordinates: a piece has 2 arrays of them: expected 3");
  EXPECT_EQ(vtr_error(with(kVtr, "5</DataArray>",
                           R"(5</DataArray><DataArray type="Int8" format="ascii">1</DataArray>)"))
                .substr(0, 70),
            "file-format: a.vtr: Coordinates: a piece has more than 3 arrays of the");
  EXPECT_EQ(vtr_error(with(kVtr, "Int32", "String")),
            "file-format: a.vtr: Coordinates: array 'z': expected numbers of one component");
  EXPECT_EQ(vtr_error(with(kVtr, R"(Name="z")", R"(Name="z" NumberOfComponents="2")")),
            "file-format: a.vtr: Coordinates: array 'z': expected numbers of one component");
  EXPECT_EQ(vtr_error(with(kVtr, "</Coordinates>", "</Coordinates><Coordinates></Coordinates>")),
            "file-format: a.vtr: Coordinates: stand twice, or in no piece");
  const auto legacy_error = [](const std::string& content) {
    return error_of(
        [&] { check_legacy_vtk(*open_memory("a.vtk", std::as_bytes(std::span(content)))); });
  };
  EXPECT_EQ(legacy_error(kLegacy), "");
  EXPECT_EQ(legacy_error(with(kLegacy, "X_COORDINATES 3", "X_COORDINATES 4")),
            "file-format: a.vtk: X_COORDINATES: 4 of them: DIMENSIONS need 3");
  EXPECT_EQ(legacy_error(with(kLegacy, "Y_COORDINATES", "Z_COORDINATES")),
            "file-format: a.vtk: 'z_coordinates': expected Y_COORDINATES, FIELD, POINT_DATA or "
            "CELL_DATA");
  EXPECT_EQ(legacy_error(with(kLegacy, "Z_COORDINATES 1 int\n5\n", "")),
            "file-format: a.vtk: POINT_DATA before the coordinates along all three axes");
  EXPECT_EQ(legacy_error(with(kLegacy, "0 0.5 1", "0 x 1")).substr(0, 46),
            "file-format: a.vtk: X_COORDINATES: 'x' after 1");
}

}  // namespace rectilinear_test
}  // namespace ovoid::io
