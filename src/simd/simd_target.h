// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace ovoid::simd {

// One of the SIMD targets that this build has and this machine can run. Highway's own choice is
// shared by the whole process, programs with Highway of their own included; this one is not.
class SimdTarget {
 public:
  // Empty: the best. Throws Error(kInvalidArgument) for a name that is not among usable().
  explicit SimdTarget(const std::string& name = {});

  static std::vector<std::string> usable();  // best first

  const std::string& name() const noexcept { return name_; }

  // The target's function in a table that HWY_EXPORT has made; a build for one target has one.
  template <typename Function, std::size_t kSize>
  Function* choose(Function* const (&table)[kSize]) const noexcept {
    return table[std::min(index_, kSize - 1)];
  }

 private:
  std::string name_;
  std::size_t index_ = 0;
};

}  // namespace ovoid::simd
