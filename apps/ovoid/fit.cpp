// SPDX-License-Identifier: Apache-2.0
// ovoid fit: fewer kernels for a field, with a stated error.
#include "ovoid/fit.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "check_files.h"
#include "command.h"
#include "load.h"
#include "make_field.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "profile.h"
#include "setting_forms.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

// --tolerance: a number of the values' unit, or a share of their range.
struct Tolerance {
  double number = 0;
  bool is_share = false;
};

struct FitFlags {
  DataFlags data;
  ModelFlags model;
  std::string output, report;
  std::optional<double> psnr;
  std::optional<Tolerance> tolerance;
  std::optional<std::int64_t> kernels, bytes;
  KernelShape shape = KernelShape::kEllipsoids;
  std::uint64_t seed = 1;
  int threads = 0;
};

Tolerance parse_tolerance(const std::string& text) {
  if (!text.ends_with('%')) return {parse_number(text, kPositive), false};
  const Interval percent = {.lo = 0, .hi = 100, .lo_open = true};
  return {parse_number(text.substr(0, text.size() - 1), percent) / 100, true};
}

const Table<FitFlags>& fit_settings() {
  using F = FitFlags;
  static const Names<KernelShape> shapes = {{"ellipsoid", KernelShape::kEllipsoids},
                                            {"ball", KernelShape::kBalls}};
  static const Table<F> all = {
      {"-o,--output", word("OUT"), &F::output, "the kernels: .ply"},
      {"--psnr", number("DB"), &F::psnr, "as few kernels as reach it: 20 log10(range / rms error)"},
      {"--tolerance", Form<Tolerance>{"VALUE[%]", parse_tolerance}, &F::tolerance,
       "as few as leave no greater error; with %, of the values' range",
       not_with("psnr", kGiveOne)},
      {"--kernels", integer<std::int64_t>("N", 1, std::int64_t{1} << 40), &F::kernels,
       "so many, as good as they get", not_with("psnr tolerance", kGiveOne)},
      {"--bytes", bytes<std::int64_t>("BYTES"), &F::bytes,
       "as many as fit in a file of that size, such as 500K",
       not_with("psnr tolerance kernels", kGiveOne)},
      {"--shape", choice(shapes), &F::shape, "(default {})"},
      {"--seed", integer<std::uint64_t>("N", 0, std::int64_t{1} << 40), &F::seed,
       "of the places where the error is looked at (default {})"},
      {"--report", word("FILE"), &F::report, "what is printed, and the way there, as JSON"},
      {"--threads", integer("N", 0, 1024), &F::threads, "(default {}: one per hardware thread)"},
  };
  return all;
}

FitOptions options_of(const FitFlags& fit, const Dataset& dataset, Session& session) {
  FitOptions options;
  options.psnr = fit.psnr;
  if (fit.tolerance)
    (fit.tolerance->is_share ? options.relative_tolerance : options.tolerance) =
        fit.tolerance->number;
  options.kernels = fit.kernels;
  options.bytes = fit.bytes;
  options.shape = fit.shape;
  options.seed = fit.seed;
  options.model = kernel_options(dataset, fit.model, fit.threads, session);
  options.threads = fit.threads;
  options.stop = session.stop();
  return options;
}

void print_report(const FitReport& report, double seconds) {
  const auto row = [](const char* name, const std::string& text) {
    print_out("{:16}{}\n", name, text);
  };
  const auto percent = [](double share) { return fmt::format("{:.2g} %", 100 * share); };
  row("kernels", fmt::format("{}, of {}: 1 / {:.3g}", report.kernels, report.source_kernels,
                             static_cast<double>(report.source_kernels) /
                                 static_cast<double>(report.kernels)));
  row("bytes",
      fmt::format("{} ({})", report.bytes, readable_bytes(static_cast<double>(report.bytes))));
  row("PSNR", fmt::format("{:.2f} dB ({:.2f} of values above the least; all kernels, not fitted: "
                          "{:.2f})",
                          report.psnr, report.psnr_of_nonempty, report.source_psnr));
  row("greatest error", fmt::format("{:.4g} ({} of the range)", report.greatest_error,
                                    percent(report.greatest_error / report.range)));
  row("wrongly empty", percent(report.wrongly_empty));
  row("wrongly full", percent(report.wrongly_full));
  row("time", fmt::format("{:.2f} s", seconds));
}

std::string json_of(const FitReport& report, double seconds) {
  Json json;
  json["array"] = report.array;
  json["kernels"] = report.kernels;
  json["source_kernels"] = report.source_kernels;
  json["bytes"] = report.bytes;
  json["range"] = report.range;
  json["psnr_db"] = report.psnr;
  json["psnr_of_nonempty_db"] = report.psnr_of_nonempty;
  json["source_psnr_db"] = report.source_psnr;
  json["greatest_error"] = report.greatest_error;
  json["wrongly_empty"] = report.wrongly_empty;
  json["wrongly_full"] = report.wrongly_full;
  json["places"] = report.places;
  json["test_places"] = report.test_places;
  json["steps"] = Json::array();
  for (const FitStep& step : report.steps)
    json["steps"].push_back({{"kernels", step.kernels},
                             {"psnr_db", step.psnr},
                             {"greatest_error", step.greatest_error}});
  json["seconds"] = seconds;
  return json.dump(2) + "\n";
}

void check_flags(const Flags& flags, const FitFlags& fit) {
  require_inputs(flags, fit.data);
  if (fit.output.empty()) throw UsageError("--output: none given, expected -o OUT.ply");
  if (!has_ending(fit.output, ".ply"))
    throw UsageError(fmt::format("--output '{}': expected a name that ends in .ply", fit.output));
  if (!fit.psnr && !fit.tolerance && !fit.kernels && !fit.bytes)
    throw UsageError("no goal given: expected --psnr, --tolerance, --kernels or --bytes");
  std::vector<OutputFile> outputs = volume_outputs("--output", fit.output);
  if (!fit.report.empty()) outputs.push_back({"--report", fit.report, fit.report});
  check_files(volume_inputs(fit.data.inputs), outputs);
}

}  // namespace

void run_fit(const Words& words, Session& session) {
  FitFlags fit;
  Flags flags("fit", "INPUT... -o OUT.ply [GOAL] [FLAG...]",
              "Fewer kernels for the field of a mesh, an adaptive grid, particles or kernels, as "
              "good as --psnr, --tolerance, --kernels or --bytes says, and what error is left. "
              "Every command takes the result as it takes the data.");
  flags.section("");
  flags.add(fit_settings(), &fit);
  add_input_flags(flags, &fit.data);
  add_array_flags(flags, &fit.model);
  add_kernel_flags(flags, &fit.model);
  if (!flags.parse(words)) return;
  check_flags(flags, fit);
  check_volume_output("--output", fit.output);
  take_from_model(&fit.data, &fit.model);

  const Dataset dataset = load(fit.data, session);
  check_kind_flags(flags, dataset);
  if (dataset.kind == DatasetKind::kLattice)
    refuse_kind("fit", "meshes, adaptive grids, particles and kernels", dataset);
  const Stopwatch watch;
  FitReport report;
  const KernelField field = [&] {
    Progress progress("fitting");
    FitOptions options = options_of(fit, dataset, session);
    options.progress = progress.callback();
    return fit_kernels(dataset, options, &report);
  }();
  session.notes(report.notes);
  write_dataset(make_kernel_dataset(field), fit.output, {session.stop()});
  const double seconds = watch.ms() / 1000;
  if (!fit.report.empty()) write_file(fit.report, json_of(report, seconds));
  print_report(report, seconds);
}

}  // namespace ovoid::cli
