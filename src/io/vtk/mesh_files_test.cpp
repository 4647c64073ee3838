// SPDX-License-Identifier: Apache-2.0
// Whole files of meshes: small ones that stand here, and the real ones whose numbers their READMEs
// tell.
#include "io/meshes/mesh_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "io/core/test_data.h"
#include "io/core/test_folder.h"
#include "io/foreign/file_checks.h"
#include "io/foreign/vtk_header.h"
#include "io/images/test_volumes.h"
#include "io/points/test_shares.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace mesh_files_test {

// A hexahedron and a tetrahedron on its side, five arrays.
const std::string kVtu =
    R"(<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="9" NumberOfCells="2">
<PointData><DataArray type="Int32" Name="GlobalNodeId" format="ascii">1 2 3 4 5 6 7 8 9</DataArray>
<DataArray type="Float32" Name="v" format="ascii">0 1 2 3 4 5 6 7 8</DataArray></PointData>
<CellData><DataArray type="Float64" Name="c" format="ascii">10 20</DataArray></CellData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1 2 0 0</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3 4 5 6 7 1 8 2 5</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">8 12</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">12 10</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>
)";

const std::string kLegacyMesh =
    "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n"
    "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1\nCELLS 2 10\n4 0 1 2 3\n4 1 2 3 4\nCELL_TYPES 2\n10\n10\n"
    "POINT_DATA 5\nSCALARS v float\nLOOKUP_TABLE default\n1 2 3 4 5\n";

std::string pieces_of(const std::string& names) {
  return R"(<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid GhostLevel="0">)" + names +
         "</PUnstructuredGrid></VTKFile>";
}

class MeshFiles : public testing::Test {
 protected:
  void SetUp() override {
    if (file_error("probe.vtu", kVtu).find("no VTK") != std::string::npos)
      GTEST_SKIP() << "this build has no VTK";
  }

  std::string file_error(const std::string& name, const std::string& content) const {
    return error_of([&] { read_dataset({folder.write(name, content)}); });
  }

  TestFolder folder;
};

void expect_the_two_cells(const Dataset& mesh) {
  EXPECT_EQ(mesh.kind, DatasetKind::kMesh);
  EXPECT_EQ(mesh.positions.type, ScalarType::kFloat32);
  EXPECT_EQ(mesh.num_positions(), 9);
  EXPECT_EQ(mesh.cells.types, (std::vector{CellType::kHexahedron, CellType::kTetrahedron}));
  EXPECT_EQ(mesh.cells.offsets, (std::vector<std::int64_t>{0, 8, 12}));
  EXPECT_EQ(mesh.cells.connectivity.back(), 5U);
  EXPECT_EQ(mesh.array().name, "v");  // numbers of nodes are not data
  EXPECT_EQ(values_of<double>(mesh.array("c")), (std::vector<double>{10, 20}));
  EXPECT_TRUE(mesh.array("c").is_cell_data);
}

TEST_F(MeshFiles, Vtu) {
  const Dataset mesh = read_dataset({folder.write("a.vtu", kVtu)});
  EXPECT_EQ(mesh.format, "VTU");
  expect_the_two_cells(mesh);
  ReadOptions options;
  options.array = "c";
  EXPECT_EQ(read_dataset({folder.file("a.vtu")}, options).arrays.size(), 1U);
  options.array = "d";
  EXPECT_NE(error_of([&] {
              read_dataset({folder.file("a.vtu")}, options);
            }).find("array 'd': not there: expected one of 'GlobalNodeId', 'v', 'c'"),
            std::string::npos);
}

TEST_F(MeshFiles, GhostCellsOfVtuAreDropped) {
  const std::string ghosts =
      R"(<CellData><DataArray type="UInt8" Name="vtkGhostType" format="ascii">1 0</DataArray>)";
  const Dataset mesh = read_dataset({folder.write("a.vtu", with(kVtu, "<CellData>", ghosts))});
  EXPECT_EQ(mesh.cells.types, std::vector{CellType::kTetrahedron});
  EXPECT_EQ(values_of<double>(mesh.array("c")), std::vector<double>{20});
  EXPECT_EQ(mesh.num_positions(), 9);
}

