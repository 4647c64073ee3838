// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/blended_lattice.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "data/lattice/brick_reach.h"
#include "data/scalar_visit.h"

namespace ovoid {
namespace {

// Cells along each axis of what is summed at once.
constexpr int kCubeEdge = 16;

// Calls use(view, box) for boxes that together are `box`, each in one view of the source.
template <class Use>
void for_each_view(const BrickSource& source, const data::SampleRange& box, const Use& use) {
  const int edge = source.brick_edge();
  Index3 at = box.lo;
  while (at[2] < box.hi[2]) {
    std::int64_t next_z = box.hi[2];
    for (at[1] = box.lo[1]; at[1] < box.hi[1];) {
      std::int64_t next_y = box.hi[1];
      for (at[0] = box.lo[0]; at[0] < box.hi[0];) {
        const BrickView view = source.acquire(at[0] / edge, at[1] / edge, at[2] / edge, 0.0);
        data::SampleRange part{at, {}};
        for (std::size_t a = 0; a < 3; ++a) part.hi[a] = std::min(box.hi[a], view.hi[a]);
        next_y = std::min(next_y, part.hi[1]);
        next_z = std::min(next_z, part.hi[2]);
        use(view, part);
        at[0] = part.hi[0];
      }
      at[1] = next_y;
    }
    at[2] = next_z;
  }
}

// to (+)= weight * value, a row.
template <class T>
void add_row(const T* from, std::int64_t count, float scale, float offset, bool is_first,
             float* to) {
  for (std::int64_t i = 0; i < count; ++i) {
    float value = static_cast<float>(from[i]) * scale + offset;
    if constexpr (std::is_same_v<T, float>) {
      // An infinity is missing, as it is in the part.
      if (!std::isfinite(from[i])) value = std::numeric_limits<float>::quiet_NaN();
    }
    to[i] = is_first ? value : to[i] + value;
  }
}

}  // namespace

BlendedLattice::BlendedLattice(const LatticeGeometry& geometry,
                               std::array<std::vector<Part>, 2> parts, double range_reach,
                               std::shared_ptr<const BrickSource> samples)
    : geometry_(geometry),
      parts_(std::move(parts)),
      range_reach_(range_reach),
      samples_(std::move(samples)),
      edge_(parts_[0].front().source->brick_edge()) {
  for (int s = 0; s < geometry_.num_sublattices(); ++s) {
    assert(!parts_[static_cast<std::size_t>(s)].empty());
    for ([[maybe_unused]] const Part& part : parts_[static_cast<std::size_t>(s)]) {
      assert(part.source->geometry().dims == geometry_.dims_of(s) && part.weight > 0);
      assert(part.source->brick_edge() == edge_ && kCubeEdge % edge_ == 0);
    }
  }
  const Index3 cells = geometry_.cells();
  for (std::size_t a = 0; a < 3; ++a) num_cubes_[a] = (cells[a] + kCubeEdge - 1) / kCubeEdge;
  cubes_ =
      std::vector<std::atomic<const float*>>(static_cast<std::size_t>(num_samples(num_cubes_)));
}

BlendedLattice::~BlendedLattice() {
  for (const std::atomic<const float*>& cube : cubes_) delete[] cube.load();
}

ValueRange BlendedLattice::brick_range(std::int64_t bx, std::int64_t by,
                                       std::int64_t bz) const noexcept {
  ValueRange all;
  for (const std::vector<Part>& parts : parts_) {
    double lo = 0;
    double hi = 0;
    bool is_empty = parts.empty();
    for (const Part& part : parts) {
      const ValueRange range = part.source->brick_range(bx, by, bz);
      // Where a part has no sample the sum has none.
      is_empty = is_empty || range.is_empty();
      lo += part.weight * static_cast<double>(range.lo);
      hi += part.weight * static_cast<double>(range.hi);
    }
    if (is_empty) continue;
    // Sums of floats may round beyond sums of their bounds.
    const double slack = 1e-6 * (std::abs(lo) + std::abs(hi));
    const auto least = static_cast<float>(lo - slack);
    const auto greatest = static_cast<float>(hi + slack);
    all = all.is_empty() ? ValueRange{least, greatest}
                         : ValueRange{std::min(all.lo, least), std::max(all.hi, greatest)};
  }
  return all;
}

bool BlendedLattice::has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept {
  for (const std::vector<Part>& parts : parts_) {
    for (const Part& part : parts) {
      if (part.source->has_missing(bx, by, bz)) return true;
    }
  }
  return false;
}

std::unique_ptr<float[]> BlendedLattice::summed(const BrickView& cube) const {
  std::unique_ptr<float[]> samples(
      new float[static_cast<std::size_t>(cube.stride_z * (cube.hi[2] - cube.lo[2]))]);
  const int num_sublattices = geometry_.num_sublattices();
  for (int s = 0; s < num_sublattices; ++s) {
    // Layers s, s + num_sublattices, ... of the cube, which begins with one of sublattice 0.
    data::SampleRange box{cube.lo, cube.hi};
    box.lo[2] = cube.lo[2] / num_sublattices;
    box.hi[2] = (cube.hi[2] - s + num_sublattices - 1) / num_sublattices;
    bool is_first = true;
    for (const Part& part : parts_[static_cast<std::size_t>(s)]) {
      const auto scale = static_cast<float>(part.weight * part.source->value_scale());
      const auto offset = static_cast<float>(part.weight * part.source->value_offset());
      for_each_view(*part.source, box, [&](const BrickView& from, const data::SampleRange& shown) {
        data::visit_scalar(from.type, [&]<class T>(std::type_identity<T>) {
          for (std::int64_t z = shown.lo[2]; z < shown.hi[2]; ++z) {
            for (std::int64_t y = shown.lo[1]; y < shown.hi[1]; ++y) {
              const T* row = static_cast<const T*>(from.data) + (shown.lo[0] - from.lo[0]) +
                             (y - from.lo[1]) * from.stride_y + (z - from.lo[2]) * from.stride_z;
              add_row(row, shown.hi[0] - shown.lo[0], scale, offset, is_first,
                      samples.get() + (shown.lo[0] - cube.lo[0]) +
                          (y - cube.lo[1]) * cube.stride_y +
                          (z * num_sublattices + s - cube.lo[2]) * cube.stride_z);
            }
          }
        });
      });
      is_first = false;
    }
  }
  return samples;
}

BrickView BlendedLattice::acquire(std::int64_t bx, std::int64_t by, std::int64_t bz, double) const {
  const Index3 at{bx * edge_ / kCubeEdge, by * edge_ / kCubeEdge, bz * edge_ / kCubeEdge};
  const auto [lo, hi] = data::samples_in_brick(geometry_, at, kCubeEdge);
  BrickView view;
  view.type = ScalarType::kFloat32;
  view.lo = lo;
  view.hi = hi;
  view.stride_y = hi[0] - lo[0];
  view.stride_z = view.stride_y * (hi[1] - lo[1]);
  std::atomic<const float*>& place =
      cubes_[static_cast<std::size_t>(at[0] + num_cubes_[0] * (at[1] + num_cubes_[1] * at[2]))];
  const float* samples = place.load(std::memory_order_acquire);
  if (samples == nullptr) {
    std::unique_ptr<float[]> made = summed(view);
    // Another thread may have been faster; its sums are the same.
    if (place.compare_exchange_strong(samples, made.get(), std::memory_order_acq_rel,
                                      std::memory_order_acquire)) {
      samples = made.release();
      summed_bytes_ += static_cast<std::size_t>(view.stride_z * (hi[2] - lo[2])) * sizeof(float);
    }
  }
  view.data = samples;
  return view;
}

std::size_t BlendedLattice::resident_bytes() const noexcept {
  std::size_t bytes = summed_bytes_ + cubes_.size() * sizeof(cubes_[0]);
  for (const std::vector<Part>& parts : parts_) {
    for (const Part& part : parts) bytes += part.source->resident_bytes();
  }
  return bytes;
}

}  // namespace ovoid
