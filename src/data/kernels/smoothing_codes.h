// SPDX-License-Identifier: Apache-2.0
// What simulation codes call a smoothing length: each means another multiple of it where a
// particle's kernel ends.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace ovoid::data {

struct SmoothingCode {
  std::string_view name;  // as formats say it: "Gadget", "SWIFT, cubic spline"
  double reach = 2;       // where kernels end, in smoothing lengths
};

// Gadget's is that of its descendants, too. SWIFT's is one for each kernel.
std::span<const SmoothingCode> smoothing_codes() noexcept;

// "HDF5 (Gadget)": the format of what a code has written.
std::string format_of_code(std::string_view format, const SmoothingCode& code);

// Where kernels end in a dataset of that format, in its smoothing lengths; 2 if it names no code.
double smoothing_reach(std::string_view format) noexcept;

}  // namespace ovoid::data
