// SPDX-License-Identifier: Apache-2.0
// Lines as tubes, points as balls: surfaces of what has none.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "data/out_of_memory.h"
#include "model/mesh/mesh_cells.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/surface.h"

namespace ovoid {
namespace {

using model::MeshCells;
using model::MeshNodes;

constexpr std::uint32_t kSides = 12;  // of a tube
constexpr std::size_t kMostTriangles = std::size_t{1} << 28;
constexpr std::size_t kMostFineBalls = 20'000;

// A place on a line, or a point.
struct Site {
  Vec3 place = Vec3::Zero();
  float value = 0;
};
using Line = std::vector<Site>;

struct LinesAndPoints {
  std::vector<Line> lines;
  std::vector<Site> points;
};

// Puts lines together while cells come in.
class LineCollector {
 public:
  explicit LineCollector(LinesAndPoints& all) : all_(all) {}

  // A cell from the node `first` on: of a line that ended there it is the next part.
  void begin(std::uint32_t first, bool goes_on) {
    if (goes_on && last_ == first) return;
    finish();
  }
  void add(std::uint32_t node, const Site& site) {
    last_ = node;
    if (!site.place.allFinite()) return finish();
    if (line_.empty() || line_.back().place != site.place) line_.push_back(site);
  }
  void finish() {
    if (line_.size() == 1) all_.points.push_back(line_.front());
    if (line_.size() > 1) all_.lines.push_back(std::move(line_));
    line_.clear();
    last_.reset();
  }

 private:
  LinesAndPoints& all_;
  Line line_;
  std::optional<std::uint32_t> last_;
};

LinesAndPoints collect(const MeshNodes& nodes, const MeshCells& cells,
                       const std::vector<float>& column, bool is_of_cells) {
  LinesAndPoints all;
  LineCollector line(all);
  for (std::size_t c = 0; c < cells.count(); ++c) {
    const auto site = [&](std::uint32_t node) {
      return Site{nodes.at(node), column[is_of_cells ? c : nodes.stands_for(node)]};
    };
    const auto cell = cells.nodes(c);
    if (cells.types[c] == CellType::kVertex) {
      for (const std::uint32_t node : cell)
        if (nodes.is_placed(node)) all.points.push_back(site(node));
    }
    if (cells.types[c] != CellType::kLine && cells.types[c] != CellType::kPolyLine) continue;
    if (cell.empty()) continue;
    // A value for each cell changes from one to the next.
    line.begin(nodes.stands_for(cell.front()), cells.types[c] == CellType::kLine && !is_of_cells);
    for (const std::uint32_t node : cell) line.add(nodes.stands_for(node), site(node));
  }
  line.finish();
  return all;
}

// Corners around a place of a line.
struct Ring {
  std::uint32_t first = 0;  // of kSides places
  std::array<Eigen::Vector3f, kSides> normals;
};

// So thin that a bundle of lines is seen as lines.
double usual_radius(const LinesAndPoints& all) {
  constexpr double kOfDiagonal = 1.0 / 300;
  Bounds3 bounds;
  for (const Line& line : all.lines)
    for (const Site& site : line) bounds.extend(site.place);
  for (const Site& point : all.points) bounds.extend(point.place);
  const double radius = kOfDiagonal * bounds.diagonal().norm();
  return radius > 0 ? radius : 1;
}

class TubeBuilder {
 public:
  TubeBuilder(double radius, Surface& surface) : radius_(radius), surface_(surface) {}

  void add_tube(const Line& line) {
    Vec3 across = Vec3::Zero();
    Ring before;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vec3 along = direction_at(line, i);
      // Carried on from place to place, so that the tube does not twist.
      across -= along * along.dot(across);
      if (across.norm() < 1e-3) across = along.unitOrthogonal();
      across.normalize();
      const Ring ring = add_ring(line[i].place, along, across);
      if (i == 0) add_end(line[i], -along, ring);
      if (i > 0) add_side(before, ring, line[i - 1], line[i]);
      if (i + 1 == line.size()) add_end(line[i], along, ring);
      before = ring;
    }
  }

  void add_ball(const Site& site, const Surface& ball) {
    const auto first = static_cast<std::uint32_t>(surface_.places.size());
    for (const Vec3& place : ball.places) add_place(site.place + radius_ * place);
    for (Surface::Triangle triangle : ball.triangles) {
      for (std::uint32_t& corner : triangle.corners) corner += first;
      triangle.values.fill(site.value);
      surface_.triangles.push_back(triangle);
    }
  }

 private:
  // Half-way between those of the parts that meet.
  static Vec3 direction_at(const Line& line, std::size_t i) {
    Vec3 sum = Vec3::Zero();
    Vec3 part = Vec3::UnitX();
    if (i > 0) sum += part = (line[i].place - line[i - 1].place).normalized();
    if (i + 1 < line.size()) sum += part = (line[i + 1].place - line[i].place).normalized();
    return sum.norm() > 1e-3 ? Vec3(sum.normalized()) : part;
  }

  std::uint32_t add_place(const Vec3& place) {
    surface_.places.push_back(place);
    surface_.bounds.extend(place);
    return static_cast<std::uint32_t>(surface_.places.size() - 1);
  }

  Ring add_ring(const Vec3& middle, const Vec3& along, const Vec3& across) {
    Ring ring{static_cast<std::uint32_t>(surface_.places.size()), {}};
    const Vec3 other = along.cross(across);
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kSides;
      const Vec3 outwards = std::cos(angle) * across + std::sin(angle) * other;
      add_place(middle + radius_ * outwards);
      ring.normals[k] = outwards.cast<float>();
    }
    return ring;
  }

