// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/lattice_pieces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace lattice_pieces_test {

using testing::HasSubstr;

constexpr VtkExtent kWhole{{-2, 0, 5}, {4, 3, 8}};  // 7 x 4 x 4

std::string text_of(const VtkExtent& extent) {
  std::string text;
  for (std::size_t a = 0; a < 3; ++a)
    text += std::to_string(extent.lo[a]) + " " + std::to_string(extent.hi[a]) + " ";
  return text;
}

std::string file_of(const std::vector<VtkExtent>& pieces, const std::string& type = "PImageData") {
  std::string text = "<VTKFile type=\"" + type + "\"><" + type + " WholeExtent=\"" +
                     text_of(kWhole) + "\" GhostLevel=\"0\">";
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    text +=
        "<Piece Extent=\"" + text_of(pieces[i]) + "\" Source=\"p" + std::to_string(i) + ".vti\"/>";
  }
  return text + "</" + type + "></VTKFile>";
}

LatticeInPieces layout_of(const std::string& text) {
  return lattice_in_pieces(*open_memory("a.pvti", std::as_bytes(std::span(text))));
}

// A number for each index of the whole.
float value_at(std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<float>(x + 100 * y + 10000 * z);
}

LatticeGeometry lattice_of(const VtkExtent& extent) {
  LatticeGeometry lattice;
  lattice.dims = extent.dims();
  Mat3 linear;  // turned, and of unequal spacing
  linear << 0, -1, 0, 0.5, 0, 0, 0, 0, 2;
  lattice.world_from_index.linear() = linear;
  Vec3 first;
  for (int axis = 0; axis < 3; ++axis)
    first[axis] = static_cast<double>(extent.lo[static_cast<std::size_t>(axis)]);
  lattice.world_from_index.translation() = Vec3(1, 2, 3) + linear * first;
  return lattice;
}

using Value = std::function<float(std::int64_t x, std::int64_t y, std::int64_t z)>;

DataArray array_over(const VtkExtent& extent, bool are_cells, const Value& value) {
  std::vector<float> values;
  const std::int64_t less = are_cells ? 1 : 0;
  for (std::int64_t z = extent.lo[2]; z <= extent.hi[2] - less; ++z) {
    for (std::int64_t y = extent.lo[1]; y <= extent.hi[1] - less; ++y) {
      for (std::int64_t x = extent.lo[0]; x <= extent.hi[0] - less; ++x)
        values.push_back(value(x, y, z));
    }
  }
  DataArray array = make_array("v", ScalarType::kFloat32, values);
  array.is_cell_data = are_cells;
  return array;
}

Dataset piece_of(const VtkExtent& extent, bool are_cells = false, const Value& value = value_at) {
  Dataset dataset;
  dataset.kind = DatasetKind::kLattice;
  dataset.lattice = lattice_of(extent);
  dataset.arrays.push_back(array_over(extent, are_cells, value));
  return dataset;
}

// In pieces of 4 x 3 x 2 cells and what is left; with `ghosts` cells more on each side.
std::vector<VtkExtent> pieces_of_whole(std::int64_t ghosts = 0) {
  std::vector<VtkExtent> pieces;
  const VtkExtent& w = kWhole;
  for (std::int64_t z = w.lo[2]; z < w.hi[2]; z += 2) {
    for (std::int64_t y = w.lo[1]; y < w.hi[1]; y += 3) {
      for (std::int64_t x = w.lo[0]; x < w.hi[0]; x += 4) {
        const std::array<std::int64_t, 3> lo{x, y, z}, size{4, 3, 2};
        VtkExtent piece;
        for (std::size_t a = 0; a < 3; ++a) {
          piece.lo[a] = std::max(lo[a] - ghosts, w.lo[a]);
          piece.hi[a] = std::min(lo[a] + size[a] + ghosts, w.hi[a]);
        }
        pieces.push_back(piece);
      }
    }
  }
  return pieces;
}

void expect_whole(const Dataset& dataset, bool are_cells) {
  const LatticeGeometry expected = lattice_of(kWhole);
  EXPECT_EQ(dataset.lattice.dims, expected.dims);
  EXPECT_TRUE(dataset.lattice.world_from_index.isApprox(expected.world_from_index, 1e-12));
  ASSERT_EQ(dataset.arrays.size(), 1U);
  const DataArray all = array_over(kWhole, are_cells, value_at);
  EXPECT_EQ(dataset.arrays[0].num_tuples, all.num_tuples);
  EXPECT_EQ(dataset.arrays[0].is_cell_data, are_cells);
  EXPECT_EQ(values_of<float>(dataset.arrays[0]), values_of<float>(all));
}

TEST(LatticePieces, MakeTheWhole) {
  for (const bool are_cells : {false, true}) {
    for (const std::int64_t ghosts : {0, 1, 2}) {
      SCOPED_TRACE(testing::Message() << are_cells << " " << ghosts);
      const std::vector<VtkExtent> pieces = pieces_of_whole(ghosts);
      ASSERT_EQ(pieces.size(), 4U);
      LatticeAssembly assembly("a.pvti", layout_of(file_of(pieces)));
      for (std::size_t i = 0; i < pieces.size(); ++i)
        ASSERT_TRUE(assembly.add(i, piece_of(pieces[i], are_cells)));
      expect_whole(assembly.finish({}), are_cells);
    }
  }
}

