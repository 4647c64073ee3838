// SPDX-License-Identifier: Apache-2.0
#include "io/pictures/palette.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "io/core/atomic_file.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kAllColors = std::size_t{1} << 24;
constexpr std::size_t kColorsEach = std::size_t{1} << 20;  // between two looks at a stop token

struct CountedColor {
  Rgb8 color;
  std::uint32_t count;
};

// Colours summed by their counts.
struct ColorSum {
  double count = 0;
  std::array<double, 3> sum{};

  void add(const Rgb8& color, double times) {
    count += times;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += times * color[c];
  }
  void add(const ColorSum& other) {
    count += other.count;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += other.sum[c];
  }
  Rgb8 mean() const {
    Rgb8 color{};
    for (std::size_t c = 0; c < 3; ++c)
      color[c] = static_cast<std::uint8_t>(std::lround(sum[c] / count));
    return color;
  }
};

// By how much the squared distances to the means fall where `lower` and the rest of `all` get means
// of their own.
double gain_of(const ColorSum& lower, const ColorSum& all) {
  const double rest = all.count - lower.count;
  if (lower.count <= 0 || rest <= 0) return 0;
  double squared = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double between = lower.sum[c] / lower.count - (all.sum[c] - lower.sum[c]) / rest;
    squared += between * between;
  }
  return squared * lower.count * rest / all.count;
}

// Some of the colours, and where they are best parted: below or at `at` of channel `axis`, or not.
struct Part {
  std::span<CountedColor> colors;
  ColorSum all;
  double gain = 0;
  std::size_t axis = 0;
  int at = 0;
};

Part part_of(std::span<CountedColor> colors, const std::stop_token& stop) {
  Part part;
  part.colors = colors;
  std::array<std::array<ColorSum, 256>, 3> by_value{};
  for (std::size_t i = 0; i < colors.size(); ++i) {
    if (i % kColorsEach == 0) check_stop(stop);
    const CountedColor& entry = colors[i];
    part.all.add(entry.color, entry.count);
    for (std::size_t axis = 0; axis < 3; ++axis)
      by_value[axis][entry.color[axis]].add(entry.color, entry.count);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ColorSum lower;
    for (int at = 0; at < 255; ++at) {
      lower.add(by_value[axis][static_cast<std::size_t>(at)]);
      const double gain = gain_of(lower, part.all);
      if (gain <= part.gain) continue;
      part.gain = gain;
      part.axis = axis;
      part.at = at;
    }
  }
  return part;
}

int squared_distance(const Rgb8& a, const Rgb8& b) {
  int sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

constexpr int kSide = 8;  // of the pattern
constexpr int kShares = kSide * kSide;

// Bayer's: each of 0 to 63 once, neighbours far from each other. The bits of x ^ y and y, from the
// lowest on, become the highest.
constexpr std::uint8_t threshold_at(int x, int y) {
  int value = 0;
  for (int bit = 0; bit < 3; ++bit)
    value = value << 2 | (((x ^ y) >> bit) & 1) << 1 | ((y >> bit) & 1);
  return static_cast<std::uint8_t>(value);
}

constexpr std::size_t index_of(int x, int y) {
  return static_cast<std::size_t>(y % kSide) * kSide + static_cast<std::size_t>(x % kSide);
}

constexpr std::array<std::uint8_t, kShares> kThresholds = [] {
  std::array<std::uint8_t, kShares> all{};
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) all[index_of(x, y)] = threshold_at(x, y);
  }
  return all;
}();

std::uint32_t packed(const Rgb8& color) {
  return static_cast<std::uint32_t>(color[0]) << 16U | static_cast<std::uint32_t>(color[1]) << 8U |
         color[2];
}

}  // namespace

ColorCounts::ColorCounts() : counts_(kAllColors, 0) {}

void ColorCounts::add(std::span<const std::uint8_t> rgba8) {
  for (std::size_t i = 0; i + 3 < rgba8.size(); i += 4) {
    if (rgba8[i + 3] < kLeastOpaque) {
      has_clear_ = true;
      continue;
    }
    std::uint32_t& count = counts_[packed({rgba8[i], rgba8[i + 1], rgba8[i + 2]})];
    if (count < std::numeric_limits<std::uint32_t>::max()) ++count;
  }
}

