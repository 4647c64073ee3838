// SPDX-License-Identifier: Apache-2.0
// Channels of one stack, each in a colour, and volumes of red, green and blue: looks for what
// a scene of several volumes draws together (docs/two-volumes.md).
#pragma once

#include <cstddef>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/look.h"

namespace OVOID_API ovoid {

// From where a stain begins to stand out to where it is as bright as it gets: above the noise of
// what is unstained, which is most of a volume, up to what one sample in a thousand exceeds. Cost:
// some ten milliseconds. Throws what the field's source throws.
ValueRange channel_range(const LatticeField& field);

// Colours that mix to ones that are told apart, without red beside green: green and magenta for
// two, then azure and amber; white for one. At most four.
std::vector<Rgb> channel_colors(std::size_t count);

// One colour, and an opacity that rises over the range from 0: to 1/5 over a unit distance in mode
// composite, to 1 elsewhere.
Look channel_look(const ValueRange& range, const Rgb& color, Mode mode = Mode::kComposite);

// Of a further volume that is the red (0), green (1) or blue (2) of a field (Mixing::kColored):
// from black at the range's low end to all of the colour at its high end.
Look primary_look(const ValueRange& range, int primary);

}  // namespace ovoid
