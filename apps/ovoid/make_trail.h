// SPDX-License-Identifier: Apache-2.0
// --motion-blur: what was there some time ago, behind what is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "make_field.h"
#include "ovoid/renderer.h"
#include "ovoid/series.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// What a trail is drawn with.
struct TrailSubject {
  const Field& now;
  const Look& look;
  ValueRange values;                             // that the look is for
  std::optional<std::size_t> memory_limit = {};  // --memory-limit
};

// The trail of a series that ends at a time. Throws Error.
Trail make_trail(const TrailFlags& flags, const Series& series, double time,
                 const ModelFlags& model, int threads, const TrailSubject& subject,
                 Session& session);

// All of its moments.
Bounds3 bounds_of(const Trail& trail);

// What --motion-blur asks for of what was modelled of a step; null: it is not given. Throws Error.
std::shared_ptr<const Trail> trail_of(const DataFlags& data, const DrawingFlags& drawing,
                                      const Modelled& modelled, std::int64_t step, const Look& look,
                                      Session& session);

}  // namespace ovoid::cli
