// SPDX-License-Identifier: Apache-2.0
// Meshes and boxes of which each process of a team has a share, against one process with all.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "data/cell_builder.h"
#include "io/core/row_share.h"
#include "io/meshes/mesh_blocks.h"
#include "model/lattice/noise.h"
#include "model/team/test_teams.h"
#include "model/test_datasets.h"
#include "ovoid/error.h"
#include "ovoid/surface.h"

namespace ovoid::model {
namespace team_mesh_test {

ShareOf cut_of(const Dataset& whole) {
  return [&whole](int number, int count) {
    Dataset share = whole;
    io::cut_to_share(share, RowShare{number, count});
    return share;
  };
}

// To the bit, and in the same order: on which side of an edge a ray passes depends on it.
void expect_same_surface(const Surface& surface, const Surface& expected) {
  ASSERT_EQ(surface.triangles.size(), expected.triangles.size());
  EXPECT_EQ(surface.places, expected.places);
  EXPECT_EQ(surface.leaves_out_cells, expected.leaves_out_cells);
  EXPECT_EQ(surface.bounds.min(), expected.bounds.min());
  EXPECT_EQ(surface.bounds.max(), expected.bounds.max());
  for (std::size_t t = 0; t < expected.triangles.size(); ++t) {
    const Surface::Triangle& triangle = surface.triangles[t];
    const Surface::Triangle& wanted = expected.triangles[t];
    EXPECT_EQ(triangle.corners, wanted.corners);
    EXPECT_EQ(triangle.edges, wanted.edges);
    EXPECT_EQ(triangle.is_boundary, wanted.is_boundary);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(triangle.normals[c], wanted.normals[c]);
      const bool are_missing = std::isnan(triangle.values[c]) && std::isnan(wanted.values[c]);
      EXPECT_TRUE(are_missing || triangle.values[c] == wanted.values[c]) << "triangle " << t;
    }
  }
}

// Nodes of no cell get balls by distances that are worked out in floats of their own process, and
// the weights around these follow.
enum class Lone { kNone, kSome };

// Where a field barely rises, light depends on its last bits.
void expect_same_bits(const KernelField& field, const KernelField& expected, Lone lone) {
  for (std::int64_t b = 0; b < expected.source().num_bricks(); ++b) {
    const KernelView view = field.source().acquire(b, 0);
    const KernelView wanted = expected.source().acquire(b, 0);
    for (std::int32_t k = 0; k < wanted.count; ++k) {
      if (lone == Lone::kNone)
        EXPECT_EQ(data::weight_of(view, k), data::weight_of(wanted, k));
      else
        EXPECT_FLOAT_EQ(data::weight_of(view, k), data::weight_of(wanted, k));
      EXPECT_EQ(view.value[0][k], wanted.value[0][k]);
    }
  }
}

void expect_same_mesh(const Dataset& whole, const ShareOf& share_of,
                      const KernelModelOptions& options = {}, Lone lone = Lone::kNone) {
  expect_same_together(whole, share_of, options);
  const auto alone = make_surface(whole, options);
  const KernelField field = make_kernel_field(whole, options);
  for (const int count : {1, 3, 7}) {
    SCOPED_TRACE(::testing::Message() << count << " processes");
    for (const Made& made : made_together(share_of, count, options)) {
      expect_same_bits(made.field, field, lone);
      ASSERT_EQ(made.surface == nullptr, alone == nullptr);
      if (alone != nullptr) expect_same_surface(*made.surface, *alone);
    }
  }
}

void expect_same_mesh(const Dataset& whole, const KernelModelOptions& options = {}) {
  expect_same_mesh(whole, cut_of(whole), options);
}

Vec3 jittered(const Vec3& place, std::uint64_t seed) {
  Random random(seed + static_cast<std::uint64_t>(place[0] + 100 * place[1] + 10'000 * place[2]));
  return place + 0.2 * Vec3{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

// Curvilinear, with neighbours in any distance.
Dataset fan(const Index3& dims) {
  return grid_dataset(dims, [&](const Vec3& at) {
    const Vec3 p = jittered(at, 1);
    const double radius = 3 + 0.3 * p[0];
    return Vec3(radius * std::cos(0.1 * p[1]), radius * std::sin(0.1 * p[1]), 0.4 * p[2]);
  });
}

// Six tetrahedra for each box of a grid.
Dataset tetrahedra(const Index3& dims, std::uint64_t seed) {
  const Dataset grid = grid_dataset(dims, [&](const Vec3& at) { return jittered(at, seed); });
  Dataset mesh = grid;
  mesh.cells.dims = {0, 0, 0};
  data::CellBuilder cells;
  const auto node = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return static_cast<std::uint32_t>(i + dims[0] * (j + dims[1] * k));
  };
  constexpr std::array<std::array<int, 3>, 6> kOrders = {
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}};
  for (std::int64_t k = 0; k + 1 < dims[2]; ++k) {
    for (std::int64_t j = 0; j + 1 < dims[1]; ++j) {
      for (std::int64_t i = 0; i + 1 < dims[0]; ++i) {
        for (const auto& order : kOrders) {
          std::array<std::int64_t, 3> at{i, j, k};
          std::array<std::uint32_t, 4> corners{node(i, j, k)};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[static_cast<std::size_t>(order[step])];
            corners[step + 1] = node(at[0], at[1], at[2]);
          }
          cells.add(CellType::kTetrahedron, corners);
        }
      }
    }
  }
  mesh.cells = std::move(cells).finish();
  return mesh;
}

void add_values(Dataset& dataset, const char* name, std::int64_t count, bool is_cell_data,
                std::int64_t missing = -1) {
  std::vector<float> values;
  for (std::int64_t i = 0; i < count; ++i)
    values.push_back(i == missing ? std::nanf("") : static_cast<float>((i * 37) % 101));
  dataset.arrays.push_back(array_of_numbers(name, 1, std::move(values)));
  dataset.arrays.back().is_cell_data = is_cell_data;
}

TEST(TeamMesh, Grids) {
  expect_same_mesh(fan({9, 14, 11}));
  expect_same_mesh(fan({6, 30, 2}));  // of one layer
  Dataset flat = fan({12, 17, 1});
  expect_same_mesh(flat);
}

TEST(TeamMesh, Tetrahedra) {
  Dataset mesh = tetrahedra({8, 9, 7}, 3);
  add_values(mesh, "second", mesh.num_positions(), false);
  expect_same_mesh(mesh);
  expect_same_mesh(mesh, {.array = "second", .color_array = "v", .amplitude_passes = 1});
}

TEST(TeamMesh, ValuesOfCells) {
  Dataset mesh = tetrahedra({7, 6, 8}, 4);
  mesh.arrays.clear();
  add_values(mesh, "p", mesh.cells.count(), true, 200);
  expect_same_mesh(mesh);
  Dataset grid = fan({7, 12, 9});
  grid.arrays.clear();
  add_values(grid, "p", grid.cells.count(), true);
  expect_same_mesh(grid);
}

// Nodes of no cell, at one place with others, without a place or a value; cells that are inside
// out, flat, unknown or without a volume.
TEST(TeamMesh, WhatMeshesMayBe) {
  Dataset mesh = tetrahedra({7, 7, 7}, 5);
  std::vector<double> places;
  std::vector<float> values;
  const auto count = static_cast<std::size_t>(mesh.num_positions());
  places.resize(3 * count);
  std::memcpy(places.data(), mesh.positions.bytes.view.data(), 3 * count * sizeof(double));
  for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<float>(i % 29));
  const auto add_node = [&](const Vec3& at, float value) {
    places.insert(places.end(), {at[0], at[1], at[2]});
    values.push_back(value);
    return static_cast<std::uint32_t>(values.size() - 1);
  };
  data::CellBuilder cells{mesh.cells.types.to_vector(), mesh.cells.offsets.to_vector(),
                          mesh.cells.connectivity.to_vector()};
  std::swap(cells.connectivity[8], cells.connectivity[9]);  // inside out
  cells.connectivity[101] = cells.connectivity[102];        // without a volume
  // The other side of a crack: half of the cells have nodes of their own at the same places.
  std::map<std::uint32_t, std::uint32_t> other_side;
  for (std::size_t i = cells.connectivity.size() / 2; i < cells.connectivity.size(); ++i) {
    std::uint32_t& node = cells.connectivity[i];
    const double x = places[std::size_t{3} * node];
    if (x < 2.7 || x > 3.3 || node >= count) continue;
    if (!other_side.contains(node)) {
      const double* const at = places.data() + std::size_t{3} * node;
      other_side[node] = add_node({at[0], at[1], at[2]}, 50);
    }
    node = other_side[node];
  }
  places[3 * 60 + 1] = std::nan("");
  values[90] = std::nanf("");
  for (int i = 0; i < 5; ++i) add_node({1.5 * i, 3.1, 9}, 1);  // of no cell
  add_node({std::nan(""), 0, 0}, 1);
  const std::uint32_t far = add_node({12, 3, 3}, 4), above = add_node({12, 3, 5}, 9);
  cells.add(CellType::kTriangle, std::array{far, above, std::uint32_t{340}});
  cells.add(CellType::kLine, std::array{far, std::uint32_t{3}});
  cells.add(CellType::kVertex, std::array{add_node({9, 9, 9}, 2)});
  cells.add(CellType::kOther, std::array<std::uint32_t, 5>{far, above, 20, 21, 25});
  cells.add(CellType::kOther, std::array<std::uint32_t, 0>{});
  mesh.positions = array_of_numbers("positions", 3, std::move(places));
  mesh.arrays = {array_of_numbers("v", 1, std::move(values))};
  mesh.cells = std::move(cells).finish();
  expect_same_mesh(mesh, cut_of(mesh), {}, Lone::kSome);
}

Dataset boxes(bool has_levels) {
  std::vector<Vec3> centers;
  std::vector<double> sizes;
  for (int k = 0; k < 8; ++k) {
    for (int j = 0; j < 7; ++j) {
      for (int i = 0; i < 9; ++i) {
        if (i == 4 && j == 4) continue;  // a shaft
        const Vec3 corner(i, j, k);
        const bool is_fine = has_levels && i > 4 && k < 4;
        for (int part = 0; part < (is_fine ? 8 : 1); ++part) {
          const Vec3 offset(part & 1, part >> 1 & 1, part >> 2);
          centers.push_back(is_fine ? Vec3(corner + 0.25 * Vec3::Ones() + 0.5 * offset)
                                    : Vec3(corner + 0.5 * Vec3::Ones()));
          sizes.insert(sizes.end(), 3, is_fine ? 0.5 : 1.0);
        }
      }
    }
  }
  Dataset dataset = points_dataset(DatasetKind::kBoxes, centers);
  dataset.box_sizes = array_of_numbers("box_sizes", 3, std::move(sizes));
  return dataset;
}

// Rectangles are cut differently where parts of a plane are looked at: what they cover is the same.
double area_of(const Surface& surface) {
  double area = 0;
  for (const Surface::Triangle& triangle : surface.triangles) {
    const Vec3 origin = surface.places[triangle.corners[0]];
    area += 0.5 * (surface.places[triangle.corners[1]] - origin)
                      .cross(surface.places[triangle.corners[2]] - origin)
                      .norm();
  }
  return area;
}

TEST(TeamMesh, Boxes) {
  for (const bool has_levels : {false, true}) {
    const Dataset whole = boxes(has_levels);
    expect_same_together(whole, cut_of(whole));
    const auto alone = make_surface(whole);
    ASSERT_NE(alone, nullptr);
    for (const int count : {1, 3, 7}) {
      for (const Made& made : made_together(cut_of(whole), count, {})) {
        ASSERT_NE(made.surface, nullptr);
        EXPECT_NEAR(area_of(*made.surface), area_of(*alone), 1e-9);
        EXPECT_EQ(made.surface->bounds.max(), alone->bounds.max());
        if (!has_levels) {
          EXPECT_EQ(made.surface->triangles.size(), alone->triangles.size());
        }
      }
    }
  }
}

// The parts of a mesh between planes, each with nodes of its own.
std::vector<io::MeshPart> pieces_of(const Dataset& mesh, int count) {
  std::vector<io::MeshPart> pieces;
  for (int p = 0; p < count; ++p) {
    Dataset share = mesh;
    io::cut_to_share(share, RowShare{p, count});
    io::MeshPart& piece = pieces.emplace_back();
    piece.positions = share.positions;
    piece.cells = share.cells;
    std::vector<float> values;  // where pieces meet they need not agree
    for (std::int64_t i = 0; i < share.num_positions(); ++i)
      values.push_back(static_cast<float>(p + i % 7));
    piece.arrays = {array_of_numbers("v", 1, std::move(values))};
  }
  return pieces;
}

TEST(TeamMesh, Pieces) {
  constexpr int kPieces = 5;
  const Dataset mesh = tetrahedra({8, 7, 9}, 6);
  std::vector<io::MeshPart> pieces = pieces_of(mesh, kPieces);
  std::vector<io::PartOutline> outlines;
  for (const io::MeshPart& piece : pieces) outlines.push_back(io::outline_of(piece));
  Dataset named;
  named.source = "some.pvtu";
  Dataset whole = io::mesh_of_parts(named, pieces, {});
  whole.notes.clear();
  const ShareOf share_of = [&](int number, int count) {
    ReadOptions options;
    options.share = RowShare{number, count};
    Dataset share = io::mesh_share_of_parts(
        named, outlines, [&](std::size_t p) { return pieces[p]; }, options);
    share.notes.clear();
    return share;
  };
  expect_same_mesh(whole, share_of);
}

TEST(TeamMesh, RefusesWhatNobodyHas) {
  Dataset mesh = tetrahedra({4, 4, 4}, 7);
  mesh.arrays.clear();
  add_values(mesh, "v", mesh.num_positions(), false);
  std::vector<float> nothing(static_cast<std::size_t>(mesh.num_positions()), std::nanf(""));
  mesh.arrays = {array_of_numbers("v", 1, std::move(nothing))};
  const std::string alone = model_refusal(mesh);
  try {
    made_together(cut_of(mesh), 3, {});
    ADD_FAILURE() << "was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.what(), alone);
  }
}

TEST(TeamMesh, RefusesSharesWithoutNumbers) {
  const Dataset mesh = tetrahedra({4, 4, 4}, 8);
  const ShareOf share_of = [&](int number, int count) {
    Dataset share = cut_of(mesh)(number, count);
    share.share->nodes = {};
    return share;
  };
  EXPECT_THROW(made_together(share_of, 2, {}), Error);
}

}  // namespace team_mesh_test
}  // namespace ovoid::model
