// SPDX-License-Identifier: Apache-2.0
// ovoid fit: fewer kernels for a field, with a stated error.
#include <nlohmann/json.hpp>

#include "check_files.h"
#include "command.h"
#include "load.h"
#include "make_fit.h"
#include "ovoid/io.h"
#include "report_rows.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string json_of(const FitReport& report, double seconds) {
  Json json;
  json["array"] = report.array;
  json["kernels"] = report.kernels;
  json["source_kernels"] = report.source_kernels;
  json["bytes"] = report.bytes;
  json["range"] = report.range;
  json["psnr_db"] = decibels_json(report.psnr);
  json["psnr_of_nonempty_db"] = decibels_json(report.psnr_of_nonempty);
  json["source_psnr_db"] = decibels_json(report.source_psnr);
  if (report.noise > 0) json["noise"] = report.noise;
  json["greatest_error"] = report.greatest_error;
  json["wrongly_empty"] = report.wrongly_empty;
  json["wrongly_full"] = report.wrongly_full;
  json["places"] = report.places;
  json["test_places"] = report.test_places;
  json["steps"] = Json::array();
  for (const FitStep& step : report.steps)
    json["steps"].push_back({{"kernels", step.kernels},
                             {"psnr_db", decibels_json(step.psnr)},
                             {"greatest_error", step.greatest_error}});
  json["seconds"] = seconds;
  return json.dump(2) + "\n";
}

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
  check_fit_flags(flags, fit);
  check_fit_files(fit);
  take_from_model(&fit.data, &fit.model);

  const Dataset dataset = load(fit.data, session);
  const Stopwatch watch;
  const FitReport report = [&] {
    Progress progress("fitting");
    return make_fit(dataset, flags, fit, session, progress.callback());
  }();
  const double seconds = watch.ms() / 1000;
  if (!fit.report.empty()) write_file(fit.report, json_of(report, seconds));
  print_rows(rows_of(report, dataset.kind, seconds));
}

}  // namespace ovoid::cli
