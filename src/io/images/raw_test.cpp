// SPDX-License-Identifier: Apache-2.0
#include "io/images/raw.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fuzz/seeds.h"
#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace raw_test {

Dataset read(const std::string& name, const std::string& content, const ReadOptions& options = {}) {
  return read_raw(*open_memory(name, std::as_bytes(std::span(content))), options);
}

TEST(RawName, FollowsTheConventionOrSaysNothing) {
  const RawOptions options = parse_raw_name("scans_1x1x1/my_foot_256x128x3_uint16_le.raw");
  ASSERT_TRUE(options.dims && options.type);
  EXPECT_EQ(*options.dims, (Index3{256, 128, 3}));
  EXPECT_EQ(*options.type, ScalarType::kUInt16);
  // Each lacks one thing: a type, a third size, a positive size, a known type, a separator, digits
  // that fit.
  for (const char* name :
       {"a_4x4x4.raw", "a_4x4_uint8.raw", "a_4x0x4_uint8.raw", "a_4x4x4_bool.raw",
        "a_4x4x4uint8.raw", "a_99999999999999999999x1x1_uint8.raw", "a_4x4x4x4_uint8.raw", "", "_",
        "a_-4x4x4_uint8.raw"}) {
    EXPECT_FALSE(parse_raw_name(name).dims.has_value()) << name;
  }
}

TEST(Raw, ReadsWhatTheNameSays) {
  const auto values = counting<std::int16_t>(24);
  const Dataset dataset = read("a_4x3x2_int16.raw", bytes_of(values));
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(dataset.array().type, ScalarType::kInt16);
  EXPECT_EQ(dataset.array().num_tuples, 24);
  EXPECT_EQ(values_of<std::int16_t>(dataset.array()), values);
  EXPECT_TRUE(dataset.notes.empty());
}

TEST(Raw, OptionsBeatTheNameAndSayByteOrderAndSpacing) {
  ReadOptions options;
  options.raw.dims = Index3{1, 1, 2};
  options.raw.type = ScalarType::kUInt32;
  options.raw.spacing = Vec3(0.5, 2, 3);
  options.raw.big_endian = true;
  const Dataset dataset = read("a_8x1x1_uint8.raw", std::string("\0\0\1\2\3\4\5\6", 8), options);
  EXPECT_EQ(values_of<std::uint32_t>(dataset.array()),
            (std::vector<std::uint32_t>{0x102, 0x3040506}));
  EXPECT_EQ(dataset.lattice.spacing(), Vec3(0.5, 2, 3));
  EXPECT_EQ(dataset.notes.size(), 1U);
}

TEST(Raw, SizesMustAgreeExactly) {
  EXPECT_EQ(error_of([] { read("a_4x4x4_uint8.raw", std::string(63, 'x')); }),
            "file-format: a_4x4x4_uint8.raw: holds 63 bytes, 4x4x4 uint8 needs 64");
  EXPECT_EQ(error_of([] { read("a_4x4x4_uint8.raw", std::string(65, 'x')); }),
            "file-format: a_4x4x4_uint8.raw: holds 65 bytes, 4x4x4 uint8 needs 64");
}

TEST(Raw, ErrorsNameWhatIsMissingOrWrong) {
  EXPECT_EQ(error_of([] { read("a.raw", "x"); }),
            "invalid-argument: a.raw: a file without a header needs dimensions (--dims) and a type "
            "(--type), or a name like x_256x256x256_uint8.raw");
  ReadOptions options;
  options.raw.dims = Index3{1, 1, 1};
  EXPECT_NE(error_of([&] { read("a.raw", "x", options); }).find("needs a type"), std::string::npos);
  options.raw.type = ScalarType::kUInt8;
  options.raw.spacing = Vec3(1, 0, 1);
  EXPECT_NE(error_of([&] {
              read("a.raw", "x", options);
            }).find("spacing: the samples of axis y are 0 apart"),
            std::string::npos);
}

TEST(Raw, HugeDimensionsFailBeforeAnythingIsAllocated) {
  EXPECT_EQ(error_of([] { read("a_2147483647x2147483647x2147483647_float64.raw", "x"); }),
            "file-format: a_2147483647x2147483647x2147483647_float64.raw: "
            "2147483647x2147483647x2147483647 float64 is larger "
            "than any file");
  EXPECT_NE(error_of([] {
              read("a_100000x100000x100000_uint8.raw", "x");
            }).find("needs 1000000000000000"),
            std::string::npos);
}

TEST(Raw, StopsAndReportsProgress) {
  ReadOptions options;
  double last = 0;
  options.progress = [&](double fraction) { last = fraction; };
  read("a_4x4x4_uint8.raw", std::string(64, 'x'), options);
  EXPECT_EQ(last, 1.0);
  std::stop_source stop;
  stop.request_stop();
  options.stop = stop.get_token();
  EXPECT_EQ(error_of([&] { read("a_4x4x4_uint8.raw", std::string(64, 'x'), options); }),
            "cancelled: reading: stopped by the caller");
}

TEST(Raw, ReadsGzipByItsName) {
  const auto values = counting<std::uint8_t>(24);
  const std::string content = fuzz::gzip(bytes_of(values));
  const auto read = [&](const std::string& name, const std::string& bytes) {
    return read_raw(*open_memory(name, std::as_bytes(std::span(bytes))), {});
  };
  EXPECT_EQ(values_of<std::uint8_t>(read("a_4x3x2_uint8.raw.gz", content).array()), values);
  EXPECT_EQ(error_of([&] { read("a_4x3x1_uint8.raw.gz", content); }),
            "file-format: a_4x3x1_uint8.raw.gz: holds more than the 12 bytes that 4x3x1 uint8 "
            "needs");
  EXPECT_EQ(error_of([&] { read("a_4x3x3_uint8.raw.gz", content); }).substr(0, 66),
            "file-format: a_4x3x3_uint8.raw.gz: the gzip data end after 24 byte");
  // Samples that happen to begin like gzip data.
  EXPECT_EQ(values_of<char>(read("a_2x1x1_uint8.raw", "\x1f\x8b").array()).size(), 2U);
}

}  // namespace raw_test
}  // namespace ovoid::io
