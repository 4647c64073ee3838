// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "make_geometry.h"
#include "panels.h"
#include "start_page.h"

namespace ovoid::viewer {
namespace {

void remove_at(auto& list, std::size_t i) {
  list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
}

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

bool surfaces_editor(Panel& panel) {
  View& view = panel.document.view;
  Widgets& widgets = panel.widgets;
  bool is_changed = false;
  for (std::size_t i = 0; i < view.added.size(); ++i) {
    AddedSurface& added = view.added[i];
    const std::string name = fmt::format("scene.surface.{}", i);
    bool is_shown = !added.is_hidden;
    const std::string file = std::filesystem::path(added.file).filename().string();
    if (widgets.checkbox(name + ".show", file.c_str(), &is_shown)) {
      added.is_hidden = !is_shown;
      is_changed = true;
    }
    widgets.tip(
        fmt::format("{}\n{} triangles", added.file, added.surface->triangles.size()).c_str());
    if (widgets.button_at_right(name + ".remove", "remove")) {
      remove_at(view.added, i);
      return true;
    }
    if (added.is_hidden) continue;
    is_changed |= widgets.color(name + ".color", "colour", &added.color);
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
