// SPDX-License-Identifier: Apache-2.0
// Small JSON files (looks, cameras): read with limits, and taken apart with errors that name file,
// place and expectation.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

namespace ovoid::io {

using Json = nlohmann::json;

inline constexpr std::size_t kMaxJsonBytes = std::size_t{16}
                                             << 20;  // parsed it takes up to ten times that
inline constexpr int kMaxJsonDepth = 64;

// The parsed content of text that was read from `path`, at most kMaxJsonBytes of it. Throws
// Error(kFileFormat) for what is nested deeper or not JSON.
Json parse_json(const std::string& text, const std::string& path);

// A value inside a JSON file and the way to it, "looks.json: [2].Points[7]".
class JsonValue {
 public:
  JsonValue(const Json& json, std::string place) : json_(&json), place_(std::move(place)) {}

  const Json& json() const noexcept { return *json_; }
  const std::string& place() const noexcept { return place_; }
  bool has(const char* key) const { return json_->contains(key); }
  std::size_t size() const noexcept { return json_->size(); }

  // The member or element, which must exist.
  JsonValue member(const std::string& key) const;
  JsonValue element(std::size_t index) const;

  // What this value is. Throws Error(kFileFormat) if it is something else. Numbers are finite: JSON
  // has no others.
  double number() const;
  std::string string() const;
  bool boolean() const;  // true, false, or a number: zero or not, as ParaView writes them
  const JsonValue& object() const;
  const JsonValue& array() const;
  const JsonValue& array_of(std::size_t size) const;

  // Throws Error(kFileFormat): "<place> = <value>: <expected>", the value cut to one short line.
  [[noreturn]] void refuse(const std::string& expected) const;

 private:
  const Json* json_;
  std::string place_;
};

}  // namespace ovoid::io