// Before and behind VTK.
TEST_F(MeshFiles, ContradictionsInVtuAreNamed) {
  const auto vtu_error = [&](const std::string& from, const std::string& to) {
    return file_error("a.vtu", with(kVtu, from, to));
  };
  EXPECT_NE(vtu_error("5 6 7 1 8 2 5<", "5 6 7 1 8 2 9<").find("= 9: the mesh has 9 nodes"),
            std::string::npos);
  EXPECT_NE(vtu_error("5 6 7 1 8 2 5<", "5 6 7 1 8 2 -1<").find("= -1: the mesh has 9 nodes"),
            std::string::npos);
  EXPECT_NE(vtu_error(">8 12<", ">8 1000000000000<").find("cannot hold 1000000000000 node numb"),
            std::string::npos);
  EXPECT_NE(vtu_error(">8 12<", ">13 12<").find("offsets"), std::string::npos);
  EXPECT_NE(vtu_error(">8 12<", ">7 12<").find("cell 0 has 7 nodes: its type needs 8"),
            std::string::npos);
  EXPECT_NE(vtu_error("NumberOfPoints=\"9\"", "NumberOfPoints=\"10\"").find("array 'GlobalNodeId'"),
            std::string::npos);
  EXPECT_NE(vtu_error("NumberOfCells=\"2\"", "NumberOfCells=\"2000000000\"").find("cannot hold"),
            std::string::npos);
  EXPECT_NE(vtu_error("NumberOfPoints=\"9\"", "NumberOfPoints=\"0\"").find("a.vtu: "),
            std::string::npos);
  EXPECT_NE(vtu_error("Name=\"offsets\"", "Name=\"offset\"").find("connectivity and no offsets"),
            std::string::npos);
  EXPECT_NE(vtu_error("0 0 0 1 0 0", "0 0 nan 1 0 0").find("point 0 has z = nan"),
            std::string::npos);
  EXPECT_NE(file_error("a.vtu", kVtu.substr(0, kVtu.size() / 2)), "");
}

// Fails if what is asked for takes away the radii, masses and numbers that the model finds by name.
TEST_F(MeshFiles, PointSetsKeepTheirOtherArrays) {
  const auto array = [](const std::string& name, const std::string& values) {
    return R"(<DataArray type="Float32" Name=")" + name + R"(" format="ascii">)" + values +
           "</DataArray>";
  };
  const auto list = [](const std::string& name, const std::string& type,
                       const std::string& values) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" format=\"ascii\">" + values +
           "</DataArray>";
  };
  const std::string begin = "<PointData>" + array("h", "1 2") + array("mass", "3 4") +
                            array("u", "5 6") +
                            R"(</PointData><Points><DataArray type="Float32" NumberOfComponents="3"
format="ascii">0 0 0 1 0 0</DataArray></Points>)";
  const auto cells = [&](int count) {
    return "<Cells>" + list("connectivity", "Int64", count > 0 ? "0 1" : "") +
           list("offsets", "Int64", count > 0 ? "1 2" : "") +
           list("types", "UInt8", count > 0 ? "1 1" : "") + "</Cells>";
  };
  const auto file = [](const std::string& type, const std::string& counts,
                       const std::string& content) {
    return "<VTKFile type=\"" + type + R"(" version="0.1" byte_order="LittleEndian"><)" + type +
           "><Piece NumberOfPoints=\"2\" " + counts + ">" + content + "</Piece></" + type +
           "></VTKFile>";
  };
  const std::vector<std::string> paths{
      folder.write("vertices.vtu",
                   file("UnstructuredGrid", "NumberOfCells=\"2\"", begin + cells(2))),
      folder.write("points.vtu", file("UnstructuredGrid", "NumberOfCells=\"0\"", begin + cells(0))),
      folder.write("points.vtp", file("PolyData",
                                      R"(NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0"
NumberOfPolys="0")",
                                      begin)),
      folder.write("legacy.vtk",
                   "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n"
                   "0 0 0 1 0 0\nPOINT_DATA 2\nSCALARS h float\nLOOKUP_TABLE default\n1 2\n"
                   "SCALARS mass float\nLOOKUP_TABLE default\n3 4\n"
                   "SCALARS u float\nLOOKUP_TABLE default\n5 6\n")};
  for (const std::string& path : paths) {
    ReadOptions options;
    options.array = "u";
    const Dataset points = read_dataset({path}, options);
    EXPECT_EQ(points.kind, DatasetKind::kParticles) << path;
    ASSERT_EQ(points.arrays.size(), 3U) << path;
    EXPECT_EQ(values_of<float>(points.array("h")), (std::vector<float>{1, 2})) << path;
    EXPECT_EQ(values_of<float>(points.array("mass")), (std::vector<float>{3, 4})) << path;
    options.array = "v";
    EXPECT_NE(error_of([&] { read_dataset({path}, options); }).find("'v'"), std::string::npos);
  }
  ReadOptions options;
  options.array = "c";
  EXPECT_EQ(read_dataset({folder.write("a.vtu", kVtu)}, options).arrays.size(), 1U);  // of a mesh
}

