// SPDX-License-Identifier: Apache-2.0
// Control meshes for tests.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "ovoid/solid.h"

namespace ovoid::solid {

inline void add_vertex(SolidMesh& mesh, const Vec3& at, double density) {
  mesh.positions.insert(mesh.positions.end(), at.begin(), at.end());
  mesh.densities.push_back(density);
}

// n^3 vertices on whole numbers from 0 on.
inline SolidMesh grid_solid(int n, const std::function<double(const Vec3&)>& density) {
  SolidMesh mesh;
  for (int i = 0; i < n * n * n; ++i) {
    const Vec3 at(i % n, i / n % n, i / n / n);
    add_vertex(mesh, at, density(at));
  }
  for (int i = 0; i < (n - 1) * (n - 1) * (n - 1); ++i) {
    const int x = i % (n - 1), y = i / (n - 1) % (n - 1), z = i / (n - 1) / (n - 1);
    std::array<std::uint32_t, 8> cell{};
    for (int c = 0; c < 8; ++c)
      cell[static_cast<std::size_t>(c)] =
          static_cast<std::uint32_t>(x + (c & 1) + n * (y + (c >> 1 & 1) + n * (z + (c >> 2))));
    mesh.cells.push_back(cell);
  }
  return mesh;
}

// `around` cells a layer, two layers, around the z axis; vertex 0 is the one inside.
inline SolidMesh ring_solid(int around, const std::function<double(const Vec3&)>& density) {
  SolidMesh mesh;
  const auto place = [&](int half_steps, double radius, double z) {
    const double angle = std::numbers::pi * half_steps / around;
    return Vec3(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  for (const double z : {0.0, -1.0, 1.0}) {
    add_vertex(mesh, {0, 0, z}, density({0, 0, z}));
    for (int i = 0; i < 2 * around; ++i) {
      const Vec3 at = place(i, i % 2 == 0 ? 1 : 1.4, z);
      add_vertex(mesh, at, density(at));
    }
  }
  const int layer = 2 * around + 1;
  for (const std::array<int, 2>& layers : {std::array{1, 0}, std::array{0, 2}}) {
    for (int i = 0; i < around; ++i) {
      const std::array<int, 4> corners = {0, 1 + 2 * i, 1 + (2 * i + 2) % (2 * around), 2 + 2 * i};
      std::array<std::uint32_t, 8> cell{};
      for (std::size_t c = 0; c < 8; ++c)
        cell[c] = static_cast<std::uint32_t>(corners[c % 4] + layer * layers[c / 4]);
      mesh.cells.push_back(cell);
    }
  }
  return mesh;
}

// Some of a mesh's cells, with the vertices that they need.
inline SolidMesh part_of(const SolidMesh& mesh, const std::vector<std::size_t>& cells) {
  SolidMesh part;
  std::vector<std::uint32_t> numbers(mesh.num_vertices(), ~0U);
  for (const std::size_t c : cells) {
    std::array<std::uint32_t, 8> cell = mesh.cells[c];
    for (std::uint32_t& vertex : cell) {
      std::uint32_t& number = numbers[vertex];
      if (number == ~0U) {
        number = static_cast<std::uint32_t>(part.num_vertices());
        add_vertex(part, mesh.position(vertex), mesh.densities[vertex]);
      }
      vertex = number;
    }
    part.cells.push_back(cell);
  }
  return part;
}

// A tetrahedron cut into four hexahedra, one at each corner: around its middle all edges have three
// cells.
inline SolidMesh four_cells_solid(const std::function<double(const Vec3&)>& density) {
  SolidMesh mesh;
  const std::array<Vec3, 4> corners = {Vec3(1, 1, 1), Vec3(-1, -1, 1), Vec3(-1, 1, -1),
                                       Vec3(1, -1, -1)};
  // The mean of the corners whose bits are set, numbered by these bits.
  std::array<std::uint32_t, 16> vertex_of{};
  for (std::uint32_t bits = 1; bits < 16; ++bits) {
    Vec3 mean = Vec3::Zero();
    int count = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if ((bits >> i & 1) == 0) continue;
      mean += corners[i];
      ++count;
    }
    mean /= count;
    vertex_of[bits] = bits - 1;
    add_vertex(mesh, mean, density(mean));
  }
  // Even orders of the corners, so that all cells turn the same way.
  for (const std::array<int, 4>& order : {std::array{0, 1, 2, 3}, std::array{1, 0, 3, 2},
                                          std::array{2, 3, 0, 1}, std::array{3, 2, 1, 0}}) {
    std::array<std::uint32_t, 8> cell{};
    for (unsigned c = 0; c < 8; ++c) {
      std::uint32_t bits = 1U << order[0];
      for (unsigned axis = 0; axis < 3; ++axis) bits |= (c >> axis & 1U) << order[axis + 1];
      cell[c] = vertex_of[bits];
    }
    mesh.cells.push_back(cell);
  }
  return mesh;
}

// The basis of the 4-point scheme, support [-3, 3], by its own recursion.
inline double four_point_basis(double x) {
  constexpr int kHalvings = 7;
  static const std::array<double, 6 * (1 << kHalvings) + 1> table = [] {
    std::array<double, 6 * (1 << kHalvings) + 1> values{};
    const int last = static_cast<int>(values.size()) - 1;
    values[static_cast<std::size_t>(last / 2)] = 1;
    for (int step = 1 << kHalvings; step > 1; step /= 2) {
      const auto at = [&](int i) {
        return i < 0 || i > last ? 0 : values[static_cast<std::size_t>(i)];
      };
      for (int i = step / 2; i <= last; i += step)
        values[static_cast<std::size_t>(i)] = (9 * (at(i - step / 2) + at(i + step / 2)) -
                                               at(i - 3 * step / 2) - at(i + 3 * step / 2)) /
                                              16;
    }
    return values;
  }();
  const double place = (x + 3) * (1 << kHalvings);
  if (place < 0 || place >= static_cast<double>(table.size() - 1)) return 0;
  const auto i = static_cast<std::size_t>(place);
  const double share = place - static_cast<double>(i);
  return (1 - share) * table[i] + share * table[i + 1];
}

}  // namespace ovoid::solid
