// SPDX-License-Identifier: Apache-2.0
// Camera paths: fails if a key's camera is not what its words say, if what lies between two keys
// leaves their range, jumps, or takes the longer way around, or if a bad path is drawn.
#include "camera_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "ovoid/error.h"
#include "ovoid/io.h"
#include "program.h"

namespace ovoid::cli_tests {
namespace camera_path_test {

using cli::CameraFlags;
using cli::CameraPath;
using cli::CameraTrack;

constexpr double kRadians = std::numbers::pi / 180;
// Sums and products of a dozen numbers of this size.
constexpr double kRounding = 1e-12;

// From +z at a distance of 10, y up.
Camera front() {
  Camera camera;
  camera.position = {1, 2, 13};
  camera.focal_point = {1, 2, 3};
  return camera;
}

CameraTrack track_of(const std::string& text, const CameraFlags& flags = {}) {
  return {CameraPath(text, "p"), front(), flags};
}

Vec3 seen_from(const Camera& camera) { return (camera.position - camera.focal_point).normalized(); }

double distance(const Camera& camera) { return (camera.position - camera.focal_point).norm(); }

void expect_same(const Camera& found, const Camera& expected) {
  EXPECT_EQ(to_text(found), to_text(expected));
}

TEST(CameraPaths, KeysAreWhatTheirWordsSay) {
  const auto track = track_of(R"([
      {"frame": 0},
      {"frame": 10, "azimuth": 30, "elevation": 20, "roll": 5, "zoom": 2},
      {"frame": 15, "position": [9, 8, 7], "view_up": [0, 0, 1], "view_angle": 20},
      {"frame": 20, "focal_point": [0, 0, 1], "azimuth": 200, "zoom": 0.5}])");
  expect_same(track.at(0), front());
  Camera turned = front();
  turned.azimuth(30);
  turned.elevation(20);
  turned.roll(5);
  turned.zoom(2);
  expect_same(track.at(10), turned);
  Camera moved = front();
  moved.position = {9, 8, 7};
  moved.view_up = {0, 0, 1};
  moved.view_angle = 20;
  moved.elevation(0);
  expect_same(track.at(15), moved);
  Camera last = front();
  last.focal_point = {0, 0, 1};
  last.azimuth(200);
  last.elevation(0);
  last.zoom(0.5);
  expect_same(track.at(20), last);
  expect_same(track.at(-5), front());
  expect_same(track.at(999), last);
}

TEST(CameraPaths, FlagsTurnAllKeys) {
  CameraFlags flags;
  flags.azimuth = 15;
  flags.elevation = 10;
  flags.zoom = 1.5;
  const auto track = track_of(R"([{"frame": 0}, {"frame": 2, "azimuth": 90, "zoom": 2}])", flags);
  Camera expected = front();
  expected.azimuth(15);
  expected.elevation(10);
  expected.zoom(1.5);
  expect_same(track.at(0), expected);
  expected = front();
  expected.azimuth(105);
  expected.elevation(10);
  expected.zoom(3);
  expect_same(track.at(2), expected);
}

TEST(CameraPaths, TwoKeysAreARoundOfOneSpeed) {
  const auto track = track_of(R"([{"frame": 0}, {"frame": 8, "azimuth": 360, "zoom": 16}])");
  for (int frame = 0; frame <= 8; ++frame) {
    const Camera camera = track.at(frame);
    const double angle = 45 * frame * kRadians;
    EXPECT_LT((seen_from(camera) - Vec3(std::sin(angle), 0, std::cos(angle))).norm(), kRounding)
        << frame;
    EXPECT_NEAR(camera.view_angle, 30 / std::exp2(frame / 2.0), 30 * kRounding) << frame;
    EXPECT_NEAR(distance(camera), 10, 10 * kRounding) << frame;
  }
}

// Both orientations are turns about y; from 0 over the back to 190 degrees it is shorter the other
// way.
TEST(CameraPaths, OrientationsTakeTheShorterWay) {
  const double angle = 190 * kRadians;
  const std::string there =
      fmt::format("[{}, 2, {}]", 1 + 20 * std::sin(angle), 3 + 20 * std::cos(angle));
  const auto track = track_of(R"([{"frame": 0}, {"frame": 4, "position": )" + there + "}]");
  for (int frame = 0; frame <= 4; ++frame) {
    const Camera camera = track.at(frame);
    const double turned = -170 * kRadians * frame / 4;
    EXPECT_LT((seen_from(camera) - Vec3(std::sin(turned), 0, std::cos(turned))).norm(), 1e-11)
        << frame;
    EXPECT_LT((camera.view_up - Vec3::UnitY()).norm(), 1e-11) << frame;
    EXPECT_NEAR(distance(camera), 10 * std::exp2(frame / 4.0), 1e-10) << frame;
  }
}

// Of the slopes 1 and 4 over stretches as long, the harmonic mean is 1.6; between the keys the
// cubic with that slope.
TEST(CameraPaths, NumbersFollowTheCubicOfHarmonicMeans) {
  const auto track = track_of(
      R"([{"frame": 0}, {"frame": 10, "focal_point": [11, 2, 3], "position": [11, 2, 13]},
          {"frame": 20, "focal_point": [51, 2, 3], "position": [51, 2, 13]}])");
  const double h = 10, t = 0.5;
  const double expected = 1 + 10 * (3 * t * t - 2 * t * t * t) +
                          h * ((t * t * t - 2 * t * t + t) * 1 + (t * t * t - t * t) * 1.6);
  EXPECT_NEAR(track.at(5).focal_point.x(), expected, 1e-11);
  const double behind = 11 + 40 * 0.5 + h * (0.125 * 1.6 - 0.125 * 4);
  EXPECT_NEAR(track.at(15).focal_point.x(), behind, 1e-11);
}

