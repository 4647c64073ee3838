// SPDX-License-Identifier: Apache-2.0
#include "annotation_flags.h"

#include <fmt/format.h>

#include "ovoid/model.h"
#include "session.h"
#include "usage.h"

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
  if (!flags.title.empty()) bar.title = flags.title;
  return bar;
}

}  // namespace

void add_annotation_flags(Flags& flags, AnnotationFlags* annotation) {
  flags.section("marks in a PNG");
  flags.optional_value("--colorbar", "[=TITLE]",
                       "what the colours stand for (default title: the array's name)",
                       [annotation](const std::string& text) {
                         annotation->color_bar = true;
                         annotation->title = text;
                       });
  flags.toggle("--axes", "directions of x, y, z, or of the patient", &annotation->axes);
  flags.toggle("--bounding-box", "edges of the volume and where they lie",
               &annotation->bounding_box);
  flags.toggle("--scale-bar", "a round length, true at the focal point", &annotation->scale_bar);
  flags.value("--length-unit", "NAME",
              "unit of the world's lengths (default: mm for patient data, else none)",
              [annotation](const std::string& text) { annotation->length_unit = text; });
}

void check_annotation_flags(const Flags& flags, const std::string& output) {
  const char* const mark =
      flags.first_given({"--colorbar", "--axes", "--bounding-box", "--scale-bar"});
  if (mark != nullptr && !has_ending(output, ".png")) {
    throw UsageError(fmt::format(
        "{}: '{}' holds the volume's own numbers, marks are drawn into .png only", mark, output));
  }
  if (mark == nullptr && flags.is_given("--length-unit")) {
    throw UsageError(
        "--length-unit: has no effect without --scale-bar, --bounding-box or --colorbar");
  }
}

Described describe(const Dataset& dataset, const std::string& array, int component) {
  Described data;
  const DataArray& drawn = dataset.array(array);
  data.array = drawn.name;
  if (drawn.num_components > 1) {
    data.array += component == LatticeModelOptions::kMagnitude ? " magnitude"
                                                               : fmt::format("[{}]", component);
  }
  data.unit = drawn.unit;
  data.space = dataset.space;
  if (dataset.space != Space::kNone) data.length_unit = "mm";
  return data;
}

void draw_annotations(Image& image, const AnnotationFlags& flags, const Described& described,
                      const Camera& camera, const Look& look, const double* background) {
  Described data = described;
  if (flags.length_unit) data.length_unit = *flags.length_unit;
  const MarkStyle style = mark_style_on(background);
  if (flags.bounding_box) draw_bounding_box(image, camera, data.box, data.length_unit, style);
  if (flags.axes) draw_axes(image, camera, data.space, style);
  if (flags.scale_bar) draw_scale_bar(image, camera, data.length_unit, style);
  if (flags.color_bar) draw_color_bar(image, look, color_bar_for(flags, data, look), style);
}

}  // namespace ovoid::cli
