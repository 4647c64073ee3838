// SPDX-License-Identifier: Apache-2.0
// Size and alignment of every public type, as two translation units see them that differ in what
// the compiler may assume of the processor alone.
#pragma once

#include <cstddef>

namespace ovoid::test {

struct TypeLayout {
  const char* name;  // null ends a list
  std::size_t size, alignment;
};

// With this project's own flags, and with those for wider registers, if the compiler has any; and
// what Eigen then aligns its own types to, bytes.
extern const TypeLayout kLayoutsHere[];
extern const TypeLayout kLayoutsWide[];
extern const std::size_t kAlignmentHere;
extern const std::size_t kAlignmentWide;

}  // namespace ovoid::test
