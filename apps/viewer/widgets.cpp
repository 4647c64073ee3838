// SPDX-License-Identifier: Apache-2.0
#include "widgets.h"

#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace ovoid::viewer {
namespace {

// ImGui shows what stands before "##" and tells items apart by all of it.
std::string hidden_label(const std::string& name) { return "##" + name; }

}  // namespace

void Widgets::begin_frame(float scale) {
  last_ = std::exchange(now_, {});
  scale_ = scale;
}

void Widgets::mark(const std::string& name) {
  const ImVec2 lo = ImGui::GetItemRectMin();
  const ImVec2 hi = ImGui::GetItemRectMax();
  now_[name] = {{lo.x, lo.y, hi.x, hi.y}, ImGui::IsItemVisible()};
  if (wanted_ == name) {
    ImGui::SetScrollHereY(0.5F);
    wanted_.clear();
  }
}

void Widgets::mark(const std::string& name, const Box2& box) { now_[name] = {box, true}; }

std::optional<Box2> Widgets::find(const std::string& name) const {
  const auto found = now_.find(name);
  if (found == now_.end() || !found->second.is_in_sight) return std::nullopt;
  return found->second.box;
}

bool Widgets::scroll_to(const std::string& name) {
  if (now_.find(name) == now_.end()) return false;
  wanted_ = name;
  return true;
}

std::vector<std::string> Widgets::names() const {
  std::vector<std::string> names;
  names.reserve(now_.size());
  for (const auto& [name, place] : now_) names.push_back(name);
  return names;
}

void Widgets::label_before(const char* label) const {
  if (label == nullptr || *label == '\0') return;
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(label);
  ImGui::SameLine(width_of_label());
}

bool Widgets::button(const std::string& name, const char* label, bool is_enabled) {
  ImGui::BeginDisabled(!is_enabled);
  const bool is_pressed = ImGui::Button((label + hidden_label(name)).c_str());
  mark(name);
  ImGui::EndDisabled();
  return is_pressed;
}

bool Widgets::checkbox(const std::string& name, const char* label, bool* value) {
  const bool is_changed = ImGui::Checkbox((label + hidden_label(name)).c_str(), value);
  mark(name);
  return is_changed;
}

bool Widgets::number(const std::string& name, const char* label, double* value,
                     const NumberField& field) {
  label_before(label);
  double speed = field.speed;
  if (speed == 0) {
    const bool is_bounded = field.hi - field.lo < 1e100;
    speed = is_bounded ? (field.hi - field.lo) / 200 : std::max(std::abs(*value) / 100, 1e-6);
  }
  const ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat |
                                 (field.is_logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
  ImGui::SetNextItemWidth(-FLT_MIN);
  double edited = *value;
  const bool is_changed =
      ImGui::DragScalar(hidden_label(name).c_str(), ImGuiDataType_Double, &edited,
                        static_cast<float>(speed), &field.lo, &field.hi, field.format, flags);
  mark(name);
  if (!is_changed || !std::isfinite(edited)) return false;
  *value = edited;
  return true;
}

bool Widgets::slider(const std::string& name, const char* label, double* value, double lo,
                     double hi, const char* format) {
  label_before(label);
  ImGui::SetNextItemWidth(-FLT_MIN);
  double edited = *value;
  const bool is_changed =
      ImGui::SliderScalar(hidden_label(name).c_str(), ImGuiDataType_Double, &edited, &lo, &hi,
                          format, ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat);
  mark(name);
  if (!is_changed || !std::isfinite(edited)) return false;
  *value = edited;
  return true;
}

bool Widgets::whole(const std::string& name, const char* label, int* value, int lo, int hi) {
  label_before(label);
  ImGui::SetNextItemWidth(-FLT_MIN);
  const bool is_changed = ImGui::SliderInt(hidden_label(name).c_str(), value, lo, hi, "%d",
                                           ImGuiSliderFlags_AlwaysClamp);
  mark(name);
  return is_changed;
}

bool Widgets::vector(const std::string& name, const char* label, Vec3* value, double speed) {
  label_before(label);
  ImGui::SetNextItemWidth(-FLT_MIN);
  std::array<double, 3> edited = {value->x(), value->y(), value->z()};
  const bool is_changed =
      ImGui::DragScalarN(hidden_label(name).c_str(), ImGuiDataType_Double, edited.data(), 3,
                         static_cast<float>(speed), nullptr, nullptr, "%.4g");
  mark(name);
  const bool is_finite = std::all_of(edited.begin(), edited.end(),
                                     [](double number) { return std::isfinite(number); });
  if (!is_changed || !is_finite) return false;
  *value = Vec3(edited[0], edited[1], edited[2]);
  return true;
}

bool Widgets::color(const std::string& name, const char* label, Rgb* value) {
  label_before(label);
  std::array<float, 3> edited = {static_cast<float>((*value)[0]), static_cast<float>((*value)[1]),
                                 static_cast<float>((*value)[2])};
  ImGui::SetNextItemWidth(-FLT_MIN);
  const bool is_changed = ImGui::ColorEdit3(hidden_label(name).c_str(), edited.data());
  mark(name);
  if (is_changed) *value = {edited[0], edited[1], edited[2]};
  return is_changed;
}

bool Widgets::choice(const std::string& name, const char* label,
                     const std::vector<const char*>& options, int* chosen) {
  label_before(label);
  ImGui::SetNextItemWidth(-FLT_MIN);
  bool is_changed = false;
  const bool has_chosen = *chosen >= 0 && *chosen < static_cast<int>(options.size());
  const char* const shown = has_chosen ? options[static_cast<std::size_t>(*chosen)] : "";
  const bool is_open =
      ImGui::BeginCombo(hidden_label(name).c_str(), shown, ImGuiComboFlags_HeightLarge);
  mark(name);
  if (!is_open) return false;
  for (int i = 0; i < static_cast<int>(options.size()); ++i) {
    const char* const option = options[static_cast<std::size_t>(i)];
    if (ImGui::Selectable(option, i == *chosen)) {
      *chosen = i;
      is_changed = true;
    }
    mark(name + "/" + option);
  }
  ImGui::EndCombo();
  return is_changed;
}

bool Widgets::text(const std::string& name, const char* hint, std::string* value, float width) {
  ImGui::SetNextItemWidth(width);
  const bool is_entered = ImGui::InputTextWithHint(hidden_label(name).c_str(), hint, value,
                                                   ImGuiInputTextFlags_EnterReturnsTrue);
  mark(name);
  return is_entered;
}

void Widgets::tip(const char* sentence) const {
  if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(280 * scale_);
  ImGui::TextUnformatted(sentence);
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

}  // namespace ovoid::viewer
