// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "panels.h"

namespace ovoid::viewer {
void compare_panel(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  ImGui::TextWrapped("Keep how the picture looks as A, change anything, and see both.");
  if (widgets.button("compare.keep", "keep this as A")) {
    document.other = Setting{document.view, document.setup};
    document.compare = CompareMode::kDivided;
    document.touch_other();
  }
  ImGui::SameLine();
  if (widgets.button("compare.swap", "swap A and B", document.other.has_value())) {
    std::swap(document.other->view, document.view);
    std::swap(document.other->setup, document.setup);
    document.touch();
    document.touch_other();
  }
  if (!document.other) return;
  ImGui::SameLine();
  if (widgets.button("compare.drop", "drop A")) {
    document.other.reset();
    document.compare = CompareMode::kOff;
    document.touch_other();
    return;
  }
  int mode = static_cast<int>(document.compare);
  if (widgets.choice("compare.mode", "show",
                     {"B alone", "A left, B right of a line", "A and B side by side", "difference"},
                     &mode)) {
    document.compare = static_cast<CompareMode>(mode);
    document.touch_beside_view();
  }
  if (document.compare == CompareMode::kOff) return;
  if (document.compare == CompareMode::kDivided)
    ImGui::TextWrapped("Drag the line between them in the picture.");
  if (document.compare == CompareMode::kDifference)
    ImGui::TextWrapped("Distances of colour, %.0f times as bright.", kDifferenceGain);
  if (!panel.status.is_final) {
    widgets.row("PSNR", "...");
  } else {
    widgets.row("PSNR", std::isinf(panel.status.psnr)
                            ? "equal"
                            : fmt::format("{:.2f} dB", panel.status.psnr));
  }
}

}  // namespace ovoid::viewer
