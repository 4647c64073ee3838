// SPDX-License-Identifier: Apache-2.0
#include "view/look/look_variation.h"

#include <cmath>

namespace ovoid::view {

std::vector<float> look_variation(const LookTable& table, double path_in_units) {
  std::vector<float> entries(LookTable::kPaddedEntries);
  const auto opacity_at = [&](int i) {
    return 1.0 - std::pow(1.0 - static_cast<double>(table.opacity()[i]), path_in_units);
  };
  const auto change = [](const float* x, int i) {
    return std::abs(static_cast<double>(x[i]) - static_cast<double>(x[i - 1]));
  };
  double sum = 0;
  double before = opacity_at(0);
  for (int i = 1; i < LookTable::kPaddedEntries; ++i) {
    if (i < LookTable::kEntries) {
      const double here = opacity_at(i);
      const double color =
          change(table.red(), i) + change(table.green(), i) + change(table.blue(), i);
      sum += std::abs(here - before) + kColorVariation * 0.5 * (here + before) * color;
      before = here;
    }
    entries[static_cast<std::size_t>(i)] = static_cast<float>(sum);
  }
  return entries;
}

}  // namespace ovoid::view
