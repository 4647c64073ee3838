// SPDX-License-Identifier: Apache-2.0
//
// Steps -> samples in a hyperplane. Three ways: sums over the kernels in space and time, which take
// the steps one after the other and add what each has to the samples it reaches; sums along one
// axis, where the plane is across it; and the samples themselves, moved onto the plane.
#include "ovoid/hyperslice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numbers>
#include <type_traits>
#include <utility>
#include <vector>

#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "model/lattice/convert.h"
#include "model/lattice/even_steps.h"
#include "model/lattice/lattice_samples.h"
#include "model/time/hyperplane_frame.h"
#include "model/time/staggered_halves.h"
#include "model/time/step_blend.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

using model::Floats;
using model::HyperplaneFrame;
using model::SpaceTime;
using model::Vec4;

constexpr double kReach = 2;  // of a kernel, T
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kMostSamples = 1e10;  // of a slice; more are taken for a slip

double kernel_at(double distance) { return std::exp(-2 * distance * distance); }

[[noreturn]] void refuse(const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, "hyperslice: " + what);
}

SpaceTime space_time_of(const Series& series, const Dataset& first) {
  return {series.source().kind(), first.lattice.dims,     first.lattice.world_from_index,
          series.num_steps(),     series.times().front(), series.times().back()};
}

// One array of the steps, as values of float32; missing ones are NaN.
class StepValues {
 public:
  StepValues(const Series& series, const HypersliceOptions& options)
      : series_(series), options_(options), first_(series.step(0, options.stop)) {
    model::require_point_lattice(*first_, array_of(*first_));
  }

  const Dataset& first() const { return *first_; }
  const DataArray& array() const { return array_of(*first_); }

  std::vector<float> at(std::int64_t step) const {
    const auto dataset = series_.step(step, options_.stop);
    const model::ScalarSamples samples = model::take_component(
        array_of(*dataset), {options_.component, false, options_.threads, options_.stop});
    std::vector<float> values = model::as_floats(samples, num_samples(first_->lattice.dims));
    const auto scale = static_cast<float>(samples.value_scale);
    const auto offset = static_cast<float>(samples.value_offset);
    if (scale != 1 || offset != 0) {
      for (float& value : values) value = value * scale + offset;
    }
    return values;
  }

 private:
  const DataArray& array_of(const Dataset& dataset) const { return dataset.array(options_.array); }

  const Series& series_;
  const HypersliceOptions& options_;
  std::shared_ptr<const Dataset> first_;
};

// What the result says of itself, without lattice and values.
Dataset described(const StepValues& steps) {
  Dataset out;
  out.source = steps.first().source;
  out.format = "hyperslice";
  out.space = steps.first().space;
  return out;
}

DataArray described_array(const StepValues& steps) {
  DataArray array = steps.array();
  array.bytes = {};
  array.num_components = 1;
  array.type = ScalarType::kFloat32;
  array.value_scale = 1;
  array.value_offset = 0;
  return array;
}

LatticeKind own_kind(const Series& series) {
  return series.source().kind() == SeriesKind::kStaggered ? LatticeKind::kBodyCentred
                                                          : LatticeKind::kCartesian;
}

// --- sums over all kernels in reach

// The lattice of the result, its index space mapped to the plane.
LatticeGeometry lattice_in_plane(const HyperplaneFrame& frame, LatticeKind kind, double spacing) {
  LatticeGeometry unit;
  double count = 1;
  for (int a = 0; a < 3; ++a) {
    const double size = frame.bounds().max()[a] - frame.bounds().min()[a];
    unit.dims[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(std::ceil(size - 1e-6)) + 1;
    count *= size / spacing + 1;
  }
  if (!(count <= kMostSamples))
    refuse(fmt::format("spacing = {:g}: makes {:.3g} samples, more than {:g}", spacing, count,
                       kMostSamples));
  unit.world_from_index.translation() = frame.bounds().min();
  return kind == LatticeKind::kBodyCentred ? body_centred_like(unit, spacing)
                                           : cartesian_like(unit, spacing);
}

// What the samples of a row get from one axis of a step: up to four taps.
struct AxisTaps {
  std::int64_t first = 0;
  int count = 0;
  std::array<double, 5> weights{};
};

AxisTaps taps_at(double position, double scale, double shift, std::int64_t size) {
  const double u = (position - shift) / scale;
  const double reach = kReach / scale;
  AxisTaps taps;
  taps.first = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(u - reach)));
  const auto last = std::min(size - 1, static_cast<std::int64_t>(std::floor(u + reach)));
  taps.count = static_cast<int>(std::clamp<std::int64_t>(last - taps.first + 1, 0, 5));
  for (int k = 0; k < taps.count; ++k) {
    taps.weights[static_cast<std::size_t>(k)] =
        kernel_at(scale * (u - static_cast<double>(taps.first + k)));
  }
  return taps;
}

