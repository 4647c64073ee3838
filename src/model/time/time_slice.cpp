// SPDX-License-Identifier: Apache-2.0
//
// Steps -> a dataset at a time between them. For lattices the sum over time is one pass per step
// that has a share; what kExact adds are sums along each axis of the finished halves, because the
// four-dimensional Gaussian is a product.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <span>
#include <utility>

#include "data/bookkeeping.h"
#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "model/time/movement.h"
#include "model/time/staggered_halves.h"
#include "model/time/step_blend.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"

namespace ovoid {
namespace {

using model::Floats;
using model::HeldStep;

void require_time(const std::vector<double>& times, double time) {
  if (!std::isfinite(time))
    throw Error(ErrorCode::kInvalidArgument, fmt::format("time = {}: must be finite", time));
  if (time < times.front() || time > times.back()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("time = {:g}: must be within the data's {:g} to {:g}", time,
                            times.front(), times.back()));
  }
}

void normalize(std::vector<StepWeight>& weights) {
  double sum = 0;
  for (const StepWeight& w : weights) sum += w.weight;
  for (StepWeight& w : weights) w.weight /= sum;
}

// All arrays that vary with time; the others are the first step's.
void blend_arrays(const std::vector<HeldStep>& steps, const TimeSliceOptions& options,
                  Dataset& into) {
  for (DataArray& array : into.arrays) {
    if (data::is_bookkeeping(into, array)) continue;
    const DataArray like = array;
    const Floats values = model::new_floats(like.num_tuples * like.num_components);
    model::blend(steps, like, model::whole(values.get(), options.threads, options.stop));
    array = model::float_array(like, values, like.num_tuples);
  }
}

Dataset moved(const std::vector<HeldStep>& steps, const TimeSliceOptions& options) {
  const HeldStep& before = steps[0];
  const HeldStep& behind = steps[1];
  const std::string difference = model::difference_of(*before.dataset, *behind.dataset);
  if (!difference.empty()) {
    Dataset nearest = before.weight >= behind.weight ? *before.dataset : *behind.dataset;
    nearest.notes.push_back(
        fmt::format("{}: step {}, the nearest: steps are not interpolated, since {}",
                    nearest.source, nearest.step, difference));
    return nearest;
  }
  Dataset out = *before.dataset;
  blend_arrays(steps, options, out);
  out.positions = model::moved_positions(*before.dataset, *behind.dataset, behind.weight);
  return out;
}

// --- lattices

Dataset between_steps(const std::vector<HeldStep>& steps, const TimeSliceOptions& options) {
  if (steps.size() == 1) return *steps[0].dataset;
  if (steps[0].dataset->kind != DatasetKind::kLattice) return moved(steps, options);
  Dataset out = *steps[0].dataset;
  blend_arrays(steps, options, out);
  return out;
}

// Two halves as the layers of one lattice.
Floats interleaved(const std::array<Floats, 2>& halves, const Index3& dims, int components) {
  const std::int64_t layer = dims[0] * dims[1] * components;
  Floats out = model::new_floats(2 * dims[2] * layer);
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    for (int half = 0; half < 2; ++half)
      std::copy_n(halves[static_cast<std::size_t>(half)].get() + z * layer, layer,
                  out.get() + (2 * z + half) * layer);
  }
  return out;
}

// Along one axis: out_i = sum of weight[k] * in_(i + first + k), over the samples that exist.
struct AxisStencil {
  std::vector<double> weight;
  std::int64_t first;

  // Calls use(offset, weight) for the samples that exist around number `at` of `size`.
  template <class Use>
  void for_each(std::int64_t at, std::int64_t size, const Use& use) const {
    for (std::size_t k = 0; k < weight.size(); ++k) {
      const std::int64_t offset = first + static_cast<std::int64_t>(k);
      if (at + offset >= 0 && at + offset < size) use(offset, weight[k]);
    }
  }
  double sum_at(std::int64_t at, std::int64_t size) const {
    double sum = 0;
    for_each(at, size, [&](std::int64_t, double w) { sum += w; });
    return sum;
  }
};

Floats along_axes(Floats in, const Index3& dims, int components, const AxisStencil& stencil,
                  const TimeSliceOptions& options) {
  constexpr std::int64_t kNumbersPerTask = 65536;
  std::int64_t stride = components;
  const std::int64_t count = num_samples(dims) * components;
  for (const std::int64_t size : dims) {
    Floats out = model::new_floats(count);
    data::parallel_ranges(
        {count / stride, kNumbersPerTask / stride + 1, options.threads, options.stop},
        [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t row = begin; row < end; ++row) {
            float* to = out.get() + row * stride;
            std::fill_n(to, stride, 0.0F);
            stencil.for_each(row % size, size, [&](std::int64_t offset, double w) {
              const float* from = in.get() + (row + offset) * stride;
              const auto weight = static_cast<float>(w);
              for (std::int64_t i = 0; i < stride; ++i) to[i] += weight * from[i];
            });
          }
        });
    in = std::move(out);
    stride *= size;
  }
  return in;
}

