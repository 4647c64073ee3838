// SPDX-License-Identifier: Apache-2.0
// What lies around and over the picture.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "app.h"

namespace ovoid::viewer {
namespace {

struct KeyHelp {
  const char* keys;
  const char* meaning;
};
constexpr std::array kHelp = {
    KeyHelp{"drag", "turn"},
    KeyHelp{"shift + drag, middle drag", "move"},
    KeyHelp{"wheel, two fingers", "zoom to the mouse"},
    KeyHelp{"right drag", "zoom"},
    KeyHelp{"ctrl + drag", "roll"},
    KeyHelp{"double click", "turn about this place"},
    KeyHelp{"yellow and coloured dots", "drag: crop, planes, slices, vertices"},
    KeyHelp{"shift + arrows, [ ]", "turn and roll in steps"},
    KeyHelp{"1 ... 6", "from +x, -x, +y, -y, +z, -z"},
    KeyHelp{"r", "the first view again"},
    KeyHelp{"p", "parallel or perspective"},
    KeyHelp{"space, left, right", "play, step through time"},
    KeyHelp{"ctrl + o", "open a file"},
    KeyHelp{"s", "save the picture"},
    KeyHelp{"ctrl + c", "copy as command"},
    KeyHelp{"ctrl + s", "save the state"},
    KeyHelp{"ctrl + z, ctrl + y", "undo, redo (also ctrl + shift + z)"},
    KeyHelp{"tab", "panel"},
    KeyHelp{"f", "full screen"},
    KeyHelp{"?, escape", "this help, and away with it"},
    KeyHelp{"ctrl + q, ctrl + w", "close"}};

}  // namespace

void App::draw_panel(Panel& panel, ImVec2 at, ImVec2 size) {
  struct Tab {
    const char* name;
    void (*draw)(Panel&);
    bool needs_data;
  };
  static constexpr std::array<Tab, 9> kTabs = {{{"data", data_panel, false},
                                                {"look", look_panel, true},
                                                {"space", space_panel, true},
                                                {"scene", scene_panel, true},
                                                {"time", time_panel, true},
                                                {"solid", solid_panel, true},
                                                {"compare", compare_panel, true},
                                                {"quality", quality_panel, true},
                                                {"fit", fit_panel, true}}};
  const bool is_control_mesh = document_.is_open() && document_.info->is_control_mesh;
  ImGui::SetNextWindowPos(at);
  ImGui::SetNextWindowSize(size);
  ImGui::Begin("panel", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings);
  // All tabs have room in a panel of the usual width.
  const ImVec2 usual = ImGui::GetStyle().FramePadding;
  const ImVec2 narrow(usual.x / 3, usual.y);
  const auto push_narrow = [&] {
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, narrow);
    ImGui::PushStyleVar(ImGuiStyleVar_ItemInnerSpacing, ImVec2(1, 0));  // between them
  };
  push_narrow();
  const bool has_tabs = ImGui::BeginTabBar("tabs", ImGuiTabBarFlags_FittingPolicyScroll);
  ImGui::PopStyleVar(2);
  is_scene_shown_ = false;
  if (has_tabs) {
    for (const Tab& tab : kTabs) {
      // A control mesh has no steps in time; all other data are no solid.
      if (tab.draw == (is_control_mesh ? time_panel : solid_panel)) continue;
      // The first that is seen is the one that is used most.
      const bool is_first = !has_chosen_tab_ && document_.is_open() && tab.draw == look_panel;
      if (is_first) has_chosen_tab_ = true;
      push_narrow();
      const bool is_open = ImGui::BeginTabItem(
          tab.name, nullptr, is_first ? ImGuiTabItemFlags_SetSelected : ImGuiTabItemFlags_None);
      ImGui::PopStyleVar(2);
      widgets_.mark(fmt::format("tab.{}", tab.name));
      if (!is_open) continue;
      is_scene_shown_ = tab.draw == scene_panel;
      if (!tab.needs_data || document_.is_open()) {
        tab.draw(panel);
      } else {
        ImGui::TextDisabled("Nothing is open.");
      }
      ImGui::EndTabItem();
    }
    ImGui::EndTabBar();
  }
  ImGui::End();
}

