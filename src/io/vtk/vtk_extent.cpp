// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/vtk_extent.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>

#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {

std::array<std::int64_t, 3> VtkExtent::dims() const {
  std::array<std::int64_t, 3> result{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (hi[axis] < lo[axis]) return {};
    result[axis] = hi[axis] - lo[axis] + 1;
  }
  return result;
}

bool VtkExtent::contains(const VtkExtent& other) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (other.lo[axis] < lo[axis] || other.hi[axis] > hi[axis]) return false;
  }
  return true;
}

bool VtkExtent::shares_cells(const VtkExtent& other) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t first = std::max(lo[axis], other.lo[axis]);
    const std::int64_t last = std::min(hi[axis], other.hi[axis]);
    const bool is_flat = lo[axis] == hi[axis] && other.lo[axis] == other.hi[axis];
    if (is_flat ? first > last : first >= last) return false;
  }
  return true;
}

VtkExtent parse_vtk_extent(const ByteSource& source, const std::string& field,
                           const std::string& text) {
  const auto parts = words(text);
  VtkExtent extent;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::optional<std::int64_t> lo, hi;
    if (parts.size() == 6) {
      lo = parse_integer(parts[2 * axis]);
      hi = parse_integer(parts[2 * axis + 1]);
    }
    constexpr std::int64_t kInt = kMaxAxisSize;  // VTK keeps extents in 32-bit integers
    if (!lo || !hi || *lo < -kInt || *lo > kInt || *hi < -kInt || *hi > kInt) {
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}=\"{}\": expected six integers",
                                                      source.name(), field, text.substr(0, 80)));
    }
    extent.lo[axis] = *lo;
    extent.hi[axis] = *hi;
  }
  return extent;
}

}  // namespace ovoid::io
