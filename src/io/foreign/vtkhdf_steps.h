// SPDX-License-Identifier: Apache-2.0
// Time in a VTKHDF file: a group Steps, whose arrays say where the numbers of each step begin.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/foreign/vtkhdf_group.h"

namespace ovoid::io {

class VtkHdfSteps {
 public:
  // The steps of what `owner` holds: one without a group Steps.
  explicit VtkHdfSteps(const VtkHdfGroup& owner);

  bool is_static() const noexcept { return !group_; }
  std::int64_t count() const noexcept { return count_; }
  // One for each step, or none.
  const std::vector<double>& times() const noexcept { return times_; }
  // What levels of adaptive grids have of their own: Steps/Level0.
  std::optional<VtkHdfGroup> level(int level) const;

  // The number that Steps/NAME has for a step; 0 where there are no steps.
  std::int64_t offset(const char* name, std::int64_t step, std::int64_t column = 0) const;
  // Where the array called `array` begins, by Steps/GROUP/ARRAY; nothing if that is not there.
  std::optional<std::int64_t> offset_of_array(const char* group, const std::string& array,
                                              std::int64_t step) const;
  // Parts of a step, of `num_parts` in the file.
  std::int64_t num_parts(std::int64_t step, std::int64_t num_parts) const;

 private:
  std::optional<VtkHdfGroup> group_;
  std::int64_t count_ = 1;
  std::vector<double> times_;
};

}  // namespace ovoid::io
