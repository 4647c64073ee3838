// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "make_look.h"
#include "ovoid/error.h"
#include "panels.h"
#include "start_page.h"

namespace ovoid::viewer {

ValueAxis axis_of(const TransferFunction& tf, const ValueRange& range) {
  ValueAxis axis{tf.lo(), tf.hi(), tf.scale, tf.linear_width};
  if (!range.is_empty()) {
    axis.lo = std::min<double>(axis.lo, range.lo);
    axis.hi = std::max<double>(axis.hi, range.hi);
  }
  if (axis.scale == ValueScale::kLog && !(axis.lo > 0))
    axis.lo = tf.lo() > 0 ? tf.lo() : axis.hi * 1e-3;
  if (!(axis.hi > axis.lo)) axis.hi = axis.lo + 1;
  return axis;
}

void take_color_map(TransferFunction& tf, const std::string& name) {
  TransferFunction map = color_map(name);
  const double lo = tf.lo();
  const double hi = tf.hi();
  if (lo < hi) map.map_range(lo, hi, tf.scale, tf.linear_width);
  tf.colors = map.colors;
  tf.color_space = map.color_space;
  tf.below_color.reset();
  tf.above_color.reset();
}

bool range_editor(Panel& panel, const std::string& name, TransferFunction& tf) {
  Widgets& widgets = panel.widgets;
  double lo = tf.lo();
  double hi = tf.hi();
  bool is_moved = widgets.number(name + ".range.lo", "range from", &lo);
  is_moved |= widgets.number(name + ".range.hi", "to", &hi);
  int scale = static_cast<int>(tf.scale);
  double linear_width = tf.linear_width;
  bool is_scaled = widgets.choice(name + ".scale", "scale", {"linear", "log", "symlog"}, &scale);
  if (scale == static_cast<int>(ValueScale::kSymlog)) {
    is_scaled |= widgets.number(name + ".linear-width", "straight within", &linear_width,
                                {.lo = 1e-300, .is_logarithmic = true});
  }
  if (!is_moved && !is_scaled) return false;
  const auto wanted = static_cast<ValueScale>(scale);
  if (wanted == ValueScale::kLog && !(hi > 0)) return false;  // nothing has a logarithm
  if (wanted == ValueScale::kLog && !(lo > 0)) lo = hi * 1e-3;
  if (!(lo < hi)) return false;
  tf.map_range(lo, hi, wanted, linear_width);
  return true;
}

namespace {

constexpr std::array<Mode, 6> kModes = {Mode::kComposite, Mode::kXray, Mode::kMaximum,
                                        Mode::kMinimum,   Mode::kMean, Mode::kIsosurface};

TransferFunction& colors_of(Look& look) {
  return look.color_function ? *look.color_function : look.transfer_function;
}

// The selected point's numbers.
bool edit_point(Panel& panel, const std::string& name, std::vector<OpacityPoint>& points,
                CurveEditing& editing) {
  if (editing.selected < 0 || editing.selected >= static_cast<int>(points.size())) {
    ImGui::TextDisabled("Click: a new point. Right click: away with it.");
    return false;
  }
  Widgets& widgets = panel.widgets;
  OpacityPoint& point = points[static_cast<std::size_t>(editing.selected)];
  bool is_changed = widgets.number(name + ".value", "value", &point.x);
  is_changed |= widgets.number(name + ".opacity", "opacity", &point.opacity, {.lo = 0, .hi = 1});
  is_changed |= widgets.number(name + ".midpoint", "midpoint", &point.midpoint, {.lo = 0, .hi = 1});
  is_changed |=
      widgets.number(name + ".sharpness", "sharpness", &point.sharpness, {.lo = 0, .hi = 1});
  // Past its neighbours, if it was typed; it stays the one that is edited.
  auto at = static_cast<std::size_t>(editing.selected);
  for (; at > 0 && points[at].x < points[at - 1].x; --at) std::swap(points[at], points[at - 1]);
  for (; at + 1 < points.size() && points[at].x > points[at + 1].x; ++at)
    std::swap(points[at], points[at + 1]);
  editing.selected = static_cast<int>(at);
  return is_changed;
}

// Modes in which one sample makes the pixel: its opacity is no matter of thickness.
bool is_of_one_sample(Mode mode) {
  return mode == Mode::kMaximum || mode == Mode::kMinimum || mode == Mode::kMean;
}

// Between them and the others: what was faint in layers becomes visible, and faint again.
void swap_opacities(Panel& panel, bool was_one, bool is_one) {
  std::vector<OpacityPoint>& points = panel.document.view.look.transfer_function.opacities;
  if (was_one == is_one) return;
  if (!is_one) {
    if (panel.state.layered.size() == points.size()) points = panel.state.layered;
    return;
  }
  panel.state.layered = points;
  double greatest = 0;
  for (const OpacityPoint& point : points) greatest = std::max(greatest, point.opacity);
  if (greatest == 0) return;
  for (OpacityPoint& point : points) point.opacity /= greatest;
}

bool has_isovalue(const Look& look, double value) {
  return std::any_of(look.isosurfaces.begin(), look.isosurfaces.end(),
                     [&](const Isosurface& surface) { return surface.value == value; });
}

// Where there is most room between those that are there, half seen through.
void add_isosurface(Look& look, const ValueRange& range) {
  if (look.isosurfaces.empty()) look.isosurfaces = {{look.isovalue}};
  std::vector<double> values = {range.lo, range.hi};
  for (const Isosurface& surface : look.isosurfaces) values.push_back(surface.value);
  std::sort(values.begin(), values.end());
  std::size_t widest = 1;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] - values[i - 1] > values[widest] - values[widest - 1]) widest = i;
  }
  const double value = (values[widest - 1] + values[widest]) / 2;
  if (!has_isovalue(look, value)) look.isosurfaces.push_back({value, {}, 0.5});
}

