// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/run_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>
#include <type_traits>
#include <utility>

#include "data/lattice/brick_reach.h"
#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse_runs(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

// Bricks per task: some milliseconds of unpacking.
constexpr std::int64_t kBricksPerTask = 64;

}  // namespace

RunLattice::RunLattice(const LatticeGeometry& geometry, data::RelevantRuns runs,
                       const ResidentLatticeOptions& options)
    : geometry_(geometry),
      runs_(std::move(runs)),
      range_reach_(options.range_reach),
      value_scale_(options.value_scale),
      value_offset_(options.value_offset) {
  data::validate_geometry(geometry_);
  options.validate();
  const ScalarType type = runs_.box().type;
  if (!ResidentLattice::can_show(type))
    refuse_runs(
        fmt::format("type = {}: must be uint8, int8, uint16, int16 or float32", name_of(type)));
  if (runs_.box().dims != geometry_.dims)
    refuse_runs(fmt::format("runs: of {} samples, must be of {}",
                            fmt::join(runs_.box().dims, " x "), fmt::join(geometry_.dims, " x ")));
  const Index3 sublattice = geometry_.dims_of(0);
  for (std::size_t a = 0; a < 3; ++a)
    num_bricks_[a] = (sublattice[a] + kBrickEdge - 1) / kBrickEdge;
  const auto count = static_cast<std::size_t>(num_samples(num_bricks_));
  ranges_.resize(count);
  missing_.resize(count);
  data::parallel_ranges(
      {static_cast<std::int64_t>(count), kBricksPerTask, options.threads, options.stop},
      [&](std::int64_t begin, std::int64_t end) {
        std::vector<std::byte> scratch;
        for (std::int64_t i = begin; i < end; ++i) {
          const Index3 brick{i % num_bricks_[0], i / num_bricks_[0] % num_bricks_[1],
                             i / num_bricks_[0] / num_bricks_[1]};
          data::visit_scalar(
              type, [&]<class T>(std::type_identity<T>) { find_range<T>(brick, scratch); });
        }
      });
  const std::span<const std::byte> one = runs_.background_bytes();
  const std::size_t num_in_brick = std::size_t{kBrickEdge} * kBrickEdge * kBrickEdge *
                                   static_cast<std::size_t>(geometry_.num_sublattices());
  for (std::size_t i = 0; i < num_in_brick; ++i)
    background_.insert(background_.end(), one.begin(), one.end());
}

template <class T>
void RunLattice::find_range(const Index3& brick, std::vector<std::byte>& scratch) {
  const data::SampleRange window =
      data::samples_in_reach(geometry_, brick, kBrickEdge, range_reach_);
  ValueRange stored;
  const auto add = [&stored](float number) {
    stored = stored.is_empty()
                 ? ValueRange{number, number}
                 : ValueRange{std::min(stored.lo, number), std::max(stored.hi, number)};
  };
  bool is_missing = false;
  if (!runs_.may_hold_runs(window.lo, window.hi)) {
    const auto background = static_cast<float>(runs_.background());
    std::isfinite(background) ? add(background) : void(is_missing = true);
  } else {
    const Index3 size{window.hi[0] - window.lo[0], window.hi[1] - window.lo[1],
                      window.hi[2] - window.lo[2]};
    scratch.resize(static_cast<std::size_t>(num_samples(size)) * sizeof(T));
    runs_.decode(window.lo, window.hi, scratch.data());
    for (std::int64_t i = 0; i < num_samples(size); ++i) {
      const auto number = static_cast<float>(data::load_scalar<T>(scratch.data(), i));
      std::isfinite(number) ? add(number) : void(is_missing = true);
    }
  }
  missing_[brick_index(brick)] = is_missing ? 1 : 0;
  if (stored.is_empty()) return;
  const auto lo = static_cast<float>(stored.lo * value_scale_ + value_offset_);
  const auto hi = static_cast<float>(stored.hi * value_scale_ + value_offset_);
  ranges_[brick_index(brick)] = value_scale_ > 0 ? ValueRange{lo, hi} : ValueRange{hi, lo};
}

std::size_t RunLattice::brick_index(const Index3& brick) const noexcept {
  assert(brick[0] >= 0 && brick[0] < num_bricks_[0] && brick[1] >= 0 && brick[1] < num_bricks_[1] &&
         brick[2] >= 0 && brick[2] < num_bricks_[2]);
  return static_cast<std::size_t>(brick[0] +
                                  num_bricks_[0] * (brick[1] + num_bricks_[1] * brick[2]));
}

ValueRange RunLattice::brick_range(std::int64_t bx, std::int64_t by,
                                   std::int64_t bz) const noexcept {
  return ranges_[brick_index({bx, by, bz})];
}

bool RunLattice::has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept {
  return missing_[brick_index({bx, by, bz})] != 0;
}

BrickView RunLattice::acquire(std::int64_t bx, std::int64_t by, std::int64_t bz, double) const {
  const data::SampleRange box = data::samples_in_brick(geometry_, {bx, by, bz}, kBrickEdge);
  const Index3 size{box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]};
  BrickView view;
  view.type = runs_.box().type;
  view.lo = box.lo;
  view.hi = box.hi;
  view.stride_y = size[0];
  view.stride_z = size[0] * size[1];
  if (!runs_.may_hold_runs(box.lo, box.hi)) {
    view.data = background_.data();
    return view;
  }
  // From operator new: aligned for every type.
  const std::shared_ptr<std::byte[]> samples(
      new std::byte[static_cast<std::size_t>(num_samples(size)) * size_of(view.type)]);
  runs_.decode(box.lo, box.hi, samples.get());
  view.data = samples.get();
  view.pin = samples;
  return view;
}

std::size_t RunLattice::resident_bytes() const noexcept {
  return runs_.num_bytes() + ranges_.size() * sizeof(ValueRange) + missing_.size() +
         background_.size();
}

}  // namespace ovoid
