// SPDX-License-Identifier: Apache-2.0
#include "view/look/look_2d.h"

#include <algorithm>
#include <cmath>

#include "view/look/look_variation.h"

namespace ovoid::view {
namespace {

using Axis = TransferFunction2D::Axis;
using Rgba = TransferFunction2D::Rgba;

double place_on(const Axis& axis, double x) {
  return std::clamp((x - axis.first) / (axis.last - axis.first), 0.0, 1.0) * (axis.count - 1);
}

double read_along(const std::vector<double>& sums, double place) {
  const auto entry = std::min(static_cast<std::size_t>(place), sums.size() - 2);
  return std::lerp(sums[entry], sums[entry + 1], place - static_cast<double>(entry));
}

// As look_variation() counts, opacities corrected for their path.
float change_between(const Rgba& a, const Rgba& b) {
  const float color = std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
  return std::abs(a[3] - b[3]) + static_cast<float>(kColorVariation) * 0.5F * (a[3] + b[3]) * color;
}

// The greatest change from one line of entries to the next, summed up. `stride` from line to line.
struct Lines {
  int count, length;
  std::size_t stride, along;
};

std::vector<double> summed_changes(const std::vector<Rgba>& entries, const Lines& lines) {
  std::vector<double> sums(static_cast<std::size_t>(lines.count));
  for (int i = 1; i < lines.count; ++i) {
    const Rgba* const line = &entries[static_cast<std::size_t>(i) * lines.stride];
    float greatest = 0;
    for (int k = 0; k < lines.length; ++k) {
      const Rgba* const entry = line + static_cast<std::size_t>(k) * lines.along;
      greatest = std::max(greatest, change_between(*(entry - lines.stride), *entry));
    }
    sums[static_cast<std::size_t>(i)] =
        sums[static_cast<std::size_t>(i) - 1] + static_cast<double>(greatest);
  }
  return sums;
}

}  // namespace

TransferFunction envelope_of(const TransferFunction2D& function, const TransferFunction& of) {
  TransferFunction envelope;
  envelope.name = of.name;
  envelope.unit_distance = of.unit_distance;
  envelope.nan_color = of.nan_color;
  const Axis& values = function.values();
  for (int i = 0; i < values.count; ++i) {
    Rgba greatest{};
    for (int j = 0; j < function.gradients().count; ++j) {
      const Rgba& entry =
          function.entries()[static_cast<std::size_t>(j) * static_cast<std::size_t>(values.count) +
                             static_cast<std::size_t>(i)];
      if (j == 0 || entry[3] > greatest[3]) greatest = entry;
    }
    const double x =
        std::lerp(values.first, values.last, static_cast<double>(i) / (values.count - 1));
    envelope.colors.push_back({x, {greatest[0], greatest[1], greatest[2]}});
    envelope.opacities.push_back({x, greatest[3]});
  }
  return envelope;
}

Look with_envelope(Look look) {
  if (look.transfer_function_2d)
    look.transfer_function = envelope_of(*look.transfer_function_2d, look.transfer_function);
  return look;
}

Variation2D variation_of(const TransferFunction2D& function, const LookTable& envelope,
                         double path_in_units) {
  std::vector<Rgba> entries(function.entries().begin(), function.entries().end());
  const auto path = static_cast<float>(path_in_units);
  for (Rgba& entry : entries) {
    if (entry[3] > 0 && entry[3] < 1) entry[3] = 1 - std::pow(1 - entry[3], path);
  }
  const Axis& values = function.values();
  const Axis& gradients = function.gradients();
  const auto columns = static_cast<std::size_t>(values.count);
  const std::vector<double> along_value =
      summed_changes(entries, {values.count, gradients.count, 1, columns});
  const std::vector<double> along_gradient =
      summed_changes(entries, {gradients.count, values.count, columns, 1});
  Variation2D out;
  out.by_value.resize(LookTable::kPaddedEntries);
  for (int i = 0; i < LookTable::kPaddedEntries; ++i) {
    const double value = envelope.axis().value_of_entry(std::min(i, LookTable::kCells));
    out.by_value[static_cast<std::size_t>(i)] =
        static_cast<float>(read_along(along_value, place_on(values, value)));
  }
  out.by_gradient.assign(along_gradient.begin(), along_gradient.end());
  return out;
}

double variation_at(const std::vector<float>& by_gradient, const Axis& gradients, double gradient) {
  const double place = place_on(gradients, gradient);
  const auto entry = std::min(static_cast<std::size_t>(place), by_gradient.size() - 2);
  return std::lerp<double>(by_gradient[entry], by_gradient[entry + 1],
                           place - static_cast<double>(entry));
}

}  // namespace ovoid::view
