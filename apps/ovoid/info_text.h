// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace ovoid::cli {

// What info_json() tells, on standard output for people.
void print_info(const nlohmann::ordered_json& json);

// A number for people: nine digits tell any two float32 values apart.
std::string number_text(const nlohmann::ordered_json& value);

}  // namespace ovoid::cli
