// SPDX-License-Identifier: Apache-2.0
// The colour bar: what colour and opacity stand for.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "annotate/lettering.h"
#include "annotate/ticks.h"
#include "ovoid/annotate.h"
#include "ovoid/error.h"
#include "view/look/isosurfaces.h"

namespace ovoid {
namespace {

using annotate::Ink;
using annotate::Lettering;
using annotate::Measures;
using annotate::Tick;
using annotate::TickScale;
using annotate::Vec2;

// In sizes of the text.
constexpr double kMargin = 1.0;  // to the picture's border
constexpr double kBarWidth = 1.15;
constexpr double kTickLength = 0.35;
constexpr double kLabelGap = 0.4;      // from a tick to its label
constexpr double kOpacityWidth = 1.6;  // of the curve's greatest value
constexpr double kEndLength = 0.9;     // of the pointed ends
constexpr double kMinLabelDistance = 1.25;
constexpr double kEntryPitch = 1.6;
// Of the picture.
constexpr double kBarHeight = 0.6;
constexpr double kTitleWidth = 0.6;
constexpr double kLabelWidth = 0.3;

bool has_opacity(Mode mode) { return mode != Mode::kXray && mode != Mode::kIsosurface; }

bool is_lit(const Look& look) {
  return look.shade && (look.mode == Mode::kComposite || look.mode == Mode::kIsosurface);
}

Rgb lit(const Look& look, Rgb color) {
  if (!is_lit(look)) return color;
  for (double& component : color) {
    component = std::clamp(component * (look.material.ambient + look.material.diffuse), 0.0, 1.0);
  }
  return color;
}

TickScale scale_of(const Look& look, const ColorBar& bar) {
  const TransferFunction& tf = look.transfer_function;
  const auto [lo, hi] = bar.range.value_or(std::pair{tf.lo(), tf.hi()});
  if (!(std::isfinite(lo) && std::isfinite(hi) && lo <= hi)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("colour bar range = {} to {}: must be finite and lo <= hi", lo, hi));
  }
  return {tf.scale, lo, hi, tf.linear_width};
}

void set_pixel(Image& image, int x, int y, const Rgb& color, double opacity) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  float* const pixel = &image.rgba[4 * (static_cast<std::size_t>(y) * image.width + x)];
  const std::array<double, 4> drawn = {color[0] * opacity, color[1] * opacity, color[2] * opacity,
                                       opacity};
  for (std::size_t c = 0; c < 4; ++c) {
    pixel[c] = static_cast<float>(drawn[c] + (1 - opacity) * pixel[c]);
  }
}

void fill(Image& image, const PixelBox& box, const Rgb& color) {
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) set_pixel(image, x, y, color, 1);
  }
}

void outline(Ink& ink, const PixelBox& box, double pen) {
  // Around the pixels, not over them.
  const double half = pen / 2;
  const Vec2 a(box.x0 - half, box.y0 - half);
  const Vec2 b(box.x1 + half, box.y1 + half);
  ink.line(a, {b.x(), a.y()}, pen);
  ink.line({b.x(), a.y()}, b, pen);
  ink.line(b, {a.x(), b.y()}, pen);
  ink.line({a.x(), b.y()}, a, pen);
}

std::string title_of(const ColorBar& bar) {
  if (bar.unit.empty()) return bar.title;
  return bar.title.empty() ? bar.unit : fmt::format("{} ({})", bar.title, bar.unit);
}

// One bar in one picture: its parts are laid out by the constructor and drawn in turn.
class RampDrawing {
 public:
  RampDrawing(Image& image, const Look& look, const ColorBar& bar, const Measures& measures);

  PixelBox draw();

 private:
  void lay_out();
  void make_labels();
  std::string text_of(double value) const;
  double y_of(double value) const;
  double value_in_row(int y) const;
  bool shows_opacity() const { return greatest_opacity_ > 0; }
  double opacity_curve_left(double value) const;

  void fill_ramp();
  void fill_opacity();
  void fill_end(int first_row, int step, const Rgb& color);
  void draw_curve(Ink& ink) const;
  void draw_labels(Ink& ink) const;
  void draw_isovalue(Ink& ink, double isovalue) const;
  void draw_title(Ink& ink) const;

  Image& image_;
  const Look& look_;
  const ColorBar& bar_;
  const Measures& m_;
  TickScale scale_;
  PixelBox ramp_;
  std::vector<Tick> labels_;
  double greatest_opacity_ = 0;  // 0: not shown
  double label_width_ = 0;
};

