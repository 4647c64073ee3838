// SPDX-License-Identifier: Apache-2.0
// Hyperslices of one normal as the steps of a series.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/time/hyperplane_frame.h"
#include "ovoid/error.h"
#include "ovoid/hyperslice.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse_steps(const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, "hyperslices: " + what);
}

model::SpaceTime space_time_of(const Series& series, const HypersliceOptions& options) {
  const auto first = series.step(0, options.stop);
  if (first->kind != DatasetKind::kLattice)
    refuse_steps(fmt::format("'{}' is no lattice", series.source().name()));
  return {series.source().kind(), first->lattice.dims,    first->lattice.world_from_index,
          series.num_steps(),     series.times().front(), series.times().back()};
}

// The offset of the plane through a place in index space and time.
double offset_at(const Hyperplane& plane, const Vec3& world, double time) {
  return plane.normal[0] * world.x() + plane.normal[1] * world.y() + plane.normal[2] * world.z() +
         plane.normal[3] * time;
}

class HypersliceSteps final : public StepSource {
 public:
  HypersliceSteps(std::shared_ptr<const Series> series, const Hyperplane& plane,
                  std::vector<double> offsets, HypersliceOptions options)
      : series_(std::move(series)),
        plane_(plane),
        offsets_(std::move(offsets)),
        options_(std::move(options)) {
    if (options_.method != SliceMethod::kInterpolated)
      refuse_steps("extracted ones are no lattices: take method interpolated");
    const model::SpaceTime whole = space_time_of(*series_, options_);
    const Vec3 last = whole.world * Vec3(static_cast<double>(whole.dims[0] - 1),
                                         static_cast<double>(whole.dims[1] - 1),
                                         static_cast<double>(whole.dims[2] - 1));
    Hyperplane middle = plane;
    middle.offset = offset_at(plane, 0.5 * (whole.world.translation() + last),
                              0.5 * (whole.first_time + whole.last_time));
    const model::HyperplaneFrame frame(whole, middle);
    if (!frame.is_across_axis())
      refuse_steps("the plane must be across one axis, x, y, z or t: others move sideways");
    if (offsets_.empty()) offsets_ = offsets_of_samples(whole, frame.dropped());
    for (std::size_t i = 0; i < offsets_.size(); ++i) {
      if (!std::isfinite(offsets_[i]) || (i > 0 && !(offsets_[i] > offsets_[i - 1])))
        refuse_steps(fmt::format("offsets[{}] = {:g}: must rise", i, offsets_[i]));
      middle.offset = offsets_[i];
      model::HyperplaneFrame(whole, middle);  // throws where it misses the data
    }
  }

  const std::string& name() const noexcept override { return series_->source().name(); }
  std::int64_t num_steps() const noexcept override {
    return static_cast<std::int64_t>(offsets_.size());
  }
  const std::vector<double>& times() const noexcept override { return offsets_; }
  bool has_times() const noexcept override { return true; }

  Dataset read(std::int64_t step, std::stop_token stop) const override {
    if (step < 0 || step >= num_steps()) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: step {}: there are {}", name(), step, num_steps()));
    }
    Hyperplane plane = plane_;
    plane.offset = offsets_[static_cast<std::size_t>(step)];
    HypersliceOptions options = options_;
    options.stop = std::move(stop);
    Dataset slice = hyperslice(*series_, plane, options);
    slice.num_steps = num_steps();
    slice.step = step;
    slice.times = offsets_;
    return slice;
  }

 private:
  // Where the axis has samples.
  std::vector<double> offsets_of_samples(const model::SpaceTime& whole, int axis) const {
    const bool is_time = axis == 3;
    const std::int64_t size =
        is_time ? whole.num_steps : whole.dims[static_cast<std::size_t>(axis)];
    std::vector<double> offsets;
    for (std::int64_t i = 0; i < size; ++i) {
      const auto place = static_cast<double>(i);
      const double time =
          is_time ? series_->times()[static_cast<std::size_t>(i)] : whole.first_time;
      const Vec3 index = is_time ? Vec3::Zero() : Vec3(place * Vec3::Unit(axis));
      offsets.push_back(offset_at(plane_, whole.world * index, time));
    }
    if (offsets.front() > offsets.back()) std::reverse(offsets.begin(), offsets.end());
    return offsets;
  }

  std::shared_ptr<const Series> series_;
  Hyperplane plane_;
  std::vector<double> offsets_;
  HypersliceOptions options_;
};

}  // namespace

std::shared_ptr<const StepSource> hyperslice_steps(std::shared_ptr<const Series> series,
                                                   const Hyperplane& plane,
                                                   std::vector<double> offsets,
                                                   const HypersliceOptions& options) {
  if (series == nullptr) refuse_steps("there is no series");
  return std::make_shared<HypersliceSteps>(std::move(series), plane, std::move(offsets), options);
}

}  // namespace ovoid
