// SPDX-License-Identifier: Apache-2.0
//
// Between two keys numbers follow a cubic whose slopes at the keys are the weighted harmonic means
// of the slopes on both sides, or 0 where these differ in sign [Fritsch 1984]: no number leaves the
// range of the two keys, and none jumps in speed. Orientations do the same as rotation vectors, by
// a product of three turns that is such a cubic on the sphere [Kim 1995].
#include "camera_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "animation_plan.h"
#include "checked_json.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "suggest.h"
#include "values.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxPathBytes = std::size_t{16} << 20;
constexpr std::array kCameraMembers = {"position",       "focal_point", "view_up",
                                       "parallel_scale", "view_angle",  "parallel_projection"};

[[noreturn]] void refuse_path(const std::string& message) {
  throw Error(ErrorCode::kFileFormat, message);
}

// One key, and where it stands: "path.json: [2]".
class KeyReader {
 public:
  KeyReader(const Json& json, std::string place) : json_(json), place_(std::move(place)) {
    if (!json_.is_object()) refuse_path(place_ + ": must be an object");
    check_words();
  }

  bool has(const char* word) const { return json_.contains(word); }

  double number(const char* word) const {
    const Json& value = json_[word];
    if (!value.is_number())
      refuse_path(fmt::format("{}: {} = {}: must be a number", place_, word,
                              cut_line(value.dump(-1, ' ', true, Json::error_handler_t::replace))));
    return value.get<double>();
  }

  CameraPath::Turns turns() const {
    CameraPath::Turns turns;
    if (has("azimuth")) turns.azimuth = number("azimuth");
    if (has("elevation")) turns.elevation = number("elevation");
    if (has("roll")) turns.roll = number("roll");
    if (has("zoom")) turns.zoom = number("zoom");
    if (!(turns.zoom > 0))
      refuse_path(fmt::format("{}: zoom = {}: must be > 0", place_, turns.zoom));
    return turns;
  }

  Json camera_members() const {
    Json members = Json::object();
    for (const char* const word : kCameraMembers) {
      if (has(word)) members[word] = json_[word];
    }
    return members;
  }

  // Where the key stands, at one of both words.
  bool is_timed() const {
    if (has("frame") == has("time"))
      refuse_path(fmt::format("{}: {}, expected one of them", place_,
                              has("time") ? "has frame and time" : "has neither frame nor time"));
    return has("time");
  }

  [[noreturn]] void refuse(const std::string& message) const {
    refuse_path(place_ + ": " + message);
  }

 private:
  void check_words() const {
    std::vector<std::string> known = {"frame", "time", "azimuth", "elevation", "roll", "zoom"};
    known.insert(known.end(), kCameraMembers.begin(), kCameraMembers.end());
    for (const auto& [word, value] : json_.items()) {
      if (std::find(known.begin(), known.end(), word) != known.end()) continue;
      refuse_path(fmt::format("{}: {}: unknown; a key has {}{}", place_, cut_line(word),
                              fmt::join(known, " "), did_you_mean(word, known)));
    }
  }

  const Json& json_;
  std::string place_;
};

std::string key_name(const std::string& source, std::size_t index) {
  return fmt::format("{}: [{}]", source, index);
}

void check_place(const KeyReader& reader, double place, bool is_timed,
                 const CameraPath::Key* before) {
  const char* const word = is_timed ? "time" : "frame";
  constexpr auto kMost = static_cast<double>(AnimationFlags::kMaxFrames - 1);
  if (!is_timed && !(place >= 0 && place <= kMost))
    reader.refuse(fmt::format("frame = {}: must be from 0 to {}", place, kMost));
  if (before != nullptr && !(place > before->place))
    reader.refuse(fmt::format("{} = {}: must be greater than the key's before, {}", word, place,
                              before->place));
}

