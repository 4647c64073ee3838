// SPDX-License-Identifier: Apache-2.0
#include "fit/fit_goal.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "ovoid/error.h"

namespace ovoid::fit {

void refuse_fit(const std::string& message) { throw Error(ErrorCode::kInvalidArgument, message); }

double psnr_of(double range, double mean_square) {
  return mean_square > 0 ? 20 * std::log10(range / std::sqrt(mean_square))
                         : std::numeric_limits<double>::infinity();
}

void check_goal(const FitOptions& options) {
  const int goals = static_cast<int>(options.psnr.has_value()) +
                    static_cast<int>(options.tolerance.has_value()) +
                    static_cast<int>(options.relative_tolerance.has_value()) +
                    static_cast<int>(options.kernels.has_value()) +
                    static_cast<int>(options.bytes.has_value()) + static_cast<int>(options.smooth);
  if (goals != 1)
    refuse_fit(
        fmt::format("psnr, tolerance, relative_tolerance, kernels, bytes, smooth: {} given, "
                    "expected one",
                    goals));
  if (options.psnr && !std::isfinite(*options.psnr))
    refuse_fit(fmt::format("psnr = {}: must be finite", *options.psnr));
  if (options.tolerance && !(*options.tolerance > 0 && std::isfinite(*options.tolerance)))
    refuse_fit(fmt::format("tolerance = {}: must be > 0", *options.tolerance));
  if (options.relative_tolerance &&
      !(*options.relative_tolerance > 0 && *options.relative_tolerance <= 1))
    refuse_fit(
        fmt::format("relative_tolerance = {}: must be in (0, 1]", *options.relative_tolerance));
  if (options.kernels && *options.kernels < 1)
    refuse_fit(fmt::format("kernels = {}: must be 1 or more", *options.kernels));
}

}  // namespace ovoid::fit
