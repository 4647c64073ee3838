// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "drawing.h"
#include "load.h"
#include "settings.h"
#include "theme.h"

namespace ovoid::viewer {

// What the command line, a state file or a drop asks to be opened: the flags of `ovoid render` and
// the window's own.
struct Launch {
  cli::DataFlags data;
  cli::DrawingFlags drawing;
  std::string state;                                                 // its file; empty: none
  nlohmann::ordered_json window = nlohmann::ordered_json::object();  // what that keeps for us
  std::string script;                                                // input to replay
  std::string record;                                                // where input is written
  std::string save_state;      // where the state is written at the end
  std::string report;          // where the measured times are written at the end
  std::optional<Theme> theme;  // none: the one that is remembered
  std::string remember;        // where; "none": nowhere; empty: the usual file
  bool watches = false;
  bool has_panel = true;
  bool has_marks = true;
  std::unique_ptr<cli::Flags> flags;  // as they were given
};

// Throws cli::UsageError. Null if help was asked for, and given.
std::shared_ptr<Launch> parse_launch(const std::vector<std::string>& words);

}  // namespace ovoid::viewer
