// SPDX-License-Identifier: Apache-2.0
// What `ovoid simplify` and the Python module share: the bound, the boxes into a file, what is told
// of them.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "ovoid/simplify.h"
#include "report_rows.h"
#include "setting_forms.h"
#include "settings.h"

namespace ovoid::cli {

struct SimplifyFlags {
  DataFlags data;
  ModelFlags model;
  std::string output, report;
  Tolerance tolerance{0.01, true};
  double rms = 1;
  Primitives primitives = Primitives::kBoxes;
  RunSearch search = RunSearch::kGreedy;
  std::optional<double> relevant_above;
  int threads = 0;
};

// What was simplified, and at what cost.
struct Simplified {
  SimplifyReport report;
  std::int64_t bytes = 0;  // of the file
  double seconds = 0;
};

// The flags of `ovoid simplify`, which set `into`.
Flags make_simplify_flags(SimplifyFlags* into);

// Throws UsageError for an output of another ending, and for flags that contradict each other.
void check_simplify_flags(const SimplifyFlags& simplify);

// Simplifies, and writes the output. Throws Error, and UsageError for what is no lattice.
Simplified make_simplified(const Dataset& dataset, const Flags& flags,
                           const SimplifyFlags& simplify, Session& session,
                           const std::function<void(double)>& progress);

// What is told of it, and the members of --report.
ReportRows rows_of(const Simplified& done);
nlohmann::ordered_json json_of(const Simplified& done);

}  // namespace ovoid::cli
