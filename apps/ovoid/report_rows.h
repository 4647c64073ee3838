// SPDX-License-Identifier: Apache-2.0
// What `ovoid fit` and `ovoid simplify` tell of what they made, for people and as JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

namespace ovoid::cli {

// Names and texts.
using ReportRows = std::vector<std::pair<std::string, std::string>>;
void print_rows(const ReportRows& rows);

// ": 1 / 9.99" for how many times fewer `count` is than `of`; nothing for none.
std::string one_for_text(std::int64_t of, std::int64_t count);
// "246311 (240.5 KiB)"
std::string bytes_text(std::int64_t bytes);
// "4.4 %"
std::string share_text(double share);
// "0.2093 (4.4 % of the range)"; a range of 0 counts as 1.
std::string error_text(double error, double range);
// "14.10 s"
std::string seconds_text(double seconds);

// JSON has no infinity: null, where there is no error.
nlohmann::ordered_json decibels_json(double decibels);

}  // namespace ovoid::cli
