// SPDX-License-Identifier: Apache-2.0
// The letters of marks: a stroke font of our own, so that text needs no font file or library and
// has the same bytes everywhere. A glyph is lines and arcs for a round pen.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace ovoid::annotate {

using Vec2 = Eigen::Vector2d;

// Heights in font units above the baseline, y up. A text of size S (pixels from one line to the
// next but for leading) has capitals of 0.7 S.
inline constexpr double kCapHeight = 10.0;
inline constexpr double kXHeight = 7.0;
inline constexpr double kDescender = -3.0;
inline constexpr double kUnitsPerSize = 0.07;  // sizes per font unit

// One letter: the ways of the pen, and how far the next letter's origin is.
struct Glyph {
  std::vector<std::vector<Vec2>> strokes;  // polylines; one of a single point is a dot
  double advance = 0;                      // font units
};

// The glyph of a character: ASCII 32 to 126, and for units micro (and mu), degree, superscript 1, 2
// and 3, middle dot, times, plus-minus, minus, Angstrom, superscript minus, ellipsis. A box for any
// other. Thread-safe.
const Glyph& glyph_of(char32_t character);
bool has_glyph(char32_t character);

// The characters of UTF-8 text, at most `most` of them; each byte that is no part of a valid
// character becomes U+FFFD.
std::u32string decode_utf8(std::string_view text, std::size_t most);

}  // namespace ovoid::annotate
