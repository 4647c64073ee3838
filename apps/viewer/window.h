// SPDX-License-Identifier: Apache-2.0
// The window: the only file pair that sees GLFW, but for the numbers of keys.
#pragma once

#include <string>
#include <vector>

#include "events.h"
#include "size.h"

struct GLFWwindow;

namespace ovoid::viewer {

// A window with an OpenGL 3.3 context, which is current in the thread that made it; all members but
// wake() are that thread's. One at a time.
class Window {
 public:
  // Throws Error(kUnsupported), in one line, where there is no display or no OpenGL 3.3.
  Window(const std::string& title, Size size);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // What happened since the last call; waits for at most `seconds` for something to happen.
  std::vector<Event> events(double seconds);
  static void wake() noexcept;  // ends the wait; from any thread

  Size size() const;              // the window's units, in which the mouse moves
  Size framebuffer() const;       // pixels
  float interface_scale() const;  // how much larger than 96 dpi, in the window's units
  void resize(Size size);
  void set_title(const std::string& title);
  void toggle_full_screen();
  void show_frame();  // swaps
  void hide();

  std::string clipboard() const;
  void set_clipboard(const std::string& text);
  void set_cursor(int imgui_cursor);

 private:
  struct Impl;
  Impl* impl_;
};

}  // namespace ovoid::viewer
