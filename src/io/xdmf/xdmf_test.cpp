// SPDX-License-Identifier: Apache-2.0
// XDMF with numbers in its text and in raw files. What would make it fail: axes in another order,
// sizes that are believed, a pointer that leads elsewhere.
#include "io/xdmf/xdmf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/formats.h"
#include "io/images/test_volumes.h"
#include "io/points/test_shares.h"
#include "io/read_source.h"
#include "io/xdmf/test_xdmf.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

namespace ovoid::io {
namespace xdmf_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kTwelve = xdmf_item("12", xdmf_counting(12));
const std::string kEvenValues =
    xdmf_attribute("f", xdmf_item("2 3 4", xdmf_counting(24), "Precision=\"8\""));

Dataset read_xdmf_text(const std::string& content, const ReadOptions& options = {},
                       const MemoryFiles& files = {}) {
  return read_source(*open_memory("a.xmf", std::as_bytes(std::span(content))), options,
                     files.opener());
}

// What is wrong with a file of this domain.
std::string xdmf_error(const std::string& domain, const MemoryFiles& files = {}) {
  return error_of([&] { read_xdmf_text(xdmf_file(domain), {}, files); });
}

void expect_the_mixed_cells(const Dataset& mesh) {
  EXPECT_EQ(mesh.kind, DatasetKind::kMesh);
  EXPECT_EQ(mesh.num_positions(), 9);
  EXPECT_EQ(mesh.cells.types, (std::vector{CellType::kHexahedron, CellType::kTetrahedron}));
  EXPECT_EQ(mesh.cells.offsets, (std::vector<std::int64_t>{0, 8, 12}));
  EXPECT_EQ(mesh.cells.connectivity,
            (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7, 1, 8, 2, 5}));
}

TEST(Xdmf, EvenGridsAreLattices) {
  const std::string cells =
      xdmf_attribute("c", xdmf_item("1 2 3", "1 2 3 4 5 6", "NumberType=\"UChar\""),
                     "AttributeType=\"Scalar\" Center=\"Cell\"");
  const std::string vectors = xdmf_attribute("v", xdmf_item("2 3 4 3", xdmf_counting(72)),
                                             "AttributeType=\"Vector\" Center=\"Node\"");
  const Dataset dataset =
      read_xdmf_text(xdmf_file(xdmf_grid(kXdmfEven + kEvenValues + cells + vectors)));
  EXPECT_EQ(dataset.format, "XDMF");
  EXPECT_EQ(dataset.kind, DatasetKind::kLattice);
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(0.5, 2, 3));
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(10, 20, 30));
  ASSERT_EQ(dataset.arrays.size(), 3U);
  EXPECT_EQ(dataset.array("f").type, ScalarType::kFloat64);
  EXPECT_EQ(values_of<double>(dataset.array("f")), counting<double>(24));
  EXPECT_TRUE(dataset.array("c").is_cell_data);
  EXPECT_EQ(values_of<std::uint8_t>(dataset.array("c")), counting<std::uint8_t>(6));
  EXPECT_EQ(dataset.array("v").num_components, 3);
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("are taken in the order of Dimensions, z, y and "
                                                   "x: spacing 0.5, 2, 3 along x, y, z")));
  ReadOptions options;
  options.array = "c";
  EXPECT_EQ(
      read_xdmf_text(xdmf_file(xdmf_grid(kXdmfEven + kEvenValues + cells)), options).arrays.size(),
      1U);
  options.array = "d";
  EXPECT_THAT(
      error_of([&] { read_xdmf_text(xdmf_file(xdmf_grid(kXdmfEven + kEvenValues)), options); }),
      HasSubstr("'d'"));
}

TEST(Xdmf, PlaneGridsHaveOneSlice) {
  const std::string grid =
      "<Topology TopologyType=\"2DCoRectMesh\" Dimensions=\"3 4\"/>"
      "<Geometry GeometryType=\"ORIGIN_DXDY\">" +
      xdmf_item("2", "1 2") + xdmf_item("2", "0.5 0.25") + "</Geometry>" +
      xdmf_attribute("f", kTwelve);
  const Dataset dataset = read_xdmf_text(xdmf_file(xdmf_grid(grid)));
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 1}));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(0.25, 0.5, 0.25));
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(2, 1, 0));
}

