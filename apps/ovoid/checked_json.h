// SPDX-License-Identifier: Apache-2.0
// JSON that somebody else wrote: parsed with limits, members in the order of the text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace ovoid::cli {

// `source` stands for the text in messages. Throws Error(kFileFormat), in one line, for what is not
// JSON or nested deep, for numbers that double does not hold, for objects of very many members, and
// for what stands twice in one object, of which one would be lost.
nlohmann::ordered_json checked_json(const std::string& text, const std::string& source);

// A text of the file's, short enough for a message.
std::string cut_line(const std::string& text);

}  // namespace ovoid::cli
