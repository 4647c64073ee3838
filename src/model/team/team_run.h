// SPDX-License-Identifier: Apache-2.0
// Numbers of all processes of a run; of a run without a team its own. All processes call these, at
// the same places.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "data/kernels/letters.h"
#include "model/particles/kernel_parts.h"

namespace ovoid::model {

template <class T>
T total_of(const ModelRun& run, T own) {
  if (run.team == nullptr) return own;
  T total{};
  for (const std::vector<T>& from : data::gathered(*run.team, std::span<const T>(&own, 1)))
    total += from.at(0);
  return total;
}

template <class T>
T least_of(const ModelRun& run, T own) {
  if (run.team == nullptr) return own;
  for (const std::vector<T>& from : data::gathered(*run.team, std::span<const T>(&own, 1)))
    own = std::min(own, from.at(0));
  return own;
}

template <class T>
T greatest_of(const ModelRun& run, T own) {
  return -least_of(run, -own);
}

// Number by number.
inline void add_of_all(const ModelRun& run, std::vector<double>& own) {
  if (run.team == nullptr) return;
  std::vector<double> sums(own.size());
  for (const std::vector<double>& from : data::gathered(*run.team, std::span<const double>(own))) {
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += from.at(i);
  }
  own = std::move(sums);
}

// Of all processes, one behind the other.
template <class T>
std::vector<T> joined(const ModelRun& run, std::vector<T> own) {
  return run.team != nullptr ? data::joined(*run.team, std::span<const T>(own)) : own;
}

}  // namespace ovoid::model
