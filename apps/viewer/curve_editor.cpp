// SPDX-License-Identifier: Apache-2.0
#include "curve_editor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ovoid::viewer {
namespace {

constexpr float kHandle = 5;  // radius of a point
constexpr float kReach = 9;   // how near the mouse must come

double scaled(double value, const ValueAxis& axis) {
  switch (axis.scale) {
    case ValueScale::kLog:
      return std::log10(std::max(value, 1e-300));
    case ValueScale::kSymlog:
      return std::copysign(std::log10(1 + std::abs(value) / axis.linear_width), value);
    case ValueScale::kLinear:
      break;
  }
  return value;
}

double unscaled(double at, const ValueAxis& axis) {
  switch (axis.scale) {
    case ValueScale::kLog:
      return std::pow(10.0, at);
    case ValueScale::kSymlog:
      return std::copysign((std::pow(10.0, std::abs(at)) - 1) * axis.linear_width, at);
    case ValueScale::kLinear:
      break;
  }
  return at;
}

double height_of(double opacity, bool is_magnified) {
  return is_magnified ? std::cbrt(opacity) : opacity;
}
double opacity_at(double height, bool is_magnified) {
  const double clamped = std::clamp(height, 0.0, 1.0);
  return is_magnified ? clamped * clamped * clamped : clamped;
}

// A canvas of the panel's width, and where the mouse is in it.
struct Canvas {
  ImVec2 lo, hi;
  ImVec2 mouse;
  bool is_pressed = false;  // the left button, now, inside
  bool is_right_pressed = false;
  bool is_held = false;

