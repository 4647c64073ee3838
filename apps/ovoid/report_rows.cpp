// SPDX-License-Identifier: Apache-2.0
#include "report_rows.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "console.h"
#include "profile.h"

namespace ovoid::cli {

void print_rows(const ReportRows& rows) {
  for (const auto& [name, text] : rows) print_out("{:16}{}\n", name, text);
}

std::string one_for_text(std::int64_t of, std::int64_t count) {
  if (count == 0) return "";
  return fmt::format(": 1 / {:.3g}", static_cast<double>(of) / static_cast<double>(count));
}

std::string bytes_text(std::int64_t bytes) {
  return fmt::format("{} ({})", bytes, readable_bytes(static_cast<double>(bytes)));
}

std::string share_text(double share) { return fmt::format("{:.2g} %", 100 * share); }

std::string error_text(double error, double range) {
  return fmt::format("{:.4g} ({} of the range)", error,
                     share_text(error / (range > 0 ? range : 1)));
}

std::string seconds_text(double seconds) { return fmt::format("{:.2f} s", seconds); }

nlohmann::ordered_json decibels_json(double decibels) {
  return std::isfinite(decibels) ? nlohmann::ordered_json(decibels) : nlohmann::ordered_json();
}

}  // namespace ovoid::cli
