// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "panels.h"

namespace ovoid::viewer {

void compare_choice(Panel& panel, const std::string& name, CompareWith with,
                    const std::vector<const char*>& options) {
  Document& document = panel.document;
  const bool is_chosen = document.compare_with == with;
  int mode = static_cast<int>(is_chosen ? document.compare : CompareMode::kOff);
  if (panel.widgets.choice(name, "show", options, &mode)) {
    document.compare = static_cast<CompareMode>(mode);
    document.compare_with = with;
    document.touch_other();
  }
  if (!document.compares() || document.compare_with != with) return;
  if (document.compare == CompareMode::kDivided)
    ImGui::TextWrapped("Drag the line between them in the picture.");
  if (document.compare == CompareMode::kDifference)
    ImGui::TextWrapped("Distances of colour, %.0f times as bright.", kDifferenceGain);
  std::string psnr = "...";
  if (panel.status.is_final) {
    psnr = std::isinf(panel.status.psnr) ? "equal" : fmt::format("{:.2f} dB", panel.status.psnr);
  }
  panel.widgets.row("PSNR of the pictures", psnr);
}

void compare_panel(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  ImGui::TextWrapped("Keep how the picture looks as A, change anything, and see both.");
  if (widgets.button("compare.keep", "keep this as A")) {
    document.other = Setting{document.view, document.setup};
    document.compare = CompareMode::kDivided;
    document.compare_with = CompareWith::kOther;
    document.touch_other();
  }
  ImGui::SameLine();
  if (widgets.button("compare.swap", "swap A and B", document.other.has_value())) {
    std::swap(document.other->view, document.view);
    std::swap(document.other->setup, document.setup);
    std::swap(document.other->view.solid, document.view.solid);  // both are of what is shown
    document.touch();
    document.touch_other();
  }
  if (!document.other) return;
  ImGui::SameLine();
  if (widgets.button("compare.drop", "drop A")) {
    document.other.reset();
    if (document.compare_with == CompareWith::kOther) document.compare = CompareMode::kOff;
    document.touch_other();
    return;
  }
  compare_choice(panel, "compare.mode", CompareWith::kOther,
                 {"B alone", "A left, B right of a line", "A and B side by side", "difference"});
}

}  // namespace ovoid::viewer
