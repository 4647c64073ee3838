// SPDX-License-Identifier: Apache-2.0
// The triad in the corner.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "annotate/lettering.h"
#include "annotate/projection.h"
#include "ovoid/annotate.h"

namespace ovoid {
namespace {

using annotate::Ink;
using annotate::Lettering;
using annotate::Measures;
using annotate::Vec2;

// In sizes of the text.
constexpr double kArmLength = 2.3;
constexpr double kNegativeArm = 0.62;  // of an arm, where both ends are named
constexpr double kLabelDistance = 0.75;
constexpr double kLetterGap = 0.1;  // between two letters, at least
constexpr double kCorner = 3.8;     // of the origin from both borders

// Shorter than this in the picture (of an arm) a direction can no longer be seen.
constexpr double kEndOn = 0.2;

struct Arm {
  std::array<std::string, 2> names;  // of the positive and negative ends; empty: not named
  Rgb color;
  Vec2 along;   // pixels, in the picture, of the positive end from the origin
  double away;  // of the unit vector, along the view axis: > 0 points away from the eye
  bool is_end_on;

  // With both ends named, the name of the end that is nearer to the eye.
  const std::string& end_on_name() const { return names[away > 0 && !names[1].empty() ? 1 : 0]; }
};

std::array<std::array<std::string, 2>, 3> names_of(Space space) {
  if (space == Space::kLps) return {{{"L", "R"}, {"P", "A"}, {"S", "I"}}};
  if (space == Space::kRas) return {{{"R", "L"}, {"A", "P"}, {"S", "I"}}};
  return {{{"x", ""}, {"y", ""}, {"z", ""}}};
}

// Red, green, blue of one lightness: each can be told from both inks and halos.
constexpr std::array<Rgb, 3> kColors = {Rgb{0.93, 0.30, 0.28}, Rgb{0.33, 0.72, 0.28},
                                        Rgb{0.30, 0.52, 0.98}};

class Triad {
 public:
  Triad(Image& image, const annotate::Projection& projection, Space space,
        const Measures& measures);
  void draw();

 private:
  struct End {
    const Arm* arm;
    double sign;
    double away;
    bool is_named;

    const std::string& name() const { return arm->names[sign > 0 ? 0 : 1]; }
    // From the origin, pixels.
    Vec2 tip() const { return sign * (sign > 0 ? 1.0 : kNegativeArm) * arm->along; }
  };
  Vec2 letter_place(const End& end) const;
  Vec2 end_on_letter_place() const { return origin_ + 1.0 * m_.text * free_corner(); }
  void leave_out_covered_names(std::span<End> far_to_near) const;
  void draw_arm(const End& end);
  void draw_end_on(const Arm& arm);
  Vec2 free_corner() const;
  void put(const Ink& ink, const Rgb& color);

