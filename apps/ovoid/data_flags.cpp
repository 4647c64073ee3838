// SPDX-License-Identifier: Apache-2.0
#include "data_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ovoid/error.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

// The step whose time is nearest, the earlier of two.
std::int64_t nearest_step(const Dataset& dataset, double time) {
  if (dataset.times.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--time: '{}' names no times of its {} step{}; --step takes a number",
                            dataset.source, dataset.num_steps, dataset.num_steps == 1 ? "" : "s"));
  }
  const auto nearest = std::min_element(
      dataset.times.begin(), dataset.times.end(),
      [time](double a, double b) { return std::abs(a - time) < std::abs(b - time); });
  return nearest - dataset.times.begin();
}

void check_format_flags(const DataFlags& data, const Dataset& dataset) {
  const char* const given = !data.positions.empty() ? "--positions"
                            : !data.values.empty()  ? "--value"
                                                    : nullptr;
  if (given == nullptr || dataset.format == "HDF5") return;
  throw Error(ErrorCode::kInvalidArgument, fmt::format("{}: is for HDF5 files, '{}' is {}", given,
                                                       dataset.source, dataset.format));
}

}  // namespace

void add_input_flags(Flags& flags, DataFlags* data) {
  flags.section("data");
  flags.positionals("INPUT",
                    "a volume, mesh, particles or kernels in any format of docs/formats.md, or a "
                    "folder of DICOM files; several are the time steps of one, the slices of a "
                    "DICOM series, or the parts of a format that has some",
                    &data->inputs);
  flags.value("--block", "NAME",
              "which of several volumes, such as a DICOM series (default: the largest)",
              [data](const std::string& text) { data->block = text; });
  flags.value(
      "--step", "N", "which time step, from 0 (default: the first that varies)",
      [data](const std::string& text) { data->step = parse_integer(text, 0, 1'000'000'000); });
  flags.value("--time", "T", "the time step nearest to this time, where the input names times",
              [data](const std::string& text) { data->time = parse_number(text); });
  flags.value("--positions", "PATH",
              "HDF5: the particles' positions, such as /PartType1/Coordinates (default: found)",
              [data](const std::string& text) { data->positions = text; });
  flags.repeatable("--value", "PATH",
                   "HDF5: an array of the particles (repeatable; default: those beside the "
                   "positions)",
                   [data](const std::string& text) { data->values.push_back(text); });
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

void require_inputs(const Flags& flags, const DataFlags& data) {
  if (data.inputs.empty()) {
    throw UsageError(fmt::format("INPUT: none given (see ovoid {} --help)", flags.command()));
  }
  for (const std::string& input : data.inputs) {
    if (input.empty()) throw UsageError("INPUT '': expected the name of a file");
  }
  if (data.step && data.time) throw UsageError("--time: contradicts --step; give one of them");
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
  options.positions = data.positions;
  options.values = data.values;
  Dataset dataset = read_dataset(data.inputs, options);
  if (data.time) {
    // What the steps' times are is known once one of them has been read.
    options.step = nearest_step(dataset, *data.time);
    if (*options.step != dataset.step) dataset = read_dataset(data.inputs, options);
    session.note(fmt::format("--time {:g}: step {}, time {:g}", *data.time, dataset.step,
                             dataset.times[static_cast<std::size_t>(dataset.step)]));
  }
  check_format_flags(data, dataset);
  session.notes(dataset.notes);
  return dataset;
}

}  // namespace ovoid::cli