TEST_F(MeshFiles, PiecesAndBlocks) {
  folder.write("a.vtu", kVtu);
  // The same moved by one in x: four nodes of the hexahedra meet, and the tetrahedron's tip.
  folder.write("b.vtu", with(kVtu, "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1 2 0 0",
                             "1 0 0 2 0 0 2 1 0 1 1 0 1 0 1 2 0 1 2 1 1 1 1 1 3 0 0"));
  const Dataset pieces = read_dataset(
      {folder.write("a.pvtu", pieces_of(R"(<Piece Source="a.vtu"/><Piece Source="b.vtu"/>)"))});
  EXPECT_EQ(pieces.format, "PVTU");
  EXPECT_EQ(pieces.num_positions(), 18 - 5);
  EXPECT_EQ(pieces.cells.count(), 4);
  EXPECT_TRUE(pieces.blocks.empty());
  EXPECT_NE(file_error("b.pvtu", pieces_of(R"(<Piece Source="c.vtu"/>)")).find("c.vtu"),
            std::string::npos);
  EXPECT_NE(file_error("c.pvtu", pieces_of("")).find("names no files"), std::string::npos);
  EXPECT_NE(file_error("d.pvtu", pieces_of(R"(<Piece Source="d.pvtu"/>)")).find("8 deep"),
            std::string::npos);

  const std::string blocks = folder.write(
      "a.vtm",
      R"(<VTKFile type="vtkMultiBlockDataSet"><vtkMultiBlockDataSet><Block index="0" name="solid">
<DataSet index="0" name="left" file="a.vtu"/><DataSet index="1" file="b.vtu"/></Block>
<DataSet index="1" file=""/></vtkMultiBlockDataSet></VTKFile>)");
  const Dataset both = read_dataset({blocks});
  ASSERT_EQ(both.blocks.size(), 2U);
  EXPECT_EQ(both.blocks[0].name, "solid/left");
  EXPECT_EQ(both.blocks[1].name, "solid/1");
  ReadOptions options;
  options.block = "solid/left";
  expect_the_two_cells(read_dataset({blocks}, options));
}

// Numbers of nodes that are wrong are found by the share that has the piece.
TEST_F(MeshFiles, SharesArePieces) {
  folder.write("a.vtu", kVtu);
  folder.write("b.vtu", with(kVtu, "5 6 7 1 8 2 5<", "5 6 7 1 8 2 9<"));
  const std::string path = folder.write(
      "a.pvtu",
      pieces_of(R"(<Piece Source="a.vtu"/><Piece Source="b.vtu"/><Piece Source="a.vtu"/>)"));
  const auto share = [&](int number, int count) {
    ReadOptions options;
    options.share = RowShare{number, count};
    return read_dataset({path}, options);
  };
  expect_the_two_cells(share(0, 3));
  EXPECT_EQ(share(0, 3).share->total, 6);
  EXPECT_EQ(share(0, 3).share->nodes.back(), 8U);
  expect_the_two_cells(share(2, 3));
  EXPECT_EQ(share(2, 3).share->first, 4);
  EXPECT_EQ(share(2, 3).share->nodes.front(), std::uint64_t{2} << 32U);
  EXPECT_NE(error_of([&] { share(1, 3); }).find("b.vtu: cells: connectivity[11] = 9"),
            std::string::npos);
  EXPECT_EQ(share(3, 7).num_positions(), 0);
  // A single file is read whole, then cut.
  ReadOptions options;
  options.share = RowShare{1, 2};
  const Dataset second = read_dataset({folder.file("a.vtu")}, options);
  EXPECT_EQ(second.cells.types, std::vector{CellType::kTetrahedron});
  EXPECT_EQ(second.share->nodes, (std::vector<std::uint64_t>{1, 2, 5, 8}));
}

