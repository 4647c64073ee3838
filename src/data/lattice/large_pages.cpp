// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/large_pages.h"

#include <memory>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace ovoid::data {

void advise_large_pages([[maybe_unused]] void* begin, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  constexpr std::size_t kPage = 4096;
  if (std::align(kPage, kPage, begin, bytes) == nullptr) return;
  madvise(begin, bytes / kPage * kPage, MADV_HUGEPAGE);
#endif
}

}  // namespace ovoid::data