RampDrawing::RampDrawing(Image& image, const Look& look, const ColorBar& bar,
                         const Measures& measures)
    : image_(image), look_(look), bar_(bar), m_(measures), scale_(scale_of(look, bar)) {
  lay_out();
}

void RampDrawing::lay_out() {
  const int height = std::max(1, static_cast<int>(std::round(kBarHeight * image_.height)));
  ramp_.y0 = (image_.height - height) / 2;
  ramp_.y1 = ramp_.y0 + height;
  make_labels();
  for (const Tick& label : labels_) {
    label_width_ = std::max(label_width_, Lettering(label.label, m_.text).width());
  }
  const double right = image_.width - label_width_ - m_.text * (kMargin + kTickLength + kLabelGap);
  ramp_.x1 = static_cast<int>(std::round(right));
  ramp_.x0 = ramp_.x1 - std::max(1, static_cast<int>(std::round(kBarWidth * m_.text)));

  if (!has_opacity(look_.mode)) return;
  double least = 1;
  double greatest = 0;
  const auto look_at = [&](double value) {
    const double opacity = look_.transfer_function.opacity_at(value);
    least = std::min(least, opacity);
    greatest = std::max(greatest, opacity);
  };
  for (int y = ramp_.y0; y < ramp_.y1; ++y) look_at(value_in_row(y));
  // Rows are seen at their middles; peaks and ends lie between.
  look_at(scale_.lo());
  look_at(scale_.hi());
  for (const OpacityPoint& point : look_.transfer_function.opacities) {
    if (point.x >= scale_.lo() && point.x <= scale_.hi()) look_at(point.x);
  }
  if (least < 1) greatest_opacity_ = greatest;
}

// To a five-hundredth of the range or less, which is less than a row of most bars. Over decades
// each value has a scale of its own: a thousandth of itself.
std::string RampDrawing::text_of(double value) const {
  if (!(scale_.lo() < scale_.hi())) return annotate::number_text(value);
  const double told =
      scale_.is_linear() ? (scale_.hi() / 2 - scale_.lo() / 2) / 250 : std::abs(value) * 1e-3;
  return annotate::number_text(value, annotate::round_below(std::max(told, 1e-307)));
}

// The range's ends, and between them the round values that leave room.
void RampDrawing::make_labels() {
  const double lo = scale_.lo();
  const double hi = scale_.hi();
  if (!(lo < hi)) {
    labels_ = {{lo, text_of(lo)}};
    return;
  }
  Tick low{lo, text_of(lo)};
  Tick high{hi, text_of(hi)};
  if (low.label == high.label) {
    low.label = annotate::number_text(lo);
    high.label = annotate::number_text(hi);
  }
  const double room = ramp_.y1 - ramp_.y0;
  const int most = std::clamp(static_cast<int>(room / (2.2 * m_.text)), 2, 11);
  labels_ = scale_.ticks(most);
  std::erase_if(labels_, [&](const Tick& tick) {
    const double y = scale_.place(tick.value) * room;
    return std::min(y, room - y) < kMinLabelDistance * m_.text;
  });
  labels_.insert(labels_.begin(), low);
  labels_.push_back(high);
}

double RampDrawing::y_of(double value) const {
  return ramp_.y1 - scale_.place(value) * (ramp_.y1 - ramp_.y0);
}

double RampDrawing::value_in_row(int y) const { return color_bar_value(look_, bar_, ramp_, y); }

double RampDrawing::opacity_curve_left(double value) const {
  const double part = look_.transfer_function.opacity_at(value) / greatest_opacity_;
  return ramp_.x0 - m_.pen - part * kOpacityWidth * m_.text;
}

void RampDrawing::fill_ramp() {
  for (int y = ramp_.y0; y < ramp_.y1; ++y) {
    fill(image_, {ramp_.x0, y, ramp_.x1, y + 1}, shown_color(look_, value_in_row(y)));
  }
}

void RampDrawing::fill_opacity() {
  for (int y = ramp_.y0; y < ramp_.y1; ++y) {
    const double value = value_in_row(y);
    const double left = opacity_curve_left(value);
    for (int x = static_cast<int>(std::floor(left)); x < ramp_.x0; ++x) {
      const double covered = std::clamp(x + 1 - left, 0.0, 1.0);
      set_pixel(image_, x, y, shown_color(look_, value), 0.6 * covered);
    }
  }
}

