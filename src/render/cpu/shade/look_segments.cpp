// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/shade/look_segments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "render/shared/device_layout.h"

namespace ovoid::cpu {
namespace {

constexpr std::size_t kEntries = device::kTableCells + 1;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Straight logarithms of opacities are as good as straight opacities up to this.
constexpr double kMostOfLogarithms = 0.5;

using Numbers = std::array<double, 4>;

struct Entry {
  Numbers value;
  Numbers error;    // that is allowed
  bool is_nothing;  // no opacity: nor has what stands for it
};

// The slopes of a line from a segment's first entry that are near enough to all entries so far.
class SlopeRange {
 public:
  SlopeRange() {
    lo_.fill(-kInfinity);
    hi_.fill(kInfinity);
  }

  // Another entry, `cells` behind the first. Leaves the range as it was, and returns false, if no
  // line is near enough to it, too.
  bool narrow(const Entry& first, const Entry& entry, double cells) {
    // What begins at nothing stays nothing, but for a single cell.
    if (first.is_nothing && !entry.is_nothing && cells > 1) return false;
    Numbers lo = lo_;
    Numbers hi = hi_;
    for (std::size_t c = 0; c < lo.size(); ++c) {
      const double rise = entry.value[c] - first.value[c];
      lo[c] = std::max(lo[c], (rise - entry.error[c]) / cells);
      hi[c] = std::min(hi[c], (rise + entry.error[c]) / cells);
      if (lo[c] > hi[c]) return false;
    }
    lo_ = lo;
    hi_ = hi;
    return true;
  }

  double middle(std::size_t number) const { return 0.5 * (lo_[number] + hi_[number]); }

 private:
  Numbers lo_, hi_;
};

// Of an opacity or its logarithm.
double error_of(double value) {
  return value == 0 ? 0.0 : kSegmentOpacityError + kSegmentRelativeOpacityError * std::abs(value);
}

ColorSegments segments_of(const std::vector<Entry>& entries) {
  ColorSegments segments;
  std::fill_n(segments.first, Segments::kMost, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i + 1 < entries.size();) {
    if (segments.count == Segments::kMost) return {};
    const Entry& first = entries[i];
    SlopeRange slopes;
    std::size_t end = i + 1;
    while (end < entries.size() && slopes.narrow(first, entries[end], static_cast<double>(end - i)))
      ++end;
    const int s = segments.count++;
    // The first reaches backwards without end.
    segments.first[s] = s == 0 ? -std::numeric_limits<float>::infinity() : static_cast<float>(i);
    for (std::size_t c = 0; c < first.value.size(); ++c) {
      const double slope = slopes.middle(c);
      segments.slope[c][s] = static_cast<float>(slope);
      segments.base[c][s] = static_cast<float>(first.value[c] - slope * static_cast<double>(i));
    }
    i = end - 1;
  }
  return segments;
}

// The parabola through three entries of a table.
class Parabola {
 public:
  Parabola(const float* numbers, std::size_t begin, std::size_t end) : begin_(begin) {
    const auto length = static_cast<double>(end - begin);
    const std::size_t half = (end - begin) / 2;
    const auto middle = static_cast<double>(half);
    const double rise = number(numbers, end) - number(numbers, begin);
    origin_ = number(numbers, begin);
    if (half == 0) {
      slope_ = rise / length;
      return;
    }
    const double rise_to_middle = number(numbers, begin + half) - origin_;
    curve_ = (rise / length - rise_to_middle / middle) / (length - middle);
    slope_ = rise / length - curve_ * length;
  }

  double at(std::size_t i) const {
    const auto x = static_cast<double>(i - begin_);
    return origin_ + (slope_ + curve_ * x) * x;
  }
  // Of the place itself, from entry 0.
  std::array<double, 3> terms() const {
    const auto x = static_cast<double>(begin_);
    return {origin_ - (slope_ - curve_ * x) * x, slope_ - 2 * curve_ * x, curve_};
  }

  static double number(const float* numbers, std::size_t i) {
    return static_cast<double>(numbers[i]);
  }

 private:
  std::size_t begin_;
  double origin_, slope_, curve_ = 0;
};

// True if a segment from entry `begin` to `end` is near enough to all entries between, and either
// nothing or all of it shows.
bool is_one_segment(const float* entries, const float* variation, std::size_t begin,
                    std::size_t end) {
  const auto shows = [&](std::size_t i) { return entries[4 * i + 3] != 0.0F; };
  const Parabola parabola(variation, begin, end);
  for (std::size_t i = begin; i <= end; ++i) {
    if (end - begin > 1 && shows(i) != shows(begin)) return false;
    if (std::abs(parabola.at(i) - Parabola::number(variation, i)) > kSegmentVariationError)
      return false;
  }
  return true;
}

// The farthest end of a segment from `begin` on: found by doubling, then halving steps.
std::size_t end_of_segment(const float* entries, const float* variation, std::size_t begin) {
  std::size_t end = begin + 1;
  std::size_t step = 1;
  const auto try_step = [&] {
    if (end + step >= kEntries || !is_one_segment(entries, variation, begin, end + step))
      return false;
    end += step;
    return true;
  };
  while (try_step()) step *= 2;
  for (; step > 0; step /= 2) try_step();
  return end;
}

}  // namespace

ColorSegments color_segments(const float* entries) {
  std::vector<Entry> all(kEntries);
  float most = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const float* const entry = entries + 4 * i;
    most = std::max(most, entry[3]);
    const auto opacity = static_cast<double>(entry[3]);
    all[i] = {{entry[0], entry[1], entry[2], opacity},
              {kSegmentColorError, kSegmentColorError, kSegmentColorError, error_of(opacity)},
              opacity == 0};
  }
  if (most <= kMostOfLogarithms) {
    std::vector<Entry> logarithms = all;
    for (Entry& entry : logarithms) {
      if (entry.is_nothing) continue;
      entry.value[3] = std::log2(1 - entry.value[3]);
      entry.error[3] = error_of(entry.value[3]);
    }
    ColorSegments segments = segments_of(logarithms);
    segments.has_logarithms = true;
    if (segments.count > 0) return segments;
  }
  return segments_of(all);
}

VariationSegments variation_segments(const float* entries, const float* variation) {
  VariationSegments segments;
  std::fill_n(segments.first, Segments::kMost, std::numeric_limits<float>::infinity());
  for (std::size_t begin = 0; begin + 1 < kEntries;) {
    if (segments.count == Segments::kMost) return {};
    const std::size_t end = end_of_segment(entries, variation, begin);
    const int s = segments.count++;
    segments.first[s] =
        s == 0 ? -std::numeric_limits<float>::infinity() : static_cast<float>(begin);
    const std::array<double, 3> terms = Parabola(variation, begin, end).terms();
    for (std::size_t i = 0; i < terms.size(); ++i)
      segments.terms[i][s] = static_cast<float>(terms[i]);
    segments.shows[s] =
        entries[4 * begin + 3] == 0.0F && entries[4 * end + 3] == 0.0F ? 0.0F : 1.0F;
    begin = end;
  }
  return segments;
}

}  // namespace ovoid::cpu
