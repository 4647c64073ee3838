// SPDX-License-Identifier: Apache-2.0
// What seeds are made of.
#pragma once

#include <bzlib.h>

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <string>

#include "io/core/test_deflate.h"

namespace ovoid::fuzz {

using io::deflated;

inline std::string gzip(const std::string& data) { return deflated(data, 15 + 16); }

inline std::string bzip2(const std::string& data) {
  std::string out(data.size() + 1000, '\0');
  auto size = static_cast<unsigned>(out.size());
  BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(data.data()),
                           static_cast<unsigned>(data.size()), 9, 0, 0);
  out.resize(size);
  return out;
}

// Bytes that vary and compress.
inline std::string samples(std::size_t count) {
  std::string result;
  for (std::size_t i = 0; i < count; ++i) result += static_cast<char>(i * i / 7 % 251);
  return result;
}

// A binary header, number by number, in either byte order.
class BinaryHeader {
 public:
  BinaryHeader(std::size_t size, bool is_big_endian)
      : bytes_(size, '\0'), is_swapped_(is_big_endian) {}

  template <typename T>
  BinaryHeader& put(std::size_t at, std::initializer_list<T> values) {
    for (const T value : values) {
      std::memcpy(bytes_.data() + at, &value, sizeof(T));
      char* const raw = bytes_.data() + at;
      if (is_swapped_) std::reverse(raw, raw + sizeof(T));
      at += sizeof(T);
    }
    return *this;
  }
  BinaryHeader& text(std::size_t at, const std::string& value) {
    std::memcpy(bytes_.data() + at, value.data(), value.size());
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  bool is_swapped_;  // the machines that run tests are little endian
};

}  // namespace ovoid::fuzz