// Colours beyond the range: a triangle on the ramp's end.
void RampDrawing::fill_end(int first_row, int step, const Rgb& color) {
  const double length = kEndLength * m_.text;
  const double half = (ramp_.x1 - ramp_.x0) / 2.0;
  for (int i = 0; i < length; ++i) {
    const double reach = half * (1 - (i + 0.5) / length);
    for (int x = ramp_.x0; x < ramp_.x1; ++x) {
      const double covered =
          std::clamp(reach + 0.5 - std::abs(x + 0.5 - ramp_.x0 - half), 0.0, 1.0);
      set_pixel(image_, x, first_row + i * step, color, covered);
    }
  }
}

void RampDrawing::draw_curve(Ink& ink) const {
  Vec2 last;
  for (int y = ramp_.y0; y <= ramp_.y1; ++y) {
    const double value = value_in_row(std::min(y, ramp_.y1 - 1));
    const Vec2 here(opacity_curve_left(value), y);
    if (y > ramp_.y0) ink.line(last, here, m_.pen);
    last = here;
  }
  const double base = ramp_.x0 - m_.pen / 2;
  ink.line({opacity_curve_left(value_in_row(ramp_.y0)), ramp_.y0 * 1.0}, {base, ramp_.y0 * 1.0},
           m_.pen);
  ink.line({opacity_curve_left(value_in_row(ramp_.y1 - 1)), ramp_.y1 * 1.0}, {base, ramp_.y1 * 1.0},
           m_.pen);
}

void RampDrawing::draw_labels(Ink& ink) const {
  for (const Tick& label : labels_) {
    const double y = y_of(label.value);
    const double end = ramp_.x1 + m_.pen + kTickLength * m_.text;
    ink.line({ramp_.x1 + m_.pen / 2, y}, {end, y}, m_.pen);
    Lettering(label.label, m_.text).write_at(ink, {end + kLabelGap * m_.text, y}, 0);
  }
}

void RampDrawing::draw_isovalue(Ink& ink, double isovalue) const {
  if (!(isovalue >= scale_.lo() && isovalue <= scale_.hi())) return;
  const double y = y_of(isovalue);
  const double tip = ramp_.x0 - 1.5 * m_.pen;
  const double size = 0.45 * m_.text;
  const std::array<Vec2, 3> triangle = {Vec2(tip, y), Vec2(tip - 1.5 * size, y - size),
                                        Vec2(tip - 1.5 * size, y + size)};
  ink.convex(triangle);
  Lettering(text_of(isovalue), m_.text)
      .write_at(ink, {tip - 1.5 * size - kLabelGap * m_.text, y}, 1);
}

void RampDrawing::draw_title(Ink& ink) const {
  const double ends = look_.transfer_function.above_color ? kEndLength : 0;
  const double border = image_.width - kMargin * m_.text;
  Lettering title(title_of(bar_), m_.text);
  title.shorten(kTitleWidth * image_.width);
  title.write(ink, std::min<double>(ramp_.x0, border - title.width()),
              ramp_.y0 - (1.0 + ends) * m_.text);
  if (!shows_opacity()) return;
  const double below = look_.transfer_function.below_color ? kEndLength : 0;
  const Lettering caption(
      fmt::format("opacity to {}",
                  annotate::number_text(greatest_opacity_, greatest_opacity_ / 30)),
      0.85 * m_.text);
  caption.write(ink, std::min(ramp_.x0 - kOpacityWidth * m_.text, border - caption.width()),
                ramp_.y1 + (1.75 + below) * m_.text);
}

PixelBox RampDrawing::draw() {
  Ink ink(image_.width, image_.height, m_.halo);
  outline(ink, ramp_, m_.pen);
  draw_labels(ink);
  if (look_.mode == Mode::kIsosurface) {
    // Those with a colour of their own are none of the bar's.
    for (const Isosurface& surface : view::surfaces_of(look_)) {
      if (!surface.color) draw_isovalue(ink, surface.value);
    }
  }
  draw_title(ink);
  if (shows_opacity()) draw_curve(ink);
  // Colours last: the ink stands beside the ramp, but its halo would not stop there.
  if (shows_opacity()) fill_opacity();
  ink.over(image_, m_.paint);
  fill_ramp();
  const TransferFunction& tf = look_.transfer_function;
  if (tf.above_color) fill_end(ramp_.y0 - 1, -1, lit(look_, *tf.above_color));
  if (tf.below_color) fill_end(ramp_.y1, 1, lit(look_, *tf.below_color));
  return ramp_;
}