// Sums of one sample so far.
struct Sum {
  float values = 0;
  float weights = 0;
  float missing = 0;  // weights of samples that are not there
};

class PlaneSums {
 public:
  PlaneSums(const SpaceTime& space_time, const HyperplaneFrame& frame,
            const LatticeGeometry& lattice, const HypersliceOptions& options)
      : space_time_(space_time),
        frame_(frame),
        lattice_(lattice),
        options_(options),
        sums_(static_cast<std::size_t>(num_samples(lattice.dims))) {
    along_row_ = frame_.axes() * lattice_.world_from_index.linear().col(0);
  }

  void add(std::int64_t step, const std::vector<float>& values) {
    data::parallel_ranges({num_rows(), 16, options_.threads, options_.stop},
                          [&](std::int64_t begin, std::int64_t end) {
                            for (std::int64_t row = begin; row < end; ++row)
                              add_to_row(row, step, values);
                          });
  }

  Floats values() const {
    Floats out = model::new_floats(num_samples(lattice_.dims));
    data::parallel_ranges({num_rows(), 64, options_.threads, options_.stop}, [&](std::int64_t begin,
                                                                                 std::int64_t end) {
      for (std::int64_t row = begin; row < end; ++row) {
        Vec4 at = start_of(row);
        for (std::int64_t i = 0; i < lattice_.dims[0]; ++i, at += along_row_) {
          const auto n = static_cast<std::size_t>(row * lattice_.dims[0] + i);
          const Sum& sum = sums_[n];
          const bool is_there = is_in_data(at) && sum.weights > 0 && sum.weights >= sum.missing;
          out[n] = is_there ? sum.values / sum.weights : kNaN;
        }
      }
    });
    return out;
  }

 private:
  std::int64_t num_rows() const { return lattice_.dims[1] * lattice_.dims[2]; }

  Vec4 start_of(std::int64_t row) const {
    const Index3 sample{0, row % lattice_.dims[1], row / lattice_.dims[1]};
    return frame_.from_plane(lattice_.world_from_index * lattice_.index_position(sample));
  }

  // Half a spacing beyond the outermost samples there is still something.
  bool is_in_data(const Vec4& at) const {
    const Vec4 beyond = Vec4::Constant(0.5);
    return ((at + beyond).array() >= 0).all() &&
           ((at - beyond).array() <= space_time_.size().array()).all();
  }

  void add_to_row(std::int64_t row, std::int64_t step, const std::vector<float>& values) {
    const Vec4 start = start_of(row);
    const double time = space_time_.step_distance() * static_cast<double>(step);
    // Samples whose time is in reach of the step.
    double first = 0;
    auto last = static_cast<double>(lattice_.dims[0] - 1);
    if (std::abs(along_row_[3]) > 1e-12) {
      double from = (time - kReach - start[3]) / along_row_[3];
      double until = (time + kReach - start[3]) / along_row_[3];
      if (from > until) std::swap(from, until);
      first = std::max(first, std::ceil(from));
      last = std::min(last, std::floor(until));
    } else if (std::abs(time - start[3]) > kReach) {
      return;
    }
    const double shift = space_time_.shift_of(step);
    for (auto i = static_cast<std::int64_t>(first); static_cast<double>(i) <= last; ++i) {
      const Vec4 at = start + static_cast<double>(i) * along_row_;
      if (is_in_data(at))
        add_to_sample(at, kernel_at(at[3] - time), shift, values,
                      sums_[static_cast<std::size_t>(row * lattice_.dims[0] + i)]);
    }
  }

