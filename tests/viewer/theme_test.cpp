// SPDX-License-Identifier: Apache-2.0
// Both themes can be read: contrasts of letters, lines and points to what they stand on, by WCAG
// 2.1: 4.5 for letters, 3 for what else carries meaning.
#include "theme.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace ovoid::viewer {
namespace theme_test {

constexpr double kLetters = 4.5;
constexpr double kShapes = 3;

ImVec4 vec(ImU32 color) {
  const auto part = [&](int shift) { return static_cast<float>(color >> shift & 255U) / 255; };
  return {part(IM_COL32_R_SHIFT), part(IM_COL32_G_SHIFT), part(IM_COL32_B_SHIFT),
          part(IM_COL32_A_SHIFT)};
}

ImVec4 over(const ImVec4& color, const ImVec4& below) {
  const auto mixed = [&](float a, float b) { return color.w * a + (1 - color.w) * b; };
  return {mixed(color.x, below.x), mixed(color.y, below.y), mixed(color.z, below.z), 1};
}

double luminance(const ImVec4& color) {
  const auto linear = [](float c) {
    return c <= 0.04045F ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(color.x) + 0.7152 * linear(color.y) + 0.0722 * linear(color.z);
}

double contrast(const ImVec4& a, const ImVec4& b) {
  const double x = luminance(a);
  const double y = luminance(b);
  return (std::max(x, y) + 0.05) / (std::min(x, y) + 0.05);
}

const ImVec4 kBlack{0, 0, 0, 1};
const ImVec4 kWhite{1, 1, 1, 1};

class Themes : public ::testing::TestWithParam<Theme> {
 protected:
  const ThemeColors& colors() const { return colors_of(GetParam()); }
};

TEST_P(Themes, LettersOverAnyPicture) {
  for (const ImVec4& picture : {kBlack, kWhite}) {
    const ImVec4 ground = over(vec(colors().ground), picture);
    EXPECT_GE(contrast(vec(colors().ink), ground), kLetters);
    EXPECT_GE(contrast(vec(colors().faint), ground), kLetters);
    EXPECT_GE(contrast(vec(colors().error), ground), kLetters);
    EXPECT_GE(contrast(vec(colors().bar), ground), kShapes);
  }
}

TEST_P(Themes, LettersOfThePanel) {
  const ImGuiStyle style = style_of(GetParam(), 1);
  const ImVec4 window = style.Colors[ImGuiCol_WindowBg];
  const auto on_window = [&](ImGuiCol color) { return over(style.Colors[color], window); };
  for (const ImGuiCol ground :
       {ImGuiCol_WindowBg, ImGuiCol_PopupBg, ImGuiCol_FrameBg, ImGuiCol_FrameBgHovered,
        ImGuiCol_FrameBgActive, ImGuiCol_Button, ImGuiCol_ButtonHovered, ImGuiCol_ButtonActive,
        ImGuiCol_Tab, ImGuiCol_TabActive, ImGuiCol_TabHovered, ImGuiCol_Header,
        ImGuiCol_HeaderHovered, ImGuiCol_TableHeaderBg, ImGuiCol_TitleBgActive}) {
    EXPECT_GE(contrast(style.Colors[ImGuiCol_Text], on_window(ground)), kLetters)
        << ImGui::GetStyleColorName(ground);
  }
  // The line under the mouse has faint letters, too.
  const ImVec4 faint = style.Colors[ImGuiCol_TextDisabled];
  for (const ImGuiCol ground : {ImGuiCol_WindowBg, ImGuiCol_PopupBg}) {
    const ImVec4 below = on_window(ground);
    EXPECT_GE(contrast(faint, below), kLetters);
    EXPECT_GE(contrast(faint, over(style.Colors[ImGuiCol_HeaderHovered], below)), kLetters);
  }
  EXPECT_GE(contrast(style.Colors[ImGuiCol_CheckMark], on_window(ImGuiCol_FrameBg)), kShapes);
  // A number can be read through the slider's grab.
  EXPECT_GE(contrast(style.Colors[ImGuiCol_Text],
                     over(style.Colors[ImGuiCol_SliderGrab], on_window(ImGuiCol_FrameBg))),
            kLetters);
}

TEST_P(Themes, CurvesBeforeTheirHistogram) {
  for (const ImU32 ground : {colors().canvas, colors().histogram}) {
    EXPECT_GE(contrast(vec(colors().curve), vec(ground)), kShapes);
    EXPECT_GE(contrast(vec(colors().point), vec(ground)), kShapes);
    EXPECT_GE(contrast(vec(colors().selected), vec(ground)), kShapes);
    EXPECT_GE(contrast(vec(colors().mark), vec(ground)), kShapes);
  }
  // Bars are seen at all, and the one point is told from the others.
  EXPECT_GE(contrast(vec(colors().histogram), vec(colors().canvas)), 1.5);
  EXPECT_GE(contrast(vec(colors().selected), vec(colors().point)), 1.5);
}

INSTANTIATE_TEST_SUITE_P(Both, Themes, ::testing::Values(Theme::kDark, Theme::kLight),
                         [](const auto& parameter) {
                           return std::string(cli::name_in(theme_names(), parameter.param));
                         });

}  // namespace theme_test
}  // namespace ovoid::viewer
