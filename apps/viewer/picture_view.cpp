// SPDX-License-Identifier: Apache-2.0
#include "picture_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "hands.h"
#include "ovoid/annotate.h"
#include "ovoid/pick.h"

namespace ovoid::viewer {
namespace {

constexpr double kWheelZoom = 1.12;     // per notch
constexpr double kDragZoom = 1.008;     // per pixel
constexpr double kWheelSettles = 0.18;  // seconds after its last notch
constexpr double kMostOfAClick = 4;     // how far the mouse may go
constexpr float kDividerReach = 6;      // of the line between two pictures
constexpr ImU32 kDividerInk = IM_COL32(235, 238, 242, 230);
constexpr ImU32 kDividerShade = IM_COL32(10, 11, 13, 170);

// Of the bounding box, as faint as it may be: as marks are on this background.
ImU32 box_color(const Rgb& background) {
  const Rgb ink = mark_style_on(background).ink;
  return ImGui::ColorConvertFloat4ToU32(
      {static_cast<float>(ink[0]), static_cast<float>(ink[1]), static_cast<float>(ink[2]), 0.45F});
}

Vec2 vec(ImVec2 v) { return {v.x, v.y}; }

constexpr float kMostOfBar = 0.25F;  // of the width, for a colour bar beside pictures
constexpr double kMostOfDivider = 0.98;

ImVec2 corner(const Box2& box) { return {box.x0, box.y0}; }

Vec2 extent(const Box2& box) { return {box.x1 - box.x0, box.y1 - box.y0}; }

bool is_split(const Document& document) {
  return document.compares() && document.compare == CompareMode::kSideBySide;
}

bool is_divided(const Document& document) {
  return document.compares() && document.compare == CompareMode::kDivided;
}

}  // namespace

std::string describe(const Level& level, bool is_final) {
  if (level.is_full()) return is_final ? "full picture" : "moving: full pixels";
  std::string text = "coarse: ";
  if (level.pixels > 1) text += fmt::format("pixels {0} x {0}", level.pixels);
  if (level.pixels > 1 && level.field > 0) text += ", ";
  if (level.field > 0) text += fmt::format("1/{} of the kernels", 1 << (3 * level.field));
  return text;
}

void PictureView::take(Pictures pictures) {
  for (std::size_t i = 0; i < pictures.pictures.size() && i < 2; ++i) {
    const Picture& picture = pictures.pictures[i];
    textures_[i].upload_opaque(picture.bgra.data(), picture.image.width, picture.image.height);
  }
  if (!pictures.difference.empty()) {
    const Image& image = pictures.pictures.front().image;
    difference_.upload_opaque(pictures.difference.data(), image.width, image.height);
  }
  shown_ = std::move(pictures);
}

void PictureView::forget() {
  shown_.reset();
  picked_.reset();
}

const Picture* PictureView::full(const Document& document) const {
  if (!shown_ || shown_->number != document.version() || !shown_->level.is_full() ||
      !shown_->is_final || shown_->pictures.empty())
    return nullptr;
  const Picture& own = shown_->pictures[shown_->own];
  return own.job->shown->is_of(document.view.solid) ? &own : nullptr;
}

Placement PictureView::placement(const Document& document, ImVec2 at, ImVec2 size) const {
  Placement place;
  place.all = {at.x, at.y, at.x + size.x, at.y + size.y};
  if (document.compares()) {
    place.all.x0 += std::min(static_cast<float>(marks_.width_at_left()), kMostOfBar * size.x);
    place.all.x1 -= std::min(static_cast<float>(marks_.width_at_right()), kMostOfBar * size.x);
  }
  place.picture = place.all;
  const float width = place.all.x1 - place.all.x0;
  place.divider = place.all.x0 + static_cast<float>(divider_) * width;
  if (is_split(document)) {
    place.beside = width / 2;
    place.picture.x1 -= place.beside;
    const float beyond = size.y * (1 - place.beside / size.x) / 2;  // above and below the view
    place.picture.y0 += beyond;
    place.picture.y1 -= beyond;
  }
  return place;
}

void PictureView::show_pictures(const Document& document, Gui& gui, const Placement& place) const {
  if (!shown_ || shown_->pictures.empty()) return;
  const Box2& all = place.all;
  if (shown_->pictures.size() == 1) return gui.show_behind(textures_[0], all);
  if (document.compare == CompareMode::kDifference && !shown_->difference.empty())
    return gui.show_behind(difference_, all);
  if (is_split(document)) {
    const float middle = all.x0 + place.beside;
    gui.show_behind(textures_[0], {all.x0, all.y0, middle, all.y1});
    gui.show_behind(textures_[1], {middle, all.y0, all.x1, all.y1});
  } else {
    gui.show_behind(textures_[0], all);
    gui.show_behind(textures_[1], all, place.divider);
  }
}

// The line between two pictures, and which is which.
void PictureView::draw_divider(Panel& panel, ImDrawList& list, const Placement& place) const {
  if (!is_split(panel.document) && !is_divided(panel.document)) return;
  const float scale = panel.widgets.scale();
  const float x = is_split(panel.document) ? place.all.x0 + place.beside : place.divider;
  list.AddLine({x, place.all.y0}, {x, place.all.y1}, kDividerShade, 3);
  list.AddLine({x, place.all.y0}, {x, place.all.y1}, kDividerInk);
  if (is_divided(panel.document)) {
    const float middle = (place.all.y0 + place.all.y1) / 2;
    const float half = 4 * scale;
    const ImVec2 lo(x - half, middle - 4 * half);
    const ImVec2 hi(x + half, middle + 4 * half);
    list.AddRectFilled(lo, hi, kDividerInk, half);
    list.AddRect(lo, hi, kDividerShade, half);
    panel.widgets.mark("compare.divider", {x - half, middle - half, x + half, middle + half});
  }
  // Below the notes in the corner, wherever the line is.
  const float y = place.all.y0 + 34 * scale;
  const float gap = 10 * scale;
  const ImU32 ink = panel.widgets.colors().ink;
  const bool has_fit = panel.document.compares_fit();
  const char* const left = has_fit ? "data" : "A";
  panel.widgets.label(list, {x - gap - ImGui::CalcTextSize(left).x, y}, ink, left);
  panel.widgets.label(list, {x + gap, y}, ink, has_fit ? "fit" : "B");
}

void PictureView::begin_drag(Panel& panel, ImVec2 mouse, const Placement& place) {
  const ImGuiIO& io = ImGui::GetIO();
  const bool is_left = ImGui::IsMouseDown(ImGuiMouseButton_Left);
  const bool has_handles = !panel.document.compares();
  if (is_left && is_divided(panel.document) &&
      std::abs(mouse.x - place.divider) < kDividerReach * panel.widgets.scale()) {
    drag_ = Drag::kDivider;
  } else if (is_left && has_handles && handles_.press(mouse, panel.widgets)) {
    drag_ = Drag::kHandle;
    panel.state.vertex = handles_.held_vertex().value_or(panel.state.vertex);
  } else if (ImGui::IsMouseDown(ImGuiMouseButton_Right)) {
    drag_ = Drag::kZoom;
  } else if (!is_left || io.KeyShift) {
    drag_ = Drag::kPan;
  } else {
    drag_ = io.KeyCtrl ? Drag::kRoll : Drag::kOrbit;
  }
}

bool PictureView::continue_drag(Document& document, const Vec2& mouse, const Vec2& moved,
                                const Vec2& size) {
  if (moved.norm() == 0) return false;
  Camera& camera = document.camera;
  switch (drag_) {
    case Drag::kOrbit:
      orbit(camera, moved, size.y());
      return true;
    case Drag::kPan:
      pan(camera, moved, size.y());
      return true;
    case Drag::kRoll:
      roll_with(camera, mouse - moved, mouse, size / 2);
      return true;
    case Drag::kZoom:
      zoom_to(camera, std::pow(kDragZoom, -moved.y()), size / 2, size, document.extent());
      return true;
    case Drag::kHandle:
      return handles_.drag(document, Projection(camera, size.x(), size.y()), moved);
    case Drag::kDivider:
    case Drag::kNone:
      break;
  }
  return false;
}

bool PictureView::act(Panel& panel, const Placement& place) {
  Document& document = panel.document;
  const ImGuiIO& io = ImGui::GetIO();
  const Vec2 picture = extent(place.picture);
  Vec2 mouse = vec(io.MousePos) - vec(corner(place.picture));
  if (place.beside > 0 && mouse.x() > picture.x()) mouse.x() -= place.beside;  // the second of two
  bool is_changed = false;
  bool is_second_click = false;  // of a double click; two quick drags are none
  if (ImGui::IsItemActivated()) {
    is_second_click = std::exchange(dragged_, 0) < kMostOfAClick &&
                      ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    begin_drag(panel, io.MousePos, place);
  }
  if (ImGui::IsItemActive()) {
    if (drag_ == Drag::kDivider) {
      const double width = extent(place.all).x();
      divider_ =
          std::clamp((io.MousePos.x - place.all.x0) / width, 1 - kMostOfDivider, kMostOfDivider);
    }
    is_changed |= continue_drag(document, mouse, vec(io.MouseDelta), picture);
    if (drag_ == Drag::kHandle) panel.state.vertex_refusal = handles_.refusal();
    dragged_ += vec(io.MouseDelta).norm();
  } else {
    drag_ = Drag::kNone;
    handles_.release();
  }
  const bool is_hovered = ImGui::IsItemHovered();
  const float from_divider = std::abs(io.MousePos.x - place.divider) / panel.widgets.scale();
  if (drag_ == Drag::kDivider ||
      (is_hovered && is_divided(document) && drag_ == Drag::kNone && from_divider < kDividerReach))
    ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  if (is_hovered && io.MouseWheel != 0) {
    zoom_to(document.camera, std::pow(kWheelZoom, io.MouseWheel), mouse, picture,
            document.extent());
    wheel_until_ = ImGui::GetTime() + kWheelSettles;
    is_changed = true;
  }
  if (is_second_click && drag_ != Drag::kHandle && drag_ != Drag::kDivider && picked_) {
    const Vec3 shift = picked_->position - document.camera.focal_point;
    document.camera.focal_point += shift;
    document.camera.position += shift;
    is_changed = true;
  }
  if (is_changed && drag_ == Drag::kHandle) document.touch();
  if (is_changed && drag_ != Drag::kHandle) document.touch_beside_view();
  if (is_hovered && drag_ == Drag::kNone) {
    pick(document, place);
  } else {
    picked_.reset();
  }
  return drag_ != Drag::kNone || ImGui::GetTime() < wheel_until_;
}

// What the pixel of a full picture stands for, which shows something. Until there is a probe, a
// place by the picture's depths alone.
Picked PictureView::picked_in(const Picture& picture, int x, int y, const FieldProbe* probe) {
  const Image& image = picture.image;
  const PictureJob& job = *picture.job;
  if (probe == nullptr) {
    const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                              static_cast<std::size_t>(x);
    double depth = image.depth[pixel];
    if (!std::isfinite(depth)) depth = image.front_depth[pixel];
    const Projection projection(job.camera, image.width, image.height);
    return {projection.world_at(Vec2(x + 0.5, y + 0.5), depth)};
  }
  const PickKey key{shown_->number, x, y, &picture, probe};
  if (key == pick_key_) return last_picked_;
  pick_key_ = key;
  const Pick found =
      ovoid::pick(image, x, y, {job.field(), *probe, job.camera, job.look(), job.options});
  last_picked_ = {found.place->position, found.place->sample.value, found.place->sample.is_defined};
  return last_picked_;
}

void PictureView::pick(const Document& document, const Placement& place) {
  picked_.reset();
  const std::size_t expected = document.compares() ? 2 : 1;
  if (!shown_ || !shown_->is_final || shown_->pictures.size() != expected) return;
  Box2 box = place.all;
  const float x_in_window = ImGui::GetIO().MousePos.x;
  bool is_second = expected == 2;
  if (is_divided(document)) is_second = x_in_window >= place.divider;
  if (place.beside > 0) {
    is_second = x_in_window >= box.x0 + place.beside;
    (is_second ? box.x0 : box.x1) = box.x0 + place.beside;
  }
  const Picture& picture = shown_->pictures[is_second ? 1 : 0];
  const Image& image = picture.image;
  const Vec2 mouse = (vec(ImGui::GetIO().MousePos) - vec(corner(box))).cwiseQuotient(extent(box));
  const int x = static_cast<int>(std::floor(mouse.x() * image.width));
  const int y = static_cast<int>(std::floor(mouse.y() * image.height));
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                            static_cast<std::size_t>(x);
  if (!std::isfinite(image.front_depth[pixel])) return;
  const auto& extras =
      document.compares_fit() && is_second ? document.fit->extras : document.extras;
  picked_ = picked_in(picture, x, y, extras ? extras->probe.get() : nullptr);
}

bool PictureView::draw(Panel& panel, Gui& gui, ImVec2 at, ImVec2 size, float density) {
  Document& document = panel.document;
  ImGui::SetNextWindowPos(at);
  ImGui::SetNextWindowSize(size);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
  ImGui::Begin("picture", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoBringToFrontOnFocus |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoScrollWithMouse |
                   ImGuiWindowFlags_NoNav);
  ImGui::PopStyleVar(2);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Placement place = placement(document, at, size);
  gui.set_background(document.is_open() ? document.view.background : panel.widgets.colors().window);
  show_pictures(document, gui, place);
  bool is_moving = false;
  if (document.is_open()) {
    ImGui::InvisibleButton("canvas", size,
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                               ImGuiButtonFlags_MouseButtonMiddle);
    panel.widgets.mark("picture");
    is_moving = act(panel, place);
    const Vec2 picture = extent(place.picture);
    const ImVec2 upper_left = corner(place.picture);
    const Projection projection(document.camera, picture.x(), picture.y());
    if (document.view.marks.bounding_box) {
      const Box box{Affine3::Identity(), document.bounds()};
      const ImU32 color = box_color(document.view.background);
      draw_box(box, projection, upper_left, list, color);
      const ImVec2 of_second(upper_left.x + place.beside, upper_left.y);
      if (place.beside > 0) draw_box(box, projection, of_second, list, color);
    }
    draw_divider(panel, list, place);
    if (!document.compares()) {
      const PanelState& state = panel.state;
      handles_.draw(document, {state.has_handles, state.has_vertices, state.vertex}, projection,
                    upper_left, list, panel.widgets);
    }
    std::array<Marks::XrayRange, 2> xray_ranges;
    xray_ranges.fill({1e-3, 1.0});
    if (shown_ && !shown_->pictures.empty()) {
      const std::vector<Picture>& two = shown_->pictures;
      const std::size_t own = std::min(shown_->own, two.size() - 1);
      xray_ranges = {two[two.size() - 1 - own].xray_range, two[own].xray_range};
    }
    const Box2 all{at.x, at.y, at.x + size.x, at.y + size.y};
    marks_.draw(document, xray_ranges, list, {all, place.picture, density, panel.widgets.scale()});
  }
  ImGui::End();
  return is_moving;
}

}  // namespace ovoid::viewer
