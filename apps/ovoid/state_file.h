// SPDX-License-Identifier: Apache-2.0
// State files: what is looked at and how, so that it can be gone back to. The form is in
// docs/command-line.md, "State files".
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.h"
#include "flag_set.h"

namespace ovoid::cli {

inline constexpr int kStateVersion = 1;

struct State {
  std::vector<std::string> inputs;  // as the program can open them from where it runs
  FlagSet flags;
  nlohmann::ordered_json window = nlohmann::ordered_json::object();  // the viewer's own
};

// Files in it that are relative are taken from the state file's folder: the inputs, and those that
// `tf`, `camera` and `trail-tf` name. At most 16 MiB is read, and no file but the state is opened.
// Throws Error: kFileNotFound; kUnsupported for the state of a newer version; kFileFormat, in one
// line that names file and key, for what is no state, damaged, or what render would refuse.
State read_state(const std::string& path);

// Files that lie in the state file's folder or under it are written relative to that, others
// absolute. Written beside and renamed. Throws Error(kFileWrite), kInvalidArgument for names that
// are not UTF-8, which JSON cannot hold.
void write_state(const State& state, const std::string& path);

}  // namespace ovoid::cli
