// SPDX-License-Identifier: Apache-2.0
#include "make_simplified.h"

#include <fmt/format.h>

#include "make_field.h"
#include "ovoid/io.h"
#include "ovoid/lattice_file.h"
#include "ovoid/output_files.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {

using Json = nlohmann::ordered_json;

namespace {

const Table<SimplifyFlags>& simplify_settings() {
  using F = SimplifyFlags;
  static const Names<Primitives> primitives = {{"constant", Primitives::kConstants},
                                               {"ramp", Primitives::kRamps},
                                               {"box", Primitives::kBoxes}};
  static const Names<RunSearch> searches = {{"greedy", RunSearch::kGreedy},
                                            {"fewest", RunSearch::kFewest}};
  static const Table<F> all = {
      {"-o,--output", word("OUT"), &F::output, "the file, .h5"},
      {"--tolerance", Form<Tolerance>{"VALUE[%]", parse_tolerance_or_zero}, &F::tolerance,
       "what no sample errs by more than; with %, of the values' range (default 1%); 0 keeps "
       "integers of 1 or 2 bytes as they are; all else is taken as float32, and kept to 3e-8 of "
       "the range"},
      {"--rms", number("SHARE", {.lo = 0, .hi = 1, .lo_open = true}), &F::rms,
       "what the samples of a primitive err by at most in the root mean square, as a share of "
       "--tolerance (default {})"},
      {"--primitive", choice(primitives), &F::primitives,
       "runs along x of one value, runs along x that rise evenly, or boxes that rise evenly along "
       "each axis (default {})"},
      {"--search", choice(searches), &F::search,
       "of runs: each as long as it can be, from left to right, or the fewest that least squares "
       "accept (slower) (default {})"},
      {"--relevant-above", number("V"), &F::relevant_above,
       "samples up to this value need not be kept, and become the least value; no error that is "
       "told is theirs"},
      {"--report", word("FILE"), &F::report, "what is printed, as JSON"},
      {"--threads", integer("N", 0, 1024), &F::threads, "(default {}: one per hardware thread)"},
  };
  return all;
}

SimplifyOptions options_of(const SimplifyFlags& simplify, const Dataset& dataset,
                           Session& session) {
  SimplifyOptions options;
  options.array = simplify.model.array;
  options.component = component_of(dataset.array(simplify.model.array), simplify.model.component);
  (simplify.tolerance.is_share ? options.relative_tolerance : options.tolerance) =
      simplify.tolerance.number;
  options.rms_share = simplify.rms;
  options.primitives = simplify.primitives;
  options.search = simplify.search;
  options.relevant_above = simplify.relevant_above;
  options.threads = simplify.threads;
  options.stop = session.stop();
  return options;
}

}  // namespace

Flags make_simplify_flags(SimplifyFlags* into) {
  Flags flags("simplify", "INPUT... -o OUT [FLAG...]",
              "Runs and boxes for a scan's samples whose values are constant or rise evenly, each "
              "of which one primitive stands for, with a bound on the error of every sample. "
              "Every command takes the result as it takes the scan.");
  flags.section("");
  flags.add(simplify_settings(), into);
  add_input_flags(flags, &into->data);
  add_array_flags(flags, &into->model);
  return flags;
}

void check_simplify_flags(const SimplifyFlags& simplify) {
  if (simplify.output.empty()) throw UsageError("--output: none given, expected -o OUT.h5");
  if (!has_ending(simplify.output, ".h5"))
    throw UsageError(
        fmt::format("--output '{}': expected a name that ends in .h5", simplify.output));
  if (simplify.search == RunSearch::kFewest && simplify.primitives == Primitives::kBoxes)
    throw UsageError("--search fewest: is for --primitive constant or ramp");
}

Simplified make_simplified(const Dataset& dataset, const Flags& flags,
                           const SimplifyFlags& simplify, Session& session,
                           const std::function<void(double)>& progress) {
  check_kind_flags(flags, dataset);
  if (dataset.kind != DatasetKind::kLattice)
    refuse_kind("simplify", "lattices (ovoid fit takes everything else)", dataset);
  const Stopwatch watch;
  Simplified done;
  SimplifyOptions options = options_of(simplify, dataset, session);
  options.progress = progress;
  const LatticeBoxes boxes = simplify_lattice(dataset, options, &done.report);
  LatticeFileWriter writer(
      simplify.output,
      lattice_file_header(dataset, done.report.array, LatticeContent::kBoxes, boxes.whole),
      {session.stop()});
  writer.write_boxes({&boxes, 1});
  writer.finish();
  done.bytes = size_of_written(simplify.output);
  done.seconds = watch.ms() / 1000;
  return done;
}

ReportRows rows_of(const Simplified& done) {
  const SimplifyReport& report = done.report;
  return {{"primitives",
           fmt::format("{}, for {} relevant samples of {}{}", report.primitives, report.relevant,
                       report.samples, one_for_text(report.relevant, report.primitives))},
          {"bytes", bytes_text(done.bytes)},
          {"PSNR", fmt::format("{:.2f} dB", report.psnr)},
          {"greatest error", error_text(report.greatest_error, report.range)},
          {"time", seconds_text(done.seconds)}};
}

Json json_of(const Simplified& done) {
  const SimplifyReport& report = done.report;
  Json json;
  json["array"] = report.array;
  json["samples"] = report.samples;
  json["relevant"] = report.relevant;
  json["primitives"] = report.primitives;
  json["bytes"] = done.bytes;
  json["range"] = report.range;
  json["tolerance"] = report.tolerance;
  json["greatest_error"] = report.greatest_error;
  json["psnr_db"] = decibels_json(report.psnr);
  json["seconds"] = done.seconds;
  return json;
}

}  // namespace ovoid::cli
