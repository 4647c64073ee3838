// SPDX-License-Identifier: Apache-2.0
// The boundary of a mesh: faces of solid cells that no other cell shares, and flat cells; of boxes,
// what is left of their faces where no other box goes on (model/boxes.h).
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>

#include "data/out_of_memory.h"
#include "model/boxes.h"
#include "model/mesh_cells.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/surface.h"

namespace ovoid {
namespace {

using model::MeshCells;
using model::MeshNodes;

// A face of a cell, by its place in lists of nodes. Two cells share a face if they have the same
// three least nodes of it: more of a face's nodes cannot differ in a mesh that is one.
struct Face {
  std::array<std::uint32_t, 3> key{};  // rising
  std::uint32_t cell = 0;
  std::uint8_t number = 0;  // of the cell's table; of flat cells kFlat
};
constexpr std::uint8_t kFlat = 255;

bool has_key_before(const Face& a, const Face& b) {
  return std::tie(a.key, a.cell, a.number) < std::tie(b.key, b.cell, b.number);
}

// The corners of a face of a cell, in order around it, nodes of one place merged, no node twice in
// a row.
void corners_of(const MeshNodes& nodes, const MeshCells& cells, const Face& face,
                std::vector<std::uint32_t>& corners) {
  corners.clear();
  const auto cell = cells.nodes(face.cell);
  const auto add = [&](std::uint32_t node) {
    const std::uint32_t merged = nodes.stands_for(node);
    if (corners.empty() || corners.back() != merged) corners.push_back(merged);
  };
  if (face.number == kFlat) {
    for (const std::uint32_t node : cell) add(node);
  } else {
    for (const std::uint8_t local : model::table_of(cells.types[face.cell]).faces[face.number])
      add(cell[local]);
  }
  while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
}

bool is_placed(const MeshNodes& nodes, const std::vector<std::uint32_t>& corners) {
  return std::all_of(corners.begin(), corners.end(),
                     [&](std::uint32_t node) { return nodes.is_placed(node); });
}

// Newell's: half of the sum of cross products, so that length is area, flat or not.
Vec3 area_vector(const MeshNodes& nodes, const std::vector<std::uint32_t>& corners) {
  Vec3 area = Vec3::Zero();
  const Vec3 origin = nodes.at(corners[0]);
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    area += (nodes.at(corners[i]) - origin).cross(nodes.at(corners[i + 1]) - origin);
  return 0.5 * area;
}

// Turns a solid cell's face so that from outside its corners go counterclockwise. Cells may be
// inside out: outside is away from the middle of the cell, whatever its table says.
void turn_outwards(const MeshNodes& nodes, const MeshCells& cells, const Face& face,
                   std::vector<std::uint32_t>& corners) {
  Vec3 middle = Vec3::Zero();
  for (const std::uint32_t corner : corners) middle += nodes.at(corner);
  middle /= static_cast<double>(corners.size());
  const Vec3 outwards = middle - model::moments_of(nodes, cells.nodes(face.cell)).mean;
  if (area_vector(nodes, corners).dot(outwards) < 0) std::reverse(corners.begin(), corners.end());
}

void require_running(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "making a surface was cancelled");
}

// Every face of every cell, those of the same key side by side.
std::vector<Face> faces_of(const MeshNodes& nodes, const MeshCells& cells,
                           const std::stop_token& stop) {
  std::vector<Face> faces;
  std::vector<std::uint32_t> corners;
  const auto add = [&](std::size_t cell, std::uint8_t number) {
    Face face{{}, static_cast<std::uint32_t>(cell), number};
    corners_of(nodes, cells, face, corners);
    if (corners.size() < 3 || !is_placed(nodes, corners)) return;
    std::partial_sort_copy(corners.begin(), corners.end(), face.key.begin(), face.key.end());
    faces.push_back(face);
  };
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    const CellType type = cells.types[cell];
    const auto num_faces = model::table_of(type).faces.size();
    for (std::size_t f = 0; f < num_faces; ++f) add(cell, static_cast<std::uint8_t>(f));
    if (type == CellType::kTriangle || type == CellType::kQuad) add(cell, kFlat);
    if (cell % 65536 == 0) require_running(stop);
  }
  std::sort(faces.begin(), faces.end(), has_key_before);
  return faces;
}

