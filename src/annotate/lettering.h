// SPDX-License-Identifier: Apache-2.0
// Lines of text, and the sizes that all marks of a picture share.
#pragma once

#include <string>
#include <string_view>

#include "annotate/ink.h"

namespace ovoid::annotate {

// Sizes and colours of the marks of one picture, pixels.
struct Measures {
  double text;  // height of a line
  double pen;   // of lines and ticks
  double halo;  // how far it reaches
  Paint paint;
};

// Throws Error(kInvalidArgument) if the image's sizes do not fit together or the style is out of
// its range.
Measures measures_of(const Image& image, const MarkStyle& style);

// A line of text at one size. Its letters stand on whole pixels, and baseline, x-height and
// capitals are rounded to pixels, so that small text is crisp.
class Lettering {
 public:
  Lettering(std::string_view text, double size_px);  // at most kMost characters are kept

  double width() const noexcept { return width_; }  // pixels, from ink to ink
  double cap_height() const noexcept;               // pixels, whole

  // At most `width_px` wide; what is cut off becomes an ellipsis.
  void shorten(double width_px);

  // `left`: of the ink; `baseline`: both pixels.
  void write(Ink& ink, double left, double baseline) const;
  // `align` 0: `at` is the left end, 0.5 the middle, 1 the right end; the capitals' middle is at
  // at.y.
  void write_at(Ink& ink, const Vec2& at, double align) const;

  static constexpr std::size_t kMost = 200;

 private:
  double advance(char32_t character) const;
  double height(double units) const;  // pixels above the baseline, the font's lines rounded
  void measure();

  std::u32string text_;
  double size_;
  double unit_;  // pixels per font unit
  double width_ = 0;
};

}  // namespace ovoid::annotate
