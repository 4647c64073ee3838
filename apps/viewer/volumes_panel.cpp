// SPDX-License-Identifier: Apache-2.0
// Of the tab "scene": what is drawn together, channels of the file and volumes beside the data.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "panels.h"

namespace ovoid::viewer {
namespace {

constexpr std::size_t kMostChannels = Scene::kMaxVolumes;

// Components of the array that is shown, or else the arrays, the first few of them.
std::vector<std::string> possible_channels(const Document& document) {
  std::vector<std::string> names;
  if (document.info->kind != DatasetKind::kLattice) return names;
  const ArrayInfo* const array = document.array_info(document.shown->array);
  if (array != nullptr && array->num_components > 1) {
    for (int i = 0; i < array->num_components; ++i) names.push_back(std::to_string(i));
  } else {
    for (const ArrayInfo& each : document.info->arrays) names.push_back(each.name);
  }
  if (names.size() > kMostChannels) names.resize(kMostChannels);
  return names;
}

bool may_be_primaries(const Document& document) {
  const ArrayInfo* const array = document.array_info(document.shown->array);
  return array != nullptr && (array->num_components == 3 || array->num_components == 4);
}

// One array or component of it, several as channels, or as the colours that they are.
void choose_channels(Panel& panel, const std::vector<std::string>& names) {
  const Document& document = panel.document;
  const ShownChannels& shown = document.shown->channels;
  enum Way { kOne, kChannels, kColors };
  int way = shown.chosen.empty() ? kOne : shown.are_primaries() ? kColors : kChannels;
  std::vector<const char*> options = {"by itself", "as channels"};
  if (may_be_primaries(document)) options.push_back("as red, green, blue");
  if (!panel.widgets.choice("scene.channels", "the array", options, &way)) return;
  ArrayChoice choice = choice_of(*document.shown);
  choice.channels.clear();
  const ArrayInfo* const array = document.array_info(choice.array);
  if (way == kOne && array != nullptr) choice.component = array->usual_component;
  if (way == kChannels) choice.channels = names;
  if (way == kColors) choice.channels = {"rgb"};
  panel.wishes.array = choice;
}

bool mixing_editor(Panel& panel) {
  Mixing& mixing = panel.document.view.mixing;
  int way = mixing == Mixing::kAdded ? 1 : 0;
  const bool is_changed =
      panel.widgets.choice("scene.mixing", "mixed", {"averaged", "added"}, &way);
  panel.widgets.tip("Averaged: as two fogs in one room. Added: as lights.");
  if (is_changed) mixing = way == 1 ? Mixing::kAdded : Mixing::kAveraged;
  return is_changed;
}

bool channel_editor(Panel& panel, std::size_t number, ChannelStyle& style, bool may_be_hidden) {
  const cli::NamedChannel& channel = panel.document.shown->channels.named[number];
  Widgets& widgets = panel.widgets;
  const std::string name = fmt::format("scene.channel.{}", number);
  const float at_color = ImGui::GetContentRegionMax().x - ImGui::GetFrameHeight();
  const float room = at_color - ImGui::GetCursorPosX() - 2 * ImGui::GetFrameHeight();
  bool is_shown = !style.is_hidden;
  bool is_changed = false;
  ImGui::BeginDisabled(is_shown && !may_be_hidden);  // nothing would be left
  if (widgets.checkbox(name + ".show", widgets.fitted(channel.title, room).c_str(), &is_shown)) {
    style.is_hidden = !is_shown;
    is_changed = true;
  }
  ImGui::EndDisabled();
  ImGui::SameLine(at_color);
  if (widgets.swatch(name + ".color", &style.color)) {
    style.color = in_bytes(style.color);
    is_changed = true;
  }
  if (style.is_hidden) return is_changed;
  const ValueRange all = channel.field.value_range();
  const double span = std::max(static_cast<double>(all.hi) - all.lo, 1e-30);
  const NumberField field{.speed = span / 400};
  double lo = style.range.lo;
  double hi = style.range.hi;
  const bool is_moved = widgets.number(name + ".lo", "shows from", &lo, field) |
                        widgets.number(name + ".hi", "brightest at", &hi, field);
  const ValueRange wanted{static_cast<float>(lo), static_cast<float>(hi)};
  if (!is_moved || !(wanted.lo < wanted.hi)) return is_changed;
  style.range = wanted;
  return true;
}

double greatest_opacity(const TransferFunction& curves) {
  double greatest = 0;
  for (const OpacityPoint& point : curves.opacities) greatest = std::max(greatest, point.opacity);
  return greatest;
}

bool volume_editor(Panel& panel, std::size_t number, AddedVolume& added) {
  Widgets& widgets = panel.widgets;
  TransferFunction& curves = added.curves;
  const std::string name = fmt::format("scene.volume.{}", number);
  std::string& map = panel.state.volume_maps[number];
  bool is_changed = false;
  if (added.of->volume.look.transfer_function_2d) {
    ImGui::TextWrapped("Colour and opacity go by value and gradient.");
    return false;
  }
  if (choose_color_map(widgets, name + ".map", "colours", &map)) {
    take_color_map(curves, map);
    is_changed = true;
  }
  CurveLook look;
  look.height = 60;
  look.histogram = &added.of->histogram;
  look.is_magnified = panel.state.is_magnified;
  const ValueAxis axis = axis_of(curves, added.of->volume.field.value_range());
  is_changed |= edit_opacities(widgets, name + ".curve", curves.opacities, axis, look,
                               panel.state.volume_opacities[number]);
  is_changed |= range_editor(panel, name, curves);
  const double greatest = greatest_opacity(curves);
  double wanted = greatest;
  if (greatest > 0 && widgets.slider(name + ".opacity", "opacity", &wanted, 0.01, 1)) {
    for (OpacityPoint& point : curves.opacities) point.opacity *= wanted / greatest;
    is_changed = true;
  }
  if (widgets.button(name + ".labels", "draw as labels")) {
    panel.wishes.add_labels = added.of->source.file;
    added.is_hidden = true;
    is_changed = true;
  }
  widgets.tip("Whole numbers that stand for names, by their surfaces.");
  return is_changed;
}

}  // namespace

void channels_editor(Panel& panel) {
  Document& document = panel.document;
  const std::vector<std::string> names = possible_channels(document);
  if (names.size() < 2) return;
  choose_channels(panel, names);
  if (!document.shown->channels.chosen.empty() && !document.shows_channels(document.view)) {
    ImGui::TextWrapped(
        "Channels are not shown now: they take the mode composite, maximum or minimum (colours: "
        "composite), and no motion blur.");
  }
  bool is_changed = false;
  if (document.shows_channels(document.view) && !document.shown->channels.are_primaries()) {
    std::vector<ChannelStyle> styles = document.channels_of(document.view);
    const auto num_shown = std::count_if(styles.begin(), styles.end(),
                                         [](const ChannelStyle& each) { return !each.is_hidden; });
    for (std::size_t i = 0; i < styles.size(); ++i)
      is_changed |= channel_editor(panel, i, styles[i], num_shown > 1);
    if (is_changed) document.view.channels = std::move(styles);
    is_changed |= mixing_editor(panel);
  }
  if (is_changed) document.touch();
  ImGui::Separator();
}

void volumes_editor(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  std::vector<AddedVolume>& volumes = document.view.volumes;
  if (volumes.empty()) return;
  const bool are_hidden = std::all_of(volumes.begin(), volumes.end(),
                                      [](const AddedVolume& each) { return each.is_hidden; });
  if (!are_hidden && !document.shows_volumes(document.view)) {
    ImGui::TextWrapped(
        "Volumes are not shown now: they take the mode composite, maximum or minimum, and neither "
        "channels nor motion blur.");
  }
  bool is_changed = false;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    AddedVolume& added = volumes[i];
    const std::string name = fmt::format("scene.volume.{}", i);
    const std::string file = std::filesystem::path(added.of->source.file).filename().string();
    const float room = ImGui::GetContentRegionAvail().x - 110 * widgets.scale();
    bool is_shown = !added.is_hidden;
    if (widgets.checkbox(name + ".show", widgets.fitted(file, room).c_str(), &is_shown)) {
      added.is_hidden = !is_shown;
      is_changed = true;
    }
    widgets.tip(added.of->source.file.c_str());
    if (widgets.button_at_right(name + ".remove", "remove")) {
      volumes.erase(volumes.begin() + static_cast<std::ptrdiff_t>(i));
      panel.state.volume_opacities = {};
      panel.state.volume_maps = {};
      is_changed = true;
      break;
    }
    if (!added.is_hidden) is_changed |= volume_editor(panel, i, added);
  }
  if (document.shows_volumes(document.view)) is_changed |= mixing_editor(panel);
  if (is_changed) document.touch();
  ImGui::Separator();
}

}  // namespace ovoid::viewer