TEST(Xdmf, RectilinearGridsAreLatticesOrMeshes) {
  const auto grid = [](const std::string& z) {
    return xdmf_file(
        xdmf_grid("<Topology Type=\"3DRectMesh\" NumberOfElements=\"3 2 2\"/>"
                  "<Geometry Type=\"VXVYVZ\">" +
                  xdmf_item("2", "0 1") + xdmf_item("2", "5 7") + xdmf_item("3", z) +
                  "</Geometry>" + xdmf_attribute("f", kTwelve)));
  };
  const Dataset even = read_xdmf_text(grid("1 4 7"));
  EXPECT_EQ(even.kind, DatasetKind::kLattice);
  EXPECT_EQ(even.lattice.dims, (Index3{2, 2, 3}));
  EXPECT_EQ(even.lattice.world_from_index.linear().diagonal(), Vec3(1, 2, 3));
  EXPECT_EQ(even.lattice.world_from_index.translation(), Vec3(0, 5, 1));
  const Dataset uneven = read_xdmf_text(grid("1 4 8"));
  EXPECT_EQ(uneven.kind, DatasetKind::kMesh);
  EXPECT_EQ(uneven.cells.dims, (Index3{2, 2, 3}));
  const std::vector<double> places = values_of<double>(uneven.positions);
  EXPECT_EQ(std::vector<double>(places.end() - 6, places.end()),
            (std::vector<double>{0, 7, 8, 1, 7, 8}));
  EXPECT_THAT(error_of([&] { read_xdmf_text(grid("1 4 7 9")); }), HasSubstr("Dimensions"));
}

TEST(Xdmf, CurvedGridsAreMeshes) {
  const std::string topology =
      "<Topology TopologyType=\"3DSMesh\" Dimensions=\"2 2 2\"/><Geometry GeometryType=\"X_Y_Z\">";
  const std::string grid = topology + xdmf_item("8", "0 1 0 1 0 1 0 2") +
                           xdmf_item("8", "0 0 1 1 0 0 1 2") + xdmf_item("8", "0 0 0 0 1 1 1 2") +
                           "</Geometry>" + xdmf_attribute("f", xdmf_item("8", xdmf_counting(8)));
  const Dataset mesh = read_xdmf_text(xdmf_file(xdmf_grid(grid)));
  EXPECT_EQ(mesh.cells.dims, (Index3{2, 2, 2}));
  const std::vector<float> places = values_of<float>(mesh.positions);
  EXPECT_EQ(std::vector<float>(places.end() - 6, places.end()),
            (std::vector<float>{0, 1, 1, 2, 2, 2}));
  EXPECT_THAT(xdmf_error(xdmf_grid(with(grid, "2 2 2", "2 2 3"))),
              HasSubstr("has 8 points, Dimensions 3x2x2 need another number"));
}

