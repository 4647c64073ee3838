// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "annotate/lettering.h"
#include "annotate/projection.h"
#include "annotate/ticks.h"
#include "ovoid/annotate.h"

namespace ovoid {
namespace {

// The bar's greatest length; a step of 1, 2, 5 leaves at least 0.4 of it.
constexpr double kGreatestWidth = 0.22;  // of the picture

}  // namespace

void draw_scale_bar(Image& image, const Camera& camera, const std::string& unit,
                    const MarkStyle& style) {
  using annotate::Vec2;
  const annotate::Measures m = annotate::measures_of(image, style);
  const annotate::Projection projection(camera, image.width, image.height);
  const double scale = projection.pixels_per_world_at_focus();
  const double limit = kGreatestWidth * image.width / scale;
  if (!std::isnormal(limit)) return;  // lengths that doubles cannot hold
  const double length = annotate::round_below(limit);

  const double pen = 1.6 * m.pen;
  const Vec2 right(std::round(image.width - 1.2 * m.text) - 0.5,
                   std::round(image.height - 1.3 * m.text) - 0.5);
  const Vec2 left = right - Vec2(length * scale, 0);
  const Vec2 end(0, 0.32 * m.text);
  annotate::Ink ink(image.width, image.height, m.halo);
  ink.line(left, right, pen);
  ink.line(left - end, left + end, pen);
  ink.line(right - end, right + end, pen);
  const std::string number = annotate::number_text(length);
  const annotate::Lettering label(unit.empty() ? number : fmt::format("{} {}", number, unit),
                                  m.text);
  label.write(ink, std::round((left.x() + right.x() - label.width()) / 2),
              right.y() - 0.75 * m.text);
  ink.over(image, m.paint);
}

}  // namespace ovoid
