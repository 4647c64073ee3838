// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "flags.h"
#include "model_flags.h"
#include "ovoid/annotate.h"

namespace ovoid::cli {

// Which marks are drawn into the picture.
struct AnnotationFlags {
  bool color_bar = false;
  std::string title;  // of the colour bar; empty: the array's name
  bool axes = false;
  bool bounding_box = false;
  bool scale_bar = false;
  std::optional<std::string> length_unit;  // none: what the data say
  double text_px = 0;                      // height of a line of text; 0: by the picture's size

  bool any() const noexcept { return color_bar || axes || bounding_box || scale_bar; }
};

void add_annotation_flags(Flags& flags, AnnotationFlags* annotation);
// Throws UsageError for contradictions; marks are drawn into .png only.
void check_annotation_flags(const Flags& flags, const std::string& output);

// What the marks tell of the data.
struct Described {
  std::string array;        // that gives colour
  std::string unit;         // of its values
  std::string length_unit;  // of the world; patient spaces are in mm
  Space space = Space::kNone;
  Box box;  // of what is drawn
};

// All but the box. `component` is what was drawn of the arrays' tuples.
Described describe(const Dataset& dataset, const Modelled& modelled, int component);

// Draws the marks; an x-ray has been mapped to the colours of `look`.
void draw_annotations(Image& image, const AnnotationFlags& flags, const Described& described,
                      const Camera& camera, const Look& look, const std::optional<Rgb>& background);

}  // namespace ovoid::cli
