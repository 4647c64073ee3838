// SPDX-License-Identifier: Apache-2.0
#include "experiments/removed_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "model/lattice/convert.h"

namespace ovoid::experiments {

namespace {

// Of larger sets the middle: more says no more, and takes longer.
constexpr std::int64_t kMostSamples = 160;
// Spacings of what is kept: places are so far from the faces.
constexpr std::int64_t kFromFaces = 4;
// Taps of the band limit to either side.
constexpr int kFilterReach = 24;

// Samples of one component, x fastest.
struct Volume {
  Index3 dims;
  std::vector<float> values;

  float at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return values[static_cast<std::size_t>(i + dims[0] * (j + dims[1] * k))];
  }
};

Volume middle_of(const Dataset& dataset) {
  const DataArray& array = dataset.array();
  const model::ScalarSamples all = model::take_component(array, {0, true, 0, {}});
  const Index3 dims = dataset.lattice.dims;
  Volume middle;
  Index3 first{};
  for (std::size_t a = 0; a < 3; ++a) {
    middle.dims[a] = std::min(dims[a], kMostSamples);
    first[a] = (dims[a] - middle.dims[a]) / 2;
  }
  for (std::int64_t k = 0; k < middle.dims[2]; ++k) {
    for (std::int64_t j = 0; j < middle.dims[1]; ++j) {
      const float* row =
          all.writable + first[0] + dims[0] * (first[1] + j + dims[1] * (first[2] + k));
      middle.values.insert(middle.values.end(), row, row + middle.dims[0]);
    }
  }
  return middle;
}

// A windowed sinc of half the band, mirrored at the faces.
void limit_band(Volume& volume) {
  std::vector<double> taps;
  double sum = 0;
  for (int n = -kFilterReach; n <= kFilterReach; ++n) {
    const double x = std::numbers::pi * n / 2;
    const double window = 0.5 + 0.5 * std::cos(std::numbers::pi * n / (kFilterReach + 1));
    taps.push_back((n == 0 ? 1.0 : std::sin(x) / x) * window);
    sum += taps.back();
  }
  std::int64_t stride = 1;
  for (const std::int64_t size : volume.dims) {
    std::vector<double> line(static_cast<std::size_t>(size));
    const auto count = static_cast<std::int64_t>(volume.values.size());
    for (std::int64_t start = 0; start < count; ++start) {
      if (start / stride % size != 0) continue;
      for (std::int64_t n = 0; n < size; ++n) {
        double value = 0;
        for (int t = -kFilterReach; t <= kFilterReach; ++t) {
          std::int64_t at = n + t;
          while (at < 0 || at >= size) at = at < 0 ? -at - 1 : 2 * size - 1 - at;
          const int tap = t + kFilterReach;
          value +=
              taps[static_cast<std::size_t>(tap)] *
              static_cast<double>(volume.values[static_cast<std::size_t>(start + at * stride)]);
        }
        line[static_cast<std::size_t>(n)] = value / sum;
      }
      for (std::int64_t n = 0; n < size; ++n)
        volume.values[static_cast<std::size_t>(start + n * stride)] =
            static_cast<float>(line[static_cast<std::size_t>(n)]);
    }
    stride *= size;
  }
}

std::vector<double> errors_of(const Volume& volume, const std::vector<FieldWay>& ways,
                              int num_places) {
  const Index3 dims{(volume.dims[0] + 1) / 2, (volume.dims[1] + 1) / 2, (volume.dims[2] + 1) / 2};
  const Dataset kept = dataset_of(dims, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return volume.at(2 * i, 2 * j, 2 * k);
  });
  const auto [lo, hi] = std::minmax_element(volume.values.begin(), volume.values.end());
  std::vector<double> decibels;
  for (const FieldWay& way : ways) {
    const PointField field = way.make(kept);
    std::mt19937_64 random(1);
    double squares = 0;
    for (int n = 0; n < num_places;) {
      Index3 at;
      for (std::size_t a = 0; a < 3; ++a) {
        const std::int64_t margin = std::min(kFromFaces, (dims[a] - 1) / 3);
        std::uniform_int_distribution<std::int64_t> along(2 * margin, 2 * (dims[a] - 1 - margin));
        at[a] = along(random);
      }
      if (at[0] % 2 == 0 && at[1] % 2 == 0 && at[2] % 2 == 0) continue;
      const Vec3 place(static_cast<double>(at[0]), static_cast<double>(at[1]),
                       static_cast<double>(at[2]));
      const double error =
          field(0.5 * place).value - static_cast<double>(volume.at(at[0], at[1], at[2]));
      squares += error * error;
      ++n;
    }
    decibels.push_back(
        20 * std::log10(static_cast<double>(*hi - *lo) / std::sqrt(squares / num_places)));
  }
  return decibels;
}

// Values held to the range of the samples that lie less than `reach` around a place.
PointField bounded(const Dataset& dataset, const PointField& field, int reach) {
  const DataArray& array = dataset.array();
  const auto* values = reinterpret_cast<const float*>(array.bytes.view.data());
  const Index3 dims = dataset.lattice.dims;
  return [=, owner = array.bytes.owner](const Vec3& place) {
    reference::FieldSample sample = field(place);
    double lo = std::numeric_limits<double>::infinity();
    double hi = -lo;
    Index3 cell;
    for (std::size_t a = 0; a < 3; ++a)
      cell[a] = static_cast<std::int64_t>(std::floor(place[static_cast<int>(a)]));
    for (int k = 1 - reach; k <= reach; ++k) {
      for (int j = 1 - reach; j <= reach; ++j) {
        for (int i = 1 - reach; i <= reach; ++i) {
          const std::int64_t x = std::clamp<std::int64_t>(cell[0] + i, 0, dims[0] - 1);
          const std::int64_t y = std::clamp<std::int64_t>(cell[1] + j, 0, dims[1] - 1);
          const std::int64_t z = std::clamp<std::int64_t>(cell[2] + k, 0, dims[2] - 1);
          const auto value = static_cast<double>(values[x + dims[0] * (y + dims[1] * z)]);
          lo = std::min(lo, value);
          hi = std::max(hi, value);
        }
      }
    }
    sample.value = std::clamp(sample.value, lo, hi);
    return sample;
  };
}

}  // namespace

std::vector<FieldWay> field_ways() {
  const auto by = [](const KernelChoice& choice) -> FieldWay {
    return {choice.name, [choice](const Dataset& d) { return kernel_points(d, choice); }};
  };
  const auto held = [](int reach) -> FieldWay {
    return {fmt::format("default, held to the range of {0} x {0} x {0} samples", 2 * reach),
            [reach](const Dataset& d) {
              return bounded(d, kernel_points(d, default_choice()), reach);
            }};
  };
  return {{"trilinear", trilinear_points},
          by(normalized_choice(0.5, 2, false)),
          by(normalized_choice(0.5, 2, true)),
          by(normalized_choice(0.65, 2, true)),
          by(catmull_rom_choice()),
          by(default_choice()),
          held(1),
          held(2)};
}

RemovedErrors measure_removed(const Dataset& dataset, const std::vector<FieldWay>& ways,
                              int num_places) {
  Volume volume = middle_of(dataset);
  RemovedErrors errors;
  errors.as_they_are = errors_of(volume, ways, num_places);
  limit_band(volume);
  errors.band_limited = errors_of(volume, ways, num_places);
  return errors;
}

}  // namespace ovoid::experiments