bool edit_isosurface(Panel& panel, const std::string& name, Isosurface& surface) {
  Look& look = panel.document.view.look;
  Widgets& widgets = panel.widgets;
  const ValueRange range = panel.document.shown->field().value_range();
  bool is_changed = false;
  double value = surface.value;
  if (widgets.slider(name + ".value", "isovalue", &value, range.lo, range.hi) &&
      !has_isovalue(look, value)) {
    surface.value = value;
    is_changed = true;
  }
  is_changed |= widgets.slider(name + ".opacity", "opacity", &surface.opacity, 0, 1);
  bool has_color = surface.color.has_value();
  if (widgets.checkbox(name + ".own", "a colour of its own", &has_color)) {
    surface.color.reset();
    if (has_color) surface.color = look.transfer_function.color_at(surface.value);
    is_changed = true;
  }
  if (surface.color) is_changed |= widgets.color(name + ".color", "colour", &*surface.color);
  if (surface.color && is_changed) surface.color = in_bytes(*surface.color);
  return is_changed;
}

bool edit_isosurfaces(Panel& panel) {
  Look& look = panel.document.view.look;
  Widgets& widgets = panel.widgets;
  std::vector<Isosurface>& surfaces = look.isosurfaces;
  const ValueRange range = panel.document.shown->field().value_range();
  bool is_changed = false;
  if (surfaces.empty())
    is_changed = widgets.slider("look.isovalue", "isovalue", &look.isovalue, range.lo, range.hi);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const std::string name = fmt::format("look.iso.{}", i);
    ImGui::TextDisabled("isosurface %d", static_cast<int>(i) + 1);
    if (widgets.button_at_right(name + ".remove", "remove")) {
      surfaces.erase(surfaces.begin() + static_cast<std::ptrdiff_t>(i));
      is_changed = true;
      break;
    }
    is_changed |= edit_isosurface(panel, name, surfaces[i]);
  }
  // One that is like any other needs no list.
  if (surfaces.size() == 1 && !surfaces[0].color && surfaces[0].opacity == 1) {
    look.isovalue = surfaces[0].value;
    surfaces.clear();
  }
  if (widgets.button("look.iso.add", "add an isosurface",
                     surfaces.size() < Look::kMaxIsosurfaces)) {
    add_isosurface(look, range);
    is_changed = true;
  }
  widgets.tip("Outer ones that are seen through show inner ones.");
  return is_changed;
}

bool choose_mode(Panel& panel) {
  Look& look = panel.document.view.look;
  int mode = static_cast<int>(std::find(kModes.begin(), kModes.end(), look.mode) - kModes.begin());
  const bool is_changed = panel.widgets.choice(
      "look.mode", "mode", {"composite", "x-ray", "maximum", "minimum", "mean", "isosurface"},
      &mode);
  if (is_changed) {
    const Mode before = std::exchange(look.mode, kModes[static_cast<std::size_t>(mode)]);
    change_mode_2d(panel, look.mode);
    swap_opacities(panel, is_of_one_sample(before), is_of_one_sample(look.mode));
    const ValueRange range = panel.document.shown->field().value_range();
    if (look.mode == Mode::kIsosurface && !(look.isovalue > range.lo && look.isovalue < range.hi))
      look.isovalue = (static_cast<double>(range.lo) + range.hi) / 2;
  }
  if (look.mode != Mode::kIsosurface) return is_changed;
  return edit_isosurfaces(panel) || is_changed;
}