// Faces of solid cells that are there once, and all flat ones.
void keep_outer(std::vector<Face>& faces) {
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < faces.size();) {
    std::size_t end = begin;
    std::size_t num_solid = 0;
    while (end < faces.size() && faces[end].key == faces[begin].key) {
      if (faces[end++].number != kFlat) ++num_solid;
    }
    for (std::size_t i = begin; i < end; ++i) {
      if (faces[i].number == kFlat || num_solid == 1) faces[kept++] = faces[i];
    }
    begin = end;
  }
  faces.resize(kept);
}

// The faces around each node, as a list of lists.
class FacesAround {
 public:
  FacesAround(const MeshNodes& nodes, const MeshCells& cells, const std::vector<Face>& faces)
      : first_(nodes.count() + 1) {
    std::vector<std::uint32_t> corners;
    for (const Face& face : faces) {
      corners_of(nodes, cells, face, corners);
      areas_.push_back(area_vector(nodes, corners));
      for (const std::uint32_t node : corners) ++first_[node + 1];
    }
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    faces_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      corners_of(nodes, cells, faces[f], corners);
      for (const std::uint32_t node : corners) faces_[next[node]++] = static_cast<std::uint32_t>(f);
    }
  }

  // At a corner of a face: the mean over what goes on smoothly from it.
  Eigen::Vector3f normal_at(std::uint32_t node, std::size_t face) const {
    static const double kSmooth = std::cos(Surface::kFeatureAngle * std::numbers::pi / 180);
    const Vec3 own = areas_[face].normalized();
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = first_[node]; i < first_[node + 1]; ++i) {
      const Vec3& area = areas_[faces_[i]];
      // Flat cells, and cells inside out, turn either way.
      const double cosine = own.dot(area.normalized());
      if (std::abs(cosine) >= kSmooth) sum += cosine < 0 ? Vec3(-area) : area;
    }
    return (sum.norm() > 0 ? sum.normalized() : own).cast<float>();
  }

 private:
  std::vector<Vec3> areas_;
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> faces_;
};

// Places are kept where a corner is, numbered in the order in which they are met.
class Places {
 public:
  explicit Places(const MeshNodes& nodes) : nodes_(nodes), number_of_(nodes.count(), kNone) {}

  std::uint32_t number_of(std::uint32_t node, Surface& surface) {
    std::uint32_t& number = number_of_[node];
    if (number == kNone) {
      number = static_cast<std::uint32_t>(surface.places.size());
      surface.places.push_back(nodes_.at(node));
      surface.bounds.extend(surface.places.back());
    }
    return number;
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const MeshNodes& nodes_;
  std::vector<std::uint32_t> number_of_;
};

struct FaceBuilder {
  const std::vector<float>& column;  // values of what gives colour
  bool is_of_cells;                  // a value per cell, else per node
  std::stop_token stop;
};

void add_faces(const MeshNodes& nodes, const MeshCells& cells, const std::vector<Face>& faces,
               const FaceBuilder& builder, Surface& surface) {
  const FacesAround around(nodes, cells, faces);
  Places places(nodes);
  std::vector<std::uint32_t> corners;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (f % 65536 == 0) require_running(builder.stop);
    corners_of(nodes, cells, faces[f], corners);
    const bool is_boundary = faces[f].number != kFlat;
    if (is_boundary) turn_outwards(nodes, cells, faces[f], corners);
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
      Surface::Triangle triangle;
      triangle.is_boundary = is_boundary;
      const std::array<std::uint32_t, 3> fan{corners[0], corners[i], corners[i + 1]};
      for (std::size_t c = 0; c < 3; ++c) {
        triangle.corners[c] = places.number_of(fan[c], surface);
        triangle.normals[c] = around.normal_at(fan[c], f);
        triangle.values[c] = builder.column[builder.is_of_cells ? faces[f].cell : fan[c]];
      }
      triangle.edges =
          static_cast<std::uint8_t>((i == 1 ? 1U : 0U) | 2U | (i + 2 == corners.size() ? 4U : 0U));
      surface.triangles.push_back(triangle);
    }
  }
}

// The corners of a rectangle, from outside counterclockwise, and the bit of BoxFace::own_sides that
// each side, from a corner to the next, has.
struct BoxCorner {
  bool is_hi_first, is_hi_second;
  unsigned side;
};
constexpr std::array<BoxCorner, 4> kUpperCorners = {
    {{false, false, 2}, {true, false, 1}, {true, true, 3}, {false, true, 0}}};
