// SPDX-License-Identifier: Apache-2.0
// Where a fit looks, and what the field should be there.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "fit/source_kernels.h"
#include "ovoid/dataset.h"
#include "ovoid/model.h"

namespace ovoid::fit {

struct Places {
  std::vector<double> at;                    // [n, 3]
  std::vector<double> shares;                // [n] of the volume; their sum is about the whole's
  std::vector<std::vector<double>> targets;  // of each attribute [n]

  std::size_t count() const noexcept { return shares.size(); }
};

struct PlaceOptions {
  const KernelModelOptions& model;
  std::uint64_t seed = 1;
  std::size_t most = 0;  // places to fit to, about
  std::size_t test = 0;  // places to test at
  int threads = 1;
  std::stop_token stop{};
};

// Both sets know nothing of each other.
struct FitPlaces {
  Places seen;    // that the kernels are fitted to, in random order
  Places unseen;  // at random, evenly over the volume
};

// Of a mesh with values at its nodes: nodes and middles of cells, and random places in cells, where
// the values are interpolated. Of everything else: the kernels' centres and a random place near
// each, where the field is the source's.
FitPlaces make_places(const Dataset& dataset, const KernelField& field,
                      const SourceKernels& kernels, const PlaceOptions& options);

}  // namespace ovoid::fit
