// SPDX-License-Identifier: Apache-2.0
// For tests of readers and writers: small volumes, and what an error says.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"
#include "ovoid/error.h"

namespace ovoid::io {

// "code: message" of what `action` throws; "" if it throws nothing.
inline std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return std::string(name_of(error.code())) + ": " + error.what();
  }
  return {};
}

// `text` with the first `from`, which must be there, replaced.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
  const auto position = text.find(from);
  EXPECT_NE(position, std::string::npos) << from;
  return position == std::string::npos ? text : text.replace(position, from.size(), to);
}

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <typename T>
std::vector<T> values_of(const DataArray& array) {
  std::vector<T> values(array.bytes.view.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), array.bytes.view.data(), array.bytes.view.size());
  return values;
}

template <typename T>
std::vector<T> counting(std::size_t count) {
  std::vector<T> values(count);
  std::iota(values.begin(), values.end(), T{1});
  return values;
}

template <typename T>
DataArray make_array(std::string name, ScalarType type, const std::vector<T>& values,
                     int num_components = 1) {
  const auto owner = std::make_shared<std::vector<T>>(values);
  return {std::move(name),
          type,
          num_components,
          static_cast<std::int64_t>(values.size()) / num_components,
          "",
          false,
          Bytes{owner, std::as_bytes(std::span(*owner))}};
}

// Files that exist in memory only.
class MemoryFiles {
 public:
  std::map<std::string, std::string> files;

  std::unique_ptr<ByteSource> open(const std::string& path) const {
    const auto found = files.find(path);
    if (found == files.end()) throw Error(ErrorCode::kFileNotFound, path + ": no such file");
    return open_memory(path, std::as_bytes(std::span(found->second)));
  }
  Opener opener() const {
    return [this](const std::string& path) { return open(path); };
  }
};

}  // namespace ovoid::io
