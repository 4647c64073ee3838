// SPDX-License-Identifier: Apache-2.0
// Camera files: one JSON object in VTK's words.
#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "io/core/atomic_file.h"
#include "io/core/json_file.h"
#include "io/core/text_file.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

using io::Json;
using io::JsonValue;
using OrderedJson = nlohmann::ordered_json;  // writes members in the order of the code

constexpr std::string_view kMembers[] = {
    "position", "focal_point", "view_up", "parallel_projection", "parallel_scale", "view_angle"};

Vec3 vector_from(const JsonValue& value) {
  value.array_of(3);
  return {value.element(0).number(), value.element(1).number(), value.element(2).number()};
}

OrderedJson json_of(const Vec3& v) { return OrderedJson::array({v.x(), v.y(), v.z()}); }

}  // namespace

Camera read_camera(const std::string& path) {
  return camera_from_text(io::read_text(path, io::kMaxJsonBytes), path);
}

Camera camera_from_text(const std::string& text, const std::string& source_name) {
  io::require_size(text.size(), io::kMaxJsonBytes, source_name);
  const Json json = io::parse_json(text, source_name);
  const JsonValue root(json, source_name + ": ");
  // A misspelt member would silently give another picture.
  for (const auto& item : root.object().json().items()) {
    if (std::find(std::begin(kMembers), std::end(kMembers), item.key()) == std::end(kMembers)) {
      root.member(item.key())
          .refuse(fmt::format("unknown; a camera has {}", fmt::join(kMembers, " ")));
    }
  }
  Camera camera;
  if (root.has("position")) camera.position = vector_from(root.member("position"));
  if (root.has("focal_point")) camera.focal_point = vector_from(root.member("focal_point"));
  if (root.has("view_up")) camera.view_up = vector_from(root.member("view_up"));
  if (root.has("parallel_projection"))
    camera.parallel_projection = root.member("parallel_projection").boolean();
  if (root.has("parallel_scale")) camera.parallel_scale = root.member("parallel_scale").number();
  if (root.has("view_angle")) camera.view_angle = root.member("view_angle").number();
  try {
    camera.validate();
  } catch (const Error& error) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source_name, error.what()));
  }
  return camera;
}

std::string to_text(const Camera& camera) {
  camera.validate();
  OrderedJson json;
  json["position"] = json_of(camera.position);
  json["focal_point"] = json_of(camera.focal_point);
  json["view_up"] = json_of(camera.view_up);
  json["parallel_projection"] = camera.parallel_projection;
  json["parallel_scale"] = camera.parallel_scale;
  json["view_angle"] = camera.view_angle;
  return json.dump(1) + "\n";
}

void write_camera(const Camera& camera, const std::string& path) {
  io::write_atomically(path, to_text(camera));
}

}  // namespace ovoid
