// SPDX-License-Identifier: Apache-2.0
#include "model/mesh/boxes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::model {
namespace {

// Faces of one plane side by side, those that are the same among them.
bool is_face_before(const BoxFace& a, const BoxFace& b) {
  return std::tie(a.place, a.lo, a.hi, a.is_upper, a.box) <
         std::tie(b.place, b.lo, b.hi, b.is_upper, b.box);
}

// Both faces of every box that stand on an axis.
std::vector<BoxFace> faces_along(const Boxes& boxes, std::uint8_t axis, double pitch) {
  std::vector<BoxFace> faces;
  faces.reserve(2 * boxes.count());
  for (std::size_t i = 0; i < boxes.count(); ++i) {
    std::array<Vec3, 2> ends;
    for (std::size_t end = 0; end < 2; ++end) {
      const Vec3 place = boxes.center(i) + (end == 0 ? -0.5 : 0.5) * boxes.edge(i);
      ends[end] = (place.array() / pitch).round() * pitch;
    }
    if (!ends[0].allFinite() || !ends[1].allFinite()) continue;
    BoxFace face{.box = static_cast<std::uint32_t>(i), .axis = axis, .own_sides = 15};
    for (int k = 0; k < 2; ++k) {
      const int along = (axis + 1 + k) % 3;
      face.lo[static_cast<std::size_t>(k)] = ends[0][along];
      face.hi[static_cast<std::size_t>(k)] = ends[1][along];
    }
    for (const bool is_upper : {false, true}) {
      face.is_upper = is_upper;
      face.place = ends[is_upper ? 1 : 0][axis];
      faces.push_back(face);
    }
  }
  return faces;
}

// One plane's faces, cancelled against each other. Rectangles are halved at their own sides until
// within each half all are the same, or are of one kind.
class PlaneOfFaces {
 public:
  explicit PlaneOfFaces(std::vector<BoxFace>& left) : left_(left) {}

  // `faces` sorted by is_face_before.
  void cancel(std::span<const BoxFace> faces) {
    Sides sides;
    for (std::size_t begin = 0; begin < faces.size();) {
      std::size_t end = begin;
      std::size_t num_lower = 0;
      for (; end < faces.size() && is_one_rectangle(faces[begin], faces[end]); ++end)
        num_lower += faces[end].is_upper ? 0 : 1;
      // Lower ones come first.
      const std::size_t num_upper = end - begin - num_lower;
      const std::size_t num_gone = std::min(num_lower, num_upper);
      sides.lower.insert(sides.lower.end(), faces.begin() + static_cast<std::ptrdiff_t>(begin),
                         faces.begin() + static_cast<std::ptrdiff_t>(begin + num_lower - num_gone));
      sides.upper.insert(sides.upper.end(),
                         faces.begin() + static_cast<std::ptrdiff_t>(begin + num_lower + num_gone),
                         faces.begin() + static_cast<std::ptrdiff_t>(end));
      begin = end;
    }
    halve(std::move(sides));
  }

 private:
  // The two kinds.
  struct Sides {
    std::vector<BoxFace> lower, upper;
  };
  struct Rectangle {
    std::array<double, 2> lo, hi;
  };
  // A line along which nothing reaches across, or least.
  struct Cut {
    std::size_t along = 0;  // of BoxFace::lo
    double place = 0;
    std::size_t num_cut = std::numeric_limits<std::size_t>::max();
  };

  static bool is_one_rectangle(const BoxFace& a, const BoxFace& b) {
    return a.lo == b.lo && a.hi == b.hi;
  }

  static Rectangle bounds_of(const std::vector<BoxFace>& faces) {
    Rectangle all{faces.front().lo, faces.front().hi};
    for (const BoxFace& face : faces) {
      for (std::size_t k = 0; k < 2; ++k) {
        all.lo[k] = std::min(all.lo[k], face.lo[k]);
        all.hi[k] = std::max(all.hi[k], face.hi[k]);
      }
    }
    return all;
  }

  void keep(const std::vector<BoxFace>& faces) {
    left_.insert(left_.end(), faces.begin(), faces.end());
  }

  // Faces that do not meet the rectangle have nothing to be cancelled against.
  void keep_those_outside(std::vector<BoxFace>& faces, const Rectangle& rectangle) {
    std::erase_if(faces, [&](const BoxFace& face) {
      const bool meets = face.lo[0] < rectangle.hi[0] && face.hi[0] > rectangle.lo[0] &&
                         face.lo[1] < rectangle.hi[1] && face.hi[1] > rectangle.lo[1];
      if (!meets) left_.push_back(face);
      return !meets;
    });
  }