void App::draw_transport(Panel& panel, ImVec2 at, ImVec2 size) {
  const float scale = gui_.scale();
  const float left = std::min(190 * scale, size.x * 0.3F);  // beside the axes
  const float width = std::clamp(size.x - 2 * left, 60 * scale, 460 * scale);
  ImGui::SetNextWindowPos(
      {at.x + std::max((size.x - width) / 2, left), at.y + size.y - 44 * scale});
  ImGui::SetNextWindowSize({width, 36 * scale});
  ImGui::SetNextWindowBgAlpha(0.6F);
  ImGui::Begin("transport", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                   ImGuiWindowFlags_NoNav);
  TimeState& time = document_.time;
  const std::vector<double>& times = document_.info->times;
  if (widgets_.button("transport.play", time.is_playing ? "||" : ">"))
    time.is_playing = !time.is_playing;
  ImGui::SameLine();
  const std::string format = time_label(times, document_.info->time_unit, time.now).format();
  if (widgets_.slider("transport.time", "", &time.now, times.front(), times.back(), format.c_str()))
    panel.wishes.goes_to_time = true;
  ImGui::End();
}

void App::draw_status(ImVec2 at, ImVec2 size) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const ThemeColors& colors = widgets_.colors();
  const float line = ImGui::GetTextLineHeightWithSpacing();
  const float left = at.x + 8;
  float y = at.y + 6;
  if (document_.is_open() && picture_view_.shown() != nullptr) {
    const Pictures& shown = *picture_view_.shown();
    widgets_.label(list, {left, y}, colors.faint, describe(shown.level, shown.is_final));
    y += line + 4;
  }
  if (const auto& picked = picture_view_.picked()) {
    const Vec3& place = picked->position;
    std::string text = fmt::format("{:.5g}, {:.5g}, {:.5g}", place.x(), place.y(), place.z());
    if (!document_.shown->subject.described.length_unit.empty())
      text += " " + document_.shown->subject.described.length_unit;
    if (picked->is_defined)
      text += fmt::format(": {:.5g} {}", picked->value, document_.shown->subject.unit);
    widgets_.label(list, {left, y}, colors.ink, text);
    y += line + 4;
  }
  if (progress_) {
    const std::string text = progress_->what;
    widgets_.label(list, {left, y}, colors.ink, text);
    y += line + 4;
    const float width = std::min(260 * gui_.scale(), size.x - 20);
    list.AddRectFilled({left, y}, {left + width, y + 6}, colors.ground, 3);
    const auto done = static_cast<float>(std::clamp(progress_->fraction, 0.0, 1.0));
    list.AddRectFilled({left, y}, {left + width * done, y + 6}, colors.bar, 3);
    y += 14;
  }
  const double now = now_s();
  while (!messages_.empty() && messages_.front().until < now) messages_.pop_front();
  for (const Message& message : messages_) {
    const float wrap = std::max(size.x - 24, 60.0F);
    widgets_.label(list, {left, y}, message.is_error ? colors.error : colors.ink, message.text,
                   wrap);
    y += ImGui::CalcTextSize(message.text.c_str(), nullptr, false, wrap).y + 8;
  }
}

void App::draw_help() {
  const ImVec2 all = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({all.x / 2, all.y / 2}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowBgAlpha(0.93F);
  ImGui::SetNextWindowSizeConstraints({100, 60}, {all.x, all.y});
  ImGui::SetNextWindowFocus();
  ImGui::Begin("help", &shows_help_,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoMove);
  if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
    for (const KeyHelp& help : kHelp) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextDisabled("%s   ", help.keys);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(help.meaning);
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

}  // namespace ovoid::viewer
