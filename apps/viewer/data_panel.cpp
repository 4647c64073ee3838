// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "start_page.h"

namespace ovoid::viewer {
namespace {

std::string text_of(const ValueRange& range) {
  return range.is_empty() ? "no values" : fmt::format("{:.3g} to {:.3g}", range.lo, range.hi);
}

bool radio(Widgets& widgets, const std::string& name, bool is_on) {
  const bool is_pressed = ImGui::RadioButton(("##" + name).c_str(), is_on);
  widgets.mark(name);
  return is_pressed;
}

void choose_component(Panel& panel, ArrayChoice& choice) {
  const ArrayInfo* const chosen = panel.document.array_info(choice.array);
  if (chosen != nullptr && chosen->num_components > 1) {
    int component = choice.component + 1;  // the norm comes first
    std::vector<std::string> names = {"magnitude"};
    static constexpr const char* kAxes[] = {" (x)", " (y)", " (z)"};
    const bool is_vector = chosen->num_components == 3;
    for (int i = 0; i < chosen->num_components; ++i)
      names.push_back(fmt::format("{}{}", i, is_vector ? kAxes[i] : ""));
    std::vector<const char*> options;
    options.reserve(names.size());
    for (const std::string& name : names) options.push_back(name.c_str());
    if (panel.widgets.choice("data.component", "component", options, &component))
      choice.component = component - 1;
  } else {
    choice.component = 0;
  }
}

void array_table(Panel& panel) {
  Document& document = panel.document;
  const Shown& shown = *document.shown;
  const bool has_colors = document.info->kind != DatasetKind::kLattice;
  ArrayChoice choice = choice_of(shown);
  // Particles without a density of their own are drawn by their number per volume at first.
  const bool is_of_none = document.array_info(shown.array) == nullptr;
  if (is_of_none) choice.is_density = true;
  const ArrayChoice before = choice;
  if (!ImGui::BeginTable("arrays", has_colors ? 4 : 3,
                         ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit))
    return;
  ImGui::TableSetupColumn(has_colors ? "opacity" : "shown");
  if (has_colors) ImGui::TableSetupColumn("colour");
  ImGui::TableSetupColumn("array", ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn("range");
  ImGui::TableHeadersRow();
  for (const ArrayInfo& array : document.info->arrays) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    if (radio(panel.widgets, "data.array." + array.name, array.name == choice.array)) {
      if (choice.color_array == choice.array || is_of_none) choice.color_array = array.name;
      choice.array = array.name;
      choice.component = array.usual_component;
      choice.is_density = false;
    }
    if (has_colors) {
      ImGui::TableNextColumn();
      if (radio(panel.widgets, "data.color." + array.name, array.name == choice.color_array))
        choice.color_array = array.name;
    }
    ImGui::TableNextColumn();
    const std::string name =
        fmt::format("{}{}{}", array.name, array.is_cell_data ? " (cells)" : "",
                    array.num_components > 1 ? fmt::format(" x{}", array.num_components) : "");
    ImGui::TextUnformatted(name.c_str());
    panel.widgets.tip(name.c_str());
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(
        (text_of(array.range) + (array.unit.empty() ? "" : " " + array.unit)).c_str());
  }
  if (document.info->kind == DatasetKind::kParticles) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    if (radio(panel.widgets, "data.density", choice.is_density) && !before.is_density) {
      choice = {};
      choice.is_density = true;
    }
    ImGui::TableNextColumn();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted("density");
    panel.widgets.tip("The particles' mass per volume, or their number where they have no mass.");
  }
  ImGui::EndTable();
  choose_component(panel, choice);
  if (choice == before) return;
  choice.channels.clear();
  panel.wishes.array = choice;
}

void files_of_state(Panel& panel) {
  Widgets& widgets = panel.widgets;
  widgets.text("data.state.path", "state file", &panel.state.state_path, -172 * widgets.scale());
  widgets.tip(
      "Everything that is set, as one file; 'ovoid render --state FILE' draws the same "
      "picture.");
  ImGui::SameLine();
  if (widgets.button("data.state.save", "save")) panel.wishes.write_state = panel.state.state_path;
  ImGui::SameLine();
  if (widgets.button("data.state.restore", "restore"))
    panel.wishes.read_state = panel.state.state_path;
  ImGui::SameLine();
  browse_button(panel, "data.state.browse", "browse", Browsing::kState);
}

void about_data(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  const Field& field = document.shown->field();
  widgets.row("file", document.info->title);
  widgets.row("kind", document.shown->solid ? "solid" : name_of(document.info->kind));
  widgets.row("kernels", fmt::format("{}", field.num_kernels()));
  widgets.row("memory",
              fmt::format("{:.1f} MiB", static_cast<double>(field.resident_bytes()) / 1048576));
  widgets.row("drawn values", text_of(field.value_range()));
  ImGui::Separator();
  if (document.info->arrays.empty()) {
    ImGui::TextWrapped("No arrays: the field is the particles' number per volume.");
  } else {
    array_table(panel);
  }
  ImGui::Separator();
  if (widgets.button("data.copy", "copy as command")) panel.wishes.copies_command = true;
  widgets.tip(
      "The line of 'ovoid render' that draws this picture, byte for byte on the same back "
      "end (Ctrl+C).");
  ImGui::SameLine();
  if (widgets.button("data.picture", "save the picture")) panel.wishes.saves_picture = true;
  files_of_state(panel);
  if (document.notes.empty()) return;
  ImGui::Separator();
  for (const std::string& note : document.notes) ImGui::TextWrapped("%s", note.c_str());
}

void choose_theme(Panel& panel) {
  std::vector<const char*> options;
  for (const auto& [name, theme] : theme_names()) options.push_back(name);
  int chosen = static_cast<int>(panel.status.theme);
  if (panel.widgets.choice("data.theme", "theme", options, &chosen))
    panel.wishes.theme = static_cast<Theme>(chosen);
}

}  // namespace

void data_panel(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  if (widgets.text("data.open.path", "a file to open, or drop one here", &panel.state.open_path,
                   -124 * widgets.scale()))
    panel.wishes.open = panel.state.open_path;
  ImGui::SameLine();
  if (widgets.button("data.open", "open")) panel.wishes.open = panel.state.open_path;
  ImGui::SameLine();
  browse_button(panel, "data.browse", "browse", Browsing::kInput);
  recent_choice(panel);
  if (document.is_open()) about_data(panel);
  ImGui::Separator();
  choose_theme(panel);
}

}  // namespace ovoid::viewer