// The slope at a place between two stretches of lengths h with the slopes d: of one number, or of
// each component.
double slope_at(double h0, double d0, double h1, double d1) {
  if (!(d0 * d1 > 0)) return 0;
  const double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / d0 + w1 / d1);
}

// Of the numbers' slopes at one key: `change(i)` is what one does from key i to the next.
template <class Change>
double key_slope(const std::vector<double>& lengths, std::size_t key, const Change& change) {
  const auto slope = [&](std::size_t i) { return change(i) / lengths[i]; };
  if (key == 0) return slope(0);
  if (key == lengths.size()) return slope(key - 1);
  return slope_at(lengths[key - 1], slope(key - 1), lengths[key], slope(key));
}

// The rotation as its axis times its angle, the shorter way around.
Vec3 vector_of(const Eigen::Quaterniond& rotation) {
  Eigen::Quaterniond q = rotation;
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-300) return Vec3::Zero();
  return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

Eigen::Quaterniond rotation_of(const Vec3& vector) {
  const double angle = vector.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle));
}

Eigen::Quaterniond orientation_of(const Camera& camera) {
  Mat3 axes;
  axes.col(2) = (camera.position - camera.focal_point).normalized();
  axes.col(0) = camera.view_up.cross(axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return Eigen::Quaterniond(axes).normalized();
}

}  // namespace

CameraPath::CameraPath(const std::string& text, const std::string& source) : source_(source) {
  const Json list = checked_json(text, source);
  if (!list.is_array())
    refuse_path(source + R"(: is no camera path: expected a list, [{"frame": 0, ...}, ...])");
  if (list.size() < 2)
    refuse_path(fmt::format("{}: {}, expected two or more", source,
                            list.empty() ? "has no keys" : "has one key, which does not move"));
  keys_.reserve(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    const KeyReader reader(list[i], key_name(source, i));
    const bool is_timed = reader.is_timed();
    if (i == 0) is_timed_ = is_timed;
    if (is_timed != is_timed_)
      reader.refuse(fmt::format("has a {}, the keys before have {}s: expected one of both in all",
                                is_timed ? "time" : "frame", is_timed_ ? "time" : "frame"));
    const double place = reader.number(is_timed ? "time" : "frame");
    check_place(reader, place, is_timed, keys_.empty() ? nullptr : &keys_.back());
    keys_.push_back({place, reader.camera_members(), reader.turns()});
  }
}

CameraPath CameraPath::of_flag(const std::string& value) {
  if (is_json(value)) return {value, "--camera-path"};
  return {read_text_file(value, kMaxPathBytes), value};
}

std::int64_t CameraPath::num_frames() const {
  return static_cast<std::int64_t>(std::ceil(keys_.back().place)) + 1;
}

CameraTrack::CameraTrack(const CameraPath& path, const Camera& unturned, const CameraFlags& flags)
    : added_{flags.azimuth, flags.elevation, flags.roll, flags.zoom} {
  const Json own = Json::parse(to_text(unturned));
  for (std::size_t i = 0; i < path.keys().size(); ++i) {
    const CameraPath::Key& key = path.keys()[i];
    const std::string name = key_name(path.source(), i);
    Pose pose{key.place, unturned, key.turns, {}, Eigen::Quaterniond::Identity()};
    if (!key.members.empty()) {
      Json whole = own;
      whole.update(key.members);
      pose.camera = camera_from_text(whole.dump(), name);
    }
    try {
      turned(pose.camera, pose.turns).validate();
    } catch (const Error& error) {
      refuse_path(fmt::format("{}: {}", name, error.what()));
    }
    const Camera& camera = pose.camera;
    if (!poses_.empty() && camera.parallel_projection != poses_.front().camera.parallel_projection)
      refuse_path(name + ": parallel_projection: must be the same in all keys");
    const Vec3& focal = camera.focal_point;
    pose.numbers = {focal[0],
                    focal[1],
                    focal[2],
                    std::log((camera.position - focal).norm()),
                    std::log(camera.parallel_scale),
                    std::log(camera.view_angle),
                    std::log(key.turns.zoom),
                    key.turns.azimuth,
                    key.turns.elevation,
                    key.turns.roll,
                    0};
    pose.orientation = orientation_of(camera);
    const Vec3 up = pose.orientation.conjugate() * camera.view_up;
    pose.numbers.back() = std::atan2(up[2], up[1]);
    poses_.push_back(std::move(pose));
  }
}

