// SPDX-License-Identifier: Apache-2.0
// Colours of the interface, light or dark. What is drawn over a picture has a ground of its own, so
// that it can be read whatever the picture is.
#pragma once

#include <imgui.h>

#include "ovoid/transfer_function.h"
#include "values.h"

namespace ovoid::viewer {

enum class Theme { kDark, kLight };

const cli::Names<Theme>& theme_names();

struct ThemeColors {
  ImU32 ink, faint, error;  // letters on `ground`
  ImU32 ground;             // behind letters over a picture
  ImU32 bar;                // how far the work has come, on `ground`
  // The editors of curves: letters, lines and points on `canvas`.
  ImU32 canvas, histogram, curve, point, point_edge, selected, mark;
  Rgb window;  // behind everything, while no picture is there
};

const ThemeColors& colors_of(Theme theme);

// Dear ImGui's style, with lengths for an interface of that scale.
ImGuiStyle style_of(Theme theme, float scale);

}  // namespace ovoid::viewer
