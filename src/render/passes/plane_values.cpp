// SPDX-License-Identifier: Apache-2.0
// In: a field, and where a plane is in sight. Out: the field's values on a grid of texels.
//
// A camera looks at the plane squarely, with parallel projection, such that sheet 0 lies on it. A
// sample's place on a sheet is exact, so nothing is between the texel and the field but the
// rounding of floats. An x-ray picture of one sheet holds value times path; where colour comes from
// another attribute, an opaque picture in gray holds that attribute's place in its range.
//
// Lattices: sheets are so far apart that no other meets the field, so that a tile has one layer,
// and the path, a power of two, costs no digit. Kernel sets are widened to half a sheet along the
// view, so theirs are a quarter of the default apart, and two clip planes leave only one of them.
#include "render/passes/plane_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "view/look/color_attribute.h"
#include "view/look/value_scale.h"

namespace ovoid {
namespace {

// Curves through four texels lose so much of the peak of one isolated sample (its normalized
// kernel, in the plane): 0.06 % where texels are a quarter of a lattice's sigma apart, 0.6 % at
// half of it, 7 % at one sigma, 26 % at one and a half. So pixels wider than kPixelsPerSigma have
// two texels along a side, and finer ones than kTexelsPerSigma serve nobody. Kernels of sets, whose
// sheets cost more, are at least 0.65 texels wide in any case: theirs are pixels.
constexpr double kPixelsPerSigma = 1 / 0.6;
constexpr double kTexelsPerSigma = 8;

// Of values between texels: two on either side, and one for the rounding of the footprint.
constexpr int kMargin = 3;

// A pixel takes so many places along each of its sides at most.
constexpr int kMaxPlaces = 8;

struct Extent {
  double lo = std::numeric_limits<double>::infinity();
  double hi = -std::numeric_limits<double>::infinity();
  void add(double x) {
    lo = std::min(lo, x);
    hi = std::max(hi, x);
  }
};

// A pixel wide, or half of one, where the plane is nearest to the eye.
double texel_of(const Field& field, const PlaneView& view, const std::vector<Vec3>& footprint) {
  double pixel = std::numeric_limits<double>::infinity();
  for (const Vec3& corner : footprint) pixel = std::min(pixel, view.pitch_at(corner));
  const LatticeField* const lattice = field.lattice();
  if (lattice == nullptr) return pixel;
  const double sigma = lattice->kernel().sigma * lattice->default_sampling_distance();
  return pixel > sigma / kPixelsPerSigma ? 0.5 * pixel : std::max(pixel, sigma / kTexelsPerSigma);
}

PlaneGrid grid_for(const Field& field, const PlaneView& view, const std::vector<Vec3>& footprint) {
  PlaneGrid grid;
  // Upright in the picture; of a plane on which up is nearly a point, away from the eye.
  constexpr double kUpright = 0.3;
  const Vec3& forward = view.normal();
  Vec3 up = view.view_up() - forward.dot(view.view_up()) * forward;
  if (up.norm() < kUpright) {
    const Vec3& axis = view.lattice().view_axis();
    up = axis - forward.dot(axis) * forward;
  }
  grid.up = up.normalized();
  grid.right = forward.cross(grid.up);
  // With parallel projection texels lie on pixels, if the plane is seen squarely.
  Vec3 anchor = footprint.front();
  if (view.lattice().is_parallel()) {
    if (const auto first = view.hit(0, 0)) anchor = first->at;
  }
  Extent across, along;
  for (const Vec3& corner : footprint) {
    across.add(grid.right.dot(corner - anchor));
    along.add(grid.up.dot(corner - anchor));
  }
  const double longest = std::max(across.hi - across.lo, along.hi - along.lo);
  constexpr int kMostWithin = PlaneGrid::kMaxSide - 2 * kMargin - 2;
  grid.texel = std::max(texel_of(field, view, footprint), longest / kMostWithin);
  const double left = std::floor(across.lo / grid.texel) - kMargin;
  const double top = std::ceil(along.hi / grid.texel) + kMargin;
  grid.width = static_cast<int>(std::ceil(across.hi / grid.texel) + kMargin - left) + 1;
  grid.height = static_cast<int>(top - std::floor(along.lo / grid.texel) + kMargin) + 1;
  grid.corner = anchor + grid.texel * (left * grid.right + top * grid.up);
  return grid;
}

// Sheet 0 is on the plane.
Camera camera_of(const PlaneGrid& grid, const Vec3& forward, double sheets, double distance) {
  const Vec3 middle =
      grid.corner +
      0.5 * grid.texel * ((grid.width - 1) * grid.right - (grid.height - 1) * grid.up);
  Camera camera;
  camera.position = middle - distance * forward;
  camera.focal_point = middle - 0.5 * sheets * forward;
  camera.view_up = grid.up;
  camera.parallel_projection = true;
  camera.parallel_scale = 0.5 * grid.texel * grid.height;
  return camera;
}

// Gray over the values of the attribute that gives colour, along the scale of the function that
// will read them, so that small values keep their digits.
struct GrayScale {
  GrayScale(const ValueRange& range, const TransferFunction& of)
      : scale(of.scale), linear_width(of.linear_width), lo(range.lo), hi(range.hi) {
    // Values <= 0 lie below all points.
    if (scale == ValueScale::kLog) lo = std::max(lo, std::min(of.lo(), std::max(hi, kLeast)) / 2);
    hi = std::max(lo, hi);
  }

