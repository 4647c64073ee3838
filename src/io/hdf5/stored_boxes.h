// SPDX-License-Identifier: Apache-2.0
// The boxes of LatticeBoxes as a lattice file holds them: docs/formats.md, "Boxes".
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "io/core/samples.h"
#include "io/hdf5/short_numbers.h"
#include "ovoid/lattice_boxes.h"

namespace ovoid::io {

// One of the numbers that a box has, which are a list each: lists of like numbers pack better.
struct BoxNumber {
  const char* name;  // of the list
  std::int64_t least;
  std::optional<std::int64_t> greatest;  // none: as many as the lattice has samples
  std::int64_t (*of)(const LatticeBox& box);
  void (*put)(LatticeBox& box, std::int64_t number);
};

template <std::size_t kAxis>
constexpr BoxNumber size_of_box(const char* name) {
  return {name, 1, kMaxAxisSize,
          [](const LatticeBox& box) -> std::int64_t { return box.size[kAxis]; },
          [](LatticeBox& box, std::int64_t n) { box.size[kAxis] = static_cast<std::int32_t>(n); }};
}

inline constexpr std::int64_t kLeastOfBox = std::numeric_limits<std::int32_t>::min();
inline constexpr std::int64_t kMostOfBox = std::numeric_limits<std::int32_t>::max();

template <std::size_t kAxis>
constexpr BoxNumber rise_of_box(const char* name) {
  return {name, kLeastOfBox, kMostOfBox,
          [](const LatticeBox& box) -> std::int64_t { return box.rise[kAxis]; },
          [](LatticeBox& box, std::int64_t n) { box.rise[kAxis] = static_cast<std::int32_t>(n); }};
}

inline constexpr std::array<BoxNumber, 8> kBoxNumbers = {
    {{"gaps", 0, std::nullopt, [](const LatticeBox& box) { return box.gap; },
      [](LatticeBox& box, std::int64_t n) { box.gap = n; }},
     size_of_box<0>("sizes_x"),
     size_of_box<1>("sizes_y"),
     size_of_box<2>("sizes_z"),
     {"firsts", kLeastOfBox, kMostOfBox,
      [](const LatticeBox& box) -> std::int64_t { return box.first; },
      [](LatticeBox& box, std::int64_t n) { box.first = static_cast<std::int32_t>(n); }},
     rise_of_box<0>("rises_x"),
     rise_of_box<1>("rises_y"),
     rise_of_box<2>("rises_z")}};

// The list of that number of all boxes.
ShortNumbers list_of(const LatticeBoxes& boxes, const BoxNumber& number);

}  // namespace ovoid::io
