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

// Where pictures are shown, in the window's units.
struct Placement {
  Box2 all;           // the pictures; colour bars of two that are compared stand beside them
  Box2 picture;       // the whole of what the camera sees, of two beside each other in the left one
  float beside = 0;   // how far right of it the second one is
  float divider = 0;  // x of the line between two in the same place
};

class PictureView {
 public:
  void take(Pictures pictures);  // to be shown from now on
  void forget();                 // other data: the picture that is shown is of others

  // Draws into the rectangle of the window and lets the mouse act on the document. `density`:
  // pixels per unit. Returns whether a button is held or the wheel has just turned.
  bool draw(Panel& panel, Gui& gui, ImVec2 at, ImVec2 size, float density);

  Placement placement(const Document& document, ImVec2 at, ImVec2 size) const;
  double divider() const noexcept { return divider_; }
  bool holds_vertex() const { return drag_ == Drag::kHandle && handles_.held_vertex(); }

  const Pictures* shown() const noexcept { return shown_ ? &*shown_ : nullptr; }
  // The last full picture, if it is of the document as it is.
  const Picture* full(const Document& document) const;
  const std::optional<Picked>& picked() const noexcept { return picked_; }

 private:
  enum class Drag { kNone, kOrbit, kPan, kRoll, kZoom, kHandle, kDivider };

  void show_pictures(const Document& document, Gui& gui, const Placement& place) const;
  void draw_divider(Panel& panel, ImDrawList& list, const Placement& place) const;
  bool act(Panel& panel, const Placement& place);
  void begin_drag(Panel& panel, ImVec2 mouse, const Placement& place);
  bool continue_drag(Document& document, const Vec2& mouse, const Vec2& moved, const Vec2& size);
  void pick(const Document& document, const Placement& place);
  Picked picked_in(const Picture& picture, int x, int y, const FieldProbe* probe);

  // What was picked last: while the mouse rests nothing is searched for again.
  struct PickKey {
    std::uint64_t number = 0;
    int x = -1, y = -1;
    const Picture* picture = nullptr;
    const FieldProbe* probe = nullptr;
    bool operator==(const PickKey&) const = default;
  };

  std::optional<Pictures> shown_;
  Texture textures_[2];
  Texture difference_;
  Marks marks_;
  Handles handles_;
  Drag drag_ = Drag::kNone;
  double divider_ = 0.5;  // where the line between two pictures is, of their width
  double dragged_ = 0;    // how far, with the last button that was pressed
  std::optional<Picked> picked_;
  PickKey pick_key_;
  Picked last_picked_;
  double wheel_until_ = 0;  // ImGui::GetTime() up to which a turn of the wheel counts as moving
};

// "full", "moving: every second pixel, 1/8 of the kernels": how fine a picture is.
std::string describe(const Level& level, bool is_final);

}  // namespace ovoid::viewer
