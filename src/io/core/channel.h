// SPDX-License-Identifier: Apache-2.0
// What OME's files say of a channel.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ovoid/dataset.h"

namespace ovoid::io {

struct Channel {
  std::string name;  // empty: not said
  ChannelDisplay display{};
};

// The name of channels[index], which has one; with `number` behind it where another has the same.
std::string name_among(const std::vector<Channel>& channels, std::size_t index,
                       const std::string& number);

// Of red, green and blue from 0 to 255 each; empty for black, in which nothing shows.
std::optional<std::array<double, 3>> channel_color(const std::array<std::uint8_t, 3>& rgb);

// Programs write all that a whole number of a type can be as the range where nobody has chosen one.
void leave_out_whole_range(ScalarType type, ChannelDisplay& display);

}  // namespace ovoid::io
