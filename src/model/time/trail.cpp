// SPDX-License-Identifier: Apache-2.0
//
// Steps -> their mean over some time before a moment. One step after the other is added, so that
// two volumes are all that is held.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "model/time/step_blend.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"

namespace ovoid {
namespace {

using model::Floats;

void require_trail(double length, double decay) {
  if (!(length > 0) || !std::isfinite(length))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("length = {}: must be finite and > 0", length));
  if (!(decay >= 0 && decay <= TrailOptions::kMaxDecay))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("decay = {}: must be from 0 to {}", decay, TrailOptions::kMaxDecay));
}

// Where `time` lies between its neighbours among rising times: share 1 - b of number a, b of a + 1.
struct Between {
  std::size_t a;
  double b;
};

Between between(const std::vector<double>& times, double time) {
  if (times.size() == 1 || time <= times.front()) return {0, 0};
  if (time >= times.back()) return {times.size() - 2, 1};
  const auto behind = std::upper_bound(times.begin(), times.end(), time) - times.begin();
  const auto a = static_cast<std::size_t>(behind) - 1;
  return {a, (time - times[a]) / (times[a + 1] - times[a])};
}

// The integral over [from, until] of the steps at `times`, linear between them and constant beyond,
// under a weight that falls by 1/e in `fall` towards earlier times; by Gauss's rule of three
// points, piece by piece. One weight per step, not divided by their sum.
std::vector<double> integrated(const std::vector<double>& times, double from, double until,
                               double fall) {
  constexpr double kPlace[] = {-0.7745966692414834, 0.0, 0.7745966692414834};
  constexpr double kShare[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  std::vector<double> weights(times.size(), 0.0);
  std::vector<double> ends{from};
  std::copy_if(times.begin(), times.end(), std::back_inserter(ends),
               [&](double t) { return from < t && t < until; });
  ends.push_back(until);
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double length = ends[i + 1] - ends[i];
    // So short that the weight hardly bends over a piece; far from the end it is nothing at all.
    const int pieces = static_cast<int>(std::clamp(std::ceil(2 * length / fall), 1.0, 1000.0));
    const double piece = length / pieces;
    for (int p = 0; p < pieces; ++p) {
      for (int k = 0; k < 3; ++k) {
        const double time = ends[i] + (p + 0.5 + 0.5 * kPlace[k]) * piece;
        const double weight = std::exp((time - until) / fall) * piece * kShare[k];
        const Between at = between(times, time);
        weights[at.a] += weight * (1 - at.b);
        if (at.b > 0) weights[at.a + 1] += weight * at.b;
      }
    }
  }
  return weights;
}

// Those of the steps first, first + stride, ...
std::vector<StepWeight> trail_weights(const std::vector<double>& times, std::int64_t first,
                                      std::int64_t stride, double time, double length,
                                      double decay) {
  require_trail(length, decay);
  weights_of_steps(times, time);  // refuses a time out of range
  if (time == times.front()) return {};
  std::vector<double> own;
  for (auto i = static_cast<std::size_t>(first); i < times.size();
       i += static_cast<std::size_t>(stride))
    own.push_back(times[i]);
  const double fall = decay > 0 ? length / decay : 1e300;
  const std::vector<double> shares =
      integrated(own, std::max(time - length, times.front()), time, fall);
  double sum = 0;
  for (const double share : shares) sum += share;
  std::vector<StepWeight> weights;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (shares[i] > 0)
      weights.push_back({first + stride * static_cast<std::int64_t>(i), shares[i] / sum});
  }
  return weights;
}

void require_lattice(const Dataset& dataset) {
  if (dataset.kind == DatasetKind::kLattice) return;
  throw Error(ErrorCode::kInvalidArgument, fmt::format("'{}': a trail takes lattices, this is {}",
                                                       dataset.source, name_of(dataset.kind)));
}

// Adds up steps, whose arrays go where `target` says.
template <class Target>
void add_up(const Series& series, const std::vector<StepWeight>& weights, std::stop_token stop,
            const std::vector<DataArray>& likes, const Target& target) {
  bool adds = false;
  for (const auto& [step, weight] : weights) {
    const std::vector<model::HeldStep> held = {{series.step(step, stop), weight}};
    require_lattice(*held[0].dataset);
    for (std::size_t i = 0; i < likes.size(); ++i) model::blend(held, likes[i], target(i, adds));
    adds = true;
  }
}

Dataset trail_of_steps(const Series& series, const std::vector<StepWeight>& weights,
                       const TrailOptions& options) {
  Dataset out = *series.step(weights.back().step, options.stop);
  require_lattice(out);
  const std::vector<DataArray> likes = out.arrays;
  std::vector<Floats> sums;
  sums.reserve(likes.size());
  for (const DataArray& like : likes)
    sums.push_back(model::new_floats(like.num_tuples * like.num_components));
  add_up(series, weights, options.stop, likes, [&](std::size_t i, bool adds) {
    return model::whole(sums[i].get(), options.threads, options.stop, adds);
  });
  for (std::size_t i = 0; i < likes.size(); ++i)
    out.arrays[i] = model::float_array(likes[i], sums[i], likes[i].num_tuples);
  return out;
}

Dataset trail_of_halves(const Series& series, double time, const TrailOptions& options) {
  const auto first = series.step(0, options.stop);
  require_lattice(*first);
  const std::vector<DataArray>& likes = first->arrays;
  std::vector<Floats> sums;
  sums.reserve(likes.size());
  for (const DataArray& like : likes)
    sums.push_back(model::new_floats(2 * like.num_tuples * like.num_components));
  for (int half = 0; half < 2; ++half) {
    add_up(series, weights_of_half_trail(series.times(), half, time, options.length, options.decay),
           options.stop, likes, [&](std::size_t i, bool adds) {
             const std::int64_t layer =
                 likes[i].num_tuples / first->lattice.dims[2] * likes[i].num_components;
             return model::every_second_layer(sums[i].get(), layer, half, options.threads,
                                              options.stop, adds);
           });
  }
  Dataset out = model::body_centred_of(*first);
  for (std::size_t i = 0; i < likes.size(); ++i)
    out.arrays.push_back(model::float_array(likes[i], sums[i], 2 * likes[i].num_tuples));
  return out;
}

}  // namespace

std::vector<StepWeight> weights_of_trail(const std::vector<double>& times, double time,
                                         double length, double decay) {
  return trail_weights(times, 0, 1, time, length, decay);
}

std::vector<StepWeight> weights_of_half_trail(const std::vector<double>& times, int half,
                                              double time, double length, double decay) {
  return trail_weights(times, half, 2, time, length, decay);
}

Dataset trail_before(const Series& series, double time, const TrailOptions& options) {
  try {
    const std::vector<StepWeight> weights =
        weights_of_trail(series.times(), time, options.length, options.decay);
    if (weights.empty()) {
      Dataset slice =
          slice_at_time(series, time, {.threads = options.threads, .stop = options.stop});
      require_lattice(slice);
      return slice;
    }
    return series.source().kind() == SeriesKind::kStaggered
               ? trail_of_halves(series, time, options)
               : trail_of_steps(series, weights, options);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory, fmt::format("time = {:g}: no memory for a trail", time));
  }
}

}  // namespace ovoid
