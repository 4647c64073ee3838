// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "ovoid/math.h"

namespace ovoid::model {

// The sites [n, 3] nearest to a place, by a k-d tree. Borrows the sites; immutable, any number of
// threads may ask at once. Memory: some 16 bytes per site.
class NearestSites {
 public:
  explicit NearestSites(std::span<const double> sites);
  ~NearestSites();
  NearestSites(const NearestSites&) = delete;
  NearestSites& operator=(const NearestSites&) = delete;

  // Fills the indices and squared distances of the spans' length sites nearest to `place`, or of
  // all if there are fewer, nearest first. Returns how many.
  std::size_t find(const Vec3& place, std::span<std::uint32_t> indices,
                   std::span<double> squares) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace ovoid::model
