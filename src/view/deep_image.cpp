// SPDX-License-Identifier: Apache-2.0
#include "ovoid/deep_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "ovoid/error.h"
#include "ovoid/render_options.h"
#include "ovoid/space_part.h"
#include "view/plan/coverage.h"
#include "view/plan/finished_pixel.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse_image(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, "deep image: " + message);
}

std::size_t num_pixels_of(const DeepImage& image) {
  return static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

constexpr float kNowhere = std::numeric_limits<float>::infinity();

// Where the opacity has reached a bound with this run and had not before: at the run's own depth,
// if it gets there by itself, else where the run is first seen.
void note_depth(float before, float after, float bound, float own, const DeepImage::Run& run,
                float& depth) {
  if (before < bound && after >= bound) depth = std::isfinite(own) ? own : run.front_depth;
}

struct FinishedPixel {
  std::array<float, 4> rgba{};
  float depth = kNowhere, front_depth = kNowhere;
};

FinishedPixel composited_pixel(std::span<const DeepImage::Run> runs) {
  FinishedPixel pixel;
  for (const DeepImage::Run& run : runs) {
    const float before = pixel.rgba[3];
    if (before >= static_cast<float>(RenderOptions::kOpaque)) break;  // as a ray would stop
    for (std::size_t c = 0; c < 4; ++c) pixel.rgba[c] += (1 - before) * run.rgba[c];
    note_depth(before, pixel.rgba[3], 0.5F, run.depth, run, pixel.depth);
    note_depth(before, pixel.rgba[3], kLeastVisibleOpacity, run.front_depth, run,
               pixel.front_depth);
  }
  return pixel;
}

FinishedPixel value_pixel(std::span<const DeepImage::Run> runs, const Look& look) {
  FinishedPixel pixel;
  const bool is_least = look.mode == Mode::kMinimum;
  const bool is_extreme = is_least || look.mode == Mode::kMaximum;
  float best = !is_extreme ? 0.0F : is_least ? kNowhere : -kNowhere;
  float path = 0;
  for (const DeepImage::Run& run : runs) {
    if (is_extreme) {
      const bool is_better = is_least ? run.rgba[0] < best : run.rgba[0] > best;
      if (!is_better) continue;
      pixel.depth = run.depth;
      best = run.rgba[0];
    } else {
      if (pixel.depth == kNowhere) pixel.depth = run.depth;
      best += run.rgba[0];
      path += run.rgba[1];
    }
  }
  show_value(look, best, path, pixel.rgba.data());
  pixel.front_depth = front_depth_of_value(pixel.rgba.data(), pixel.depth);
  return pixel;
}

}  // namespace

void DeepImage::validate() const {
  constexpr int kMost = RenderOptions::kMaxImageSide;
  if (width < 1 || width > kMost || height < 1 || height > kMost)
    refuse_image(fmt::format("{} x {} pixels: must be 1 to {} each way", width, height, kMost));
  const std::size_t num_pixels = num_pixels_of(*this);
  if (first.size() != num_pixels + 1 || first.front() != 0 || first.back() != runs.size() ||
      !std::is_sorted(first.begin(), first.end()))
    refuse_image("first: must rise from 0 to the number of runs, one number per pixel and the end");
  for (std::size_t pixel = 0; pixel < num_pixels; ++pixel) {
    for (std::size_t i = first[pixel]; i < first[pixel + 1]; ++i) {
      const Run& run = runs[i];
      if (!(run.first < run.last) || run.first < kFirstSheet || run.last > kLastSheet)
        refuse_image(fmt::format("a run of sheets {} to {}: must have some", run.first, run.last));
      if (i > first[pixel] && runs[i - 1].last > run.first)
        refuse_image(fmt::format("pixel {}, {}: two runs on sheet {}",
                                 pixel % static_cast<std::size_t>(width),
                                 pixel / static_cast<std::size_t>(width), run.first));
      const bool is_finite = std::all_of(run.rgba.begin(), run.rgba.end(),
                                         [](float number) { return std::isfinite(number); });
      const auto is_share = [](float number) { return number >= 0 && number <= 1.001F; };
      if (!is_finite || !is_share(run.rgba[3]) || !is_share(run.coverage) ||
          std::isnan(run.depth) || std::isnan(run.front_depth))
        refuse_image(
            "a run whose numbers are not finite, or whose opacity or coverage is not in [0, 1]");
    }
  }
}

DeepImage merged(std::span<const DeepImage> images) {
  if (images.empty()) refuse_image("none to be merged");
  DeepImage all;
  all.width = images.front().width;
  all.height = images.front().height;
  all.mode = images.front().mode;
  std::size_t num_runs = 0;
  for (const DeepImage& image : images) {
    image.validate();
    if (image.width != all.width || image.height != all.height)
      refuse_image(fmt::format("of {} x {} pixels, another has {} x {}", image.width, image.height,
                               all.width, all.height));
    if (image.mode != all.mode) refuse_image("of different modes");
    num_runs += image.runs.size();
  }
  const std::size_t num_pixels = num_pixels_of(all);
  all.first.assign(num_pixels + 1, 0);
  all.runs.reserve(num_runs);
  for (std::size_t pixel = 0; pixel < num_pixels; ++pixel) {
    const auto begin = static_cast<std::ptrdiff_t>(all.runs.size());
    for (const DeepImage& image : images)
      all.runs.insert(all.runs.end(), image.runs.begin() + image.first[pixel],
                      image.runs.begin() + image.first[pixel + 1]);
    std::sort(all.runs.begin() + begin, all.runs.end(),
              [](const DeepImage::Run& a, const DeepImage::Run& b) { return a.first < b.first; });
    all.first[pixel + 1] = static_cast<std::uint32_t>(all.runs.size());
  }
  all.validate();
  return all;
}

Image composited(const DeepImage& image, const Look& look) {
  image.validate();
  look.validate();
  Look of_values = look;
  of_values.mode = image.mode;
  Image picture;
  picture.width = image.width;
  picture.height = image.height;
  const std::size_t num_pixels = num_pixels_of(image);
  picture.rgba.assign(4 * num_pixels, 0.0F);
  picture.depth.assign(num_pixels, kNowhere);
  picture.front_depth.assign(num_pixels, kNowhere);
  std::vector<float> coverage(num_pixels, 1.0F);
  for (std::size_t pixel = 0; pixel < num_pixels; ++pixel) {
    const auto runs = std::span(image.runs)
                          .subspan(image.first[pixel], image.first[pixel + 1] - image.first[pixel]);
    if (runs.empty()) continue;
    const FinishedPixel finished =
        shows_values(image.mode) ? value_pixel(runs, of_values) : composited_pixel(runs);
    std::copy(finished.rgba.begin(), finished.rgba.end(), picture.rgba.begin() + 4 * pixel);
    coverage[pixel] = runs.front().coverage;
    picture.depth[pixel] = finished.depth;
    picture.front_depth[pixel] = finished.front_depth;
  }
  view::apply_coverage(coverage, image.mode, picture);
  return picture;
}

}  // namespace ovoid
