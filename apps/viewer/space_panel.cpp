// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "hands.h"
#include "ovoid/crop.h"
#include "panels.h"

namespace ovoid::viewer {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One end of the crop along an axis; at the data's own end nothing is cut.
bool crop_end(Panel& panel, const std::string& name, const char* label, int axis, bool is_upper) {
  Document& document = panel.document;
  const Bounds3 all = document.data_bounds();
  Bounds3& crop = *document.view.crop;
  double& end = is_upper ? crop.max()[axis] : crop.min()[axis];
  const double lo = all.min()[axis];
  const double hi = all.max()[axis];
  double shown = std::clamp(end, lo, hi);
  if (!panel.widgets.slider(name, label, &shown, lo, hi)) return false;
  const double least = (hi - lo) * 1e-3;  // is left in any case
  if (is_upper) {
    shown = std::max(shown, std::max(crop.min()[axis], lo) + least);
    end = shown >= hi ? kInfinity : shown;
  } else {
    shown = std::min(shown, std::min(crop.max()[axis], hi) - least);
    end = shown <= lo ? -kInfinity : shown;
  }
  return true;
}

bool crop_editor(Panel& panel) {
  View& view = panel.document.view;
  bool is_on = view.crop.has_value();
  bool is_changed = false;
  if (panel.widgets.checkbox("space.crop", "crop", &is_on)) {
    view.crop.reset();
    if (is_on) view.crop = Bounds3(Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity));
    is_changed = true;
  }
  panel.widgets.tip("Six planes parallel to the axes; drag their handles in the picture.");
  if (!view.crop) return is_changed;
  static constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const char* const letter = kAxes[static_cast<std::size_t>(axis)];
    is_changed |= crop_end(panel, fmt::format("space.crop.{}0", letter),
                           fmt::format("{} from", letter).c_str(), axis, false);
    is_changed |= crop_end(panel, fmt::format("space.crop.{}1", letter), "to", axis, true);
  }
  return is_changed;
}

// Two clip planes that leave what lies between them (--thick-slice): none if these do not.
struct ThickSlice {
  ClipPlane middle;
  double thickness = 0;
};
std::optional<ThickSlice> thick_slice_of(const std::vector<ClipPlane>& planes, std::size_t first) {
  if (first + 1 >= planes.size()) return std::nullopt;
  const ClipPlane& a = planes[first];
  const ClipPlane& b = planes[first + 1];
  const double between = -b.offset - a.offset;
  if (a.normal != -b.normal || !(between > 0)) return std::nullopt;
  return ThickSlice{{a.normal, (a.offset - b.offset) / 2}, between / a.normal.norm()};
}

bool thick_slice_editor(Panel& panel, const std::string& name, ThickSlice slice,
                        std::vector<ClipPlane>& planes, std::size_t first) {
  const Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  bool is_changed = false;
  Vec3 normal = slice.middle.normal;
  if (widgets.vector(name + ".normal", "normal", &normal, 0.01) && normal.norm() > 1e-6) {
    slice.middle.normal = normal;
    is_changed = true;
  }
  const double length = slice.middle.normal.norm();
  const Bounds3 all = document.data_bounds();
  const double middle = slice.middle.normal.dot(all.center());
  const double reach = (all.sizes() / 2).dot(slice.middle.normal.cwiseAbs());
  is_changed |= widgets.slider(name + ".offset", "place", &slice.middle.offset, middle - reach,
                               middle + reach);
  is_changed |= widgets.slider(name + ".thickness", "thickness", &slice.thickness,
                               document.extent() * 1e-3, 2 * reach / length);
  if (is_changed) {
    const std::array<ClipPlane, 2> ends = slice_planes(slice.middle, slice.thickness);
    std::copy(ends.begin(), ends.end(), planes.begin() + static_cast<std::ptrdiff_t>(first));
  }
  return is_changed;
}

bool clip_editor(Panel& panel) {
  Document& document = panel.document;
  std::vector<ClipPlane>& planes = document.view.clip_planes;
  Widgets& widgets = panel.widgets;
  bool is_changed = false;
  constexpr std::size_t kCropPlanes = 6;
  constexpr std::size_t kMost = RenderOptions::kMaxClipPlanes - kCropPlanes - 1;
  const bool has_room = planes.size() < kMost;
  const bool has_room_for_two = planes.size() + 1 < kMost;
  if (widgets.button("space.add-clip", "add a clip plane", has_room)) {
    // Across the middle, facing the eye, so that something is seen to happen.
    const Vec3 away = (document.camera.focal_point - document.camera.position).normalized();
    planes.push_back({away, away.dot(document.bounds().center())});
    is_changed = true;
  }
  ImGui::SameLine();
  if (widgets.button("space.add-slab", "add a thick slice", has_room_for_two)) {
    const Vec3 away = (document.camera.focal_point - document.camera.position).normalized();
    for (const ClipPlane& plane :
         slice_planes({away, away.dot(document.bounds().center())}, document.extent() / 10))
      planes.push_back(plane);
    is_changed = true;
  }
  widgets.tip(
      "What lies between two parallel planes: in the modes maximum, minimum, mean and x-ray its "
      "values alone count.");
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (const std::optional<ThickSlice> slice = thick_slice_of(planes, i)) {
      const std::string name = fmt::format("space.slab.{}", i);
      is_changed |= thick_slice_editor(panel, name, *slice, planes, i);
      if (widgets.button(name + ".remove", "remove")) {
        const auto first = planes.begin() + static_cast<std::ptrdiff_t>(i);
        planes.erase(first, first + 2);
        return true;
      }
      ++i;
      continue;
    }
    ClipPlane& plane = planes[i];
    const std::string name = fmt::format("space.clip.{}", i);
    Vec3 normal = plane.normal;
    if (widgets.vector(name + ".normal", "normal", &normal, 0.01) && normal.norm() > 1e-6) {
      plane.normal = normal;
      is_changed = true;
    }
    is_changed |= widgets.number(name + ".offset", "offset", &plane.offset,
                                 {.speed = document.extent() * plane.normal.norm() / 400});
    if (widgets.button(name + ".flip", "flip")) {
      plane.normal = -plane.normal;
      plane.offset = -plane.offset;
      is_changed = true;
    }
    ImGui::SameLine();
    if (widgets.button(name + ".remove", "remove")) {
      planes.erase(planes.begin() + static_cast<std::ptrdiff_t>(i));
      return true;
    }
  }
  return is_changed;
}

