// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "make_field.h"
#include "ovoid/annotate.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// What the marks tell of the data.
struct Described {
  std::string array;        // that gives colour
  std::string unit;         // of its values
  std::string length_unit;  // of the world; patient spaces are in mm
  Space space = Space::kNone;
  std::map<int, std::string> label_names;  // of values that are labels, where they have names
  Box box;                                 // of what is drawn
};

// All but the box. `component` is what was drawn of the arrays' tuples.
Described describe(const Dataset& dataset, const Modelled& modelled, int component);

// Whether a look has colours that a bar can show: not those over value and gradient.
bool has_color_bar(const Look& look);
// Tells of the bar that is asked for and left out.
void note_on_marks(const AnnotationFlags& flags, const Look& look, Session& session);

// Draws the marks; an x-ray has been mapped to the colours of `look`.
void draw_annotations(Image& image, const AnnotationFlags& flags, const Described& described,
                      const Camera& camera, const Look& look, const std::optional<Rgb>& background);

}  // namespace ovoid::cli
