// SPDX-License-Identifier: Apache-2.0
//
// Control mesh -> level of its subdivision. A step makes a point of each edge, then of each face
// from its edges' points, then of each cell from its faces' points: always the middle of two points
// a and b by the 4-point rule, with the points that the line through them meets before a and after
// b (link.h). Work is divided by vertices, edges, faces and cells, each of which writes its own.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "data/parallel.h"
#include "ovoid/error.h"
#include "solid/link.h"

namespace ovoid {

namespace solid {

namespace {

// Place and density.
using Point = Eigen::Vector4d;

struct MaybePoint {
  Point point = Point::Zero();
  bool is_there = false;
};

// A line's points before a and after b. Where the mesh ends, the parabola through the three that
// are there goes on, or with two the straight line.
Point middle(const Point& a, const Point& b, const MaybePoint& before, const MaybePoint& after) {
  const Point first = before.is_there  ? before.point
                      : after.is_there ? Point(3 * (a - b) + after.point)
                                       : Point(2 * a - b);
  const Point last = after.is_there    ? after.point
                     : before.is_there ? Point(3 * (b - a) + before.point)
                                       : Point(2 * b - a);
  return 0.5625 * (a + b) - 0.0625 * (first + last);
}

// `point_of(i)`: of the i-th thing of the link.
template <class PointOf>
MaybePoint straight_on_point(const Link& link, std::size_t from, const PointOf& point_of) {
  MaybePoint beyond;
  const std::vector<double> weights = straight_on(link, from);
  beyond.is_there = !weights.empty();
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] != 0) beyond.point += weights[i] * point_of(i);
  }
  return beyond;
}

constexpr std::int64_t kGrain = 512;

// One step of subdivision.
class Step {
 public:
  Step(const std::vector<Point>& vertices, const std::vector<CellVertices>& cells,
       const SubdivisionOptions& options)
      : vertices_(vertices),
        cells_(cells),
        options_(options),
        topology_(make_topology(vertices.size(), cells)) {
    first_edge_ = vertices.size();
    first_face_ = first_edge_ + topology_.edges.size();
    first_cell_ = first_face_ + topology_.faces.size();
    const std::size_t count = first_cell_ + cells.size();
    if (count >= std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::kOutOfMemory,
                  fmt::format("levels = {}: {} vertices, must be fewer than {}", options.levels,
                              count, std::numeric_limits<std::uint32_t>::max()));
    points_ = vertices;
    points_.resize(count);
    make_edge_points();
    make_face_points();
    make_cell_points();
  }

  std::vector<Point> take_points() && { return std::move(points_); }

