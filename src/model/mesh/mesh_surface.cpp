// SPDX-License-Identifier: Apache-2.0
// The boundary of a mesh: faces of solid cells that no other cell shares, and flat cells; of boxes,
// what is left of their faces where no other box goes on (model/mesh/boxes.h).
#include "model/mesh/mesh_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "data/kernels/letters.h"
#include "data/out_of_memory.h"
#include "model/mesh/boxes.h"
#include "model/mesh/local_mesh.h"
#include "model/team/team_run.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/surface.h"

namespace ovoid {
namespace {

using model::LocalMesh;
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
template <class PlaceOf>
Vec3 area_vector(std::span<const std::uint32_t> corners, const PlaceOf& place_of) {
  Vec3 area = Vec3::Zero();
  const Vec3 origin = place_of(corners[0]);
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    area += (place_of(corners[i]) - origin).cross(place_of(corners[i + 1]) - origin);
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
  const Vec3 area = area_vector(corners, [&](std::uint32_t node) { return nodes.at(node); });
  if (area.dot(outwards) < 0) std::reverse(corners.begin(), corners.end());
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

// Outer faces as they are drawn: from outside counterclockwise, a value at each corner.
struct OuterFaces {
  std::vector<Vec3> places;
  std::vector<std::uint32_t> sizes;     // corners of each face
  std::vector<std::uint8_t> are_solid;  // faces of solid cells
  std::vector<std::uint32_t> corners;   // of all faces
  std::vector<float> values;            // at the corners
  // In a team: the least three of its nodes' numbers in the whole, by which one process sorts
  // faces.
  std::vector<std::array<std::uint64_t, 3>> keys;

  std::size_t count() const noexcept { return sizes.size(); }
};

// A face is its corners' least place's owner's, who has all cells that may share it.
bool owns_face(const LocalMesh& mesh, const std::vector<std::uint32_t>& corners) {
  const auto place = [&](std::uint32_t node) {
    const Vec3 at = mesh.nodes.at(node);
    return std::tuple(at[0], at[1], at[2]);
  };
  return mesh.owns_node(
      *std::min_element(corners.begin(), corners.end(),
                        [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); }));
}

std::array<std::uint64_t, 3> key_in_whole(const LocalMesh& mesh,
                                          const std::vector<std::uint32_t>& corners) {
  std::vector<std::uint64_t> numbers;
  numbers.reserve(corners.size());
  for (const std::uint32_t corner : corners) numbers.push_back(mesh.numbers[corner]);
  std::array<std::uint64_t, 3> key{};
  std::partial_sort_copy(numbers.begin(), numbers.end(), key.begin(), key.end());
  return key;
}

// Leaves the places of corners, numbered in the order in which they are met. `place_of(number)`:
// those that the corners say, `num_places` of them.
template <class PlaceOf>
void number_as_met(std::size_t num_places, const PlaceOf& place_of, OuterFaces& outer) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number_of(num_places, kNone);
  std::vector<Vec3> places;
  for (std::uint32_t& corner : outer.corners) {
    std::uint32_t& number = number_of[corner];
    if (number == kNone) {
      number = static_cast<std::uint32_t>(places.size());
      places.push_back(place_of(corner));
    }
    corner = number;
  }
  outer.places = std::move(places);
}

OuterFaces outer_faces_of(const model::ModelRun& run, const LocalMesh& mesh,
                          const std::vector<Face>& faces) {
  // Colour's, if that is another.
  const std::vector<float>& column = mesh.values.columns.back();
  OuterFaces outer;
  std::vector<std::uint32_t> corners;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (f % 65536 == 0) require_running(run.stop);
    corners_of(mesh.nodes, mesh.cells, faces[f], corners);
    if (!owns_face(mesh, corners)) continue;
    if (run.team != nullptr) outer.keys.push_back(key_in_whole(mesh, corners));
    const bool is_solid = faces[f].number != kFlat;
    if (is_solid) turn_outwards(mesh.nodes, mesh.cells, faces[f], corners);
    for (const std::uint32_t corner : corners) {
      outer.corners.push_back(corner);
      outer.values.push_back(column[mesh.is_cell_data ? faces[f].cell : corner]);
    }
    outer.sizes.push_back(static_cast<std::uint32_t>(corners.size()));
    outer.are_solid.push_back(is_solid ? 1 : 0);
  }
  number_as_met(
      mesh.nodes.count(), [&](std::uint32_t node) { return mesh.nodes.at(node); }, outer);
  return outer;
}