// Values that stand for themselves: a list, first entry on top.
PixelBox draw_entries(Image& image, const Look& look, const ColorBar& bar, const Measures& m) {
  const double pitch = kEntryPitch * m.text;
  const auto room = static_cast<std::size_t>(std::max(1.0, (image.height - 5 * m.text) / pitch));
  const bool is_cut = bar.entries.size() > room;
  const std::size_t shown = is_cut ? room - 1 : bar.entries.size();
  std::vector<Lettering> names;
  for (std::size_t i = 0; i < shown; ++i) {
    const ColorBarEntry& entry = bar.entries[i];
    names.emplace_back(entry.name.empty() ? annotate::number_text(entry.value) : entry.name,
                       m.text);
  }
  if (is_cut) {
    names.emplace_back(fmt::format("\u2026 {} more", bar.entries.size() - shown), m.text);
  }
  double width = 0;
  for (Lettering& name : names) {
    name.shorten(kLabelWidth * image.width);
    width = std::max(width, name.width());
  }
  const int side = std::max(1, static_cast<int>(std::round(kBarWidth * m.text)));
  const double border = image.width - kMargin * m.text;
  const int x0 = static_cast<int>(std::round(border - width - 0.6 * m.text)) - side;
  const int y0 =
      static_cast<int>(std::round((image.height - pitch * static_cast<double>(names.size())) / 2));

  Ink ink(image.width, image.height, m.halo);
  std::vector<PixelBox> swatches;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int y = y0 + static_cast<int>(std::round(pitch * static_cast<double>(i)));
    if (i < shown) {
      swatches.push_back({x0, y, x0 + side, y + side});
      outline(ink, swatches.back(), m.pen);
    }
    names[i].write_at(ink, {x0 + side + 0.6 * m.text, y + side / 2.0}, 0);
  }
  Lettering title(title_of(bar), m.text);
  title.shorten(kTitleWidth * image.width);
  title.write(ink, std::min<double>(x0, border - title.width()), y0 - 0.9 * m.text);
  ink.over(image, m.paint);
  for (std::size_t i = 0; i < swatches.size(); ++i) {
    fill(image, swatches[i], shown_color(look, bar.entries[i].value));
  }
  if (swatches.empty()) return {x0, y0, x0, y0};
  return {x0, swatches.front().y0, x0 + side, swatches.back().y1};
}

}  // namespace

Rgb shown_color(const Look& look, double value) {
  return lit(look, look.transfer_function.color_at(value));
}

double color_bar_value(const Look& look, const ColorBar& bar, const PixelBox& ramp, int y) {
  return scale_of(look, bar).value((ramp.y1 - y - 0.5) / (ramp.y1 - ramp.y0));
}

std::vector<ColorBarEntry> label_entries(const TransferFunction& transfer_function) {
  const std::vector<ColorPoint>& points = transfer_function.colors;
  std::vector<ColorBarEntry> entries;
  double label = 0;
  for (std::size_t i = 0; i + 1 < points.size(); i += 2) {
    const double lo = points[i].x;
    const double hi = points[i + 1].x;
    // The border lies as far above the label before it as below this one.
    label = i == 0 ? lo + 0.5 : 2 * lo - label;
    const bool is_joined = i == 0 || points[i - 1].x == lo;
    if (points[i].rgb != points[i + 1].rgb || !is_joined) return {};
    if (label != std::floor(label) || !(lo < label && label < hi)) return {};
    if (transfer_function.opacity_at(label) > 0)
      entries.push_back({label, annotate::number_text(label)});
  }
  const bool is_complete = points.size() >= 2 && points.size() % 2 == 0;
  if (!is_complete || points.back().x != label + 0.5) return {};
  return entries;
}

PixelBox draw_color_bar(Image& image, const Look& look, const ColorBar& bar,
                        const MarkStyle& style) {
  if (look.transfer_function_2d) {
    throw Error(ErrorCode::kUnsupported,
                "colour bar: a 2-D transfer function has no colours by value alone");
  }
  const Measures measures = annotate::measures_of(image, style);
  if (!bar.entries.empty()) return draw_entries(image, look, bar, measures);
  return RampDrawing(image, look, bar, measures).draw();
}

}  // namespace ovoid
