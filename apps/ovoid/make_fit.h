// SPDX-License-Identifier: Apache-2.0
// What `ovoid fit` and the window share: the goal, the fit into a file, what is told of it.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "ovoid/fit.h"
#include "report_rows.h"
#include "session.h"
#include "setting_forms.h"
#include "settings.h"

namespace ovoid::cli {

struct FitFlags {
  DataFlags data;
  ModelFlags model;
  std::string output, report;
  std::optional<double> psnr;
  std::optional<Tolerance> tolerance;
  std::optional<std::int64_t> kernels, bytes;
  bool smooth = false;
  KernelShape shape = KernelShape::kEllipsoids;
  int refinements = FitOptions{}.refinements;
  std::uint64_t seed = 1;
  int threads = 0;
};

// The flags of `ovoid fit`, which set `into`.
Flags make_fit_flags(FitFlags* into);

// Throws UsageError without output or goal, and for an output of another ending than fits have.
void check_fit_flags(const FitFlags& fit);

// Throws UsageError if the ending of the output is not that of what such data become.
void check_fit_ending(const std::string& output, const Dataset& dataset);

// Fits, and writes the output. The report's notes are told to the session. Throws Error, and
// UsageError for what does not go with the kind of the data.
FitReport make_fit(const Dataset& dataset, const Flags& flags, const FitFlags& fit,
                   Session& session, const std::function<void(double)>& progress);

// What is told of it.
ReportRows rows_of(const FitReport& report, DatasetKind kind, double seconds);

// The members of --report.
nlohmann::ordered_json json_of(const FitReport& report, double seconds);

}  // namespace ovoid::cli
