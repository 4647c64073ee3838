// SPDX-License-Identifier: Apache-2.0
// --lattice: which lattice `convert` and `make` put samples on, and files of lattices in time.
#pragma once

#include <optional>
#include <string>

#include "ovoid/lattice_file.h"
#include "ovoid/series.h"
#include "session.h"
#include "setting.h"

namespace ovoid::cli {

enum class TargetLattice { kCartesian, kBodyCentred, kCartesianInTime, kD4Star };

Form<TargetLattice> lattice_form();  // "cc|bcc|cc4|d4star"

inline bool is_in_time(TargetLattice lattice) {
  return lattice == TargetLattice::kCartesianInTime || lattice == TargetLattice::kD4Star;
}
inline SeriesKind series_of(TargetLattice lattice) {
  return lattice == TargetLattice::kD4Star ? SeriesKind::kStaggered : SeriesKind::kSteps;
}

// Throws UsageError for a lattice in time in a file that holds none.
void require_file_in_time(TargetLattice lattice, const std::string& output);

// Writes all steps, with a line on a terminal that tells how far it is; of relevant samples with a
// note on what that saves. Nothing is left of an interrupted file.
void write_steps(const StepSource& steps, const std::string& output,
                 const std::optional<RelevantSamples>& relevant, Session& session);

// Tells how many of a file's samples are kept as runs.
void note_relevant(const std::string& output, const LatticeFileCounts& counts, Session& session);

}  // namespace ovoid::cli
