// SPDX-License-Identifier: Apache-2.0
#include "io/core/axis_order.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::io {

std::optional<std::size_t> axis_place(std::string_view order, char letter) noexcept {
  const std::size_t place = order.find(letter);
  return place == std::string_view::npos ? std::nullopt : std::optional(place);
}

std::optional<char> axis_called(std::string_view name) {
  static constexpr std::pair<std::string_view, char> kNames[] = {
      {"t", 't'},        {"time", 't'},     {"c", 'c'},     {"channel", 'c'},
      {"z", 'z'},        {"lev", 'z'},      {"level", 'z'}, {"depth", 'z'},
      {"height", 'z'},   {"altitude", 'z'}, {"y", 'y'},     {"lat", 'y'},
      {"latitude", 'y'}, {"x", 'x'},        {"lon", 'x'},   {"longitude", 'x'},
  };
  std::string plain(name);
  for (char& c : plain) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const auto& [known, letter] : kNames)
    if (plain == known) return letter;
  return std::nullopt;
}

bool is_component_axis(std::int64_t size) noexcept {
  return (1 <= size && size <= 4) || size == 6 || size == 9;
}

std::optional<std::string> usual_axis_order(std::span<const std::int64_t> sizes) {
  if (sizes.size() < 2 || sizes.size() > 5) return std::nullopt;
  const bool has_components = is_component_axis(sizes.back());
  if (sizes.size() == 2) return "yx";
  if (sizes.size() == 3) return "zyx";
  if (sizes.size() == 4) return has_components ? "zyxc" : "tzyx";
  return has_components ? "tzyxc" : "tczyx";
}

void check_axis_order(const std::string& where, const std::string& order,
                      std::span<const std::int64_t> sizes) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: axis order '{}': {}", where, order, what));
  };
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (kAxisLetters.find(order[i]) == std::string_view::npos || order.find(order[i]) != i)
      fail("expected letters of t, c, z, y and x, each once");
  }
  if (!axis_place(order, 'y') || !axis_place(order, 'x'))
    fail("expected y and x among the letters");
  if (order.size() != sizes.size()) {
    fail(fmt::format("has {} letters, the array has {} axes: ({})", order.size(), sizes.size(),
                     fmt::join(sizes, ", ")));
  }
}

}  // namespace ovoid::io