// As the whole would be, of which one step varies.
TEST_F(MeshFiles, SharesOfASeriesAreOfOneStep) {
  folder.write("a.vtu", with(kVtu, ">0 1 2 3 4 5 6 7 8<", ">0 0 0 0 0 0 0 0 0<"));
  folder.write("b.vtu", kVtu);
  const std::string series = folder.write("a.pvd", R"(<VTKFile type="Collection"><Collection>
<DataSet timestep="2.5" file="b.vtu"/><DataSet timestep="2.5" file="b.vtu"/>
<DataSet timestep="-1" file="a.vtu"/><DataSet timestep="-1" file="a.vtu"/></Collection></VTKFile>)");
  ReadOptions options;
  options.share = RowShare{1, 2};
  EXPECT_EQ(read_dataset({series}, options).step, 1);
  options.step = 1;
  const Dataset named = read_dataset({series}, options);
  EXPECT_EQ(named.times, (std::vector<double>{-1, 2.5}));
  EXPECT_EQ(named.share->nodes.front(), std::uint64_t{1} << 32U);  // the second piece
}

TEST_F(MeshFiles, TimeSeriesBeginWhereTheyVary) {
  folder.write("a.vtu", with(kVtu, ">0 1 2 3 4 5 6 7 8<", ">0 0 0 0 0 0 0 0 0<"));
  folder.write("b.vtu", kVtu);
  const std::string series = folder.write("a.pvd", R"(<VTKFile type="Collection"><Collection>
<DataSet timestep="2.5" file="b.vtu"/><DataSet timestep="-1" file="a.vtu"/></Collection></VTKFile>)");
  const Dataset mesh = read_dataset({series});
  EXPECT_EQ(mesh.times, (std::vector<double>{-1, 2.5}));
  EXPECT_EQ(mesh.step, 1);  // the array of cells varies at the first, but nodes come first
  expect_the_two_cells(mesh);
  ReadOptions options;
  options.step = 0;
  EXPECT_EQ(read_dataset({series}, options).step, 0);
  EXPECT_EQ(mesh.time_unit, "");
  EXPECT_EQ(mesh.space, Space::kNone);
  EXPECT_EQ(read_dataset({folder.file("a.vtu"), folder.file("b.vtu")}).step, 1);
}

// What ParaView's files have no words for stands beside its own.
TEST_F(MeshFiles, TimeSeriesMaySayTheirUnitAndSpace) {
  folder.write("a.vtu", kVtu);
  const auto series = [&](const std::string& words) {
    return folder.write("a.pvd", R"(<VTKFile type="Collection"><Collection )" + words +
                                     R"(><DataSet timestep="1" file="a.vtu"/></Collection>
</VTKFile>)");
  };
  const Dataset mesh = read_dataset({series(R"(TimeUnit="&lt;ms&gt;" Space="RAS")")});
  EXPECT_EQ(mesh.time_unit, "<ms>");
  EXPECT_EQ(mesh.space, Space::kRas);
  EXPECT_NE(error_of([&] {
              read_dataset({series(R"(Space="MNI")")});
            }).find("Space=\"MNI\": expected none, LPS or RAS"),
            std::string::npos);
}

