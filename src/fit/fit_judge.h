// SPDX-License-Identifier: Apache-2.0
// What fitted kernels err by, at places of the domain. A place where the source's field has a value
// and the fitted one has none is a hole. In a mean a hole errs by the values' deviation, as if the
// values' mean stood there; under a bound on the error there must be no hole.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <stop_token>
#include <vector>

#include "fit/clusters.h"
#include "fit/fit_places.h"
#include "ovoid/fit.h"

namespace ovoid::fit {

// The first attribute of fitted kernels.
struct JudgedKernels {
  const MergedKernels& kernels;
  std::span<const double> values;  // [n]
};

class FitJudge {
 public:
  // All but the range is borrowed.
  FitJudge(const KernelField& field, const SourceKernels& source, double range, int threads,
           const std::stop_token& stop);

  // Of the source's values; what a hole errs by.
  double deviation() const noexcept { return deviation_; }

  // Numbers of the places that are holes, where `rows` are the fitted kernels at the places. A
  // sum has none. With a margin above 1, places count, too, whose sum of weights is less than so
  // many times what a value needs.
  std::vector<std::uint32_t> holes(const Places& places, const KernelOperator& rows,
                                   float margin = 1) const;

  // The kernel that each hole is nearest to, in units of the kernel's size; as many as holes.
  // kNoSite where no kernel is near.
  std::vector<std::uint32_t> owners_of_holes(const Places& places,
                                             std::span<const std::uint32_t> holes,
                                             const MergedKernels& kernels) const;

  // Widens the kernels that are nearest to holes, little by little, until there are none or next to
  // none. Returns whether there were any. The margin is that of holes().
  bool close_holes(const Places& places, MergedKernels& kernels, float margin = 1) const;

  // [places] not negative; infinite in holes, NaN where the source's field has no value either.
  std::vector<double> errors(const Places& places, const JudgedKernels& fitted) const;

  struct Errors {
    double mean_square = 0;
    double greatest = 0;  // but for holes
  };
  // Over the domain.
  Errors sum_up(const Places& places, const JudgedKernels& fitted) const;

  // The places with the greatest errors that a search finds: it starts from the worst of `places`
  // and looks beside the worst so far, ever nearer. The worst comes first.
  struct Worst {
    Places places;
    std::vector<double> errors;
    double greatest_but_for_holes = 0;  // of all that were looked at
    // Infinite if there is a hole; also if there is nothing to judge by, which is no success.
    double greatest() const {
      return errors.empty() ? std::numeric_limits<double>::infinity() : errors[0];
    }
  };
  Worst look_for_worst(const PlaceMaker& maker, std::span<const Places* const> places,
                       const JudgedKernels& fitted, std::uint64_t seed) const;

  // Fills the report's errors from the field as it is stored; the greatest error so far stays where
  // it is greater.
  void report(const KernelField& fitted, const Places& places, FitReport& report) const;

 private:
  void report_full(const KernelField& fitted, FitReport& report) const;
  std::vector<KernelSample> sampled(const KernelField& field, std::span<const double> at) const {
    return sample_field(field, at, threads_, stop_);
  }
  bool is_sum() const { return source_.reconstruction == Reconstruction::kSum; }
  Worst worst_of(const Places& places, const std::vector<double>& errors) const;

  const KernelField& field_;
  const SourceKernels& source_;
  double range_;
  double deviation_ = 0;
  int threads_;
  const std::stop_token& stop_;
};

}  // namespace ovoid::fit