  Look look() const {
    Look look;
    look.shade = false;
    look.transfer_function.opacities = {{0, 1}};
    TransferFunction gray;
    gray.scale = scale;
    gray.linear_width = linear_width;
    gray.colors = {{lo, {0, 0, 0}}};
    if (hi > lo) gray.colors.push_back({hi, {1, 1, 1}});
    look.color_function = gray;
    return look;
  }
  double value_of(double gray) const {
    const double from = view::along(scale, linear_width, lo);
    const double to = view::along(scale, linear_width, hi);
    return view::value_at(scale, linear_width, from + gray * (to - from));
  }

  static constexpr double kLeast = 1e-300;
  ValueScale scale;
  double linear_width, lo, hi;
};

// Keys' cubic through four texels, `t` in [0, 1] from the second to the third [Keys 1981].
std::array<float, 4> cubic_weights(double t) {
  const double s = 1 - t;
  return {static_cast<float>(-0.5 * t * s * s), static_cast<float>(1 + t * t * (1.5 * t - 2.5)),
          static_cast<float>(1 + s * s * (1.5 * s - 2.5)), static_cast<float>(-0.5 * s * t * t)};
}

}  // namespace

PlaneValues::PlaneValues(FieldRenderer& renderer, const Field& field, const Look& look,
                         const PlaneView& view, const std::vector<Vec3>& footprint,
                         const RenderOptions& options, const RenderHooks& hooks)
    : view_(view), grid_(grid_for(field, view, footprint)), step_(grid_.texel) {
  const KernelField* const kernels = field.kernels();
  if (kernels == nullptr) step_ = std::max(step_, field.default_sampling_distance());
  RenderOptions own;
  own.width = grid_.width;
  own.height = grid_.height;
  own.slab = Slab::kMid;
  own.sheets = Sheets::kImage;  // of the plane's own pixels
  own.evaluate = options.evaluate;
  own.post_convolution = PostConvolution::kOff;
  own.collect_profile = options.collect_profile;
  const double sheets = kernels != nullptr
                            ? 0.25 * field.default_sampling_distance()
                            : std::exp2(std::ceil(std::log2(4 * view.box_diagonal())));
  own.sampling_distance = sheets;
  const Vec3& forward = view.normal();
  const Camera camera = camera_of(grid_, forward, sheets, std::max(sheets, view.box_diagonal()));
  double path = sheets;
  if (kernels != nullptr) {
    path = 0.5 * sheets;
    const double middle = forward.dot(grid_.corner);
    own.clip_planes = {{forward, middle - 0.5 * path}, {-forward, -middle - 0.5 * path}};
  }
  const bool has_own_color = kernels != nullptr && kernels->has_own_color();
  const GrayScale gray(field.color_range(), view::color_function_of(look));
  Look values_look;
  values_look.mode = Mode::kXray;
  if (has_own_color) values_look = gray.look();
  const Frame frame = renderer.draw({field, values_look}, camera, own, hooks);
  profile_ = frame.profile;
  const std::vector<float>& rgba = frame.image.rgba;
  values_.assign(rgba.size() / 4, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (!(rgba[4 * i + 3] > 0)) continue;
    values_[i] =
        static_cast<float>(has_own_color ? gray.value_of(rgba[4 * i]) : rgba[4 * i] / path);
  }
}

PlaneValues::Place PlaneValues::place_of(const Vec3& at) const {
  const Vec3 from = at - grid_.corner;
  return {grid_.right.dot(from) / grid_.texel, -grid_.up.dot(from) / grid_.texel};
}

float PlaneValues::texel(int x, int y) const {
  return values_[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width) +
                 static_cast<std::size_t>(x)];
}

bool PlaneValues::is_within_faces(int x, int y) const {
  return view_.is_within_faces(grid_.corner + grid_.texel * (x * grid_.right - y * grid_.up));
}