TEST(CameraPaths, ZoomStaysBetweenKeysAndNothingJumps) {
  const auto track = track_of(R"([{"frame": 0}, {"frame": 10, "zoom": 8, "azimuth": 10},
      {"frame": 11, "zoom": 8, "azimuth": 100}, {"frame": 40, "zoom": 1.01, "azimuth": 90},
      {"frame": 50, "position": [20, 30, 3], "roll": 40}])");
  constexpr int kSteps = 5000;
  Camera before = track.at(0);
  Vec3 speed_before = Vec3::Zero();
  for (int i = 1; i <= kSteps; ++i) {
    const double place = 50.0 * i / kSteps;
    const Camera now = track.at(place);
    if (place <= 10) {
      EXPECT_LE(now.view_angle, before.view_angle * (1 + kRounding)) << place;
    }
    if (place > 11 && place <= 40) {
      EXPECT_GE(now.view_angle, before.view_angle * (1 - kRounding)) << place;
    }
    EXPECT_LE(now.view_angle, 30 * (1 + kRounding)) << place;
    EXPECT_GE(now.view_angle, 3.75 * (1 - kRounding)) << place;
    // The steepest: 90 degrees within a frame, three times as fast in the middle at most.
    const Vec3 speed = now.position - before.position;
    EXPECT_LT(speed.norm(), 0.6) << place;
    if (i > 1) {
      EXPECT_LT((speed - speed_before).norm(), 0.03) << place;
    }
    speed_before = speed;
    before = now;
  }
}

// Azimuths turn about view_up, which need not be upright in the picture: beside a key they turn
// about the same axis as at it.
TEST(CameraPaths, AzimuthsTurnAboutTheSameAxisBetweenKeys) {
  Camera slanting = front();
  slanting.position = {1, -7, 8};
  slanting.view_up = {0, 0, 1};
  const CameraTrack track(
      CameraPath(R"([{"frame": 0}, {"frame": 4, "azimuth": 120}, {"frame": 6, "azimuth": 90}])",
                 "p"),
      slanting, {});
  for (double place = 0; place <= 4; place += 0.125)
    EXPECT_NEAR(track.at(place).position.z(), 8, 1e-11) << place;
  EXPECT_LT((track.at(4).position - track.at(4 - 1e-9).position).norm(), 1e-6);
  EXPECT_LT((track.at(4).view_up - track.at(4 + 1e-9).view_up).norm(), 1e-6);
}

TEST(CameraPaths, ParallelScaleIsZoomedToo) {
  const auto track = track_of(R"([{"frame": 0, "parallel_projection": true, "parallel_scale": 8},
                   {"frame": 2, "parallel_projection": true, "parallel_scale": 2, "zoom": 4}])");
  EXPECT_NEAR(track.at(1).parallel_scale, 2, kRounding);
  EXPECT_TRUE(track.at(1).parallel_projection);
}

