// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/shade/look_segments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/shared/device_layout.h"
#include "render/shared/look_values.h"
#include "view/look/look_variation.h"

namespace ovoid::cpu {
namespace look_segments_test {

constexpr int kEntries = device::kTableCells + 1;

struct Tables {
  explicit Tables(const TransferFunction& transfer)
      : table(transfer),
        entries(classification_entries(table, 1.0)),
        variation(view::look_variation(table, 0.5)) {}
  view::LookTable table;
  std::vector<float> entries, variation;
};

TransferFunction ramp_between_zeros() {
  TransferFunction transfer;
  transfer.colors = {{0, {0, 0.2, 1}}, {0.3, {1, 0, 0}}, {1, {1, 1, 0.5}}};
  transfer.opacities = {{0.1, 0}, {0.4, 0.8}, {0.5, 0}, {0.6, 0}, {0.9, 0.05}};
  return transfer;
}

int segment_at(const Segments& segments, int entry) {
  int s = 0;
  while (s + 1 < segments.count && segments.first[s + 1] <= static_cast<float>(entry)) ++s;
  return s;
}

float at(const ColorSegments& segments, int number, int entry) {
  const int s = segment_at(segments, entry);
  return segments.base[number][s] + segments.slope[number][s] * static_cast<float>(entry);
}

float variation_at(const VariationSegments& segments, int entry) {
  const int s = segment_at(segments, entry);
  const auto p = static_cast<float>(entry);
  return (segments.terms[2][s] * p + segments.terms[1][s]) * p + segments.terms[0][s];
}

// Fails if a segment strays from the table, or shows something where the look shows nothing.
void expect_near_table(const TransferFunction& transfer, bool has_logarithms) {
  const Tables tables(transfer);
  const ColorSegments colors = color_segments(tables.entries.data());
  const VariationSegments variation =
      variation_segments(tables.entries.data(), tables.variation.data());
  ASSERT_GT(colors.count, 0);
  ASSERT_GT(variation.count, 0);
  ASSERT_EQ(colors.has_logarithms, has_logarithms);
  for (int i = 0; i < kEntries; ++i) {
    const float* const entry = tables.entries.data() + static_cast<std::ptrdiff_t>(4) * i;
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(at(colors, c, i), entry[c], kSegmentColorError + 1e-5) << i;
    const auto opacity = static_cast<double>(entry[3]);
    const double expected = has_logarithms ? std::log2(1 - opacity) : opacity;
    ASSERT_NEAR(at(colors, 3, i), expected,
                kSegmentOpacityError + kSegmentRelativeOpacityError * std::abs(expected) + 1e-6)
        << i;
    ASSERT_NEAR(variation_at(variation, i), tables.variation[static_cast<std::size_t>(i)],
                kSegmentVariationError + 1e-5);
    // The end of a slope is a segment's last entry: nothing is left but rounding.
    const bool is_within_nothing =
        i > 0 && i + 1 < kEntries && entry[-1] == 0.0F && entry[3] == 0.0F && entry[7] == 0.0F;
    if (is_within_nothing) {
      ASSERT_EQ(at(colors, 3, i), 0) << i;
      ASSERT_EQ(variation.shows[segment_at(variation, i)], 0) << i;
    } else if (entry[3] != 0.0F) {
      ASSERT_EQ(variation.shows[segment_at(variation, i)], 1) << i;
    }
  }
}

TEST(LookSegments, AreNearTheTable) { expect_near_table(ramp_between_zeros(), false); }

TEST(LookSegments, OfLittleOpacityAreLogarithms) {
  TransferFunction transfer = ramp_between_zeros();
  transfer.opacities = {{0.1, 0}, {1, 0.08}};
  expect_near_table(transfer, true);
}

TEST(LookSegments, AreNotForLooksOfManyColors) {
  TransferFunction transfer = ramp_between_zeros();
  transfer.colors.clear();
  for (int i = 0; i <= 40; ++i) {
    const double on = i % 2;
    transfer.colors.push_back({i / 40.0, {on, 1 - on, 0}});
  }
  EXPECT_EQ(color_segments(Tables(transfer).entries.data()).count, 0);
}

}  // namespace look_segments_test
}  // namespace ovoid::cpu
