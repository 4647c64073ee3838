// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace ovoid::cli {

// The candidate that a person who typed `word` most likely meant: the nearest by edits (insert,
// delete, replace a letter), empty if all are further than a third of the word. Ties go to the
// first.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);

// "; did you mean --size?", or nothing.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace ovoid::cli
