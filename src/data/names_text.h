// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace ovoid::data {

// What a file calls its parts may be of any length and number; a message is one line that a person
// reads. "'name'", with what is beyond 60 characters as "...".
std::string name_text(std::string_view name);

// "'a', 'b', 'c'", of many the first ten: "'a', ..., 'j' and 59990 more"; "none" if there are none.
std::string names_text(std::span<const std::string> names);

}  // namespace ovoid::data
