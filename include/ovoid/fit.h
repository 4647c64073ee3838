// SPDX-License-Identifier: Apache-2.0
// Fewer kernels for the same field, with a stated error, and the linear algebra below: what kernels
// make of values at places, the transpose of that, and least squares by conjugate gradients.
// docs/numerics.md, "Fitted kernels", is the definition.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/kernel_field.h"
#include "ovoid/lattice_levels.h"
#include "ovoid/model.h"

namespace OVOID_API ovoid {

// The field of given kernels at given places, as a linear map of the kernels' values: row k holds
// h_i = w_i phi_i(x_k), of a normalized field divided by their sum. Ellipsoids of Gaussian profile.
// A normalized field that is not defined at a place (a sum of weights under
// KernelField::kLeastWeight) has an empty row there. The rows are kept, 8 bytes for each kernel
// that reaches a place, since every product needs them again. Immutable; any number of threads may
// ask at once. The results are the same bytes for any number of threads.
class KernelOperator {
 public:
  // `kernels`: values and attributes do not count. `places` [num_places, 3], world units, finite.
  // Throws Error: kInvalidArgument that names column and index; kCancelled; kOutOfMemory. Cost:
  // some microseconds per place.
  KernelOperator(const KernelColumns& kernels, Reconstruction reconstruction,
                 BorrowedValues<double> places, int threads = 0, std::stop_token stop = {});
  ~KernelOperator();
  KernelOperator(KernelOperator&&) noexcept;
  KernelOperator& operator=(KernelOperator&&) noexcept;

  std::size_t num_kernels() const noexcept;
  std::size_t num_places() const noexcept;
  std::size_t resident_bytes() const noexcept;
  // [num_places] sums of w phi.
  std::span<const float> weights() const noexcept;
  bool is_defined(std::size_t place) const noexcept;  // whether its row has entries

  // A place's row: the kernels that reach it, and its entries.
  struct Row {
    std::size_t place = 0;
    std::span<const std::uint32_t> kernels;
    std::span<const float> entries;
  };
  // By number in [0, num_places()), in the order of memory: neighbours in space follow each other.
  // Spans live as long as the operator.
  Row row(std::size_t number) const noexcept;

  // Gather: the field at the places, [num_places], of values [num_kernels]; 0 where it is not
  // defined. Throws Error(kInvalidArgument) for wrong lengths.
  std::vector<double> gather(std::span<const double> values) const;
  // Splat, the transpose: for each kernel the sum over places of its entry times `numbers`
  // [num_places].
  std::vector<double> splat(std::span<const double> numbers) const;
  // The same of the entries' squares: with the places' shares, the diagonal of the normal
  // equations.
  std::vector<double> splat_squares(std::span<const double> numbers) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Values of kernels such that their field comes near targets.
struct ValueProblem {
  std::span<const double> targets;  // [num_places]
  std::span<const double> shares;   // [num_places] >= 0: how much each place counts
  // How much a value counts that leaves its start, as a share of what its own places count. > 0:
  // without it, kernels that no place holds fast would swing.
  double ridge = 1e-3;
  // [num_kernels], or empty: sum_i keeps_i v_i stays what it is at the start; of a density, with
  // w_i det L_i, its integral.
  std::span<const double> keeps{};
  int iterations = 25;      // at most
  double tolerance = 1e-4;  // of the residual's norm, over what it was at the start
};

struct ValueSolution {
  int iterations = 0;
  std::vector<double> residual_norms;  // relative; [0] is 1, one more after each iteration
};

// Minimises sum_k share_k (sum_i h_ki v_i - target_k)^2 + ridge sum_i g_i (v_i - start_i)^2 with
// g_i = sum_k share_k h_ki^2, from `values` = start on, by conjugate gradients on the normal
// equations, preconditioned by their diagonal: a gather and a splat each. Throws
// Error(kInvalidArgument) for wrong lengths, kCancelled.
ValueSolution fit_values(const KernelOperator& kernels, const ValueProblem& problem,
                         std::vector<double>& values, const std::stop_token& stop = {});

// Exactly one of the first six is the goal.
struct FitOptions {
  std::optional<double> psnr;                // dB, of FitStep::psnr
  std::optional<double> tolerance;           // values: FitReport::greatest_error is at most this
  std::optional<double> relative_tolerance;  // the same as a share of FitReport::range
  std::optional<std::int64_t> kernels;       // as many, or all there are
  std::optional<std::int64_t> bytes;         // of the file (.ply, .h5), at most
  // Of lattices alone: the PSNR at which the rms error is FitReport::noise, so that what is taken
  // away is as much as the noise that is there.
  bool smooth = false;