std::vector<Rgb8> ColorCounts::palette(std::size_t most, const std::stop_token& stop) const {
  std::vector<CountedColor> colors;
  for (std::size_t i = 0; i < kAllColors; ++i) {
    if (i % kColorsEach == 0) check_stop(stop);
    if (counts_[i] == 0) continue;
    colors.push_back({{static_cast<std::uint8_t>(i >> 16U), static_cast<std::uint8_t>(i >> 8U),
                       static_cast<std::uint8_t>(i)},
                      counts_[i]});
  }
  if (colors.empty()) return {Rgb8{}};
  std::vector<Part> parts{part_of(colors, stop)};
  while (parts.size() < most) {
    check_stop(stop);
    const auto worst = std::max_element(
        parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.gain < b.gain; });
    if (worst->gain <= 0) break;
    const std::span<CountedColor> whole = worst->colors;
    const auto middle =
        std::partition(whole.begin(), whole.end(),
                       [axis = worst->axis, at = worst->at](const CountedColor& entry) {
                         return entry.color[axis] <= at;
                       });
    const auto num_lower = static_cast<std::size_t>(middle - whole.begin());
    *worst = part_of(whole.first(num_lower), stop);
    parts.push_back(part_of(whole.subspan(num_lower), stop));
  }
  std::vector<Rgb8> palette;
  palette.reserve(parts.size());
  for (const Part& part : parts) palette.push_back(part.all.mean());
  return palette;
}

PaletteMatcher::PaletteMatcher(std::vector<Rgb8> palette)
    : palette_(std::move(palette)), known_(std::size_t{1} << 16) {}

// The nearest colour p, and the colour q with which it mixes best: with a share t of q the mean is
// wrong by |c - p - t (q - p)|^2, and the pattern shows by its variance t (1 - t) |q - p|^2, of
// which the eye, seeing several pixels as one, takes a part.
PaletteMatcher::Mixture PaletteMatcher::mixture_of(const Rgb8& color) const {
  // Found by looking at turbo over white and at glow over black: with 0.1 single dots catch the
  // eye, with 1 there are rings, as without mixing.
  constexpr double kSeenOfPattern = 0.25;
  Mixture best;
  best.color = packed(color);
  int least = std::numeric_limits<int>::max();
  for (std::size_t i = 0; i < palette_.size(); ++i) {
    const int distance = squared_distance(color, palette_[i]);
    if (distance >= least) continue;
    least = distance;
    best.near = static_cast<std::uint8_t>(i);
  }
  best.far = best.near;
  const Rgb8& near = palette_[best.near];
  double least_error = least;
  for (std::size_t i = 0; i < palette_.size() && least > 0; ++i) {
    const double apart = squared_distance(near, palette_[i]);
    if (apart == 0) continue;
    double along = 0;
    for (std::size_t c = 0; c < 3; ++c) along += (color[c] - near[c]) * (palette_[i][c] - near[c]);
    const double share = std::round(std::clamp(along / apart, 0.0, 0.5) * kShares) / kShares;
    const double mean_error = least - 2 * share * along + share * share * apart;
    const double error = mean_error + kSeenOfPattern * share * (1 - share) * apart;
    if (error >= least_error) continue;
    least_error = error;
    best.far = static_cast<std::uint8_t>(i);
    best.share = static_cast<std::uint8_t>(std::lround(share * kShares));
  }
  return best;
}

std::uint8_t PaletteMatcher::index(const Rgb8& color, int x, int y) {
  // Fibonacci hashing: the upper bits of a product with 2^32 / golden ratio.
  Mixture& mixture = known_[packed(color) * 2654435769U >> 16U];
  if (mixture.color != packed(color)) mixture = mixture_of(color);
  const std::uint8_t threshold = kThresholds[index_of(x, y)];
  return mixture.share > threshold ? mixture.far : mixture.near;
}

}  // namespace ovoid::io