  void add_to_sample(const Vec4& at, double weight_in_time, double shift,
                     const std::vector<float>& values, Sum& sum) const {
    const Index3& dims = space_time_.dims;
    const double scale = space_time_.scale();
    const AxisTaps x = taps_at(at[0], scale, shift, dims[0]);
    const AxisTaps y = taps_at(at[1], scale, shift, dims[1]);
    const AxisTaps z = taps_at(at[2], scale, shift, dims[2]);
    for (int k = 0; k < z.count; ++k) {
      const double weight_z = weight_in_time * z.weights[static_cast<std::size_t>(k)];
      for (int j = 0; j < y.count; ++j) {
        const double weight_y = weight_z * y.weights[static_cast<std::size_t>(j)];
        const float* from =
            values.data() + x.first + dims[0] * (y.first + j + dims[1] * (z.first + k));
        for (int i = 0; i < x.count; ++i) {
          const auto weight = static_cast<float>(weight_y * x.weights[static_cast<std::size_t>(i)]);
          const bool exists = std::isfinite(from[i]);
          sum.values += exists ? weight * from[i] : 0.0F;
          sum.weights += exists ? weight : 0.0F;
          sum.missing += exists ? 0.0F : weight;
        }
      }
    }
  }

  const SpaceTime& space_time_;
  const HyperplaneFrame& frame_;
  const LatticeGeometry& lattice_;  // its world is the plane
  const HypersliceOptions& options_;
  Vec4 along_row_;  // from a sample of a row to the next
  std::vector<Sum> sums_;
};

Dataset interpolated(const Series& series, const StepValues& steps, const SpaceTime& space_time,
                     const HyperplaneFrame& frame, const HypersliceOptions& options) {
  const LatticeGeometry in_plane =
      lattice_in_plane(frame, options.lattice.value_or(own_kind(series)), options.spacing);
  PlaneSums sums(space_time, frame, in_plane, options);
  for (std::int64_t step = 0; step < series.num_steps(); ++step) {
    // A step that the plane does not come near is not read.
    if (frame.dropped() == 3 && frame.is_across_axis() &&
        std::abs(frame.place() - space_time.step_distance() * static_cast<double>(step)) > kReach)
      continue;
    sums.add(step, steps.at(step));
  }
  Dataset out = described(steps);
  out.lattice = in_plane;
  out.lattice.world_from_index = frame.world_from_plane() * in_plane.world_from_index;
  out.arrays.push_back(
      model::float_array(described_array(steps), sums.values(), num_samples(in_plane.dims)));
  return out;
}

// --- sums along one axis of space

// The planes of a half, or of a step, that a slice across an axis is made of: their shares in it,
// and in what moves, of a half by four steps.
struct PlaneShares {
  std::vector<StepWeight> shares, moving;
};

PlaneShares shares_of_planes(const SpaceTime& space_time, int axis, double place, int half,
                             TimeFilter filter) {
  const std::int64_t size = space_time.dims[static_cast<std::size_t>(axis)];
  std::vector<double> places;
  if (space_time.kind == SeriesKind::kSteps) {
    for (std::int64_t i = 0; i < size; ++i) places.push_back(static_cast<double>(i));
    return {weights_of_steps(places, std::clamp(place, 0.0, places.back())), {}};
  }
  // As if space were time: the halves' planes follow each other.
  for (std::int64_t i = 0; i < 2 * size; ++i)
    places.push_back(static_cast<double>(i) * space_time.step_distance());
  place = std::clamp(place, 0.0, places.back());
  PlaneShares planes{weights_of_half(places, half, place, filter), {}};
  if (filter == TimeFilter::kFourSteps)
    planes.moving = model::moving_weights_of_half(places, half, place);
  for (std::vector<StepWeight>* const shares : {&planes.shares, &planes.moving}) {
    for (StepWeight& share : *shares) share.step /= 2;
  }
  return planes;
}

// A step's plane across the axis, made of several: rows of what is left of the axes.
void add_plane(const std::vector<float>& values, const Index3& dims, int axis,
               const std::vector<StepWeight>& shares, const Index3& out_dims,
               std::int64_t layer_stride, float* to) {
  std::array<std::int64_t, 3> in_stride{1, dims[0], dims[0] * dims[1]};
  const std::array<std::int64_t, 3> out_stride{1, out_dims[0], layer_stride};
  const int u = axis == 0 ? 1 : 0;
  const int v = axis == 2 ? 1 : 2;
  for (std::int64_t j = 0; j < dims[static_cast<std::size_t>(v)]; ++j) {
    for (std::int64_t i = 0; i < dims[static_cast<std::size_t>(u)]; ++i) {
      const float* from = values.data() + i * in_stride[static_cast<std::size_t>(u)] +
                          j * in_stride[static_cast<std::size_t>(v)];
      float sum = 0;
      for (const StepWeight& share : shares)
        sum += static_cast<float>(share.weight) *
               from[share.step * in_stride[static_cast<std::size_t>(axis)]];
      to[i * out_stride[static_cast<std::size_t>(u)] +
         j * out_stride[static_cast<std::size_t>(v)]] = sum;
    }
  }
}

