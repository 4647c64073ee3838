// SPDX-License-Identifier: Apache-2.0
#include "data_flags.h"

#include <fmt/format.h>

#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

const Names<Reconstruction> kReconstructions = {{"normalized", Reconstruction::kNormalized},
                                                {"sum", Reconstruction::kSum}};

// "gaussian", "gaussian:SIGMA" or "gaussian:SIGMA,CUTOFF"
LatticeKernel parse_kernel(const std::string& text) {
  using K = LatticeKernel;
  const std::vector<std::string> parts = split(text, ':');
  if (parts[0] != "gaussian" || parts.size() > 2) throw BadValue("expected gaussian:SIGMA,CUTOFF");
  K kernel;
  if (parts.size() == 1) return kernel;
  const std::vector<std::string> numbers = split(parts[1], ',');
  if (numbers.size() > 2) throw BadValue("expected gaussian:SIGMA,CUTOFF");
  const auto named = [](const char* what, const std::string& number, const Interval& interval) {
    try {
      return parse_number(number, interval);
    } catch (const BadValue& bad) {
      throw BadValue(fmt::format("{}: {}", what, bad.what()));
    }
  };
  kernel.sigma = named("SIGMA", numbers[0], {K::kMinSigma, K::kMaxSigma});
  if (numbers.size() == 2) kernel.cutoff = named("CUTOFF", numbers[1], {0, K::kMaxCutoff, true});
  if (kernel.support_radius() < K::kMinSupport) {
    throw BadValue(fmt::format("expected SIGMA x CUTOFF >= {:g} spacings, else kernels leave gaps",
                               K::kMinSupport));
  }
  return kernel;
}

int parse_component(const std::string& text) {
  if (text == "magnitude") return LatticeModelOptions::kMagnitude;
  try {
    return static_cast<int>(parse_integer(text, 0, 1'000'000));
  } catch (const BadValue&) {
    throw BadValue("expected a component's number, from 0, or magnitude");
  }
}

}  // namespace

void add_input_flags(Flags& flags, DataFlags* data) {
  flags.section("data");
  flags.positionals("INPUT",
                    "a volume: NRRD, NIfTI, MetaImage, NPY, raw, SLC, VTI, VTR, legacy VTK, a "
                    "DICOM file or folder; "
                    "several are its time steps, or the slices of a DICOM series",
                    &data->inputs);
  flags.value("--block", "NAME",
              "which of several volumes, such as a DICOM series (default: the largest)",
              [data](const std::string& text) { data->block = text; });
  flags.value(
      "--step", "N", "which time step, from 0 (default: the first that varies)",
      [data](const std::string& text) { data->step = parse_integer(text, 0, 1'000'000'000); });
  flags.section("raw data, where the name is not like x_256x256x256_uint8.raw");
  flags.value("--dims", "XxYxZ", "samples along x, y, z",
              [data](const std::string& text) { data->raw.dims = parse_dims(text); });
  flags.value("--type", "TYPE", "type of a sample: uint8, int16, float32, ...",
              [data](const std::string& text) { data->raw.type = parse_scalar_type(text); });
  flags.value("--spacing", "A,B,C", "distance of samples along x, y, z (default 1,1,1)",
              [data](const std::string& text) {
                const Vec3 spacing = parse_vec3(text);
                // What any reader takes for a distance of samples.
                if (!(spacing.minCoeff() >= 1e-90 && spacing.maxCoeff() <= 1e90))
                  throw BadValue("expected three numbers > 0, from 1e-90 to 1e90");
                data->raw.spacing = spacing;
              });
  flags.toggle("--big-endian", "most significant byte first", &data->raw.big_endian);
}

void add_array_flags(Flags& flags, DataFlags* data) {
  flags.section("array");
  flags.value("--array", "NAME", "the array (default: the first that varies)",
              [data](const std::string& text) { data->array = text; });
  flags.value("--component", "N|magnitude", "of arrays with several (default 0)",
              [data](const std::string& text) { data->component = parse_component(text); });
  flags.refuse({"--color-array", "--time", "--positions", "--radius-array", "--quantity"});
}

void add_model_flags(Flags& flags, LatticeModelOptions* model) {
  flags.section("kernels");
  flags.value(
      "--kernel", "gaussian:SIGMA,CUTOFF",
      fmt::format(
          "the shared kernel; SIGMA in spacings, CUTOFF in sigmas (default gaussian:{:g},{:g})",
          model->kernel.sigma, model->kernel.cutoff),
      [model](const std::string& text) { model->kernel = parse_kernel(text); });
  flags.toggle("--prefilter", "make the field take the samples' values at the samples",
               &model->prefilter);
  flags.value("--reconstruction", joined(kReconstructions),
              fmt::format("weighted mean of the kernels, or their sum that fades to 0 (default {})",
                          name_in(kReconstructions, model->reconstruction)),
              [model](const std::string& text) {
                model->reconstruction = parse_name(text, kReconstructions);
              });
  flags.refuse({"--cutoff", "--profile-kernel", "--neighbors"});
}

void require_inputs(const Flags& flags, const DataFlags& data) {
  if (data.inputs.empty()) {
    throw UsageError(fmt::format("INPUT: none given (see ovoid {} --help)", flags.command()));
  }
  for (const std::string& input : data.inputs) {
    if (input.empty()) throw UsageError("INPUT '': expected the name of a file");
  }
}

Dataset load(const DataFlags& data, Session& session) {
  Progress progress("reading");
  ReadOptions options;
  options.raw = data.raw;
  options.array = data.array;
  options.block = data.block;
  options.step = data.step;
  options.progress = progress.callback();
  options.stop = session.stop();
  Dataset dataset = read_dataset(data.inputs, options);
  session.notes(dataset.notes);
  return dataset;
}

LatticeField make_field(const Dataset& dataset, const DataFlags& data, LatticeModelOptions model,
                        LatticeModelReport* report, Session& session) {
  model.array = data.array;
  model.component = data.component;
  LatticeModelReport own;
  LatticeModelReport& found = report != nullptr ? *report : own;
  LatticeField field = make_lattice_field(dataset, model, &found, session.stop());
  if (data.array.empty() && dataset.arrays.size() > 1) {
    std::string names;
    for (const DataArray& array : dataset.arrays) names += (names.empty() ? "" : ", ") + array.name;
    session.note(fmt::format("array '{}' of {}; choose with --array", found.array, names));
  }
  session.notes(found.notes);
  return field;
}

}  // namespace ovoid::cli
