// SPDX-License-Identifier: Apache-2.0
// The modes that show one value of a ray: its integral, its greatest, its least, its mean. They
// look at the same samples or pieces as all others (pixel_tracer.cpp), but composite nothing.
#include <algorithm>
#include <limits>

#include "render/reference/pixel_tracer.h"

namespace ovoid::reference {
namespace {

// What stands for a pixel at one place alone.
Pixel premultiplied(const Rgb& color, double alpha, double depth) {
  return {{alpha * color[0], alpha * color[1], alpha * color[2], alpha},
          depth,
          alpha >= double{kLeastVisibleOpacity} ? depth : std::numeric_limits<double>::infinity()};
}

}  // namespace

// Of a part of a piece the end that is the greater or the less, or the middle.
void PixelTracer::add_values(const PixelRay& pixel, const Piece& piece,
                             std::vector<SeenValue>& seen) const {
  const double front = (piece.front ? piece.front : piece.back)->value;
  const double back = (piece.back ? piece.back : piece.front)->value;
  const auto value_at = [&](double z) {
    const double t = (z - view_.z_of(piece.sheet - 1)) / view_.sampling_distance();
    return front + t * (back - front);
  };
  for (const ZRange& part : parts_left(pixel, piece)) {
    const double path = (part.hi - part.lo) * pixel.ray.direction.norm();
    const double first = value_at(part.lo);
    const double last = value_at(part.hi);
    if (look_.mode == Mode::kXray || look_.mode == Mode::kMean) {
      seen.push_back({0.5 * (first + last), part.lo, path});
    } else if (look_.mode == Mode::kMaximum ? last > first : last < first) {
      seen.push_back({last, part.hi, path});
    } else {
      seen.push_back({first, part.lo, path});
    }
  }
}

// Samples with a path, or where planes cut the pieces between them: docs/numerics.md, "Cut values".
std::vector<PixelTracer::SeenValue> PixelTracer::values_along(const PixelRay& pixel,
                                                              TraceCounts& counts) const {
  std::vector<SeenValue> seen;
  std::optional<RaySample> before;
  const std::int64_t last = pixel.sheets.last + (is_refined_ ? 1 : 0);
  for (std::int64_t k = pixel.sheets.first; k <= last; ++k) {
    const std::optional<RaySample> own = sample(pixel, k, counts);
    if (is_refined_) {
      if (before || own) add_values(pixel, {k, before, own}, seen);
      before = own;
    } else if (const std::optional<RaySample> at = within_limits(pixel, own)) {
      seen.push_back({at->value, at->z, at->path});
    }
  }
  return seen;
}

Pixel PixelTracer::xray(const PixelRay& pixel, TraceCounts& counts) const {
  const std::vector<SeenValue> seen = values_along(pixel, counts);
  if (seen.empty()) return {};
  double integral = 0;
  for (const SeenValue& at : seen) integral += at.value * at.path;
  counts.visible += static_cast<std::int64_t>(seen.size());
  const double depth = seen.front().z;
  if (keeps_values_) return kept(integral, 0, depth);
  return {{integral, integral, integral, 1}, depth, depth};
}

Pixel PixelTracer::extreme(const PixelRay& pixel, TraceCounts& counts) const {
  const std::vector<SeenValue> seen = values_along(pixel, counts);
  if (seen.empty()) return {};
  const SeenValue best =
      *std::min_element(seen.begin(), seen.end(), [&](const SeenValue& a, const SeenValue& b) {
        return look_.mode == Mode::kMaximum ? a.value > b.value : a.value < b.value;
      });
  if (keeps_values_) return kept(best.value, 0, best.z);
  return classified(best.value, best.z, counts);
}

Pixel PixelTracer::mean(const PixelRay& pixel, TraceCounts& counts) const {
  const std::vector<SeenValue> seen = values_along(pixel, counts);
  if (seen.empty()) return {};
  double integral = 0;
  double length = 0;
  for (const SeenValue& at : seen) {
    integral += at.value * at.path;
    length += at.path;
  }
  const double depth = seen.front().z;
  return keeps_values_ ? kept(integral, length, depth)
                       : classified(integral / length, depth, counts);
}

// keep_value().
Pixel PixelTracer::kept(double best, double path, double depth) {
  return {{best, path, 0, 1}, depth, depth};
}

// A pixel that one value stands for; the opacity is not corrected by a distance.
Pixel PixelTracer::classified(double value, double depth, TraceCounts& counts) const {
  const double opacity = look_.transfer_function.opacity_at(value);
  if (opacity > 0) ++counts.visible;
  return premultiplied(look_.transfer_function.color_at(value), opacity, depth);
}

}  // namespace ovoid::reference