  Canvas(Widgets& widgets, const std::string& name, float height) {
    lo = ImGui::GetCursorScreenPos();
    const ImVec2 size(std::max(ImGui::GetContentRegionAvail().x, 20.0F), height * widgets.scale());
    hi = ImVec2(lo.x + size.x, lo.y + size.y);
    ImGui::InvisibleButton(("##" + name).c_str(), size,
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
    widgets.mark(name);
    mouse = ImGui::GetIO().MousePos;
    is_held = ImGui::IsItemActive() && ImGui::IsMouseDown(ImGuiMouseButton_Left);
    is_pressed = ImGui::IsItemActivated() && ImGui::IsMouseDown(ImGuiMouseButton_Left);
    is_right_pressed = ImGui::IsItemHovered() && ImGui::IsMouseClicked(ImGuiMouseButton_Right);
  }
  // Room for the handles of points at the ends, and of those that are clear or opaque.
  float inset = 6;
  float x_of(double place) const {
    return lo.x + inset + static_cast<float>(place) * (hi.x - lo.x - 2 * inset);
  }
  float y_of(double height) const {
    return hi.y - inset - static_cast<float>(height) * (hi.y - lo.y - 2 * inset);
  }
  double place_of(float x) const {
    return static_cast<double>((x - lo.x - inset) / (hi.x - lo.x - 2 * inset));
  }
  double place_of_mouse() const { return std::clamp(place_of(mouse.x), 0.0, 1.0); }
  double height_of_mouse() const { return (hi.y - inset - mouse.y) / (hi.y - lo.y - 2 * inset); }
};

void draw_histogram(ImDrawList& list, const Canvas& canvas, const CurveLook& look,
                    const ValueAxis& axis, ImU32 color) {
  const cli::Histogram& histogram = *look.histogram;
  const bool is_by_decades =
      axis.scale != ValueScale::kLinear && !histogram.logarithmic.counts.empty();
  const cli::Histogram::Bins& bins = is_by_decades ? histogram.logarithmic : histogram.linear;
  if (bins.greatest == 0) return;
  const auto height = [&](std::uint64_t count) {
    const auto all = static_cast<double>(bins.greatest);
    const auto some = static_cast<double>(count);
    return look.is_log_count ? std::log1p(some) / std::log1p(all) : some / all;
  };
  const double width = (bins.hi - bins.lo) / static_cast<double>(bins.counts.size());
  // Bars meet: their ends are whole pixels.
  const auto end_of = [&](std::size_t bin) {
    const double at = bins.lo + width * static_cast<double>(bin);
    const double place = axis.place_of(is_by_decades ? std::pow(10.0, at) : at);
    return std::floor(canvas.x_of(std::clamp(place, -0.1, 1.1)));
  };
  for (std::size_t i = 0; i < bins.counts.size(); ++i) {
    if (bins.counts[i] == 0) continue;
    const float x0 = end_of(i);
    const float x1 = std::max(end_of(i + 1), x0 + 1);
    list.AddRectFilled({x0, canvas.y_of(0.97 * height(bins.counts[i]))}, {x1, canvas.hi.y}, color);
  }
}

void draw_curve(ImDrawList& list, const Canvas& canvas, const std::vector<OpacityPoint>& points,
                const ValueAxis& axis, bool is_magnified, ImU32 color) {
  TransferFunction curve;
  curve.opacities = points;
  curve.scale = axis.scale;
  curve.linear_width = axis.linear_width;
  std::vector<ImVec2> line;
  for (float x = canvas.lo.x; x <= canvas.hi.x; x += 1) {
    const double place = canvas.place_of(x);
    const double opacity = points.empty() ? 1 : curve.opacity_at(axis.value_at(place));
    line.emplace_back(x, canvas.y_of(height_of(opacity, is_magnified)));
  }
  list.AddPolyline(line.data(), static_cast<int>(line.size()), color, 0, 1.5F);
}

int nearest_point(const Canvas& canvas, const std::vector<ImVec2>& places, float reach) {
  int nearest = -1;
  float least = reach * reach;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const float dx = places[i].x - canvas.mouse.x;
    const float dy = places[i].y - canvas.mouse.y;
    if (dx * dx + dy * dy > least) continue;
    least = dx * dx + dy * dy;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

bool is_delete_pressed() {
  return !ImGui::GetIO().WantTextInput && ImGui::IsKeyPressed(
#if IMGUI_VERSION_NUM < 18700
                                              ImGui::GetKeyIndex(ImGuiKey_Delete)
#else
                                              ImGuiKey_Delete
#endif
                                          );
}

// A point stays between its neighbours, so that its number stays what it is.
template <typename Point>
double between_neighbours(const std::vector<Point>& points, int index, double x) {
  const auto at = static_cast<std::size_t>(index);
  if (at > 0) x = std::max(x, points[at - 1].x);
  if (at + 1 < points.size()) x = std::min(x, points[at + 1].x);
  return x;
}

template <typename Point>
int insert_sorted(std::vector<Point>& points, const Point& point) {
  const auto at = std::upper_bound(points.begin(), points.end(), point,
                                   [](const Point& a, const Point& b) { return a.x < b.x; });
  const auto inserted = points.insert(at, point);  // which moves the beginning
  return static_cast<int>(inserted - points.begin());
}

template <typename Point>
bool remove_point(std::vector<Point>& points, int index, std::size_t fewest,
                  CurveEditing& editing) {
  if (index < 0 || points.size() <= fewest) return false;
  points.erase(points.begin() + index);
  editing = {};
  return true;
}

}  // namespace

double ValueAxis::place_of(double value) const {
  const double a = scaled(lo, *this);
  return (scaled(value, *this) - a) / (scaled(hi, *this) - a);
}

double ValueAxis::value_at(double place) const {
  const double a = scaled(lo, *this);
  return unscaled(a + place * (scaled(hi, *this) - a), *this);
}

bool edit_opacities(Widgets& widgets, const std::string& name, std::vector<OpacityPoint>& points,
                    const ValueAxis& axis, const CurveLook& look, CurveEditing& editing) {
  const Canvas canvas(widgets, name, look.height);
  const ThemeColors& colors = widgets.colors();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(canvas.lo, canvas.hi, colors.canvas, 3);
  list.PushClipRect(canvas.lo, canvas.hi, true);
  if (look.histogram != nullptr) draw_histogram(list, canvas, look, axis, colors.histogram);
  for (const double value : look.marks) {
    const float x = canvas.x_of(axis.place_of(value));
    list.AddLine({x, canvas.lo.y}, {x, canvas.hi.y}, colors.mark);
  }
  bool is_changed = false;
  std::vector<ImVec2> places;
  places.reserve(points.size());
  for (const OpacityPoint& point : points) {
    places.emplace_back(canvas.x_of(axis.place_of(point.x)),
                        canvas.y_of(height_of(point.opacity, look.is_magnified)));
  }
  const int near = nearest_point(canvas, places, kReach * widgets.scale());
  if (canvas.is_pressed) {
    if (near < 0) {
      const double value = axis.value_at(canvas.place_of_mouse());
      editing.dragged = insert_sorted(
          points, OpacityPoint{value, opacity_at(canvas.height_of_mouse(), look.is_magnified)});
      is_changed = true;
    } else {
      editing.dragged = near;
    }
    editing.selected = editing.dragged;
  } else if (!canvas.is_held) {
    editing.dragged = -1;
  }
  const bool is_moved = ImGui::GetIO().MouseDelta.x != 0 || ImGui::GetIO().MouseDelta.y != 0;
  if (editing.dragged >= 0 && editing.dragged < static_cast<int>(points.size()) &&
      !canvas.is_pressed && is_moved) {
    OpacityPoint& point = points[static_cast<std::size_t>(editing.dragged)];
    point.x = between_neighbours(points, editing.dragged, axis.value_at(canvas.place_of_mouse()));
    point.opacity = opacity_at(canvas.height_of_mouse(), look.is_magnified);
    is_changed = true;
  }
  if (canvas.is_right_pressed) is_changed |= remove_point(points, near, 1, editing);
  if (editing.selected >= 0 && editing.dragged < 0 && ImGui::IsWindowFocused() &&
      !ImGui::IsAnyItemActive() && is_delete_pressed())
    is_changed |= remove_point(points, editing.selected, 1, editing);
  draw_curve(list, canvas, points, axis, look.is_magnified, colors.curve);
  list.PopClipRect();
  const float radius = kHandle * widgets.scale();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double place = axis.place_of(points[i].x);
    if (place < -0.01 || place > 1.01) continue;
    const ImVec2 at(canvas.x_of(place),
                    canvas.y_of(height_of(points[i].opacity, look.is_magnified)));
    const bool is_selected = static_cast<int>(i) == editing.selected;
    list.AddCircleFilled(at, radius, is_selected ? colors.selected : colors.point);
    list.AddCircle(at, radius, colors.point_edge);
    widgets.mark(fmt::format("{}.{}", name, i), {at.x - 1, at.y - 1, at.x + 1, at.y + 1});
  }
  return is_changed;
}

bool edit_colors(Widgets& widgets, const std::string& name, TransferFunction& tf,
                 const ValueAxis& axis, CurveEditing& editing) {
  constexpr float kStrip = 16;
  constexpr float kBelow = 10;  // where the handles are
  const Canvas canvas(widgets, name, kStrip + kBelow);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float bottom = canvas.lo.y + kStrip * widgets.scale();
  for (float x = canvas.lo.x; x < canvas.hi.x; x += 2) {
    const double place = canvas.place_of(x);
    const Rgb color = tf.color_at(axis.value_at(place));
    list.AddRectFilled({x, canvas.lo.y}, {std::min(x + 2, canvas.hi.x), bottom},
                       ImGui::ColorConvertFloat4ToU32(ImVec4(static_cast<float>(color[0]),
                                                             static_cast<float>(color[1]),
                                                             static_cast<float>(color[2]), 1)));
  }
  // Maps of many points are moved by their range, not by hand.
  constexpr std::size_t kMostHandles = 32;
  if (tf.colors.size() > kMostHandles) return false;
  bool is_changed = false;
  int near = -1;
  float least = kReach * widgets.scale();
  for (std::size_t i = 0; i < tf.colors.size(); ++i) {
    const float distance = std::abs(canvas.x_of(axis.place_of(tf.colors[i].x)) - canvas.mouse.x);
    if (distance > least) continue;
    least = distance;
    near = static_cast<int>(i);
  }
  if (canvas.is_pressed) {
    if (near < 0) {
      const double value = axis.value_at(canvas.place_of_mouse());
      near = insert_sorted(tf.colors, ColorPoint{value, tf.color_at(value)});
      is_changed = true;
    }
    editing.selected = editing.dragged = near;
  } else if (!canvas.is_held) {
    editing.dragged = -1;
  }
  if (editing.dragged >= 0 && editing.dragged < static_cast<int>(tf.colors.size()) &&
      !canvas.is_pressed && ImGui::GetIO().MouseDelta.x != 0) {
    tf.colors[static_cast<std::size_t>(editing.dragged)].x =
        between_neighbours(tf.colors, editing.dragged, axis.value_at(canvas.place_of_mouse()));
    is_changed = true;
  }
  if (canvas.is_right_pressed) is_changed |= remove_point(tf.colors, near, 2, editing);
  for (std::size_t i = 0; i < tf.colors.size(); ++i) {
    const float x = canvas.x_of(axis.place_of(tf.colors[i].x));
    if (x < canvas.lo.x - 1 || x > canvas.hi.x + 1) continue;
    const float half = 5 * widgets.scale();
    const bool is_selected = static_cast<int>(i) == editing.selected;
    list.AddTriangleFilled({x, bottom}, {x - half, canvas.hi.y}, {x + half, canvas.hi.y},
                           is_selected ? widgets.colors().selected : widgets.colors().point);
    widgets.mark(fmt::format("{}.{}", name, i),
                 {x - 1, canvas.hi.y - half, x + 1, canvas.hi.y - 1});
  }
  return is_changed;
}

}  // namespace ovoid::viewer
