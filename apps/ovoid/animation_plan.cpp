// SPDX-License-Identifier: Apache-2.0
#include "animation_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "camera_path.h"
#include "ovoid/error.h"
#include "values.h"

namespace ovoid::cli {
namespace {

constexpr const char* kTimesForm = "expected A:B:STEP with A <= B and STEP > 0";
constexpr const char* kStepsForm = "expected A:B or A:B:STEP, whole numbers with A <= B, STEP >= 1";

// Rounding must not take the last moment away.
constexpr double kLastFits = 1e-9;  // of a step

std::int64_t count_of(const AnimationFlags::Times& times) {
  return static_cast<std::int64_t>(std::floor((times.last - times.first) / times.step + kLastFits) +
                                   1);
}

AnimationFlags::Times parse_times(const std::string& text) {
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 3) throw BadValue(kTimesForm);
  AnimationFlags::Times times;
  try {
    times = {parse_number(parts[0]), parse_number(parts[1]),
             parse_number(parts[2], {.lo = 0, .lo_open = true})};
  } catch (const BadValue&) {
    throw BadValue(kTimesForm);
  }
  if (!(times.first <= times.last)) throw BadValue(kTimesForm);
  if ((times.last - times.first) / times.step >= static_cast<double>(AnimationFlags::kMaxFrames))
    throw BadValue(fmt::format("expected at most {} frames", AnimationFlags::kMaxFrames));
  return times;
}

AnimationFlags::Steps parse_steps(const std::string& text) {
  constexpr std::int64_t kGreatest = 1'000'000'000;
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 2 && parts.size() != 3) throw BadValue(kStepsForm);
  AnimationFlags::Steps steps;
  try {
    if (!parts[0].empty()) steps.first = parse_integer(parts[0], 0, kGreatest);
    if (!parts[1].empty()) steps.last = parse_integer(parts[1], 0, kGreatest);
    if (parts.size() == 3) steps.step = parse_integer(parts[2], 1, kGreatest);
  } catch (const BadValue&) {
    throw BadValue(kStepsForm);
  }
  if (steps.first && steps.last && *steps.first > *steps.last) throw BadValue(kStepsForm);
  return steps;
}

std::optional<std::string> has_stride(const std::string& text) {
  return parse_steps(text).step > 1 ? std::optional(text) : std::nullopt;
}

// The moments of --times.
std::vector<double> asked_times(const AnimationFlags::Times& asked, const StepSource& source) {
  if (!source.has_times()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--times: '{}' names no times of its {} step{}; --steps takes numbers",
                            source.name(), source.num_steps(), source.num_steps() == 1 ? "" : "s"));
  }
  const double first = source.times().front(), last = source.times().back();
  const double slack = kLastFits * asked.step;
  if (asked.first < first - slack || asked.last > last + slack) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--times {:g}:{:g}: '{}' has the times {:g} to {:g}", asked.first,
                            asked.last, source.name(), first, last));
  }
  std::vector<double> times;
  for (std::int64_t i = 0; i < count_of(asked); ++i)
    times.push_back(asked.first + static_cast<double>(i) * asked.step);
  return times;
}

// The moments of the steps asked for, one each.
std::vector<double> step_times(const AnimationFlags& animation, const StepSource& source) {
  const AnimationFlags::Steps steps = animation.steps.value_or(AnimationFlags::Steps{});
  const std::int64_t greatest = source.num_steps() - 1;
  const std::int64_t first = steps.first.value_or(0);
  const std::int64_t last = steps.last.value_or(greatest);
  if (first > greatest || last > greatest || first > last) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--steps: '{}' has the steps 0 to {}", source.name(), greatest));
  }
  std::vector<double> times;
  for (std::int64_t step = first; step <= last; step += steps.step)
    times.push_back(source.times()[static_cast<std::size_t>(step)]);
  return times;
}

// `count` moments, evenly from the first to the last of `times`.
std::vector<double> spread_times(const std::vector<double>& times, std::int64_t count) {
  std::vector<double> all;
  const double first = times.front(), last = times.back();
  for (std::int64_t i = 0; i < count; ++i) {
    const double part = count == 1 ? 0.0 : static_cast<double>(i) / static_cast<double>(count - 1);
    all.push_back(i + 1 == count && count > 1 ? last : first + part * (last - first));
  }
  return all;
}

}  // namespace

const Table<AnimationFlags>& animation_settings() {
  using A = AnimationFlags;
  static const Table<A> all = {
      {"--steps", Form<A::Steps>{"A:B[:STEP]", parse_steps}, &A::steps,
       "a frame for each step from A to B, both included; without A from the first, without B to "
       "the last (default: all)",
       not_with("step time", kGiveOne)},
      {"--times", Form<A::Times>{"A:B:STEP", parse_times}, &A::times,
       "frames at the times A, A+STEP, ... up to B, where the input names times; each shows the "
       "step nearest to its time",
       not_with("steps frames step time", kGiveOne)},
      {"--turn", number("DEG"), &A::turn,
       "turn the camera around the view's up axis by so much in all; 360 is a round whose last "
       "frame comes just before the first"},
      {"--camera-path", word("FILE|JSON", Content::kCamera), &A::camera_path,
       "keys of a camera that moves, at frames or at times: docs/time.md",
       not_with("turn", kGiveOne)},
      {"--frames", integer<std::int64_t>("N", 1, A::kMaxFrames), &A::num_frames,
       fmt::format("so many, spread evenly over the times (default: one per step; {} of a turn "
                   "around one step; of a camera path up to its last key)",
                   A::kTurnFrames),
       not_with("steps", "contradicts --steps with a STEP, which says how many there are",
                has_stride)},
  };
  return all;
}

std::vector<PlannedFrame> plan_frames(const AnimationFlags& animation, const StepSource& source,
                                      std::optional<double> only, const CameraPath* path) {
  std::vector<double> times;
  if (animation.times) {
    times = asked_times(*animation.times, source);
  } else if (only) {
    times = {*only};
  } else {
    times = step_times(animation, source);
  }
  const bool is_one_moment = times.front() == times.back();
  if (is_one_moment && !animation.turn && path == nullptr) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': one step in time, which does not move: expected --turn DEG, "
                            "--camera-path FILE, or several steps",
                            source.name()));
  }
  const bool is_timed = path != nullptr && path->is_timed();
  if (is_timed && is_one_moment) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: its keys are at times, and '{}' is drawn at one: expected keys at "
                            "frames",
                            path->source(), source.name()));
  }
  if (animation.num_frames) {
    times = spread_times(times, *animation.num_frames);
  } else if (path != nullptr && !is_timed && !animation.times && !animation.steps) {
    times = spread_times(times, path->num_frames());
  } else if (is_one_moment) {
    times.assign(AnimationFlags::kTurnFrames, times.front());
  }
  std::vector<PlannedFrame> frames;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double turn =
        animation.turn.value_or(0) * static_cast<double>(i) / static_cast<double>(times.size());
    frames.push_back({times[i], turn, is_timed ? times[i] : static_cast<double>(i)});
  }
  return frames;
}

}  // namespace ovoid::cli