Dataset across_axis(const Series& series, const StepValues& steps, const SpaceTime& space_time,
                    const HyperplaneFrame& frame, const HypersliceOptions& options) {
  const bool is_staggered = space_time.kind == SeriesKind::kStaggered;
  const int halves = is_staggered ? 2 : 1;
  const int axis = frame.dropped();
  // Whole pairs of steps: both halves have as many.
  const std::int64_t count = series.num_steps() / halves;
  Dataset out = described(steps);
  out.lattice.world_from_index = space_time.world;
  out.lattice.kind = own_kind(series);
  out.lattice.dims = space_time.dims;
  out.lattice.dims[static_cast<std::size_t>(axis)] = count;
  out.lattice.dims[2] *= halves;
  const Index3& dims = out.lattice.dims;
  const std::int64_t layer = dims[0] * dims[1];
  Floats values = model::new_floats(num_samples(dims));
  const bool takes_four = is_staggered && options.filter == TimeFilter::kFourSteps;
  const Index3 half_dims{dims[0], dims[1], dims[2] / halves};
  std::array<Floats, 2> moving;
  if (takes_four) {
    for (Floats& half : moving) half = model::new_floats(num_samples(half_dims));
  }
  for (std::int64_t step = 0; step < count * halves; ++step) {
    const auto half = static_cast<int>(step % halves);
    const PlaneShares planes =
        shares_of_planes(space_time, axis, frame.place(), half, options.filter);
    const auto add = [&](const std::vector<StepWeight>& shares, std::int64_t layer_stride,
                         float* to) {
      const std::array<std::int64_t, 3> step_stride{1, dims[0], layer_stride};
      add_plane(steps.at(step), space_time.dims, axis, shares, dims, layer_stride,
                to + step / halves * step_stride[static_cast<std::size_t>(axis)]);
    };
    add(planes.shares, halves * layer, values.get() + half * layer);
    if (takes_four) add(planes.moving, layer, moving[static_cast<std::size_t>(half)].get());
  }
  if (takes_four)
    model::take_out_alternation(moving, half_dims, 1, {options.threads, options.stop},
                                values.get());
  if (count * halves < series.num_steps())
    out.notes.push_back(fmt::format("{}: the last of {} steps is left out, which has no other half",
                                    out.source, series.num_steps()));
  out.arrays.push_back(model::float_array(described_array(steps), values, num_samples(dims)));
  return out;
}

Dataset across_time(const Series& series, const StepValues& steps, const SpaceTime& space_time,
                    const HyperplaneFrame& frame, const HypersliceOptions& options) {
  const double share = space_time.size()[3] > 0 ? frame.place() / space_time.size()[3] : 0.0;
  const double time =
      std::clamp(space_time.first_time + share * (space_time.last_time - space_time.first_time),
                 space_time.first_time, space_time.last_time);
  Dataset slice = slice_at_time(series, time, {options.filter, options.threads, options.stop});
  const DataArray taken = slice.array(steps.array().name);
  const model::ScalarSamples samples =
      model::take_component(taken, {options.component, true, options.threads, options.stop});
  Dataset out = described(steps);
  out.lattice = slice.lattice;
  DataArray array = described_array(steps);
  array.num_tuples = taken.num_tuples;
  array.bytes = samples.bytes;
  out.arrays.push_back(std::move(array));
  return out;
}

// --- extraction

// Half-axes of what the plane's unit ball is in the world, and the rotation that they are after.
struct Ellipsoid {
  Vec3 axes;
  Eigen::Quaterniond rotation;
};

Ellipsoid ball_in_world(const Affine3& world_from_plane) {
  const Eigen::JacobiSVD<Mat3> svd(world_from_plane.linear(), Eigen::ComputeFullU);
  Mat3 directions = svd.matrixU();
  if (directions.determinant() < 0) directions.col(2) = -directions.col(2);
  return {svd.singularValues(), Eigen::Quaterniond(directions)};
}

template <class T>
DataArray numbers(const std::string& name, int num_components, const std::vector<T>& values) {
  const auto memory = std::make_shared<std::vector<T>>(values);
  DataArray array;
  array.name = name;
  array.type = std::is_same_v<T, double> ? ScalarType::kFloat64 : ScalarType::kFloat32;
  array.num_components = num_components;
  array.num_tuples = static_cast<std::int64_t>(values.size()) / num_components;
  array.bytes = {memory, std::as_bytes(std::span<const T>(*memory))};
  return array;
}

