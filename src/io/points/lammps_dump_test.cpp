// SPDX-License-Identifier: Apache-2.0
#include "io/points/lammps_dump.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "fuzz/seeds.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"

namespace ovoid::io {
namespace lammps_dump_test {

using Doubles = std::vector<double>;

std::string frame(int step, const std::string& columns, const std::string& atoms,
                  const std::string& box = " pp pp pp\n0 10\n0 20\n-1 1\n") {
  return "ITEM: TIMESTEP\n" + std::to_string(step) +
         "\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS" + box + "ITEM: ATOMS " + columns + "\n" +
         atoms;
}

Dataset read_dump(const std::string& text, const ReadOptions& options = {}) {
  return read_source(*open_memory("a.dump", std::as_bytes(std::span(text))), options);
}

TEST(LammpsDump, FramesAreSteps) {
  const std::string text = frame(0, "id x y z v", "1 1 2 3 5\n2 4 5 6 5\n") +
                           frame(50, "id x y z v", "2 7 8 9 6\n1 1 1 1 5\n") +
                           frame(100, "id x y z v", "1 0 0 0 1\n2 0 0 0 2\n");
  const Dataset first = read_dump(text);
  EXPECT_EQ(first.kind, DatasetKind::kParticles);
  EXPECT_EQ(first.num_steps, 3);
  EXPECT_EQ(first.step, 1) << "'v' does not vary in the first frame, and 'id' is not drawn";
  EXPECT_EQ(first.times, (Doubles{0, 50, 100}));
  EXPECT_EQ(values_of<double>(first.positions), (Doubles{7, 8, 9, 1, 1, 1}));
  ASSERT_TRUE(first.periodic_box.has_value());
  EXPECT_EQ(first.periodic_box->max(), Vec3(10, 20, 1));
  ReadOptions options;
  options.step = 2;
  EXPECT_EQ(values_of<double>(read_dump(text, options).array("v")), (Doubles{1, 2}));
  EXPECT_EQ(read_dump(fuzz::gzip(text)).step, 1);
  EXPECT_EQ(read_dump(fuzz::bzip2(text), options).step, 2);
  options.step = 3;
  EXPECT_EQ(error_of([&] { read_dump(text, options); }),
            "invalid-argument: a.dump: step 3: expected 0 to 2");
}

TEST(LammpsDump, ScaledAndUnwrappedPositions) {
  const Dataset scaled = read_dump(frame(0, "element xs ys zs", "H 0.5 0.5 0.5\nO 0 1 1\n"));
  EXPECT_EQ(values_of<double>(scaled.positions), (Doubles{5, 10, 0, 0, 20, 1}));
  EXPECT_TRUE(scaled.arrays.empty());
  const Dataset unwrapped = read_dump(frame(0, "xu yu zu", "11 12 13\n1 2 3\n"));
  EXPECT_EQ(values_of<double>(unwrapped.positions)[0], 11);
  EXPECT_FALSE(unwrapped.periodic_box.has_value());
  // A tilted box: bounds 0..4 along x with xy = 1 are those of a box of 3.
  const Dataset tilted = read_dump(
      frame(0, "xs ys zs", "0 1 0\n1 0 0\n", " xy xz yz pp pp pp\n0 4 1\n0 2 0\n0 2 0\n"));
  EXPECT_EQ(values_of<double>(tilted.positions), (Doubles{1, 2, 0, 3, 0, 0}));
  EXPECT_FALSE(tilted.periodic_box.has_value());
  EXPECT_FALSE(read_dump(frame(0, "x y z", "1 2 3\n1 2 4\n", " pp ff pp\n0 1\n0 1\n0 1\n"))
                   .periodic_box.has_value());
}

// dump_modify time yes, units yes: the frame's first items.
TEST(LammpsDump, TimesOfTheSimulation) {
  const auto at = [](const std::string& time) { return "ITEM: TIME\n" + time + "\n"; };
  const std::string atoms = "1 2 3\n4 5 6\n";
  const std::string first = at("0") + frame(0, "x y z", atoms);
  const Dataset dump =
      read_dump("ITEM: UNITS\nmetal\n" + first + at("0.5") + frame(100, "z y x", atoms));
  EXPECT_EQ(dump.num_steps, 2);
  EXPECT_EQ(dump.times, (Doubles{0, 0.5}));
  EXPECT_EQ(dump.time_unit, "ps");
  EXPECT_EQ(read_dump(fuzz::gzip(first)).times, Doubles{0});
  // Frames that do not all tell a later one are numbered.
  EXPECT_EQ(read_dump(first + frame(100, "x y z", atoms)).times, (Doubles{0, 100}));
  EXPECT_EQ(read_dump(first + at("0") + frame(100, "x y z", atoms)).times, (Doubles{0, 100}));
  EXPECT_EQ(error_of([&] { read_dump("ITEM: TIME\nnow\n" + frame(0, "x y z", atoms)); }),
            "file-format: a.dump: line 2: 'now': expected a number");
}

// A frame has columns of its own, and so has its box.
TEST(LammpsDump, FramesDiffer) {
  const std::string text = frame(0, "id x y z v", "1 1 2 3 5\n2 4 5 6 7\n") +
                           frame(1, "z y x w id", "3 2 1 8 1\n6 5 4 9 2\n");
  ReadOptions options;
  options.step = 1;
  const Dataset second = read_dump(text, options);
  EXPECT_EQ(values_of<double>(second.positions), (Doubles{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(values_of<double>(second.array("w")), (Doubles{8, 9}));
}

// Edge vectors (2,0,0), (1,3,0), (0,1,4) from (10,20,30) on.
TEST(LammpsDump, GeneralBox) {
  const std::string box = " abc origin pp pp pp\n2 0 0 10\n1 3 0 20\n0 1 4 30\n";
  const Dataset scaled = read_dump(frame(0, "xs ys zs", "0 0 0\n0.5 1 0.25\n", box));
  EXPECT_EQ(values_of<double>(scaled.positions), (Doubles{10, 20, 30, 12, 23.25, 31}));
  EXPECT_FALSE(scaled.periodic_box.has_value());
  EXPECT_EQ(scaled.notes.size(), 1U);
  const std::string even = " abc origin pp pp pp\n2 0 0 10\n0 3 0 20\n0 0 4 30\n";
  const Dataset upright = read_dump(frame(0, "x y z", "11 21 31\n12 22 32\n", even));
  ASSERT_TRUE(upright.periodic_box.has_value());
  EXPECT_EQ(upright.periodic_box->max(), Vec3(12, 23, 34));
}

TEST(LammpsDump, OtherDumpsAreNamed) {
  EXPECT_EQ(error_of([&] {
              read_dump(
                  "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS pp pp "
                  "pp\n0 1\n0 1\n0 1\nITEM: ENTRIES c_1\n1\n");
            }),
            "unsupported: a.dump: line 3: 'ITEM: NUMBER OF ENTRIES': is a dump of bonds or other "
            "entries, which is not read: expected one of atoms");
}

TEST(LammpsDump, WhatIsBroken) {
  const std::string good = frame(0, "x y z", "1 2 3\n4 5 6\n");
  const auto message = [](const std::string& text) { return error_of([&] { read_dump(text); }); };
  const Dataset cut = read_dump(good + frame(1, "x y z", "1 2 3\n"));
  EXPECT_EQ(cut.num_steps, 1);
  ASSERT_EQ(cut.notes.size(), 1U);
  EXPECT_EQ(cut.notes[0], "a.dump: the last frame is cut short and left out");
  EXPECT_EQ(message(frame(1, "x y z", "1 2 3\n")),
            "file-format: a.dump: line 10: the file ends within a frame");
  EXPECT_EQ(message(with(good, "4 5 6", "4 five 6")),
            "file-format: a.dump: line 11: column 'y' is 'five': expected a number");
  EXPECT_EQ(message(with(good, "\n2\n", "\n1e9\n")),
            "file-format: a.dump: line 4: '1e9': expected a number of atoms");
  EXPECT_EQ(
      message(with(good, "x y z", "vx vy vz")),
      "file-format: a.dump: line 9: the atoms have no columns x y z, xu yu zu, xs ys zs or xsu "
      "ysu zsu");
  EXPECT_EQ(message(with(with(good, "x y z", "xs a b c ys zs"), "1 2 3", "one 1 2 3 4 5")),
            "file-format: a.dump: line 10: column 'xs' holds no numbers");
  EXPECT_EQ(message(good + "garbage\n").substr(0, 38), "file-format: a.dump: line 12: 'garbage");
}

}  // namespace lammps_dump_test
}  // namespace ovoid::io