TEST(Xdmf, CellsOfAllKinds) {
  struct Kind {
    const char* name;
    int num_nodes;
    CellType type;
  };
  const Kind kinds[] = {{"Triangle", 3, CellType::kTriangle},
                        {"Quadrilateral", 4, CellType::kQuad},
                        {"Tetrahedron", 4, CellType::kTetrahedron},
                        {"Pyramid", 5, CellType::kPyramid},
                        {"Wedge", 6, CellType::kWedge},
                        {"Hexahedron", 8, CellType::kHexahedron},
                        {"Tetrahedron_10", 10, CellType::kQuadraticTetrahedron},
                        {"Tet_10", 10, CellType::kQuadraticTetrahedron},
                        {"Pyramid_13", 13, CellType::kQuadraticPyramid},
                        {"Wedge_15", 15, CellType::kQuadraticWedge},
                        {"Hexahedron_20", 20, CellType::kQuadraticHexahedron},
                        {"Hexahedron_27", 27, CellType::kTriQuadraticHexahedron},
                        {"Quadrilateral_8", 8, CellType::kOther}};
  std::string nodes;
  for (int i = 0; i < 27; ++i) nodes += std::to_string(i) + " 0 0 ";
  const std::string geometry = "<Geometry GeometryType=\"XYZ\">" + xdmf_item("27 3", nodes) +
                               "</Geometry>" +
                               xdmf_attribute("u", xdmf_item("27", xdmf_counting(27)));
  for (const Kind& kind : kinds) {
    const std::string count = std::to_string(kind.num_nodes);
    const std::string topology = std::string("<Topology BaseOffset=\"1\" TopologyType=\"") +
                                 kind.name + "\" NumberOfElements=\"1\">" +
                                 xdmf_item("1 " + count, xdmf_counting(kind.num_nodes),
                                           "NumberType=\"UInt\" Precision=\"8\"") +
                                 "</Topology>";
    const Dataset mesh = read_xdmf_text(xdmf_file(xdmf_grid(topology + geometry)));
    SCOPED_TRACE(kind.name);
    ASSERT_EQ(mesh.cells.types.size(), 1U);
    EXPECT_EQ(mesh.cells.types[0], kind.type);
    EXPECT_EQ(mesh.cells.connectivity.size(), static_cast<std::size_t>(kind.num_nodes));
    EXPECT_EQ(mesh.cells.connectivity.front(), 0U);
    EXPECT_THAT(
        xdmf_error(xdmf_grid(with(topology, "BaseOffset=\"1\"", "BaseOffset=\"2\"") + geometry)),
        HasSubstr("cell 0 has node 1: the grid has 27 of them, from 2"));
    EXPECT_THAT(
        xdmf_error(xdmf_grid(with(topology, "Elements=\"1\"", "Elements=\"2\"") + geometry)),
        HasSubstr("holds 1 cells, 2 are stated"));
  }
}

TEST(Xdmf, MixedCells) {
  const std::string values = xdmf_attribute("u", xdmf_item("9", xdmf_counting(9)));
  const std::string cells = xdmf_attribute("c", xdmf_item("2", "10 20"), "Center=\"Cell\"");
  const Dataset mesh = read_xdmf_text(xdmf_file(xdmf_grid(kXdmfMixed + values + cells)));
  expect_the_mixed_cells(mesh);
  EXPECT_TRUE(mesh.array("c").is_cell_data);
  EXPECT_EQ(values_of<float>(mesh.array("c")), (std::vector<float>{10, 20}));
  // A polygon of three, a line, and the tetrahedron once more as a polyhedron.
  const std::string more =
      "<Topology TopologyType=\"Mixed\" NumberOfElements=\"3\">" +
      xdmf_item("27", "3 3 0 1 2  2 2 3 4  16 4 3 1 8 2 3 1 8 5 3 8 2 5 3 1 2 5",
                "NumberType=\"Int\"") +
      "</Topology>" + kXdmfNodes;
  const Dataset other = read_xdmf_text(xdmf_file(xdmf_grid(more + values)));
  EXPECT_EQ(other.cells.types,
            (std::vector{CellType::kTriangle, CellType::kLine, CellType::kOther}));
  EXPECT_EQ(other.cells.connectivity, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 1, 2, 5, 8}));
  EXPECT_THAT(xdmf_error(xdmf_grid(with(kXdmfMixed, ">9 0 1", ">77 0 1") + values)),
              HasSubstr("cell 0 is of kind 77, which is not known"));
  EXPECT_THAT(xdmf_error(xdmf_grid(with(kXdmfMixed, "6 1 8 2 5", "7 1 8 2 5") + values)),
              HasSubstr("ends within cell 1"));
  EXPECT_THAT(xdmf_error(xdmf_grid(with(kXdmfMixed, "1 8 2 5", "1 9 2 5") + values)),
              HasSubstr("cell 1 has node 9: the grid has 9 of them"));
}

