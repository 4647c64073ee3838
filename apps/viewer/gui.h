// SPDX-License-Identifier: Apache-2.0
// Dear ImGui's frame: fed with our own events, so that a script's input takes the same way as a
// person's, and drawn by its OpenGL back end.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "events.h"
#include "ovoid/transfer_function.h"
#include "theme.h"
#include "widgets.h"
#include "window.h"

namespace ovoid::viewer {

// A picture on the display's side. The context must be current while one lives.
class Texture {
 public:
  Texture() = default;
  ~Texture();
  Texture(Texture&& other) noexcept;
  Texture& operator=(Texture&& other) noexcept;

  // Straight alpha, row 0 at the top.
  void upload(const std::uint8_t* rgba, int width, int height);
  // Opaque, row 0 at the bottom, in the order of most windows' own pixels, into which a driver
  // without a graphics processor then copies it as it is (Gui::show_behind).
  void upload_opaque(const std::uint8_t* bgra, int width, int height);
  unsigned name() const noexcept { return name_; }
  void* id() const noexcept;  // as ImGui takes it
  bool is_empty() const noexcept { return name_ == 0; }
  Size size() const noexcept { return {width_, height_}; }

 private:
  void upload(const std::uint8_t* pixels, int width, int height, unsigned order);

  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
};

class Gui {
 public:
  explicit Gui(Window& window);
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  // `seconds` since the last frame.
  void begin(const std::vector<Event>& events, double seconds);
  void end();  // draws; the frame is shown by Window::show_frame()

  // Shows an opaque picture behind everything else of this frame, in a rectangle of the window's
  // units, as much of it as lies right of `from_x`; its rows begin at the bottom. Copied, not
  // drawn: drivers without a graphics processor would spend more on a drawn rectangle than on the
  // interface.
  void show_behind(const Texture& picture, const Box2& place, float from_x = 0);
  void set_background(const Rgb& color) { background_ = color; }
  void set_theme(Theme theme);  // between two frames

  float scale() const noexcept { return scale_; }  // of all lengths of the interface
  // What was drawn last, 8-bit RGB, row 0 at the top.
  std::vector<std::uint8_t> pixels(Size* size) const;

 private:
  void rescale();

  struct Behind {
    unsigned texture;
    Size size;
    Box2 place;
    float from_x;
  };

  Window& window_;
  float scale_ = 0;
  Theme theme_ = Theme::kDark;
  Rgb background_{0, 0, 0};
  std::vector<Behind> behind_;
  unsigned framebuffer_ = 0;  // from which pictures are copied
  std::string clipboard_;
};

}  // namespace ovoid::viewer
