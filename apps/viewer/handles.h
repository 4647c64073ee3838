// SPDX-License-Identifier: Apache-2.0
// What can be taken hold of in the picture: the six ends of a crop, clip planes and the value
// plane.
#pragma once

#include <imgui.h>

#include <string>

#include "document.h"
#include "projection.h"
#include "widgets.h"

namespace ovoid::viewer {

class Handles {
 public:
  // Draws them, over a picture whose pixel (0, 0) is at `at`, in units; handles are named
  // "handle.crop.x0", "handle.clip.0.offset", "handle.clip.0.normal", "handle.plane.offset" ...
  void draw(const Document& document, const Projection& projection, ImVec2 at, ImDrawList& list,
            Widgets& widgets);

  // Takes hold of the one under the mouse; false if there is none. Of a clip plane that faces the
  // eye both lie at one place: then of the one that moves it.
  bool press(ImVec2 mouse, const Widgets& widgets);
  // Moves the one that is held; true if the document changed.
  bool drag(Document& document, const Projection& projection, const Vec2& moved);
  void release() noexcept { held_.clear(); }
  bool is_held() const noexcept { return !held_.empty(); }

 private:
  struct Handle {
    std::string name;
    ImVec2 place;
    enum class Kind { kCrop, kClipOffset, kClipNormal, kPlaneOffset } kind;
    int index = 0;
    Vec3 anchor;     // world
    Vec3 direction;  // world, unit length: along it, it moves
    const char* meaning() const;
  };
  void add(Handle handle, const Projection& projection, ImVec2 at);
  void add_plane(const std::string& name, const Vec3& normal, double offset, bool has_normal,
                 int index, const Document& document, const Projection& projection, ImVec2 at,
                 ImDrawList& list);

  // The one that a press at this place takes; null if none is near.
  const Handle* under(ImVec2 mouse, float scale) const;

  std::vector<Handle> handles_;
  std::string held_;
};

// The edges of a box, those before the volume and behind it alike.
void draw_box(const Box& box, const Projection& projection, ImVec2 at, ImDrawList& list,
              ImU32 color);

}  // namespace ovoid::viewer
