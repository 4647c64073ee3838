// SPDX-License-Identifier: Apache-2.0
#include "handles.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace ovoid::viewer {
namespace {

constexpr ImU32 kEdge = IM_COL32(255, 170, 40, 140);
constexpr ImU32 kEdgeShade = IM_COL32(0, 0, 0, 60);
constexpr ImU32 kSolidEdge = IM_COL32(255, 170, 40, 70);  // faint, as there are many
constexpr ImU32 kFill = IM_COL32(255, 170, 40, 255);
// As the axes' own (red, green, blue).
constexpr std::array<ImU32, 3> kAxisColors = {
    IM_COL32(237, 77, 71, 255), IM_COL32(84, 184, 71, 255), IM_COL32(90, 130, 255, 255)};
constexpr ImU32 kFillHeld = IM_COL32(255, 230, 160, 255);
constexpr ImU32 kHandleInk = IM_COL32(0, 0, 0, 200);
constexpr float kRadius = 5;
constexpr float kHandleReach = 10;  // of a handle
// A handle that turns a plane counts as this much farther away: less than a hand aims by.
constexpr float kTie = 4;
constexpr double kSquare = 0.3;  // half a side of a plane's square, in extents of the data
constexpr double kArrow = 0.12;  // of its arrow

ImVec2 to_window(const Vec2& pixel, ImVec2 at) {
  return {at.x + static_cast<float>(pixel.x()), at.y + static_cast<float>(pixel.y())};
}

// The nearest point of the plane to the middle of what is seen of the data.
Vec3 foot(const Vec3& normal, double offset, const Vec3& from) {
  return from + normal * ((offset - normal.dot(from)) / normal.squaredNorm());
}

// With a dark edge, which makes it stand out from bright pictures.
void draw_line(const Vec3& a, const Vec3& b, const Projection& projection, ImVec2 at,
               ImDrawList& list, ImU32 color) {
  const auto from = projection.pixel_of(a);
  const auto to = projection.pixel_of(b);
  if (!from || !to) return;
  list.AddLine(to_window(*from, at), to_window(*to, at), kEdgeShade, 3);
  list.AddLine(to_window(*from, at), to_window(*to, at), color, 1.5F);
}

// By how much the mouse moved it along its direction, world units. Where that points at the eye,
// its picture is too short to follow: upwards then goes away from the eye.
double moved_along(const Vec3& anchor, const Vec3& direction, double length,
                   const Projection& projection, const Vec2& moved) {
  const auto a = projection.pixel_of(anchor);
  const auto b = projection.pixel_of(anchor + direction * length);
  if (!a || !b) return 0;
  const Vec2 picture = (*b - *a) / length;  // pixels per world unit
  const double pixel_size = projection.pixel_size_at(projection.focal_depth());
  if (picture.norm() * pixel_size < 0.125)
    return std::copysign(pixel_size, direction.dot(projection.forward())) * -moved.y();
  return moved.dot(picture) / picture.squaredNorm();
}

// Each edge of the cells once.
std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_of(const SolidMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& cell : mesh.cells) {
    for (std::size_t corner = 0; corner < cell.size(); ++corner) {
      for (const std::size_t step : {1U, 2U, 4U}) {
        if ((corner & step) == 0) edges.push_back(std::minmax({cell[corner], cell[corner | step]}));
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace

void draw_box(const Box& box, const Projection& projection, ImVec2 at, ImDrawList& list,
              ImU32 color) {
  const auto corner = [&](int number) {
    const Vec3& lo = box.bounds.min();
    const Vec3& hi = box.bounds.max();
    return Vec3(box.world_from_box * Vec3((number & 1) != 0 ? hi.x() : lo.x(),
                                          (number & 2) != 0 ? hi.y() : lo.y(),
                                          (number & 4) != 0 ? hi.z() : lo.z()));
  };
  for (int a = 0; a < 8; ++a) {
    for (const int bit : {1, 2, 4}) {
      if ((a & bit) == 0) draw_line(corner(a), corner(a | bit), projection, at, list, color);
    }
  }
}

const char* Handles::Handle::meaning() const {
  static constexpr std::array<const char*, 6> kEnds = {"x from", "x to",   "y from",
                                                       "y to",   "z from", "z to"};
  switch (kind) {
    case Kind::kCrop:
      return kEnds[static_cast<std::size_t>(index)];
    case Kind::kClipOffset:
      return "move the clip plane";
    case Kind::kClipNormal:
      return "turn the clip plane";
    case Kind::kPlaneOffset:
      return "move the value plane";
    case Kind::kSliceOffset:
      return "move the slice";
    case Kind::kVertex:
      break;
  }
  return "move the vertex";
}

void Handles::add(Handle handle, const Projection& projection, ImVec2 at) {
  const auto pixel = projection.pixel_of(handle.anchor);
  if (!pixel) return;
  handle.place = to_window(*pixel, at);
  handles_.push_back(std::move(handle));
}

void Handles::add_plane(const std::string& name, const ClipPlane& plane, Handle::Kind kind,
                        int index, const Document& document, const Projection& projection,
                        ImVec2 at, ImDrawList& list) {
  const Vec3 unit = plane.normal.normalized();
  const Vec3 center = foot(plane.normal, plane.offset, document.bounds().center());
  const double extent = document.extent();
  const Vec3 u = unit.unitOrthogonal() * extent * kSquare;
  const Vec3 v = unit.cross(u);
  const std::array<Vec3, 4> corners = {center - u - v, center + u - v, center + u + v,
                                       center - u + v};
  for (std::size_t i = 0; i < 4; ++i)
    draw_line(corners[i], corners[(i + 1) % 4], projection, at, list, kEdge);
  const Vec3 tip = center + unit * extent * kArrow;
  draw_line(center, tip, projection, at, list, kEdge);
  add({name + ".offset", {}, kind, index, center, unit}, projection, at);
  if (kind == Handle::Kind::kClipOffset)
    add({name + ".normal", {}, Handle::Kind::kClipNormal, index, tip, unit}, projection, at);
}

void Handles::add_cuts(const Document& document, const Projection& projection, ImVec2 at,
                       ImDrawList& list) {
  const View& view = document.view;
  if (view.crop) {
    const Bounds3 left = document.bounds();
    draw_box({Affine3::Identity(), left}, projection, at, list, kEdge);
    static constexpr std::array<char, 3> kAxes = {'x', 'y', 'z'};
    for (int end = 0; end < 6; ++end) {
      const int axis = end / 2;
      Vec3 anchor = left.center();
      anchor[axis] = end % 2 == 0 ? left.min()[axis] : left.max()[axis];
      add({fmt::format("handle.crop.{}{}", kAxes[static_cast<std::size_t>(axis)], end % 2),
           {},
           Handle::Kind::kCrop,
           end,
           anchor,
           Vec3::Unit(axis)},
          projection, at);
    }
  }
  for (std::size_t i = 0; i < view.clip_planes.size(); ++i) {
    add_plane(fmt::format("handle.clip.{}", i), view.clip_planes[i], Handle::Kind::kClipOffset,
              static_cast<int>(i), document, projection, at, list);
  }
  const bool is_layered = view.look.mode == Mode::kComposite || view.look.mode == Mode::kIsosurface;
  if (view.plane && is_layered) {
    add_plane("handle.plane", {view.plane->normal, view.plane->offset}, Handle::Kind::kPlaneOffset,
              0, document, projection, at, list);
  }
  if (!document.shows_scenery(view)) return;
  for (std::size_t i = 0; i < view.slices.slices.size(); ++i) {
    const cli::SlicePlane& slice = view.slices.slices[i];
    add_plane(fmt::format("handle.slice.{}", i), {slice.normal, document.offset_of(slice)},
              Handle::Kind::kSliceOffset, static_cast<int>(i), document, projection, at, list);
  }
}

void Handles::add_vertices(const SolidMesh& control, const Projection& projection, ImVec2 at,
                           ImDrawList& list) {
  if (control.num_vertices() > kMostVertices) return;
  if (edges_of_ != control.cells) {
    edges_of_ = control.cells;
    edges_ = edges_of(control);
  }
  for (const auto& [a, b] : edges_) {
    const auto from = projection.pixel_of(control.position(a));
    const auto to = projection.pixel_of(control.position(b));
    if (from && to) list.AddLine(to_window(*from, at), to_window(*to, at), kSolidEdge);
  }
  for (std::size_t vertex = 0; vertex < control.num_vertices(); ++vertex) {
    add({fmt::format("handle.vertex.{}", vertex),
         {},
         Handle::Kind::kVertex,
         static_cast<int>(vertex),
         control.position(vertex),
         Vec3::Zero()},
        projection, at);
  }
}

void Handles::draw(const Document& document, const WantedHandles& wanted,
                   const Projection& projection, ImVec2 at, ImDrawList& list, Widgets& widgets) {
  handles_.clear();
  const std::optional<SolidShape>& solid = document.view.solid;
  if (wanted.of_solid && solid) add_vertices(*solid->control, projection, at, list);
  if (wanted.of_cuts) add_cuts(document, projection, at, list);
  const float radius = kRadius * widgets.scale();
  const Handle* const next = under(ImGui::GetIO().MousePos, widgets.scale());
  for (const Handle& handle : handles_) {
    const bool is_near = held_.empty() ? &handle == next : handle.name == held_;
    const bool is_vertex = handle.kind == Handle::Kind::kVertex;
    const bool is_chosen = is_vertex && handle.index == wanted.chosen_vertex;
    ImU32 color = is_chosen ? kFillHeld : kFill;
    if (handle.kind == Handle::Kind::kCrop)
      color = kAxisColors[static_cast<std::size_t>(handle.index / 2)];
    // Vertices are many.
    const float usual = is_vertex && !is_chosen ? 0.6F * radius : radius;
    list.AddCircleFilled(handle.place, is_near ? 1.5F * usual : usual, color);
    list.AddCircle(handle.place, is_near ? 1.5F * usual : usual, is_near ? kFillHeld : kHandleInk);
    if (is_near) {
      const std::string meaning =
          is_vertex ? fmt::format("vertex {}", handle.index) : handle.meaning();
      widgets.label(list, {handle.place.x + 3 * radius, handle.place.y - 3 * radius},
                    widgets.colors().ink, meaning);
    }
    widgets.mark(handle.name,
                 {handle.place.x - 1, handle.place.y - 1, handle.place.x + 1, handle.place.y + 1});
  }
}

const Handles::Handle* Handles::under(ImVec2 mouse, float scale) const {
  const Handle* nearest = nullptr;
  float least = HUGE_VALF;
  for (const Handle& handle : handles_) {
    const float distance = std::hypot(handle.place.x - mouse.x, handle.place.y - mouse.y);
    if (distance > kHandleReach * scale) continue;
    const float counted =
        handle.kind == Handle::Kind::kClipNormal ? distance + kTie * scale : distance;
    if (counted > least) continue;
    least = counted;
    nearest = &handle;
  }
  return nearest;
}

std::optional<int> Handles::held_vertex() const {
  for (const Handle& handle : handles_) {
    if (handle.name == held_ && handle.kind == Handle::Kind::kVertex) return handle.index;
  }
  return std::nullopt;
}

// In the plane through the vertex that is parallel to the picture.
bool Handles::drag_vertex(Document& document, const Handle& handle, const Projection& projection,
                          const Vec2& moved) {
  const auto vertex = static_cast<std::size_t>(handle.index);
  if (!document.view.solid || vertex >= document.view.solid->control->num_vertices()) return false;
  if (!pulled_) pulled_ = handle.anchor;
  const double size = projection.pixel_size_at(projection.depth_of(*pulled_));
  *pulled_ += (projection.right() * moved.x() - projection.up() * moved.y()) * size;
  refusal_ = document.set_vertex(vertex, *pulled_, document.view.solid->control->densities[vertex]);
  return refusal_.empty();
}

bool Handles::press(ImVec2 mouse, const Widgets& widgets) {
  const Handle* const next = under(mouse, widgets.scale());
  held_ = next != nullptr ? next->name : std::string();
  pulled_.reset();
  refusal_.clear();
  return is_held();
}

bool Handles::drag(Document& document, const Projection& projection, const Vec2& moved) {
  const auto held = std::find_if(handles_.begin(), handles_.end(),
                                 [&](const Handle& handle) { return handle.name == held_; });
  if (held == handles_.end() || moved.norm() == 0) return false;
  if (held->kind == Handle::Kind::kVertex) return drag_vertex(document, *held, projection, moved);
  const double extent = document.extent();
  const double along = moved_along(held->anchor, held->direction, extent * 0.01, projection, moved);
  View& view = document.view;
  const auto index = static_cast<std::size_t>(held->index);
  if (held->kind == Handle::Kind::kCrop && view.crop) {
    const int axis = held->index / 2;
    const Bounds3 all = document.data_bounds();
    const Bounds3 left = document.bounds();
    const double least = all.sizes()[axis] * 1e-3;  // is left in any case
    if (held->index % 2 == 0) {
      const double end = std::min(left.min()[axis] + along, left.max()[axis] - least);
      view.crop->min()[axis] = end <= all.min()[axis] ? -HUGE_VAL : end;
    } else {
      const double end = std::max(left.max()[axis] + along, left.min()[axis] + least);
      view.crop->max()[axis] = end >= all.max()[axis] ? HUGE_VAL : end;
    }
  } else if (held->kind == Handle::Kind::kClipOffset && index < view.clip_planes.size()) {
    ClipPlane& plane = view.clip_planes[index];
    plane.offset += along * plane.normal.norm();
  } else if (held->kind == Handle::Kind::kClipNormal && index < view.clip_planes.size()) {
    // The arrow's tip follows the mouse, the plane turns about its middle.
    ClipPlane& plane = view.clip_planes[index];
    const Vec3 center = foot(plane.normal, plane.offset, document.bounds().center());
    const double size = projection.pixel_size_at(projection.depth_of(held->anchor));
    const Vec3 tip =
        held->anchor + (projection.right() * moved.x() - projection.up() * moved.y()) * size;
    if ((tip - center).norm() < extent * 1e-3) return false;
    plane.normal = (tip - center).normalized();
    plane.offset = plane.normal.dot(center);
  } else if (held->kind == Handle::Kind::kPlaneOffset && view.plane) {
    view.plane->offset += along * view.plane->normal.norm();
  } else if (held->kind == Handle::Kind::kSliceOffset && index < view.slices.slices.size()) {
    cli::SlicePlane& slice = view.slices.slices[index];
    slice.offset = document.offset_of(slice) + along * slice.normal.norm();
  } else {
    return false;
  }
  return true;
}

}  // namespace ovoid::viewer
