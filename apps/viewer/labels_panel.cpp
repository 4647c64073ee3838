// SPDX-License-Identifier: Apache-2.0
// Of the tab "scene": the labels that are drawn, one in a row.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>

#include "panels.h"

namespace ovoid::viewer {
namespace {

constexpr std::size_t kMostRowsInSight = 9;  // further ones are scrolled to
constexpr std::size_t kManyRows = 400;       // of which those out of sight are not laid out
constexpr float kOpacityWidth = 84;

std::string title_of(const LabelStyle& style) {
  return style.name.empty() ? fmt::format("label {}", style.label) : style.name;
}

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// Air, which the list leaves out.
bool is_nothing(const LabelStyle& plain) { return plain.label == 0 && plain.opacity == 0; }

// The numbers in the list of those whose name or number has the text in it.
std::vector<std::size_t> matching(const std::vector<LabelStyle>& plain, const std::string& text) {
  const std::string wanted = lower_case(text);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const bool is_match = lower_case(title_of(plain[i])).find(wanted) != std::string::npos ||
                          std::to_string(plain[i].label) == wanted;
    if (is_match && !is_nothing(plain[i])) rows.push_back(i);
  }
  return rows;
}

// One label's row: `style` as it is drawn.
bool label_row(Widgets& widgets, const LabelStyle& plain, LabelStyle style, LabelEdits* edits) {
  const std::string name = fmt::format("scene.label.{}", style.label);
  const float scale = widgets.scale();
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const float at_opacity = ImGui::GetContentRegionMax().x - kOpacityWidth * scale;
  const float at_color = at_opacity - gap - ImGui::GetFrameHeight();
  const float room = at_color - ImGui::GetCursorPosX() - ImGui::GetFrameHeight() - 2 * gap;
  bool is_changed = false;
  bool is_shown = style.opacity > 0;
  const std::string title = title_of(style);
  if (widgets.checkbox(name + ".show", widgets.fitted(title, room).c_str(), &is_shown)) {
    show_label(plain, is_shown, edits);
    is_changed = true;
  }
  widgets.tip(fmt::format("{}: label {}", title, style.label).c_str());
  ImGui::SameLine(at_color);
  if (widgets.swatch(name + ".color", &style.color)) {
    (*edits)[style.label].color = in_bytes(style.color);
    is_changed = true;
  }
  ImGui::SameLine(at_opacity);
  if (!is_shown) {
    ImGui::TextDisabled("hidden");
    return is_changed;
  }
  if (widgets.bare_slider(name + ".opacity", &style.opacity, 0.02, 1)) {
    (*edits)[style.label].opacity = style.opacity;
    is_changed = true;
  }
  return is_changed;
}

void show_rows(const std::vector<LabelStyle>& plain, const std::vector<std::size_t>& rows,
               bool is_shown, LabelEdits* edits) {
  for (const std::size_t row : rows) {
    // Those that their table hides are not meant by all.
    if (plain[row].opacity > 0 || !is_shown) show_label(plain[row], is_shown, edits);
  }
}

bool label_rows(Panel& panel, const std::vector<LabelStyle>& plain,
                const std::vector<std::size_t>& rows, LabelEdits* edits) {
  Widgets& widgets = panel.widgets;
  const std::vector<LabelStyle> styles = edited(plain, *edits);
  const std::size_t in_sight = std::clamp(rows.size(), std::size_t{1}, kMostRowsInSight);
  bool is_changed = false;
  widgets.begin_list("scene.labels.list", static_cast<int>(in_sight));
  ImGuiListClipper clipper;
  const auto row = [&](int number) {
    const std::size_t i = rows[static_cast<std::size_t>(number)];
    is_changed |= label_row(widgets, plain[i], styles[i], edits);
  };
  if (rows.size() > kManyRows) {
    clipper.Begin(static_cast<int>(rows.size()));
    while (clipper.Step())
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) row(i);
  } else {
    for (int i = 0; i < static_cast<int>(rows.size()); ++i) row(i);
  }
  if (rows.empty()) ImGui::TextDisabled("No label has that name.");
  widgets.end_list();
  return is_changed;
}

// Which labels these are. Whether they are drawn.
bool labels_head(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  View& view = document.view;
  if (!view.labels) {
    if (widgets.checkbox("scene.labels", "surfaces of labels", &view.label_surfaces))
      document.touch();
    return view.label_surfaces;
  }
  const std::string file = std::filesystem::path(view.labels->file).filename().string();
  const float room = ImGui::GetContentRegionAvail().x - 70 * widgets.scale();
  ImGui::AlignTextToFramePadding();
  ImGui::TextDisabled("%s", widgets.fitted("labels of " + file, room).c_str());
  widgets.tip(view.labels->file.c_str());
  if (!widgets.button_at_right("scene.labels.remove", "remove")) return true;
  document.set_labels(std::nullopt);
  return document.plain_labels(view) != nullptr;
}

}  // namespace

void labels_editor(Panel& panel) {
  Document& document = panel.document;
  if (document.plain_labels(document.view) == nullptr || !labels_head(panel)) return;
  const LabelSurfaces* const labels = document.plain_labels(document.view);
  Widgets& widgets = panel.widgets;
  LabelEdits edits = document.view.label_edits;
  const float buttons = 92 * widgets.scale();
  widgets.text("scene.labels.filter", "name or number", &panel.state.label_filter, -buttons);
  const std::vector<std::size_t> rows = matching(labels->styles, panel.state.label_filter);
  bool is_changed = false;
  for (const auto& [name, is_shown] : {std::pair("all", true), std::pair("none", false)}) {
    ImGui::SameLine();
    if (!widgets.button(fmt::format("scene.labels.{}", name), name)) continue;
    show_rows(labels->styles, rows, is_shown, &edits);
    is_changed = true;
  }
  widgets.tip("Of the labels that are listed here.");
  is_changed |= label_rows(panel, labels->styles, rows, &edits);
  if (is_changed) document.edit_labels(std::move(edits));
}

}  // namespace ovoid::viewer
