// SPDX-License-Identifier: Apache-2.0
#include "io/core/lzf.h"

#include <gtest/gtest.h>

#include <random>
#include <span>
#include <string>

namespace ovoid::io {
namespace lzf_test {

using namespace std::string_literals;

// "?" for what is refused.
std::string unpacked(const std::string& packed) {
  const auto bytes = std::as_bytes(std::span(packed));
  const auto size = lzf_size(bytes);
  if (!size) return "?";
  std::string out(*size, '-');
  unpack_lzf(bytes, std::as_writable_bytes(std::span(out)));
  return out;
}

TEST(Lzf, RunsAndCopies) {
  EXPECT_EQ(unpacked(""), "");
  EXPECT_EQ(unpacked("\x02"
                     "abc"s),
            "abc");
  EXPECT_EQ(unpacked(std::string(1, 31) + std::string(32, 'x')), std::string(32, 'x'));
  EXPECT_EQ(unpacked("\x02"
                     "abc\x20\x02"s),
            "abcabc")
      << "three bytes, three back";
  EXPECT_EQ(unpacked("\x00"
                     "a\xe0\xff\x00"s),
            std::string(265, 'a'))
      << "into itself, the longest";
  EXPECT_EQ(unpacked("\x01"
                     "ab\xe0\x00\x01"s),
            "abababababa");
  std::string packed =
      "\x02"
      "abc"s;
  for (int i = 0; i < 255; ++i) packed += std::string(1, 31) + std::string(32, 'x');
  // The farthest that this output reaches back: all of its 8163 bytes, 31 * 256 + 0xe2 + 1.
  EXPECT_EQ(unpacked(packed + "\x3f\xe2"s).substr(8163), "abc");
}

TEST(Lzf, WhatEndsEarlyOrLeadsOutIsRefused) {
  EXPECT_EQ(unpacked("\x02"
                     "ab"s),
            "?");
  EXPECT_EQ(unpacked("\x00"s), "?");
  EXPECT_EQ(unpacked("\x00"
                     "a\x20"s),
            "?");
  EXPECT_EQ(unpacked("\x00"
                     "a\xe0\x00"s),
            "?");
  EXPECT_EQ(unpacked("\x00"
                     "a\x20\x01"s),
            "?")
      << "two back, where one is";
  EXPECT_EQ(unpacked("\x20\x00"s), "?");
}

// Fails under a sanitizer if anything outside is touched, and if the ratio is exceeded.
TEST(Lzf, AnyBytesAreSafe) {
  std::mt19937 random(20261129);
  int num_read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string packed(random() % 40, '\0');
    for (char& c : packed) c = static_cast<char>(random() % 3 == 0 ? random() % 4 : random());
    const std::string out = unpacked(packed);
    EXPECT_LE(out.size(), packed.size() * kMaxLzfRatio + 1);
    num_read += out != "?" ? 1 : 0;
  }
  EXPECT_GT(num_read, 100);
}

}  // namespace lzf_test
}  // namespace ovoid::io