TEST(Xdmf, PointsAreParticles) {
  const std::string values = xdmf_attribute("m", xdmf_item("9", xdmf_counting(9)));
  const std::string vertices =
      "<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"9\" NodesPerElement=\"1\">" +
      xdmf_item("9", "0 1 2 3 4 5 6 7 8", "NumberType=\"Int\"") + "</Topology>";
  for (const std::string& topology :
       {std::string(), std::string("<Topology TopologyType=\"Polyvertex\"/>"), vertices}) {
    const Dataset points = read_xdmf_text(xdmf_file(xdmf_grid(topology + kXdmfNodes + values)));
    EXPECT_EQ(points.kind, DatasetKind::kParticles) << topology;
    EXPECT_EQ(points.num_positions(), 9);
    EXPECT_EQ(values_of<float>(points.array("m")), counting<float>(9));
    ReadOptions one;
    one.array = "m";
    const std::string radii = xdmf_attribute("h", xdmf_item("9", xdmf_counting(9)));
    const auto both = xdmf_file(xdmf_grid(topology + kXdmfNodes + values + radii));
    EXPECT_EQ(read_xdmf_text(both, one).arrays.size(), 2U) << topology;  // the radii, too
    expect_shares([&](const ReadOptions& options) {
      return read_xdmf_text(xdmf_file(xdmf_grid(topology + kXdmfNodes + values)), options);
    });
  }
  const std::string plane = "<Geometry GeometryType=\"XY\">" +
                            xdmf_item("2 2", "1 2 3 4", "Precision=\"8\"") + "</Geometry>";
  EXPECT_EQ(values_of<double>(read_xdmf_text(xdmf_file(xdmf_grid(plane))).positions),
            (std::vector<double>{1, 2, 0, 3, 4, 0}));
}

TEST(Xdmf, RawFiles) {
  MemoryFiles files;
  files.files["b.bin"] = "ab" + std::string("\0\1\0\2\0\3\1\0", 8);
  const auto grid = [](const std::string& item) {
    return xdmf_grid(
        "<Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"1 2 2\"/>"
        "<Geometry GeometryType=\"ORIGIN_DXDYDZ\">" +
        xdmf_item("3", "0 0 0") + xdmf_item("3", "1 1 1") + "</Geometry>" +
        xdmf_attribute("f", item));
  };
  const std::string item = xdmf_item("2 2", " b.bin\n",
                                     "Format=\"Binary\" Seek=\"2\" Endian=\"Big\" "
                                     "NumberType=\"Int\" Precision=\"2\"");
  const Dataset dataset = read_xdmf_text(xdmf_file(grid(item)), {}, files);
  EXPECT_EQ(values_of<std::int16_t>(dataset.array()), (std::vector<std::int16_t>{1, 2, 3, 256}));
  EXPECT_EQ(values_of<std::int16_t>(
                read_xdmf_text(xdmf_file(grid(with(item, "Big", "Little"))), {}, files).array()),
            (std::vector<std::int16_t>{256, 512, 768, 1}));
  EXPECT_THAT(xdmf_error(grid(with(item, "Seek=\"2\"", "Seek=\"3\"")), files),
              HasSubstr("needs 8 bytes from 3 on: b.bin has 10"));
  EXPECT_THAT(xdmf_error(grid(with(item, "Seek=\"2\"", "Seek=\"-1\"")), files),
              HasSubstr("needs 8 bytes from -1 on"));
  EXPECT_THAT(xdmf_error(grid(with(item, "Seek=\"2\"", "Compression=\"Zlib\"")), files),
              HasSubstr("is compressed by 'zlib', which is not read"));
  EXPECT_THAT(xdmf_error(grid(with(item, "b.bin", "c.bin")), files),
              HasSubstr("c.bin: no such file"));
}