// What a piece marks as another's is stale in it; it may come first, or last.
TEST(LatticePieces, TakeValuesOfTheirOwners) {
  const std::vector<VtkExtent> own = pieces_of_whole(), pieces = pieces_of_whole(1);
  for (const bool is_backwards : {false, true}) {
    LatticeAssembly assembly("a.pvti", layout_of(file_of(pieces)));
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const std::size_t i = is_backwards ? pieces.size() - 1 - k : k;
      const auto is_own = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
        return own[i].contains({{x, y, z}, {x + 1, y + 1, z + 1}});
      };
      Dataset piece = piece_of(pieces[i], true, [&](auto x, auto y, auto z) {
        return is_own(x, y, z) ? value_at(x, y, z) : -1.0F;
      });
      const DataArray marks = array_over(
          pieces[i], true, [&](auto x, auto y, auto z) { return is_own(x, y, z) ? 0.0F : 1.0F; });
      std::vector<std::uint8_t> ghosts;
      for (const float mark : values_of<float>(marks))
        ghosts.push_back(static_cast<std::uint8_t>(mark));
      piece.arrays.push_back(make_array(kGhostArray, ScalarType::kUInt8, ghosts));
      piece.arrays.back().is_cell_data = true;
      ASSERT_TRUE(assembly.add(i, piece));
    }
    expect_whole(assembly.finish({}), true);
  }
}

TEST(LatticePieces, LeaveOutWhatNotAllHave) {
  const std::vector<VtkExtent> pieces = pieces_of_whole();
  for (const std::size_t lacking : {std::size_t{0}, std::size_t{2}}) {
    LatticeAssembly assembly("a.pvti", layout_of(file_of(pieces)));
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      Dataset piece = piece_of(pieces[i]);
      piece.arrays.push_back(piece.arrays[0]);
      piece.arrays.back().name = "more";
      if (i == lacking) piece.arrays.pop_back();
      ASSERT_TRUE(assembly.add(i, piece));
    }
    const Dataset whole = assembly.finish({});
    expect_whole(whole, false);
    EXPECT_EQ(whole.notes,
              std::vector<std::string>{"a.pvti: arrays that not all pieces have are left out"});
  }
}

// VTK says that a layer of samples has cells; the whole has none there, whichever piece comes
// first.
TEST(LatticePieces, OfOneLayerHaveNoCells) {
  const VtkExtent left{{-2, 0, 5}, {1, 3, 8}}, layer{{-2, 0, 5}, {4, 3, 5}},
      right{{1, 0, 5}, {4, 3, 8}};
  Dataset flat = piece_of(layer);
  flat.arrays[0].is_cell_data = true;
  for (const bool is_flat_first : {true, false}) {
    const std::vector<VtkExtent> pieces =
        is_flat_first ? std::vector{layer, left, right} : std::vector{left, layer, right};
    LatticeAssembly assembly("a.pvti", layout_of(file_of(pieces)));
    Dataset with_more = piece_of(left, true), without = piece_of(right, true);
    with_more.arrays.push_back(with_more.arrays[0]);
    with_more.arrays[0].name = "more";
    ASSERT_TRUE(assembly.add(0, is_flat_first ? flat : with_more));
    flat.arrays[0].name = "more";  // which is not in the last piece
    ASSERT_TRUE(assembly.add(1, is_flat_first ? with_more : flat));
    ASSERT_TRUE(assembly.add(2, without));
    expect_whole(assembly.finish({}), true);
  }
}

TEST(LatticePieces, ThatAreMissingAreTold) {
  std::vector<VtkExtent> pieces = pieces_of_whole();
  pieces.pop_back();
  LatticeAssembly assembly("a.pvti", layout_of(file_of(pieces)));
  for (std::size_t i = 0; i < pieces.size(); ++i) ASSERT_TRUE(assembly.add(i, piece_of(pieces[i])));
  EXPECT_EQ(error_of([&] { assembly.finish({}); }),
            "file-format: a.pvti: its pieces hold 104 of 112 samples");
}

TEST(LatticePieces, ThatAreNoLatticeTogether) {
  const std::vector<VtkExtent> pieces = pieces_of_whole();
  const auto added = [&](const std::function<void(Dataset&)>& change) {
    LatticeAssembly assembly("a.pvti", layout_of(file_of(pieces)));
    EXPECT_TRUE(assembly.add(0, piece_of(pieces[0])));
    Dataset piece = piece_of(pieces[1]);
    change(piece);
    return assembly.add(1, piece);
  };
  EXPECT_TRUE(added([](Dataset&) {}));
  EXPECT_FALSE(added([](Dataset& piece) { piece.kind = DatasetKind::kMesh; }));
  EXPECT_FALSE(
      added([](Dataset& piece) { piece.lattice.world_from_index.translation().x() += 0.01; }));
  EXPECT_FALSE(added([](Dataset& piece) { piece.lattice.world_from_index.linear()(2, 2) = 2.1; }));
}

