// SPDX-License-Identifier: Apache-2.0
#include "model/lattice/sample_window.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "data/lattice/brick_reach.h"
#include "data/scalar_visit.h"

namespace ovoid::model {
namespace {

bool covers(const BrickView& view, const data::SampleRange& box) {
  for (std::size_t a = 0; a < 3; ++a)
    if (box.lo[a] < view.lo[a] || box.hi[a] > view.hi[a]) return false;
  return true;
}

// Copies a box that both have.
template <class T>
void copy_box(const BrickView& view, const data::SampleRange& box, SampleWindow& window) {
  const auto* const bytes = static_cast<const std::byte*>(view.data);
  const std::int64_t count = box.hi[0] - box.lo[0];
  bool is_whole = true;
  for (std::int64_t k = box.lo[2]; k < box.hi[2]; ++k) {
    for (std::int64_t j = box.lo[1]; j < box.hi[1]; ++j) {
      const std::int64_t first = (box.lo[0] - view.lo[0]) + (j - view.lo[1]) * view.stride_y +
                                 (k - view.lo[2]) * view.stride_z;
      double* const to =
          window.numbers.data() + window.start_of_row(j, k) + (box.lo[0] - window.lo[0]);
      for (std::int64_t i = 0; i < count; ++i) {
        const T number = data::load_scalar<T>(bytes, first + i);
        to[i] = static_cast<double>(number);
        if constexpr (std::is_floating_point_v<T>) {
          const bool exists = std::abs(number) <= std::numeric_limits<T>::max();
          to[i] = exists ? to[i] : std::numeric_limits<double>::quiet_NaN();
          is_whole &= exists;
        }
      }
    }
  }
  window.has_missing |= !is_whole;
}

void copy_box(const BrickView& view, const data::SampleRange& box, SampleWindow& window) {
  data::visit_scalar(view.type,
                     [&]<class T>(std::type_identity<T>) { copy_box<T>(view, box, window); });
}

}  // namespace

void SampleWindow::load(const BrickSource& source, const Index3& first, const Index3& end) {
  lo = first;
  hi = end;
  has_missing = false;
  numbers.resize(
      static_cast<std::size_t>(num_samples({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]})));
  const int edge = source.brick_edge();
  Index3 low, high;  // bricks, both included
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t samples = edge * (a == 2 ? source.geometry().num_sublattices() : 1);
    low[a] = lo[a] / samples;
    high[a] = (hi[a] - 1) / samples;
  }
  for (std::int64_t z = low[2]; z <= high[2]; ++z) {
    for (std::int64_t y = low[1]; y <= high[1]; ++y) {
      for (std::int64_t x = low[0]; x <= high[0]; ++x) {
        const BrickView view = source.acquire(x, y, z, 0.0);
        if (covers(view, {lo, hi})) {  // as of samples in memory, whatever the brick
          copy_box(view, {lo, hi}, *this);
          return;
        }
        data::SampleRange box = data::samples_in_brick(source.geometry(), {x, y, z}, edge);
        for (std::size_t a = 0; a < 3; ++a) {
          box.lo[a] = std::max(box.lo[a], lo[a]);
          box.hi[a] = std::min(box.hi[a], hi[a]);
        }
        copy_box(view, box, *this);
      }
    }
  }
}

}  // namespace ovoid::model
