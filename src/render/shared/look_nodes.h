// SPDX-License-Identifier: Apache-2.0
// A look's tables in the form that back ends read: red, green, blue and opacity of a node side by
// side.
#pragma once

#include <array>
#include <vector>

#include "ovoid/look.h"
#include "view/frame_plan.h"

namespace ovoid {

// The extinction that stands for an opacity of 1: light through one unit distance of it is 1.6e-28.
inline constexpr double kGreatestExtinction = 64.0;

// [kPaddedNodes][4]: the nodes of the table, opacities corrected for a path of so many unit
// distances.
std::vector<float> classification_nodes(const view::LookTable& table, double path_in_units);

// A range outside of which a table has no opacity, a cell wider than it need be.
struct VisibleValues {
  float lo, hi;
};
VisibleValues visible_values(const view::LookTable& table);

// Integrals of the look over the value, from node 0 on: extinction times red, green and blue, and
// extinction, each as the sum of two floats, since differences are taken of large numbers.
struct IntegralNodes {
  std::vector<float> nodes;          // [kPaddedNodes][8]: four high parts, four low
  float per_value = 1;               // the unit of the integrals, by value
  float value_lo = 0, value_hi = 1;  // of the first and the last node; beyond, the ends go on
  std::array<float, 4> before{}, behind{};  // what is integrated there
};
IntegralNodes integral_nodes(const view::LookTable& table);

// 1 / (the gradient's length, world, below which a region counts as flat). `range`: of the field's
// values.
float flat_gradient_inverse(const Look& look, const ValueRange& range, double least_spacing);

}  // namespace ovoid
