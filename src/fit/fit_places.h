// SPDX-License-Identifier: Apache-2.0
// Where a fit looks, and what the field should be there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "fit/source_kernels.h"
#include "model/lattice/noise.h"
#include "ovoid/dataset.h"
#include "ovoid/model.h"

namespace ovoid::fit {

// Of a place that lies in no site in particular.
inline constexpr std::uint32_t kNoSite = std::numeric_limits<std::uint32_t>::max();

struct Places {
  std::vector<double> at;                    // [n, 3]
  std::vector<double> shares;                // [n] of the volume; their sum is about the whole's
  std::vector<std::uint32_t> sites;          // [n] that the place lies in or near, or kNoSite
  std::vector<std::vector<double>> targets;  // of each attribute [n]

  std::size_t count() const noexcept { return shares.size(); }
  // The place's share is not that of `from`.
  void append(const Places& from, std::size_t index, double share);
};

// The field at places [n, 3].
std::vector<KernelSample> sample_field(const KernelField& field, std::span<const double> at,
                                       int threads, const std::stop_token& stop);

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
  Places unseen;  // at random; with their shares, evenly over the domain
};

// Makes places of sites. A mesh with values at its nodes has its cells as sites: the values are
// interpolated in them, and together they are the domain. Everything else has its kernels as sites:
// the values are those of the source's field, and the domain is where any of its kernels reaches,
// of means within the box of their centres.
class PlaceMaker {
 public:
  virtual ~PlaceMaker() = default;

  // Seen are the kernels' centres, of a mesh the middles of cells, and random places in or near the
  // sites.
  FitPlaces make() const;

  // About so many random places for each of some kernels, near where it is the greatest; in random
  // order. Throws Error(kCancelled).
  Places make_evenly(const KernelColumns& kernels, double per_kernel) const;

  // A random place beside each of those of `places` that have a site: in the same cell, or within
  // so many sigmas of the site's kernel.
  Places make_beside(const Places& places, double sigmas, std::uint64_t seed) const;

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
  virtual void append_beside(std::size_t site, const Vec3& at, double sigmas, model::Random& random,
                             Places& places) const = 0;
  // `options_.test` places over the domain, without targets where fill() makes them.
  virtual Places unseen() const = 0;
  // Targets, where appending left them out.
  virtual void fill(Places& /*places*/) const {}
  virtual Places seen() const = 0;
};

// Everything but the options is borrowed.
std::unique_ptr<PlaceMaker> make_place_maker(const Dataset& dataset, const KernelField& field,
                                             const SourceKernels& kernels,
                                             const PlaceOptions& options);

}  // namespace ovoid::fit