  std::vector<CellVertices> finer_cells() const {
    std::vector<CellVertices> finer;
    finer.reserve(8 * cells_.size());
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      for (int at = 0; at < kCellCorners; ++at) {
        CellVertices cell{};
        for (int corner = 0; corner < kCellCorners; ++corner)
          cell[static_cast<std::size_t>(corner)] = vertex_at(c, at & corner, at ^ corner);
        finer.push_back(cell);
      }
    }
    return finer;
  }

 private:
  // The vertex of a cell where the axes of `halved` are at their middle, and of the others
  // those of `far` at their end.
  std::uint32_t vertex_at(std::size_t cell, int far, int halved) const {
    const auto numbered = [](std::size_t first, std::size_t i) {
      return static_cast<std::uint32_t>(first + i);
    };
    switch (halved) {
      case 0:
        return cells_[cell][static_cast<std::size_t>(far)];
      case 1:
      case 2:
      case 4:
        return numbered(
            first_edge_,
            topology_.cell_edges[cell][static_cast<std::size_t>(edge_at_corner(halved / 2, far))]);
      case 7:
        return numbered(first_cell_, cell);
      default: {
        const auto axis = static_cast<std::size_t>((7 ^ halved) / 2);
        const auto side = static_cast<std::size_t>(far) >> axis & 1U;
        return numbered(first_face_, topology_.cell_faces[cell][axis * 2 + side]);
      }
    }
  }

  template <class Body>
  void for_all(std::size_t count, const Body& body) const {
    data::parallel_ranges(
        {static_cast<std::int64_t>(count), kGrain, options_.threads, options_.stop},
        [&](std::int64_t begin, std::int64_t end) {
          for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
            body(i);
        });
  }

  void make_edge_points() {
    std::vector<std::array<MaybePoint, 2>> beyond(topology_.edges.size());  // each end
    const Incidence edges = edges_of_vertex();
    for_all(vertices_.size(), [&](std::size_t v) {
      const auto vertex = static_cast<std::uint32_t>(v);
      const Link link = link_of_vertex(topology_, cells_, vertex);
      for (const std::uint32_t e : edges.of(v)) {
        const auto& ends = topology_.edges[e];
        const std::size_t side = ends[0] == vertex ? 0 : 1;
        const auto from = std::find(link.things.begin(), link.things.end(), ends[1 - side]);
        beyond[e][side] = straight_on_point(
            link, static_cast<std::size_t>(from - link.things.begin()),
            [&](std::size_t i) -> const Point& { return vertices_[link.things[i]]; });
      }
    });
    for_all(topology_.edges.size(), [&](std::size_t e) {
      const auto& ends = topology_.edges[e];
      points_[first_edge_ + e] =
          middle(vertices_[ends[0]], vertices_[ends[1]], beyond[e][0], beyond[e][1]);
    });
  }

  // Between two opposite edges of a face, once either way.
  void make_face_points() {
    std::vector<std::array<MaybePoint, 4>> beyond(topology_.faces.size());  // each edge
    const auto side_of = [&](std::uint32_t face, std::size_t edge) {
      const auto& edges = topology_.face_edges[face];
      return static_cast<std::size_t>(
          std::find(edges.begin(), edges.end(), static_cast<std::uint32_t>(edge)) - edges.begin());
    };
    for_all(topology_.edges.size(), [&](std::size_t e) {
      const Link link = link_of_edge(topology_, static_cast<std::uint32_t>(e));
      for (std::size_t from = 0; from < link.things.size(); ++from) {
        const std::uint32_t face = link.things[from];
        beyond[face][side_of(face, e)] =
            straight_on_point(link, from, [&](std::size_t i) -> const Point& {
              const std::uint32_t other = link.things[i];
              return edge_point(topology_.face_edges[other][(side_of(other, e) + 2) % 4]);
            });
      }
    });
    for_all(topology_.faces.size(), [&](std::size_t f) {
      const auto& edges = topology_.face_edges[f];
      Point sum = Point::Zero();
      for (std::size_t way = 0; way < 2; ++way)
        sum += middle(edge_point(edges[way]), edge_point(edges[way + 2]), beyond[f][way],
                      beyond[f][way + 2]);
      points_[first_face_ + f] = sum / 2;
    });
  }

  // Between two opposite faces of a cell, once each way.
  void make_cell_points() {
    for_all(cells_.size(), [&](std::size_t c) {
      const auto& faces = topology_.cell_faces[c];
      Point sum = Point::Zero();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t a = faces[2 * axis], b = faces[2 * axis + 1];
        sum += middle(face_point(a), face_point(b), beyond_face(c, a), beyond_face(c, b));
      }
      points_[first_cell_ + c] = sum / 3;
    });
  }

  // The point of the far face of the cell behind a face.
  MaybePoint beyond_face(std::size_t cell, std::uint32_t face) const {
    for (const std::uint32_t other : topology_.cells_of_face.of(face)) {
      if (other == cell) continue;
      const auto& faces = topology_.cell_faces[other];
      const auto local =
          static_cast<int>(std::find(faces.begin(), faces.end(), face) - faces.begin());
      return {face_point(faces[static_cast<std::size_t>(opposite_face(local))]), true};
    }
    return {};
  }

  Incidence edges_of_vertex() const {
    std::vector<std::array<std::uint32_t, 2>> pairs;
    for (std::size_t e = 0; e < topology_.edges.size(); ++e) {
      for (const std::uint32_t vertex : topology_.edges[e])
        pairs.push_back({vertex, static_cast<std::uint32_t>(e)});
    }
    return {vertices_.size(), pairs};
  }

  const Point& edge_point(std::uint32_t edge) const { return points_[first_edge_ + edge]; }
  const Point& face_point(std::uint32_t face) const { return points_[first_face_ + face]; }

  const std::vector<Point>& vertices_;
  const std::vector<CellVertices>& cells_;
  const SubdivisionOptions& options_;
  HexTopology topology_;
  std::size_t first_edge_ = 0, first_face_ = 0, first_cell_ = 0;
  std::vector<Point> points_;
};

void check_options(const SolidMesh& control, const SubdivisionOptions& options) {
  constexpr int kMost = SubdivisionOptions::kMostLevels;
  if (options.levels < 0 || options.levels > kMost)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("levels = {}: must be 0 to {}", options.levels, kMost));
  const std::size_t bytes = bytes_of_level(control, options.levels);
  if (options.memory_limit > 0 && bytes > options.memory_limit)
    throw Error(
        ErrorCode::kOutOfMemory,
        fmt::format("levels = {}: {} cells become {}, which take about {} bytes, more than "
                    "the memory limit of {}; fewer levels, or a higher limit, will do",
                    options.levels, control.cells.size(),
                    control.cells.size() << 3 * options.levels, bytes, options.memory_limit));
}

}  // namespace

}  // namespace solid

std::size_t bytes_of_level(const SolidMesh& control, int levels) noexcept {
  // For each cell, which has a vertex nearly: what hexahedra and their vertices take, the topology
  // of the level before and, most of all, some 40 entries in the rows of a KernelOperator.
  // Measured: 773 for 450,560 cells, the program itself and the file's columns included.
  constexpr double kBytesPerCell = 800;
  const double bytes =
      std::ldexp(static_cast<double>(control.cells.size()), 3 * levels) * kBytesPerCell;
  constexpr double kMost = 9e18;  // is under 2^63
  return static_cast<std::size_t>(std::min(bytes, kMost));
}

SolidMesh subdivide_solid(const SolidMesh& control, const SubdivisionOptions& options) {
  solid::check_options(control, options);
  check_solid_mesh(control);
  std::vector<solid::Point> points(control.num_vertices());
  for (std::size_t v = 0; v < points.size(); ++v)
    points[v] << control.position(v), control.densities[v];
  std::vector<solid::CellVertices> cells = control.cells;
  try {
    for (int level = 0; level < options.levels; ++level) {
      solid::Step step(points, cells, options);
      std::vector<solid::CellVertices> finer = step.finer_cells();
      points = std::move(step).take_points();
      cells = std::move(finer);
    }
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("levels = {}: no memory for {} cells", options.levels,
                            control.cells.size() << 3 * options.levels));
  }
  SolidMesh level;
  level.name = control.name;
  level.unit = control.unit;
  level.cells = std::move(cells);
  for (const solid::Point& point : points) {
    level.positions.insert(level.positions.end(), point.data(), point.data() + 3);
    level.densities.push_back(point[3]);
  }
  return level;
}

}  // namespace ovoid
