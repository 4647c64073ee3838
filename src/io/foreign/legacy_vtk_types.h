// SPDX-License-Identifier: Apache-2.0
// The words that legacy VTK files have for types of numbers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "io/core/text_scanner.h"

namespace ovoid::io {

struct ValueType {
  std::int64_t size = 0;  // bytes when binary; 0 for bits
  NumberKind kind = NumberKind::kInteger;
};

// Words for text, which may stand in fields: "variant" for values of any type, one to a line.
inline bool is_legacy_text(const std::string& type) {
  return type == "string" || type == "utf8_string" || type == "variant";
}

// The types of numbers. "bit" has a size of its own.
inline std::optional<ValueType> find_legacy_type(const std::string& name) {
  constexpr auto kLong = static_cast<std::int64_t>(sizeof(long));  // as VTK reads it
  static const std::map<std::string, ValueType> kTypes{{"bit", {0}},
                                                       {"char", {1}},
                                                       {"signed_char", {1}},
                                                       {"unsigned_char", {1}},
                                                       {"short", {2}},
                                                       {"unsigned_short", {2}},
                                                       {"int", {4}},
                                                       {"unsigned_int", {4}},
                                                       {"long", {kLong}},
                                                       {"unsigned_long", {kLong}},
                                                       {"vtkidtype", {4}},
                                                       {"vtktypeint64", {8}},
                                                       {"vtktypeuint64", {8}},
                                                       {"float", {4, NumberKind::kReal}},
                                                       {"double", {8, NumberKind::kReal}}};
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) return std::nullopt;
  return found->second;
}

// One array as the file announces it.
struct LegacyArray {
  std::string what;  // for messages: "array 'v'"
  std::string type;
  std::int64_t num_tuples = 0;
  std::int64_t num_components = 1;
};

}  // namespace ovoid::io
