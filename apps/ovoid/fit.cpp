// SPDX-License-Identifier: Apache-2.0
// ovoid fit: fewer kernels for a field, with a stated error.
#include "ovoid/fit.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "check_files.h"
#include "command.h"
#include "load.h"
#include "make_field.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/lattice_file.h"
#include "profile.h"
#include "setting_forms.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

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

const Table<FitFlags>& fit_settings() {
  using F = FitFlags;
  const Rule sets = for_data(
      {DatasetKind::kMesh, DatasetKind::kBoxes, DatasetKind::kParticles, DatasetKind::kKernels},
      "meshes, particles and kernels");
  const Rule of_lattice = for_data(
      {DatasetKind::kLattice}, "lattices, whose samples tell their noise; give a --psnr instead");
  static const Names<KernelShape> shapes = {{"ellipsoid", KernelShape::kEllipsoids},
                                            {"ball", KernelShape::kBalls}};
  static const Table<F> all = {
      {"-o,--output", word("OUT"), &F::output, "the kernels: .ply; of a lattice, as levels: .h5"},
      {"--psnr", number("DB"), &F::psnr, "as few kernels as reach it: 20 log10(range / rms error)"},
      {"--tolerance", Form<Tolerance>{"VALUE[%]", parse_tolerance}, &F::tolerance,
       "as few as leave no greater error; with %, of the values' range",
       not_with("psnr", kGiveOne)},
      {"--kernels", integer<std::int64_t>("N", 1, std::int64_t{1} << 40), &F::kernels,
       "so many, as good as they get", not_with("psnr tolerance", kGiveOne)},
      {"--bytes", bytes<std::int64_t>("BYTES"), &F::bytes,
       "as many as fit in a file of that size, such as 500K",
       not_with("psnr tolerance kernels", kGiveOne)},
      {"--smooth", Toggle{}, &F::smooth,
       "of a lattice as few as leave its own noise as the error: a clean copy",
       not_with("psnr tolerance kernels bytes", kGiveOne), of_lattice},
      {"--shape", choice(shapes), &F::shape, "(default {})", sets},
      {"--refine", integer("N", 0, 100), &F::refinements,
       "steps that move and shape kernels at the end, at most (default {})", sets},
      {"--seed", integer<std::uint64_t>("N", 0, std::int64_t{1} << 40), &F::seed,
       "of the places where the error is looked at (default {})", sets},
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
  options.smooth = fit.smooth;
  options.shape = fit.shape;
  options.refinements = fit.refinements;
  options.seed = fit.seed;
  options.model = kernel_options(dataset, fit.model, fit.threads, session);
  options.threads = fit.threads;
  options.stop = session.stop();
  return options;
}

void print_report(const FitReport& report, bool is_lattice, double seconds) {
  const auto row = [](const char* name, const std::string& text) {
    print_out("{:16}{}\n", name, text);
  };
  const auto percent = [](double share) { return fmt::format("{:.2g} %", 100 * share); };
  const std::string share =
      report.kernels == 0 ? ""
                          : fmt::format(": 1 / {:.3g}", static_cast<double>(report.source_kernels) /
                                                            static_cast<double>(report.kernels));
  row("kernels", fmt::format("{}, {} {}{}", report.kernels, is_lattice ? "for samples:" : "of",
                             report.source_kernels, share));
  row("bytes",
      fmt::format("{} ({})", report.bytes, readable_bytes(static_cast<double>(report.bytes))));
  row("PSNR",
      fmt::format(
          "{:.2f} dB ({:.2f} of values above the least{})", report.psnr, report.psnr_of_nonempty,
          is_lattice ? "" : fmt::format("; all kernels, not fitted: {:.2f}", report.source_psnr)));
  const double range = report.range > 0 ? report.range : 1;
  if (report.noise > 0)
    row("noise",
        fmt::format("{:.4g} ({} of the range)", report.noise, percent(report.noise / range)));
  row("greatest error", fmt::format("{:.4g} ({} of the range)", report.greatest_error,
                                    percent(report.greatest_error / range)));
  if (!is_lattice) {
    row("wrongly empty", percent(report.wrongly_empty));
    row("wrongly full", percent(report.wrongly_full));
  }
  row("time", fmt::format("{:.2f} s", seconds));
}

// JSON has no infinity: null, where there is no error.
Json decibels(double value) { return std::isfinite(value) ? Json(value) : Json(); }

std::string json_of(const FitReport& report, double seconds) {
  Json json;
  json["array"] = report.array;
  json["kernels"] = report.kernels;
  json["source_kernels"] = report.source_kernels;
  json["bytes"] = report.bytes;
  json["range"] = report.range;
  json["psnr_db"] = decibels(report.psnr);
  json["psnr_of_nonempty_db"] = decibels(report.psnr_of_nonempty);
  json["source_psnr_db"] = decibels(report.source_psnr);
  if (report.noise > 0) json["noise"] = report.noise;
  json["greatest_error"] = report.greatest_error;
  json["wrongly_empty"] = report.wrongly_empty;
  json["wrongly_full"] = report.wrongly_full;
  json["places"] = report.places;
  json["test_places"] = report.test_places;
  json["steps"] = Json::array();
  for (const FitStep& step : report.steps)
    json["steps"].push_back({{"kernels", step.kernels},
                             {"psnr_db", decibels(step.psnr)},
                             {"greatest_error", step.greatest_error}});
  json["seconds"] = seconds;
  return json.dump(2) + "\n";
}

void check_flags(const Flags& flags, const FitFlags& fit) {
  require_inputs(flags, fit.data);
  if (fit.output.empty()) throw UsageError("--output: none given, expected -o OUT.ply or OUT.h5");
  if (!has_ending(fit.output, ".ply") && !has_ending(fit.output, ".h5")) {
    throw UsageError(fmt::format(
        "--output '{}': expected a name that ends in .ply, or, of a lattice, in .h5", fit.output));
  }
  if (!fit.psnr && !fit.tolerance && !fit.kernels && !fit.bytes && !fit.smooth)
    throw UsageError("no goal given: expected --psnr, --tolerance, --kernels, --bytes or --smooth");
  std::vector<OutputFile> outputs = volume_outputs("--output", fit.output);
  if (!fit.report.empty()) outputs.push_back({"--report", fit.report, fit.report});
  check_files(volume_inputs(fit.data.inputs), outputs);
}

// What the ending of the output says must be what the data are.
void check_output(const Flags& flags, const FitFlags& fit, const Dataset& dataset) {
  const bool is_lattice = dataset.kind == DatasetKind::kLattice;
  if (is_lattice && !has_ending(fit.output, ".h5")) {
    throw UsageError(fmt::format("--output '{}': '{}' is a lattice, whose kernels go into .h5",
                                 fit.output, one_line(dataset.source)));
  }
  if (!is_lattice && !has_ending(fit.output, ".ply")) {
    throw UsageError(fmt::format("--output '{}': '{}' is no lattice, its kernels go into .ply",
                                 fit.output, one_line(dataset.source)));
  }
  const std::string flag = flags.first_given(kernel_settings());
  if (is_lattice && !flag.empty())
    throw UsageError(fmt::format("{}: has no effect on the fit of a lattice", flag));
}

void fit_set(const Dataset& dataset, const FitOptions& options, const std::string& output,
             FitReport& report) {
  const KernelField field = fit_kernels(dataset, options, &report);
  write_dataset(make_kernel_dataset(field), output, {options.stop});
}

void fit_levels(const Dataset& dataset, const FitOptions& options, const std::string& output,
                FitReport& report) {
  const LatticeLevels levels = fit_lattice(dataset, options, &report);
  const LatticeFileHeader header =
      lattice_file_header(dataset, report.array, LatticeContent::kLevels, levels.whole);
  LatticeFileWriter writer(output, header, {options.stop});
  writer.write_levels({&levels, 1});
  writer.finish();
  report.bytes = static_cast<std::int64_t>(std::filesystem::file_size(output));
}

}  // namespace

