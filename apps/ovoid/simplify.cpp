// SPDX-License-Identifier: Apache-2.0
// ovoid simplify: runs and boxes of samples that one primitive stands for.
#include "check_files.h"
#include "command.h"
#include "console.h"
#include "load.h"
#include "make_simplified.h"
#include "ovoid/io.h"
#include "ovoid/output_files.h"
#include "report_rows.h"

namespace ovoid::cli {

void run_simplify(const Words& words, Session& session) {
  SimplifyFlags simplify;
  Flags flags = make_simplify_flags(&simplify);
  if (!flags.parse(words)) return;
  require_inputs(flags, simplify.data);
  check_simplify_flags(simplify);
  std::vector<OutputFile> outputs = volume_outputs("--output", simplify.output);
  if (!simplify.report.empty()) outputs.push_back({"--report", simplify.report, simplify.report});
  check_files(volume_inputs(simplify.data.inputs), outputs);
  check_volume_output("--output", simplify.output);
  take_from_model(&simplify.data, &simplify.model);

  const Dataset dataset = load(simplify.data, session);
  FilesTogether files;
  const Simplified done = [&] {
    Progress progress("simplifying");
    return make_simplified(dataset, flags, simplify, session, progress.callback());
  }();
  if (!simplify.report.empty()) write_file(simplify.report, json_of(done).dump(2) + "\n");
  print_rows(rows_of(done));
  flush_out();
  session.check_stop();
  files.commit();
}

}  // namespace ovoid::cli
