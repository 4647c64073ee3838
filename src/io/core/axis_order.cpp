// SPDX-License-Identifier: Apache-2.0
#include "io/core/axis_order.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>
#include <utility>
#include <vector>

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
  const std::size_t rank = sizes.size();
  if (rank == 2) return "yx";
  if (rank == 3) return "zyx";
  if (rank < 2) return std::nullopt;
  std::string order(rank, kPassedAxis);
  const bool has_components = is_component_axis(sizes.back()) && sizes.back() > 1;
  if (has_components) order.back() = 'c';
  std::size_t begin = 0, end = rank - (has_components ? 1 : 0);
  std::vector<std::size_t> axes;
  for (std::size_t a = begin; a < end; ++a)
    if (sizes[a] != 1) axes.push_back(a);
  if (axes.size() < 3) {
    while (end - begin > 3 && sizes[begin] == 1) ++begin;
    while (end - begin > 3 && sizes[end - 1] == 1) --end;
    axes.resize(end - begin);
    std::iota(axes.begin(), axes.end(), begin);
  }
  if (axes.size() > (has_components ? 4 : 5)) return std::nullopt;
  constexpr std::string_view kLetters[] = {"zyx", "tzyx", "tczyx"};
  const std::string_view letters = kLetters[axes.size() - 3];
  for (std::size_t i = 0; i < axes.size(); ++i) order[axes[i]] = letters[i];
  return order;
}

std::string order_with_passed_axes(const std::string& order, std::span<const std::int64_t> sizes) {
  const auto num_long = static_cast<std::size_t>(
      std::count_if(sizes.begin(), sizes.end(), [](std::int64_t size) { return size != 1; }));
  if (order.size() == sizes.size() || order.size() != num_long) return order;
  std::string whole;
  std::size_t next = 0;
  for (const std::int64_t size : sizes) whole += size == 1 ? kPassedAxis : order[next++];
  return whole;
}

std::string axis_names(std::string_view order) {
  std::string names;
  for (const char letter : order) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ",
                         letter == 't'          ? "time"
                         : letter != 'c'        ? std::string(1, letter)
                         : order.ends_with('c') ? "component"
                                                : "channel");
  }
  return fmt::format("({})", names);
}

void check_axis_order(const std::string& where, const std::string& order,
                      std::span<const std::int64_t> sizes) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: axis order '{}': {}", where, order, what));
  };
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_passed = order[i] == kPassedAxis && i < sizes.size() && sizes[i] == 1;
    if (is_passed) continue;
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
