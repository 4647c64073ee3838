// SPDX-License-Identifier: Apache-2.0
// Text with the line ends of Unix, Windows, old Macs and all of them mixed must read alike, in
// every reader of text. Fails if a reader knows some line ends only.
#include "io/core/line_ends.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fuzz/seeds.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"
#include "io/step_times.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace line_ends_test {

// Every '\n' of the text as `ends` have it, in turn.
std::string with_ends(const std::string& text, const std::vector<std::string>& ends) {
  std::string result;
  std::size_t line = 0;
  for (const char c : text) result += c == '\n' ? ends[line++ % ends.size()] : std::string(1, c);
  return result;
}

const std::vector<std::vector<std::string>> kEnds = {
    {"\n"}, {"\r\n"}, {"\r"}, {"\n", "\r\n", "\r", "\r"}};

std::string shown(const std::vector<std::string>& ends) {
  return ends.size() > 1 ? "mixed" : ends[0] == "\n" ? "Unix" : ends[0] == "\r" ? "Mac" : "Windows";
}

Dataset read_bytes(const std::string& name, const std::string& bytes) {
  return read_source(*open_memory(name, std::as_bytes(std::span(bytes))), {});
}

TEST(LineEnds, PiecesAreCutAnywhere) {
  const std::string text = "a\r\nb\rc\n\r\r\n\n\rd\r";
  std::string whole = text;
  unify_line_ends(whole);
  EXPECT_EQ(whole, "a\nb\nc\n\n\n\n\nd\n");
  for (std::size_t size = 1; size < text.size(); ++size) {
    LineEnds ends;
    std::string result;
    for (std::size_t at = 0; at < text.size(); at += size) {
      std::string piece = text.substr(at, size);
      result += piece.substr(0, ends.unify(piece));
    }
    EXPECT_EQ(result, whole) << "pieces of " << size;
  }
}

TEST(LineEnds, TablesOfParticles) {
  std::string text = "x,y,z,v\n# a comment\n\n";
  std::vector<double> expected;
  for (int i = 0; i < 100000; ++i) {  // longer than is read at a time
    text += std::to_string(i) + ",1,2," + std::to_string(i % 7) + "\n";
    expected.insert(expected.end(), {static_cast<double>(i), 1, 2});
  }
  for (const auto& ends : kEnds) {
    for (const bool is_packed : {false, true}) {
      const std::string bytes = with_ends(text, ends);
      const Dataset dataset = read_bytes("a.csv", is_packed ? fuzz::gzip(bytes) : bytes);
      EXPECT_EQ(values_of<double>(dataset.positions), expected) << shown(ends);
      ASSERT_EQ(dataset.arrays.size(), 1U);
      EXPECT_EQ(dataset.array().name, "v") << shown(ends);
      EXPECT_EQ(values_of<double>(dataset.array())[6], 6) << shown(ends);
    }
  }
}

TEST(LineEnds, ErrorsCountTheLines) {
  for (const auto& ends : kEnds) {
    EXPECT_EQ(error_of([&] { read_bytes("a.csv", with_ends("x,y,z\n1,2,3\n4,5\n", ends)); }),
              "file-format: a.csv: line 3: has 2 fields: expected 3")
        << shown(ends);
  }
}

TEST(LineEnds, LammpsDumps) {
  const std::string text =
      "ITEM: TIMESTEP\n25\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 10\n0 20\n-1 1\n"
      "ITEM: ATOMS id x y z v\n1 1 2 3 5\n2 4 5 6 7\n";
  for (const auto& ends : kEnds) {
    const std::string bytes = with_ends(text, ends);
    const Dataset dataset = read_bytes("a.dump", bytes);
    EXPECT_EQ(values_of<double>(dataset.positions), (std::vector<double>{1, 2, 3, 4, 5, 6}))
        << shown(ends);
    EXPECT_EQ(dataset.times, (std::vector<double>{25})) << shown(ends);
    EXPECT_EQ(named_time(*open_memory("a.dump", std::as_bytes(std::span(bytes)))), 25)
        << shown(ends);
  }
}

// The samples begin with the bytes that end lines, which belong to them.
TEST(LineEnds, HeadersBeforeSamples) {
  const std::string samples = "\n\r\n\r\r\nabcdefghijklmnopqr";
  const std::string headers[] = {
      "NRRD0004\n# a comment\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n\n",
      "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\n"
      "ElementDataFile = LOCAL\n"};
  for (const std::string& header : headers) {
    for (const auto& ends : kEnds) {
      std::string bytes = with_ends(header, ends);
      // What stands behind a mixed header's last \r, if it were one, would be anyone's guess.
      if (ends.size() > 1)
        bytes = bytes.substr(0, bytes.find_last_not_of("\r\n") + 1) +
                (header.ends_with("\n\n") ? "\n\n" : "\n");
      const Dataset dataset = read_bytes("a.bin", bytes + samples);
      EXPECT_EQ(bytes_of(values_of<std::uint8_t>(dataset.array())), samples)
          << header.substr(0, 4) << " " << shown(ends);
      EXPECT_TRUE(dataset.notes.empty()) << dataset.notes[0];
    }
  }
}

TEST(LineEnds, Ply) {
  const std::string text =
      "ply\nformat ascii 1.0\ncomment hello\nelement vertex 2\nproperty float x\nproperty float "
      "y\nproperty float z\nend_header\n1 2 3\n4 5 6\n";
  for (const auto& ends : kEnds) {
    EXPECT_EQ(values_of<float>(read_bytes("a.ply", with_ends(text, ends)).positions),
              (std::vector<float>{1, 2, 3, 4, 5, 6}))
        << shown(ends);
  }
}

TEST(LineEnds, LooksOfNumbers) {
  for (const auto& ends : kEnds) {
    const Look look =
        look_from_text(with_ends("# value opacity\n0 0\n1 0.5\n4 1\n", ends), "a.txt");
    ASSERT_EQ(look.transfer_function.opacities.size(), 3U) << shown(ends);
    EXPECT_EQ(look.transfer_function.opacities[1].opacity, 0.5) << shown(ends);
    EXPECT_EQ(error_of([&] {
                look_from_text(with_ends("0 0\n1 0.5\nx 1\n", ends), "a.txt");
              }).substr(0, 27),
              "file-format: a.txt: line 3:")
        << shown(ends);
  }
}

}  // namespace line_ends_test
}  // namespace ovoid::io