  // Through the middle one of all sides within the bounds. None where all faces are the same.
  static std::optional<Cut> best_cut(const Sides& sides) {
    Rectangle all = bounds_of(sides.lower);
    const Rectangle others = bounds_of(sides.upper);
    Cut best;
    std::vector<double> places;
    for (std::size_t k = 0; k < 2; ++k) {
      all.lo[k] = std::min(all.lo[k], others.lo[k]);
      all.hi[k] = std::max(all.hi[k], others.hi[k]);
      places.clear();
      for (const auto* faces : {&sides.lower, &sides.upper}) {
        for (const BoxFace& face : *faces) {
          if (face.lo[k] > all.lo[k]) places.push_back(face.lo[k]);
          if (face.hi[k] < all.hi[k]) places.push_back(face.hi[k]);
        }
      }
      if (places.empty()) continue;
      const auto middle = places.begin() + static_cast<std::ptrdiff_t>(places.size() / 2);
      std::nth_element(places.begin(), middle, places.end());
      std::size_t num_cut = 0;
      for (const auto* faces : {&sides.lower, &sides.upper}) {
        num_cut += static_cast<std::size_t>(std::count_if(
            faces->begin(), faces->end(),
            [&](const BoxFace& face) { return face.lo[k] < *middle && face.hi[k] > *middle; }));
      }
      if (num_cut < best.num_cut) best = {k, *middle, num_cut};
    }
    if (best.num_cut == std::numeric_limits<std::size_t>::max()) return std::nullopt;
    return best;
  }

  // Those below the cut stay, the others are returned.
  static std::vector<BoxFace> take_above(std::vector<BoxFace>& faces, const Cut& cut) {
    const std::size_t k = cut.along;
    std::vector<BoxFace> above;
    for (const BoxFace& face : faces) {
      if (face.hi[k] <= cut.place) continue;
      above.push_back(face);
      if (face.lo[k] >= cut.place) continue;
      above.back().lo[k] = cut.place;
      above.back().own_sides &= static_cast<std::uint8_t>(~(1U << (2 * k)));
    }
    std::erase_if(faces, [&](const BoxFace& face) { return face.lo[k] >= cut.place; });
    for (BoxFace& face : faces) {
      if (face.hi[k] <= cut.place) continue;
      face.hi[k] = cut.place;
      face.own_sides &= static_cast<std::uint8_t>(~(2U << (2 * k)));
    }
    return above;
  }

  void halve(Sides sides) {
    auto& [lower, upper] = sides;
    if (!lower.empty() && !upper.empty()) {
      keep_those_outside(lower, bounds_of(upper));
      if (!lower.empty()) keep_those_outside(upper, bounds_of(lower));
    }
    if (lower.empty() || upper.empty()) {
      keep(lower);
      keep(upper);
      return;
    }
    const std::optional<Cut> cut = best_cut(sides);
    if (!cut) {  // one covers the other
      auto& more = lower.size() > upper.size() ? lower : upper;
      const std::size_t num_gone = std::min(lower.size(), upper.size());
      left_.insert(left_.end(), more.begin() + static_cast<std::ptrdiff_t>(num_gone), more.end());
      return;
    }
    Sides above{take_above(lower, *cut), take_above(upper, *cut)};
    halve(std::move(sides));
    halve(std::move(above));
  }

  std::vector<BoxFace>& left_;
};

}  // namespace

Boxes load_boxes(const ModelRun& run) {
  Boxes boxes;
  boxes.centers = load_positions(run);
  DataArray named = run.dataset.box_sizes;
  if (named.name.empty()) named.name = "box sizes";
  boxes.edges = load_tuples(named, run.dataset.num_positions(), 3, "boxes");
  for (std::size_t i = 0; i < boxes.edges.size(); ++i) {
    const double edge = boxes.edges[i];
    if (!(edge > 0) || !std::isfinite(edge))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}[{}][{}] = {}: must be > 0", named.name, i / 3, i % 3, edge));
  }
  return boxes;
}

double least_edge_of(const Boxes& boxes) noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (const double edge : boxes.edges) least = std::min(least, edge);
  return least;
}

std::vector<BoxFace> outer_faces(const Boxes& boxes, double least_edge,
                                 const std::stop_token& stop) {
  std::vector<BoxFace> left;
  if (boxes.count() == 0) return left;
  // A power of two, so that places on the grid are exact.
  const double pitch = std::exp2(std::floor(std::log2(least_edge / 1000)));
  for (std::uint8_t axis = 0; axis < 3; ++axis) {
    std::vector<BoxFace> faces = faces_along(boxes, axis, pitch);
    std::sort(faces.begin(), faces.end(), is_face_before);
    PlaneOfFaces plane(left);
    for (std::size_t begin = 0; begin < faces.size();) {
      std::size_t end = begin + 1;
      while (end < faces.size() && faces[end].place == faces[begin].place) ++end;
      if (stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "finding where boxes end was cancelled");
      plane.cancel(std::span(faces).subspan(begin, end - begin));
      begin = end;
    }
  }
  return left;
}

}  // namespace ovoid::model
