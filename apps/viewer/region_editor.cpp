// SPDX-License-Identifier: Apache-2.0
#include "region_editor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::viewer {
namespace {

constexpr float kPlotHeight = 200;  // before the interface's scale, as all lengths here
constexpr float kMargin = 6;        // room for grips at the ends
constexpr float kFeet = 9;          // and for those below the axis
constexpr float kGrip = 4;

struct Plot {
  PlaneCanvas plane;
  ImVec2 lo, hi;  // of the whole canvas
  PlanePlace mouse;
  bool is_hovered = false;
  bool is_pressed = false, is_held = false, is_double = false, is_right = false;
};

Plot begin_plot(Widgets& widgets, const std::string& name, const PlaneAxes& axes) {
  const float scale = widgets.scale();
  Plot plot;
  plot.lo = ImGui::GetCursorScreenPos();
  const float below = (kFeet + kGrip) * scale + ImGui::GetTextLineHeight();
  const ImVec2 size(std::max(ImGui::GetContentRegionAvail().x, 40.0F),
                    (kPlotHeight + kMargin) * scale + below);
  plot.hi = {plot.lo.x + size.x, plot.lo.y + size.y};
  ImGui::InvisibleButton(("##" + name).c_str(), size,
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
  const Box2 inside{plot.lo.x + kMargin * scale, plot.lo.y + kMargin * scale,
                    plot.hi.x - kMargin * scale, plot.hi.y - below};
  widgets.mark(name, inside);
  plot.plane = {axes, inside.x0, inside.y0, inside.x1, inside.y1};
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  plot.mouse = {mouse.x, mouse.y};
  plot.is_hovered = ImGui::IsItemHovered();
  plot.is_held = ImGui::IsItemActive() && ImGui::IsMouseDown(ImGuiMouseButton_Left);
  plot.is_pressed = ImGui::IsItemActivated() && ImGui::IsMouseDown(ImGuiMouseButton_Left);
  plot.is_double = plot.is_hovered && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
  plot.is_right = plot.is_hovered && ImGui::IsMouseClicked(ImGuiMouseButton_Right);
  return plot;
}

bool is_remove_pressed() {
#if IMGUI_VERSION_NUM < 18700
  const bool is_pressed = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Delete));
#else
  const bool is_pressed = ImGui::IsKeyPressed(ImGuiKey_Delete);
#endif
  return is_pressed && !ImGui::GetIO().WantTextInput;
}

// Without regions there is no function, so the last one stays.
bool remove_region(std::vector<LookRegion>& regions, int index, RegionEditing& editing) {
  if (index < 0 || index >= static_cast<int>(regions.size()) || regions.size() < 2) return false;
  regions.erase(regions.begin() + index);
  editing.selected = -1;
  editing.held.reset();
  return true;
}

bool add_region(std::vector<LookRegion>& regions, LookRegion region, RegionEditing& editing) {
  if (regions.size() >= TransferFunction2D::kMaxRegions) return false;
  region.rgb = color_for_region(regions);
  regions.push_back(region);
  editing.selected = static_cast<int>(regions.size()) - 1;
  return true;
}

// What the mouse does to the region that is held, or makes.
bool drag_held(std::vector<LookRegion>& regions, const Plot& plot, RegionEditing& editing) {
  RegionEditing::Held& held = *editing.held;
  const PlanePoint to = plot.plane.at(plot.mouse.x, plot.mouse.y);
  if (held.hit.region >= 0) {
    if (held.hit.region >= static_cast<int>(regions.size())) return false;
    regions[static_cast<std::size_t>(held.hit.region)] =
        moved_region(held.region, held.hit.grip, held.from, to, held.axes);
    return true;
  }
  const auto drawn = region_between(held.from, to, held.axes);
  if (!drawn || !add_region(regions, *drawn, editing)) return false;
  // From here on its corner is held, the one that the mouse is at.
  held.region = regions.back();
  held.hit.region = editing.selected;
  const bool is_right = to.value > held.from.value;
  const bool is_top = to.gradient > held.from.gradient;
  held.hit.grip = is_right ? (is_top ? Grip::kTopRight : Grip::kBottomRight)
                           : (is_top ? Grip::kTopLeft : Grip::kBottomLeft);
  held.from = to;
  return true;
}