bool opacity_editor(Panel& panel) {
  Document& document = panel.document;
  TransferFunction& tf = document.view.look.transfer_function;
  CurveLook look;
  if (document.extras) look.histogram = &document.extras->histogram;
  look.is_log_count = panel.state.is_log_count;
  look.is_magnified = panel.state.is_magnified;
  const Look& shown = document.view.look;
  if (shown.mode == Mode::kIsosurface && shown.isosurfaces.empty()) look.marks = {shown.isovalue};
  if (shown.mode == Mode::kIsosurface) {
    for (const Isosurface& surface : shown.isosurfaces) look.marks.push_back(surface.value);
  }
  const ValueAxis axis = axis_of(tf, document.shown->field().value_range());
  bool is_changed =
      edit_opacities(panel.widgets, "look.opacity", tf.opacities, axis, look, panel.state.opacity);
  if (!document.view.look.color_function)
    is_changed |= edit_colors(panel.widgets, "look.colors", tf, axis, panel.state.colors);
  ImGui::TextDisabled("%.5g", axis.lo);
  const std::string hi = fmt::format("{:.5g} {}", axis.hi, document.shown->subject.unit);
  ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(hi.c_str()).x);
  ImGui::TextDisabled("%s", hi.c_str());
  panel.widgets.checkbox("look.log-count", "log counts", &panel.state.is_log_count);
  ImGui::SameLine();
  panel.widgets.checkbox("look.magnify", "room for low opacities", &panel.state.is_magnified);
  is_changed |= edit_point(panel, "look.point", tf.opacities, panel.state.opacity);
  return is_changed;
}

bool color_editor(Panel& panel) {
  Document& document = panel.document;
  Look& look = document.view.look;
  TransferFunction& tf = colors_of(look);
  Widgets& widgets = panel.widgets;
  bool is_changed = false;
  if (look.color_function) {
    const ValueAxis axis = axis_of(tf, document.shown->field().color_range());
    is_changed |= edit_colors(widgets, "look.colors", tf, axis, panel.state.colors);
  }
  if (choose_color_map(widgets, "look.map", "colours", &panel.state.color_map)) {
    take_color_map(tf, panel.state.color_map);
    is_changed = true;
  }
  const int selected = panel.state.colors.selected;
  if (selected >= 0 && selected < static_cast<int>(tf.colors.size())) {
    ColorPoint& point = tf.colors[static_cast<std::size_t>(selected)];
    is_changed |= widgets.color("look.color.rgb", "colour", &point.rgb);
    if (widgets.number("look.color.value", "at value", &point.x)) {
      tf.sort();
      is_changed = true;
    }
  }
  return is_changed;
}

// How much of the light arrives, whether it lights or dims.
bool arriving_light_editor(Widgets& widgets, Look& look) {
  // What they are made from knows no gradients.
  if (look.transfer_function_2d && look.occlusion == 0 && look.shadows == 0) return false;
  bool is_changed = widgets.slider("look.occlusion", "occlusion", &look.occlusion, 0, 1);
  is_changed |= widgets.slider("look.shadows", "shadows", &look.shadows, 0, 1);
  if (look.shadows > 0)
    is_changed |= widgets.slider("look.scatter", "scatter", &look.scatter, 0, 1);
  return is_changed;
}

bool light_editor(Panel& panel) {
  Look& look = panel.document.view.look;
  Widgets& widgets = panel.widgets;
  bool is_changed = widgets.checkbox("look.shade", "light", &look.shade);
  if (!look.shade) return arriving_light_editor(widgets, look) || is_changed;
  Material& material = look.material;
  is_changed |= widgets.slider("look.ambient", "ambient", &material.ambient, 0, 1);
  is_changed |= widgets.slider("look.diffuse", "diffuse", &material.diffuse, 0, 1);
  is_changed |= widgets.slider("look.specular", "specular", &material.specular, 0, 1);
  is_changed |= widgets.slider("look.power", "specular power", &material.specular_power, 1, 100);
  bool is_studio = look.light == Light::kStudio;
  if (widgets.checkbox("look.studio", "key and fill light", &is_studio)) {
    look.light = is_studio ? Light::kStudio : Light::kSingle;
    is_changed = true;
  }
  is_changed |= arriving_light_editor(widgets, look);
  is_changed |= widgets.slider("look.flat", "even light below a rise of", &look.flat_rise, 0, 0.2);
  bool is_headlight = !look.light_direction.has_value();
  if (widgets.checkbox("look.headlight", "light moves with the camera", &is_headlight)) {
    look.light_direction.reset();
    const Camera& camera = panel.document.camera;
    if (!is_headlight)
      look.light_direction = (camera.position - camera.focal_point).normalized() + camera.view_up;
    is_changed = true;
  }
  if (look.light_direction) {
    Vec3 direction = *look.light_direction;
    if (widgets.vector("look.light", "light from", &direction, 0.01) && direction.norm() > 1e-6) {
      look.light_direction = direction;
      is_changed = true;
    }
  }
  return is_changed;
}

