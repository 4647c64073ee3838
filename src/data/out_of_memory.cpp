// SPDX-License-Identifier: Apache-2.0
#include "data/out_of_memory.h"

#include <fmt/format.h>

#include "ovoid/error.h"

namespace ovoid::data {

void throw_out_of_memory(std::string_view what, std::size_t num_bytes) {
  throw Error(ErrorCode::kOutOfMemory, fmt::format("{}: no memory for {} bytes", what, num_bytes));
}

}  // namespace ovoid::data
