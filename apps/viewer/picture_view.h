// SPDX-License-Identifier: Apache-2.0
// The picture in the window, what lies over it, and the mouse in it.
#pragma once

#include <imgui.h>

#include <optional>
#include <string>

#include "document.h"
#include "gui.h"
#include "handles.h"
#include "marks.h"
#include "panels.h"

namespace ovoid::viewer {

// What lies under the mouse.
struct Picked {
  Vec3 position;  // world
  double value = 0;
  bool is_defined = false;  // the field, there
};

class PictureView {
 public:
  void take(Pictures pictures);  // to be shown from now on
  void forget();                 // other data: the picture that is shown is of others

  // Draws into the rectangle of the window and lets the mouse act on the document. `density`:
  // pixels per unit. Returns whether a button is held or the wheel has just turned.
  bool draw(Panel& panel, Gui& gui, ImVec2 at, ImVec2 size, float density);

  const Pictures* shown() const noexcept { return shown_ ? &*shown_ : nullptr; }
  // The last full picture, if it is of the document as it is.
  const Picture* full(std::uint64_t number) const noexcept;
  const std::optional<Picked>& picked() const noexcept { return picked_; }

 private:
  enum class Drag { kNone, kOrbit, kPan, kRoll, kZoom, kHandle };

  void show_pictures(const Document& document, Gui& gui, ImDrawList& list, ImVec2 at,
                     ImVec2 size) const;
  bool act(Panel& panel, ImVec2 at, ImVec2 size);
  void begin_drag(const Panel& panel, ImVec2 mouse, float reach);
  bool continue_drag(Document& document, const Vec2& mouse, const Vec2& moved, const Vec2& size);
  void pick(const Document& document, ImVec2 at, ImVec2 size);

  std::optional<Pictures> shown_;
  Texture textures_[2];
  Texture difference_;
  Marks marks_;
  Handles handles_;
  Drag drag_ = Drag::kNone;
  double dragged_ = 0;  // how far, with the last button that was pressed
  std::optional<Picked> picked_;
  double wheel_until_ = 0;  // ImGui::GetTime() up to which a turn of the wheel counts as moving
};

// "full", "moving: every second pixel, 1/8 of the kernels": how fine a picture is.
std::string describe(const Level& level, bool is_final);

}  // namespace ovoid::viewer
