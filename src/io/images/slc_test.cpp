// SPDX-License-Identifier: Apache-2.0
#include "io/images/slc.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fuzz/seeds.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"

namespace ovoid::io {
namespace slc_test {

using Bytes8 = std::vector<std::uint8_t>;

Dataset read_slc_text(const std::string& content) {
  return read_source(*open_memory("a.slc", std::as_bytes(std::span(content))), {});
}

std::string slc_error(const std::string& content) {
  return error_of([&] { read_slc_text(content); });
}

const std::string kStart = "11111\n4 1 2\n8\n1.5 2 0.5\n1 2 3\n";
const std::string kIcon = "2 1 Xiiiiii";

TEST(Slc, ReadsPlainSamples) {
  const Dataset dataset = read_slc_text(kStart + "0\n" + kIcon + "abcdefgh");
  EXPECT_EQ(dataset.format, "SLC");
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 1, 2}));
  EXPECT_EQ(dataset.lattice.spacing(), Vec3(1.5, 2, 0.5));
  EXPECT_EQ(dataset.space, Space::kNone);
  EXPECT_EQ(values_of<char>(dataset.array()),
            (std::vector<char>{'a', 'b', 'c', 'd', 'e', 'f', 'g', 'h'}));
}

// Fails if literal and repeated runs are mixed up, or a slice does not begin where its size says.
TEST(Slc, ReadsRunLengths) {
  const std::string first("\x03\x07\x81\x09\0", 5);     // 7 7 7 9
  const std::string second("\x84\x01\x02\x03\x04", 5);  // as they stand, with no end
  const std::string content = kStart + "1\n0 0 X" + "5 X" + first + "\n5X" + second;
  EXPECT_EQ(values_of<std::uint8_t>(read_slc_text(content).array()),
            (Bytes8{7, 7, 7, 9, 1, 2, 3, 4}));
  EXPECT_EQ(slc_error(with(content, "\x03\x07", "\x02\x07")),
            "file-format: a.slc: slice 0: has 3 of its 4 samples");
  EXPECT_EQ(slc_error(with(content, "\x03\x07", "\x04\x07")),
            "file-format: a.slc: slice 0: has more than its 4 samples");
  EXPECT_EQ(slc_error(content.substr(0, content.size() - 1)),
            "file-format: a.slc: slice 1: has 5 bytes, 4 are left: is the file truncated?");
  EXPECT_EQ(slc_error(with(content, "\n5X", "\n4X")),
            "file-format: a.slc: slice 1: ends within a run");
}

TEST(Slc, ErrorsNameTheField) {
  const std::string content = kStart + "0\n" + kIcon + "abcdefgh";
  EXPECT_EQ(slc_error(with(content, "4 1 2", "4 -1 2")),
            "file-format: a.slc: samples along y: '-1': expected 1 to 2147483647");
  EXPECT_EQ(slc_error(with(content, "\n8\n", "\n16\n")),
            "unsupported: a.slc: has 16 bits per sample: expected 8");
  EXPECT_EQ(slc_error(with(content, "\n0\n", "\n2\n")),
            "unsupported: a.slc: compression 2: expected 0, none, or 1, run lengths");
  EXPECT_EQ(slc_error(with(content, "1.5", "0")).substr(0, 60),
            "file-format: a.slc: spacing: the samples of axis x are 0 apa");
  EXPECT_EQ(slc_error(with(content, "4 1 2", "400 1 2")),
            "file-format: a.slc: 8 bytes hold at most 8 samples, 400x1x2 needs 800: is the file "
            "truncated?");
  EXPECT_EQ(slc_error(with(content, "2 1 X", "2000 1000 X")),
            "file-format: a.slc: an icon of 2000 x 1000 pixels does not fit the file: is it "
            "truncated?");
  // A table of numbers is none.
  EXPECT_EQ(slc_error("11111 1 2 3\n4 5 6 7\n"),
            "file-format: a.slc: the name ends in .slc but the content does not begin like it");
}

}  // namespace slc_test
}  // namespace ovoid::io
