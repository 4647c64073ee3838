// SPDX-License-Identifier: Apache-2.0
// The few colours of a film that stand for all of its colours.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

namespace ovoid::io {

using Rgb8 = std::array<std::uint8_t, 3>;

// A picture of 8 bits either shows the background at a pixel or does not: from this alpha on it
// does not.
inline constexpr std::uint8_t kLeastOpaque = 128;

// How often each colour of 24 bits occurs in a film. 64 MiB, however long the film is.
class ColorCounts {
 public:
  ColorCounts();
  // Counts a picture's pixels. `rgba8`: [height, width, 4], straight alpha.
  void add(std::span<const std::uint8_t> rgba8);
  // Whether any pixel was less opaque than kLeastOpaque; those have no colour.
  bool has_clear() const noexcept { return has_clear_; }

  // At most `most` colours, chosen by parting all colours where the squared distances to the parts'
  // means fall most (the criterion of [Wu 1991]), again and again. Where there are no more than
  // `most` colours it is these. Throws Error(kCancelled). Cost: some ten looks at each different
  // colour.
  std::vector<Rgb8> palette(std::size_t most, const std::stop_token& stop = {}) const;

 private:
  std::vector<std::uint32_t> counts_;  // by 65536 r + 256 g + b
  bool has_clear_ = false;
};

// Says which colour of a palette stands for a pixel. Between two of them the pixels of a fixed
// pattern are mixed (ordered dithering, [Bayer 1973]): the pattern stands still from frame to
// frame, and a colour that the palette has is not mixed.
class PaletteMatcher {
 public:
  explicit PaletteMatcher(std::vector<Rgb8> palette);  // 1 to 256 colours
  std::uint8_t index(const Rgb8& color, int x, int y);

 private:
  struct Mixture {
    std::uint32_t color = ~0U;  // 0xRRGGBB; else: none yet
    std::uint8_t near = 0, far = 0;
    std::uint8_t share = 0;  // of `far`, in 64ths, up to a half
  };
  Mixture mixture_of(const Rgb8& color) const;

  std::vector<Rgb8> palette_;
  std::vector<Mixture> known_;  // the last of each hash
};

}  // namespace ovoid::io