  Image& image_;
  const Measures& m_;
  Vec2 origin_;
  std::array<Arm, 3> arms_;
};

Triad::Triad(Image& image, const annotate::Projection& projection, Space space,
             const Measures& measures)
    : image_(image), m_(measures) {
  origin_ = {std::round(kCorner * m_.text) + 0.5,
             image.height - std::round(kCorner * m_.text) - 0.5};
  const auto names = names_of(space);
  for (int a = 0; a < 3; ++a) {
    const Vec3 view = projection.turned(Vec3::Unit(a));
    const auto i = static_cast<std::size_t>(a);
    const Vec2 along = kArmLength * m_.text * Vec2(view.x(), -view.y());
    arms_[i] = {names[i], kColors[i], along, view.z(), std::hypot(view.x(), view.y()) < kEndOn};
  }
}

void Triad::put(const Ink& ink, const Rgb& color) {
  annotate::Paint paint = m_.paint;
  paint.ink = color;
  ink.over(image_, paint);
}

Vec2 Triad::letter_place(const End& end) const {
  const Vec2 tip = end.tip();
  return origin_ + tip + kLabelDistance * m_.text * tip.normalized();
}

// Of two letters that would overlap the one that lies behind stays out. Letters of arms along the
// view stand before all others.
void Triad::leave_out_covered_names(std::span<End> far_to_near) const {
  struct Letter {
    Vec2 place;
    double width, height;
  };
  std::vector<Letter> kept;
  const auto letter_of = [&](const std::string& name, const Vec2& place) {
    const Lettering letter(name, m_.text);
    return Letter{place, letter.width(), letter.cap_height()};
  };
  for (const Arm& arm : arms_) {
    if (arm.is_end_on) kept.push_back(letter_of(arm.end_on_name(), end_on_letter_place()));
  }
  const double gap = kLetterGap * m_.text;
  for (std::size_t i = far_to_near.size(); i-- > 0;) {
    End& end = far_to_near[i];
    const Letter letter = letter_of(end.name(), letter_place(end));
    end.is_named = std::none_of(kept.begin(), kept.end(), [&](const Letter& other) {
      const Vec2 apart = (letter.place - other.place).cwiseAbs();
      return apart.x() < (letter.width + other.width) / 2 + gap &&
             apart.y() < (letter.height + other.height) / 2 + gap;
    });
    if (end.is_named) kept.push_back(letter);
  }
}

void Triad::draw_arm(const End& end) {
  const Arm& arm = *end.arm;
  const Vec2 tip = end.tip();
  const Vec2 direction = tip.normalized();
  Ink ink(image_.width, image_.height, m_.halo);
  if (end.sign > 0) {
    const double head = std::min(0.75 * m_.text, 0.8 * tip.norm());
    const Vec2 across = 0.3 * m_.text * Vec2(-direction.y(), direction.x());
    const Vec2 neck = origin_ + tip - head * direction;
    ink.line(origin_, neck, 1.9 * m_.pen);
    const std::array<Vec2, 3> triangle = {Vec2(origin_ + tip), Vec2(neck + across),
                                          Vec2(neck - across)};
    ink.convex(triangle);
  } else {
    ink.line(origin_, origin_ + tip, m_.pen);
  }
  put(ink, arm.color);
  if (!end.is_named) return;
  Ink letter(image_.width, image_.height, m_.halo);
  Lettering(end.name(), m_.text).write_at(letter, letter_place(end), 0.5);
  put(letter, end.sign > 0 ? arm.color : m_.paint.ink);
}

// Of the four diagonals the one that is farthest from all arms.
Vec2 Triad::free_corner() const {
  Vec2 best(0, 0);
  double best_cosine = 2;
  for (const Vec2& diagonal : {Vec2(1, -1), Vec2(-1, -1), Vec2(-1, 1), Vec2(1, 1)}) {
    double cosine = -1;
    for (const Arm& arm : arms_) {
      if (arm.is_end_on) continue;
      const double towards = diagonal.dot(arm.along) / (std::sqrt(2.0) * arm.along.norm());
      cosine = std::max(cosine, arm.names[1].empty() ? towards : std::abs(towards));
    }
    if (cosine < best_cosine - 1e-9) {
      best_cosine = cosine;
      best = diagonal;
    }
  }
  return best;
}

void Triad::draw_end_on(const Arm& arm) {
  const double radius = 0.5 * m_.text;
  constexpr int kSides = 32;
  std::array<Vec2, kSides> circle;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    circle[static_cast<std::size_t>(i)] = origin_ + radius * Vec2(std::cos(angle), std::sin(angle));
  }
  // A disc first, or the arms that start here would cross the sign.
  Ink disc(image_.width, image_.height, m_.halo);
  disc.convex(circle);
  put(disc, m_.paint.halo);
  Ink ink(image_.width, image_.height, m_.halo);
  for (std::size_t i = 0; i < kSides; ++i) {
    ink.line(circle[i], circle[(i + 1) % kSides], 1.5 * m_.pen);
  }
  if (arm.away > 0 && arm.names[1].empty()) {
    const double reach = 0.6 * radius;
    ink.line(origin_ - Vec2(reach, reach), origin_ + Vec2(reach, reach), 1.3 * m_.pen);
    ink.line(origin_ - Vec2(reach, -reach), origin_ + Vec2(reach, -reach), 1.3 * m_.pen);
  } else {
    ink.line(origin_, origin_, 3.5 * m_.pen);
  }
  Lettering(arm.end_on_name(), m_.text).write_at(ink, end_on_letter_place(), 0.5);
  put(ink, arm.color);
}

void Triad::draw() {
  std::vector<End> ends;
  for (const Arm& arm : arms_) {
    if (arm.is_end_on) continue;
    ends.push_back({&arm, 1.0, arm.away, true});
    if (!arm.names[1].empty()) ends.push_back({&arm, -1.0, -arm.away, true});
  }
  std::stable_sort(ends.begin(), ends.end(),
                   [](const End& a, const End& b) { return a.away > b.away; });
  leave_out_covered_names(ends);
  for (const End& end : ends) draw_arm(end);
  for (const Arm& arm : arms_) {
    if (arm.is_end_on) draw_end_on(arm);
  }
}

}  // namespace

void draw_axes(Image& image, const Camera& camera, Space space, const MarkStyle& style) {
  const Measures measures = annotate::measures_of(image, style);
  const annotate::Projection projection(camera, image.width, image.height);
  Triad(image, projection, space, measures).draw();
}

}  // namespace ovoid
