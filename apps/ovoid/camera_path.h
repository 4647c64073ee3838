// SPDX-License-Identifier: Apache-2.0
// A camera that moves in a film: keys, each of which is a whole camera at a frame or at a time, and
// what lies between them. docs/time.md, "Camera paths", is the definition.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ovoid/camera.h"
#include "settings.h"

namespace ovoid::cli {

// What a file says, before the film's own camera is known.
class CameraPath {
 public:
  // A key's turns about the camera that its members make: as the flags of these names.
  struct Turns {
    double azimuth = 0, elevation = 0, roll = 0;  // degrees
    double zoom = 1;                              // > 0
  };
  struct Key {
    double place = 0;                // a frame's number, or a time
    nlohmann::ordered_json members;  // of a camera file, those that are there; an object
    Turns turns;
  };

  // `source` stands for the text in messages. Throws Error(kFileFormat), which names the key.
  CameraPath(const std::string& text, const std::string& source);

  // Of the value of --camera-path: JSON itself, or a file's name. Throws Error as read_text_file().
  static CameraPath of_flag(const std::string& value);

  bool is_timed() const noexcept { return is_timed_; }             // keys at times, else at frames
  const std::vector<Key>& keys() const noexcept { return keys_; }  // two or more, places rise
  std::int64_t num_frames() const;  // of keys at frames: up to the last one's
  const std::string& source() const noexcept { return source_; }

 private:
  std::string source_;
  bool is_timed_ = false;
  std::vector<Key> keys_;
};

// A path for one film. Immutable.
class CameraTrack {
 public:
  // `unturned`: the film's camera before flags turn and zoom it, of which a key has what it does
  // not say. `flags`: turns that all keys have beside their own. Throws Error(kFileFormat) for keys
  // that are no cameras with it, or of both projections.
  CameraTrack(const CameraPath& path, const Camera& unturned, const CameraFlags& flags);

  // At a key's place the key's camera, to the bit; before the first and behind the last key
  // theirs. Throws Error(kInvalidArgument) where what lies between two keys is no camera, because
  // numbers are too large. Cost: that of some dozen logarithms and sines.
  Camera at(double place) const;

 private:
  // What is interpolated one by one: the focal point (3), logarithms of distance, parallel scale,
  // view angle and zoom, azimuth, elevation, roll, and how far view_up, about which azimuths turn,
  // leans from the picture's own up towards the eye.
  static constexpr std::size_t kNumbers = 11;
  using Numbers = std::array<double, kNumbers>;
  struct Pose {
    double place = 0;
    Camera camera;  // before its turns
    CameraPath::Turns turns;
    Numbers numbers{};
    Eigen::Quaterniond orientation;  // world from right, up and back
  };

  Camera turned(Camera camera, const CameraPath::Turns& turns) const;
  Camera between(std::size_t index, double place) const;

  std::vector<Pose> poses_;
  CameraPath::Turns added_;  // by the flags
};

}  // namespace ovoid::cli
