// SPDX-License-Identifier: Apache-2.0
// Dear ImGui's widgets with names, by which scripts find them, and with our numbers' types.
#pragma once

#include <imgui.h>

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ovoid/math.h"
#include "ovoid/transfer_function.h"
#include "theme.h"

namespace ovoid::viewer {

// A rectangle of the window, in its own units.
struct Box2 {
  float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  ImVec2 middle() const { return {(x0 + x1) / 2, (y0 + y1) / 2}; }
};

// What of a number may be typed or dragged.
struct NumberField {
  double lo = -1e300;
  double hi = 1e300;
  double speed = 0;  // per pixel of a drag; 0: a two-hundredth of the range, or of the value
  const char* format = "%.6g";
  bool is_logarithmic = false;
};

// All but the finders are to be called between ImGui::NewFrame() and Render(). Widgets that change
// a value return whether they did.
class Widgets {
 public:
  void begin_frame(float scale, const ThemeColors& colors);

  // Names the last item, or a place that is no item of ImGui's.
  void mark(const std::string& name);
  void mark(const std::string& name, const Box2& box);
  // Where it was drawn last; empty if it was not, or is hidden behind its panel's border.
  std::optional<Box2> find(const std::string& name) const;
  // Whether it was drawn, if out of sight; the next frame will scroll to it.
  bool scroll_to(const std::string& name);

  bool button(const std::string& name, const char* label, bool is_enabled = true);
  // At the right border of the row of the item before.
  bool button_at_right(const std::string& name, const char* label);
  bool checkbox(const std::string& name, const char* label, bool* value);
  bool number(const std::string& name, const char* label, double* value, const NumberField& = {});
  bool slider(const std::string& name, const char* label, double* value, double lo, double hi,
              const char* format = "%.4g");
  bool whole(const std::string& name, const char* label, int* value, int lo, int hi);
  bool vector(const std::string& name, const char* label, Vec3* value, double speed);
  bool color(const std::string& name, const char* label, Rgb* value);
  bool swatch(const std::string& name, Rgb* value);  // the colour alone, a click opens its editor
  bool bare_slider(const std::string& name, double* value, double lo, double hi);
  // `decorate`, if any, draws onto an option in the opened list, which is then ImGui's last item.
  bool choice(const std::string& name, const char* label, const std::vector<const char*>& options,
              int* chosen, const std::function<void(int option)>& decorate = {});
  bool text(const std::string& name, const char* hint, std::string* value, float width = -1);
  void row(const char* label, const std::string& value);           // text at both borders
  std::string fitted(const std::string& text, float width) const;  // cut where it is too wide
  // Rows with a scroll bar of their own, so many in sight.
  void begin_list(const std::string& name, int rows);
  void end_list();
  // A sentence about the item before, shown while the mouse rests on it.
  void tip(const char* sentence);
  // Letters over a picture, on a ground of their own; `wrap`: the most that they are wide, 0: any.
  void label(ImDrawList& list, ImVec2 at, ImU32 color, const std::string& text, float wrap = 0);

  float scale() const noexcept { return scale_; }
  const ThemeColors& colors() const noexcept { return *colors_; }
  float width_of_label() const noexcept { return 134 * scale_; }

 private:
  struct Place {
    Box2 box;
    bool is_in_sight = true;
  };
  void label_before(const char* label) const;
  // A field that is typed into takes effect when it is left or Enter is pressed, not by every key.
  template <typename Value, typename Draw>
  bool typed(const std::string& name, Value* value, const Draw& draw);

  std::map<std::string, Place> now_, last_;
  std::string wanted_;         // is scrolled to
  bool has_scrolled_ = false;  // in the list that is drawn, which is to come in sight, too
  // The item that the mouse rests on, and since when.
  ImVec2 rested_on_{-1, -1};
  double rests_since_ = 0;
  // The field that is typed into, and what it says so far.
  std::string typed_into_;
  std::array<double, 3> typed_{};
  float scale_ = 1;
  const ThemeColors* colors_ = &colors_of(Theme::kDark);
};

}  // namespace ovoid::viewer
