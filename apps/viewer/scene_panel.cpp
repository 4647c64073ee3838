// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "make_geometry.h"
#include "make_labels.h"
#include "panels.h"
#include "start_page.h"

namespace ovoid::viewer {
namespace {

void remove_at(auto& list, std::size_t i) {
  list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
}

// Of two digits, as a person would type it.
double short_number(double x) { return std::strtod(fmt::format("{:.2g}", x).c_str(), nullptr); }

void files_editor(Panel& panel) {
  Widgets& widgets = panel.widgets;
  PanelState& state = panel.state;
  bool adds = widgets.text("scene.path", "surface, labels, volume", &state.beside_path,
                           -118 * widgets.scale());
  ImGui::SameLine();
  adds |= widgets.button("scene.add", "add");
  widgets.tip(
      "In the data's own world, beside them: a surface (.stl, .obj, .ply, .vtp, a mesh), a "
      "segmentation, or another volume. Or drop the file while this tab is open.");
  if (adds) panel.wishes.add_beside = state.beside_path;
  ImGui::SameLine();
  browse_button(panel, "scene.browse", "browse", Browsing::kBeside);
  if (state.beside_error.empty()) return;
  ImGui::PushStyleColor(ImGuiCol_Text, widgets.colors().error);
  ImGui::TextWrapped("%s", state.beside_error.c_str());
  ImGui::PopStyleColor();
}

// The values that the map spans.
bool range_of_surface(Widgets& widgets, const std::string& name, AddedSurface& added) {
  bool is_usual = !added.range.has_value();
  bool is_changed = widgets.checkbox(name + ".range.usual", "over all values", &is_usual);
  if (is_changed) added.range = is_usual ? std::nullopt : std::optional(added.of->values);
  if (!added.range) return is_changed;
  auto [lo, hi] = *added.range;
  const NumberField field{.speed = std::max(hi - lo, 1e-30) / 400};
  bool is_moved = widgets.number(name + ".range.lo", "values from", &lo, field);
  is_moved |= widgets.number(name + ".range.hi", "to", &hi, field);
  if (is_moved && lo < hi) added.range = {lo, hi};
  return is_changed || is_moved;
}

// One, or a map's by the values of an array.
bool colors_of_surface(Widgets& widgets, const std::string& name, AddedSurface& added) {
  std::string& array = added.source.array;
  bool is_changed = false;
  const std::vector<std::string>& arrays = added.of->arrays;
  if (!arrays.empty()) {
    std::vector<const char*> options = {"one colour"};
    for (const std::string& each : arrays) options.push_back(each.c_str());
    const auto found = std::find(arrays.begin(), arrays.end(), array);
    int chosen = found == arrays.end() ? 0 : static_cast<int>(found - arrays.begin()) + 1;
    if (widgets.choice(name + ".array", "coloured by", options, &chosen)) {
      array = chosen == 0 ? std::string() : arrays[static_cast<std::size_t>(chosen) - 1];
      added.range.reset();
      is_changed = true;
    }
  }
  if (array.empty()) return widgets.color(name + ".color", "colour", &added.color) || is_changed;
  is_changed |= choose_color_map(widgets, name + ".map", "colours", &added.color_map);
  return range_of_surface(widgets, name, added) || is_changed;
}

// Of lines and points.
bool radius_of_surface(Widgets& widgets, const std::string& name, AddedSurface& added) {
  constexpr double kUsualShare = 1.0 / 300;  // of the diagonal, as `ovoid render` has it
  double& radius = added.source.radius;
  const double diagonal = added.of->surface->bounds.diagonal().norm();
  bool is_usual = radius == 0;
  bool is_changed = widgets.checkbox(name + ".radius.usual", "of the usual radius", &is_usual);
  if (is_changed) radius = is_usual ? 0 : short_number(diagonal * kUsualShare);
  if (is_usual) return is_changed;
  double edited = radius;
  if (widgets.number(name + ".radius", "radius", &edited,
                     {.lo = diagonal * 1e-6, .hi = 1e300, .speed = radius / 50}) &&
      edited > 0) {
    radius = edited;
    is_changed = true;
  }
  return is_changed;
}

bool surfaces_editor(Panel& panel) {
  View& view = panel.document.view;
  Widgets& widgets = panel.widgets;
  bool is_changed = false;
  for (std::size_t i = 0; i < view.added.size(); ++i) {
    AddedSurface& added = view.added[i];
    const std::string name = fmt::format("scene.surface.{}", i);
    bool is_shown = !added.is_hidden;
    const std::string file = std::filesystem::path(added.source.file).filename().string();
    if (widgets.checkbox(name + ".show", file.c_str(), &is_shown)) {
      added.is_hidden = !is_shown;
      is_changed = true;
    }
    widgets.tip(
        fmt::format("{}\n{} triangles", added.source.file, added.of->surface->triangles.size())
            .c_str());
    if (widgets.button_at_right(name + ".remove", "remove")) {
      remove_at(view.added, i);
      return true;
    }
    if (added.is_hidden) continue;
    is_changed |= colors_of_surface(widgets, name, added);
    if (added.of->has_radius) is_changed |= radius_of_surface(widgets, name, added);
    is_changed |= widgets.slider(name + ".opacity", "opacity", &added.opacity, 0.02, 1);
  }
  if (view.added.empty()) return is_changed;
  is_changed |= widgets.checkbox("scene.edges", "edges of their faces", &view.added_edges);
  return is_changed;
}

constexpr std::array<const char*, 4> kAcross = {"sagittal (x)", "coronal (y)", "axial (z)",
                                                "oblique"};
constexpr int kOblique = 3;

// The axis that a slice stands across of; kOblique: none.
int sliced_axis(const cli::SlicePlane& slice) {
  for (int axis = 0; axis < kOblique; ++axis) {
    if (slice.normal == Vec3::Unit(axis)) return axis;
  }
  return kOblique;
}

// Facing the eye, through the middle, so that something is seen to happen.
cli::SlicePlane oblique_slice(const Document& document) {
  const Camera& camera = document.camera;
  const Vec3 normal = (camera.focal_point - camera.position).normalized();
  return {normal, normal.dot(document.data_bounds().center())};
}

cli::SlicePlane slice_across(int axis, const Document& document) {
  return axis == kOblique ? oblique_slice(document) : cli::SlicePlane{Vec3::Unit(axis), {}};
}

bool slice_editor(Panel& panel, const std::string& name, cli::SlicePlane& slice) {
  const Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  bool is_changed = false;
  int across = sliced_axis(slice);
  if (widgets.choice(name + ".across", "across", {kAcross.begin(), kAcross.end()}, &across)) {
    slice = slice_across(across, document);
    is_changed = true;
  }
  if (across == kOblique) {
    Vec3 normal = slice.normal;
    if (widgets.vector(name + ".normal", "normal", &normal, 0.01) && normal.norm() > 1e-6) {
      // About its own place, where it is nearest to the middle.
      const Vec3 middle = document.data_bounds().center();
      const double off = document.offset_of(slice) - slice.normal.dot(middle);
      const Vec3 place = middle + slice.normal * (off / slice.normal.squaredNorm());
      slice = {normal, normal.dot(place)};
      is_changed = true;
    }
  }
  const Bounds3 all = document.data_bounds();
  const double middle = slice.normal.dot(all.center());
  const double reach = (all.sizes() / 2).dot(slice.normal.cwiseAbs());
  double offset = document.offset_of(slice);
  if (std::abs(offset) < 1e-9 * document.extent()) offset = 0;  // the middle, but for rounding
  if (widgets.slider(name + ".offset", "place", &offset, middle - reach, middle + reach)) {
    slice.offset = offset;
    is_changed = true;
  }
  return is_changed;
}

// What slices show of the labels that are drawn, if any are.
bool labels_on_slices(Panel& panel) {
  Document& document = panel.document;
  View& view = document.view;
  if (!document.shows_labels(view)) return false;
  const LabelSurfaces labels = document.labels_of(view);
  int shown = static_cast<int>(cli::shown_on_slices(labels));
  bool is_changed = false;
  if (panel.widgets.choice("scene.slice_labels", "labels", {"lines", "areas", "both", "none"},
                           &shown)) {
    view.slice_labels = static_cast<cli::SliceLabels>(shown);
    is_changed = true;
  }
  is_changed |=
      panel.widgets.checkbox("scene.flat_labels", "labels on slices alone", &view.are_labels_flat);
  return is_changed;
}

// As two values, and as radiologists have them: how much, and about which.
bool range_of_slices(Panel& panel) {
  const Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  std::optional<std::pair<double, double>>& range = panel.document.view.slices.slice_range;
  const bool is_counted = document.extras && document.extras->of == document.shown;
  bool is_usual = !range.has_value();
  bool is_changed = false;
  ImGui::BeginDisabled(!is_counted && is_usual);  // it is about to be known
  if (widgets.checkbox("scene.range.usual", "over 99 % of the values", &is_usual)) {
    range.reset();
    if (!is_usual)
      range =
          cli::usual_slice_range(document.extras->histogram, document.shown->field().value_range());
    is_changed = true;
  }
  ImGui::EndDisabled();
  if (!range) return is_changed;
  auto& [lo, hi] = *range;
  const ValueRange all = document.shown->field().value_range();
  const double span = std::max(static_cast<double>(all.hi) - all.lo, 1e-30);
  const double least = span * 1e-6;
  const NumberField field{.speed = span / 400};
  double from = lo;
  double to = hi;
  double window = hi - lo;
  double level = lo + (hi - lo) / 2;
  if (widgets.number("scene.range.lo", "values from", &from, field)) {
    lo = std::min(from, hi - least);
    is_changed = true;
  }
  if (widgets.number("scene.range.hi", "to", &to, field)) {
    hi = std::max(to, lo + least);
    is_changed = true;
  }
  bool is_moved =
      widgets.number("scene.range.window", "window", &window, {.lo = least, .speed = span / 400});
  is_moved |= widgets.number("scene.range.level", "level", &level, field);
  if (is_moved) range = {level - window / 2, level + window / 2};
  return is_changed || is_moved;
}

bool slices_editor(Panel& panel) {
  Document& document = panel.document;
  cli::GeometryFlags& look = document.view.slices;
  Widgets& widgets = panel.widgets;
  bool is_changed = false;
  ImGui::TextUnformatted("Add a slice:");
  static constexpr std::array<std::pair<const char*, int>, 4> kButtons = {
      {{"axial", 2}, {"coronal", 1}, {"sagittal", 0}, {"oblique", kOblique}}};
  for (const auto& [label, axis] : kButtons) {
    if (axis != kButtons.front().second) ImGui::SameLine();
    if (widgets.button(fmt::format("scene.slice.{}", label), label)) {
      look.slices.push_back(slice_across(axis, document));
      is_changed = true;
    }
  }
  for (std::size_t i = 0; i < look.slices.size(); ++i) {
    const std::string name = fmt::format("scene.slice.{}", i);
    ImGui::TextDisabled("slice %d", static_cast<int>(i) + 1);
    if (widgets.button_at_right(name + ".remove", "remove")) {
      remove_at(look.slices, i);
      return true;
    }
    is_changed |= slice_editor(panel, name, look.slices[i]);
  }
  if (look.slices.empty()) return is_changed;
  ImGui::Separator();
  is_changed |= choose_color_map(widgets, "scene.map", "colours", &look.slice_map);
  is_changed |= range_of_slices(panel);
  is_changed |= widgets.slider("scene.opacity", "opacity", &look.slice_opacity, 0.02, 1);
  bool is_clear = !look.shows_empty;
  if (widgets.checkbox("scene.clear", "see-through where nothing is", &is_clear)) {
    look.shows_empty = !is_clear;
    is_changed = true;
  }
  widgets.tip("Of scans: values near the least, if a fifth of all are so low.");
  is_changed |= widgets.checkbox("scene.outlines", "outlines", &look.has_outlines);
  widgets.tip("A line where slices leave the data's box.");
  is_changed |= labels_on_slices(panel);
  return is_changed;
}

}  // namespace

void scene_panel(Panel& panel) {
  Document& document = panel.document;
  const View& view = document.view;
  const bool has_any =
      !view.added.empty() || !view.slices.slices.empty() || view.labels.has_value();
  if (has_any && !document.shows_scenery(view)) {
    ImGui::TextWrapped(
        "Not shown now: surfaces, labels and slices take the modes composite and isosurface, and "
        "neither a "
        "value plane, nor points, nor motion blur.");
    ImGui::Separator();
  }
  bool is_changed = false;
  labels_editor(panel);
  if (document.plain_labels(view) != nullptr) ImGui::Separator();
  channels_editor(panel);
  volumes_editor(panel);
  files_editor(panel);
  is_changed |= surfaces_editor(panel);
  ImGui::Separator();
  is_changed |= slices_editor(panel);
  if (is_changed) document.touch();
}

}  // namespace ovoid::viewer
