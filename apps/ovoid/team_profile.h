// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "team.h"

namespace ovoid::cli {

// Of one process, milliseconds.
struct StageTimes {
  double load_ms, model_ms, draw_ms;
};

// What each stage took, of the quickest and of the slowest process. All processes come here; the
// first, which has the picture, tells: on standard error, or as JSON to a file if one is named.
// Throws Error(kFileWrite).
void tell_stages(Team& team, const StageTimes& own, const std::optional<Team::Picture>& picture,
                 const std::string& file);

}  // namespace ovoid::cli
