// SPDX-License-Identifier: Apache-2.0
#include "data_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "environment.h"
#include "ovoid/error.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

const Names<TimeFilter> kTimeFilters = {{"two-steps", TimeFilter::kTwoSteps},
                                        {"gaussian", TimeFilter::kGaussian},
                                        {"exact", TimeFilter::kExact}};

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
  flags.value(
      "--time", "T",
      "the data at this time, between steps interpolated; where the input names no times, a "
      "step's number is its time",
      [data](const std::string& text) { data->time = parse_number(text); });
  flags.value(
      "--time-filter", joined(kTimeFilters),
      fmt::format("kernels over time of lattices in space and time (D4*): docs/time.md "
                  "(default {})",
                  name_in(kTimeFilters, data->time_filter)),
      [data](const std::string& text) { data->time_filter = parse_name(text, kTimeFilters); });
  add_slice_flags(flags, &data->slice);
  flags.value("--memory-limit", "BYTES",
              "of the steps in memory, as 4G or 512M; one is in any case (default 1G)",
              [data](const std::string& text) { data->memory_limit = parse_bytes(text); });
  flags.value("--positions", "PATH",
              "HDF5: the particles' positions, such as /PartType1/Coordinates (default: found)",
              [data](const std::string& text) { data->positions = text; });
  flags.repeatable("--value", "PATH",
                   "HDF5: an array of the particles (repeatable; default: those beside the "
                   "positions)",
                   [data](const std::string& text) { data->values.push_back(text); });
  flags.repeatable(
      "--data-folder", "DIR",
      "files that the input names (pieces, samples, external storage of HDF5) may also "
      "lie below this folder (repeatable; default: below the input's own)",
      [data](const std::string& text) { data->folders.push_back(text); });
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
  check_data_flags(flags, data);
}

void check_data_flags(const Flags& flags, const DataFlags& data) {
  if (data.step && data.time) throw UsageError("--time: contradicts --step; give one of them");
  check_slice_flags(flags, data.slice);
}

void check_format_flags(const DataFlags& data, const Dataset& dataset) {
  const char* const given = !data.positions.empty() ? "--positions"
                            : !data.values.empty()  ? "--value"
                                                    : nullptr;
  if (given == nullptr || dataset.format == "HDF5") return;
  throw Error(ErrorCode::kInvalidArgument, fmt::format("{}: is for HDF5 files, '{}' is {}", given,
                                                       dataset.source, dataset.format));
}

void take_from_model(DataFlags* data, ModelFlags* model) {
  data->array = array_to_read(*model);
  if (!data->slice.plane) return;
  data->component = std::exchange(model->lattice.component, 0);
  model->kernels.component = 0;
}

Series open_series(const DataFlags& data, const Session& session, bool prefetch) {
  return Series(open_steps(data.inputs, read_options(data, session)),
                {.memory_limit = data.memory_limit, .prefetch = prefetch});
}

ReadOptions read_options(const DataFlags& data, const Session& session) {
  ReadOptions options;
  options.raw = data.raw;
  options.array = data.array;
  options.block = data.block;
  options.step = data.step;
  options.stop = session.stop();
  options.hdf5.positions = data.positions;
  options.hdf5.values = data.values;
  options.data_folders = data.folders;
  options.reader_program = reader_of_environment();
  return options;
}

namespace {

void require_steps(const Dataset& dataset) {
  if (dataset.num_steps > 1) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("--time: '{}' has one step", dataset.source));
}

// Made of the steps around the time; a note tells which.
Dataset at_time(const DataFlags& data, double time, Session& session) {
  const Series series = open_series(data, session, false);
  TimeSliceOptions options;
  options.filter = data.time_filter;
  options.stop = session.stop();
  Dataset dataset = slice_at_time(series, time, options);
  if (series.source().kind() == SeriesKind::kStaggered) {
    session.note(fmt::format("time {:g}: of both halves of the lattice in time", time));
    return dataset;
  }
  const std::vector<StepWeight> weights = weights_of_steps(series.times(), time);
  if (weights.size() == 1) {
    session.note(fmt::format("time {:g}: step {}", time, weights[0].step));
  } else {
    session.note(fmt::format("time {:g}: between steps {} and {}, {:.0f} % of the second", time,
                             weights[0].step, weights[1].step, 100 * weights[1].weight));
  }
  return dataset;
}

Dataset sliced(const DataFlags& data, Session& session) {
  const Series series = open_series(data, session);
  HypersliceOptions options;
  options.method = data.slice.method;
  options.lattice = data.slice.lattice;
  options.spacing = data.slice.spacing;
  options.filter = data.time_filter;
  options.array = data.array;
  options.component = data.component;
  options.stop = session.stop();
  return hyperslice(series, *data.slice.plane, options);
}

}  // namespace

Dataset load(const DataFlags& data, Session& session) {
  if (data.slice.plane) {
    Dataset dataset = sliced(data, session);
    session.notes(dataset.notes);
    return dataset;
  }
  Progress progress("reading");
  ReadOptions options = read_options(data, session);
  options.progress = progress.callback();
  Dataset dataset = read_dataset(data.inputs, options);
  const bool is_half = dataset.series == SeriesKind::kStaggered && !data.step;
  if (data.time || is_half) {
    const double time =
        data.time.value_or(is_half ? dataset.times[static_cast<std::size_t>(dataset.step)] : 0.0);
    require_steps(dataset);
    dataset = at_time(data, time, session);
  }
  check_format_flags(data, dataset);
  session.notes(dataset.notes);
  return dataset;
}

}  // namespace ovoid::cli