TEST_F(MeshFiles, LegacyMeshesOfEveryKind) {
  const Dataset mesh = read_dataset({folder.write("a.vtk", kLegacyMesh)});
  EXPECT_EQ(mesh.kind, DatasetKind::kMesh);
  EXPECT_EQ(mesh.cells.count(), 2);
  EXPECT_EQ(mesh.cells.connectivity, (std::vector<std::uint32_t>{0, 1, 2, 3, 1, 2, 3, 4}));
  // As version 5 stores cells.
  const Dataset later = read_dataset({folder.write(
      "b.vtk",
      with(with(kLegacyMesh, "Version 3.0", "Version 5.1"), "CELLS 2 10\n4 0 1 2 3\n4 1 2 3 4\n",
           "CELLS 3 8\nOFFSETS vtktypeint64\n0 4 8\nCONNECTIVITY vtktypeint64\n0 1 2 3 1 "
           "2 3 4\n"))});
  EXPECT_EQ(later.cells.connectivity, mesh.cells.connectivity);

  const Dataset grid = read_dataset({folder.write(
      "c.vtk",
      "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS 2 2 1\n"
      "POINTS 4 double\n0 0 0 1 0 0 0 1 0 1 2 0\nCELL_DATA 1\nSCALARS c int\nLOOKUP_TABLE "
      "default\n7\n")});
  EXPECT_EQ(grid.cells.dims, (Index3{2, 2, 1}));
  EXPECT_EQ(grid.positions.type, ScalarType::kFloat64);
  const Dataset points = read_dataset({folder.write(
      "d.vtk",
      "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 "
      "0\nPOLYGONS 1 4\n3 0 1 2\nPOINT_DATA 3\nSCALARS v float\nLOOKUP_TABLE default\n1 2 3\n")});
  EXPECT_EQ(points.kind, DatasetKind::kParticles);
  EXPECT_EQ(points.num_positions(), 3);
  expect_shares(
      [&](const ReadOptions& options) { return read_dataset({folder.file("d.vtk")}, options); });
}

TEST_F(MeshFiles, LegacyListsOfCellsAreWalkedBeforeVtkDoes) {
  const auto legacy_error = [&](const std::string& from, const std::string& to) {
    const std::string content = with(kLegacyMesh, from, to);
    return error_of(
        [&] { check_legacy_vtk(*open_memory("a.vtk", std::as_bytes(std::span(content)))); });
  };
  EXPECT_EQ(legacy_error("title", "a title"), "");
  EXPECT_EQ(legacy_error("\n4 1 2 3 4", "\n5 1 2 3 4"),
            "file-format: a.vtk: CELLS: cell 1 has 5 nodes: 4 of 10 numbers are left");
  EXPECT_EQ(legacy_error("CELLS 2 10\n4", "CELLS 2 10\n3"),
            "file-format: a.vtk: CELLS: 2 cells take 8 of 10 numbers");
  EXPECT_EQ(legacy_error("4 1 2 3 4\n", "4 1 2 3 5\n"),
            "file-format: a.vtk: CELLS: node 5: there are 5 POINTS");
  EXPECT_EQ(legacy_error("CELL_TYPES 2", "CELL_TYPES 3"),
            "file-format: a.vtk: CELL_TYPES: 3 of them behind 2 CELLS");
  EXPECT_NE(legacy_error("CELLS 2 10", "CELLS 2 1000000000"), "");
  EXPECT_NE(legacy_error("POINTS 5", "POINTS 2000000000"), "");
  EXPECT_EQ(legacy_error("POINT_DATA 5", "POINT_DATA 6"),
            "file-format: a.vtk: POINT_DATA: '6': POINTS and CELLS need 5");
}

