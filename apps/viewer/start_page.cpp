// SPDX-License-Identifier: Apache-2.0
#include "start_page.h"

#include <fmt/format.h>

#include <algorithm>

namespace ovoid::viewer {
namespace {

// As much of the end of a path as fits, whole folders.
std::string end_of(const std::string& path, float room) {
  std::string end = path;
  while (ImGui::CalcTextSize(end.c_str()).x > room) {
    const std::size_t slash = end.find('/', end.starts_with(".../") ? 4 : 1);
    if (slash == std::string::npos) return "";
    end = "..." + end.substr(slash);
  }
  return end;
}

// One row for each input, NAME.N by number; those that are not there cannot be chosen. Behind
// the name stands where it lies.
void recent_rows(Panel& panel, const std::string& name) {
  const float room = ImGui::GetContentRegionAvail().x;
  const std::vector<RecentInput>& recent = panel.memory.recent();
  for (std::size_t i = 0; i < recent.size(); ++i) {
    const RecentInput& input = recent[i];
    const std::string row = fmt::format("{}.{}", name, i);
    const ImVec2 at = ImGui::GetCursorPos();
    const ImGuiSelectableFlags flags =
        input.is_there ? ImGuiSelectableFlags_None : ImGuiSelectableFlags_Disabled;
    if (ImGui::Selectable((input.title() + "##" + row).c_str(), false, flags))
      panel.wishes.open_recent = i;
    panel.widgets.mark(row);
    std::string tip = fmt::format("{}", fmt::join(input.words(), "\n"));
    if (!input.is_there) tip += "\nis not there now";
    panel.widgets.tip(tip.c_str());
    const char* const before = input.is_there ? "" : "not there: ";
    const float left = ImGui::CalcTextSize(input.title().c_str()).x + 12 * panel.widgets.scale();
    const std::string folder = end_of(input.folder(), room - left - ImGui::CalcTextSize(before).x);
    if (folder.empty()) continue;
    ImGui::SameLine(at.x + left);
    ImGui::TextDisabled("%s%s", before, folder.c_str());
  }
}

}  // namespace

void browse_button(Panel& panel, const std::string& name, const char* label, Browsing what) {
  if (panel.widgets.button(name, label, !panel.status.is_browsing)) panel.wishes.browses = what;
  panel.widgets.tip(what == Browsing::kInput
                        ? "The desktop's own dialog, if zenity or kdialog is installed (Ctrl+O)."
                        : "The desktop's own dialog, if zenity or kdialog is installed.");
}

void recent_choice(Panel& panel) {
  if (panel.memory.recent().empty()) return;
  ImGui::SetNextItemWidth(-FLT_MIN);
  const bool is_open =
      ImGui::BeginCombo("##data.recent", "opened last ...", ImGuiComboFlags_HeightLarge);
  panel.widgets.mark("data.recent");
  if (!is_open) return;
  recent_rows(panel, "data.recent");
  ImGui::Separator();
  if (ImGui::Selectable("forget these")) panel.wishes.forgets_recent = true;
  panel.widgets.mark("data.recent.forget");
  ImGui::EndCombo();
}

void start_page(Panel& panel, const std::string& error, ImVec2 at, ImVec2 size) {
  const float width = std::min(size.x * 0.9F, 560 * panel.widgets.scale());
  ImGui::SetNextWindowPos({at.x + size.x / 2, at.y + size.y / 2}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSize({std::max(width, 1.0F), 0});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
  ImGui::Begin("start", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::PopStyleVar();
  if (!error.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, panel.widgets.colors().error);
    ImGui::TextWrapped("%s", error.c_str());
    ImGui::PopStyleColor();
    ImGui::Separator();
  }
  ImGui::TextWrapped("Drop a file here, or name one in the panel (Tab).");
  browse_button(panel, "start.browse", "browse for a file", Browsing::kInput);
  if (!panel.memory.recent().empty()) {
    ImGui::Separator();
    ImGui::TextDisabled("Opened last:");
    recent_rows(panel, "start.recent");
  }
  ImGui::End();
}

}  // namespace ovoid::viewer