TEST(Xdmf, Hyperslabs) {
  const std::string grid =
      "<Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"2 3 2\"/>"
      "<Geometry GeometryType=\"ORIGIN_DXDYDZ\">" +
      xdmf_item("3", "0 0 0") + xdmf_item("3", "1 1 1") + "</Geometry>";
  const std::vector<float> wanted{5, 7, 9, 11, 13, 15, 21, 23, 25, 27, 29, 31};
  const auto read = [&](const std::string& item, const MemoryFiles& files = {}) {
    return values_of<float>(
        read_xdmf_text(xdmf_file(xdmf_grid(grid + xdmf_attribute("f", item))), {}, files).array());
  };
  EXPECT_EQ(read(xdmf_slab()), wanted);
  MemoryFiles files;
  files.files["b.bin"] = bytes_of(counting<float>(32));
  const std::string raw = with(with(xdmf_slab(), xdmf_counting(32), "b.bin"), "\"2 4 4\"",
                               "\"2 4 4\" Format=\"Binary\"");
  EXPECT_EQ(read(raw, files), wanted);
  // The second volume alone, read from where it begins.
  const std::string second =
      with(with(raw, "0 1 0  1 1 2  2 3 2", "1 0 0  1 1 1  1 4 3"), "\"2 3 2\"", "\"1 4 3\"");
  EXPECT_EQ(read(second, files),
            (std::vector<float>{17, 18, 19, 21, 22, 23, 25, 26, 27, 29, 30, 31}));
  const auto error = [&](const std::string& item) {
    return xdmf_error(xdmf_grid(grid + xdmf_attribute("f", item)));
  };
  EXPECT_THAT(error(with(xdmf_slab(), "2 3 2\"", "2 3 3\"")),
              HasSubstr("has Dimensions 2 3 3: 12 numbers are taken"));
  EXPECT_THAT(error(with(xdmf_slab(), "0 1 0", "0 2 0")),
              HasSubstr("takes 3 from 2 by 1 of axis 1, which has 4"));
  EXPECT_THAT(error(with(xdmf_slab(), "  1 1 2", "  1 0 2")), HasSubstr("takes 3 from 1 by 0"));
  EXPECT_THAT(error(with(xdmf_slab(), "3 3\"", "3 2\"")), HasSubstr("more numbers than the 6"));
}

TEST(Xdmf, JoinedArraysAreComponents) {
  const std::string type = "AttributeType=\"Vector\" Center=\"Node\"";
  const Dataset dataset =
      read_xdmf_text(xdmf_file(xdmf_grid(kXdmfEven + xdmf_attribute("v", xdmf_join(), type))));
  EXPECT_EQ(dataset.array().num_components, 3);
  const std::vector<float> values = values_of<float>(dataset.array());
  EXPECT_EQ(std::vector<float>(values.begin(), values.begin() + 5),
            (std::vector<float>{1, 1, 1, 2, 2}));
  EXPECT_EQ(values.back(), 24);
  EXPECT_THAT(
      xdmf_error(xdmf_grid(
          kXdmfEven + xdmf_attribute("v", with(xdmf_join(), "\"24\" >1 2", "\"23\" >2"), type))),
      HasSubstr("joins 24 numbers of float32 and 23 of float32"));
}

