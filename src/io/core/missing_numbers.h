// SPDX-License-Identifier: Apache-2.0
// What the CF conventions say of an array's numbers: which stand for missing samples, and the
// places of samples along an axis.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::io {

// Samples of the array that are one of these numbers, as stored, become NaN; integers become
// float32, those of 4 and 8 bytes float64, with a note. Where there are none, or the samples stay
// in their file, nothing changes. `where` names the array. Throws Error(kOutOfMemory).
void hide_missing_numbers(const std::string& where, std::span<const double> numbers,
                          DataArray& array, std::vector<std::string>& notes);

// The first place and the distance, if there are at least two and all distances are the same to a
// thousandth.
std::optional<std::pair<double, double>> even_places(std::span<const double> places);

}  // namespace ovoid::io
