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

auto key_of_escape() {
#if IMGUI_VERSION_NUM < 18700
  return ImGui::GetKeyIndex(ImGuiKey_Escape);
#else
  return ImGuiKey_Escape;
#endif
}

}  // namespace

void Widgets::begin_frame(float scale, const ThemeColors& colors) {
  last_ = std::exchange(now_, {});
  scale_ = scale;
  colors_ = &colors;
}

void Widgets::mark(const std::string& name) {
  const ImVec2 lo = ImGui::GetItemRectMin();
  const ImVec2 hi = ImGui::GetItemRectMax();
  mark(name, {lo.x, lo.y, hi.x, hi.y});
}

// In sight is what can be clicked: its middle.
void Widgets::mark(const std::string& name, const Box2& box) {
  const ImVec2 at = box.middle();
  now_[name] = {box, ImGui::IsRectVisible(at, {at.x + 1, at.y + 1})};
  if (wanted_ == name) {
    ImGui::SetScrollFromPosY(at.y - ImGui::GetWindowPos().y, 0.5F);
    wanted_.clear();
    has_scrolled_ = true;
  }
}

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

bool Widgets::button_at_right(const std::string& name, const char* label) {
  const float width = ImGui::CalcTextSize(label).x + 2 * ImGui::GetStyle().FramePadding.x;
  ImGui::SameLine(ImGui::GetContentRegionMax().x - width);
  return button(name, label);
}

bool Widgets::checkbox(const std::string& name, const char* label, bool* value) {
  const bool is_changed = ImGui::Checkbox((label + hidden_label(name)).c_str(), value);
  mark(name);
  return is_changed;
}

template <typename Value, typename Draw>
bool Widgets::typed(const std::string& name, Value* value, const Draw& draw) {
  ImGui::SetNextItemWidth(-FLT_MIN);
  const bool was_typed_into = typed_into_ == name;
  Value edited = *value;
  if (was_typed_into) std::copy_n(typed_.begin(), edited.size(), edited.begin());
  const bool is_changed = draw(edited.data());
  mark(name);
  const bool is_finite = std::all_of(edited.begin(), edited.end(),
                                     [](double number) { return std::isfinite(number); });
  const bool is_typed_into = ImGui::IsItemActive() && ImGui::GetIO().WantTextInput;
  if (is_typed_into) {
    typed_into_ = name;
    if (is_finite) std::copy_n(edited.begin(), edited.size(), typed_.begin());
    return false;
  }
  if (was_typed_into) typed_into_.clear();
  if (!is_finite || edited == *value || !(is_changed || was_typed_into)) return false;
  if (was_typed_into && ImGui::IsKeyPressed(key_of_escape())) return false;
  *value = edited;
  return true;
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
  std::array<double, 1> edited = {*value};
  const bool is_changed = typed(name, &edited, [&](double* numbers) {
    return ImGui::DragScalar(hidden_label(name).c_str(), ImGuiDataType_Double, numbers,
                             static_cast<float>(speed), &field.lo, &field.hi, field.format, flags);
  });
  *value = edited[0];
  return is_changed;
}

