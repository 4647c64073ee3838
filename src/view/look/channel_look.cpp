// SPDX-License-Identifier: Apache-2.0
// Looks of channels: docs/two-volumes.md says what they come to.
#include <algorithm>
#include <array>

#include "data/field_samples.h"
#include "ovoid/channels.h"

namespace ovoid {
namespace {

// Over a sample, where a channel is as bright as it gets: what lies behind shows, too.
constexpr double kMostOfComposite = 0.2;

}  // namespace

ValueRange channel_range(const LatticeField& field) {
  const data::FieldSamples samples = data::take_samples(field.samples());
  if (samples.values.empty()) return {0, 1};
  // Most of a stained volume is unstained, and its camera's noise lies around that.
  const auto quantile = [&](double q) {
    return static_cast<float>(data::quantile(samples.values, q));
  };
  const float middle = quantile(0.5);
  const float hi = quantile(0.999);
  const float lo = middle + 2 * (middle - quantile(0.05));
  if (lo < hi) return {lo, hi};
  if (middle < hi) return {middle, hi};
  return field.value_range();
}

std::vector<Rgb> channel_colors(std::size_t count) {
  static constexpr std::array<Rgb, 4> kOfSome{Rgb{0, 1, 0}, Rgb{1, 0, 1}, Rgb{0, 0.6, 1},
                                              Rgb{1, 0.8, 0}};
  if (count <= 1) return std::vector<Rgb>(count, Rgb{1, 1, 1});
  return {kOfSome.begin(),
          kOfSome.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(count, 4))};
}

Look channel_look(const ValueRange& range, const Rgb& color, Mode mode) {
  Look look;
  look.mode = mode;
  const double hi = range.lo < range.hi ? range.hi : range.lo + 1;
  look.transfer_function.colors = {{range.lo, color}, {hi, color}};
  look.transfer_function.opacities = {{range.lo, 0},
                                      {hi, mode == Mode::kComposite ? kMostOfComposite : 1.0}};
  return look;
}

Look primary_look(const ValueRange& range, int primary) {
  Look look;
  Rgb color{0, 0, 0};
  color.at(static_cast<std::size_t>(primary)) = 1;
  const double hi = range.lo < range.hi ? range.hi : range.lo + 1;
  look.transfer_function.colors = {{range.lo, {0, 0, 0}}, {hi, color}};
  look.transfer_function.opacities = {{range.lo, 1}, {hi, 1}};
  look.shade = false;  // the volume that they colour is lit
  return look;
}

}  // namespace ovoid
