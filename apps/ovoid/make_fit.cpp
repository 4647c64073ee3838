// SPDX-License-Identifier: Apache-2.0
#include "make_fit.h"

#include <fmt/format.h>

#include "make_field.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/lattice_file.h"
#include "ovoid/output_files.h"
#include "usage.h"

namespace ovoid::cli {

using Json = nlohmann::ordered_json;

namespace {

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
       "so many that no error is greater; with %, of the values' range",
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
  report.bytes = size_of_written(output);
}

}  // namespace

Flags make_fit_flags(FitFlags* into) {
  Flags flags("fit", "INPUT... -o OUT [GOAL] [FLAG...]",
              "Fewer kernels for the field of a scan, a mesh, an adaptive grid, particles or "
              "kernels, as good as --psnr, --tolerance, --kernels, --bytes or --smooth says, and "
              "what error is left. Every command takes the result as it takes the data.");
  flags.section("");
  flags.add(fit_settings(), into);
  add_input_flags(flags, &into->data);
  add_array_flags(flags, &into->model);
  add_kernel_flags(flags, &into->model);
  flags.footer(
      "--memory-limit, where it is given, also bounds what a fit works with beside the data: fewer "
      "places are looked at, and a fit that takes more than that is refused.");
  return flags;
}

void check_fit_flags(const FitFlags& fit) {
  if (fit.output.empty()) throw UsageError("--output: none given, expected -o OUT.ply or OUT.h5");
  if (!has_ending(fit.output, ".ply") && !has_ending(fit.output, ".h5")) {
    throw UsageError(fmt::format(
        "--output '{}': expected a name that ends in .ply, or, of a lattice, in .h5", fit.output));
  }
  if (!fit.psnr && !fit.tolerance && !fit.kernels && !fit.bytes && !fit.smooth)
    throw UsageError("no goal given: expected --psnr, --tolerance, --kernels, --bytes or --smooth");
}

void check_fit_ending(const std::string& output, const Dataset& dataset) {
  const bool is_lattice = dataset.kind == DatasetKind::kLattice;
  if (is_lattice && !has_ending(output, ".h5")) {
    throw UsageError(fmt::format("--output '{}': '{}' is a lattice, whose kernels go into .h5",
                                 output, one_line(dataset.source)));
  }
  if (!is_lattice && !has_ending(output, ".ply")) {
    throw UsageError(fmt::format("--output '{}': '{}' is no lattice, its kernels go into .ply",
                                 output, one_line(dataset.source)));
  }
}

FitReport make_fit(const Dataset& dataset, const Flags& flags, const FitFlags& fit,
                   Session& session, const std::function<void(double)>& progress) {
  check_kind_flags(flags, dataset);
  check_fit_ending(fit.output, dataset);
  const bool is_lattice = dataset.kind == DatasetKind::kLattice;
  const std::string flag = flags.first_given(kernel_settings());
  if (is_lattice && !flag.empty())
    throw UsageError(fmt::format("{}: has no effect on the fit of a lattice", flag));
  FitOptions options = options_of(fit, dataset, session);
  options.progress = progress;
  if (fit.data.memory_limit) options.memory_limit = *fit.data.memory_limit;
  FitReport report;
  (is_lattice ? fit_levels : fit_set)(dataset, options, fit.output, report);
  session.notes(report.notes);
  return report;
}

ReportRows rows_of(const FitReport& report, DatasetKind kind, double seconds) {
  const bool is_lattice = kind == DatasetKind::kLattice;
  ReportRows rows;
  const auto row = [&](const char* name, const std::string& text) {
    rows.emplace_back(name, text);
  };
  row("kernels",
      fmt::format("{}, {} {}{}", report.kernels, is_lattice ? "for samples:" : "of",
                  report.source_kernels, one_for_text(report.source_kernels, report.kernels)));
  row("bytes", bytes_text(report.bytes));
  row("PSNR",
      fmt::format(
          "{:.2f} dB ({:.2f} of values above the least{})", report.psnr, report.psnr_of_nonempty,
          is_lattice ? "" : fmt::format("; all kernels, not fitted: {:.2f}", report.source_psnr)));
  if (report.noise > 0) row("noise", error_text(report.noise, report.range));
  row("greatest error", error_text(report.greatest_error, report.range));
  if (!is_lattice) {
    row("wrongly empty", share_text(report.wrongly_empty));
    row("wrongly full", share_text(report.wrongly_full));
  }
  row("time", seconds_text(seconds));
  return rows;
}

Json json_of(const FitReport& report, double seconds) {
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
  return json;
}

}  // namespace ovoid::cli
