// SPDX-License-Identifier: Apache-2.0
// Grids of XDMF that are parts of one thing. What would make it fail: a piece at another's place,
// one that is lost, values of two pieces that change places.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io/images/test_volumes.h"
#include "io/read_source.h"
#include "io/xdmf/test_xdmf.h"

namespace ovoid::io {
namespace xdmf_pieces_test {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

Dataset read_grids(const std::string& content, const ReadOptions& options = {},
                   const std::string& type = "CollectionType=\"Spatial\"") {
  const std::string file = xdmf_file(xdmf_grid(content, "GridType=\"Collection\" " + type));
  return read_source(*open_memory("a.xmf", std::as_bytes(std::span(file))), options, open_file);
}

// Of `dims` samples, written z, y, x, from `origin` on; `values` are those of `center`.
std::string even(const std::string& name, const std::string& dims, const std::string& origin,
                 const std::string& spacing, const std::string& values, const std::string& center) {
  return xdmf_grid("<Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"" + dims +
                       "\"/><Geometry GeometryType=\"ORIGIN_DXDYDZ\">" +
                       xdmf_item("3", origin, "Precision=\"8\"") +
                       xdmf_item("3", spacing, "Precision=\"8\"") + "</Geometry>" +
                       xdmf_attribute("f", values, "Center=\"" + center + "\""),
                   "Name=\"" + name + "\"");
}

TEST(XdmfPieces, CellsThatTileAreALattice) {
  // Two blocks of 2 x 1 x 1 cells, the second first.
  const Dataset dataset =
      read_grids(even("b", "2 2 3", "0 0 1", "1 1 0.5", xdmf_item("1 1 2", "3 4"), "Cell") +
                 even("a", "2 2 3", "0 0 0", "1 1 0.5", xdmf_item("1 1 2", "1 2"), "Cell"));
  ASSERT_EQ(dataset.kind, DatasetKind::kLattice);
  EXPECT_EQ(dataset.lattice.dims, (Index3{5, 2, 2}));
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(0, 0, 0));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(0.5, 1, 1));
  EXPECT_TRUE(dataset.array().is_cell_data);
  EXPECT_EQ(values_of<float>(dataset.array()), (std::vector<float>{1, 2, 3, 4}));
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("2 lattices are put together to one")));
  ASSERT_EQ(dataset.blocks.size(), 2U);
  EXPECT_EQ(dataset.blocks[0].name, "b");
}

TEST(XdmfPieces, NodesThatMeetAreALattice) {
  // Blocks that share a layer of nodes, and blocks that do not.
  const auto first = even("a", "1 2 3", "0 0 0", "1 1 1", xdmf_item("6", "1 2 3 11 12 13"), "Node");
  const Dataset shared =
      read_grids(first + even("b", "1 2 2", "0 0 2", "1 1 1", xdmf_item("4", "3 4 13 14"), "Node"));
  ASSERT_EQ(shared.kind, DatasetKind::kLattice);
  EXPECT_EQ(shared.lattice.dims, (Index3{4, 2, 1}));
  EXPECT_EQ(values_of<float>(shared.array()), (std::vector<float>{1, 2, 3, 4, 11, 12, 13, 14}));
  const Dataset apart =
      read_grids(first + even("b", "1 2 1", "0 0 3", "1 1 1", xdmf_item("2", "4 14"), "Node"));
  ASSERT_EQ(apart.kind, DatasetKind::kLattice);
  EXPECT_EQ(values_of<float>(apart.array()), values_of<float>(shared.array()));
  // Spacings that fall are a lattice as well.
  const Dataset falling =
      read_grids(even("a", "1 2 3", "0 0 3", "1 1 -1", xdmf_item("6", "1 2 3 11 12 13"), "Node") +
                 even("b", "1 2 1", "0 0 0", "1 1 -1", xdmf_item("2", "4 14"), "Node"));
  ASSERT_EQ(falling.kind, DatasetKind::kLattice);
  EXPECT_EQ(values_of<float>(falling.array()), values_of<float>(shared.array()));
  EXPECT_EQ(falling.lattice.world_from_index.translation(), Vec3(3, 0, 0));
}

