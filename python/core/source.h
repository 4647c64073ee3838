// SPDX-License-Identifier: Apache-2.0
// What is drawn, fitted, converted: data in memory, or files.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ovoid/series.h"
#include "session.h"
#include "settings.h"
#include "waiting.h"

namespace ovoid::python {

// Exactly one of the two is there.
struct Source {
  std::shared_ptr<const StepSource> steps;
  std::vector<std::string> inputs;
};

// Parses a command's words with the source as its input. Throws UsageError for flags about files
// where the data are in memory, and for those about time where they are one step.
void parse(const Source& source, const cli::Words& words, cli::Flags& flags, cli::DataFlags& data);

// A session that tells its notes to the work, and is stopped with it.
cli::Session session_of(Work& work);
std::function<void(double)> progress_of(Work& work);

}  // namespace ovoid::python
