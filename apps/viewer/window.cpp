// SPDX-License-Identifier: Apache-2.0
#include "window.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <array>
#include <cstdlib>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::viewer {

struct Window::Impl {
  GLFWwindow* window = nullptr;
  std::vector<Event> events;
  std::array<GLFWcursor*, ImGuiMouseCursor_COUNT> cursors{};
  int cursor = -1;
  // Where the window was before it filled the screen.
  int x = 0, y = 0;
  Size size;
};

namespace {

std::string last_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text == nullptr ? "the reason is not known" : text;
}

std::string advice() { return "; 'ovoid render' draws to a file and needs no display"; }

std::vector<Event>& events_of(GLFWwindow* window) {
  return *static_cast<std::vector<Event>*>(glfwGetWindowUserPointer(window));
}

void install_callbacks(GLFWwindow* window) {
  glfwSetCursorPosCallback(window, [](GLFWwindow* from, double x, double y) {
    events_of(from).push_back(MouseMoved{x, y});
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* from, int button, int action, int) {
    events_of(from).push_back(ButtonChanged{button, action == GLFW_PRESS});
  });
  glfwSetScrollCallback(window, [](GLFWwindow* from, double dx, double dy) {
    events_of(from).push_back(Scrolled{dx, dy});
  });
  glfwSetKeyCallback(window, [](GLFWwindow* from, int key, int, int action, int modifiers) {
    events_of(from).push_back(KeyChanged{key, action != GLFW_RELEASE, modifiers});
  });
  glfwSetCharCallback(window, [](GLFWwindow* from, unsigned codepoint) {
    events_of(from).push_back(Typed{codepoint});
  });
  glfwSetDropCallback(window, [](GLFWwindow* from, int count, const char** paths) {
    events_of(from).push_back(Dropped{{paths, paths + count}});
  });
  glfwSetWindowCloseCallback(window, [](GLFWwindow* from) {
    glfwSetWindowShouldClose(from, GLFW_FALSE);  // the program decides
    events_of(from).push_back(CloseAsked{});
  });
}

}  // namespace

Window::Window(const std::string& title, Size size) : impl_(new Impl) {
  if (glfwInit() != GLFW_TRUE) {
    const std::string reason = last_error();
    delete impl_;
    throw Error(ErrorCode::kUnsupported,
                fmt::format("no window can be opened: {}{}", reason, advice()));
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  impl_->window = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
  if (impl_->window == nullptr) {
    const std::string reason = last_error();
    glfwTerminate();
    delete impl_;
    throw Error(ErrorCode::kUnsupported,
                fmt::format("no window with OpenGL 3.3 can be opened: {}{}", reason, advice()));
  }
  glfwMakeContextCurrent(impl_->window);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(impl_->window, &impl_->events);
  install_callbacks(impl_->window);
}

Window::~Window() {
  for (GLFWcursor* const cursor : impl_->cursors) {
    if (cursor != nullptr) glfwDestroyCursor(cursor);
  }
  glfwDestroyWindow(impl_->window);
  glfwTerminate();
  delete impl_;
}

std::vector<Event> Window::events(double seconds) {
  if (seconds > 0) {
    glfwWaitEventsTimeout(seconds);
  } else {
    glfwPollEvents();
  }
  return std::exchange(impl_->events, {});
}

void Window::wake() noexcept { glfwPostEmptyEvent(); }

Size Window::size() const {
  Size size;
  glfwGetWindowSize(impl_->window, &size.width, &size.height);
  return size;
}

Size Window::framebuffer() const {
  Size size;
  glfwGetFramebufferSize(impl_->window, &size.width, &size.height);
  return size;
}

float Window::interface_scale() const {
  // Set by hand where the display tells nothing sensible, as remote ones do.
  if (const char* const asked = std::getenv("OVOID_INTERFACE_SCALE")) {
    const float scale = std::strtof(asked, nullptr);
    if (scale >= 0.5F && scale <= 8.0F) return scale;
  }
  float across = 1;
  float down = 1;
  glfwGetWindowContentScale(impl_->window, &across, &down);
  const Size window = size();
  const Size pixels = framebuffer();
  const float already =
      window.width > 0 ? static_cast<float>(pixels.width) / static_cast<float>(window.width) : 1.0F;
  return across / already;
}

void Window::resize(Size size) { glfwSetWindowSize(impl_->window, size.width, size.height); }

void Window::set_title(const std::string& title) {
  glfwSetWindowTitle(impl_->window, title.c_str());
}

void Window::toggle_full_screen() {
  Impl& own = *impl_;
  if (glfwGetWindowMonitor(own.window) != nullptr) {
    glfwSetWindowMonitor(own.window, nullptr, own.x, own.y, own.size.width, own.size.height, 0);
    return;
  }
  GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* const mode = monitor == nullptr ? nullptr : glfwGetVideoMode(monitor);
  if (mode == nullptr) return;
  glfwGetWindowPos(own.window, &own.x, &own.y);
  own.size = size();
  glfwSetWindowMonitor(own.window, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

void Window::show_frame() { glfwSwapBuffers(impl_->window); }

void Window::hide() { glfwHideWindow(impl_->window); }

std::string Window::clipboard() const {
  const char* const text = glfwGetClipboardString(impl_->window);
  return text == nullptr ? "" : text;
}

void Window::set_clipboard(const std::string& text) {
  glfwSetClipboardString(impl_->window, text.c_str());
}

void Window::set_cursor(int imgui_cursor) {
  Impl& own = *impl_;
  if (imgui_cursor == own.cursor) return;
  own.cursor = imgui_cursor;
  int shape = GLFW_ARROW_CURSOR;
  if (imgui_cursor == ImGuiMouseCursor_TextInput) shape = GLFW_IBEAM_CURSOR;
  if (imgui_cursor == ImGuiMouseCursor_Hand) shape = GLFW_HAND_CURSOR;
  if (imgui_cursor == ImGuiMouseCursor_ResizeEW) shape = GLFW_HRESIZE_CURSOR;
  if (imgui_cursor == ImGuiMouseCursor_ResizeNS) shape = GLFW_VRESIZE_CURSOR;
  if (imgui_cursor < 0 || imgui_cursor >= ImGuiMouseCursor_COUNT) return;
  GLFWcursor*& cursor = own.cursors[static_cast<std::size_t>(imgui_cursor)];
  if (cursor == nullptr) cursor = glfwCreateStandardCursor(shape);
  glfwSetCursor(own.window, cursor);
}

}  // namespace ovoid::viewer