TEST(Xdmf, CollectionsInTimeAreSteps) {
  ReadOptions options;
  options.step = 1;
  Dataset dataset = read_xdmf_text(xdmf_file(xdmf_series()), options);
  expect_the_mixed_cells(dataset);
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_EQ(dataset.step, 1);
  EXPECT_THAT(dataset.times, ElementsAre(0.5, 1.5));
  EXPECT_EQ(values_of<float>(dataset.array("u"))[0], 9);
  const std::string grids = xdmf_grid(kXdmfEven + kEvenValues) + xdmf_grid(kXdmfEven + kEvenValues);
  const std::string collection = "GridType=\"Collection\" CollectionType=\"Temporal\"";
  for (const auto& [type, item] :
       {std::pair{"List", xdmf_item("2", "3 4")}, {"HyperSlab", xdmf_item("3", "3 1 2")}}) {
    const std::string time = std::string("<Time TimeType=\"") + type + "\">" + item + "</Time>";
    dataset = read_xdmf_text(xdmf_file(xdmf_grid(time + grids, collection)));
    EXPECT_THAT(dataset.times, ElementsAre(3, 4)) << type;
  }
  dataset = read_xdmf_text(xdmf_file(xdmf_grid(grids, collection)));
  EXPECT_THAT(dataset.times, IsEmpty());
  EXPECT_THAT(
      xdmf_error(xdmf_grid("<Time TimeType=\"List\">" + xdmf_item("3", "3 4 5") + "</Time>" + grids,
                           collection)),
      HasSubstr("has 3 times: the collection has 2 grids"));
  options.step = 2;
  EXPECT_THAT(error_of([&] { read_xdmf_text(xdmf_file(xdmf_series()), options); }),
              HasSubstr("step 2"));
  const TestFolder folder;
  const auto steps = open_steps({folder.write("a.xdmf", xdmf_file(xdmf_series()))});
  EXPECT_THAT(steps->times(), ElementsAre(0.5, 1.5));
  EXPECT_EQ(values_of<float>(steps->read(1).array("u"))[0], 9);
}

TEST(Xdmf, References) {
  const std::string item = xdmf_item("2 3 4", xdmf_counting(24), "Name=\"kept\"");
  for (const char* const reference :
       {"<DataItem Reference=\"XML\"> /Xdmf/Domain/DataItem[@Name='kept'] </DataItem>",
        "<DataItem Reference=\"XML\">//DataItem[1]</DataItem>",
        "<DataItem Reference=\"/Xdmf/Domain/DataItem[1]\"/>"}) {
    const Dataset dataset =
        read_xdmf_text(xdmf_file(item + xdmf_grid(kXdmfEven + xdmf_attribute("f", reference))));
    EXPECT_EQ(values_of<float>(dataset.array()), counting<float>(24)) << reference;
  }
  const auto error = [&](const std::string& reference) {
    return xdmf_error(item + xdmf_grid(kXdmfEven + xdmf_attribute("f", reference)));
  };
  EXPECT_THAT(error("<DataItem Reference=\"XML\">/Xdmf/Domain/DataItem[2]</DataItem>"),
              HasSubstr("refers to '/Xdmf/Domain/DataItem[2]': there is no such DataItem"));
  EXPECT_THAT(error("<DataItem Reference=\"XML\">/Xdmf/Domain/Grid</DataItem>"),
              HasSubstr("there is no such DataItem"));
  EXPECT_THAT(error("<DataItem Reference=\"XML\">/Xdmf/Domain/Grid/Attribute/DataItem</DataItem>"),
              HasSubstr("refers to itself"));
  EXPECT_THAT(error("<DataItem Reference=\"XML\">/Xdmf/Domain/DataItem[last()]</DataItem>"), "");
  EXPECT_THAT(error("<DataItem Reference=\"XML\">/Xdmf/Domain[</DataItem>"),
              HasSubstr("the path '/Xdmf/Domain[' is not read"));
}

TEST(Xdmf, OneOfSeveralGrids) {
  const std::string mesh = xdmf_grid(kXdmfMixed, "Name=\"mesh\"");
  const std::string file = xdmf_file(mesh + xdmf_series() + xdmf_grid(kXdmfEven + kEvenValues));
  const Dataset dataset = read_xdmf_text(file);
  EXPECT_EQ(dataset.block, "series");
  ASSERT_EQ(dataset.blocks.size(), 3U);
  EXPECT_EQ(dataset.blocks[2].name, "grid 3");
  EXPECT_THAT(dataset.notes[0], HasSubstr("holds 3 grids, 'series' is read; choose with --block"));
  ReadOptions options;
  options.block = "grid 3";
  EXPECT_EQ(read_xdmf_text(file, options).kind, DatasetKind::kLattice);
  options.block = "a";
  EXPECT_THAT(error_of([&] { read_xdmf_text(file, options); }),
              HasSubstr("block 'a': no such grid: expected one of 'mesh' 'series' 'grid 3'"));
}

