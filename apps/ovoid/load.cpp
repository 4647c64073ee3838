// SPDX-License-Identifier: Apache-2.0
#include "load.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "environment.h"
#include "make_field.h"
#include "make_geometry.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"
#include "team.h"
#include "usage.h"

namespace ovoid::cli {
void check_format_flags(const DataFlags& data, const Dataset& dataset) {
  const char* const given = !data.positions.empty() ? "--positions"
                            : !data.values.empty()  ? "--value"
                                                    : nullptr;
  if (given == nullptr || dataset.format.starts_with("HDF5")) return;
  throw Error(ErrorCode::kInvalidArgument, fmt::format("{}: is for HDF5 files, '{}' is {}", given,
                                                       dataset.source, dataset.format));
}

bool has_no_values(const Dataset& dataset) {
  return dataset.kind == DatasetKind::kMesh && dataset.arrays.size() == 1 &&
         dataset.arrays.front().name == kNothing;
}

void require_values(const Dataset& dataset, const char* command) {
  if (!has_no_values(dataset)) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: '{}' has no array of numbers at its points or cells: expected some; "
                          "'ovoid render' draws its surface",
                          command, dataset.source));
}

void take_from_model(DataFlags* data, ModelFlags* model) {
  data->array = array_to_read(*model);
  if (!data->slice.plane) return;
  const int asked = std::exchange(model->component, kUsualComponent);
  data->component = asked == kUsualComponent ? 0 : asked;
}

Series open_series(const DataFlags& data, const Session& session, bool prefetch) {
  return Series(
      data.steps != nullptr ? data.steps : open_steps(data.inputs, read_options(data, session)),
      {.memory_limit = data.memory_limit.value_or(kMemoryOfSteps), .prefetch = prefetch});
}

namespace {

// Between steps rows of both are needed together.
bool shares_rows(const DataFlags& data, const Session& session) {
  return data.may_be_shared && !data.time && session.team() != nullptr &&
         session.team()->kernels() != nullptr;
}

}  // namespace

ReadOptions read_options(const DataFlags& data, const Session& session) {
  ReadOptions options;
  options.raw = data.raw;
  options.array = data.array;
  options.block = data.block;
  options.step = data.step;
  options.may_stay_in_file = data.may_stay_in_file;
  if (shares_rows(data, session))
    options.share = RowShare{session.team()->number(), session.team()->count()};
  if (session.team() != nullptr) options.processes_beside = session.team()->beside();
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

// The step that is named, or is shown without a name.
Dataset read_step(const DataFlags& data, const ReadOptions& options) {
  if (data.steps == nullptr) return read_dataset(data.inputs, options);
  return data.step ? data.steps->read(*data.step, options.stop)
                   : step_to_show(*data.steps, options.array, options.stop);
}

// Made of the steps around the time that is asked for, or else that of `step`; a note tells which.
Dataset at_time(const DataFlags& data, std::optional<double> asked, std::int64_t step,
                Session& session) {
  const Series series = open_series(data, session, false);
  const double time = asked.value_or(series.times()[static_cast<std::size_t>(step)]);
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

HypersliceOptions slice_options(const DataFlags& data, const Session& session) {
  HypersliceOptions options;
  options.method = data.slice.method;
  options.lattice = data.slice.lattice;
  options.spacing = data.slice.spacing;
  options.filter = data.time_filter;
  options.array = data.array;
  options.component = data.component;
  options.stop = session.stop();
  return options;
}

Dataset sliced(const DataFlags& data, Session& session) {
  if (std::isnan(data.slice.plane->offset)) {
    throw UsageError(
        "--hyperslice: expected A,B,C,D,E; A,B,C,D alone is for animate, which goes along E");
  }
  return hyperslice(open_series(data, session), *data.slice.plane, slice_options(data, session));
}

}  // namespace

Series open_shown_series(const DataFlags& data, const Session& session) {
  if (!data.slice.plane) return open_series(data, session);
  return Series(hyperslice_steps(std::make_shared<const Series>(open_series(data, session)),
                                 *data.slice.plane, {}, slice_options(data, session)));
}

Dataset load(const DataFlags& data, Session& session) {
  if (data.slice.plane) {
    Dataset dataset = sliced(data, session);
    session.notes(dataset.notes);
    return dataset;
  }
  if (data.inputs.size() == 1) {
    if (const auto held = session.provided(data.inputs.front())) {
      session.notes(held->notes);
      return *held;
    }
  }
  Progress progress("reading");
  ReadOptions options = read_options(data, session);
  options.progress = progress.callback();
  // Between steps all of their samples are needed.
  if (!data.time) options.memory_limit = static_cast<std::int64_t>(data.memory_limit.value_or(0));
  if (session.team() != nullptr && options.may_stay_in_file) {
    // What stays in a file for one of them does so for all.
    session.team()->meet();
    const auto own = static_cast<double>(memory_for_field(options));
    options.memory_limit = static_cast<std::int64_t>(session.team()->spread(own).least);
  }
  Dataset dataset = read_step(data, options);
  const bool is_half =
      dataset.series == SeriesKind::kStaggered && dataset.num_steps > 1 && !data.step;
  if (dataset.share) agree_on_array(dataset, *session.team()->kernels());
  if (data.time || is_half) {
    require_steps(dataset);
    dataset = at_time(data, data.time, dataset.step, session);
  }
  check_format_flags(data, dataset);
  session.notes(dataset.notes);
  return dataset;
}

}  // namespace ovoid::cli
