// SPDX-License-Identifier: Apache-2.0
// What can be taken hold of in the picture: the six ends of a crop, clip planes, the value plane,
// slices and the vertices of a solid's control mesh.
#pragma once

#include <imgui.h>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "document.h"
#include "projection.h"
#include "widgets.h"

namespace ovoid::viewer {

// Which handles are wanted.
struct WantedHandles {
  bool of_cuts = true;     // crop, planes and slices
  bool of_solid = true;    // vertices
  int chosen_vertex = -1;  // stands out; -1: none
};

class Handles {
 public:
  // A control mesh of more vertices has no handles: they would hide the solid.
  static constexpr std::size_t kMostVertices = 3000;

  // Draws them, over a picture whose pixel (0, 0) is at `at`, in units; handles are named
  // "handle.crop.x0", "handle.clip.0.offset", "handle.clip.0.normal", "handle.plane.offset",
  // "handle.slice.0.offset", "handle.vertex.0" ...
  void draw(const Document& document, const WantedHandles& wanted, const Projection& projection,
            ImVec2 at, ImDrawList& list, Widgets& widgets);

  // Takes hold of the one under the mouse; false if there is none. Of a clip plane that faces the
  // eye both lie at one place: then of the one that moves it.
  bool press(ImVec2 mouse, const Widgets& widgets);
  // The vertex that is held.
  std::optional<int> held_vertex() const;
  // Why it could not follow the mouse; empty: it did.
  const std::string& refusal() const noexcept { return refusal_; }
  // Moves the one that is held; true if the document changed.
  bool drag(Document& document, const Projection& projection, const Vec2& moved);
  void release() noexcept {
    held_.clear();
    pulled_.reset();
  }
  bool is_held() const noexcept { return !held_.empty(); }

 private:
  struct Handle {
    std::string name;
    ImVec2 place;
    enum class Kind { kCrop, kClipOffset, kClipNormal, kPlaneOffset, kSliceOffset, kVertex } kind;
    int index = 0;
    Vec3 anchor;     // world
    Vec3 direction;  // world, unit length: along it, it moves
    const char* meaning() const;
  };
  void add(Handle handle, const Projection& projection, ImVec2 at);
  // `kind`: of the handle that moves it.
  void add_plane(const std::string& name, const ClipPlane& plane, Handle::Kind kind, int index,
                 const Document& document, const Projection& projection, ImVec2 at,
                 ImDrawList& list);

  void add_cuts(const Document& document, const Projection& projection, ImVec2 at,
                ImDrawList& list);
  void add_vertices(const SolidMesh& control, const Projection& projection, ImVec2 at,
                    ImDrawList& list);
  bool drag_vertex(Document& document, const Handle& handle, const Projection& projection,
                   const Vec2& moved);

  // The one that a press at this place takes; null if none is near.
  const Handle* under(ImVec2 mouse, float scale) const;

  std::vector<Handle> handles_;
  std::string held_;
  // Where the vertex that is held would be: where it cannot be it waits for the mouse to come back.
  std::optional<Vec3> pulled_;
  std::string refusal_;
  // Of the control mesh that was drawn last, by its cells.
  std::vector<std::array<std::uint32_t, 8>> edges_of_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_;
};

// The edges of a box, those before the volume and behind it alike.
void draw_box(const Box& box, const Projection& projection, ImVec2 at, ImDrawList& list,
              ImU32 color);

}  // namespace ovoid::viewer
