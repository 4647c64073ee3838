// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "flags.h"
#include "ovoid/io.h"
#include "ovoid/model.h"
#include "session.h"

namespace ovoid::cli {

// Which data: files, what headerless ones cannot say, and the array.
struct DataFlags {
  std::vector<std::string> inputs;
  RawOptions raw;
  std::string block;
  std::optional<std::int64_t> step;
  std::string array;
  int component = 0;
};

// The INPUT... arguments and the flags of sections "data" and "raw data".
void add_input_flags(Flags& flags, DataFlags* data);  // INPUT... and raw
void add_array_flags(Flags& flags, DataFlags* data);  // --array, --component

// How an array becomes a field: the model's half of section "numbers".
void add_model_flags(Flags& flags, LatticeModelOptions* model);

// Throws UsageError if no INPUT was given, or an empty one.
void require_inputs(const Flags& flags, const DataFlags& data);

// Reads the inputs, with progress; tells the reader's notes.
Dataset load(const DataFlags& data, Session& session);

// Chooses kernels; tells which array was chosen where there are several, and the model's notes.
LatticeField make_field(const Dataset& dataset, const DataFlags& data, LatticeModelOptions model,
                        LatticeModelReport* report, Session& session);

}  // namespace ovoid::cli
