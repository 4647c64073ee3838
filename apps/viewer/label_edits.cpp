// SPDX-License-Identifier: Apache-2.0
#include "label_edits.h"

#include <algorithm>
#include <string>
#include <utility>

#include "make_labels.h"
#include "ovoid/labels.h"

namespace ovoid::viewer {
namespace {

using Json = nlohmann::ordered_json;
using Opacities = std::vector<cli::LabelFlags::Opacity>;

constexpr const char* kOthers = "others";

std::string name_of(const LabelStyle& style) { return std::to_string(style.label); }

// Those that differ from what they are without being named.
Opacities opacities_beside(const std::vector<LabelStyle>& unnamed,
                           const std::vector<LabelStyle>& wanted) {
  Opacities named;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i].opacity != unnamed[i].opacity)
      named.push_back({name_of(wanted[i]), wanted[i].opacity});
  }
  return named;
}

}  // namespace

LabelEdits label_edits_of(const std::vector<LabelStyle>& plain, const cli::LabelFlags& flags) {
  std::vector<LabelStyle> styled = plain;
  cli::style_labels(styled, flags);
  LabelEdits edits;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    LabelEdit edit;
    if (styled[i].color != plain[i].color) edit.color = styled[i].color;
    edit.is_hidden = styled[i].opacity == 0 && plain[i].opacity > 0;
    if (styled[i].opacity > 0 && styled[i].opacity != plain[i].opacity)
      edit.opacity = styled[i].opacity;
    if (edit.color || edit.opacity || edit.is_hidden) edits[plain[i].label] = edit;
  }
  return edits;
}

std::vector<LabelStyle> edited(std::vector<LabelStyle> plain, const LabelEdits& edits) {
  for (LabelStyle& style : plain) {
    const auto found = edits.find(style.label);
    if (found == edits.end()) continue;
    const LabelEdit& edit = found->second;
    style.color = edit.color.value_or(style.color);
    style.opacity = edit.is_hidden ? 0 : edit.opacity.value_or(style.opacity);
  }
  return plain;
}

void tell_label_edits(const std::vector<LabelStyle>& plain, const LabelEdits& edits,
                      cli::LabelFlags* flags) {
  const std::vector<LabelStyle> wanted = edited(plain, edits);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i].color != plain[i].color)
      flags->colors.push_back({name_of(wanted[i]), wanted[i].color});
  }
  flags->opacities = opacities_beside(plain, wanted);
  std::vector<LabelStyle> none = plain;
  for (LabelStyle& style : none) style.opacity = 0;
  Opacities few = opacities_beside(none, wanted);
  few.insert(few.begin(), {kOthers, 0});
  if (few.size() < flags->opacities.size()) flags->opacities = std::move(few);
}

void show_label(const LabelStyle& plain, bool is_shown, LabelEdits* edits) {
  LabelEdit& edit = (*edits)[plain.label];
  edit.is_hidden = !is_shown && plain.opacity > 0;
  if (!is_shown && plain.opacity == 0) edit.opacity.reset();
  if (is_shown && plain.opacity == 0 && !edit.opacity) edit.opacity = 1;
}

Json hidden_label_opacities(const LabelEdits& edits) {
  Json opacities;
  for (const auto& [label, edit] : edits) {
    if (edit.is_hidden && edit.opacity) opacities[std::to_string(label)] = *edit.opacity;
  }
  return opacities;
}

void take_hidden_label_opacities(const Json& json, LabelEdits* edits) {
  if (!json.is_object()) return;
  for (auto& [label, edit] : *edits) {
    const auto found = json.find(std::to_string(label));
    if (!edit.is_hidden || found == json.end() || !found->is_number()) continue;
    const auto opacity = found->get<double>();
    if (opacity > 0 && opacity <= 1) edit.opacity = opacity;
  }
}

bool shows_labels_by_value(const TransferFunction& tf, const std::vector<LabelStyle>& styles) {
  if (styles.empty()) return false;
  const TransferFunction own = label_look(styles).transfer_function;
  const auto is_same_color = [](const ColorPoint& a, const ColorPoint& b) {
    return a.x == b.x && a.rgb == b.rgb;
  };
  const auto is_same_opacity = [](const OpacityPoint& a, const OpacityPoint& b) {
    return a.x == b.x && a.opacity == b.opacity;
  };
  return std::equal(tf.colors.begin(), tf.colors.end(), own.colors.begin(), own.colors.end(),
                    is_same_color) &&
         std::equal(tf.opacities.begin(), tf.opacities.end(), own.opacities.begin(),
                    own.opacities.end(), is_same_opacity);
}

}  // namespace ovoid::viewer