TEST(Xdmf, SpatialCollectionsOfMeshesArePieces) {
  const std::string values = xdmf_attribute("u", xdmf_item("9", xdmf_counting(9)));
  const std::string shifted = with(kXdmfMixed, "2 0 0<", "-1 0 0<");
  const std::string domain = xdmf_grid(
      xdmf_grid(kXdmfMixed + values, "Name=\"a\"") + xdmf_grid(shifted + values, "Name=\"b\""),
      "GridType=\"Collection\" CollectionType=\"Spatial\"");
  const Dataset mesh = read_xdmf_text(xdmf_file(domain));
  EXPECT_EQ(mesh.num_positions(), 10);
  EXPECT_EQ(mesh.cells.types.size(), 4U);
  ASSERT_EQ(mesh.blocks.size(), 2U);
  EXPECT_EQ(mesh.blocks[1].name, "b");
}

TEST(Xdmf, WhatIsNotReadIsRefusedInWords) {
  const auto error = [](const std::string& attribute) {
    return xdmf_error(xdmf_grid(kXdmfEven + attribute));
  };
  EXPECT_EQ(error(kEvenValues), "");
  EXPECT_THAT(error(with(kEvenValues, "Precision=\"8\"", "Precision=\"3\"")),
              HasSubstr("has NumberType 'float' of Precision '3': expected Float of 4 or 8"));
  EXPECT_THAT(error(with(kEvenValues, "Precision=\"8\"", "Format=\"TIFF\"")),
              HasSubstr("has Format 'tiff', which is not read"));
  EXPECT_THAT(error("<xi:include href=\"b.xmf\"/>"), HasSubstr("b.xmf: no such file"));
  EXPECT_THAT(xdmf_error(xdmf_grid("", "GridType=\"Subset\"")),
              HasSubstr("is of GridType 'subset', which is not read"));
  EXPECT_THAT(xdmf_error(xdmf_grid("<Topology TopologyType=\"Hexahedron_64\"/>" + kXdmfNodes)),
              HasSubstr("is of TopologyType 'hexahedron_64', which is not known"));
  EXPECT_THAT(error(with(kEvenValues, "Node\"", "Node\" AttributeType=\"Vector\"")),
              HasSubstr("has 24 numbers: expected vector of 24 nodes"));
  EXPECT_THAT(error(with(kEvenValues, "\"f\"", "\"&a;\"")),
              HasSubstr("the entity '&a;' is not declared"));
  EXPECT_THAT(error(xdmf_attribute("f",
                                   "<DataItem Name=\"a\" ItemType=\"HyperSlab\"><DataItem "
                                   "Reference=\"//DataItem[@Name='a']\"/><DataItem/></DataItem>")),
              HasSubstr("is made of items that are made of items"));
  // Sums of arrays, and others' arrays, do not keep one from reading.
  const std::string sum =
      xdmf_attribute("s", "<DataItem ItemType=\"Function\" Function=\"$0 + 1\"/>");
  EXPECT_THAT(
      read_xdmf_text(xdmf_file(xdmf_grid(kXdmfEven + sum + kEvenValues))).notes,
      testing::Contains(HasSubstr("array 's' is left out: it is a function of others, which "
                                  "is not read")));
  const std::string whole = xdmf_attribute("w", xdmf_item("1", "1"), "Center=\"Grid\"");
  const std::string file = xdmf_file(xdmf_grid(kXdmfEven + whole + kEvenValues));
  EXPECT_THAT(read_xdmf_text(file).notes,
              testing::Contains(HasSubstr("array 'w' is left out: it belongs to Center 'grid'")));
  ReadOptions options;
  options.array = "w";
  EXPECT_THAT(error_of([&] { read_xdmf_text(file, options); }),
              HasSubstr("belongs to Center 'grid', which is not read"));
}

