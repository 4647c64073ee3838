// SPDX-License-Identifier: Apache-2.0
#include "io/core/channel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ovoid::io {

std::string name_among(const std::vector<Channel>& channels, std::size_t index,
                       const std::string& number) {
  const std::string& name = channels[index].name;
  const auto same = std::count_if(channels.begin(), channels.end(),
                                  [&](const Channel& other) { return other.name == name; });
  return same > 1 ? fmt::format("{} ({})", name, number) : name;
}

std::optional<std::array<double, 3>> channel_color(const std::array<std::uint8_t, 3>& rgb) {
  if (rgb == std::array<std::uint8_t, 3>{}) return std::nullopt;
  return std::array{rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0};
}

void leave_out_whole_range(ScalarType type, ChannelDisplay& display) {
  if (!display.range || is_floating(type)) return;
  const auto [first, last] = *display.range;
  if (last - first >= std::ldexp(1.0, 8 * static_cast<int>(size_of(type))) - 1)
    display.range.reset();
}

}  // namespace ovoid::io
