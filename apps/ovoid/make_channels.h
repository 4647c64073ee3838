// SPDX-License-Identifier: Apache-2.0
// --channels: the arrays or components of one file as colours of one picture (docs/two-volumes.md).
#pragma once

#include <string>
#include <vector>

#include "flags.h"
#include "ovoid/dataset.h"
#include "ovoid/scene.h"
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

// The others, or red, green and blue, as a scene has them behind its first volume; none: the
// drawing has no channels.
std::vector<Volume> make_channels(const Dataset& dataset, const DrawingFlags& drawing,
                                  Session& session);

// A channel by itself.
struct NamedChannel {
  std::string name;   // as --channels takes it
  std::string title;  // for people
  LatticeField field;
  ValueRange range;  // that the flags give it, or its own
  Rgb color;
};
// Those of a drawing after take_channels(), which is of these volumes; none of red, green and blue.
std::vector<NamedChannel> named_channels(const Dataset& dataset, const DrawingFlags& drawing,
                                         const std::vector<Volume>& volumes);

// What a channel's look is made by; flags about light are those of the whole picture.
LookFlags channel_look_flags(const LookFlags& picture, const ValueRange& range, const Rgb& color);

// Of what red, green and blue are the colours of, the own colours go: white, which they tint.
void leave_colors_to_channels(const DrawingFlags& drawing, Look* look);

// How what is drawn together is mixed.
Mixing mixing_of(const DrawingFlags& drawing);

}  // namespace ovoid::cli
