// SPDX-License-Identifier: Apache-2.0
#include "annotate/lettering.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ovoid/error.h"

namespace ovoid::annotate {
namespace {

// A pen of a twelfth of the size is a regular weight; under 1.15 pixels strokes break up.
constexpr double kPenPerSize = 0.085;
constexpr double kLeastPen = 1.15;
constexpr double kDotPerPen = 1.35;

double pen_of(double size_px) { return std::max(kLeastPen, kPenPerSize * size_px); }

void require(bool holds, const std::string& message) {
  if (!holds) throw Error(ErrorCode::kInvalidArgument, message);
}

}  // namespace

Measures measures_of(const Image& image, const MarkStyle& style) {
  const auto pixels = static_cast<std::size_t>(std::max(image.width, 0)) *
                      static_cast<std::size_t>(std::max(image.height, 0));
  require(pixels > 0 && image.rgba.size() == 4 * pixels,
          fmt::format("image.rgba has {} values: must have {} x {} x 4, not 0", image.rgba.size(),
                      image.height, image.width));
  require(std::isfinite(style.text_px) && style.text_px >= 0 && style.text_px <= 4096,
          fmt::format("text_px = {}: must be 0 to 4096", style.text_px));
  require(style.halo_opacity >= 0 && style.halo_opacity <= 1,
          fmt::format("halo_opacity = {}: must be 0 to 1", style.halo_opacity));
  require(style.halo_size >= 0 && style.halo_size <= 1,
          fmt::format("halo_size = {}: must be 0 to 1", style.halo_size));
  const double side = std::min(image.width, image.height);
  Measures measures{};
  measures.text =
      style.text_px > 0 ? style.text_px : std::min(std::max(10.0, side / 42), side / 12);
  measures.pen = std::max(1.0, 0.065 * measures.text);
  measures.halo = std::max(10 * style.halo_size, style.halo_size * measures.text);
  measures.paint = {style.ink, 1.0, style.halo, style.halo_opacity};
  return measures;
}

Lettering::Lettering(std::string_view text, double size_px)
    : text_(decode_utf8(text, kMost)), size_(size_px), unit_(kUnitsPerSize * size_px) {
  measure();
}

double Lettering::advance(char32_t character) const {
  return std::round(glyph_of(character).advance * unit_);
}

void Lettering::measure() {
  width_ = 0;
  for (const char32_t character : text_) width_ += advance(character);
  // The last letter's gap is not ink.
  if (!text_.empty()) width_ -= std::round((glyph_of(U'.').advance) * unit_);
}

double Lettering::cap_height() const noexcept { return std::round(kCapHeight * unit_); }

double Lettering::height(double units) const {
  constexpr std::array<double, 4> kLines = {kDescender, 0, kXHeight, kCapHeight};
  std::size_t above = 1;
  while (above + 1 < kLines.size() && units > kLines[above]) ++above;
  const double lo = std::round(kLines[above - 1] * unit_);
  const double hi = std::round(kLines[above] * unit_);
  const double t = (units - kLines[above - 1]) / (kLines[above] - kLines[above - 1]);
  return lo + t * (hi - lo);
}

void Lettering::shorten(double width_px) {
  if (width_ <= width_px) return;
  std::u32string kept = text_;
  do {
    kept.pop_back();
    text_ = kept + U'\u2026';
    measure();
  } while (width_ > width_px && !kept.empty());
}

void Lettering::write(Ink& ink, double left, double baseline) const {
  // Pen strokes along the baseline and on a letter's first stem fill whole pixels.
  double x = std::floor(left) + 0.5;
  const double y = std::floor(baseline) + 0.5;
  const double pen = pen_of(size_);
  for (const char32_t character : text_) {
    for (const std::vector<Vec2>& way : glyph_of(character).strokes) {
      const auto place = [&](const Vec2& p) { return Vec2(x + p.x() * unit_, y - height(p.y())); };
      if (way.size() == 1) ink.line(place(way[0]), place(way[0]), kDotPerPen * pen);
      for (std::size_t i = 1; i < way.size(); ++i) {
        ink.line(place(way[i - 1]), place(way[i]), pen);
      }
    }
    x += advance(character);
  }
}

void Lettering::write_at(Ink& ink, const Vec2& at, double align) const {
  write(ink, std::round(at.x() - align * width_), std::round(at.y() + cap_height() / 2 - 0.5));
}

}  // namespace ovoid::annotate