// What the kernels of an endless lattice sum to on average: the integral of exp(-2 d^2) over space
// and time, times the samples there are in a unit of it.
double mean_sum(const SpaceTime& space_time) {
  constexpr double kIntegral = 0.25 * std::numbers::pi * std::numbers::pi;
  return kIntegral / (std::pow(space_time.scale(), 3) * space_time.step_distance());
}

Dataset extracted(const Series& series, const StepValues& steps, const SpaceTime& space_time,
                  const HyperplaneFrame& frame, const HypersliceOptions& options) {
  const Index3& dims = space_time.dims;
  const Affine3 world = frame.world_from_plane();
  const double per_kernel = 1 / mean_sum(space_time);
  std::vector<double> positions;
  std::vector<float> weights, values;
  for (std::int64_t step = 0; step < series.num_steps(); ++step) {
    const std::vector<float> here = steps.at(step);
    const double shift = space_time.shift_of(step);
    Vec4 at;
    at[3] = space_time.step_distance() * static_cast<double>(step);
    const float* value = here.data();
    for (std::int64_t k = 0; k < dims[2]; ++k) {
      at[2] = space_time.scale() * static_cast<double>(k) + shift;
      if (options.stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "slicing was cancelled");
      for (std::int64_t j = 0; j < dims[1]; ++j) {
        at[1] = space_time.scale() * static_cast<double>(j) + shift;
        for (std::int64_t i = 0; i < dims[0]; ++i, ++value) {
          at[0] = space_time.scale() * static_cast<double>(i) + shift;
          const double distance = frame.distance(at);
          if (std::abs(distance) > kReach || !std::isfinite(*value)) continue;
          const Vec3 place = world * frame.to_plane(at);
          positions.insert(positions.end(), place.data(), place.data() + 3);
          weights.push_back(static_cast<float>(per_kernel * kernel_at(distance)));
          values.push_back(*value);
        }
      }
    }
  }
  if (values.empty()) refuse("there is no sample within 2 T of the plane");
  const Ellipsoid ball = ball_in_world(world);
  std::vector<float> scales, rotations;
  for (std::size_t n = 0; n < values.size(); ++n) {
    // A kernel of exp(-2 d^2) has a sigma of half a T.
    for (int a = 0; a < 3; ++a) scales.push_back(static_cast<float>(0.5 * ball.axes[a]));
    for (const double q :
         {ball.rotation.w(), ball.rotation.x(), ball.rotation.y(), ball.rotation.z()})
      rotations.push_back(static_cast<float>(q));
  }
  Dataset out = described(steps);
  out.kind = DatasetKind::kKernels;
  out.reconstruction = Reconstruction::kNormalized;
  out.positions = numbers("positions", 3, positions);
  DataArray array = numbers(steps.array().name, 1, values);
  array.unit = steps.array().unit;
  out.arrays = {std::move(array), numbers("scale", 3, scales), numbers("rotation", 4, rotations),
                numbers("weight", 1, weights)};
  return out;
}

}  // namespace

Dataset hyperslice(const Series& series, const Hyperplane& plane,
                   const HypersliceOptions& options) {
  if (!(options.spacing > 0) || !std::isfinite(options.spacing))
    refuse(fmt::format("spacing = {}: must be finite and > 0", options.spacing));
  try {
    const StepValues steps(series, options);
    const SpaceTime space_time = space_time_of(series, steps.first());
    const HyperplaneFrame frame(space_time, plane);
    const bool is_moment = frame.is_across_axis() && frame.dropped() == 3;
    const bool is_on_own_lattice =
        options.spacing == 1 && options.lattice.value_or(own_kind(series)) == own_kind(series);
    const bool is_along_one =
        options.method == SliceMethod::kInterpolated && frame.is_across_axis() && is_on_own_lattice;
    const bool is_exact = options.filter == TimeFilter::kExact;
    if (is_moment && is_along_one && (!is_exact || space_time.kind == SeriesKind::kStaggered))
      return across_time(series, steps, space_time, frame, options);
    if (series.num_steps() > 1) model::require_even_steps(series);
    if (is_along_one && !is_exact) return across_axis(series, steps, space_time, frame, options);
    return options.method == SliceMethod::kExtracted
               ? extracted(series, steps, space_time, frame, options)
               : interpolated(series, steps, space_time, frame, options);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory, "hyperslice: no memory for the slice");
  }
}

}  // namespace ovoid
