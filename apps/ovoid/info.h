// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "flags.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// What is in a dataset, and how it would be drawn by `model`, which `flags` have said; the members
// of `ovoid info --json`. Throws Error.
nlohmann::ordered_json info_json(const Dataset& dataset, const ModelFlags& model,
                                 const Flags& flags, Session& session);

}  // namespace ovoid::cli