TEST(CameraPaths, BadPathsAreTold) {
  const auto expect_told = [](const std::string& text, const std::string& message) {
    SCOPED_TRACE(text);
    try {
      track_of(text);
      ADD_FAILURE() << "is taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFileFormat);
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  };
  const std::string first = R"([{"frame": 0}, )";
  expect_told("{}", R"(p: is no camera path: expected a list, [{"frame": 0, ...}, ...])");
  expect_told("[", "p: not JSON at byte");
  expect_told("[]", "p: has no keys, expected two or more");
  expect_told(R"([{"frame": 3}])", "p: has one key, which does not move");
  expect_told(first + "7]", "p: [1]: must be an object");
  expect_told(first + R"({"frame": 0}])",
              "p: [1]: frame = 0: must be greater than the key's "
              "before, 0");
  expect_told(R"([{"time": 2}, {"time": 1}])", "p: [1]: time = 1: must be greater");
  expect_told(first + R"({"time": 1}])", "p: [1]: has a time, the keys before have frames");
  expect_told(first + R"({"frame": 1, "time": 1}])", "p: [1]: has frame and time");
  expect_told(first + R"({"zoom": 1}])", "p: [1]: has neither frame nor time");
  expect_told(R"([{"frame": -1}, {"frame": 1}])", "p: [0]: frame = -1: must be from 0 to 999999");
  expect_told(first + R"({"frame": 1e7}])", "p: [1]: frame = 10000000: must be from 0 to 999999");
  expect_told(first + R"({"frame": NaN}])", "p: not JSON at byte");
  expect_told(first + R"({"frame": 1e999}])", "p: holds a number that double cannot");
  expect_told(first + R"({"frame": "1"}])", "p: [1]: frame = \"1\": must be a number");
  expect_told(first + R"({"frame": 1, "zoom": 0}])", "p: [1]: zoom = 0: must be > 0");
  expect_told(first + R"({"frame": 1, "azimut": 5}])", "did you mean azimuth?");
  expect_told(first + R"({"frame": 1, "frame": 2}])", "p: 'frame' stands twice in one object");
  expect_told(first + R"({"frame": 1, "position": [1, 2]}])", "p: [1]: position");
  expect_told(first + R"({"frame": 1, "position": [1, 2, 3]}])",
              "p: [1]: camera position = (1, 2, 3): must differ");
  expect_told(first + R"({"frame": 1, "view_up": [0, 0, 1]}])", "p: [1]: camera view_up");
  expect_told(first + R"({"frame": 1, "zoom": 1e-9}])", "p: [1]: camera view_angle");
  expect_told(first + R"({"frame": 1, "parallel_projection": true}])",
              "p: [1]: parallel_projection: must be the same in all keys");
}

// The program's frames at keys are pictures by the keys' cameras.
TEST(CameraPaths, FilmsGoAlongThem) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const Words look = {"--size", "40x30", "--range", "0,255", "--background", "0,0,0"};
  const auto with = [&](Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), look.begin(), look.end());
    return words;
  };
  const std::string first =
      R"("position": [7.5, 7.5, 60], "focal_point": [7.5, 7.5, 7.5], "view_up": [0, 1, 0])";
  const std::string last =
      R"("position": [50, 9, 7.5], "focal_point": [7.5, 7.5, 7.5], "view_up": [0, 0, 1])";
  write_file(folder / "path.json",
             R"([{"frame": 0, )" + first + R"(}, {"frame": 3, )" + last + "}]");
  const auto drawn = [&](const Words& words) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  };
  drawn(
      with({"animate", ball, "-o", folder / "f%d.png", "--camera-path", folder / "path.json"}, {}));
  EXPECT_TRUE(std::filesystem::exists(folder / "f3.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "f4.png"));
  drawn(with({"render", ball, "-o", folder / "a.png", "--camera", "{" + first + "}"}, {}));
  drawn(with({"render", ball, "-o", folder / "b.png", "--camera", "{" + last + "}"}, {}));
  EXPECT_EQ(read_file(folder / "f0.png"), read_file(folder / "a.png"));
  EXPECT_EQ(read_file(folder / "f3.png"), read_file(folder / "b.png"));
  EXPECT_NE(read_file(folder / "f1.png"), read_file(folder / "f2.png"));
  // Another path: the same command draws anew.
  write_file(folder / "path.json",
             R"([{"frame": 0, )" + last + R"(}, {"frame": 3, )" + first + "}]");
  drawn(
      with({"animate", ball, "-o", folder / "f%d.png", "--camera-path", folder / "path.json"}, {}));
  EXPECT_EQ(read_file(folder / "f0.png"), read_file(folder / "b.png"));
}

TEST(CameraPaths, WhatTheProgramRefuses) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const auto animate = [&](const Words& more) {
    Words words = {"animate", ball, "-o", folder / "f%d.png", "--size", "16x12"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const std::string keys = R"([{"frame": 0}, {"frame": 2, "zoom": 2}])";
  expect_failure(animate({"--camera-path", keys, "--turn", "90"}), 2,
                 {"--camera-path", "contradicts --turn"});
  expect_failure(animate({"--camera-path", "[]"}), 2, {"--camera-path: has no keys"});
  expect_failure(animate({"--camera-path", folder / "none.json"}), 1,
                 {"none.json", "no such file"});
  write_file(folder / "bad.json", R"([{"frame": 1}, {"frame": 1}])");
  expect_failure(animate({"--camera-path", folder / "bad.json"}), 1, {"bad.json: [1]: frame = 1"});
  expect_failure(animate({"--camera-path", R"([{"time": 0}, {"time": 2}])"}), 1,
                 {"--camera-path: its keys are at times", "expected keys at frames"});
  write_file(folder / "f1.png", keys);
  expect_failure(animate({"--camera-path", folder / "f1.png"}), 2,
                 {"frame 1", "the keys of --camera-path"});
}

}  // namespace camera_path_test
}  // namespace ovoid::cli_tests
