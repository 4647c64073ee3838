// SPDX-License-Identifier: Apache-2.0
#include "marks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "projection.h"

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
  image.front_depth = image.depth;
  return image;
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

Size pixels_of(const Box2& box, float density) {
  return {static_cast<int>((box.x1 - box.x0) * density),
          static_cast<int>((box.y1 - box.y0) * density)};
}

// What a whole picture's marks have (MarkStyle::text_px).
double text_height(int width, int height) {
  const double shorter = std::min(width, height);
  return std::min(std::max(10.0, shorter / 42), shorter / 12);
}

}  // namespace

Marks::Mark Marks::drawn(const Document& document, const View& view, const XrayRange& xray_range,
                         const Piece& piece) {
  Image image = clear_image(std::min(piece.size.width, piece.of.width),
                            std::min(piece.size.height, piece.of.height));
  Look look = view.look;
  if (look.mode == Mode::kXray)
    look.transfer_function = spread_over_integrals(look.transfer_function, xray_range);
  const Camera camera =
      of_height(piece.camera, static_cast<double>(image.height) / piece.of.height);
  cli::draw_annotations(image, piece.marks, document.shown->subject.described, camera, look,
                        view.background);
  const Part part = part_in_use(image);
  const Image used = cut(image, part);
  Mark mark;
  mark.texture.upload(to_rgba8(used).data(), used.width, used.height);
  mark.x = part.x0;
  mark.y = part.y0;
  mark.beside = image.width - part.x1;
  mark.below = image.height - part.y1;
  return mark;
}

void Marks::draw(const Document& document, const std::array<XrayRange, 2>& xray_ranges,
                 ImDrawList& list, const Place& place) {
  width_at_left_ = width_at_right_ = 0;
  const float density = place.density;
  const Size all = pixels_of(place.all, density);
  const Size picture = pixels_of(place.picture, density);
  if (std::min({all.width, all.height, picture.width, picture.height}) < 32) return;
  const bool is_resized = !(all == drawn_for_.all && picture == drawn_for_.picture);
  const bool has_moved = is_resized || document.version() != drawn_for_.version;
  // The colour bars stand still.
  const bool has_changed = is_resized || document.view_version() != drawn_for_.view_version ||
                           document.other_version() != drawn_for_.other_version ||
                           xray_ranges != drawn_for_.xray_ranges;
  drawn_for_ = {document.version(),
                document.view_version(),
                document.other_version(),
                xray_ranges,
                all,
                picture};
  const cli::AnnotationFlags wanted = document.marks_of(document.view);
  Piece piece;
  piece.camera = document.camera;
  piece.marks.text_px =
      std::max(text_height(all.width, all.height), kLeastText * place.scale * density);
  piece.marks.length_unit = wanted.length_unit;
  piece.marks.title = wanted.title;
  const int line = static_cast<int>(std::ceil(piece.marks.text_px));
  const auto show = [&](const Mark& mark, float x, float y) {
    const Size extent = mark.texture.size();
    list.AddImage(mark.texture.id(), {x, y},
                  {x + static_cast<float>(extent.width) / density,
                   y + static_cast<float>(extent.height) / density});
  };
  const auto units = [&](int length) { return static_cast<float>(length) / density; };
  if (wanted.axes) {
    piece.marks.axes = true;
    piece.size = {kAxesSide * line, kAxesSide * line};
    piece.of = picture;
    if (has_moved || axes_.texture.is_empty())
      axes_ = drawn(document, document.view, xray_ranges[1], piece);
    piece.marks.axes = false;
    const int height = axes_.texture.size().height + axes_.below;
    show(axes_, place.picture.x0 + units(axes_.x), place.all.y1 - units(height));
  }
  if (wanted.scale_bar) {
    piece.marks.scale_bar = true;
    piece.size = {picture.width, kScaleBarHeight * line};
    piece.of = picture;
    if (has_moved || scale_bar_.texture.is_empty())
      scale_bar_ = drawn(document, document.view, xray_ranges[1], piece);
    piece.marks.scale_bar = false;
    const Size size = scale_bar_.texture.size();
    show(scale_bar_, place.picture.x1 - units(size.width + scale_bar_.beside),
         place.all.y1 - units(size.height + scale_bar_.below));
  }
  const bool is_difference = document.compares() && document.compare == CompareMode::kDifference;
  if (!wanted.color_bar || is_difference || all.width <= kLeastWidthForBar * line) return;
  piece.marks.color_bar = true;
  piece.size = {kColorBarWidth * line, all.height};
  piece.of = all;
  if (cli::has_color_bar(document.view.look)) {
    if (has_changed || color_bar_.texture.is_empty())
      color_bar_ = drawn(document, document.view, xray_ranges[1], piece);
    width_at_right_ = units(color_bar_.texture.size().width + 2 * color_bar_.beside);
    show(color_bar_, place.all.x1 - units(color_bar_.texture.size().width + color_bar_.beside),
         place.all.y0 + units(color_bar_.y));
  }
  if (!document.compares() || document.compares_fit()) return;  // one look has one bar
  if (!cli::has_color_bar(document.other->view.look)) return;
  if (has_changed || other_color_bar_.texture.is_empty())
    other_color_bar_ = drawn(document, document.other->view, xray_ranges[0], piece);
  width_at_left_ = units(other_color_bar_.texture.size().width + 2 * other_color_bar_.beside);
  show(other_color_bar_, place.all.x0 + units(other_color_bar_.beside),
       place.all.y0 + units(other_color_bar_.y));
}

}  // namespace ovoid::viewer
