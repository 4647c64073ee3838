// SPDX-License-Identifier: Apache-2.0
// Which moment, and which turn of the camera, each frame of an animation shows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ovoid/series.h"
#include "setting.h"

namespace ovoid::cli {

class CameraPath;

struct AnimationFlags {
  struct Times {
    double first = 0, last = 0, step = 0;
  };
  struct Steps {
    std::optional<std::int64_t> first, last;
    std::int64_t step = 1;
  };
  std::optional<double> turn;  // degrees
  std::optional<Times> times;
  std::optional<Steps> steps;
  std::optional<std::int64_t> num_frames;
  std::string camera_path;  // a file's name, or JSON itself; empty: none

  static constexpr std::int64_t kMaxFrames = 1'000'000;
  static constexpr std::int64_t kTurnFrames = 120;  // of a turn in one moment
};

struct PlannedFrame {
  double time = 0;   // as the series counts it
  double turn = 0;   // degrees beyond the camera's own azimuth
  double place = 0;  // on the camera's path
};

const Table<AnimationFlags>& animation_settings();

// The frames in order, at least one. `only`: the moment that --step or --time took. `path`: of
// --camera-path; null: none. Throws Error(kInvalidArgument) for steps and times that the series
// does not have, for --times where it names none, for a path over times where there is one moment,
// and if nothing would move.
std::vector<PlannedFrame> plan_frames(const AnimationFlags& animation, const StepSource& source,
                                      std::optional<double> only, const CameraPath* path);

}  // namespace ovoid::cli
