// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "flags.h"
#include "model_flags.h"
#include "ovoid/io.h"
#include "ovoid/series.h"
#include "ovoid/slices.h"
#include "session.h"
#include "slice_flags.h"

namespace ovoid::cli {

// Which data: files, and what headerless ones cannot say.
struct DataFlags {
  std::vector<std::string> inputs;
  RawOptions raw;
  std::string block;
  std::optional<std::int64_t> step;
  std::optional<double> time;
  TimeFilter time_filter = TimeFilter::kTwoSteps;
  SliceFlags slice;
  std::size_t memory_limit = std::size_t{1} << 30;  // bytes of steps
  std::string positions;                            // HDF5: the path of the positions
  std::vector<std::string> values;                  // HDF5: paths of arrays
  std::vector<std::string> folders;  // where files that the input names may lie, beside its own
  std::string array;  // the only one that is read where the format allows; empty: all
  int component = 0;  // of hyperslices
};

// The INPUT... arguments and the flags of sections "data" and "raw data".
void add_input_flags(Flags& flags, DataFlags* data);

// Throws UsageError if no INPUT was given, or an empty one, and for contradictions.
void require_inputs(const Flags& flags, const DataFlags& data);
void check_data_flags(const Flags& flags, const DataFlags& data);  // for contradictions alone

// What the data must know of the model: the array to read, where one is enough, and what a slice is
// taken of, which then is a component by itself.
void take_from_model(DataFlags* data, ModelFlags* model);

// The steps of the inputs, within --memory-limit. Throws Error.
Series open_series(const DataFlags& data, const Session& session, bool prefetch = true);

// What readers are told, but for progress and where the step is a matter of time.
ReadOptions read_options(const DataFlags& data, const Session& session);

// Throws Error for a flag that is for another format than the input's.
void check_format_flags(const DataFlags& data, const Dataset& dataset);

// Reads the inputs, with progress; tells the reader's notes. Throws Error, also for a flag that is
// for another format than the input's.
Dataset load(const DataFlags& data, Session& session);

}  // namespace ovoid::cli
