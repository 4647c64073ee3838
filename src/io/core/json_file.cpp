// SPDX-License-Identifier: Apache-2.0
#include "io/core/json_file.h"

#include <fmt/format.h>

#include "ovoid/error.h"

namespace ovoid::io {

Json parse_json(const std::string& text, const std::string& path) {
  const auto check_depth = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > kMaxJsonDepth) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: nested deeper than {} levels", path, kMaxJsonDepth));
    }
    return true;
  };
  try {
    return Json::parse(text, check_depth);
  } catch (const Json::parse_error& error) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: not JSON at byte {}", path, error.byte));
  } catch (const Json::exception&) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: holds a number that double cannot", path));
  }
}

JsonValue JsonValue::member(const std::string& key) const {
  const auto it = object().json_->find(key);
  if (it == json_->end())
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no member {}", place_, key));
  return {*it, fmt::format("{}{}{}", place_, place_.ends_with(' ') ? "" : ".", key)};
}

JsonValue JsonValue::element(std::size_t index) const {
  return {array().json_->at(index), fmt::format("{}[{}]", place_, index)};
}

double JsonValue::number() const {
  if (!json_->is_number()) refuse("must be a number");
  return json_->get<double>();
}

std::string JsonValue::string() const {
  if (!json_->is_string()) refuse("must be a string");
  return json_->get<std::string>();
}

bool JsonValue::boolean() const {
  if (json_->is_boolean()) return json_->get<bool>();
  if (!json_->is_number()) refuse("must be true or false");
  return json_->get<double>() != 0.0;
}

const JsonValue& JsonValue::object() const {
  if (!json_->is_object()) refuse("must be an object");
  return *this;
}

const JsonValue& JsonValue::array() const {
  if (!json_->is_array()) refuse("must be an array");
  return *this;
}

const JsonValue& JsonValue::array_of(std::size_t size) const {
  if (array().size() != size) refuse(fmt::format("must have {} elements", size));
  return *this;
}

void JsonValue::refuse(const std::string& expected) const {
  constexpr std::size_t kShown = 40;
  std::string value = json_->is_object() ? "{...}"
                      : json_->is_array() && json_->size() > 4
                          ? fmt::format("[{} elements]", json_->size())
                          : json_->dump(-1, ' ', true);
  if (value.size() > kShown) value = value.substr(0, kShown) + "...";
  throw Error(
      ErrorCode::kFileFormat,
      fmt::format("{}{}{}: {}", place_, place_.ends_with(' ') ? "" : " = ", value, expected));
}

}  // namespace ovoid::io
