// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/series.h"

namespace OVOID_API ovoid {

// How a Cartesian lattice is brought to another one (docs/lattices.md).
struct LatticeResampleOptions {
  std::string array;       // empty: all arrays of the lattice's points
  double spacing = 1.0;    // T of the result in spacings of the dataset's lattice, > 0
  bool band_limit = true;  // spherically, to what a body-centred lattice of that T keeps
  int threads = 0;         // 0: one per hardware thread
  std::function<void(double fraction)> progress;
  std::stop_token stop;
};

// The dataset's arrays on a lattice of the kind, of their own type (integers rounded, cut to the
// type's range) or float32 for 32-bit and 64-bit integers and doubles. The body-centred lattice is
// body_centred_like(dataset.lattice, spacing); the Cartesian one has round((n - 1) / spacing) + 1
// samples along each axis, the first on the first. Spherically band-limited (radius 1 / (2 spacing)
// cycles per spacing), then interpolated by cubic B-splines. Samples that are not finite are filled
// from their neighbours first, and results whose nearest sample is one are NaN. Throws Error:
// kInvalidArgument unless the dataset is a Cartesian lattice with such an array and at least two
// samples along each axis where a body-centred one is asked for; kCancelled, kOutOfMemory. Memory:
// four times the samples as float32. Cost: some fast Fourier transforms of lines and 12 taps per
// sample. Source: [Neophytou 2006, section 2.4], [Unser 1999].
Dataset resample_lattice(const Dataset& dataset, LatticeKind kind,
                         const LatticeResampleOptions& options = {});

// The same in space and time.
struct SeriesResampleOptions {
  LatticeResampleOptions lattice;  // `spacing` is that of time, too, in steps; `array` empty: the
                                   // dataset's default
  int component = 0;
  std::size_t memory_limit = std::size_t{12} << 30;  // bytes
};

// The lattice of the steps of a series that stands for one of `cartesian` steps: of kSteps the
// Cartesian lattice of that spacing, of kStaggered the first half of body_centred_like(). The odd
// steps of the latter are shifted by half of each axis vector.
LatticeGeometry step_lattice(const LatticeGeometry& cartesian, SeriesKind kind, double spacing);

// Steps of a Cartesian lattice in space and time, or, staggered, of a four-dimensional body-centred
// one (D4*) with half as many samples; one array of one component. Limited to a ball of frequencies
// in space and time together, interpolated by cubic B-splines; steps of the result lie within the
// times of the series, from the first on, `spacing` steps apart, or, staggered, spacing / sqrt(2).
// All steps are read now and held, twice as float32; each of the result is made when it is read.
// Throws Error: kInvalidArgument for a series of one step or of steps that are not even, with
// missing samples, or of what is no Cartesian lattice; kOutOfMemory over the limit; kCancelled;
// what reading throws. Source: [Neophytou 2006, section 2.2].
std::shared_ptr<const StepSource> resample_series(const Series& series, SeriesKind kind,
                                                  const SeriesResampleOptions& options = {});

}  // namespace ovoid
