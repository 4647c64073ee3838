// SPDX-License-Identifier: Apache-2.0
#include "render/shared/look_nodes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace ovoid {
namespace {

// What IntegralNodes integrate, at node i.
std::array<double, 4> integrand_at(const view::LookTable& table, int i) {
  const double opacity = table.opacity()[i];
  const double extinction =
      opacity < 1.0 ? std::min(-std::log1p(-opacity), kGreatestExtinction) : kGreatestExtinction;
  return {extinction * table.red()[i], extinction * table.green()[i], extinction * table.blue()[i],
          extinction};
}

}  // namespace

std::vector<float> classification_nodes(const view::LookTable& table, double path_in_units) {
  std::vector<float> nodes(std::size_t{4} * view::LookTable::kPaddedNodes);
  float* node = nodes.data();
  for (int i = 0; i < view::LookTable::kPaddedNodes; ++i, node += 4) {
    node[0] = table.red()[i];
    node[1] = table.green()[i];
    node[2] = table.blue()[i];
    node[3] = static_cast<float>(
        1.0 - std::pow(1.0 - static_cast<double>(table.opacity()[i]), path_in_units));
  }
  return nodes;
}

VisibleValues visible_values(const view::LookTable& table) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float* const opacity = table.opacity();
  const float* const end = opacity + view::LookTable::kNodes;
  const auto shows = [](float a) { return a > 0.0F; };
  const auto first = std::find_if(opacity, end, shows) - opacity;
  if (first == view::LookTable::kNodes) return {kInfinity, -kInfinity};
  const auto last =
      std::find_if(std::reverse_iterator(end), std::reverse_iterator(opacity), shows).base() - 1 -
      opacity;
  const auto value_at = [&](std::ptrdiff_t node) {
    return static_cast<float>(table.axis().value_of_node(static_cast<double>(node)));
  };
  // Values beyond the table read its ends.
  return {first == 0 ? -kInfinity : value_at(first - 2),
          last == view::LookTable::kCells ? kInfinity : value_at(last + 2)};
}

IntegralNodes integral_nodes(const view::LookTable& table) {
  using view::LookTable;
  constexpr int kParts = 8;
  IntegralNodes result;
  result.nodes.resize(std::size_t{kParts} * LookTable::kPaddedNodes);
  float* node = result.nodes.data();
  const double first = table.axis().value_of_node(0);
  const double last = table.axis().value_of_node(LookTable::kCells);
  const double per_value = LookTable::kCells / (last - first);
  std::array<double, 4> sum{};
  std::array<double, 4> here = integrand_at(table, 0);
  for (int i = 0; i < LookTable::kPaddedNodes; ++i, node += kParts) {
    for (std::size_t c = 0; c < 4; ++c) {
      node[c] = static_cast<float>(sum[c]);
      node[c + 4] = static_cast<float>(sum[c] - static_cast<double>(node[c]));
    }
    if (i >= LookTable::kCells) continue;
    const std::array<double, 4> next = integrand_at(table, i + 1);
    // Of a cell with a step, each side has its share.
    const double share = table.step()[i] >= 0.0F ? static_cast<double>(table.step()[i]) : 0.5;
    const double width =
        (table.axis().value_of_node(i + 1) - table.axis().value_of_node(i)) * per_value;
    for (std::size_t c = 0; c < 4; ++c)
      sum[c] += width * (share * here[c] + (1.0 - share) * next[c]);
    here = next;
  }
  result.per_value = static_cast<float>(per_value);
  result.value_lo = static_cast<float>(first);
  result.value_hi = static_cast<float>(last);
  for (std::size_t c = 0; c < 4; ++c) {
    result.before[c] = static_cast<float>(integrand_at(table, 0)[c]);
    result.behind[c] = static_cast<float>(integrand_at(table, LookTable::kCells)[c]);
  }
  return result;
}

float flat_gradient_inverse(const Look& look, const ValueRange& range, double least_spacing) {
  constexpr double kFlat =
      1e-4;  // of the drawn range, per smallest spacing (docs/numerics.md, "Light")
  const double span = look.mode == Mode::kIsosurface
                          ? static_cast<double>(range.hi) - range.lo
                          : look.transfer_function.hi() - look.transfer_function.lo();
  return static_cast<float>(span > 0 ? std::min(least_spacing / (kFlat * span), 1e30) : 1e30);
}

}  // namespace ovoid
