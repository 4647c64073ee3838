// SPDX-License-Identifier: Apache-2.0
// Where a fit looks, and what the field should be there.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <utility>
#include <vector>

#include "fit/source_kernels.h"
#include "model/noise.h"
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
  KernelModelOptions model;
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

// Makes places of sites, which fill the volume: of a mesh with values at its nodes its cells, in
// which the values are interpolated; of everything else the kernels, near which the field is the
// source's.
class PlaceMaker {
 public:
  virtual ~PlaceMaker() = default;

  // Seen are the kernels' centres, of a mesh the middles of cells, and random places in or near the
  // sites.
  FitPlaces make() const;

  // About so many random places for each of some kernels, near where it is the greatest; in random
  // order. Throws Error(kCancelled).
  Places make_evenly(const KernelColumns& kernels, double per_kernel) const;

 protected:
  // `kernels` is borrowed.
  PlaceMaker(const SourceKernels& kernels, PlaceOptions options)
      : kernels_(kernels), options_(std::move(options)) {}
  Places empty() const;

  const SourceKernels& kernels_;
  const PlaceOptions options_;

 private:
  virtual std::size_t num_sites() const = 0;
  virtual double volume(std::size_t site) const = 0;
  virtual Vec3 middle(std::size_t site) const = 0;
  virtual void append_random(std::size_t site, double share, model::Random& random,
                             Places& places) const = 0;
  // Targets, where appending left them out.
  virtual void fill(Places& /*places*/) const {}
  virtual Places seen() const = 0;
};

// Everything but the options is borrowed.
std::unique_ptr<PlaceMaker> make_place_maker(const Dataset& dataset, const KernelField& field,
                                             const SourceKernels& kernels,
                                             const PlaceOptions& options);

}  // namespace ovoid::fit
