// SPDX-License-Identifier: Apache-2.0
// --channels: the arrays or components of one file as colours of one picture (docs/two-volumes.md).
#pragma once

#include "flags.h"
#include "ovoid/dataset.h"
#include "ovoid/further_volumes.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// Makes `drawing` model the first of the wanted channels, or what red, green and blue are the
// colours of; channels lie before black unless `flags` name a background. Throws Error, naming the
// flag, for a channel that is not there.
void take_channels(const Dataset& dataset, const Flags& flags, DrawingFlags* drawing,
                   Session& session);

// Then the look of the first, whose field that is.
void take_channel_look(const Dataset& dataset, const LatticeField& field, DrawingFlags* drawing);

// The others, or red, green and blue; null: the drawing has no channels.
std::shared_ptr<const std::vector<FurtherVolume>> make_channels(const Dataset& dataset,
                                                                const DrawingFlags& drawing,
                                                                Session& session);

// Of what red, green and blue are the colours of, the own colours go: white, which they tint.
void leave_colors_to_channels(const DrawingFlags& drawing, Look* look);

// How what is drawn together is mixed.
Mixing mixing_of(const DrawingFlags& drawing);

}  // namespace ovoid::cli
