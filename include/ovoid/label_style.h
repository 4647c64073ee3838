// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "ovoid/export.h"
#include "ovoid/transfer_function.h"

namespace OVOID_API ovoid {

// How a label is drawn.
struct LabelStyle {
  int label = 0;
  std::string name;          // for people; may be empty
  Rgb color{0.8, 0.8, 0.8};  // each in [0, 1]
  double opacity = 1;        // of its surface, in [0, 1]; 0: not drawn
  bool shows_field = true;   // whether the field, if any, is drawn within it
};

// What a table of labels says of one.
struct LabelEntry {
  int label = 0;
  std::string name;                 // empty: nothing
  std::optional<Rgb> color{};       // each in [0, 1]
  std::optional<double> opacity{};  // in [0, 1]
};

}  // namespace ovoid
