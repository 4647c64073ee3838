// SPDX-License-Identifier: Apache-2.0
#include "data/kernels/smoothing_codes.h"

#include <fmt/format.h>

#include <array>

namespace ovoid::data {
namespace {

// [Springel 2005, eq. 4]: W = 0 beyond h. SWIFT's h is twice the standard deviation of the kernel
// along an axis: H / h in three dimensions of [Dehnen 2012, table 1].
constexpr std::array kCodes = std::to_array<SmoothingCode>({{"Gadget", 1},
                                                            {"SWIFT, cubic spline", 1.825742},
                                                            {"SWIFT, quartic spline", 2.018932},
                                                            {"SWIFT, quintic spline", 2.195775},
                                                            {"SWIFT, Wendland C2", 1.936492},
                                                            {"SWIFT, Wendland C4", 2.207940},
                                                            {"SWIFT, Wendland C6", 2.449490}});

}  // namespace

std::span<const SmoothingCode> smoothing_codes() noexcept { return kCodes; }

std::string format_of_code(std::string_view format, const SmoothingCode& code) {
  return fmt::format("{} ({})", format, code.name);
}

double smoothing_reach(std::string_view format) noexcept {
  const auto open = format.find('(');
  if (open == std::string_view::npos || !format.ends_with(')')) return 2;
  const std::string_view name = format.substr(open + 1, format.size() - open - 2);
  for (const SmoothingCode& code : kCodes)
    if (code.name == name) return code.reach;
  return 2;
}

}  // namespace ovoid::data