// Every sample of both halves under all kernels that reach it. In: the halves' sums over time and
// their weights' sums.
std::array<Floats, 2> exact_halves(const std::array<Floats, 2>& sums,
                                   const std::array<double, 2>& weights, const Index3& dims,
                                   int components, const TimeSliceOptions& options) {
  const double far = model::kernel_along_axis(model::kOwnSpacing);
  const double near = model::kernel_along_axis(1 / model::kOwnSpacing);
  const AxisStencil own{{far, 1, far}, -1};
  const AxisStencil of_other[2] = {{{near, near}, -1}, {{near, near}, 0}};
  const std::int64_t row = dims[0] * components;
  std::array<Floats, 2> out;
  for (std::size_t half = 0; half < 2; ++half) {
    const std::size_t other = 1 - half;
    const Floats from_own = along_axes(sums[half], dims, components, own, options);
    const Floats from_other = along_axes(sums[other], dims, components, of_other[half], options);
    out[half] = model::new_floats(dims[1] * dims[2] * row);
    // Sums of weights are products along the axes.
    const auto weight_at = [&](const AxisStencil& stencil, const Index3& at) {
      double product = 1;
      for (std::size_t a = 0; a < 3; ++a) product *= stencil.sum_at(at[a], dims[a]);
      return product;
    };
    data::parallel_ranges(
        {dims[1] * dims[2], 64, options.threads, options.stop},
        [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t r = begin; r < end; ++r) {
            for (std::int64_t i = 0; i < row; ++i) {
              const Index3 at{i / components, r % dims[1], r / dims[1]};
              const double weight = weights[half] * weight_at(own, at) +
                                    weights[other] * weight_at(of_other[half], at);
              const std::int64_t n = r * row + i;
              out[half][n] = static_cast<float>(
                  (static_cast<double>(from_own[n]) + static_cast<double>(from_other[n])) / weight);
            }
          }
        });
  }
  return out;
}

Dataset staggered(const Series& series, double time, const TimeSliceOptions& options) {
  const std::vector<double>& times = series.times();
  std::array<std::vector<HeldStep>, 2> halves;
  std::array<std::vector<HeldStep>, 2> moving;  // by four steps
  std::array<double, 2> sums{};
  for (int half = 0; half < 2; ++half) {
    const bool is_exact = options.filter == TimeFilter::kExact;
    const std::vector<StepWeight> weights =
        is_exact ? model::kernel_weights_of_half(times, half, time, model::kKernelSupport, 0)
                 : weights_of_half(times, half, time, options.filter);
    const auto h = static_cast<std::size_t>(half);
    halves[h] = model::hold(series, weights, options.stop);
    for (const StepWeight& w : weights) sums[h] += w.weight;
    if (options.filter == TimeFilter::kFourSteps)
      moving[h] =
          model::hold(series, model::moving_weights_of_half(times, half, time), options.stop);
  }
  const Dataset& first = *halves[0][0].dataset;
  const Index3 dims = first.lattice.dims;
  Dataset out = model::body_centred_of(first);
  for (const DataArray& like : first.arrays) {
    const std::int64_t count = like.num_tuples * like.num_components;
    const auto each_whole = [&](const std::array<std::vector<HeldStep>, 2>& steps) {
      std::array<Floats, 2> out_of;
      for (std::size_t half = 0; half < 2; ++half) {
        out_of[half] = model::new_floats(count);
        model::blend(steps[half], like,
                     model::whole(out_of[half].get(), options.threads, options.stop));
      }
      return out_of;
    };
    Floats both;
    if (options.filter == TimeFilter::kExact) {
      both = interleaved(exact_halves(each_whole(halves), sums, dims, like.num_components, options),
                         dims, like.num_components);
    } else {
      both = model::new_floats(2 * count);
      for (int half = 0; half < 2; ++half) {
        model::blend(halves[static_cast<std::size_t>(half)], like,
                     model::every_second_layer(both.get(), count / dims[2], half, options.threads,
                                               options.stop));
      }
      if (options.filter == TimeFilter::kFourSteps)
        model::take_out_alternation(each_whole(moving), dims, like.num_components,
                                    {options.threads, options.stop}, both.get());
    }
    out.arrays.push_back(model::float_array(like, both, 2 * like.num_tuples));
  }
  return out;
}

}  // namespace

std::vector<StepWeight> weights_of_steps(const std::vector<double>& times, double time) {
  require_time(times, time);
  const auto behind = std::lower_bound(times.begin(), times.end(), time);
  const auto step = behind - times.begin();
  if (*behind == time) return {{step, 1.0}};
  const double before = *(behind - 1);
  const double share = (time - before) / (*behind - before);
  return {{step - 1, 1 - share}, {step, share}};
}

std::vector<StepWeight> weights_of_half(const std::vector<double>& times, int half, double time,
                                        TimeFilter filter) {
  require_time(times, time);
  if (filter == TimeFilter::kFourSteps) return model::cubic_weights_of_half(times, half, time);
  const bool takes_two = filter == TimeFilter::kTwoSteps;
  const double reach = takes_two ? model::kOwnSpacing : model::kKernelSupport;
  const double floor = takes_two ? model::kernel_along_axis(model::kOwnSpacing) : 0.0;
  std::vector<StepWeight> weights = model::kernel_weights_of_half(times, half, time, reach, floor);
  normalize(weights);
  return weights;
}

Dataset slice_at_time(const Series& series, double time, const TimeSliceOptions& options) {
  try {
    if (series.source().kind() == SeriesKind::kStaggered) return staggered(series, time, options);
    return between_steps(model::hold(series, weights_of_steps(series.times(), time), options.stop),
                         options);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("time = {:g}: no memory for a step made of several", time));
  }
}

}  // namespace ovoid
