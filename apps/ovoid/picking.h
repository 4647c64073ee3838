// SPDX-License-Identifier: Apache-2.0
// What a picture shows at some of its pixels, in words and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drawing.h"
#include "ovoid/annotate.h"
#include "ovoid/pick.h"
#include "shot.h"

namespace ovoid::cli {

// A pixel that flags name, row 0 at the top.
using PickedPixel = std::pair<int, int>;
PickedPixel parse_pixel(const std::string& text);  // "X,Y"; throws BadValue
// Throws UsageError for the first that lies outside of the picture.
void check_pixels(const std::vector<PickedPixel>& pixels, const RenderOptions& options);

// The names and units in which picks are told.
struct PickWords {
  std::string array, unit;  // of the values that give opacity
  std::string color_array;  // of those that give colour, where they are others'; else empty
  std::string length_unit;
  Space space = Space::kNone;
};
PickWords pick_words(const Subject& subject, const Shot& shot, const AnnotationFlags& marks);

// A label that a pixel shows.
using Label = ColorBarEntry;

// Asks the picture of a shot. All arguments outlive it.
class Picker {
 public:
  Picker(const Shot& shot, const RenderOptions& options);

  Pick at(const Image& image, int x, int y) const;
  // Of surfaces of labels, and of a look of labels, the first that shows, from the place on to one
  // spacing behind: between two labels a field passes all between them. None: there is none, or no
  // place.
  std::optional<Label> label(const Pick& pick) const;

 private:
  std::optional<Label> label_of_surface(const Vec3& at) const;
  std::optional<Label> label_of_look(const Vec3& place) const;

  const Field& field_;
  const Shot& shot_;
  const RenderOptions& options_;
  FieldProbe probe_;
  const LabelSurfaces& surfaces_;
  std::vector<Label> labels_;  // of the look
};

// One pixel; the members of docs/command-line.md.
nlohmann::ordered_json pick_json(const Picker& picker, const Pick& pick, const PickWords& words);
std::string pick_text(const Picker& picker, const Pick& pick, const PickWords& words);

// A whole report, which says the names and units once.
std::string picks_json(const Picker& picker, const std::vector<Pick>& picks, const PickWords& words,
                       const std::string& command);

}  // namespace ovoid::cli
