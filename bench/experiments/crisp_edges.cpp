// SPDX-License-Identifier: Apache-2.0
#include "experiments/crisp_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "data/parallel.h"
#include "experiments/fields.h"
#include "experiments/pictures.h"
#include "ovoid/renderer.h"

namespace ovoid::experiments {

namespace {

// A box of 16^3 in 32^3 samples; the world is index space. The pictures look at its corner.
constexpr std::int64_t kSize = 32;
constexpr std::int64_t kFirst = 8;
constexpr std::int64_t kEnd = 24;
constexpr double kMiddle = (kSize - 1) / 2.0;
// Near a corner, so that the middle row of the picture crosses one side. Half a spacing from the
// samples, sheets one spacing apart lie on them.
const Vec3 kFocalPoint(kFirst - 0.5, kFirst + 1.5, kMiddle);

double box(std::int64_t i, std::int64_t j, std::int64_t k) {
  const auto is_within = [](std::int64_t n) { return n >= kFirst && n < kEnd; };
  return is_within(i) && is_within(j) && is_within(k) ? 1.0 : 0.0;
}

// All or nothing at the middle between the two values; the box is nearly opaque.
constexpr double kOpacity = 0.15;
constexpr Rgb kColor{0.9, 0.55, 0.25};

Image draw_post(double zoom, int pixels) {
  Look look;
  look.shade = false;
  look.unit_distance = 1;
  look.transfer_function.colors = {{0, kColor}, {1, kColor}};
  look.transfer_function.opacities = {{0, 0}, {0.5, 0}, {0.5, kOpacity}, {1, kOpacity}};
  Camera camera;
  camera.focal_point = kFocalPoint;
  camera.position = kFocalPoint + Vec3(0, 0, 100);
  camera.parallel_projection = true;
  camera.parallel_scale = pixels / zoom / 2;
  RenderOptions options;
  options.sheets = Sheets::kImage;
  options.width = pixels;
  options.height = pixels;
  const LatticeField field = field_of(dataset_of({kSize, kSize, kSize}, &box), default_choice());
  return Renderer(Backend::kCpu).render({field, look}, camera, options).image;
}

// Each sample is classified; opacity and colour times opacity are fields of the same kernel. The
// colour is one, so one field of the opacity tells all four.
Image draw_pre(double zoom, int pixels) {
  const PointField opacity =
      kernel_points(dataset_of({kSize, kSize, kSize},
                               [](std::int64_t i, std::int64_t j, std::int64_t k) {
                                 return box(i, j, k) >= 0.5 ? kOpacity : 0.0;
                               }),
                    default_choice());
  Image image = blank(pixels, pixels);
  data::parallel_ranges({pixels, 1, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      for (int column = 0; column < pixels; ++column) {
        const double x = (column + 0.5 - pixels / 2.0) / zoom;
        const double y = (pixels / 2.0 - static_cast<double>(row) - 0.5) / zoom;
        double clear = 1;
        for (std::int64_t k = 0; k < kSize; ++k) {  // the same sheets
          const Vec3 place(kFocalPoint.x() + x, kFocalPoint.y() + y, static_cast<double>(k));
          clear *= 1 - opacity(place).value;
        }
        float* pixel = image.rgba.data() + 4 * (row * pixels + column);
        for (std::size_t c = 0; c < 3; ++c) {
          pixel[c] = static_cast<float>(kColor[c] * (1 - clear));
        }
        pixel[3] = static_cast<float>(1 - clear);
      }
    }
  });
  return image;
}

// Pixels between the places where the opacity of the middle row, linear between pixels, passes 10
// and 90 % of its greatest.
double outline_width(const Image& image) {
  const float* row = image.rgba.data() + 4 * (image.height / 2) * image.width;
  std::vector<double> alpha;
  alpha.reserve(static_cast<std::size_t>(image.width));
  for (int x = 0; x < image.width; ++x) alpha.push_back(static_cast<double>(row[4 * x + 3]));
  const double greatest = *std::max_element(alpha.begin(), alpha.end());
  const auto passes = [&](double level) {
    for (std::size_t x = 1; x < alpha.size(); ++x) {
      if (alpha[x] < level) continue;
      return static_cast<double>(x) - (alpha[x] - level) / (alpha[x] - alpha[x - 1]);
    }
    return std::numeric_limits<double>::quiet_NaN();
  };
  return passes(0.9 * greatest) - passes(0.1 * greatest);
}

}  // namespace

CrispEdge measure_edge(double zoom, int pixels) {
  CrispEdge edge;
  edge.post = draw_post(zoom, pixels);
  edge.pre = draw_pre(zoom, pixels);
  edge.post_px = outline_width(edge.post);
  edge.pre_px = outline_width(edge.pre);
  return edge;
}

}  // namespace ovoid::experiments