void run_fit(const Words& words, Session& session) {
  FitFlags fit;
  Flags flags("fit", "INPUT... -o OUT [GOAL] [FLAG...]",
              "Fewer kernels for the field of a scan, a mesh, an adaptive grid, particles or "
              "kernels, as good as --psnr, --tolerance, --kernels, --bytes or --smooth says, and "
              "what error is left. Every command takes the result as it takes the data.");
  flags.section("");
  flags.add(fit_settings(), &fit);
  add_input_flags(flags, &fit.data);
  add_array_flags(flags, &fit.model);
  add_kernel_flags(flags, &fit.model);
  flags.footer(
      "--memory-limit, where it is given, also bounds what a fit works with beside the data: fewer "
      "places are looked at, and a fit that takes more than that is refused.");
  if (!flags.parse(words)) return;
  check_flags(flags, fit);
  check_volume_output("--output", fit.output);
  take_from_model(&fit.data, &fit.model);

  const Dataset dataset = load(fit.data, session);
  check_kind_flags(flags, dataset);
  check_output(flags, fit, dataset);
  const bool is_lattice = dataset.kind == DatasetKind::kLattice;
  const Stopwatch watch;
  FitReport report;
  {
    Progress progress("fitting");
    FitOptions options = options_of(fit, dataset, session);
    options.progress = progress.callback();
    if (flags.is_given("memory-limit")) options.memory_limit = fit.data.memory_limit;
    (is_lattice ? fit_levels : fit_set)(dataset, options, fit.output, report);
  }
  session.notes(report.notes);
  const double seconds = watch.ms() / 1000;
  if (!fit.report.empty()) write_file(fit.report, json_of(report, seconds));
  print_report(report, is_lattice, seconds);
}

}  // namespace ovoid::cli
