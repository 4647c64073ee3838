// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <variant>
#include <vector>

namespace ovoid::viewer {

// What a person does to the window; a script does the same. Positions are in the window's own units
// from its upper left corner, buttons and keys in GLFW's numbers.
struct MouseMoved {
  double x = 0, y = 0;
};
struct ButtonChanged {
  int button = 0;
  bool is_down = false;
};
struct Scrolled {
  double dx = 0, dy = 0;  // notches, upwards and to the right positive
};
struct KeyChanged {
  int key = 0;
  bool is_down = false;
  int modifiers = 0;
};
struct Typed {
  unsigned codepoint = 0;
};
struct Dropped {
  std::vector<std::string> paths;
};
struct CloseAsked {};

using Event =
    std::variant<MouseMoved, ButtonChanged, Scrolled, KeyChanged, Typed, Dropped, CloseAsked>;

}  // namespace ovoid::viewer