bool gradient_editor(Panel& panel) {
  Document& document = panel.document;
  TransferFunction& tf = document.view.look.transfer_function;
  Widgets& widgets = panel.widgets;
  // Steeper than the whole range within one spacing nothing is.
  const ValueRange range = document.shown->field().value_range();
  const double spacing = document.shown->field().default_sampling_distance();
  const double steepest = std::max((static_cast<double>(range.hi) - range.lo) / spacing, 1e-30);
  bool is_on = !tf.gradient_opacities.empty();
  bool is_changed = false;
  if (widgets.checkbox("look.gradient", "opacity by gradient", &is_on)) {
    tf.gradient_opacities.clear();
    if (is_on) tf.gradient_opacities = {{0, 0}, {steepest / 8, 1}};
    panel.state.gradient = {};
    is_changed = true;
  }
  widgets.tip(
      "Factor on the opacity by the steepness of the field: shows boundaries, hides what "
      "is even.");
  if (!is_on) return is_changed;
  CurveLook look;
  look.height = 70;
  ValueAxis axis{0, steepest / 2};
  axis.hi = std::max(axis.hi, tf.gradient_opacities.back().x);
  is_changed |= edit_opacities(widgets, "look.gradient.curve", tf.gradient_opacities, axis, look,
                               panel.state.gradient);
  is_changed |=
      edit_point(panel, "look.gradient.point", tf.gradient_opacities, panel.state.gradient);
  return is_changed;
}

bool presets(Panel& panel) {
  Document& document = panel.document;
  static const std::vector<std::string> names = look_preset_names();
  std::vector<const char*> options = {"what suits the data"};
  for (const std::string& name : names) options.push_back(name.c_str());
  int chosen = -1;
  if (!panel.widgets.choice("look.preset", "preset", options, &chosen)) return false;
  const Field& field = document.shown->field();
  Look& look = document.view.look;
  if (look.transfer_function_2d) leave_2d(panel);
  const Look before = look;
  const std::string& unit = document.shown->subject.unit;
  const bool is_cinematic =
      chosen > 0 && names[static_cast<std::size_t>(chosen - 1)] == kCinematicPreset;
  if (chosen == 0 || is_cinematic) {
    look = default_look(field, unit);
  } else {
    look = look_preset(names[static_cast<std::size_t>(chosen - 1)], field.value_range());
    cli::place_hounsfield_units(look.transfer_function, field, unit);
  }
  look.color_function = before.color_function;
  look.lighting() = before.lighting();
  if (is_cinematic) add_cinematic_light(look);
  panel.state.opacity = panel.state.gradient = panel.state.colors = {};
  return true;
}

void look_files(Panel& panel) {
  Widgets& widgets = panel.widgets;
  widgets.text("look.path", "look file", &panel.state.look_path, -164 * widgets.scale());
  widgets.tip("ParaView's JSON. Read: also looks of 3D Slicer and Inviwo. Or drop a file here.");
  ImGui::SameLine();
  if (widgets.button("look.read", "read")) panel.wishes.read_look = panel.state.look_path;
  ImGui::SameLine();
  if (widgets.button("look.write", "write")) panel.wishes.write_look = panel.state.look_path;
  ImGui::SameLine();
  browse_button(panel, "look.browse", "browse", Browsing::kLook);
}

// Of a mesh: its surface around what is in it.
bool surface_editor(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  if (!document.shown->subject.has_walls) return false;
  View& view = document.view;
  bool is_changed = widgets.checkbox("look.surface", "surface", &view.draws_surface);
  widgets.tip("Where the mesh ends; see-through, with what is in it. Cuts get lids.");
  if (view.draws_surface) {
    is_changed |=
        widgets.slider("look.surface-opacity", "of opacity", &view.surface.opacity, 0.05, 1);
    is_changed |= widgets.checkbox("look.edges", "with edges", &view.surface.shows_edges);
  }
  ImGui::Separator();
  return is_changed;
}

