// SPDX-License-Identifier: Apache-2.0
// Of the tab "look": looks by value and gradient (docs/looks2d.md), the way to them and back.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "panels.h"

namespace ovoid::viewer {
namespace {

const cli::Histogram2D* histogram_of(const Document& document) {
  return document.counted_2d ? document.counted_2d->histogram.get() : nullptr;
}

// Counts what is not counted yet; true if that is on its way.
bool awaits_histogram(Panel& panel) {
  const auto& counted = panel.document.counted_2d;
  if (counted && counted->of == panel.document.shown) return false;
  panel.wishes.counts_2d = true;
  return true;
}

void enter_2d(Panel& panel) {
  Document& document = panel.document;
  RegionsState& state = panel.state.regions;
  Look& look = document.view.look;
  if (state.has_left(*document.shown)) {
    look.transfer_function_2d = state.left;
  } else {
    const cli::Histogram2D* const histogram = histogram_of(document);
    const PlaneAxes axes = plane_axes(histogram, nullptr, document.shown->field().value_range());
    look.transfer_function_2d =
        TransferFunction2D({first_region(histogram, look.transfer_function, axes)});
  }
  state.occlusion = std::exchange(look.occlusion, 0);
  state.shadows = std::exchange(look.shadows, 0);
  state.editing.selected = look.transfer_function_2d->regions().empty() ? -1 : 0;
  state.awaits_first = state.is_left_by_mode = false;
}

std::string title_of(const LookRegion& region, std::size_t number) {
  return fmt::format("{}: {:.4g} to {:.4g}", number + 1, region.values[0], region.values[1]);
}

// Of several, the one whose numbers stand below.
void choose_region(Panel& panel, const std::vector<LookRegion>& regions) {
  if (regions.size() < 2) return;
  std::vector<std::string> titles;
  for (std::size_t i = 0; i < regions.size(); ++i) titles.push_back(title_of(regions[i], i));
  std::vector<const char*> options;
  options.reserve(titles.size());
  for (const std::string& title : titles) options.push_back(title.c_str());
  panel.widgets.choice("look.region", "region", options, &panel.state.regions.editing.selected);
}

bool region_buttons(Panel& panel, std::vector<LookRegion>& regions, const PlaneAxes& axes) {
  Widgets& widgets = panel.widgets;
  int& selected = panel.state.regions.editing.selected;
  const auto count = static_cast<int>(regions.size());
  const bool has_one = selected >= 0 && selected < count;
  if (widgets.button("look.region.add", "add", regions.size() < TransferFunction2D::kMaxRegions)) {
    LookRegion region =
        region_around({(axes.value_lo + axes.value_hi) / 2, axes.gradient_hi / 2}, axes);
    region.rgb = color_for_region(regions);
    regions.push_back(region);
    selected = count;
    return true;
  }
  ImGui::SameLine();
  if (widgets.button("look.region.remove", "remove", has_one && count > 1)) {
    regions.erase(regions.begin() + selected);
    selected = -1;
    return true;
  }
  ImGui::SameLine();
  const auto at = regions.begin() + (has_one ? selected : 0);
  if (widgets.button("look.region.lower", "lower", has_one && selected > 0)) {
    std::iter_swap(at, std::prev(at));
    --selected;
    return true;
  }
  widgets.tip("Behind the one before it.");
  ImGui::SameLine();
  if (widgets.button("look.region.raise", "raise", has_one && selected + 1 < count)) {
    std::iter_swap(at, std::next(at));
    ++selected;
    return true;
  }
  widgets.tip("Over the one behind it: where both are, its colour is seen.");
  return false;
}

bool edit_ends(Widgets& widgets, const std::string& name, const char* label,
               std::array<double, 2>& ends, const NumberField& field) {
  std::array<double, 2> edited = ends;
  bool is_changed = widgets.number(name + ".lo", label, &edited[0], field);
  is_changed |= widgets.number(name + ".hi", "to", &edited[1], field);
  if (!is_changed || !(edited[0] < edited[1])) return false;
  ends = edited;
  return true;
}

bool region_numbers(Panel& panel, LookRegion& region, const PlaneAxes& axes) {
  Widgets& widgets = panel.widgets;
  constexpr double kPixels = 300;  // about as wide as the axes are
  bool is_changed = edit_ends(widgets, "look.region.values", "values from", region.values,
                              {.speed = (axes.value_hi - axes.value_lo) / kPixels});
  is_changed |= edit_ends(widgets, "look.region.gradients", "gradients from", region.gradients,
                          {.lo = 0, .speed = axes.gradient_hi / kPixels});
  int shape = static_cast<int>(region.shape);
  if (widgets.choice("look.region.shape", "shape", {"box", "gaussian"}, &shape)) {
    region.shape = static_cast<LookRegion::Shape>(shape);
    is_changed = true;
  }
  if (widgets.color("look.region.rgb", "colour", &region.rgb)) {
    region.rgb = in_bytes(region.rgb);
    is_changed = true;
  }
  is_changed |= widgets.slider("look.region.opacity", "opacity", &region.opacity, 0, 1);
  if (region.shape == LookRegion::Shape::kGaussian) return is_changed;
  is_changed |= widgets.slider("look.region.softness", "softness", &region.softness, 0, 1);
  widgets.tip("The share of the way from an edge to the middle over which the opacity rises.");
  is_changed |= widgets.slider("look.region.foot", "foot", &region.foot, 0, 1);
  widgets.tip("The width at the least gradient: 1 a box, 0 a triangle on its tip.");
  return is_changed;
}

bool edit_numbers(Panel& panel, TransferFunction2D& function, const PlaneAxes& axes) {
  std::vector<LookRegion> regions = function.regions();
  choose_region(panel, regions);
  bool is_changed = region_buttons(panel, regions, axes);
  const int selected = panel.state.regions.editing.selected;
  if (selected >= 0 && selected < static_cast<int>(regions.size())) {
    is_changed |= region_numbers(panel, regions[static_cast<std::size_t>(selected)], axes);
  } else {
    ImGui::TextDisabled("Click: select. Double click: a new region.");
  }
  return is_changed && take_regions(function, std::move(regions));
}

}  // namespace

bool RegionsState::has_left(const Shown& shown) const {
  return left && left_array == shown.array && left_component == shown.component;
}

std::string why_not_2d(const Document& document) {
  const View& view = document.view;
  const KernelField* const kernels = document.shown->field().kernels();
  if (view.look.mode != Mode::kComposite) return "only in the mode composite";
  if (document.shows_channels(view)) return "channels have looks of their own";
  if (kernels != nullptr && kernels->has_own_color())
    return "not while another array gives the colour (tab data)";
  if (view.options.classification == Classification::kPreintegrated)
    return "not with pre-integrated classification (tab quality)";
  if (document.time.blur_length > 0 && document.shown->trail)
    return "not with motion blur (tab time)";
  return {};
}

void leave_2d(Panel& panel) {
  Look& look = panel.document.view.look;
  RegionsState& state = panel.state.regions;
  state.left = std::exchange(look.transfer_function_2d, std::nullopt);
  state.left_array = panel.document.shown->array;
  state.left_component = panel.document.shown->component;
  state.is_left_by_mode = false;
  if (look.occlusion == 0 && look.shadows == 0) {
    look.occlusion = std::exchange(state.occlusion, 0);
    look.shadows = std::exchange(state.shadows, 0);
  }
}

void change_mode_2d(Panel& panel, Mode mode) {
  RegionsState& state = panel.state.regions;
  if (mode != Mode::kComposite && panel.document.view.look.transfer_function_2d) {
    leave_2d(panel);
    state.is_left_by_mode = true;
  } else if (mode == Mode::kComposite && state.is_left_by_mode &&
             state.has_left(*panel.document.shown)) {
    enter_2d(panel);
  }
}

bool way_to_regions(Panel& panel) {
  RegionsState& state = panel.state.regions;
  const std::string why_not = why_not_2d(panel.document);
  if (!why_not.empty()) state.awaits_first = false;
  if (state.awaits_first) {
    ImGui::TextDisabled("Counting values and gradients ...");
    if (awaits_histogram(panel)) return false;
    enter_2d(panel);
    return true;
  }
  const bool is_pressed =
      panel.widgets.button("look.enter-2d", "by value and gradient", why_not.empty());
  panel.widgets.tip(why_not.empty() ? "Regions of the value and the steepness instead of a curve "
                                      "over the value: tells boundaries from materials."
                                    : why_not.c_str());
  if (!is_pressed) return false;
  state.awaits_first = !state.has_left(*panel.document.shown) && awaits_histogram(panel);
  if (state.awaits_first) return false;
  enter_2d(panel);
  return true;
}

bool regions_editor(Panel& panel) {
  Document& document = panel.document;
  RegionsState& state = panel.state.regions;
  TransferFunction2D& function = *document.view.look.transfer_function_2d;
  const bool is_awaited = awaits_histogram(panel);
  RegionCanvas canvas;
  if (document.counted_2d) canvas.histogram = document.counted_2d->histogram;
  canvas.axes =
      plane_axes(canvas.histogram.get(), &function, document.shown->field().value_range());
  canvas.unit = document.shown->subject.unit;
  bool is_changed = edit_regions(panel.widgets, "look.regions", function, canvas, state.editing);
  ImGui::TextDisabled("value to the right, gradient upwards%s", is_awaited ? ", counting" : "");
  const std::string why_not = why_not_2d(document);
  if (!why_not.empty()) {
    ImGui::TextWrapped("Is not drawn: %s.", why_not.c_str());
  } else if (document.draws_surface(document.view) && document.view.surface.opacity == 1) {
    ImGui::TextWrapped("Lies behind the opaque surface.");
  }
  if (function.regions().empty()) {
    ImGui::TextWrapped("A table of %d x %d entries, which is not edited here.",
                       function.values().count, function.gradients().count);
  } else {
    is_changed |= edit_numbers(panel, function, canvas.axes);
  }
  if (panel.widgets.button("look.leave-2d", "by the value alone")) {
    leave_2d(panel);
    is_changed = true;
  }
  panel.widgets.tip("Back to the curves. The button there brings this back, and so does undo.");
  return is_changed;
}

}  // namespace ovoid::viewer
