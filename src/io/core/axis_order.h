// SPDX-License-Identifier: Apache-2.0
// What the axes of an array are, as a text with a letter for each, the slowest axis first: "tczyx".
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace ovoid::io {

// t: time. c: channels or components. z, y, x: space. kPassed: an axis of one sample.
inline constexpr std::string_view kAxisLetters = "tczyx";
inline constexpr char kPassedAxis = '1';

// The place of an axis in the order; none if there is no such axis.
std::optional<std::size_t> axis_place(std::string_view order, char letter) noexcept;

// The axis that a name like "lat" or "Time" stands for; none for another name.
std::optional<char> axis_called(std::string_view name);

// The order of an array of these sizes that says nothing of it. Of 2 and 3 axes "yx" and "zyx". Of
// more the last is one of components, 'c', if it has as many entries as vectors, colours or tensors
// have (2 to 4, 6, 9), axes of one entry are passed, and those that are left are "zyx", "tzyx" or,
// without components, "tczyx". Where fewer than three are left, those of one entry before and
// behind the rest are passed, as far as three axes stay. Nothing for other numbers of axes.
std::optional<std::string> usual_axis_order(std::span<const std::int64_t> sizes);

// An order that a user has given for the axes of more than one entry alone, with the others passed;
// any other order as it is.
std::string order_with_passed_axes(const std::string& order, std::span<const std::int64_t> sizes);

// "(time, z, y, x)", for people.
std::string axis_names(std::string_view order);

// Whether a last axis of so many entries is one of components.
bool is_component_axis(std::int64_t size) noexcept;

// Throws Error(kInvalidArgument) unless the order, which a user has given, has the letters of
// kAxisLetters, each at most once, y and x among them, and as many as `sizes` has axes.
void check_axis_order(const std::string& where, const std::string& order,
                      std::span<const std::int64_t> sizes);

}  // namespace ovoid::io