bool take_mouse(std::vector<LookRegion>& regions, const Plot& plot, const Reach& reach,
                RegionEditing& editing) {
  if (!plot.is_held) editing.held.reset();
  const RegionHit under = region_under(regions, plot.plane, plot.mouse, editing.selected, reach);
  const PlanePoint at = plot.plane.at(plot.mouse.x, plot.mouse.y);
  if (plot.is_double && under.region < 0) {
    editing.held.reset();
    return add_region(regions, region_around(at, plot.plane.axes), editing);
  }
  if (plot.is_right) return remove_region(regions, under.region, editing);
  if (plot.is_pressed) {
    editing.selected = under.region;
    editing.held = RegionEditing::Held{under, {}, at, plot.plane.axes};
    if (under.region >= 0) editing.held->region = regions[static_cast<std::size_t>(under.region)];
    return false;
  }
  const ImVec2 moved = ImGui::GetIO().MouseDelta;
  if (editing.held && (moved.x != 0 || moved.y != 0)) return drag_held(regions, plot, editing);
  if (!editing.held && ImGui::IsWindowFocused() && !ImGui::IsAnyItemActive() && is_remove_pressed())
    return remove_region(regions, editing.selected, editing);
  return false;
}

std::uint8_t byte_of(float share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0F, 1.0F)));
}

// Rows of a picture begin at the top, those of what it is of at gradient 0.
template <class PixelOf>
void upload_rows(Texture& texture, int columns, int rows, const PixelOf& pixel_of) {
  std::vector<std::uint8_t> rgba(4 * static_cast<std::size_t>(columns) *
                                 static_cast<std::size_t>(rows));
  std::uint8_t* to = rgba.data();
  for (int row = rows - 1; row >= 0; --row) {
    for (int i = 0; i < columns; ++i, to += 4) pixel_of(row * columns + i, to);
  }
  texture.upload(rgba.data(), columns, rows);
}

void update_textures(const Widgets& widgets, const TransferFunction2D& function,
                     const RegionCanvas& canvas, RegionEditing& editing) {
  const ThemeColors& colors = widgets.colors();
  if (canvas.histogram &&
      (canvas.histogram != editing.counted || colors.canvas != editing.ground)) {
    const std::vector<float> brightness = cli::brightness_of(*canvas.histogram);
    const ImVec4 dark = ImGui::ColorConvertU32ToFloat4(colors.canvas);
    const ImVec4 bright = ImGui::ColorConvertU32ToFloat4(colors.faint);
    upload_rows(editing.counts, cli::Histogram2D::kColumns, cli::Histogram2D::kRows,
                [&](int entry, std::uint8_t* to) {
                  const float t = brightness[static_cast<std::size_t>(entry)];
                  to[0] = byte_of(std::lerp(dark.x, bright.x, t));
                  to[1] = byte_of(std::lerp(dark.y, bright.y, t));
                  to[2] = byte_of(std::lerp(dark.z, bright.z, t));
                  to[3] = 255;
                });
    editing.counted = canvas.histogram;
    editing.ground = colors.canvas;
  }
  const bool is_colored =
      editing.colored && editing.colored->entries().data() == function.entries().data();
  if (is_colored) return;
  upload_rows(editing.colors, function.values().count, function.gradients().count,
              [&](int entry, std::uint8_t* to) {
                // Between 0 and 0.01 is where much is decided: as in curves with more room there.
                constexpr float kMost = 0.8F;
                const auto& from = function.entries()[static_cast<std::size_t>(entry)];
                for (std::size_t c = 0; c < 3; ++c) to[c] = byte_of(from[c]);
                to[3] = byte_of(kMost * std::cbrt(from[3]));
              });
  editing.colored = function;
}

ImVec2 to_im(double x, double y) { return {static_cast<float>(x), static_cast<float>(y)}; }
ImVec2 to_im(const PlanePlace& place) { return to_im(place.x, place.y); }

