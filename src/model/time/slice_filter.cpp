// SPDX-License-Identifier: Apache-2.0
#include "model/time/slice_filter.h"

#include <algorithm>
#include <vector>

namespace ovoid::model {

namespace {
constexpr std::int64_t kRows = 16;  // side by side
}

SliceFilter::SliceFilter(const Index3& dims, const PrefilterOptions& options)
    : along_x_(dims[0], options.kernel, options.reconstruction),
      along_y_(dims[1], options.kernel, options.reconstruction) {}

void SliceFilter::apply(float* slice) const {
  solve_along_x(slice);
  along_y_.solve({slice, along_x_.size(), along_x_.size()});
}

// Some rows at a time are turned over, so that they lie side by side.
void SliceFilter::solve_along_x(float* slice) const {
  const std::int64_t size = along_x_.size();
  thread_local std::vector<float> lines;
  lines.resize(static_cast<std::size_t>(size * kRows));
  for (std::int64_t first = 0; first < along_y_.size(); first += kRows) {
    float* const rows = slice + first * size;
    const std::int64_t lanes = std::min(kRows, along_y_.size() - first);
    for (std::int64_t j = 0; j < size; ++j) {
      for (std::int64_t lane = 0; lane < lanes; ++lane)
        lines[j * kRows + lane] = rows[lane * size + j];
    }
    along_x_.solve({lines.data(), kRows, lanes});
    for (std::int64_t lane = 0; lane < lanes; ++lane) {
      for (std::int64_t j = 0; j < size; ++j) rows[lane * size + j] = lines[j * kRows + lane];
    }
  }
}

}  // namespace ovoid::model
