// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/dataset.h"
#include "ovoid/field.h"
#include "ovoid/geometry.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// The surfaces of --add and the slices of --slice, in their colours. `field`: what slices show.
// Throws Error for what is no surface.
Scenery make_scenery(const GeometryFlags& flags, const Field& field, Session& session);

// What a mesh needs to have a surface, where its own arrays do not count.
DataArray nothing_at_nodes(const Dataset& mesh);

}  // namespace ovoid::cli