TEST_F(MeshFiles, AdaptiveGridsAreTheirFinestCells) {
  const auto image = [&](const std::string& name, const char* extent, const char* spacing,
                         const std::string& values) {
    folder.write(name, std::string(R"(<VTKFile type="ImageData"><ImageData WholeExtent=")") +
                           extent + R"(" Origin="0 0 0" Spacing=")" + spacing +
                           R"("><Piece Extent=")" + extent +
                           R"("><CellData><DataArray type="Float32" Name="rho" format="ascii">)" +
                           values + "</DataArray></CellData></Piece></ImageData></VTKFile>");
  };
  image("0.vti", "0 2 0 2 0 1", "1 1 1", "1 2 3 4");
  image("1.vti", "2 4 0 2 0 2", "0.5 0.5 0.5", "10 11 12 13 14 15 16 17");
  const Dataset boxes = read_dataset({folder.write(
      "a.vth",
      R"(<VTKFile type="vtkOverlappingAMR"><vtkOverlappingAMR origin="0 0 0" grid_description="XYZ">
<Block level="0" spacing="1 1 1"><DataSet index="0" amr_box="0 1 0 1 0 0" file="0.vti"/></Block>
<Block level="1"><DataSet index="0" amr_box="2 3 0 1 0 1" file="1.vti"/></Block>
</vtkOverlappingAMR></VTKFile>)")});
  EXPECT_EQ(boxes.kind, DatasetKind::kBoxes);
  // The second cell of four is covered by eight.
  EXPECT_EQ(values_of<float>(boxes.array("rho")),
            (std::vector<float>{1, 3, 4, 10, 11, 12, 13, 14, 15, 16, 17}));
  const auto centers = values_of<double>(boxes.positions);
  EXPECT_EQ(centers[9], 1.25);  // that of 10
  EXPECT_EQ(centers[10], 0.25);
  const auto sizes = values_of<double>(boxes.box_sizes);
  double volume = 0;
  for (std::size_t i = 0; i < sizes.size(); i += 3)
    volume += sizes[i] * sizes[i + 1] * sizes[i + 2];
  EXPECT_EQ(volume, 4);
}

// A netCDF header of one dimension, one attribute and one variable of ten doubles.
std::string netcdf(std::uint32_t size, std::size_t num_there,
                   const std::string& attribute = "api_version") {
  std::string bytes = "CDF\x01";
  const auto number = [&](std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8)
      bytes += static_cast<char>(value >> static_cast<unsigned>(shift) & 0xffU);
  };
  const auto name = [&](const std::string& text) {
    number(static_cast<std::uint32_t>(text.size()));
    bytes += text + std::string((4 - text.size() % 4) % 4, '\0');
  };
  number(0);
  number(10), number(1), name("n"), number(size);
  number(12), number(1), name(attribute), number(4), number(1), number(7);
  number(11), number(1), name("xy"), number(1), number(0), number(0), number(0), number(6);
  number(size * 8), number(static_cast<std::uint32_t>(bytes.size()) + 4);
  return bytes + std::string(num_there, 'x');
}

TEST(NetcdfHeader, VariablesMustBeThere) {
  const auto error = [](const std::string& bytes) {
    return error_of([&] { check_exodus(*open_memory("a.e", std::as_bytes(std::span(bytes)))); });
  };
  EXPECT_EQ(error(netcdf(10, 80)), "");
  EXPECT_EQ(error(netcdf(10, 70)),
            "file-format: a.e: netCDF variable 'xy' needs 80 bytes from 108 on, the file has 178: "
            "is it truncated?");
  EXPECT_NE(error(netcdf(0x7fffffff, 80)), "");
  EXPECT_EQ(error(netcdf(10, 80).substr(0, 30)),
            "file-format: a.e: the netCDF header ends at attributes of the file: is the file "
            "truncated?");
  EXPECT_NE(error("CDF\x07 and more"), "");
  EXPECT_EQ(error(netcdf(10, 80, "Conventions")),
            "unsupported: a.e: is netCDF, but no Exodus mesh (it has no attribute 'api_version')");
}

