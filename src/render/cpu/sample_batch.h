// SPDX-License-Identifier: Apache-2.0
// Samples of refined pieces, packed: few of a group's pieces may show something, and they take
// different numbers of steps. SIMD groups are full only if samples are taken together from all over
// a sheet.
#pragma once

#include <array>
#include <cstdint>

#include "view/look_variation.h"

namespace ovoid::cpu {

struct alignas(64) SampleBatch {
  static constexpr int kGroup = 16;                               // the most lanes of a SIMD group
  static constexpr int kMostOfGroup = kGroup * view::kMostSteps;  // that a group of pieces has
  static constexpr int kSamples = 2 * kMostOfGroup;
  // Groups are stored and read whole.
  using Floats = std::array<float, kSamples + kGroup>;

  // One step of a group's pieces: the samples of `lanes`, from sample `first` on.
  struct Step {
    int column, row;
    std::uint32_t lanes;
    int first;
  };

  int num_samples = 0;
  int num_steps = 0;
  std::array<Step, kSamples> steps;

  // Of each sample: the field, and the attribute that gives the colour, if another one does; the
  // gradient, if the frame takes any; the direction to the eye, in perspective.
  alignas(64) Floats value, color_value;
  alignas(64) std::array<Floats, 3> gradient, eye;
  // Its path, in unit distances of the look, and its depth.
  alignas(64) Floats path, depth;
  // What comes of it. The opacity is that of its path.
  alignas(64) Floats red, green, blue, opacity;

  bool has_room() const noexcept { return num_samples + kMostOfGroup <= kSamples; }
};

}  // namespace ovoid::cpu
