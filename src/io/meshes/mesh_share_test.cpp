// SPDX-License-Identifier: Apache-2.0
// Shares of the cells of a mesh: together they are the whole, node by node.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "data/cell_builder.h"
#include "io/core/row_share.h"
#include "io/images/test_volumes.h"
#include "io/meshes/mesh_blocks.h"

namespace ovoid::io {
namespace mesh_share_test {

constexpr std::uint32_t kNodes = 24;

// Tetrahedra along a row of nodes and one triangle; the last two nodes are of no cell.
Dataset row_of_cells() {
  Dataset mesh;
  mesh.source = "a.vtu";
  mesh.kind = DatasetKind::kMesh;
  mesh.positions = make_array("positions", ScalarType::kFloat32, counting<float>(3 * kNodes), 3);
  data::CellBuilder cells;
  for (std::uint32_t i = 0; i + 6 < kNodes; ++i)
    cells.add(CellType::kTetrahedron, std::array{i, i + 2, i + 1, i + 3});
  cells.add(CellType::kTriangle, std::array<std::uint32_t, 3>{0, 5, 21});
  mesh.cells = std::move(cells).finish();
  const auto num_cells = static_cast<std::size_t>(mesh.cells.count());
  mesh.arrays = {make_array("v", ScalarType::kFloat64, counting<double>(2 * kNodes), 2),
                 make_array("c", ScalarType::kInt16, counting<std::int16_t>(num_cells))};
  mesh.arrays[1].is_cell_data = true;
  return mesh;
}

Dataset grid(const Index3& dims) {
  Dataset mesh;
  mesh.source = "a.vts";
  mesh.kind = DatasetKind::kMesh;
  const auto num_nodes = static_cast<std::size_t>(dims[0] * dims[1] * dims[2]);
  mesh.positions = make_array("positions", ScalarType::kFloat32, counting<float>(3 * num_nodes), 3);
  mesh.cells.dims = dims;
  const auto num_cells = static_cast<std::size_t>(mesh.cells.count());
  mesh.arrays = {make_array("v", ScalarType::kFloat64, counting<double>(2 * num_nodes), 2),
                 make_array("c", ScalarType::kInt16, counting<std::int16_t>(num_cells))};
  mesh.arrays[1].is_cell_data = true;
  return mesh;
}

Dataset share_of_cells(const Dataset& whole, int number, int count) {
  Dataset share = whole;
  cut_to_share(share, RowShare{number, count});
  return share;
}

// Nodes are the whole's of their numbers, cells follow each other, and nothing is missing.
void expect_the_whole(const Dataset& whole, int count) {
  std::map<std::uint64_t, int> times;
  std::int64_t next = 0;
  MeshPart all;
  all.cells = whole.cells;
  all.positions = whole.positions;
  make_explicit(all);
  for (int p = 0; p < count; ++p) {
    const Dataset share = share_of_cells(whole, p, count);
    ASSERT_TRUE(share.share.has_value());
    EXPECT_EQ(share.share->first, next);
    EXPECT_EQ(share.share->total, whole.cells.count());
    ASSERT_EQ(share.share->nodes.size(), static_cast<std::size_t>(share.num_positions()));
    MeshPart part;
    part.cells = share.cells;
    part.positions = share.positions;
    part.arrays = share.arrays;
    if (share.num_positions() > 0) check_mesh("a share", part);
    make_explicit(part);
    const auto values = values_of<double>(share.array("v"));
    const auto places = values_of<float>(share.positions);
    for (std::size_t i = 0; i < share.share->nodes.size(); ++i) {
      const std::uint64_t number = share.share->nodes[i];
      ++times[number];
      EXPECT_EQ(places[3 * i], 1 + 3 * static_cast<float>(number));
      EXPECT_EQ(values[2 * i], 1 + 2 * static_cast<double>(number));
    }
    const auto cell_values = values_of<std::int16_t>(share.array("c"));
    for (std::int64_t c = 0; c < part.cells.count(); ++c, ++next) {
      const auto cell = static_cast<std::size_t>(next), own = static_cast<std::size_t>(c);
      EXPECT_EQ(cell_values[own], 1 + next);
      EXPECT_EQ(part.cells.types[own], all.cells.types[cell]);
      for (std::int64_t k = part.cells.offsets[own]; k < part.cells.offsets[own + 1]; ++k) {
        const auto node = part.cells.connectivity[static_cast<std::size_t>(k)];
        const auto whole_k = all.cells.offsets[cell] + k - part.cells.offsets[own];
        EXPECT_EQ(share.share->nodes[node],
                  all.cells.connectivity[static_cast<std::size_t>(whole_k)]);
      }
    }
  }
  EXPECT_EQ(next, whole.cells.count());
  EXPECT_EQ(std::ssize(times), whole.num_positions());
}

TEST(MeshShare, CellsComeTogether) {
  const Dataset whole = row_of_cells();
  for (const int count : {1, 2, 5, 40}) expect_the_whole(whole, count);
  // Those of no cell are in one share each.
  int num_seen = 0;
  for (int p = 0; p < 5; ++p) {
    const Dataset share = share_of_cells(whole, p, 5);
    for (const std::uint64_t node : share.share->nodes) num_seen += node + 2 >= kNodes ? 1 : 0;
  }
  EXPECT_EQ(num_seen, 2);
}

TEST(MeshShare, GridsAreCutInLayers) {
  for (const Index3& dims : {Index3{3, 4, 5}, Index3{4, 6, 1}, Index3{9, 1, 1}, Index3{1, 1, 1}}) {
    SCOPED_TRACE(testing::Message() << dims[0] << " x " << dims[1] << " x " << dims[2]);
    for (const int count : {1, 2, 3, 7}) expect_the_whole(grid(dims), count);
  }
  EXPECT_EQ(share_of_cells(grid({3, 4, 5}), 1, 2).cells.dims, (Index3{3, 4, 3}));
}

TEST(MeshShare, BoxesComeTogether) {
  Dataset boxes;
  boxes.kind = DatasetKind::kBoxes;
  boxes.positions = make_array("positions", ScalarType::kFloat64, counting<double>(30), 3);
  boxes.box_sizes = make_array("box_sizes", ScalarType::kFloat64, counting<double>(30), 3);
  boxes.arrays = {make_array("v", ScalarType::kFloat32, counting<float>(10))};
  const Dataset share = share_of_cells(boxes, 1, 3);
  EXPECT_EQ(share.share->first, 3);
  EXPECT_EQ(values_of<float>(share.arrays[0]), (std::vector<float>{4, 5, 6}));
  EXPECT_EQ(values_of<double>(share.box_sizes)[0], 10);
  EXPECT_EQ(share.box_sizes.num_tuples, 3);
}

MeshPart part_at(float x, const std::string& block) {
  MeshPart part;
  part.block = block;
  part.positions = make_array("", ScalarType::kFloat32,
                              std::vector<float>{x, 0, 0, x + 1, 0, 0, x, 1, 0, x, 0, 1}, 3);
  data::CellBuilder cells;
  cells.add(CellType::kTetrahedron, std::array<std::uint32_t, 4>{0, 1, 2, 3});
  cells.add(CellType::kTriangle, std::array<std::uint32_t, 3>{0, 1, 2});
  part.cells = std::move(cells).finish();
  part.arrays = {make_array("v", ScalarType::kFloat32, std::vector<float>{x, x, x, x})};
  return part;
}

struct Pieces {
  std::vector<MeshPart> parts;
  std::vector<std::size_t> read;  // which were asked for

