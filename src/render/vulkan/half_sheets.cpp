// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/half_sheets.h"

#include <algorithm>
#include <cmath>

#include "render/shared/look_values.h"
#include "view/look/look_variation.h"

namespace ovoid::vulkan {
namespace {

// The magnitude of a sum's range as a half float: values have all of their bits down to 2^-22 of
// it, and up to 255 times as much fits, for the range is that of samples of the field.
constexpr float kTopOfRange = 256;
constexpr float kLeastNormalHalf = 0x1p-14F;

float magnitude_of(const ValueRange& range) {
  return std::max(std::abs(range.lo), std::abs(range.hi));
}

// Whether a table's colours or opacities change over the error of a value by more than may be.
// Entries are a cell apart, between which the look is straight.
bool is_too_steep(const view::LookTable& table, double path_in_units, const KernelField& field) {
  if (table.has_steps()) return true;
  const std::vector<float> entries = classification_entries(table, path_in_units);
  const auto premultiplied = [&](int entry, int channel) {
    const float* of = entries.data() + static_cast<std::size_t>(4 * entry);
    return static_cast<double>(channel == 3 ? of[3] : of[3] * of[channel]);
  };
  for (int i = 0; i < view::LookTable::kCells; ++i) {
    const double lo = table.axis().value_of_entry(i);
    const double hi = table.axis().value_of_entry(i + 1);
    const double error =
        std::max(half_sheet_error(lo, field.value_range(), field.reconstruction()),
                 half_sheet_error(hi, field.value_range(), field.reconstruction()));
    for (int channel = 0; channel < 4; ++channel) {
      const double change = std::abs(premultiplied(i + 1, channel) - premultiplied(i, channel));
      if (!(change * error <= kMostHalfSheetChange * (hi - lo))) return true;
    }
  }
  return false;
}

}  // namespace

// Filters overshoot: normalized fields have an eighth of their range to spare.
SheetRange sheet_range(const ValueRange& range, Reconstruction reconstruction) {
  if (reconstruction == Reconstruction::kSum) {
    const float magnitude = magnitude_of(range);
    return {magnitude > 0 ? kTopOfRange / magnitude : 1.0F, 0.0F};
  }
  const float width = range.hi - range.lo;
  if (!(width > 0)) return {1.0F, range.lo - 0.5F};
  return {0.8F / width, range.lo - 0.125F * width};
}

double half_sheet_error(double value, const ValueRange& range, Reconstruction reconstruction) {
  const SheetRange sheets = sheet_range(range, reconstruction);
  if (reconstruction == Reconstruction::kNormalized) return 0.5 / 65534 / sheets.scale;
  return 0x1p-11 * std::max(std::abs(value), static_cast<double>(kLeastNormalHalf / sheets.scale));
}

std::string why_not_half_sheets(const KernelField& field, const view::FramePlan& plan,
                                const Look& look) {
  const bool is_composite = look.mode == Mode::kComposite;
  if (look.mode == Mode::kIsosurface) return "a surface is or is not between two samples";
  if (is_composite && (look.shade || plan.is_faded))
    return "light and opacity by the gradient take differences of samples";
  if (look.mode == Mode::kXray) return {};
  // Only composited opacities are over a path.
  const double path = is_composite ? plan.lattice.sampling_distance() / plan.unit_distance : 1.0;
  // A piece in twice as many steps may be other than by an error of its values.
  if (is_composite && plan.is_refined &&
      view::look_variation(plan.look_table, path).back() > 1 / view::kStepsPerVariation)
    return "the values at its ends decide in how many steps a piece is classified";
  const bool is_steep = is_too_steep(plan.look_table, path, field);
  return is_steep ? "the look changes too much from one value of 16 bits to the next" : "";
}

}  // namespace ovoid::vulkan