constexpr std::array<BoxCorner, 4> kLowerCorners = {
    {{false, false, 0}, {false, true, 3}, {true, true, 1}, {true, false, 2}}};

void add_box_faces(const std::vector<model::BoxFace>& faces, const std::vector<float>& column,
                   Surface& surface) {
  for (const model::BoxFace& face : faces) {
    const auto first = static_cast<std::uint32_t>(surface.places.size());
    const auto& corners = face.is_upper ? kUpperCorners : kLowerCorners;
    std::array<bool, 4> is_edge{};
    for (std::size_t c = 0; c < 4; ++c) {
      Vec3 place;
      place[face.axis] = face.place;
      place[(face.axis + 1) % 3] = (corners[c].is_hi_first ? face.hi : face.lo)[0];
      place[(face.axis + 2) % 3] = (corners[c].is_hi_second ? face.hi : face.lo)[1];
      surface.places.push_back(place);
      surface.bounds.extend(place);
      is_edge[c] = (face.own_sides >> corners[c].side & 1U) != 0;
    }
    Surface::Triangle triangle;
    triangle.is_boundary = true;
    triangle.normals.fill((face.is_upper ? 1.0F : -1.0F) * Eigen::Vector3f::Unit(face.axis));
    triangle.values.fill(column[face.box]);
    triangle.corners = {first, first + 1, first + 2};
    triangle.edges = static_cast<std::uint8_t>((is_edge[0] ? 1U : 0U) | (is_edge[1] ? 2U : 0U));
    surface.triangles.push_back(triangle);
    triangle.corners = {first, first + 2, first + 3};
    triangle.edges = static_cast<std::uint8_t>((is_edge[2] ? 2U : 0U) | (is_edge[3] ? 4U : 0U));
    surface.triangles.push_back(triangle);
  }
}

std::shared_ptr<const Surface> surface_of_boxes(const model::ModelRun& run,
                                                const model::ChosenArrays& chosen) {
  const model::Boxes boxes = model::load_boxes(run);
  const std::vector<model::BoxFace> faces = model::outer_faces(boxes, run.stop);
  if (faces.empty()) return nullptr;
  const model::SiteValues values =
      model::load_values(run, chosen, static_cast<std::int64_t>(boxes.count()), "cells");
  auto surface = std::make_shared<Surface>();
  add_box_faces(faces, values.columns.back(), *surface);
  return surface;
}

std::shared_ptr<const Surface> surface_of_mesh(const model::ModelRun& run,
                                               const model::ChosenArrays& chosen) {
  const MeshNodes nodes = model::load_nodes(run);
  const MeshCells cells = model::load_cells(run);
  std::vector<Face> faces = faces_of(nodes, cells, run.stop);
  keep_outer(faces);
  if (faces.empty()) return nullptr;
  const bool is_of_cells = chosen.is_cell_data;
  const std::int64_t num_sites =
      is_of_cells ? static_cast<std::int64_t>(cells.count()) : run.dataset.num_positions();
  const model::SiteValues values =
      model::load_values(run, chosen, num_sites, is_of_cells ? "cells" : "nodes");
  auto surface = std::make_shared<Surface>();
  surface->leaves_out_cells =
      std::find(cells.types.begin(), cells.types.end(), CellType::kOther) != cells.types.end();
  // Colour's, if that is another.
  add_faces(nodes, cells, faces, {values.columns.back(), is_of_cells, run.stop}, *surface);
  return surface;
}

}  // namespace

std::shared_ptr<const Surface> make_surface(const Dataset& dataset,
                                            const KernelModelOptions& options,
                                            std::stop_token stop) try {
  const bool is_boxes = dataset.kind == DatasetKind::kBoxes;
  if (dataset.kind != DatasetKind::kMesh && !is_boxes) return nullptr;
  KernelModelReport report;
  const model::ModelRun run{dataset, options, report, 1, stop};
  const auto chosen = model::choose_arrays(run);
  return is_boxes ? surface_of_boxes(run, chosen) : surface_of_mesh(run, chosen);
} catch (const std::bad_alloc&) {
  data::throw_out_of_memory("the surface of a mesh", 0);
}

}  // namespace ovoid
