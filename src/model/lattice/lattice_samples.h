// SPDX-License-Identifier: Apache-2.0
// From the samples of one lattice to those of another, and from stored numbers to floats and back.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "model/lattice/convert.h"
#include "ovoid/dataset.h"

namespace ovoid::model {

// Throws Error(kInvalidArgument) unless the dataset is a Cartesian lattice and the array of its
// points.
void require_point_lattice(const Dataset& dataset, const DataArray& array);

// The stored numbers of samples of one component.
std::vector<float> as_floats(const ScalarSamples& samples, std::int64_t count);

// Values as numbers of a type that a BrickView can show: whole ones rounded and cut to its range.
Bytes stored_as(ScalarType type, std::span<const float> values);

struct PlaceOptions {
  int threads = 0;  // 0: one per hardware thread
  std::stop_token stop{};
};

// Samples (finite, x fastest) of the Cartesian lattice `from` at the places of `to`, whose axes are
// parallel to its: layers as LatticeGeometry says. Cubic B-splines, the volume mirrored at its
// faces.
std::vector<float> at_lattice(std::span<const float> samples, const LatticeGeometry& from,
                              const LatticeGeometry& to, const PlaceOptions& options);

}  // namespace ovoid::model
