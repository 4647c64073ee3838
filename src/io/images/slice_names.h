// SPDX-License-Identifier: Apache-2.0
// Pictures that are the slices of one volume: which of a folder belong together, and in which
// order, as their names say.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ovoid::io {

// "s2" before "s10": digits in a row count as one number, of equal ones the name with fewer leading
// zeros comes first.
bool is_before_naturally(std::string_view a, std::string_view b) noexcept;

// Slices in their order, lowest first.
struct SliceNames {
  std::vector<std::string> paths;
  std::vector<std::string> left_out;  // of a folder: names that differ in more than numbers
  std::vector<std::string> notes;     // gaps in the numbers, an order that is no one's number
};

// The slices among `paths`. Paths that differ in numbers alone belong together; of a folder the
// most numerous kind is taken, and two of the same number are refused. `source` names the folder
// in messages. Throws Error(kUnsupported).
SliceNames slices_of_folder(const std::string& source, std::vector<std::string> paths);

// All of them, as somebody has named them one by one. `source` as above. A note says so if their
// numbers order them otherwise than they were given.
SliceNames slices_in_order(const std::string& source, std::vector<std::string> paths);

}  // namespace ovoid::io