// Of particles and kernels: themselves instead of their field.
bool points_editor(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  if (!document.shown->subject.has_points) return false;
  View& view = document.view;
  bool is_changed = widgets.checkbox("look.points", "points", &view.draws_points);
  widgets.tip("Each as an opaque ball in the colour of its own value.");
  if (view.draws_points)
    is_changed |= widgets.slider("look.point-size", "of size", &view.points.size, 0.1, 5);
  ImGui::Separator();
  return is_changed;
}

// Colours and opacities along the value.
bool curve_editors(Panel& panel) {
  bool is_changed = opacity_editor(panel);
  Look& look = panel.document.view.look;
  if (look.color_function) {  // opacity and colour each have values of their own
    is_changed |= range_editor(panel, "look.opacities", look.transfer_function);
    ImGui::Separator();
    is_changed |= color_editor(panel);
    is_changed |= range_editor(panel, "look", *look.color_function);
    ImGui::Separator();
  } else {
    is_changed |= color_editor(panel);
    is_changed |= range_editor(panel, "look", look.transfer_function);
  }
  if (look.mode == Mode::kComposite) is_changed |= way_to_regions(panel);
  return is_changed;
}

}  // namespace

Rgb in_bytes(const Rgb& rgb) {
  Rgb rounded = rgb;
  for (double& part : rounded) part = std::round(255 * part) / 255;
  return rounded;
}

bool choose_color_map(Widgets& widgets, const std::string& name, const char* label,
                      std::string* map) {
  static const std::vector<std::string> names = color_map_names();
  static const std::vector<TransferFunction> maps = [] {
    std::vector<TransferFunction> all;
    all.reserve(names.size());
    for (const std::string& each : names) all.push_back(color_map(each));
    return all;
  }();
  std::vector<const char*> options;
  options.reserve(names.size());
  for (const std::string& each : names) options.push_back(each.c_str());
  const auto strip = [&](int number) {
    const TransferFunction& shown = maps[static_cast<std::size_t>(number)];
    const ImVec2 hi = ImGui::GetItemRectMax();
    const ImVec2 lo(hi.x - 90 * widgets.scale(), ImGui::GetItemRectMin().y + 2);
    for (float x = lo.x; x < hi.x; x += 2) {
      const Rgb c = shown.color_at(static_cast<double>((x - lo.x) / (hi.x - lo.x)));
      ImGui::GetWindowDrawList()->AddRectFilled(
          {x, lo.y}, {x + 2, hi.y - 2},
          ImGui::ColorConvertFloat4ToU32(
              {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]), 1}));
    }
  };
  const auto found = std::find(names.begin(), names.end(), *map);
  int chosen = found == names.end() ? -1 : static_cast<int>(found - names.begin());
  if (!widgets.choice(name, label, options, &chosen, strip)) return false;
  *map = names[static_cast<std::size_t>(chosen)];
  return true;
}

void look_panel(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  if (widgets.button("look.undo", "undo", document.can_undo())) document.undo();
  widgets.tip("Changes of look, space and settings; not the camera (Ctrl+Z).");
  ImGui::SameLine();
  if (widgets.button("look.redo", "redo", document.can_redo())) document.redo();
  const bool has_own_looks =
      document.shows_channels(document.view) && !document.shown->channels.are_primaries();
  bool is_changed = !has_own_looks && presets(panel);
  is_changed |= choose_mode(panel);
  is_changed |= surface_editor(panel);
  is_changed |= points_editor(panel);
  Look& look = document.view.look;
  if (has_own_looks) {
    ImGui::TextWrapped("Each channel has a colour and a range of its own: tab scene.");
  } else {
    is_changed |= look.transfer_function_2d ? regions_editor(panel) : curve_editors(panel);
  }
  const Field& field = document.shown->field();
  double unit = unit_distance_of(look, field);
  if (widgets.number("look.unit-distance", "unit distance", &unit,
                     {.lo = 1e-300, .hi = 1e300, .speed = unit / 100, .is_logarithmic = true})) {
    look.unit_distance = unit;
    is_changed = true;
  }
  widgets.tip(
      "The length, in the data's own units, over which an opacity is meant. Larger: more "
      "transparent.");
  ImGui::Separator();
  is_changed |= light_editor(panel);
  if (!has_own_looks) {
    if (!look.transfer_function_2d) is_changed |= gradient_editor(panel);
    ImGui::Separator();
    look_files(panel);
  }
  if (is_changed) document.touch();
}

}  // namespace ovoid::viewer
