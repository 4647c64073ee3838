// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/io.h"
#include "ovoid/series.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// What the data must know of the model: the array to read, where one is enough, and what a slice is
// taken of, which then is a component by itself.
void take_from_model(DataFlags* data, ModelFlags* model);

// The steps of the inputs, within --memory-limit. Throws Error.
Series open_series(const DataFlags& data, const Session& session, bool prefetch = true);
// What an animation runs along, and trails are of: these steps, or with --hyperslice the slices of
// its normal, whose times are their offsets. Throws Error.
Series open_shown_series(const DataFlags& data, const Session& session);

// What readers are told, but for progress and where the step is a matter of time.
ReadOptions read_options(const DataFlags& data, const Session& session);

// Throws Error for a flag that is for another format than the input's.
void check_format_flags(const DataFlags& data, const Dataset& dataset);

// Reads the inputs, with progress; tells the reader's notes. Throws Error, also for a flag that is
// for another format than the input's.
Dataset load(const DataFlags& data, Session& session);

// Is it a mesh whose file has no array, which has zeros instead, so that its surface can be drawn?
bool has_no_values(const Dataset& dataset);
// Throws Error(kInvalidArgument) if so. `command` is what needs values.
void require_values(const Dataset& dataset, const char* command);

}  // namespace ovoid::cli
