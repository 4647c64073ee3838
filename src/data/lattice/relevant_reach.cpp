// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/relevant_reach.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>

#include "data/lattice/brick_reach.h"
#include "data/lattice/resident_lattice.h"
#include "data/lattice/stored_number.h"
#include "data/scalar_visit.h"
#include "ovoid/error.h"

namespace ovoid::data {
namespace {

// What is drawn of a place may depend on the field as far beside it, index units: the other end of
// a piece, a difference of neighbours.
constexpr double kBeside = 1.0;

bool may_hold(const RelevantValues& relevant, const ValueRange& bounds) {
  for (const RelevantValues::Interval& interval : relevant.intervals()) {
    if (!bounds.is_empty() && interval[0] <= static_cast<double>(bounds.hi) &&
        static_cast<double>(bounds.lo) <= interval[1])
      return true;
  }
  return false;
}

}  // namespace

std::vector<std::byte> keep_in_reach(const LatticeGeometry& geometry, ScalarType type,
                                     const Bytes& samples, const RelevantValues& relevant,
                                     double background, const ReachOptions& options) {
  if (!ResidentLattice::can_show(type)) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("relevant.with_reach: is for samples of 8 and 16 bits and float32, "
                            "these are {}",
                            name_of(type)));
  }
  const ResidentLattice bricks(geometry, type, samples,
                               {options.reach, 1.0, 0.0, options.threads, options.stop});
  const std::size_t size = size_of(type);
  std::vector<std::byte> kept(samples.view.size());
  visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    const T number = stored_number<T>(background);
    for (std::size_t i = 0; i < kept.size(); i += size) std::memcpy(kept.data() + i, &number, size);
  });
  constexpr int kEdge = ResidentLattice::kBrickEdge;
  const Index3 cells = geometry.cells();
  Index3 brick{};
  for (brick[2] = 0; brick[2] * kEdge < cells[2]; ++brick[2]) {
    for (brick[1] = 0; brick[1] * kEdge < cells[1]; ++brick[1]) {
      for (brick[0] = 0; brick[0] * kEdge < cells[0]; ++brick[0]) {
        const bool is_kept = may_hold(relevant, bricks.brick_range(brick[0], brick[1], brick[2])) ||
                             bricks.has_missing(brick[0], brick[1], brick[2]);
        if (!is_kept) continue;
        const SampleRange range = samples_in_reach(geometry, brick, kEdge, options.reach + kBeside);
        const auto length = static_cast<std::size_t>(range.hi[0] - range.lo[0]) * size;
        for (std::int64_t k = range.lo[2]; k < range.hi[2]; ++k) {
          for (std::int64_t j = range.lo[1]; j < range.hi[1]; ++j) {
            const auto from = static_cast<std::size_t>(
                                  range.lo[0] + geometry.dims[0] * (j + geometry.dims[1] * k)) *
                              size;
            std::memcpy(kept.data() + from, samples.view.data() + from, length);
          }
        }
      }
    }
  }
  return kept;
}

}  // namespace ovoid::data