TEST(Xdmf, DamageIsTold) {
  const std::string file = xdmf_file(xdmf_grid(kXdmfEven + kEvenValues));
  for (std::size_t size = 0; size + 1 < file.size(); ++size)
    EXPECT_NE(error_of([&] { read_xdmf_text(file.substr(0, size)); }), "") << size;
  const auto error = [](const std::string& attribute) {
    return xdmf_error(xdmf_grid(kXdmfEven + attribute));
  };
  EXPECT_THAT(error(with(kEvenValues, " 22", " x")),
              HasSubstr("number 21 is 'x': expected one of"));
  EXPECT_THAT(error(with(kEvenValues, "22 ", "")), HasSubstr("has 23 numbers of 24"));
  EXPECT_THAT(error(with(kEvenValues, "22 ", "22 22 ")),
              HasSubstr("has more numbers than the 24 of its Dimensions"));
  EXPECT_THAT(error(with(kEvenValues, "2 3 4", "200000 30000 40000")),
              HasSubstr("bytes of text, too few for 240000000000000 numbers"));
  EXPECT_THAT(error(with(kEvenValues, "2 3 4", "2 -3 4")), HasSubstr("has Dimensions '2 -3 4'"));
  EXPECT_THAT(error(with(kEvenValues, "2 3 4", "9999999999 9999999999 4")),
              HasSubstr("expected whole numbers from 1"));
  EXPECT_THAT(xdmf_error(xdmf_grid(kXdmfEven)), HasSubstr("has no array of numbers"));
  EXPECT_THAT(xdmf_error(""), HasSubstr("has no Grid"));
  EXPECT_THAT(error_of([&] { read_xdmf_text(with(file, "</Grid>", "</Topology>")); }),
              HasSubstr("is no XML from byte"));
  EXPECT_THAT(error_of([&] { read_xdmf_text("<Xdmf></Xdmf><Xdmf/>"); }),
              HasSubstr("has several roots"));
  std::string deep = "<Xdmf>";
  for (int i = 0; i < 100; ++i) deep += "<Grid>";
  for (int i = 0; i < 100; ++i) deep += "</Grid>";
  deep += "</Xdmf>";
  EXPECT_THAT(error_of([&] { read_xdmf_text(deep); }), HasSubstr("64 within each other"));
  // Comments, and numbers of other programs.
  EXPECT_EQ(error(with(kEvenValues, " 22", " <!-- a - b --> 2.2e1")), "");
  EXPECT_EQ(error(with(kEvenValues, " 22", " nan")), "");
}

// The same data from the formats that VTK reads.
TEST(Xdmf, IsWhatVtiAndVtuHold) {
  if (!has_library("VTK")) GTEST_SKIP() << "this build has no VTK";
  const TestFolder folder;
  const std::string values = xdmf_attribute("u", xdmf_item("9", xdmf_counting(9)));
  const Dataset lattice = read_xdmf_text(xdmf_file(xdmf_grid(kXdmfEven + kEvenValues)));
  write_dataset(lattice, folder.file("a.vti"));
  const Dataset vti = read_dataset({folder.file("a.vti")});
  EXPECT_EQ(vti.lattice.dims, lattice.lattice.dims);
  EXPECT_EQ(vti.lattice.world_from_index.matrix(), lattice.lattice.world_from_index.matrix());
  EXPECT_EQ(values_of<double>(vti.array("f")), values_of<double>(lattice.array("f")));
  const Dataset mesh = read_xdmf_text(xdmf_file(xdmf_grid(kXdmfMixed + values)));
  write_dataset(mesh, folder.file("a.vtu"));
  const Dataset vtu = read_dataset({folder.file("a.vtu")});
  expect_the_mixed_cells(vtu);
  EXPECT_EQ(values_of<float>(vtu.positions), values_of<float>(mesh.positions));
  EXPECT_EQ(values_of<float>(vtu.array("u")), values_of<float>(mesh.array("u")));
}

}  // namespace xdmf_test
}  // namespace ovoid::io
