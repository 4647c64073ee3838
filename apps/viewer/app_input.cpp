// SPDX-License-Identifier: Apache-2.0
// Keys and drops.
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <array>

#include "app.h"
#include "hands.h"

namespace ovoid::viewer {
namespace {

constexpr double kTurn = 5;  // degrees per key

constexpr std::array<const char*, 6> kViews = {"+x", "-x", "+y", "-y", "+z", "-z"};

}  // namespace

void App::take_shortcuts(const std::vector<Event>& events) {
  for (const Event& event : events) {
    if (std::holds_alternative<CloseAsked>(event)) is_open_ = false;
    if (const auto* dropped = std::get_if<Dropped>(&event)) take_drop(dropped->paths);
    const auto* key = std::get_if<KeyChanged>(&event);
    // A field that is typed into has the keys for itself.
    if (key == nullptr || !key->is_down || ImGui::GetIO().WantTextInput) continue;
    take_key(*key);
  }
}

bool App::take_key(const KeyChanged& key) {
  const bool has_ctrl = ImGui::GetIO().KeyCtrl || (key.modifiers & GLFW_MOD_CONTROL) != 0;
  const bool is_shifted = ImGui::GetIO().KeyShift || (key.modifiers & GLFW_MOD_SHIFT) != 0;
  if (!has_ctrl) return take_plain_key(key.key, is_shifted);
  Wishes wishes;
  switch (key.key) {
    case GLFW_KEY_Z:
      is_shifted ? document_.redo() : document_.undo();
      break;
    case GLFW_KEY_Y:
      document_.redo();
      break;
    case GLFW_KEY_C:
      wishes.copies_command = true;
      break;
    case GLFW_KEY_O:
      wishes.browses = Browsing::kInput;
      break;
    case GLFW_KEY_S:
      wishes.write_state = panel_state_.state_path;
      break;
    case GLFW_KEY_Q:
    case GLFW_KEY_W:
      is_open_ = false;
      break;
    default:
      return false;
  }
  grant(std::move(wishes));
  return true;
}

bool App::take_plain_key(int key, bool is_shifted) {
  if (key == GLFW_KEY_SLASH && is_shifted) {
    shows_help_ = !shows_help_;
    return true;
  }
  if (key == GLFW_KEY_ESCAPE) {
    shows_help_ = false;
    return true;
  }
  if (key == GLFW_KEY_F) {
    window_.toggle_full_screen();
    return true;
  }
  if (key == GLFW_KEY_TAB) {
    has_panel_ = !has_panel_;
    return true;
  }
  if (!document_.is_open()) return false;
  Camera& camera = document_.camera;
  const bool has_time = document_.has_time();
  if (key >= GLFW_KEY_1 && key <= GLFW_KEY_6) {
    document_.reset_camera(aspect(), kViews[static_cast<std::size_t>(key - GLFW_KEY_1)]);
  } else if (key == GLFW_KEY_R) {
    document_.reset_camera(aspect());
  } else if (key == GLFW_KEY_P) {
    toggle_projection(camera);
  } else if (key == GLFW_KEY_LEFT_BRACKET || key == GLFW_KEY_RIGHT_BRACKET) {
    camera.roll(key == GLFW_KEY_LEFT_BRACKET ? -kTurn : kTurn);
  } else if (key == GLFW_KEY_S) {
    Wishes wishes;
    wishes.saves_picture = true;
    grant(std::move(wishes));
    return true;
  } else if (key == GLFW_KEY_SPACE && has_time) {
    document_.time.is_playing = !document_.time.is_playing;
    return true;
  } else if ((key == GLFW_KEY_LEFT || key == GLFW_KEY_RIGHT) && has_time && !is_shifted) {
    if (step_time(document_, key == GLFW_KEY_LEFT ? -1 : 1)) go_to_time();
    return true;
  } else if (key == GLFW_KEY_LEFT || key == GLFW_KEY_RIGHT) {
    camera.azimuth(key == GLFW_KEY_LEFT ? kTurn : -kTurn);
  } else if (key == GLFW_KEY_UP || key == GLFW_KEY_DOWN) {
    camera.elevation(key == GLFW_KEY_UP ? kTurn : -kTurn);
  } else {
    return false;
  }
  document_.touch_beside_view();
  return true;
}

}  // namespace ovoid::viewer