// In one process' order.
OuterFaces sorted_by_keys(const OuterFaces& faces) {
  std::vector<std::size_t> firsts = {0};
  for (const std::uint32_t size : faces.sizes) firsts.push_back(firsts.back() + size);
  std::vector<std::size_t> order(faces.count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return faces.keys[a] < faces.keys[b]; });
  OuterFaces sorted;
  for (const std::size_t f : order) {
    sorted.sizes.push_back(faces.sizes[f]);
    sorted.are_solid.push_back(faces.are_solid[f]);
    for (std::size_t i = firsts[f]; i < firsts[f + 1]; ++i) {
      sorted.corners.push_back(faces.corners[i]);
      sorted.values.push_back(faces.values[i]);
    }
  }
  number_as_met(
      faces.places.size(), [&](std::uint32_t place) { return faces.places[place]; }, sorted);
  return sorted;
}

// Those of all processes; places that several have are one.
OuterFaces outer_faces_of_all(const model::ModelRun& run, OuterFaces own) {
  if (run.team == nullptr) return own;
  data::Letter letter;
  const std::array<std::uint64_t, 3> counts{own.places.size(), own.sizes.size(),
                                            own.corners.size()};
  data::append(letter, std::span<const std::uint64_t>(counts));
  data::append(letter, std::span<const Vec3>(own.places));
  data::append(letter, std::span<const std::uint32_t>(own.sizes));
  data::append(letter, std::span<const std::uint8_t>(own.are_solid));
  data::append(letter, std::span<const std::array<std::uint64_t, 3>>(own.keys));
  data::append(letter, std::span<const std::uint32_t>(own.corners));
  data::append(letter, std::span<const float>(own.values));
  own = {};
  OuterFaces all;
  std::unordered_map<Vec3, std::uint32_t, model::PlaceHash> numbers;
  for (data::Letter& from : data::gathered_letters(*run.team, letter)) {
    data::LetterReader reader(from);
    std::vector<std::uint64_t> num;
    std::vector<Vec3> places;
    reader.take(3, num);
    reader.take(num[0], places);
    reader.take(num[1], all.sizes);
    reader.take(num[1], all.are_solid);
    reader.take(num[1], all.keys);
    const std::size_t first = all.corners.size();
    reader.take(num[2], all.corners);
    reader.take(num[2], all.values);
    std::vector<std::uint32_t> number_of;
    number_of.reserve(places.size());
    for (const Vec3& place : places) {
      const auto next = static_cast<std::uint32_t>(all.places.size());
      const auto [found, is_new] = numbers.try_emplace(place, next);
      if (is_new) all.places.push_back(place);
      number_of.push_back(found->second);
    }
    for (std::size_t i = first; i < all.corners.size(); ++i)
      all.corners[i] = number_of[all.corners[i]];
    from = {};
  }
  return sorted_by_keys(all);
}

// The faces around each place, as a list of lists.
class FacesAround {
 public:
  explicit FacesAround(const OuterFaces& outer) : first_(outer.places.size() + 1) {
    std::size_t begin = 0;
    for (const std::uint32_t size : outer.sizes) {
      const auto corners = std::span(outer.corners).subspan(begin, size);
      areas_.push_back(
          area_vector(corners, [&](std::uint32_t corner) { return outer.places[corner]; }));
      for (const std::uint32_t corner : corners) ++first_[corner + 1];
      begin += size;
    }
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    faces_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    begin = 0;
    for (std::uint32_t f = 0; f < outer.count(); ++f) {
      for (const std::uint32_t corner : std::span(outer.corners).subspan(begin, outer.sizes[f]))
        faces_[next[corner]++] = f;
      begin += outer.sizes[f];
    }
  }

