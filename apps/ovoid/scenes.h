// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ovoid/field.h"
#include "ovoid/look.h"

namespace ovoid::cli {

enum class SceneLook {
  kSoft,    // semi-transparent: most samples in sight are shaded, few pixels stop
  kOpaque,  // a surface: most samples are either outside it or behind it
};

// One standard measurement: sample data by formula, seen from its default view turned by 30 and 20
// degrees, so that no axis lies along the view.
struct BenchScene {
  std::string volume;  // a name that make_sample() knows
  int samples = 256;   // along each axis; of what is no lattice: nodes, particles or kernels
  bool is_lattice = true;
  int width = 256, height = 256;  // of the picture, pixels
  SceneLook look = SceneLook::kSoft;
  double magnification = 1;  // the view is so many times nearer

  std::string name() const;         // "head-256-512px-opaque", "head-256-1920x1080-soft-x4"
  std::string volume_name() const;  // "head-256"
};

inline constexpr double kSceneAzimuth = 30;    // degrees
inline constexpr double kSceneElevation = 20;  // degrees

// A scene of one's own by its name, as name() makes it: VOLUME-SAMPLES-WIDTHxHEIGHT-LOOK, at will
// with -xM behind. None if it is no such name.
std::optional<BenchScene> scene_named(const std::string& name);

// In this order the scenes with the same volume follow each other.
std::vector<BenchScene> standard_scenes();

// The look of a scene for values in `range`.
Look make_scene_look(SceneLook kind, const ValueRange& range);

}  // namespace ovoid::cli
