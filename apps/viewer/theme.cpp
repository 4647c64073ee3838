// SPDX-License-Identifier: Apache-2.0
#include "theme.h"

namespace ovoid::viewer {
namespace {

constexpr ThemeColors kDarkColors = {
    .ink = IM_COL32(235, 238, 242, 255),
    .faint = IM_COL32(170, 178, 190, 255),
    .error = IM_COL32(255, 140, 120, 255),
    .ground = IM_COL32(10, 11, 13, 215),
    .bar = IM_COL32(90, 160, 255, 255),
    .canvas = IM_COL32(20, 22, 26, 255),
    .histogram = IM_COL32(70, 82, 98, 255),
    .curve = IM_COL32(235, 235, 235, 255),
    .point = IM_COL32(255, 255, 255, 255),
    .point_edge = IM_COL32(0, 0, 0, 255),
    .selected = IM_COL32(255, 170, 40, 255),
    .mark = IM_COL32(120, 220, 255, 255),
    .window = {0.05, 0.055, 0.065},
};

constexpr ThemeColors kLightColors = {
    .ink = IM_COL32(24, 27, 32, 255),
    .faint = IM_COL32(76, 84, 96, 255),
    .error = IM_COL32(170, 20, 10, 255),
    .ground = IM_COL32(248, 249, 251, 225),
    .bar = IM_COL32(30, 105, 215, 255),
    .canvas = IM_COL32(252, 252, 253, 255),
    .histogram = IM_COL32(196, 205, 217, 255),
    .curve = IM_COL32(30, 34, 40, 255),
    .point = IM_COL32(40, 45, 54, 255),
    .point_edge = IM_COL32(255, 255, 255, 255),
    .selected = IM_COL32(172, 80, 0, 255),
    .mark = IM_COL32(0, 100, 160, 255),
    .window = {0.88, 0.89, 0.905},
};

// ImGui's own is hard to read where the mouse is, and where things are disabled.
void color_dark(ImGuiStyle& style) {
  ImGui::StyleColorsDark(&style);
  ImVec4* const colors = style.Colors;
  colors[ImGuiCol_TextDisabled] = ImVec4(0.64F, 0.64F, 0.64F, 1.0F);
  colors[ImGuiCol_WindowBg] = ImVec4(0.11F, 0.12F, 0.14F, 1.0F);
  colors[ImGuiCol_PopupBg] = ImVec4(0.14F, 0.15F, 0.17F, 0.98F);
  for (const ImGuiCol hovered :
       {ImGuiCol_ButtonHovered, ImGuiCol_TabHovered, ImGuiCol_HeaderActive})
    colors[hovered] = ImVec4(0.20F, 0.45F, 0.78F, 1.0F);
  colors[ImGuiCol_HeaderHovered] = ImVec4(0.26F, 0.59F, 0.98F, 0.18F);
  colors[ImGuiCol_ButtonActive] = ImVec4(0.06F, 0.40F, 0.75F, 1.0F);
}

// ImGui's own is pale where things are disabled, and where tabs, rows and bars meet the window.
void color_light(ImGuiStyle& style) {
  ImGui::StyleColorsLight(&style);
  ImVec4* const colors = style.Colors;
  colors[ImGuiCol_Text] = ImVec4(0.09F, 0.10F, 0.12F, 1.0F);
  colors[ImGuiCol_TextDisabled] = ImVec4(0.33F, 0.35F, 0.39F, 1.0F);
  colors[ImGuiCol_WindowBg] = ImVec4(0.94F, 0.945F, 0.955F, 1.0F);
  colors[ImGuiCol_PopupBg] = ImVec4(0.985F, 0.985F, 0.99F, 0.98F);
  colors[ImGuiCol_FrameBg] = ImVec4(1.0F, 1.0F, 1.0F, 1.0F);
  colors[ImGuiCol_HeaderHovered] = ImVec4(0.26F, 0.59F, 0.98F, 0.28F);
  colors[ImGuiCol_Border] = ImVec4(0.60F, 0.63F, 0.68F, 0.60F);
  colors[ImGuiCol_Separator] = ImVec4(0.62F, 0.65F, 0.70F, 0.60F);
  colors[ImGuiCol_TableHeaderBg] = ImVec4(0.84F, 0.86F, 0.89F, 1.0F);
  colors[ImGuiCol_TableRowBgAlt] = ImVec4(0.30F, 0.35F, 0.45F, 0.07F);
  colors[ImGuiCol_CheckMark] = ImVec4(0.18F, 0.46F, 0.86F, 1.0F);
  colors[ImGuiCol_SliderGrab] = ImVec4(0.26F, 0.52F, 0.90F, 1.0F);
  style.FrameBorderSize = 1;  // white fields on a window that is nearly white
}

}  // namespace

const cli::Names<Theme>& theme_names() {
  static const cli::Names<Theme> all = {{"dark", Theme::kDark}, {"light", Theme::kLight}};
  return all;
}

const ThemeColors& colors_of(Theme theme) {
  return theme == Theme::kLight ? kLightColors : kDarkColors;
}

ImGuiStyle style_of(Theme theme, float scale) {
  ImGuiStyle style;
  style.WindowRounding = 0;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.PopupRounding = 3;
  style.ScrollbarRounding = 3;
  style.WindowBorderSize = 0;
  style.FramePadding = ImVec2(6, 3);
  style.ItemSpacing = ImVec2(6, 5);
  style.ScaleAllSizes(scale);
  theme == Theme::kLight ? color_light(style) : color_dark(style);
  style.Colors[ImGuiCol_SliderGrab].w = 0.55F;  // the number can be read through it
  return style;
}

}  // namespace ovoid::viewer
