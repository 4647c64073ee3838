// SPDX-License-Identifier: Apache-2.0
// Colours as words: names and hexadecimal numbers.
#pragma once

#include <string>

#include "ovoid/transfer_function.h"

namespace ovoid::cli {

// One of CSS's names [CSS colors], in lower case, or "#rgb" or "#rrggbb". Throws BadValue
// (values.h), which suggests the name that was meant.
Rgb color_of_word(const std::string& word);

// "#rrggbb": to the nearest of 256 steps.
std::string hex_text(const Rgb& rgb);

}  // namespace ovoid::cli
