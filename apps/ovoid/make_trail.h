// SPDX-License-Identifier: Apache-2.0
// --motion-blur: what was there some time ago, behind what is.
#pragma once

#include <cstdint>
#include <optional>

#include "make_field.h"
#include "ovoid/renderer.h"
#include "ovoid/series.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// The trail that ends at a time, for a picture with that look of a field with those values. Throws
// Error.
Trail make_trail(const TrailFlags& flags, const Series& series, double time,
                 const ModelFlags& model, int threads, const Look& look, const ValueRange& values,
                 Session& session);

// What --motion-blur asks for of what was modelled of a step; none: it is not given. Throws Error.
std::optional<Trail> trail_of(const DataFlags& data, const DrawingFlags& drawing,
                              const Modelled& modelled, std::int64_t step, const Look& look,
                              Session& session);

}  // namespace ovoid::cli
