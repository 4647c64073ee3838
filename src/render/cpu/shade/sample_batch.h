// SPDX-License-Identifier: Apache-2.0
// Samples of refined pieces, waiting to be shaded together: of a stage's many short loops the
// processor works on several rounds at once, and SIMD groups are full only if samples are taken
// together from all over a sheet.
//
// Where many of a group's pieces show, lanes are pixels: a step of all of them is a row of samples.
// Where few do, lanes are the steps of one piece, which follow each other.
#pragma once

#include <array>
#include <cstdint>

#include "view/look/look_variation.h"

namespace ovoid::cpu {

struct alignas(64) SampleBatch {
  static constexpr int kGroup = 16;                               // the most lanes of a SIMD group
  static constexpr int kMostOfGroup = kGroup * view::kMostSteps;  // that a group of pieces has
  static constexpr int kSamples = 2 * kMostOfGroup;               // so that they fit the L1 cache
  // Groups are stored and read whole.
  using Floats = std::array<float, kSamples + kGroup>;

  // Samples that join the pixels one after the other, from sample `first` on.
  struct Run {
    int pixel;  // of the tile: that of the piece, or of the group's first lane
    int first;
    int count;            // of the piece; 0: a step of a group's pieces
    std::uint32_t lanes;  // of the group
  };

  int num_samples = 0;
  int num_runs = 0;
  std::array<Run, kSamples> runs;

  // Of each sample: the field, and the attribute that gives the colour, if another one does; the
  // gradient, if the frame takes any; the direction to the eye, in perspective.
  alignas(64) Floats value, color_value;
  alignas(64) std::array<Floats, 3> gradient, eye;
  // How much of the light around, and of the key, arrives, if the frame has a light volume.
  alignas(64) Floats around, key;
  alignas(64) Floats clearance;  // from cut faces, if light fades there
  // Its path, in unit distances of the look, and its depth.
  alignas(64) Floats path, depth;
  // What comes of it. The opacity is that of its path.
  alignas(64) Floats red, green, blue, opacity;

  bool has_room() const noexcept { return num_samples + kMostOfGroup <= kSamples; }
};

}  // namespace ovoid::cpu
