// SPDX-License-Identifier: Apache-2.0
#include "experiments/popping.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace ovoid::experiments {

namespace {

// The picture holds the lattice at every angle: its half diagonal is sqrt(2) across the turn.
constexpr double kHalfHeight = 1.45;

TransferFunction look_of(TurnLook look) {
  TransferFunction tf = color_map("viridis");
  tf.map_range(0, 1);
  if (look == TurnLook::kHard) {
    tf.opacities = {{0, 0}, {0.5, 0}, {0.5, 1}, {1, 1}};
  } else {
    tf.opacities = {{0, 0.0},     {0.3, 0.01}, {0.45, 0.02}, {0.5, 0.35},
                    {0.55, 0.02}, {0.8, 0.1},  {1, 0.25}};
  }
  return tf;
}

Dataset signal(const TurnOptions& options) { return make_sample("marschner-lobb", {options.size}); }

double mean_change(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t n = 0; n < a.rgba.size(); ++n) {
    sum += std::abs(static_cast<double>(a.rgba[n]) - static_cast<double>(b.rgba[n]));
  }
  return 255 * sum / static_cast<double>(a.rgba.size());
}

double greatest_column_of(const Image& image) {
  double greatest = 0;
  for (int x = 0; x < image.width; ++x) {
    double sum = 0;
    for (int y = 0; y < image.height; ++y) {
      const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                         static_cast<std::size_t>(x);
      for (std::size_t c = 0; c < 4; ++c) sum += image.rgba[4 * pixel + c];
    }
    greatest = std::max(greatest, sum);
  }
  return 255 * greatest / static_cast<double>(image.rgba.size());
}

Turn turn(const TurnOptions& options, const std::function<Image(double degrees)>& draw) {
  Turn result;
  const double first = 45 - options.step_degrees * options.steps / 2.0;
  Image previous = draw(first);
  for (int step = 0; step < options.steps; ++step) {
    Image next = draw(first + options.step_degrees * (step + 1));
    result.changes.push_back(mean_change(previous, next));
    result.greatest_column = std::max(result.greatest_column, greatest_column_of(next));
    if (step == options.steps / 2) {
      result.before = previous;
      result.after = next;
    }
    previous = std::move(next);
  }
  return result;
}

}  // namespace

double Turn::median() const {
  std::vector<double> sorted = changes;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  return sorted[sorted.size() / 2];
}

double Turn::greatest() const { return *std::max_element(changes.begin(), changes.end()); }

Turn turn_control(Sheets sheets, const TurnOptions& options) {
  const ControlRenderer renderer(signal(options), look_of(options.look));
  return turn(options, [&](double degrees) {
    return renderer.draw(degrees, options.pixels, kHalfHeight, sheets);
  });
}

Turn turn_renderer(const TurnOptions& options) {
  const LatticeField field = field_of(signal(options), default_choice());
  Look look;
  look.transfer_function = look_of(options.look);
  RenderOptions render;
  render.sheets = ovoid::Sheets::kImage;
  render.width = options.pixels;
  render.height = options.pixels;
  render.classification = Classification::kSampled;
  Renderer renderer(Backend::kCpu);
  return turn(options, [&](double degrees) {
    Camera camera;
    camera.position = {0, 0, 10};
    camera.parallel_projection = true;
    camera.parallel_scale = kHalfHeight;
    camera.azimuth(degrees);
    return renderer.render({field, look}, camera, render).image;
  });
}

Image difference(const Image& a, const Image& b, double gain) {
  Image result = a;
  for (std::size_t n = 0; n < a.rgba.size(); ++n) {
    const double change = std::abs(static_cast<double>(a.rgba[n]) - static_cast<double>(b.rgba[n]));
    result.rgba[n] = n % 4 == 3 ? 1.0F : static_cast<float>(std::min(1.0, gain * change));
  }
  return result;
}

}  // namespace ovoid::experiments