// In a corner of the field's box, none of whose texels are near.
std::optional<float> PlaneValues::nearest(const Place& place) const {
  const int x0 = static_cast<int>(std::floor(place.x));
  const int y0 = static_cast<int>(std::floor(place.y));
  double least = std::numeric_limits<double>::infinity();
  std::optional<float> value;
  for (int y = y0 - 1; y <= y0 + 2; ++y) {
    for (int x = x0 - 1; x <= x0 + 2; ++x) {
      const double distance = std::hypot(place.x - x, place.y - y);
      if (std::isnan(texel(x, y)) || distance >= least) continue;
      least = distance;
      value = texel(x, y);
    }
  }
  return value;
}

// The four texels around a place, those that there are. A place counts as defined if they weigh at
// least half of what lies within the faces of the field's box.
std::optional<float> PlaneValues::near_border(const Place& place, const Vec3& at) const {
  if (!view_.is_in_box(at)) return std::nullopt;
  const int x0 = static_cast<int>(std::floor(place.x));
  const int y0 = static_cast<int>(std::floor(place.y));
  double sum = 0, defined = 0, inside = 0;
  for (int y = y0; y <= y0 + 1; ++y) {
    for (int x = x0; x <= x0 + 1; ++x) {
      const double weight = (1 - std::abs(place.x - x)) * (1 - std::abs(place.y - y));
      const float value = texel(x, y);
      const bool is_defined = !std::isnan(value);
      if (is_defined) {
        sum += weight * value;
        defined += weight;
      }
      if (is_defined || is_within_faces(x, y)) inside += weight;
    }
  }
  if (inside == 0) return nearest(place);
  if (defined == 0 || defined < 0.5 * inside) return std::nullopt;
  return static_cast<float>(sum / defined);
}

// Straight lines, for means; NaN beside an undefined texel.
float PlaneValues::between(const Place& place) const {
  if (!has_neighbours(place)) return std::numeric_limits<float>::quiet_NaN();
  const int x = static_cast<int>(place.x);
  const int y = static_cast<int>(place.y);
  const auto tx = static_cast<float>(place.x - x);
  const auto ty = static_cast<float>(place.y - y);
  const float above = texel(x, y) + tx * (texel(x + 1, y) - texel(x, y));
  const float below = texel(x, y + 1) + tx * (texel(x + 1, y + 1) - texel(x, y + 1));
  return above + ty * (below - above);
}

bool PlaneValues::has_neighbours(const Place& place) const {
  return place.x >= 1 && place.y >= 1 && place.x < grid_.width - 2 && place.y < grid_.height - 2;
}

// No curve leaves the range of the sixteen texels that it goes through.
std::optional<float> PlaneValues::interpolated(const Place& place, const Vec3& at) const {
  if (!has_neighbours(place)) return std::nullopt;
  const double x0 = std::floor(place.x);
  const double y0 = std::floor(place.y);
  const std::array<float, 4> across = cubic_weights(place.x - x0);
  const std::array<float, 4> along = cubic_weights(place.y - y0);
  float sum = 0;
  float lo = std::numeric_limits<float>::infinity();
  float hi = -lo;
  for (int j = 0; j < 4; ++j) {
    const float* row = values_.data() +
                       static_cast<std::size_t>(static_cast<int>(y0) + j - 1) *
                           static_cast<std::size_t>(grid_.width) +
                       static_cast<std::size_t>(static_cast<int>(x0) - 1);
    float line = 0;
    for (int i = 0; i < 4; ++i) {
      line += across[i] * row[i];
      lo = std::min(lo, row[i]);
      hi = std::max(hi, row[i]);
    }
    sum += along[j] * line;
  }
  if (std::isnan(sum)) return near_border(place, at);
  return std::clamp(sum, lo, hi);
}

std::optional<float> PlaneValues::at(const PlaneHit& hit) const {
  const auto center = interpolated(place_of(hit.at), hit.at);
  if (!center) return std::nullopt;
  const auto places_along = [&](const Vec3& side) {
    const double steps = side.norm() / step_;
    return steps < kMaxPlaces ? std::max(1, static_cast<int>(std::lround(steps))) : kMaxPlaces;
  };
  const int num_x = places_along(hit.per_x);
  const int num_y = places_along(hit.per_y);
  if (num_x == 1 && num_y == 1) return center;
  double sum = 0;
  int count = 0;
  for (int j = 0; j < num_y; ++j) {
    for (int i = 0; i < num_x; ++i) {
      const Vec3 at =
          hit.at + ((i + 0.5) / num_x - 0.5) * hit.per_x + ((j + 0.5) / num_y - 0.5) * hit.per_y;
      const float value = between(place_of(at));
      if (std::isnan(value)) continue;
      sum += value;
      ++count;
    }
  }
  return count > 0 ? static_cast<float>(sum / count) : *center;
}

}  // namespace ovoid