  // Of kernel sets alone:
  KernelShape shape = KernelShape::kEllipsoids;
  // Steps by which centres, shapes and weights are refined at the end, at most. 0: kernels stay the
  // moments of those they stand for.
  int refinements = 4;
  std::uint64_t seed = 1;  // of the places between nodes or particles
  // How the data become the kernels that are merged; of a lattice `array` and `component` alone.
  KernelModelOptions model{};
  // Bytes that may be used beside the dataset: fewer places are looked at where it takes more. 0:
  // no limit.
  std::size_t memory_limit = 0;
  int threads = 0;
  std::function<void(double fraction)> progress{};  // in [0, 1], not decreasing; one at a time
  std::stop_token stop{};
};

// One step on the way: what so many kernels came to.
struct FitStep {
  std::int64_t kernels = 0;
  double psnr = 0, greatest_error = 0;
};

// What came of it. Errors are those of the field as it is stored, against what it stands for: of a
// mesh with values at its nodes, interpolation in its cells; of everything else, the field that
// make_kernel_field() makes of it. They are taken at places that the fit did not see, evenly over
// the domain, and the greatest also at all it saw and beside the worst of them; of a lattice at
// every sample. A place where what it stands for has a value and the fit has none errs by the
// values' standard deviation in PSNR, and not in `greatest_error`.
struct FitReport {
  std::string array;
  std::int64_t source_kernels = 0;  // of a lattice: samples
  std::int64_t kernels = 0;
  std::int64_t bytes = 0;        // of the file (.ply, .h5)
  std::int64_t places = 0;       // that the fit saw
  std::int64_t test_places = 0;  // that it did not
  double range = 0;              // greatest less least of the values
  double noise = 0;              // of FitOptions::smooth: rms of the data's noise; values
  double psnr = 0;               // 20 log10(range / rms error), dB
  double psnr_of_nonempty = 0;   // the same of places whose value is not the data's least
  double greatest_error = 0;     // values
  double wrongly_empty = 0;      // share of the domain where the field is defined and ours is not
  double wrongly_full = 0;       // of its bounding box, the other way round
  double source_psnr = 0;  // of all the kernels that were merged, as they were; a lattice: inf
  // The errors of the places that the fit saw; of the last ones, those of places that it did not.
  std::vector<FitStep> steps;
  std::vector<std::string> notes;
};

// Kernels for the field of a mesh, boxes, particles or stored kernels. The result keeps
// reconstruction, cut-off and attributes of make_kernel_field(), and does not depend on the number
// of threads. Throws Error: what make_kernel_field() throws; kInvalidArgument for no goal or
// several, a goal that cannot be reached (with what can), `smooth`, bytes for less than a kernel, a
// lattice; kCancelled; kOutOfMemory. Cost: about seventy microseconds of one thread per node or
// particle, and for each of `refinements` a millisecond per kernel.
KernelField fit_kernels(const Dataset& dataset, const FitOptions& options,
                        FitReport* report = nullptr);

// Kernels on levels for the samples of a Cartesian lattice: LatticeFileWriter::write_levels() keeps
// them, and what it writes is read as a lattice. Integers of 1 or 2 bytes are fitted as they are
// stored, and stay whole; everything else as values (a header's array is then float32). PSNR and a
// bound on the greatest error hold sample by sample of what will be read. Of kernels and bytes at
// most as many as half the samples' number are used. A lattice of one value has none. Throws Error:
// what make_lattice_field() throws; kInvalidArgument for no goal or several, one that cannot be
// reached, `smooth` without noise that can be told, missing samples, a body-centred lattice;
// kCancelled; kOutOfMemory. Cost: about a microsecond of one thread per sample, and 48 bytes.
LatticeLevels fit_lattice(const Dataset& dataset, const FitOptions& options,
                          FitReport* report = nullptr);

}  // namespace ovoid