TEST(XdmfPieces, OneIsReadByItsName) {
  ReadOptions options;
  options.block = "b";
  const Dataset dataset =
      read_grids(even("a", "1 1 2", "0 0 0", "1 1 1", xdmf_item("2", "1 2"), "Node") +
                     even("b", "1 1 2", "0 0 1", "1 1 1", xdmf_item("2", "2 3"), "Node"),
                 options);
  EXPECT_EQ(dataset.block, "b");
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(1, 0, 0));
  EXPECT_EQ(values_of<float>(dataset.array()), (std::vector<float>{2, 3}));
}

TEST(XdmfPieces, CellsWithGapsAreBoxes) {
  const Dataset dataset =
      read_grids(even("a", "2 2 3", "0 0 0", "1 1 1", xdmf_item("2", "1 2"), "Cell") +
                 even("b", "2 2 2", "0 0 5", "1 1 1", xdmf_item("1", "3"), "Cell"));
  ASSERT_EQ(dataset.kind, DatasetKind::kBoxes);
  EXPECT_EQ(values_of<double>(dataset.positions),
            (std::vector<double>{0.5, 0.5, 0.5, 1.5, 0.5, 0.5, 5.5, 0.5, 0.5}));
  EXPECT_EQ(values_of<float>(dataset.array()), (std::vector<float>{1, 2, 3}));
}

TEST(XdmfPieces, FinerCellsCoverCoarserOnes) {
  // Four cells, of which the second is covered by two halves along x, in a Tree.
  const Dataset dataset =
      read_grids(even("fine", "2 2 3", "0 0 1", "1 1 0.5", xdmf_item("2", "20 21"), "Cell") +
                     even("coarse", "2 2 5", "0 0 0", "1 1 1", xdmf_item("4", "1 2 3 4"), "Cell"),
                 {}, "");
  ASSERT_EQ(dataset.kind, DatasetKind::kBoxes);
  EXPECT_EQ(values_of<float>(dataset.array()), (std::vector<float>{20, 21, 1, 3, 4}));
  EXPECT_EQ(values_of<double>(dataset.box_sizes)[0], 0.5);
  EXPECT_EQ(values_of<double>(dataset.positions)[0], 1.25);
  // The same for nodes: means of each cell's corners, with a word.
  const Dataset nodes =
      read_grids(even("fine", "1 1 3", "0 0 1", "1 1 0.5", xdmf_item("3", "10 20 30"), "Node") +
                 even("coarse", "1 1 4", "0 0 0", "1 1 1", xdmf_item("4", "1 3 5 7"), "Node"));
  ASSERT_EQ(nodes.kind, DatasetKind::kBoxes);
  EXPECT_EQ(values_of<float>(nodes.array()), (std::vector<float>{15, 25, 2, 6}));
  EXPECT_THAT(nodes.notes, Contains(HasSubstr("by the mean of each cell's corners")));
}

// Layers of cells that two processes both have are drawn once.
TEST(XdmfPieces, CellsThatAreThereTwiceCountOnce) {
  const Dataset dataset =
      read_grids(even("a", "2 2 3", "0 0 0", "1 1 1", xdmf_item("2", "1 2"), "Cell") +
                 even("b", "2 2 3", "0 0 1", "1 1 1", xdmf_item("2", "2 3"), "Cell") +
                 even("c", "2 2 2", "0 0 9", "1 1 1", xdmf_item("1", "9"), "Cell"));
  ASSERT_EQ(dataset.kind, DatasetKind::kBoxes);
  EXPECT_EQ(values_of<float>(dataset.array()), (std::vector<float>{1, 2, 3, 9}));
}

