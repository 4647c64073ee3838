// SPDX-License-Identifier: Apache-2.0
// How single labels are drawn, where somebody wants them otherwise than their table has them.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "ovoid/label_style.h"
#include "settings.h"

namespace ovoid::viewer {

struct LabelEdit {
  std::optional<Rgb> color;       // in steps of 1/255, as --label-color has it
  std::optional<double> opacity;  // above 0
  bool is_hidden = false;
};
using LabelEdits = std::map<int, LabelEdit>;  // by the label's number

// Throws Error for a label of the flags that `plain` lacks.
LabelEdits label_edits_of(const std::vector<LabelStyle>& plain, const cli::LabelFlags& flags);

// Edits of labels that are not among them are passed over.
std::vector<LabelStyle> edited(std::vector<LabelStyle> plain, const LabelEdits& edits);

// The colours and opacities that make the edited styles of the plain ones.
void tell_label_edits(const std::vector<LabelStyle>& plain, const LabelEdits& edits,
                      cli::LabelFlags* flags);

// Whether the label is shown from now on. One that is opaque by nothing else is so then.
void show_label(const LabelStyle& plain, bool is_shown, LabelEdits* edits);

// What flags cannot say: how opaque hidden labels will be. By their numbers; null: nothing.
nlohmann::ordered_json hidden_label_opacities(const LabelEdits& edits);
void take_hidden_label_opacities(const nlohmann::ordered_json& json, LabelEdits* edits);

// Whether the curves are those that show the labels by value, which follow their styles.
bool shows_labels_by_value(const TransferFunction& tf, const std::vector<LabelStyle>& styles);

}  // namespace ovoid::viewer
