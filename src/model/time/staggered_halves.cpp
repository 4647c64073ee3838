// SPDX-License-Identifier: Apache-2.0
#include "model/time/staggered_halves.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "data/parallel.h"

namespace ovoid::model {
namespace {

constexpr std::int64_t kNumbersPerTask = 65536;

std::int64_t num_steps_of_half(const std::vector<double>& times, int half) {
  return (static_cast<std::int64_t>(times.size()) - half + 1) / 2;
}

// Where a time lies among a half's steps, in their own numbers: by up to one outside of them.
double own_place(const std::vector<double>& times, int half, double time) {
  const std::int64_t count = num_steps_of_half(times, half);
  const auto at = [&](std::int64_t l) { return times[static_cast<std::size_t>(2 * l + half)]; };
  if (count == 1) return 0;
  std::int64_t l = 0;
  while (l + 2 < count && at(l + 1) <= time) ++l;
  return static_cast<double>(l) + (time - at(l)) / (at(l + 1) - at(l));
}

// The cubic through the samples whose slopes are those of their neighbours.
double cubic(double d) {
  if (d < 1) return (1.5 * d - 2.5) * d * d + 1;
  return d < 2 ? ((-0.5 * d + 2.5) * d - 4) * d + 2 : 0;
}

// The mean of what is linear from sample to sample, from `reach` before to `reach` behind.
double mean_of_linear(double d, double reach) {
  const auto area_until = [](double x) {  // under a tent from -1 to 1
    const double t = std::clamp(x, -1.0, 1.0);
    return t < 0 ? 0.5 * (1 + t) * (1 + t) : 1 - 0.5 * (1 - t) * (1 - t);
  };
  if (reach < 1e-6) return std::max(0.0, 1 - d);
  return (area_until(d + reach) - area_until(d - reach)) / (2 * reach);
}

using StepsOfHalf = std::map<std::int64_t, double>;  // weights, by the half's own numbers

StepsOfHalf cubic_weights(const std::vector<double>& times, int half, double time) {
  const std::int64_t last = num_steps_of_half(times, half) - 1;
  const double place = own_place(times, half, time);
  const auto before = static_cast<std::int64_t>(std::floor(place));
  StepsOfHalf weights;
  for (std::int64_t l = before - 1; l <= before + 2; ++l) {
    const double weight = cubic(std::abs(static_cast<double>(l) - place));
    const std::int64_t end = std::clamp<std::int64_t>(l, 0, last);
    weights[end] += weight;
    if (l == end || last == 0) continue;
    // Beyond the ends it goes on in a straight line.
    const double slope = weight * static_cast<double>(std::abs(l - end));
    weights[end] += slope;
    weights[l < end ? end + 1 : end - 1] -= slope;
  }
  return weights;
}

// Over the same time in both halves: that around `time`, or the nearest that both have.
StepsOfHalf mean_weights(const std::vector<double>& times, int half, double time) {
  const std::int64_t last = num_steps_of_half(times, half) - 1;
  const double shift = 0.5 * half;  // the odd half lies half a step behind the even one
  const double from = 0.5;
  const double to = std::min(static_cast<double>(num_steps_of_half(times, 0) - 1),
                             static_cast<double>(num_steps_of_half(times, 1)) - 0.5);
  const double reach = std::clamp(0.5 * (to - from), 0.0, 1.0);
  const double place = std::clamp(
      std::min(std::max(own_place(times, half, time) + shift, from + reach), to - reach) - shift,
      0.0, static_cast<double>(last));
  StepsOfHalf weights;
  for (std::int64_t l = 0; l <= last; ++l) {
    const double weight = mean_of_linear(std::abs(static_cast<double>(l) - place), reach);
    if (weight > 0) weights[l] = weight;
  }
  return weights;
}

std::vector<StepWeight> as_steps(const StepsOfHalf& weights, int half) {
  std::vector<StepWeight> steps;
  for (const auto& [l, weight] : weights) {
    if (weight != 0) steps.push_back({2 * l + half, weight});
  }
  return steps;
}

// The halves, half of what each sample has more than the mean of its eight neighbours in the other
// half: at the faces, of those that there are.
std::array<Floats, 2> alternating(const std::array<Floats, 2>& halves, const Index3& dims,
                                  int components, const HalvesOptions& options) {
  const std::int64_t row = dims[0] * components;
  std::array<Floats, 2> out;
  for (int half = 0; half < 2; ++half) {
    const float* const own = halves[static_cast<std::size_t>(half)].get();
    const float* const other = halves[static_cast<std::size_t>(1 - half)].get();
    Floats& made = out[static_cast<std::size_t>(half)];
    made = new_floats(dims[1] * dims[2] * row);
    const std::int64_t side = half == 0 ? -1 : 1;  // neighbours are at i and i + side
    const auto beside = [side](std::int64_t i, std::int64_t size) {
      return std::clamp<std::int64_t>(i + side, 0, size - 1);
    };
    data::parallel_ranges(
        {dims[1] * dims[2], kNumbersPerTask / row + 1, options.threads, options.stop},
        [&](std::int64_t begin, std::int64_t end) {
          // Of a row and the three beside it, and once more the sample at the face.
          std::vector<float> sums(static_cast<std::size_t>(row + components));
          float* const sum = sums.data() + (side < 0 ? components : 0);
          for (std::int64_t r = begin; r < end; ++r) {
            const std::int64_t y = r % dims[1];
            const std::int64_t z = r / dims[1];
            const auto row_at = [&](std::int64_t j, std::int64_t k) {
              return other + (k * dims[1] + j) * row;
            };
            const float* const a = row_at(y, z);
            const float* const b = row_at(beside(y, dims[1]), z);
            const float* const c = row_at(y, beside(z, dims[2]));
            const float* const d = row_at(beside(y, dims[1]), beside(z, dims[2]));
            for (std::int64_t i = 0; i < row; ++i) sum[i] = a[i] + b[i] + c[i] + d[i];
            if (side < 0)
              std::copy_n(sum, components, sums.data());
            else
              std::copy_n(sum + row - components, components, sum + row);
            const float* const from = own + r * row;
            float* const to = made.get() + r * row;
            for (std::int64_t i = 0; i < row; ++i) {
              const auto n = static_cast<std::size_t>(i);
              const float around = sums[n] + sums[n + static_cast<std::size_t>(components)];
              to[i] = 0.5F * (from[i] - around / 8);
            }
          }
        });
  }
  return out;
}

}  // namespace

double kernel_along_axis(double distance) { return std::exp(-2 * distance * distance); }

std::vector<StepWeight> kernel_weights_of_half(const std::vector<double>& times, int half,
                                               double time, double reach, double floor) {
  const std::int64_t count = num_steps_of_half(times, half);
  const double place =
      std::clamp(own_place(times, half, time), 0.0, static_cast<double>(count - 1));
  std::vector<StepWeight> weights;
  for (std::int64_t l = 0; l < count; ++l) {
    const double distance = kOwnSpacing * std::abs(static_cast<double>(l) - place);
    const double weight = distance <= reach ? kernel_along_axis(distance) - floor : 0.0;
    if (weight > 0) weights.push_back({2 * l + half, weight});
  }
  return weights;
}

std::vector<StepWeight> cubic_weights_of_half(const std::vector<double>& times, int half,
                                              double time) {
  return as_steps(cubic_weights(times, half, time), half);
}

std::vector<StepWeight> moving_weights_of_half(const std::vector<double>& times, int half,
                                               double time) {
  StepsOfHalf weights = cubic_weights(times, half, time);
  for (const auto& [l, weight] : mean_weights(times, half, time)) weights[l] -= weight;
  return as_steps(weights, half);
}

void take_out_alternation(std::array<Floats, 2> moving, const Index3& dims, int components,
                          const HalvesOptions& options, float* volume) {
  const std::int64_t layer = dims[0] * dims[1] * components;
  for (const Floats& half : moving) {
    data::parallel_ranges({layer * dims[2], kNumbersPerTask, options.threads, options.stop},
                          [&](std::int64_t begin, std::int64_t end) {
                            std::replace_if(
                                half.get() + begin, half.get() + end,
                                [](float v) { return std::isnan(v); }, 0.0F);
                          });
  }
  for (int pass = 0; pass < 2; ++pass) moving = alternating(moving, dims, components, options);
  data::parallel_ranges(
      {2 * dims[2], 1, options.threads, options.stop}, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t z = begin; z < end; ++z) {
          const float* from = moving[static_cast<std::size_t>(z % 2)].get() + z / 2 * layer;
          float* const to = volume + z * layer;
          for (std::int64_t i = 0; i < layer; ++i) to[i] -= from[i];
        }
      });
}

}  // namespace ovoid::model