// What every Exodus reader finds in these.
TEST_F(MeshFiles, ExodusAsTheReadmesSay) {
  const std::string disk = real_data_path("disk_out_ref/disk_out_ref.ex2");
  if (disk.empty()) GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
  const Dataset mesh = read_dataset({disk});
  EXPECT_EQ(mesh.format, "Exodus");
  EXPECT_EQ(mesh.num_positions(), 8499);
  EXPECT_EQ(mesh.cells.count(), 7472);
  EXPECT_TRUE(std::all_of(mesh.cells.types.begin(), mesh.cells.types.end(),
                          [](CellType type) { return type == CellType::kHexahedron; }));
  const auto temperature = values_of<double>(mesh.array());
  EXPECT_NEAR(*std::max_element(temperature.begin(), temperature.end()), 913.15, 1e-3);

  const std::string mug = real_data_path("mug/mug.e");
  const Dataset first = read_dataset({mug});
  EXPECT_EQ(first.num_steps, 21);
  EXPECT_EQ(first.step, 1);  // all zero before
  EXPECT_EQ(first.cells.count(), 1716 + 760);
  EXPECT_EQ(first.num_positions(), 2694 + 1260 - 180);
  ReadOptions options;
  options.step = 20;
  options.array = "diffused";
  options.block = first.blocks.at(1).name;
  EXPECT_EQ(options.block, "76");
  const Dataset last = read_dataset({mug}, options);
  EXPECT_EQ(last.num_positions(), 1260);
  EXPECT_EQ(last.cells.count(), 760);
  options.block = "coffee";
  EXPECT_NE(error_of([&] { read_dataset({mug}, options); }).find("expected one of '1', '76'"),
            std::string::npos);
  const TestFolder cut;
  std::ifstream whole(mug, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(whole), {}};
  bytes.resize(bytes.size() / 2);
  EXPECT_NE(error_of([&] { read_dataset({cut.write("mug.e", bytes)}); }).find("is it truncated?"),
            std::string::npos);
}

TEST_F(MeshFiles, TheCanInThreeFormats) {
  const std::string vtu = real_data_path("can/can.vtu");
  if (vtu.empty()) GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
  const std::vector<std::string> steps{real_data_path("can/can_0.hdf"),
                                       real_data_path("can/can_1.hdf"),
                                       real_data_path("can/can_2.hdf")};
  for (const auto& paths : {std::vector{vtu}, std::vector{steps[2]}, steps}) {
    const Dataset mesh = read_dataset(paths);
    EXPECT_EQ(mesh.num_positions(), 6724);
    EXPECT_EQ(mesh.cells.count(), 4800);
    EXPECT_EQ(mesh.step, paths.size() == 3 ? 1 : 0);
    const auto strain = values_of<double>(mesh.array("EQPS"));
    EXPECT_NEAR(*std::max_element(strain.begin(), strain.end()),
                paths.size() == 3 ? 1.884
                : paths[0] == vtu ? 2.89394
                                  : 2.873,
                5e-4);
  }
  const TestFolder cut;
  std::ifstream whole(steps[0], std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(whole), {}};
  bytes.resize(bytes.size() - 1000);
  EXPECT_NE(error_of([&] { read_dataset({cut.write("a.hdf", bytes)}); }).find("is it truncated?"),
            std::string::npos);
}

TEST_F(MeshFiles, TheLimbAndTheCosmosAsTheReadmesSay) {
  const std::string limb = real_data_path("limb_tetra/limb_ugrid.vtk");
  if (limb.empty()) GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
  const Dataset mesh = read_dataset({limb});
  EXPECT_EQ(mesh.num_positions(), 10926);
  EXPECT_EQ(mesh.cells.count(), 58977);
  EXPECT_EQ(mesh.array().name, "chem_0");

  for (const char* const name : {"enzo_amr/moving7_0010", "enzo_amr/moving7_0010.hierarchy"}) {
    const Dataset boxes = read_dataset({real_data_path(name)});
    EXPECT_EQ(boxes.kind, DatasetKind::kBoxes);
    EXPECT_EQ(boxes.num_positions(), 30360 - 3283);
    // The cells that are left fill the unit cube exactly once.
    const auto sizes = values_of<double>(boxes.box_sizes);
    double volume = 0;
    for (std::size_t i = 0; i < sizes.size(); i += 3)
      volume += sizes[i] * sizes[i + 1] * sizes[i + 2];
    EXPECT_NEAR(volume, 1, 1e-12);
    const auto density = values_of<float>(boxes.array("Density"));
    EXPECT_NEAR(*std::min_element(density.begin(), density.end()), 0.098753, 1e-5);
    EXPECT_NEAR(*std::max_element(density.begin(), density.end()), 2.5695e5, 10);
  }
}

}  // namespace mesh_files_test
}  // namespace ovoid::io
