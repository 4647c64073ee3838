// SPDX-License-Identifier: Apache-2.0
// What a header of OpenVDB says, and what it must not: sizes and places that the file does not
// have.
#include "io/vdb/vdb_header.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>
#include <string>

#include "fuzz/seeds.h"
#include "io/core/byte_source.h"
#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace vdb_header_test {

using testing::HasSubstr;

VdbHeader vdb_header_of(const std::string& file) {
  return read_vdb_header(*open_memory("a.vdb", std::as_bytes(std::span(file))));
}
std::string vdb_header_error(const std::string& file) {
  return error_of([&] { vdb_header_of(file); });
}

class VdbHeaders : public testing::Test {
 protected:
  // The file with one byte changed, `behind` bytes after the first place that has these words.
  std::string with_byte(const std::string& words, std::size_t behind, char byte) const {
    std::string file = seed;
    const std::size_t at = file.find(words);
    EXPECT_NE(at, std::string::npos);
    file[at + behind] = byte;
    return file;
  }

  std::string seed = fuzz::vdb_header_seeds()[0];
};

TEST_F(VdbHeaders, ListGrids) {
  const VdbHeader header = vdb_header_of(seed);
  EXPECT_EQ(header.version, 224U);
  ASSERT_EQ(header.grids.size(), 2U);
  EXPECT_EQ(header.grids[0].name, "density");
  EXPECT_EQ(header.grids[0].type, "Tree_float_5_4_3");
  EXPECT_EQ(header.grids[1].name, "a[1]");
  EXPECT_FALSE(vdb_header_of(fuzz::vdb_header_seeds()[1]).has_offsets);
}

TEST_F(VdbHeaders, ThatEndTooSoonAreErrors) {
  for (std::size_t size = 0; size < seed.size(); ++size)
    EXPECT_THAT(vdb_header_error(seed.substr(0, size)), HasSubstr("is the file truncated?"))
        << size;
}

TEST_F(VdbHeaders, OldVersionsAreRefused) {
  EXPECT_THAT(vdb_header_error(with_byte(" BDV", 8, static_cast<char>(221))),
              HasSubstr("unsupported: a.vdb: has version 221"));
}

TEST_F(VdbHeaders, SizesAndPlacesThatAreNotThereAreErrors) {
  EXPECT_THAT(vdb_header_error(with_byte("Tree", static_cast<std::size_t>(-1), 0x7f)),
              HasSubstr("at most 65536 are read"));
  EXPECT_THAT(vdb_header_error(with_byte("creator", 7 + 4 + 6 + 3, 0x10)),
              HasSubstr("ends within the metadata of the file, 'creator'"));
  // The three offsets of the first grid stand behind its type, and a name of no bytes.
  const std::size_t offsets = 16 + 4;
  EXPECT_THAT(vdb_header_error(with_byte("Tree", offsets + 7, 0x10)),
              HasSubstr("grid 'density' says that it lies from byte"));
  EXPECT_THAT(vdb_header_error(with_byte("Tree", offsets + 16 + 2, 0x10)),
              HasSubstr("grid 'density' ends at byte"));
  EXPECT_THAT(vdb_header_error(with_byte("Tree", offsets, 0)), HasSubstr("is the file damaged?"));
}

}  // namespace vdb_header_test
}  // namespace ovoid::io