TEST(XdmfPieces, NodesWithGapsAreAMesh) {
  const Dataset dataset = read_grids(
      even("a", "2 2 2", "0 0 0.1", "0.1 0.1 0.1", xdmf_item("8", "1 2 3 4 5 6 7 8"), "Node") +
      even("b", "2 2 2", "0 0 0.2", "0.1 0.1 0.1", xdmf_item("8", "2 1 4 3 6 5 8 7"), "Node") +
      even("c", "2 2 2", "0 0 0.7", "0.1 0.1 0.1", xdmf_item("8", "1 2 3 4 5 6 7 8"), "Node"));
  ASSERT_EQ(dataset.kind, DatasetKind::kMesh);
  EXPECT_EQ(dataset.num_positions(), 20);  // four are common, though 0.1 + 0.1 is rounded
  EXPECT_EQ(dataset.cells.count(), 3);
  EXPECT_EQ(dataset.blocks.size(), 3U);
}

TEST(XdmfPieces, EvenAndUnevenGridsAreAMesh) {
  const std::string uneven = xdmf_grid(
      "<Topology TopologyType=\"3DRectMesh\" Dimensions=\"2 2 3\"/><Geometry "
      "GeometryType=\"VXVYVZ\">" +
          xdmf_item("3", "1 2 4") + xdmf_item("2", "0 1") + xdmf_item("2", "0 1") + "</Geometry>" +
          xdmf_attribute("f", xdmf_item("12", xdmf_counting(12))),
      "Name=\"b\"");
  const Dataset dataset = read_grids(
      even("a", "2 2 2", "0 0 0", "1 1 1", xdmf_item("8", "1 2 3 4 5 6 7 8"), "Node") + uneven);
  ASSERT_EQ(dataset.kind, DatasetKind::kMesh);
  EXPECT_EQ(dataset.num_positions(), 16);
  EXPECT_EQ(values_of<double>(dataset.positions)[27], 4);  // x of the last node of a row
}

TEST(XdmfPieces, CollectionsInTimeHoldCollectionsInSpace) {
  const auto step = [](const std::string& time, const std::string& a, const std::string& b) {
    return xdmf_grid("<Time Value=\"" + time + "\"/>" +
                         even("a", "1 1 2", "0 0 0", "1 1 1", xdmf_item("1", a), "Cell") +
                         even("b", "1 1 2", "0 0 1", "1 1 1", xdmf_item("1", b), "Cell"),
                     "GridType=\"Collection\" CollectionType=\"Spatial\"");
  };
  ReadOptions options;
  options.step = 1;
  const Dataset dataset = read_grids(step("0.5", "1", "2") + step("1.5", "3", "4"), options,
                                     "CollectionType=\"Temporal\"");
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_THAT(dataset.times, ElementsAre(0.5, 1.5));
  EXPECT_EQ(values_of<float>(dataset.array()), (std::vector<float>{3, 4}));
}

TEST(XdmfPieces, CollectionsInSpaceHoldCollectionsInTime) {
  const auto series = [](const std::string& name, const std::string& origin,
                         const std::vector<std::string>& values) {
    std::string steps;
    for (std::size_t i = 0; i < values.size(); ++i) {
      steps += with(even(name, "1 1 2", origin, "1 1 1", xdmf_item("1", values[i]), "Cell"),
                    "<Topology", "<Time Value=\"" + std::to_string(i) + "\"/><Topology");
    }
    return xdmf_grid(steps,
                     "Name=\"" + name + "\" GridType=\"Collection\" CollectionType=\"Temporal\"");
  };
  ReadOptions options;
  options.step = 1;
  const std::string first = series("a", "0 0 0", {"1", "2"});
  const Dataset dataset = read_grids(first + series("b", "0 0 1", {"3", "4"}), options);
  EXPECT_THAT(dataset.times, ElementsAre(0, 1));
  EXPECT_EQ(values_of<float>(dataset.array()), (std::vector<float>{2, 4}));
  EXPECT_THAT(error_of([&] { read_grids(first + series("b", "0 0 1", {"3"}), options); }),
              HasSubstr("holds 1 time steps: another collection has 2"));
}

}  // namespace xdmf_pieces_test
}  // namespace ovoid::io
