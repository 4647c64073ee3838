// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <new>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace ovoid::data {

// Throws Error(kOutOfMemory): "WHAT: no memory for N bytes".
[[noreturn]] void throw_out_of_memory(std::string_view what, std::size_t num_bytes);

// What `allocate` returns; where it finds no memory, throws as above. For what is large: the rest
// is told without a name, by whoever called the library.
template <typename Allocate>
decltype(auto) allocated(std::string_view what, std::size_t num_bytes, Allocate&& allocate) {
  try {
    return std::forward<Allocate>(allocate)();
  } catch (const std::bad_alloc&) {
    throw_out_of_memory(what, num_bytes);
  } catch (const std::length_error&) {
    throw_out_of_memory(what, num_bytes);
  }
}

}  // namespace ovoid::data