bool Widgets::slider(const std::string& name, const char* label, double* value, double lo,
                     double hi, const char* format) {
  label_before(label);
  std::array<double, 1> edited = {*value};
  const bool is_changed = typed(name, &edited, [&](double* numbers) {
    return ImGui::SliderScalar(hidden_label(name).c_str(), ImGuiDataType_Double, numbers, &lo, &hi,
                               format,
                               ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat);
  });
  *value = edited[0];
  return is_changed;
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
  std::array<double, 3> edited = {value->x(), value->y(), value->z()};
  const bool is_changed = typed(name, &edited, [&](double* numbers) {
    return ImGui::DragScalarN(hidden_label(name).c_str(), ImGuiDataType_Double, numbers, 3,
                              static_cast<float>(speed), nullptr, nullptr, "%.4g");
  });
  *value = Vec3(edited[0], edited[1], edited[2]);
  return is_changed;
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

bool Widgets::swatch(const std::string& name, Rgb* value) {
  std::array<float, 3> edited = {static_cast<float>((*value)[0]), static_cast<float>((*value)[1]),
                                 static_cast<float>((*value)[2])};
  const std::string popup = name + "/picker";
  const ImVec4 shown(edited[0], edited[1], edited[2], 1);
  if (ImGui::ColorButton(hidden_label(name).c_str(), shown, ImGuiColorEditFlags_NoTooltip))
    ImGui::OpenPopup(popup.c_str());
  mark(name);
  if (!ImGui::BeginPopup(popup.c_str())) return false;
  ImGui::SetNextItemWidth(220 * scale_);
  const bool is_changed =
      ImGui::ColorPicker3(hidden_label(popup).c_str(), edited.data(),
                          ImGuiColorEditFlags_NoSidePreview | ImGuiColorEditFlags_NoSmallPreview |
                              ImGuiColorEditFlags_DisplayHex);
  mark(popup);
  if (ImGui::IsKeyPressed(key_of_escape())) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
  if (is_changed) *value = {edited[0], edited[1], edited[2]};
  return is_changed;
}

bool Widgets::bare_slider(const std::string& name, double* value, double lo, double hi) {
  return slider(name, "", value, lo, hi, "%.2f");
}

bool Widgets::choice(const std::string& name, const char* label,
                     const std::vector<const char*>& options, int* chosen,
                     const std::function<void(int option)>& decorate) {
  label_before(label);
  ImGui::SetNextItemWidth(-FLT_MIN);
  bool is_changed = false;
  const bool has_chosen = *chosen >= 0 && *chosen < static_cast<int>(options.size());
  const char* const shown = has_chosen ? options[static_cast<std::size_t>(*chosen)] : "choose ...";
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
    if (decorate && ImGui::IsItemVisible()) decorate(i);
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

std::string Widgets::fitted(const std::string& text, float width) const {
  if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
  std::string part = text;
  while (!part.empty()) {
    // Whole characters go.
    do {
      part.pop_back();
    } while (!part.empty() && (static_cast<unsigned char>(part.back()) & 0xC0) == 0x80);
    const bool is_whole = part.empty() || (static_cast<unsigned char>(part.back()) & 0x80) == 0;
    if (is_whole && ImGui::CalcTextSize((part + "...").c_str()).x <= width) break;
  }
  return part + "...";
}

void Widgets::begin_list(const std::string& name, int rows) {
  const float height = static_cast<float>(rows) * ImGui::GetFrameHeightWithSpacing();
  has_scrolled_ = false;
  ImGui::BeginChild(hidden_label(name).c_str(), ImVec2(0, height));
}

void Widgets::end_list() {
  ImGui::EndChild();
  if (!std::exchange(has_scrolled_, false)) return;
  const float middle = (ImGui::GetItemRectMin().y + ImGui::GetItemRectMax().y) / 2;
  ImGui::SetScrollFromPosY(middle - ImGui::GetWindowPos().y, 0.5F);
}

void Widgets::row(const char* label, const std::string& value) {
  ImGui::TextUnformatted(label);
  const float width = ImGui::CalcTextSize(value.c_str()).x;
  ImGui::SameLine(std::max(ImGui::GetContentRegionMax().x - width, 0.0F));
  ImGui::TextUnformatted(value.c_str());
}

void Widgets::label(ImDrawList& list, ImVec2 at, ImU32 color, const std::string& text, float wrap) {
  const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, wrap);
  list.AddRectFilled({at.x - 4, at.y - 2}, {at.x + size.x + 4, at.y + size.y + 2}, colors_->ground,
                     3);
  list.AddText(nullptr, 0, at, color, text.c_str(), nullptr, wrap);
}

void Widgets::tip(const char* sentence) {
  if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  // Not at once, and not after a click, when it would lie over what the click has opened.
  constexpr double kRest = 0.7;
  const ImVec2 item = ImGui::GetItemRectMin();
  const bool is_other = item.x != rested_on_.x || item.y != rested_on_.y;
  if (is_other || ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
    rested_on_ = item;
    rests_since_ = ImGui::GetTime() + (is_other ? 0 : 1e9);
  }
  if (ImGui::GetTime() - rests_since_ < kRest) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(280 * scale_);
  ImGui::TextUnformatted(sentence);
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

}  // namespace ovoid::viewer
