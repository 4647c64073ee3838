// SPDX-License-Identifier: Apache-2.0
// The box around a volume. A convex box needs no depth to be drawn rightly through what it holds:
// edges between two faces that look away from the eye lie behind all of it, the others before all
// of it or at its outline.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "annotate/lettering.h"
#include "annotate/projection.h"
#include "annotate/ticks.h"
#include "ovoid/annotate.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

using annotate::Ink;
using annotate::Lettering;
using annotate::Measures;
using annotate::Projection;
using annotate::Vec2;

constexpr double kBehindOpacity = 0.55;  // of edges behind the volume: dimmed, for depth
constexpr double kTickDistance = 0.55;   // of labels from their edge, in sizes of the text
constexpr double kShortEdge = 4.0;       // edges shorter than this get no labels, in sizes
constexpr double kLeftOverLow = 0.5;     // what a pixel to the left is worth, in pixels down
constexpr double kParallelSine = 1e-6;   // axes that deviate less are parallel

struct Edge {
  Vec3 a, b;        // world; a at the lower end of the box's axis
  bool is_behind;   // both its faces look away
  bool is_outline;  // one looks to the eye, the other away
  std::optional<std::pair<Vec2, Vec2>> pixels;
};

class BoxDrawing {
 public:
  BoxDrawing(Image& image, const Projection& projection, const Box& box, const Measures& measures);

  void draw(const std::string& unit);

 private:
  Vec3 corner(const std::array<int, 3>& side) const;
  bool looks_to_eye(int axis, int side) const;
  Edge edge(int axis, int side_1, int side_2) const;
  const Edge* labelled_edge(int axis) const;
  std::optional<int> world_axis(int axis) const;
  void label_axis(Ink& ink, int axis, const std::string& unit) const;
  void write_beside(Ink& ink, const std::string& text, const Vec2& at, const Vec2& outward) const;

  Image& image_;
  const Projection& projection_;
  const Box& box_;
  const Measures& m_;
  std::array<std::array<Edge, 4>, 3> edges_;  // [axis, around]
  Vec2 middle_;                               // of the visible edges, pixels
};

BoxDrawing::BoxDrawing(Image& image, const Projection& projection, const Box& box,
                       const Measures& measures)
    : image_(image), projection_(projection), box_(box), m_(measures) {
  Vec2 sum = Vec2::Zero();
  int count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 4; ++i) {
      Edge& made = edges_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(i)];
      made = edge(axis, i & 1, i >> 1);
      if (!made.pixels) continue;
      sum += made.pixels->first + made.pixels->second;
      count += 2;
    }
  }
  middle_ = count > 0 ? Vec2(sum / count) : Vec2::Zero();
}

Vec3 BoxDrawing::corner(const std::array<int, 3>& side) const {
  Vec3 at;
  for (int a = 0; a < 3; ++a) {
    at[a] = side[static_cast<std::size_t>(a)] == 0 ? box_.bounds.min()[a] : box_.bounds.max()[a];
  }
  return box_.world_from_box * at;
}

// The face at the low or high end of an axis; right for oblique and left-handed boxes, too.
bool BoxDrawing::looks_to_eye(int axis, int side) const {
  std::array<int, 3> at{};
  at[static_cast<std::size_t>(axis)] = side;
  const Vec3 on_face = corner(at);
  const Mat3 box_from_world = box_.world_from_box.linear().inverse();
  const double outward = box_from_world.row(axis).dot(projection_.towards_eye(on_face));
  return (side == 0 ? -outward : outward) > 0;
}

Edge BoxDrawing::edge(int axis, int side_1, int side_2) const {
  const int axis_1 = (axis + 1) % 3;
  const int axis_2 = (axis + 2) % 3;
  std::array<int, 3> at{};
  at[static_cast<std::size_t>(axis_1)] = side_1;
  at[static_cast<std::size_t>(axis_2)] = side_2;
  Edge made;
  made.a = corner(at);
  at[static_cast<std::size_t>(axis)] = 1;
  made.b = corner(at);
  const bool first = looks_to_eye(axis_1, side_1);
  const bool second = looks_to_eye(axis_2, side_2);
  made.is_behind = !first && !second;
  made.is_outline = first != second;
  made.pixels = projection_.line(made.a, made.b);
  return made;
}

// At the outline, where labels have room outside: low, or else left, away from the colour bar.
const Edge* BoxDrawing::labelled_edge(int axis) const {
  const Edge* best = nullptr;
  double best_score = 0;
  for (const Edge& edge : edges_[static_cast<std::size_t>(axis)]) {
    if (!edge.is_outline || !edge.pixels) continue;
    const auto& [a, b] = *edge.pixels;
    if ((b - a).norm() < kShortEdge * m_.text) continue;
    const Vec2 mean = (a + b) / 2;
    const double score = mean.y() - kLeftOverLow * mean.x();
    if (best == nullptr || score > best_score + 1e-6) {
      best = &edge;
      best_score = score;
    }
  }
  return best;
}