// Of rectilinear grids coordinates tell where samples are, and one is too few.
TEST(LatticePieces, OfOneLayerOfCoordinates) {
  const std::vector<VtkExtent> pieces{{{-2, 0, 5}, {4, 3, 5}}, {{-2, 0, 5}, {4, 3, 8}}};
  for (const bool is_image : {true, false}) {
    LatticeAssembly assembly(
        "a", layout_of(file_of(pieces, is_image ? "PImageData" : "PRectilinearGrid")));
    EXPECT_EQ(assembly.add(0, piece_of(pieces[0])), is_image);
  }
}

TEST(LatticePieces, ContradictionsAreErrors) {
  const std::vector<VtkExtent> pieces = pieces_of_whole();
  LatticeAssembly assembly("a.pvti", layout_of(file_of(pieces)));
  EXPECT_THAT(error_of([&] { assembly.add(0, piece_of(pieces[1])); }),
              HasSubstr("p0.vti: is 3x4x3: 'a.pvti' says 5x4x3"));
  ASSERT_TRUE(assembly.add(0, piece_of(pieces[0])));
  Dataset other = piece_of(pieces[1]);
  other.arrays[0] =
      make_array("v", ScalarType::kUInt8,
                 std::vector<std::uint8_t>(static_cast<std::size_t>(other.arrays[0].num_tuples)));
  EXPECT_THAT(error_of([&] { assembly.add(1, other); }),
              HasSubstr("p1.vti: array 'v': uint8 x 1: the piece 'p0.vti' has float32 x 1"));

  EXPECT_THAT(error_of([&] {
                layout_of(file_of({{{-2, 0, 5}, {5, 3, 8}}}));
              }),
              HasSubstr("a.pvti: Piece: Extent=\"-2 5 0 3 5 8 \": lies outside WholeExtent"));
  EXPECT_THAT(error_of([&] { layout_of(with(file_of(pieces), "-2 4 0", "-2 4")); }),
              HasSubstr("a.pvti: WholeExtent=\"-2 4 3 5 8 \": expected six integers"));
  EXPECT_NE(error_of([&] { layout_of(with(file_of(pieces), "-2 4 0", "5 4 0")); }), "");
  EXPECT_THAT(error_of([&] {
                layout_of(with(file_of(pieces), "0 3 5 8 ", "0 2147483647 -2147483647 2147483647"));
              }),
              HasSubstr("WholeExtent"));
  EXPECT_THAT(error_of([&] { layout_of(file_of({})); }), HasSubstr("a.pvti: names no files"));
}

// From the files themselves, also as a step of a series, and under a name that XML has to spell.
TEST(LatticePieces, OfFiles) {
  const TestFolder folder;
  const auto image = [&](const std::string& extent, const std::string& values) {
    return R"(<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian"><ImageData WholeExtent=")" +
           extent + R"(" Origin="1 0 0" Spacing="0.5 1 1"><Piece Extent=")" + extent +
           R"("><PointData><DataArray type="Int16" Name="v" format="ascii">)" + values +
           "</DataArray></PointData></Piece></ImageData></VTKFile>";
  };
  if (error_of([&] {
        read_dataset({folder.write("p.vti", image("0 1 0 1 0 0", "1 2 3 4"))});
      }).find("no VTK") != std::string::npos)
    GTEST_SKIP() << "this build has no VTK";
  folder.write("q & r.vti", image("1 3 0 1 0 0", "2 5 6 4 7 8"));
  const std::string path = folder.write(
      "a<b.pvti",
      R"(<VTKFile type="PImageData"><PImageData WholeExtent="0 3 0 1 0 0" GhostLevel="0">
<Piece Extent="0 1 0 1 0 0" Source="p.vti"/><Piece Extent="1 3 0 1 0 0" Source="q &amp; r.vti"/>
</PImageData></VTKFile>)");
  const std::string series = folder.write(
      "a.pvd",
      R"(<VTKFile type="Collection"><Collection><DataSet timestep="2" file="a&lt;b.pvti"/></Collection></VTKFile>)");
  for (const std::string& one : {path, series}) {
    const Dataset dataset = read_dataset({one});
    EXPECT_EQ(dataset.kind, DatasetKind::kLattice);
    EXPECT_EQ(dataset.format, "PVTI");
    EXPECT_EQ(dataset.lattice.dims, (Index3{4, 2, 1}));
    EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(1, 0, 0));
    EXPECT_EQ(values_of<std::int16_t>(dataset.array()),
              (std::vector<std::int16_t>{1, 2, 5, 6, 3, 4, 7, 8}));
  }
  ReadOptions options;
  options.array = "v";
  EXPECT_EQ(read_dataset({path}, options).arrays.size(), 1U);
  options.array = "w";
  EXPECT_THAT(error_of([&] { read_dataset({path}, options); }),
              HasSubstr("p.vti: array 'w': not there: expected one of 'v'"));
}

}  // namespace lattice_pieces_test
}  // namespace ovoid::io