  Dataset share(int number, int count, ReadOptions options = {}) {
    std::vector<PartOutline> outlines;
    for (const MeshPart& part : parts) outlines.push_back(outline_of(part));
    options.share = RowShare{number, count};
    Dataset named;
    named.source = "a.pvtu";
    return mesh_share_of_parts(
        named, outlines,
        [&](std::size_t p) {
          read.push_back(p);
          return parts[p];
        },
        options);
  }
};

TEST(MeshShare, PartsAreReadByOneEach) {
  Pieces pieces;
  for (int p = 0; p < 5; ++p) pieces.parts.push_back(part_at(static_cast<float>(p), ""));
  pieces.parts[4].arrays.push_back(
      make_array("w", ScalarType::kFloat32, std::vector<float>{1, 2, 3, 4}));
  const Dataset first = pieces.share(0, 2);
  EXPECT_EQ(pieces.read, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(first.share->first, 0);
  EXPECT_EQ(first.share->total, 10);
  EXPECT_EQ(first.cells.count(), 6);
  EXPECT_EQ(first.num_positions(), 10);  // the tips of two are corners of the next
  EXPECT_EQ(first.share->nodes[4], (std::uint64_t{1} << 32U) + 1);
  const Dataset second = pieces.share(1, 2);
  EXPECT_EQ(pieces.read, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(second.share->first, 6);
  EXPECT_EQ(second.arrays.size(), 1U);
  // The same is told of an array that one part alone has.
  EXPECT_EQ(first.notes, second.notes);
  ASSERT_EQ(first.notes.size(), 1U);
  EXPECT_NE(first.notes[0].find("array 'w' is left out"), std::string::npos);
  // More processes than parts.
  std::int64_t num_cells = 0;
  for (int p = 0; p < 8; ++p) {
    const Dataset share = pieces.share(p, 8);
    EXPECT_EQ(share.arrays.size(), 1U);
    EXPECT_EQ(share.share->total, 10);
    num_cells += share.cells.count();
  }
  EXPECT_EQ(num_cells, 10);
}

TEST(MeshShare, BlocksAreChosenByTheirOutlines) {
  Pieces pieces;
  pieces.parts = {part_at(0, "a"), part_at(5, "b"), part_at(9, "b")};
  ReadOptions options;
  options.block = "b";
  const Dataset share = pieces.share(1, 2, options);
  EXPECT_EQ(pieces.read, std::vector<std::size_t>{2});
  EXPECT_EQ(share.block, "b");
  EXPECT_EQ(share.blocks.size(), 2U);
  EXPECT_EQ(share.share->first, 2);
  options.block = "c";
  EXPECT_EQ(error_of([&] { pieces.share(0, 2, options); }),
            "invalid-argument: a.pvtu: block 'c': not there: expected one of 'a', 'b'");
}

TEST(MeshShare, PartsThatAreNotAsOutlined) {
  const MeshPart part = part_at(0, "");
  std::vector<PartOutline> outlines = {outline_of(part), outline_of(part)};
  ReadOptions options;
  options.share = RowShare{0, 2};
  Dataset named;
  named.source = "a.pvtu";
  const auto refusal = [&] {
    return error_of([&] {
      mesh_share_of_parts(
          named, outlines, [&](std::size_t) { return part; }, options);
    });
  };
  EXPECT_EQ(refusal(), "");
  outlines[0].num_nodes = 7;
  EXPECT_EQ(refusal(), "file-format: a.pvtu: has 4 points and 2 cells: its header says 7 and 2");
  outlines[0].num_nodes = 4;
  for (PartOutline& outline : outlines) outline.arrays[0].name = "w";
  EXPECT_EQ(refusal(), "file-format: a.pvtu: array 'w': is not what its header says");
}

}  // namespace mesh_share_test
}  // namespace ovoid::io
