// SPDX-License-Identifier: Apache-2.0
// The table of how labels are drawn.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <utility>
#include <vector>

#include "color_words.h"
#include "setting_forms.h"
#include "settings.h"
#include "values.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;
using LabelOpacities = std::vector<LabelFlags::Opacity>;
using LabelColors = std::vector<LabelFlags::Color>;
using LabelNames = std::vector<std::string>;

const Names<SliceLabels> kSliceLabels = {{"lines", SliceLabels::kLines},
                                         {"areas", SliceLabels::kAreas},
                                         {"both", SliceLabels::kBoth},
                                         {"none", SliceLabels::kNone}};

// The two sides of each LABEL=VALUE; `expected` is what there should be.
std::vector<std::pair<std::string, std::string>> parse_pairs(const std::string& text,
                                                             const char* expected) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& part : split(text, ',')) {
    const std::size_t equals = part.rfind('=');
    if (equals == std::string::npos || equals == 0) throw BadValue(expected);
    pairs.emplace_back(part.substr(0, equals), part.substr(equals + 1));
  }
  return pairs;
}

LabelOpacities parse_label_opacities(const std::string& text) {
  LabelOpacities opacities;
  for (const auto& [label, opacity] :
       parse_pairs(text, "expected LABEL=A,..., such as 3=0.4,liver=1,others=0"))
    opacities.push_back({label, parse_number(opacity, {.lo = 0, .hi = 1})});
  return opacities;
}

LabelColors parse_label_colors(const std::string& text) {
  LabelColors colors;
  for (const auto& [label, color] :
       parse_pairs(text, "expected LABEL=COLOR,..., such as 3=#c05030,liver=red"))
    colors.push_back({label, parse_rgb(color)});
  return colors;
}

// Commas stand between labels, so that colours have none in them.
std::string text_of_label_colors(const LabelColors& colors) {
  std::string text;
  for (const auto& [label, rgb] : colors)
    text += fmt::format("{}{}={}", text.empty() ? "" : ",", label, hex_text(rgb));
  return text;
}

std::string text_of_label_opacities(const LabelOpacities& opacities) {
  std::string text;
  for (const auto& [label, opacity] : opacities)
    text += fmt::format("{}{}={}", text.empty() ? "" : ",", label, opacity);
  return text;
}

LabelNames parse_label_names(const std::string& text) {
  LabelNames names = split(text, ',');
  for (const std::string& name : names)
    if (name.empty()) throw BadValue("expected LABEL,..., numbers or names");
  return names;
}

}  // namespace

const Table<LabelFlags>& label_settings() {
  using L = LabelFlags;
  const Rule lit = not_with("mode", "is for --mode composite and isosurface", is_unlit);
  const Rule alone = not_with("value-plane motion-blur points");
  const Rule of_file = needs("labels", "has no effect without --labels");
  const Rule of_slices = needs("slice", "has no effect without --slice");
  static const Table<L> all = {
      {"--labels", word("FILE", Content::kFile), &L::file,
       "the surfaces of a label map in the data's world, such as a segmentation of the scan", lit,
       alone},
      {"--label-surfaces", Toggle(), &L::own_surfaces,
       "draw data that are labels by their surfaces, whatever the look says (default where nothing "
       "says how they are drawn)",
       for_data({DatasetKind::kLattice}, "lattices"), lit, alone, not_with("labels", kGiveOne)},
      {"--label-table", word("FILE|JSON", Content::kLabels), &L::table,
       "names and colours of labels: .ctbl, .seg.nrrd, ITK-SNAP's or FreeSurfer's text, BIDS' "
       "dseg.tsv, or JSON itself, as {\"1\": \"liver\", \"2\": [\"spleen\", \"#c05030\"]} "
       "(default: the label file's own, if it has one)",
       lit},
      {"--label-opacity",
       {"LABEL=A,...",
        [](L& flags, const std::string& text) { flags.opacities = parse_label_opacities(text); },
        [](const L& flags) {
          return flags.opacities.empty() ? Json() : Json(text_of_label_opacities(flags.opacities));
        }},
       "of the surfaces of labels, by number or name; \"others\" are those that are not named; 0: "
       "not drawn (default 1)",
       lit},
      {"--label-color",
       {"LABEL=COLOR,...",
        [](L& flags, const std::string& text) { flags.colors = parse_label_colors(text); },
        [](const L& flags) {
          return flags.colors.empty() ? Json() : Json(text_of_label_colors(flags.colors));
        }},
       "of the surfaces of labels, by number or name, as #rrggbb or a colour's name (default: the "
       "table's, or one by the number)",
       lit},
      {"--inside-labels",
       {"LABEL,...",
        [](L& flags, const std::string& text) { flags.inside = parse_label_names(text); },
        [](const L& flags) {
          return flags.inside.empty() ? Json()
                                      : Json(fmt::format("{}", fmt::join(flags.inside, ",")));
        }},
       "draw the data within these labels alone, whose surfaces are then not drawn",
       of_file,
       not_with("outside-labels", kGiveOne)},
      {"--outside-labels",
       {"LABEL,...",
        [](L& flags, const std::string& text) { flags.outside = parse_label_names(text); },
        [](const L& flags) {
          return flags.outside.empty() ? Json()
                                       : Json(fmt::format("{}", fmt::join(flags.outside, ",")));
        }},
       "draw no data within these labels",
       of_file},
      {"--slice-labels", choice(kSliceLabels), &L::on_slices,
       "what slices show of labels that are drawn: their outlines, what they cover, both or "
       "nothing "
       "(default: lines; areas of data that are labels)",
       of_slices, lit},
      {"--flat-labels", Toggle(), &L::are_flat, "labels on slices alone, without their surfaces",
       of_slices, lit},
  };
  return all;
}

}  // namespace ovoid::cli
