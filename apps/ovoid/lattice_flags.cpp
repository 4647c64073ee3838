// SPDX-License-Identifier: Apache-2.0
#include "lattice_flags.h"

#include <fmt/format.h>

#include "check_files.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

const Names<TargetLattice> kLattices = {{"cc", TargetLattice::kCartesian},
                                        {"bcc", TargetLattice::kBodyCentred},
                                        {"cc4", TargetLattice::kCartesianInTime},
                                        {"d4star", TargetLattice::kD4Star}};

}  // namespace

Form<TargetLattice> lattice_form() { return choice(kLattices); }

void require_file_in_time(TargetLattice lattice, const std::string& output) {
  if (is_in_time(lattice) && !has_ending(output, ".h5")) {
    throw UsageError(
        fmt::format("--lattice: '{}' holds one step, only .h5 holds lattices in time", output));
  }
}

void write_steps(const StepSource& steps, const std::string& output,
                 const std::optional<RelevantSamples>& relevant, Session& session) {
  Progress progress("writing");
  std::optional<LatticeFileWriter> writer;
  for (std::int64_t step = 0; step < steps.num_steps(); ++step) {
    const Dataset dataset = steps.read(step, session.stop());
    if (!writer) {
      LatticeFileHeader header = lattice_file_header(dataset);
      header.series = steps.kind();
      header.times = steps.times();
      header.time_unit = dataset.time_unit;
      header.relevant = relevant;
      writer.emplace(output, header, WriteOptions{session.stop()});
    }
    writer->write_step(dataset);
    session.check_stop();
    progress.show(static_cast<double>(step + 1) / static_cast<double>(steps.num_steps()));
  }
  writer->finish();
  if (relevant) note_relevant(output, writer->counts(), session);
}

void note_relevant(const std::string& output, const LatticeFileCounts& counts, Session& session) {
  session.note(fmt::format(
      "{}: {} of {} samples are relevant ({:.1f} %), in {} runs: {} bytes, {} dense", output,
      counts.num_relevant, counts.num_samples,
      100.0 * static_cast<double>(counts.num_relevant) / static_cast<double>(counts.num_samples),
      counts.num_runs, counts.run_bytes, counts.dense_bytes));
}

}  // namespace ovoid::cli