  // At a corner of a face: the mean over what goes on smoothly from it.
  Eigen::Vector3f normal_at(std::uint32_t corner, std::size_t face) const {
    static const double kSmooth = std::cos(Surface::kFeatureAngle * std::numbers::pi / 180);
    const Vec3 own = areas_[face].normalized();
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = first_[corner]; i < first_[corner + 1]; ++i) {
      const Vec3& area = areas_[faces_[i]];
      // Flat cells turn either way.
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

// Each face a fan of triangles.
void add_fans(const OuterFaces& outer, const std::stop_token& stop, Surface& surface) {
  const FacesAround around(outer);
  std::size_t first = 0;
  for (std::size_t f = 0; f < outer.count(); ++f) {
    if (f % 65536 == 0) require_running(stop);
    const std::uint32_t size = outer.sizes[f];
    for (std::uint32_t i = 1; i + 1 < size; ++i) {
      Surface::Triangle triangle;
      triangle.is_boundary = outer.are_solid[f] != 0;
      const std::array<std::size_t, 3> fan{first, first + i, first + i + 1};
      for (std::size_t c = 0; c < 3; ++c) {
        triangle.corners[c] = outer.corners[fan[c]];
        triangle.normals[c] = around.normal_at(triangle.corners[c], f);
        triangle.values[c] = outer.values[fan[c]];
      }
      triangle.edges =
          static_cast<std::uint8_t>((i == 1 ? 1U : 0U) | 2U | (i + 2 == size ? 4U : 0U));
      surface.triangles.push_back(triangle);
    }
    first += size;
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

// Of all processes, in their order.
Surface joined_surface(const model::ModelRun& run, Surface own) {
  if (run.team == nullptr) return own;
  Surface all;
  data::Letter letter;
  data::append(letter, std::span<const Surface::Triangle>(own.triangles));
  const auto triangles = data::gathered_letters(*run.team, letter);
  const auto places = data::gathered(*run.team, std::span<const Vec3>(own.places));
  for (std::size_t p = 0; p < places.size(); ++p) {
    const auto before = static_cast<std::uint32_t>(all.places.size());
    const std::size_t first = all.triangles.size();
    data::LetterReader(triangles[p])
        .take(triangles[p].size() / sizeof(Surface::Triangle), all.triangles);
    for (std::size_t t = first; t < all.triangles.size(); ++t) {
      for (std::uint32_t& corner : all.triangles[t].corners) corner += before;
    }
    all.places.insert(all.places.end(), places[p].begin(), places[p].end());
  }
  for (const Vec3& place : all.places) all.bounds.extend(place);
  return all;
}

}  // namespace

namespace model {

std::shared_ptr<const Surface> surface_of_boxes(const ModelRun& run, const LocalBoxes& local) {
  const double least_edge = least_of(run, least_edge_of(local.boxes));
  std::vector<BoxFace> faces = outer_faces(with_neighbors(run, local.boxes), least_edge, run.stop);
  std::erase_if(faces, [&](const BoxFace& face) { return face.box >= local.boxes.count(); });
  Surface own;
  add_box_faces(faces, local.values.columns.back(), own);
  auto surface = std::make_shared<const Surface>(joined_surface(run, std::move(own)));
  return surface->triangles.empty() ? nullptr : surface;
}

std::shared_ptr<const Surface> surface_of_mesh(const ModelRun& run, const LocalMesh& mesh) {
  std::vector<Face> faces = faces_of(mesh.nodes, mesh.cells, run.stop);
  keep_outer(faces);
  const OuterFaces outer = outer_faces_of_all(run, outer_faces_of(run, mesh, faces));
  const auto& types = mesh.cells.types;
  const bool leaves_out = std::find(types.begin(), types.end(), CellType::kOther) != types.end();
  const bool any_leaves_out = greatest_of(run, leaves_out ? 1 : 0) > 0;
  if (outer.count() == 0) return nullptr;
  auto surface = std::make_shared<Surface>();
  surface->leaves_out_cells = any_leaves_out;
  add_fans(outer, run.stop, *surface);
  surface->places = outer.places;
  for (const Vec3& place : outer.places) surface->bounds.extend(place);
  return surface;
}

}  // namespace model

std::shared_ptr<const Surface> make_surface(const Dataset& dataset,
                                            const KernelModelOptions& options,
                                            std::stop_token stop) try {
  const bool is_boxes = dataset.kind == DatasetKind::kBoxes;
  if (dataset.kind != DatasetKind::kMesh && !is_boxes) return nullptr;
  KernelModelReport report;
  const model::ModelRun run{dataset, options, report, 1, stop};
  const auto chosen = model::choose_arrays(run);
  return is_boxes ? model::surface_of_boxes(run, model::load_local_boxes(run, chosen))
                  : model::surface_of_mesh(run, model::load_local_mesh(run, chosen));
} catch (const std::bad_alloc&) {
  data::throw_out_of_memory("the surface of a mesh", 0);
}

}  // namespace ovoid
