// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/field.h"

namespace OVOID_API ovoid {

// The field at one place: see KernelSample. A lattice's weight is its kernels' share of what the
// endless lattice's would sum to, and its colour value is its value.
using FieldSample = KernelSample;

// Evaluates a field of any kind at places in the world, in double precision. Immutable; any number
// of threads may ask at once. Of a lattice it keeps a copy of all samples, 9 bytes each; see
// FieldProbe for a few places. Throws
// what the field's source throws, and Error(kOutOfMemory).
class FieldSampler {
 public:
  explicit FieldSampler(const Field& field);
  ~FieldSampler();
  FieldSampler(FieldSampler&&) noexcept;
  FieldSampler& operator=(FieldSampler&&) noexcept;

  FieldSample at(const Vec3& world) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

// The same numbers for a few places, as under a pointer: of a lattice no samples are kept, those in
// reach of a place are acquired when it is asked for. Immutable; any number of threads may ask at
// once. Cost: a kernel field's tree of bricks to make; to ask, the bricks in reach, eight at most
// with usual kernels. Throws what the field's source throws, at() as well, and Error(kOutOfMemory).
class FieldProbe {
 public:
  explicit FieldProbe(const Field& field);
  ~FieldProbe();
  FieldProbe(FieldProbe&&) noexcept;
  FieldProbe& operator=(FieldProbe&&) noexcept;

  FieldSample at(const Vec3& world) const;  // FieldSampler's, to the last digit

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

// Lattices whose cells fill `bounds`: of `dims` samples; or of cubes, so many that `longest` of
// them reach along the longest side and the others' cells stand out by less than one, equally at
// both ends. Throw Error(kInvalidArgument): bounds that are empty or not finite, sides that are not
// 1 to kMaxLatticeSide.
LatticeGeometry lattice_over(const Bounds3& bounds, const Index3& dims);
LatticeGeometry lattice_of_cubes(const Bounds3& bounds, std::int64_t longest);
inline constexpr std::int64_t kMaxLatticeSide = 8192;

struct ResampleOptions {
  std::string name = "value";  // of the array
  std::string color_name{};    // of one with the colour's values, where an attribute of its own
                               // gives colour; empty: none
  int threads = 0;             // 0: one per hardware thread
  std::function<void(double fraction)> progress{};  // in [0, 1], not decreasing
  std::stop_token stop{};
};

// The field at the samples of a lattice, as a dataset of float32: NaN where it is not defined.
// Nothing is averaged: kernels narrower than the lattice's spacing may be missed. Throws what
// FieldSampler throws, Error(kInvalidArgument) for a degenerate lattice, kOutOfMemory, kCancelled.
// Cost: a sample each.
Dataset resample(const Field& field, const LatticeGeometry& lattice,
                 const ResampleOptions& options = {});

}  // namespace ovoid