Camera CameraTrack::turned(Camera camera, const CameraPath::Turns& turns) const {
  camera.azimuth(added_.azimuth + turns.azimuth);
  camera.elevation(added_.elevation + turns.elevation);
  camera.roll(added_.roll + turns.roll);
  camera.zoom(added_.zoom * turns.zoom);
  return camera;
}

Camera CameraTrack::at(double place) const {
  const auto next =
      std::upper_bound(poses_.begin(), poses_.end(), place,
                       [](double value, const Pose& pose) { return value < pose.place; });
  const auto index = static_cast<std::size_t>(next - poses_.begin());
  const Pose& before = poses_[index == 0 ? 0 : index - 1];
  if (index == 0 || index == poses_.size() || place == before.place)
    return turned(before.camera, before.turns);
  Camera camera = between(index - 1, place);
  camera.validate();
  return camera;
}

// Looks at no more than the keys around the two: a film of many keys costs what one of few does.
Camera CameraTrack::between(std::size_t index, double place) const {
  const std::size_t first = index == 0 ? 0 : index - 1;
  const std::size_t last = std::min(index + 2, poses_.size() - 1);
  std::vector<double> lengths;
  std::vector<Vec3> turns;  // from key to key
  for (std::size_t i = first; i < last; ++i) {
    lengths.push_back(poses_[i + 1].place - poses_[i].place);
    turns.push_back(vector_of(poses_[i].orientation.conjugate() * poses_[i + 1].orientation));
  }
  const std::size_t here = index - first;
  const double h = lengths[here];
  const double t = (place - poses_[index].place) / h;
  const double t2 = t * t, t3 = t2 * t;
  const double rise = 3 * t2 - 2 * t3, out = t3 - 2 * t2 + t, in = t3 - t2;

  Numbers now;
  for (std::size_t n = 0; n < kNumbers; ++n) {
    const auto change = [&](std::size_t i) {
      return poses_[first + i + 1].numbers[n] - poses_[first + i].numbers[n];
    };
    now[n] =
        poses_[index].numbers[n] + rise * change(here) +
        h * (out * key_slope(lengths, here, change) + in * key_slope(lengths, here + 1, change));
  }
  const auto slopes = [&](std::size_t key) -> Vec3 {
    Vec3 slope;
    for (int a = 0; a < 3; ++a)
      slope[a] = key_slope(lengths, key, [&](std::size_t i) { return turns[i][a]; });
    return slope;
  };
  const Vec3 leaving = slopes(here) * h / 3, arriving = slopes(here + 1) * h / 3;
  const Vec3 rest =
      vector_of(rotation_of(-leaving) * rotation_of(turns[here]) * rotation_of(-arriving));
  const Eigen::Quaterniond orientation = poses_[index].orientation *
                                         rotation_of(leaving * (1 - (1 - t) * (1 - t) * (1 - t))) *
                                         rotation_of(rest * rise) * rotation_of(arriving * t3);

  Camera camera = poses_[index].camera;
  camera.focal_point = {now[0], now[1], now[2]};
  camera.position = camera.focal_point + std::exp(now[3]) * (orientation * Vec3::UnitZ());
  camera.view_up = orientation * Vec3(0, std::cos(now[10]), std::sin(now[10]));
  camera.parallel_scale = std::exp(now[4]);
  camera.view_angle = std::exp(now[5]);
  return turned(camera, {now[7], now[8], now[9], std::exp(now[6])});
}

}  // namespace ovoid::cli
