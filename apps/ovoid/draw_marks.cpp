// SPDX-License-Identifier: Apache-2.0
#include "draw_marks.h"

#include <fmt/format.h>

#include "ovoid/model.h"

namespace ovoid::cli {
namespace {

// An integral's unit: of the values times the length.
std::string times_length(const std::string& unit, const std::string& length_unit) {
  if (unit.empty()) return length_unit;
  return length_unit.empty() ? unit : fmt::format("{}\u00B7{}", unit, length_unit);
}

ColorBar color_bar_for(const AnnotationFlags& flags, const Described& data, const Look& look) {
  ColorBar bar;
  bar.title = data.array;
  bar.unit = data.unit;
  if (look.mode == Mode::kXray) {
    bar.title = fmt::format("integral of {}", data.array);
    bar.unit = times_length(data.unit, data.length_unit);
  }
  if (look.mode != Mode::kXray) bar.entries = label_entries(look.transfer_function);
  for (ColorBarEntry& entry : bar.entries) {
    const auto found = data.label_names.find(static_cast<int>(entry.value));
    if (found != data.label_names.end()) entry.name = found->second;
  }
  if (!flags.title.empty()) bar.title = flags.title;
  return bar;
}

}  // namespace

Described describe(const Dataset& dataset, const Modelled& modelled, int component) {
  Described data;
  data.array = modelled.color_array;
  data.unit = unit_of(dataset, modelled, Role::kColor);
  const DataArray* const drawn = find_array(dataset, modelled.color_array);
  if (drawn != nullptr && drawn->num_components > 1) {
    data.array += component == LatticeModelOptions::kMagnitude ? " magnitude"
                                                               : fmt::format("[{}]", component);
  }
  data.space = dataset.space;
  if (dataset.space != Space::kNone) data.length_unit = "mm";
  return data;
}

// What the bar shows of the look: where another array than the opacity's gives colour, that one's
// colours alone.
Look look_of_bar(const Look& look) {
  if (!look.color_function) return look;
  Look shown = look;
  shown.transfer_function = *look.color_function;
  shown.transfer_function.opacities.clear();
  if (shown.mode == Mode::kIsosurface) shown.mode = Mode::kComposite;  // its value is another's
  return shown;
}

bool has_color_bar(const Look& look) { return !look.transfer_function_2d; }

void note_on_marks(const AnnotationFlags& flags, const Look& look, Session& session) {
  if (flags.color_bar && !has_color_bar(look))
    session.note("--colorbar: left out, a 2-D transfer function has no colours by value alone");
}

void draw_annotations(Image& image, const AnnotationFlags& flags, const Described& described,
                      const Camera& camera, const Look& look,
                      const std::optional<Rgb>& background) {
  Described data = described;
  if (flags.length_unit) data.length_unit = *flags.length_unit;
  MarkStyle style = mark_style_on(background);
  style.text_px = flags.text_px;
  if (flags.bounding_box) draw_bounding_box(image, camera, data.box, data.length_unit, style);
  if (flags.axes) draw_axes(image, camera, data.space, style);
  if (flags.scale_bar) draw_scale_bar(image, camera, data.length_unit, style);
  if (flags.color_bar && has_color_bar(look)) {
    const Look shown = look_of_bar(look);
    draw_color_bar(image, shown, color_bar_for(flags, data, shown), style);
  }
}

}  // namespace ovoid::cli