void draw_picture(ImDrawList& list, const Texture& texture, const PlaneCanvas& plane,
                  const PlaneAxes& of, double gradient_lo) {
  list.AddImage(texture.id(), to_im(plane.x_of(of.value_lo), plane.y_of(of.gradient_hi)),
                to_im(plane.x_of(of.value_hi), plane.y_of(gradient_lo)));
}

void draw_axes(ImDrawList& list, const Plot& plot, const std::string& unit, Widgets& widgets) {
  const PlaneCanvas& plane = plot.plane;
  const ThemeColors& colors = widgets.colors();
  const float scale = widgets.scale();
  constexpr int kMostNumbers = 4;
  const ImU32 line = (colors.faint & ~IM_COL32_A_MASK) | (40U << IM_COL32_A_SHIFT);
  const float line_height = ImGui::GetTextLineHeight();
  for (const double value : round_numbers(plane.axes.value_lo, plane.axes.value_hi, kMostNumbers)) {
    const double x = plane.x_of(value);
    list.AddLine(to_im(x, plane.y0), to_im(x, plane.y1), line);
    std::string text = fmt::format("{:.5g}", value);
    const float width = ImGui::CalcTextSize(text.c_str()).x;
    const float left = std::clamp(static_cast<float>(x) - width / 2, plot.lo.x + 2,
                                  std::max(plot.hi.x - width - 2, plot.lo.x + 2));
    list.AddText({left, plot.hi.y - line_height}, colors.faint, text.c_str());
  }
  if (!unit.empty()) {
    const float width = ImGui::CalcTextSize(unit.c_str()).x;
    list.AddText(to_im(plane.x1 - width - 3 * scale, plane.y1 - line_height - 2), colors.faint,
                 unit.c_str());
  }
  for (const double gradient : round_numbers(0, plane.axes.gradient_hi, kMostNumbers)) {
    if (gradient == 0) continue;
    const double y = plane.y_of(gradient);
    list.AddLine(to_im(plane.x0, y), to_im(plane.x1, y), line);
    const std::string text = fmt::format("{:.5g}", gradient);
    const double under = y + line_height + 1 < plane.y1 ? y + 1 : y - line_height - 1;
    list.AddText(to_im(plane.x0 + 3 * scale, under), colors.faint, text.c_str());
  }
}

void draw_outline(ImDrawList& list, const LookRegion& region, const PlaneCanvas& plane, ImU32 color,
                  float thickness) {
  const auto corners = outline_of(region, plane);
  for (std::size_t i = 0; i < corners.size(); ++i)
    list.AddLine(to_im(corners[i]), to_im(corners[(i + 1) % corners.size()]), color, thickness);
}

void draw_grips(ImDrawList& list, const LookRegion& region, const Plot& plot, const Reach& reach,
                const std::string& name, Widgets& widgets) {
  const ThemeColors& colors = widgets.colors();
  const float radius = kGrip * widgets.scale();
  for (const Grip grip : grips_of(region)) {
    const PlanePlace place = place_of(region, grip, plot.plane, reach.below);
    const bool is_in_sight = place.x > plot.lo.x - 1 && place.x < plot.hi.x + 1 &&
                             place.y > plot.lo.y - 1 && place.y < plot.hi.y + 1;
    if (!is_in_sight) continue;
    const ImVec2 at = to_im(place);
    if (grip == Grip::kLeftFoot || grip == Grip::kRightFoot) {
      list.AddQuadFilled({at.x, at.y - radius}, {at.x + radius, at.y}, {at.x, at.y + radius},
                         {at.x - radius, at.y}, colors.mark);
    } else {
      list.AddRectFilled({at.x - radius, at.y - radius}, {at.x + radius, at.y + radius},
                         colors.selected);
      list.AddRect({at.x - radius, at.y - radius}, {at.x + radius, at.y + radius},
                   colors.point_edge);
    }
    widgets.mark(fmt::format("{}.{}", name, name_of(grip)),
                 {at.x - 1, at.y - 1, at.x + 1, at.y + 1});
  }
}

