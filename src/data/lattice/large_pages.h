// SPDX-License-Identifier: Apache-2.0
// Memory in pages as large as the system has them: what a frame makes anew for every pixel is
// large, and each page costs a trip to the system.
#pragma once

#include <cstddef>
#include <vector>

namespace ovoid::data {

// Where it is refused pages are as they are. The memory must not have been touched yet.
void advise_large_pages(void* begin, std::size_t bytes);

// Of an empty vector.
template <class T>
void reserve_large_pages(std::vector<T>& items, std::size_t count) {
  items.reserve(count);
  advise_large_pages(items.data(), count * sizeof(T));
}

}  // namespace ovoid::data
