// SPDX-License-Identifier: Apache-2.0
// Units of length, as programs of microscopy write them.
#pragma once

#include <optional>
#include <string>

namespace ovoid::io {

// "um" for all ways of writing it; empty where a unit means no length.
std::string plain_unit(std::string unit);

// Metres in a unit that plain_unit() has made; empty for an unknown one.
std::optional<double> metres_in(const std::string& unit);

}  // namespace ovoid::io