void set_cursor(const RegionHit& under) {
  switch (under.grip) {
    case Grip::kNone:
      return;
    case Grip::kBody:
      return ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeAll);
    case Grip::kLeft:
    case Grip::kRight:
    case Grip::kLeftFoot:
    case Grip::kRightFoot:
      return ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    case Grip::kBottom:
    case Grip::kTop:
      return ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeNS);
    case Grip::kBottomLeft:
    case Grip::kTopRight:
      return ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeNESW);
    case Grip::kBottomRight:
    case Grip::kTopLeft:
      return ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeNWSE);
  }
}

void draw_regions(ImDrawList& list, const std::vector<LookRegion>& regions, const Plot& plot,
                  const Reach& reach, const std::string& name, Widgets& widgets,
                  const RegionEditing& editing) {
  const ThemeColors& colors = widgets.colors();
  list.PushClipRect(plot.lo, plot.hi, true);
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const LookRegion& region = regions[i];
    const bool is_selected = static_cast<int>(i) == editing.selected;
    draw_outline(list, region, plot.plane, is_selected ? colors.selected : colors.curve,
                 is_selected ? 2.0F : 1.0F);
    const ImVec2 middle = to_im(place_of(region, Grip::kBody, plot.plane, 0));
    widgets.mark(fmt::format("{}.{}", name, i),
                 {middle.x - 1, middle.y - 1, middle.x + 1, middle.y + 1});
  }
  if (editing.selected >= 0 && editing.selected < static_cast<int>(regions.size()))
    draw_grips(list, regions[static_cast<std::size_t>(editing.selected)], plot, reach, name,
               widgets);
  list.PopClipRect();
}

}  // namespace

bool take_regions(TransferFunction2D& function, std::vector<LookRegion> regions) {
  try {
    function = TransferFunction2D(std::move(regions));
    return true;
  } catch (const Error&) {  // numbers that were typed: too near each other, or not in order
    return false;
  }
}

bool edit_regions(Widgets& widgets, const std::string& name, TransferFunction2D& function,
                  const RegionCanvas& canvas, RegionEditing& editing) {
  const Plot plot = begin_plot(widgets, name, editing.held ? editing.held->axes : canvas.axes);
  const Reach reach{9.0 * widgets.scale(), static_cast<double>(kFeet * widgets.scale())};
  std::vector<LookRegion> regions = function.regions();
  bool is_changed = false;
  if (!regions.empty() && take_mouse(regions, plot, reach, editing))
    is_changed = take_regions(function, regions);
  update_textures(widgets, function, canvas, editing);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(plot.lo, plot.hi, widgets.colors().canvas, 3);
  const PlaneCanvas& plane = plot.plane;
  list.PushClipRect(to_im(plane.x0, plane.y0), to_im(plane.x1, plane.y1), true);
  if (canvas.histogram) {
    const cli::Histogram2D& counted = *canvas.histogram;
    draw_picture(list, editing.counts, plane,
                 {counted.value_lo, counted.value_hi, counted.gradient_hi}, 0);
  }
  // Entries lie at the ends of the axes, pixels reach half of one beyond their middles.
  const TransferFunction2D::Axis& values = function.values();
  const TransferFunction2D::Axis& gradients = function.gradients();
  const double half_value = (values.last - values.first) / (values.count - 1) / 2;
  const double half_gradient = (gradients.last - gradients.first) / (gradients.count - 1) / 2;
  draw_picture(
      list, editing.colors, plane,
      {values.first - half_value, values.last + half_value, gradients.last + half_gradient},
      gradients.first - half_gradient);
  list.PopClipRect();
  draw_axes(list, plot, canvas.unit, widgets);
  draw_regions(list, function.regions(), plot, reach, name, widgets, editing);
  if (plot.is_hovered || editing.held) {
    set_cursor(editing.held
                   ? editing.held->hit
                   : region_under(function.regions(), plane, plot.mouse, editing.selected, reach));
  }
  return is_changed;
}

}  // namespace ovoid::viewer
