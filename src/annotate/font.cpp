// SPDX-License-Identifier: Apache-2.0
#include "annotate/font.h"

#include <cassert>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <system_error>

namespace ovoid::annotate {
namespace {

// How a glyph is written down: ways of the pen separated by '|'; each is points "x,y" and
// elliptical arcs "(cx,cy,rx,ry,from,to)" in degrees, counter-clockwise if from < to, joined by
// straight lines. Ink runs from x = 0 to `width`.
struct Drawing {
  char32_t character;
  double width;
  const char* ways;
};

// Between the ink of two letters, font units: the pen is 1.1 to 1.5 wide, and a little more than
// that must stay free for words to hold together and 'l', 'i', '1' to stay apart.
constexpr double kGap = 2.9;

constexpr Drawing kUnknown = {U'\uFFFD', 5.0, "0,0 0,10 5,10 5,0 0,0"};

constexpr Drawing kDrawings[] = {
    {U' ', 1.3, ""},
    {U'!', 0.0, "0,10 0,3.2 | 0,0"},
    {U'"', 1.9, "0,10 0,7.4 | 1.9,10 1.9,7.4"},
    {U'#', 7.0, "1.4,0 2.6,10 | 4.4,0 5.6,10 | 0.2,3.3 6.4,3.3 | 0.6,6.7 6.8,6.7"},
    {U'$', 6.0, "(3,7.5,2.75,2.5,32,250) (3,2.65,3,2.65,70,-150) | 3,11.4 3,-1.4"},
    {U'%', 7.6, "0.9,0 6.7,10 | (1.7,7.9,1.7,2.1,0,360) | (5.9,2.1,1.7,2.1,0,360)"},
    {U'&', 7.0, "7,0 (2.9,8.1,1.9,1.9,220,-50) (2.8,2.5,2.8,2.5,140,312) 6.7,4.6"},
    {U'\'', 0.0, "0,10 0,7.4"},
    {U'(', 1.8, "(2.8,4.5,2.8,7,115,245)"},
    {U')', 1.8, "(-1,4.5,2.8,7,65,-65)"},
    {U'*', 4.0, "2,10 2,6 | 0.27,9 3.73,7 | 0.27,7 3.73,9"},
    {U'+', 5.4, "0,4.6 5.4,4.6 | 2.7,7.3 2.7,1.9"},
    {U',', 0.6, "0.6,0.1 0,-2"},
    {U'-', 3.8, "0,4.4 3.8,4.4"},
    {U'.', 0.0, "0,0"},
    {U'/', 4.4, "0,-1.4 4.4,11"},
    {U'0', 6.0, "(3,6.8,3,3.2,0,180) (3,3.2,3,3.2,180,360) 6,6.8"},
    {U'1', 6.0, "0.9,7.8 3.6,10 3.6,0"},
    {U'2', 6.0, "(3,7.1,2.85,2.9,172,-36) 0,0 6,0"},
    {U'3', 6.0, "(2.9,7.65,2.6,2.35,155,-90) 2,5.3 | 2.9,5.3 (2.9,2.65,3,2.65,90,-155)"},
    {U'4', 6.0, "4.5,0 4.5,10 0,2.9 6.2,2.9"},
    {U'5', 6.0, "5.4,10 1.1,10 0.7,5.5 (2.9,3.25,3.1,3.25,128,-152)"},
    {U'6', 6.0, "4.3,10 (3,3.15,3,3.15,154,514)"},
    {U'7', 6.0, "0,10 6,10 2,0"},
    {U'8', 6.0, "(3,7.65,2.55,2.35,0,360) | (3,2.65,3,2.65,0,360)"},
    {U'9', 6.0, "1.7,0 (3,6.85,3,3.15,-26,334)"},
    {U':', 0.0, "0,0.4 | 0,6"},
    {U';', 0.6, "0.6,0.1 0,-2 | 0.6,6"},
    {U'<', 5.0, "5,7.8 0,4.6 5,1.4"},
    {U'=', 5.4, "0,6 5.4,6 | 0,3.2 5.4,3.2"},
    {U'>', 5.0, "0,7.8 5,4.6 0,1.4"},
    {U'?', 5.1, "(2.6,7.4,2.5,2.6,175,-48) 2.6,4.2 2.6,3.2 | 2.6,0"},
    {U'@', 9.0,
     "(4.5,4.3,2,2.2,0,360) | 6.5,6.5 6.5,3.4 (7.75,3.4,1.25,1.3,180,360) (4.5,4.3,4.5,5.3,0,300)"},
    {U'A', 7.2, "0,0 3.6,10 7.2,0 | 1.2,3.3 6,3.3"},
    {U'B', 6.0,
     "0,0 0,10 3.1,10 (3.1,7.65,2.5,2.35,90,-90) 0,5.3 | 3.1,5.3 (3.3,2.65,2.8,2.65,90,-90) 0,0"},
    {U'C', 6.6, "(3.9,5,3.9,5,48,312)"},
    {U'D', 6.8, "0,0 0,10 2.6,10 (2.6,5,4.2,5,90,-90) 0,0"},
    {U'E', 5.4, "5.4,0 0,0 0,10 5.4,10 | 0,5.2 4.8,5.2"},
    {U'F', 5.2, "0,0 0,10 5.2,10 | 0,5 4.5,5"},
    {U'G', 7.3, "(3.9,5,3.9,5,48,332) 7.3,4.8 4.4,4.8"},
    {U'H', 6.8, "0,0 0,10 | 6.8,0 6.8,10 | 0,5.2 6.8,5.2"},
    {U'I', 0.0, "0,0 0,10"},
    {U'J', 4.4, "4.4,10 4.4,2.6 (2.2,2.4,2.2,2.4,0,-168)"},
    {U'K', 6.2, "0,0 0,10 | 6,10 0,3.8 | 2,5.9 6.2,0"},
    {U'L', 5.0, "0,10 0,0 5,0"},
    {U'M', 8.0, "0,0 0,10 4,2.6 8,10 8,0"},
    {U'N', 6.8, "0,0 0,10 6.8,0 6.8,10"},
    {U'O', 7.8, "(3.9,5,3.9,5,0,360)"},
    {U'P', 5.9, "0,0 0,10 3.1,10 (3.1,7.2,2.8,2.8,90,-90) 0,4.4"},
    {U'Q', 7.8, "(3.9,5,3.9,5,0,360) | 4.6,2.6 7.5,-0.8"},
    {U'R', 6.2, "0,0 0,10 3.1,10 (3.1,7.3,2.8,2.7,90,-90) 0,4.6 | 3,4.6 6.2,0"},
    {U'S', 6.0, "(3,7.5,2.75,2.5,32,250) (3,2.65,3,2.65,70,-150)"},
    {U'T', 6.6, "0,10 6.6,10 | 3.3,10 3.3,0"},
    {U'U', 6.6, "0,10 0,3.3 (3.3,3.3,3.3,3.3,180,360) 6.6,10"},
    {U'V', 7.0, "0,10 3.5,0 7,10"},
    {U'W', 10.0, "0,10 2.4,0 5,9 7.6,0 10,10"},
    {U'X', 6.6, "0,0 6.6,10 | 0,10 6.6,0"},
    {U'Y', 6.8, "0,10 3.4,4.6 6.8,10 | 3.4,4.6 3.4,0"},
    {U'Z', 6.2, "0,10 6.2,10 0,0 6.2,0"},
    {U'[', 2.0, "2,11.4 0,11.4 0,-2.4 2,-2.4"},
    {U'\\', 4.4, "0,11 4.4,-1.4"},
    {U']', 2.0, "0,11.4 2,11.4 2,-2.4 0,-2.4"},
    {U'^', 4.8, "0,6.6 2.4,10 4.8,6.6"},
    {U'_', 5.4, "0,-1.6 5.4,-1.6"},
    {U'`', 1.4, "0,10 1.4,8.2"},
    {U'a', 5.0,
     "0.4,5.6 (2.6,4.7,2.4,2.3,152,0) 5,0 | 5,4 2.4,4 (2.1,2,2.1,2,90,270) "
     "(2.9,2.2,2.1,2.2,-90,0)"},
    {U'b', 5.4, "0,10 0,0 | (2.7,3.5,2.7,3.5,0,360)"},
    {U'c', 4.7, "(2.8,3.5,2.8,3.5,46,314)"},
    {U'd', 5.4, "5.4,10 5.4,0 | (2.7,3.5,2.7,3.5,0,360)"},
    {U'e', 5.4, "0.1,3.6 5.4,3.6 (2.7,3.5,2.7,3.5,0,316)"},
    {U'f', 3.4, "1.3,0 1.3,8 (3.3,8,2,2,180,80) | 0,7 3.4,7"},
    {U'g', 5.4, "5.4,7 5.4,-0.6 (2.7,-0.6,2.7,2.4,0,-148) | (2.7,3.5,2.7,3.5,0,360)"},
    {U'h', 5.0, "0,10 0,0 | 0,4.4 (2.5,4.5,2.5,2.5,180,0) 5,0"},
    {U'i', 0.0, "0,7 0,0 | 0,9.7"},
    {U'j', 1.2, "1.2,7 1.2,-1.4 (-0.4,-1.4,1.6,1.6,0,-95) | 1.2,9.7"},
    {U'k', 4.8, "0,10 0,0 | 4.5,7 0,2.6 | 1.7,4.2 4.8,0"},
    {U'l', 1.5, "0,10 0,1.6 (1.5,1.6,1.5,1.6,180,275)"},
    {U'm', 8.4,
     "0,7 0,0 | 0,4.7 (2.1,4.8,2.1,2.2,180,0) 4.2,0 | 4.2,4.7 (6.3,4.8,2.1,2.2,180,0) 8.4,0"},
    {U'n', 5.0, "0,7 0,0 | 0,4.4 (2.5,4.5,2.5,2.5,180,0) 5,0"},
    {U'o', 5.6, "(2.8,3.5,2.8,3.5,0,360)"},
    {U'p', 5.4, "0,7 0,-3 | (2.7,3.5,2.7,3.5,0,360)"},
    {U'q', 5.4, "5.4,7 5.4,-3 | (2.7,3.5,2.7,3.5,0,360)"},
    {U'r', 3.2, "0,7 0,0 | 0,4.2 (2.7,4.2,2.7,2.8,180,78)"},
    {U's', 4.6, "(2.3,5.25,2.05,1.75,30,250) (2.3,1.85,2.3,1.85,70,-150)"},
    {U't', 3.6, "1.3,9.4 1.3,2 (3.3,2,2,2,180,282) | 0,7 3.6,7"},
    {U'u', 5.0, "0,7 0,2.5 (2.5,2.5,2.5,2.5,180,360) | 5,7 5,0"},
    {U'v', 5.2, "0,7 2.6,0 5.2,7"},
    {U'w', 7.8, "0,7 1.9,0 3.9,6.4 5.9,0 7.8,7"},
    {U'x', 4.8, "0,0 4.8,7 | 0,7 4.8,0"},
    {U'y', 5.2, "0,7 2.6,0 | 5.2,7 1.49,-3"},
    {U'z', 4.6, "0,7 4.6,7 0,0 4.6,0"},
    {U'{', 2.8,
     "2.8,11.4 (2.8,9.8,1.4,1.6,90,180) 1.4,6.2 0,4.5 1.4,2.8 1.4,-0.8 (2.8,-0.8,1.4,1.6,180,270)"},
    {U'|', 0.0, "0,11.4 0,-2.4"},
    {U'}', 2.8,
     "0,11.4 (0,9.8,1.4,1.6,90,0) 1.4,6.2 2.8,4.5 1.4,2.8 1.4,-0.8 (0,-0.8,1.4,1.6,0,-90)"},
    {U'~', 6.0, "(1.5,4.2,1.5,1.4,180,0) (4.5,4.8,1.5,1.4,180,360)"},
    {U'\u00B0', 3.0, "(1.5,8.5,1.5,1.5,0,360)"},
    {U'\u00B1', 5.4, "0,5.8 5.4,5.8 | 2.7,8.4 2.7,3.2 | 0,0.4 5.4,0.4"},
    {U'\u00B2', 3.1, "(1.55,8.55,1.45,1.45,172,-36) 0,5 3.1,5"},
    {U'\u00B3', 3.1, "(1.5,8.9,1.35,1.1,155,-90) 1.1,7.8 | 1.5,7.8 (1.5,6.4,1.55,1.4,90,-155)"},
    {U'\u00B5', 5.0, "0,7 0,-3 | 0,2.5 (2.5,2.5,2.5,2.5,180,360) | 5,7 5,0"},
    {U'\u00B7', 0.0, "0,4.6"},
    {U'\u00B9', 1.7, "0.2,8.9 1.6,10 1.6,5"},
    {U'\u00C5', 7.2, "0,0 3.6,9 7.2,0 | 1.2,3 6,3 | (3.6,11,1.2,1.2,0,360)"},
    {U'\u00D7', 4.8, "0,2.2 4.8,7 | 0,7 4.8,2.2"},
    {U'\u03BC', 5.0, "0,7 0,-3 | 0,2.5 (2.5,2.5,2.5,2.5,180,360) | 5,7 5,0"},
    {U'\u2026', 5.0, "0,0 | 2.5,0 | 5,0"},
    {U'\u207B', 2.8, "0,7.4 2.8,7.4"},
    {U'\u2212', 5.4, "0,4.6 5.4,4.6"},
    {U'\u212B', 7.2, "0,0 3.6,9 7.2,0 | 1.2,3 6,3 | (3.6,11,1.2,1.2,0,360)"},
};

// Degrees per segment of an arc: at 40 pixels of size the chord is 0.02 pixels off the ellipse.
constexpr double kArcStep = 7.5;

// Numbers separated by commas, up to the first character that belongs to none.
std::vector<double> take_numbers(const char*& text) {
  const char* const end = text + std::strlen(text);
  std::vector<double> numbers;
  while (true) {
    double number = 0;
    const auto [next, failure] = std::from_chars(text, end, number);  // in no locale's way
    assert(failure == std::errc{} && "a glyph's drawing has something that is no number");
    numbers.push_back(number);
    text = next;
    if (*text != ',') return numbers;
    ++text;
  }
}

void add_arc(const std::vector<double>& arc, std::vector<Vec2>& way) {
  assert(arc.size() == 6);
  const double turn = arc[5] - arc[4];
  const int steps = static_cast<int>(std::ceil(std::abs(turn) / kArcStep));
  for (int i = 0; i <= steps; ++i) {
    const double angle = (arc[4] + turn * i / steps) * (std::numbers::pi / 180);
    way.emplace_back(arc[0] + arc[2] * std::cos(angle), arc[1] + arc[3] * std::sin(angle));
  }
}

Glyph drawn(const Drawing& drawing) {
  Glyph glyph;
  glyph.advance = drawing.width + kGap;
  const char* text = drawing.ways;
  if (*text != '\0') glyph.strokes.emplace_back();
  while (*text != '\0') {
    if (*text == ' ') {
      ++text;
    } else if (*text == '|') {
      glyph.strokes.emplace_back();
      ++text;
    } else if (*text == '(') {
      add_arc(take_numbers(++text), glyph.strokes.back());
      ++text;  // ')'
    } else {
      const std::vector<double> point = take_numbers(text);
      assert(point.size() == 2);
      glyph.strokes.back().emplace_back(point[0], point[1]);
    }
  }
  return glyph;
}

const std::map<char32_t, Glyph>& glyphs() {
  static const std::map<char32_t, Glyph> all = [] {
    std::map<char32_t, Glyph> made;
    for (const Drawing& drawing : kDrawings) made.emplace(drawing.character, drawn(drawing));
    return made;
  }();
  return all;
}

constexpr char32_t kReplacement = U'\uFFFD';

// The character that starts at `at`, which moves behind it; a bad byte is passed over alone.
char32_t next_character(std::string_view text, std::size_t& at) {
  const auto byte = [&](std::size_t i) -> char32_t {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0;
  };
  const char32_t first = byte(at++);
  if (first < 0x80) return first;
  const int following = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : 1;
  if (first < 0xC2 || first > 0xF4) return kReplacement;
  char32_t character = first & (0x3FU >> following);
  for (int i = 0; i < following; ++i) {
    const char32_t more = byte(at + static_cast<std::size_t>(i));
    if ((more & 0xC0U) != 0x80U) return kReplacement;
    character = character << 6U | (more & 0x3FU);
  }
  constexpr char32_t kLeast[] = {0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = character >= 0xD800 && character <= 0xDFFF;
  if (character < kLeast[following] || character > 0x10FFFF || is_surrogate) return kReplacement;
  at += static_cast<std::size_t>(following);
  return character;
}

}  // namespace

const Glyph& glyph_of(char32_t character) {
  static const Glyph unknown = drawn(kUnknown);
  const auto found = glyphs().find(character);
  return found == glyphs().end() ? unknown : found->second;
}

bool has_glyph(char32_t character) { return glyphs().contains(character); }

std::u32string decode_utf8(std::string_view text, std::size_t most) {
  std::u32string characters;
  for (std::size_t at = 0; at < text.size() && characters.size() < most;) {
    characters.push_back(next_character(text, at));
  }
  return characters;
}

}  // namespace ovoid::annotate
