// SPDX-License-Identifier: Apache-2.0
// ovoid fit: fewer kernels for a field, with a stated error.
#include "check_files.h"
#include "command.h"
#include "console.h"
#include "load.h"
#include "make_fit.h"
#include "ovoid/io.h"
#include "ovoid/output_files.h"
#include "report_rows.h"

namespace ovoid::cli {
namespace {

void check_fit_files(const FitFlags& fit) {
  std::vector<OutputFile> outputs = volume_outputs("--output", fit.output);
  if (!fit.report.empty()) outputs.push_back({"--report", fit.report, fit.report});
  check_files(volume_inputs(fit.data.inputs), outputs);
  check_volume_output("--output", fit.output);
}

}  // namespace

void run_fit(const Words& words, Session& session) {
  FitFlags fit;
  Flags flags = make_fit_flags(&fit);
  if (!flags.parse(words)) return;
  require_inputs(flags, fit.data);
  check_fit_flags(fit);
  check_fit_files(fit);
  take_from_model(&fit.data, &fit.model);

  const Dataset dataset = load(fit.data, session);
  require_values(dataset, "fit");
  const Stopwatch watch;
  FilesTogether files;
  const FitReport report = [&] {
    Progress progress("fitting");
    return make_fit(dataset, flags, fit, session, progress.callback());
  }();
  const double seconds = watch.ms() / 1000;
  if (!fit.report.empty()) write_file(fit.report, json_of(report, seconds).dump(2) + "\n");
  print_rows(rows_of(report, dataset.kind, seconds));
  flush_out();
  session.check_stop();
  files.commit();
}

}  // namespace ovoid::cli
