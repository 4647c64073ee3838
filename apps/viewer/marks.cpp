// SPDX-License-Identifier: Apache-2.0
#include "marks.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace ovoid::viewer {
namespace {

// Pieces are as large as their marks may become, in lines of text.
constexpr int kAxesSide = 10;
constexpr int kScaleBarHeight = 5;
constexpr int kColorBarWidth = 20;
// A window narrower than this, in lines, keeps the picture free.
constexpr int kLeastWidthForBar = 26;
constexpr double kLeastText = 13;  // units, before the interface's scale

Image clear_image(int width, int height) {
  Image image;
  image.width = width;
  image.height = height;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  image.rgba.assign(pixels * 4, 0.0F);
  image.depth.assign(pixels, 0.0F);
  return image;
}

// A camera for a piece of a picture, `height` pixels high, in which the world is as large.
Camera camera_of_piece(Camera camera, int height, int full_height) {
  const double share = static_cast<double>(height) / full_height;
  camera.parallel_scale *= share;
  constexpr double kHalfDegree = std::numbers::pi / 360;
  camera.view_angle = std::atan(std::tan(camera.view_angle * kHalfDegree) * share) / kHalfDegree;
  return camera;
}

// The part of an image that is not clear.
struct Part {
  int x0, y0, x1, y1;
};

Part part_in_use(const Image& image) {
  Part part{image.width, image.height, 0, 0};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                     static_cast<std::size_t>(x);
      if (image.rgba[i * 4 + 3] == 0) continue;
      part = {std::min(part.x0, x), std::min(part.y0, y), std::max(part.x1, x + 1),
              std::max(part.y1, y + 1)};
    }
  }
  if (part.x0 >= part.x1) return {0, 0, 1, 1};
  return part;
}

Image cut(const Image& image, const Part& part) {
  Image piece = clear_image(part.x1 - part.x0, part.y1 - part.y0);
  const auto row = static_cast<std::size_t>(piece.width) * 4;
  for (int y = part.y0; y < part.y1; ++y) {
    const auto from = (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                       static_cast<std::size_t>(part.x0)) *
                      4;
    std::copy_n(image.rgba.data() + from, row,
                piece.rgba.data() + static_cast<std::size_t>(y - part.y0) * row);
  }
  return piece;
}

// What a whole picture's marks have (MarkStyle::text_px).
double text_height(int width, int height) {
  const double shorter = std::min(width, height);
  return std::min(std::max(10.0, shorter / 42), shorter / 12);
}

}  // namespace

void Marks::draw(const Document& document, const std::pair<double, double>& xray_range,
                 ImDrawList& list, ImVec2 at, ImVec2 size, float density, float scale) {
  const Size pixels{static_cast<int>(size.x * density), static_cast<int>(size.y * density)};
  if (pixels.width < 32 || pixels.height < 32) return;
  const bool is_resized = !(pixels == drawn_for_);
  const bool has_moved = is_resized || document.version() != version_;
  const bool has_changed =
      is_resized || document.view_version() != view_version_ || xray_range != xray_range_;
  version_ = document.version();
  view_version_ = document.view_version();
  xray_range_ = xray_range;
  drawn_for_ = pixels;
  const cli::AnnotationFlags& wanted = document.view.marks;
  cli::AnnotationFlags piece;
  piece.text_px = std::max(text_height(pixels.width, pixels.height), kLeastText * scale * density);
  piece.length_unit = wanted.length_unit;
  piece.title = wanted.title;
  const int line = static_cast<int>(std::ceil(piece.text_px));
  const auto show = [&](Mark& mark, int width, int height, bool is_right, bool is_low) {
    // The colour bar stands still.
    const bool is_due = is_right && !is_low ? has_changed : has_moved;
    width = std::min(width, pixels.width);
    height = std::min(height, pixels.height);
    if (is_due || mark.texture.is_empty()) {
      Image image = clear_image(width, height);
      Look look = document.view.look;
      if (look.mode == Mode::kXray)
        look.transfer_function = spread_over_integrals(look.transfer_function, xray_range);
      cli::draw_annotations(image, piece, document.shown->subject.described,
                            camera_of_piece(document.camera, height, pixels.height), look,
                            document.view.background);
      const Part part = part_in_use(image);
      const Image used = cut(image, part);
      mark.texture.upload(to_rgba8(used).data(), used.width, used.height);
      mark.x = part.x0;
      mark.y = part.y0;
    }
    const int left = mark.x + (is_right ? pixels.width - width : 0);
    const int top = mark.y + (is_low ? pixels.height - height : 0);
    const Size extent = mark.texture.size();
    const ImVec2 corner(at.x + static_cast<float>(left) / density,
                        at.y + static_cast<float>(top) / density);
    list.AddImage(mark.texture.id(), corner,
                  {corner.x + static_cast<float>(extent.width) / density,
                   corner.y + static_cast<float>(extent.height) / density});
  };
  if (wanted.axes) {
    piece.axes = true;
    show(axes_, kAxesSide * line, kAxesSide * line, false, true);
    piece.axes = false;
  }
  if (wanted.scale_bar) {
    piece.scale_bar = true;
    show(scale_bar_, pixels.width, kScaleBarHeight * line, true, true);
    piece.scale_bar = false;
  }
  const bool is_difference = document.other && document.compare == CompareMode::kDifference;
  if (wanted.color_bar && !is_difference && pixels.width > kLeastWidthForBar * line) {
    piece.color_bar = true;
    show(color_bar_, kColorBarWidth * line, pixels.height, true, false);
  }
}

}  // namespace ovoid::viewer