bool plane_editor(Panel& panel) {
  Document& document = panel.document;
  View& view = document.view;
  Widgets& widgets = panel.widgets;
  bool is_on = view.plane.has_value();
  bool is_changed = false;
  if (widgets.checkbox("space.plane", "value plane", &is_on)) {
    view.plane.reset();
    if (is_on) {
      // The axis that is looked along most, so that its face is seen.
      int across = 0;
      (document.camera.focal_point - document.camera.position).cwiseAbs().maxCoeff(&across);
      const Vec3 normal = Vec3::Unit(across);
      view.plane = ValuePlane{normal, normal.dot(document.bounds().center())};
    }
    is_changed = true;
  }
  widgets.tip(
      "An opaque plane that shows the field itself, without opacity or light. For the modes "
      "composite and isosurface.");
  if (!view.plane) return is_changed;
  if (view.look.mode != Mode::kComposite && view.look.mode != Mode::kIsosurface)
    ImGui::TextWrapped("Not shown in this mode: it takes composite or isosurface.");
  ValuePlane& plane = *view.plane;
  int across = -1;
  for (int axis = 0; axis < 3; ++axis) {
    if (plane.normal.normalized() == Vec3::Unit(axis)) across = axis;
  }
  if (across < 0) across = 3;
  if (widgets.choice("space.plane.across", "across", {"x", "y", "z", "free"}, &across)) {
    const Vec3 normal = across < 3 ? Vec3(Vec3::Unit(across)) : Vec3(1, 1, 1);
    plane.normal = normal;
    plane.offset = normal.dot(document.bounds().center());
    is_changed = true;
  }
  if (across == 3) {
    Vec3 normal = plane.normal;
    if (widgets.vector("space.plane.normal", "normal", &normal, 0.01) && normal.norm() > 1e-6) {
      plane.normal = normal;
      is_changed = true;
    }
  }
  const Bounds3 all = document.data_bounds();
  const double middle = plane.normal.dot(all.center());
  const double reach = (all.sizes() / 2).dot(plane.normal.cwiseAbs());
  is_changed |=
      widgets.slider("space.plane.offset", "offset", &plane.offset, middle - reach, middle + reach);
  bool is_shown = plane.front == PlaneFront::kShown;
  if (widgets.checkbox("space.plane.front", "show what is in front of it", &is_shown)) {
    plane.front = is_shown ? PlaneFront::kShown : PlaneFront::kRemoved;
    is_changed = true;
  }
  return is_changed;
}

void view_buttons(Panel& panel) {
  static constexpr std::array<const char*, 6> kViews = {"+x", "-x", "+y", "-y", "+z", "-z"};
  Document& document = panel.document;
  const double aspect =
      static_cast<double>(panel.status.picture.width) / std::max(panel.status.picture.height, 1);
  for (const char* const view : kViews) {
    if (panel.widgets.button(fmt::format("space.view.{}", view), view)) {
      document.reset_camera(aspect, view);
      document.touch_beside_view();
    }
    ImGui::SameLine();
  }
  if (panel.widgets.button("space.reset", "reset")) {
    document.reset_camera(aspect);
    document.touch_beside_view();
  }
}

}  // namespace

void space_panel(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  view_buttons(panel);
  bool is_parallel = document.camera.parallel_projection;
  if (widgets.checkbox("space.parallel", "parallel projection", &is_parallel)) {
    toggle_projection(document.camera);
    document.touch_beside_view();
  }
  if (!is_parallel && widgets.slider("space.view-angle", "view angle", &document.camera.view_angle,
                                     5, 120, "%.3g degrees"))
    document.touch_beside_view();
  ImGui::Separator();
  bool is_changed = crop_editor(panel);
  ImGui::Separator();
  is_changed |= clip_editor(panel);
  ImGui::Separator();
  is_changed |= plane_editor(panel);
  ImGui::Separator();
  widgets.checkbox("space.handles", "handles in the picture", &panel.state.has_handles);
  cli::AnnotationFlags& marks = document.view.marks;
  is_changed |= widgets.checkbox("space.axes", "axes", &marks.axes);
  ImGui::SameLine();
  is_changed |= widgets.checkbox("space.colorbar", "colour bar", &marks.color_bar);
  is_changed |= widgets.checkbox("space.box", "bounding box", &marks.bounding_box);
  ImGui::SameLine();
  is_changed |= widgets.checkbox("space.scale-bar", "scale bar", &marks.scale_bar);
  is_changed |= widgets.color("space.background", "background", &document.view.background);
  if (is_changed) document.touch();
}

}  // namespace ovoid::viewer
