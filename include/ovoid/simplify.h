// SPDX-License-Identifier: Apache-2.0
// Agglutination: runs and boxes of a lattice's samples whose values are constant or rise evenly,
// each of which one primitive stands for, with a bound on the error of every sample.
// docs/numerics.md, "Boxes of a scan", is the definition.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/lattice_boxes.h"

namespace OVOID_API ovoid {

// What stands for samples: runs along x of one value, runs along x that rise evenly, or boxes that
// rise evenly along each axis.
enum class Primitives { kConstants, kRamps, kBoxes };

// How runs along x are found: from left to right, each as long as it can be, or so that there are
// the fewest of those that least squares accept (dynamic programming; of kConstants and kRamps).
enum class RunSearch { kGreedy, kFewest };

// At most one of the tolerances.
struct SimplifyOptions {
  std::string array;  // empty: the dataset's only or first one that varies
  int component = 0;
  // >= 0, of every sample. Of integers of 1 or 2 bytes 0 is lossless; of all others, which are
  // taken as floats, it is at least kLeastTolerance of the range.
  std::optional<double> tolerance;           // values
  std::optional<double> relative_tolerance;  // a share of the range; neither: 1 %
  // Of each primitive by itself: the most that the root of the mean of its samples' squared errors
  // may be, as a share of the tolerance, in (0, 1].
  double rms_share = 1;
  Primitives primitives = Primitives::kBoxes;
  RunSearch search = RunSearch::kGreedy;
  // Samples up to this value need not be kept: they become the least value there is.
  std::optional<double> relevant_above;
  int threads = 0;
  std::function<void(double fraction)> progress{};  // in [0, 1], not decreasing; one at a time
  std::stop_token stop{};

  static constexpr double kLeastTolerance = 1.0 / (1 << 25);
};

// What came of it, from the samples that will be read.
struct SimplifyReport {
  std::string array;
  std::int64_t samples = 0;
  // Samples that the background does not stand for. Boxes may hold others, too.
  std::int64_t relevant = 0;
  std::int64_t primitives = 0;  // boxes or runs
  double range = 0;             // greatest less least of the values
  double tolerance = 0;         // that was held, values
  // Of all samples but those that need not be kept:
  double greatest_error = 0;  // values
  double psnr = 0;            // 20 log10(range / rms error), dB
};

// Boxes for the samples of a Cartesian lattice: LatticeFileWriter::write_boxes() keeps them, and
// what it writes is read as a lattice. The result does not depend on the number of threads.
// Integers of 1 or 2 bytes are taken as they are stored, and stay whole; everything else as values
// (a header's array is then float32). Missing samples stay missing. Throws Error: what
// make_lattice_field() throws; kInvalidArgument for options out of range, a body-centred lattice,
// 2^32 samples and more; kCancelled; kOutOfMemory. Cost: some 100 ns of one thread per sample,
// or, where runs are long, a nanosecond for each sample of its run (kFewest: for the square of
// them); and 10 bytes per sample, 40 per box.
LatticeBoxes simplify_lattice(const Dataset& dataset, const SimplifyOptions& options,
                              SimplifyReport* report = nullptr);

}  // namespace ovoid
