// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace ovoid::data {

// A number that no other field of this process has.
std::uint64_t next_field_id() noexcept;

}  // namespace ovoid::data