// The world axis to which an axis of the box is parallel, if all of them are to one.
std::optional<int> BoxDrawing::world_axis(int axis) const {
  const Mat3 axes = box_.world_from_box.linear().colwise().normalized();
  std::optional<int> found;
  for (int b = 0; b < 3; ++b) {
    int world = 0;
    axes.col(b).cwiseAbs().maxCoeff(&world);
    if ((axes.col(b).cwiseAbs() - Vec3::Unit(world)).norm() > kParallelSine) return std::nullopt;
    if (b == axis) found = world;
  }
  return found;
}

void BoxDrawing::write_beside(Ink& ink, const std::string& text, const Vec2& at,
                              const Vec2& outward) const {
  const Lettering letters(text, m_.text);
  // The text's own rectangle touches the line at `at` from outside.
  const Vec2 half(letters.width() / 2, letters.cap_height() / 2);
  Vec2 middle = at + outward * (kTickDistance * m_.text) +
                Vec2(outward.x() * half.x(), outward.y() * half.y());
  // What is in sight is named in sight.
  const Vec2 size(image_.width, image_.height);
  if (at.x() >= 0 && at.y() >= 0 && at.x() <= size.x() && at.y() <= size.y()) {
    const Vec2 least = half + Vec2::Constant(0.3 * m_.text);
    middle = middle.cwiseMin(size - least).cwiseMax(least);
  }
  letters.write_at(ink, middle, 0.5);
}

void BoxDrawing::label_axis(Ink& ink, int axis, const std::string& unit) const {
  const Edge* const edge = labelled_edge(axis);
  if (edge == nullptr) return;
  const auto& [a, b] = *edge->pixels;
  Vec2 outward = Vec2(a.y() - b.y(), b.x() - a.x()).normalized();
  if (outward.dot((a + b) / 2 - middle_) < 0) outward = -outward;
  const double length = (edge->b - edge->a).norm();
  const double resolution = length > 0 ? length / 1000 : 0;
  const std::string after = unit.empty() ? "" : " " + unit;
  const std::optional<int> world = world_axis(axis);
  if (!world) {
    constexpr std::array<const char*, 3> kIndexNames = {"i", "j", "k"};
    write_beside(ink,
                 fmt::format("{} {}{}", kIndexNames[static_cast<std::size_t>(axis)],
                             annotate::number_text(length, resolution), after),
                 (a + b) / 2, outward);
    return;
  }
  constexpr std::array<const char*, 3> kWorldNames = {"x", "y", "z"};
  const Vec2 inset = (b - a).normalized() * std::min(1.2 * m_.text, 0.2 * (b - a).norm());
  write_beside(ink, annotate::number_text(edge->a[*world], resolution), a + inset, outward);
  write_beside(ink, annotate::number_text(edge->b[*world], resolution), b - inset, outward);
  const std::string name = kWorldNames[static_cast<std::size_t>(*world)];
  write_beside(ink, unit.empty() ? name : fmt::format("{} ({})", name, unit), (a + b) / 2, outward);
}

void BoxDrawing::draw(const std::string& unit) {
  Ink behind(image_.width, image_.height, m_.halo);
  Ink before(image_.width, image_.height, m_.halo);
  for (const std::array<Edge, 4>& parallel : edges_) {
    for (const Edge& edge : parallel) {
      if (!edge.pixels) continue;
      (edge.is_behind ? behind : before).line(edge.pixels->first, edge.pixels->second, m_.pen);
    }
  }
  annotate::Paint dimmed = m_.paint;
  dimmed.opacity = kBehindOpacity;
  behind.under(image_, dimmed);
  for (int axis = 0; axis < 3; ++axis) label_axis(before, axis, unit);
  before.over(image_, m_.paint);
}

}  // namespace

void draw_bounding_box(Image& image, const Camera& camera, const Box& box, const std::string& unit,
                       const MarkStyle& style) {
  const Measures measures = annotate::measures_of(image, style);
  const Vec3 size = box.bounds.max() - box.bounds.min();
  const double volume = box.world_from_box.linear().determinant();
  if (!(size.minCoeff() > 0) || !size.allFinite() || !std::isfinite(volume) || volume == 0) {
    throw Error(ErrorCode::kInvalidArgument,
                "box: must be finite, not empty, and its axes not in one plane");
  }
  const Projection projection(camera, image.width, image.height);
  BoxDrawing(image, projection, box, measures).draw(unit);
}

}  // namespace ovoid
