// SPDX-License-Identifier: Apache-2.0
#include "annotate/font.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "annotate/lettering.h"

namespace ovoid::annotate {
namespace font_test {

// Least and greatest x of a glyph's ink.
std::pair<double, double> ink_of(const Glyph& glyph) {
  double lo = 1e9;
  double hi = -1e9;
  for (const auto& way : glyph.strokes) {
    for (const Vec2& p : way) {
      lo = std::min(lo, p.x());
      hi = std::max(hi, p.x());
    }
  }
  return {lo, hi};
}

// Fails if a character is missing, empty, off the line or reaches into its neighbours.
TEST(Font, EveryPrintableCharacterHasAGlyphWithinItsLine) {
  for (char32_t c = U' '; c <= U'~'; ++c) {
    SCOPED_TRACE(static_cast<int>(c));
    ASSERT_TRUE(has_glyph(c));
    const Glyph& glyph = glyph_of(c);
    EXPECT_GT(glyph.advance, 2);
    EXPECT_LT(glyph.advance, 14);
    EXPECT_EQ(glyph.strokes.empty(), c == U' ');
    if (c == U' ') continue;
    const auto [lo, hi] = ink_of(glyph);
    EXPECT_GE(lo, -0.6);
    EXPECT_LE(hi, glyph.advance - 2);
    for (const auto& way : glyph.strokes) {
      EXPECT_FALSE(way.empty());
      for (const Vec2& p : way) {
        EXPECT_GE(p.y(), kDescender - 0.1);
        EXPECT_LE(p.y(), 12);
      }
    }
  }
}

TEST(Font, UnitsHaveGlyphsAndOthersABox) {
  for (const char32_t c :
       U"\u00B5\u03BC\u00B0\u00B9\u00B2\u00B3\u00B7\u00D7\u00B1\u2212\u00C5\u212B\u207B\u2026") {
    EXPECT_TRUE(c == 0 || has_glyph(c)) << static_cast<int>(c);
  }
  EXPECT_FALSE(has_glyph(U'\u4E2D'));
  EXPECT_EQ(glyph_of(U'\u4E2D').strokes.size(), 1U);
  EXPECT_EQ(&glyph_of(U'\u4E2D'), &glyph_of(U'\n'));
}

// Numbers stand in columns.
TEST(Font, DigitsHaveOneWidth) {
  for (char32_t c = U'0'; c <= U'9'; ++c) EXPECT_EQ(glyph_of(c).advance, glyph_of(U'0').advance);
}

TEST(Font, DecodesUtf8) {
  EXPECT_EQ(decode_utf8("a\u00B5\u2026\U0001F600z", 99), U"a\u00B5\u2026\U0001F600z");
  EXPECT_EQ(decode_utf8("abcdef", 3), U"abc");
  EXPECT_EQ(decode_utf8("", 3), U"");
}

// Cut off, overlong, surrogates, too great, lone: every bad byte is one replacement and no byte
// is read beyond the end.
TEST(Font, BadBytesBecomeReplacements) {
  const char32_t bad = U'\uFFFD';
  EXPECT_EQ(decode_utf8("\xC2", 9), std::u32string(1, bad));
  EXPECT_EQ(decode_utf8("\xE2\x80", 9), std::u32string(2, bad));
  EXPECT_EQ(decode_utf8("\xC0\x80", 9), std::u32string(2, bad));
  EXPECT_EQ(decode_utf8("\xE0\x80\x80", 9), std::u32string(3, bad));
  EXPECT_EQ(decode_utf8("\xED\xA0\x80", 9), std::u32string(3, bad));
  EXPECT_EQ(decode_utf8("\xF4\x90\x80\x80", 9), std::u32string(4, bad));
  EXPECT_EQ(decode_utf8("\xFF"
                        "a\x80"
                        "b",
                        9),
            std::u32string({bad, U'a', bad, U'b'}));
}

TEST(Lettering, WidthsAddUpAndGrowWithTheSize) {
  const double a = Lettering("0", 20).width();
  EXPECT_GT(a, 6);
  EXPECT_GT(Lettering("00", 20).width(), 2 * a);
  EXPECT_GT(Lettering("0", 40).width(), 1.8 * a);
  EXPECT_EQ(Lettering("", 20).width(), 0);
  EXPECT_EQ(Lettering("0", 20).cap_height(), 14);
}

TEST(Lettering, ShortenEndsInAnEllipsisThatFits) {
  Lettering text("a name that is far too long", 20);
  text.shorten(100);
  EXPECT_LE(text.width(), 100);
  EXPECT_GT(text.width(), 70);
  Lettering narrow("name", 20);
  narrow.shorten(0);  // an ellipsis is the least
  EXPECT_GT(narrow.width(), 0);
  Lettering fits("name", 20);
  const double before = fits.width();
  fits.shorten(before);
  EXPECT_EQ(fits.width(), before);
  EXPECT_EQ(Lettering(std::string(5000, 'x'), 20).width(),
            Lettering(std::string(Lettering::kMost, 'x'), 20).width());
}

}  // namespace font_test
}  // namespace ovoid::annotate
