// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/look.h"
#include "view/look/look_table.h"

namespace ovoid::view {

// The transfer function whose colours are used where colour comes from an attribute of its own.
inline const TransferFunction& color_function_of(const Look& look) {
  return look.color_function ? *look.color_function : look.transfer_function;
}

// Colours by value, as nobody's opacity lets them through.
inline LookTable colors_alone(TransferFunction tf) {
  tf.opacities.clear();
  tf.gradient_opacities.clear();
  return LookTable(tf);
}

}  // namespace ovoid::view
