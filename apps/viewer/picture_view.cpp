// SPDX-License-Identifier: Apache-2.0
#include "picture_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hands.h"

namespace ovoid::viewer {
namespace {

constexpr double kWheelZoom = 1.12;     // per notch
constexpr double kDragZoom = 1.008;     // per pixel
constexpr double kWheelSettles = 0.18;  // seconds after its last notch
constexpr float kHandleReach = 10;      // of a handle
constexpr double kMostOfAClick = 4;     // how far the mouse may go
constexpr ImU32 kBoxColor = IM_COL32(200, 205, 215, 110);

Vec2 vec(ImVec2 v) { return {v.x, v.y}; }

// The size in which the camera's picture is shown: with two beside each other, of one of them.
Vec2 size_of_picture(const Document& document, ImVec2 size) {
  const bool is_split = document.compare == CompareMode::kSideBySide && document.other;
  return {is_split ? size.x / 2 : size.x, size.y};
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

const Picture* PictureView::full(std::uint64_t number) const noexcept {
  if (!shown_ || shown_->number != number || !shown_->level.is_full() || !shown_->is_final ||
      shown_->pictures.empty())
    return nullptr;
  return &shown_->pictures.back();
}

void PictureView::show_pictures(const Document& document, Gui& gui, ImDrawList& list, ImVec2 at,
                                ImVec2 size) const {
  gui.set_background(document.view.background);
  if (!shown_ || shown_->pictures.empty()) return;
  if (shown_->pictures.size() == 1)
    return gui.show_behind(textures_[0], at.x, at.y, size.x, size.y);
  if (document.compare == CompareMode::kDifference && !shown_->difference.empty())
    return gui.show_behind(difference_, at.x, at.y, size.x, size.y);
  const float half = size.x / 2;
  gui.show_behind(textures_[0], at.x, at.y, half, size.y);
  gui.show_behind(textures_[1], at.x + half, at.y, half, size.y);
  const float middle = at.x + half;
  list.AddLine({middle, at.y}, {middle, at.y + size.y}, IM_COL32(255, 255, 255, 160));
  list.AddText({middle - 20, at.y + 8}, IM_COL32(255, 255, 255, 220), "A");
  list.AddText({middle + 10, at.y + 8}, IM_COL32(255, 255, 255, 220), "B, which the panel edits");
}

void PictureView::begin_drag(const Panel& panel, ImVec2 mouse, float reach) {
  const ImGuiIO& io = ImGui::GetIO();
  const bool is_left = ImGui::IsMouseDown(ImGuiMouseButton_Left);
  if (is_left && panel.state.has_handles && handles_.press(mouse, reach)) {
    drag_ = Drag::kHandle;
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
    case Drag::kNone:
      break;
  }
  return false;
}

bool PictureView::act(Panel& panel, ImVec2 at, ImVec2 size) {
  Document& document = panel.document;
  const ImGuiIO& io = ImGui::GetIO();
  const Vec2 picture = size_of_picture(document, size);
  Vec2 mouse = vec(io.MousePos) - vec(at);
  if (mouse.x() > picture.x()) mouse.x() -= picture.x();  // the second of two
  bool is_changed = false;
  bool is_second_click = false;  // of a double click; two quick drags are none
  if (ImGui::IsItemActivated()) {
    is_second_click = std::exchange(dragged_, 0) < kMostOfAClick &&
                      ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    begin_drag(panel, io.MousePos, kHandleReach * panel.widgets.scale());
  }
  if (ImGui::IsItemActive()) {
    is_changed |= continue_drag(document, mouse, vec(io.MouseDelta), picture);
    dragged_ += vec(io.MouseDelta).norm();
  } else {
    drag_ = Drag::kNone;
    handles_.release();
  }
  const bool is_hovered = ImGui::IsItemHovered();
  if (is_hovered && io.MouseWheel != 0) {
    zoom_to(document.camera, std::pow(kWheelZoom, io.MouseWheel), mouse, picture,
            document.extent());
    wheel_until_ = ImGui::GetTime() + kWheelSettles;
    is_changed = true;
  }
  if (is_second_click && drag_ != Drag::kHandle && picked_) {
    const Vec3 shift = picked_->position - document.camera.focal_point;
    document.camera.focal_point += shift;
    document.camera.position += shift;
    is_changed = true;
  }
  if (is_changed && drag_ == Drag::kHandle) document.touch();
  if (is_changed && drag_ != Drag::kHandle) document.touch_beside_view();
  if (is_hovered && drag_ == Drag::kNone) {
    pick(document, at, size);
  } else {
    picked_.reset();
  }
  return drag_ != Drag::kNone || ImGui::GetTime() < wheel_until_;
}

// From the depth of the full picture: where the opacity passes one half.
void PictureView::pick(const Document& document, ImVec2 at, ImVec2 size) {
  picked_.reset();
  if (!shown_ || !shown_->is_final || shown_->pictures.size() != 1) return;
  const Picture& picture = shown_->pictures.front();
  const Image& image = picture.image;
  const Vec2 mouse = vec(ImGui::GetIO().MousePos) - vec(at);
  const int x = static_cast<int>(std::floor(mouse.x() / size.x * image.width));
  const int y = static_cast<int>(std::floor(mouse.y() / size.y * image.height));
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  const double depth =
      image.depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                  static_cast<std::size_t>(x)];
  if (!std::isfinite(depth)) return;
  const Projection projection(picture.scene->camera, image.width, image.height);
  Picked picked{projection.world_at(Vec2(x + 0.5, y + 0.5), depth)};
  if (document.extras && document.extras->probe) {
    const FieldSample sample = document.extras->probe->at(picked.position);
    picked.is_defined = sample.is_defined;
    picked.value = sample.value;
  }
  picked_ = picked;
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
  show_pictures(document, gui, list, at, size);
  bool is_moving = false;
  if (document.is_open()) {
    ImGui::InvisibleButton("canvas", size,
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                               ImGuiButtonFlags_MouseButtonMiddle);
    panel.widgets.mark("picture");
    is_moving = act(panel, at, size);
    const Vec2 picture = size_of_picture(document, size);
    const Projection projection(document.camera, picture.x(), picture.y());
    if (document.view.marks.bounding_box)
      draw_box({Affine3::Identity(), document.bounds()}, projection, at, list, kBoxColor);
    if (panel.state.has_handles && document.compare == CompareMode::kOff)
      handles_.draw(document, projection, at, list, panel.widgets);
    const auto xray_range = shown_ && !shown_->pictures.empty() ? shown_->pictures.back().xray_range
                                                                : std::pair(1e-3, 1.0);
    marks_.draw(document, xray_range, list, at, size, density, panel.widgets.scale());
  }
  ImGui::End();
  return is_moving;
}

}  // namespace ovoid::viewer