  void add_side(const Ring& from, const Ring& to, const Site& a, const Site& b) {
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const std::uint32_t next = (k + 1) % kSides;
      add({from.first + k, from.first + next, to.first + next},
          {from.normals[k], from.normals[next], to.normals[next]}, {a.value, a.value, b.value});
      add({from.first + k, to.first + next, to.first + k},
          {from.normals[k], to.normals[next], to.normals[k]}, {a.value, b.value, b.value});
    }
  }

  void add_end(const Site& site, const Vec3& outwards, const Ring& ring) {
    const std::uint32_t middle = add_place(site.place);
    const Eigen::Vector3f normal = outwards.cast<float>();
    for (std::uint32_t k = 0; k < kSides; ++k) {
      add({middle, ring.first + k, ring.first + (k + 1) % kSides}, {normal, normal, normal},
          {site.value, site.value, site.value});
    }
  }

  void add(const std::array<std::uint32_t, 3>& corners,
           const std::array<Eigen::Vector3f, 3>& normals, const std::array<float, 3>& values) {
    Surface::Triangle triangle;
    triangle.corners = corners;
    triangle.normals = normals;
    triangle.values = values;
    surface_.triangles.push_back(triangle);
  }

  double radius_;
  Surface& surface_;
};

// A ball of radius 1: an octahedron's faces, each cut into `n` x `n` triangles.
Surface unit_ball(std::uint32_t n) {
  Surface ball;
  const auto corner = [&](const Vec3& direction) {
    ball.places.push_back(direction.normalized());
    return static_cast<std::uint32_t>(ball.places.size() - 1);
  };
  for (unsigned octant = 0; octant < 8; ++octant) {
    const auto sign = [&](unsigned bit) { return (octant >> bit & 1U) != 0 ? -1.0 : 1.0; };
    const Vec3 size(sign(0), sign(1), sign(2));
    std::vector<std::vector<std::uint32_t>> rows(n + 1);
    for (std::uint32_t i = 0; i <= n; ++i)
      for (std::uint32_t j = 0; i + j <= n; ++j)
        rows[i].push_back(corner(size.cwiseProduct(Vec3(i, j, n - i - j))));
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      Surface::Triangle triangle;
      triangle.corners = {a, b, c};
      for (std::size_t k = 0; k < 3; ++k)
        triangle.normals[k] = ball.places[triangle.corners[k]].cast<float>();
      ball.triangles.push_back(triangle);
    };
    for (std::uint32_t i = 0; i < n; ++i) {
      for (std::uint32_t j = 0; i + j < n; ++j) {
        add(rows[i][j], rows[i][j + 1], rows[i + 1][j]);
        if (i + j + 1 < n) add(rows[i][j + 1], rows[i + 1][j + 1], rows[i + 1][j]);
      }
    }
  }
  return ball;
}

LinesAndPoints lines_and_points(const model::ModelRun& run) {
  const Dataset& dataset = run.dataset;
  const auto chosen = model::choose_arrays(run);
  const bool is_of_cells = dataset.kind == DatasetKind::kMesh && chosen.is_cell_data;
  const MeshNodes nodes = model::load_nodes(run);
  if (dataset.kind == DatasetKind::kParticles) {
    const auto values = model::load_values(run, chosen, dataset.num_positions(), "points");
    LinesAndPoints all;
    for (std::uint32_t i = 0; i < nodes.count(); ++i)
      if (nodes.is_placed(i)) all.points.push_back({nodes.at(i), values.columns.back()[i]});
    return all;
  }
  const MeshCells cells = model::load_cells(run);
  const auto num_sites =
      is_of_cells ? static_cast<std::int64_t>(cells.count()) : dataset.num_positions();
  const auto values = model::load_values(run, chosen, num_sites, is_of_cells ? "cells" : "nodes");
  return collect(nodes, cells, values.columns.back(), is_of_cells);
}

}  // namespace

std::shared_ptr<const Surface> make_tubes(const Dataset& dataset, double radius,
                                          const KernelModelOptions& options,
                                          std::stop_token stop) try {
  if (!(radius >= 0) || !std::isfinite(radius))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("radius = {}: must be finite, and 0 or more", radius));
  if (dataset.kind != DatasetKind::kMesh && dataset.kind != DatasetKind::kParticles) return nullptr;
  KernelModelReport report;
  const LinesAndPoints all = lines_and_points({dataset, options, report, 1, stop});
  if (all.lines.empty() && all.points.empty()) return nullptr;
  const Surface ball = unit_ball(all.points.size() > kMostFineBalls ? 3 : 6);
  std::size_t count = ball.triangles.size() * all.points.size();
  for (const Line& line : all.lines) count += 2 * kSides * line.size();
  if (count > kMostTriangles) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format("'{}': {} lines and {} points would be {} triangles, at most {} are "
                    "drawn: points are drawn as data of their own",
                    dataset.source, all.lines.size(), all.points.size(), count, kMostTriangles));
  }
  auto surface = std::make_shared<Surface>();
  surface->triangles.reserve(count);
  TubeBuilder builder(radius > 0 ? radius : usual_radius(all), *surface);
  for (const Line& line : all.lines) {
    if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "making tubes was cancelled");
    builder.add_tube(line);
  }
  for (const Site& point : all.points) builder.add_ball(point, ball);
  return surface;
} catch (const std::bad_alloc&) {
  data::throw_out_of_memory("tubes around lines", 0);
}

}  // namespace ovoid
