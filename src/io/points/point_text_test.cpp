// SPDX-License-Identifier: Apache-2.0
#include "io/points/point_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "fuzz/seeds.h"
#include "io/core/number_fields.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/points/point_columns.h"
#include "io/read_source.h"

namespace ovoid::io {
namespace point_text_test {

using Doubles = std::vector<double>;

Dataset read_csv(const std::string& text, const std::string& name = "a.csv") {
  return read_source(*open_memory(name, std::as_bytes(std::span(text))), {});
}

std::string csv_error(const std::string& text) {
  return error_of([&] { read_csv(text); });
}

std::vector<std::string> names_in(const Dataset& dataset) {
  std::vector<std::string> names;
  for (const DataArray& array : dataset.arrays)
    names.push_back(array.name + "/" + std::to_string(array.num_components));
  return names;
}

TEST(PointText, NamesUnitsAndComponents) {
  const Dataset dataset = read_csv(
      "id,\"X [kpc]\",y,v:0,v:1,v:2,z,T (K),\"rho, "
      "gas\"\n1,2,3,4,5,6,7,8,9\n10,20,30,40,50,60,70,80,"
      "90\n");
  EXPECT_EQ(dataset.kind, DatasetKind::kParticles);
  EXPECT_EQ(dataset.format, "CSV");
  EXPECT_EQ(values_of<double>(dataset.positions), (Doubles{2, 3, 7, 20, 30, 70}));
  EXPECT_EQ(dataset.positions.unit, "kpc");
  EXPECT_EQ(names_in(dataset), (std::vector<std::string>{"id/1", "v/3", "T/1", "rho, gas/1"}));
  EXPECT_EQ(values_of<double>(dataset.array("v")), (Doubles{4, 5, 6, 40, 50, 60}));
  EXPECT_EQ(dataset.array("T").unit, "K");
  EXPECT_EQ(dataset.array().name, "v") << "numbers of particles are not drawn by default";
  EXPECT_TRUE(dataset.notes.empty());
}

TEST(PointText, PositionsByOtherNames) {
  for (const char* const names :
       {"Points:0,Points:1,Points:2", "Points_0,Points_1,Points_2", "pos_x,pos_y,pos_z",
        "PosX,PosY,PosZ", "coordinates:0,coordinates:1,coordinates:2"}) {
    const Dataset dataset = read_csv("a," + std::string(names) + "\n9,1,2,3\n8,4,5,6\n");
    EXPECT_EQ(values_of<double>(dataset.positions), (Doubles{1, 2, 3, 4, 5, 6})) << names;
    EXPECT_TRUE(dataset.notes.empty()) << names;
  }
  const Dataset first = read_csv("a,b,c\n1,2,3\n");
  ASSERT_EQ(first.notes.size(), 1U);
  EXPECT_EQ(first.notes[0],
            "a.csv: no columns are called x, y, z: 'a', 'b' and 'c' are taken for "
            "the positions");
}

TEST(PointText, SeparatorsBlanksAndComments) {
  const Doubles expected{1, 2, 3, 4, 5, 6};
  for (const char* const text :
       {"1,2,3\n4,5,6", "1 2 3\n4 5 6\n", " 1\t2  3 \r\n\r\n# comment\n4 5 6\r\n", "1;2;3\n4;5;6\n",
        "1, 2, 3,\n4 , 5 ,6\n",
        "\xef\xbb\xbf"
        "1\t2\t3\n4\t5\t6\n",
        "+1 2.0e0 3d0\n\"4\" 5 6"}) {
    const Dataset dataset = read_csv(text, "a.dat");
    EXPECT_EQ(values_of<double>(dataset.positions), expected) << text;
    EXPECT_TRUE(dataset.arrays.empty()) << text;
  }
  EXPECT_EQ(values_of<double>(read_csv(fuzz::gzip("1,2,3\n4,5,6\n"), "a.csv.gz").positions),
            expected);
  EXPECT_EQ(values_of<double>(read_csv(fuzz::bzip2("1,2,3\n4,5,6\n"), "a.txt.bz2").positions),
            expected);
}

TEST(PointText, MissingValuesAndText) {
  const Dataset dataset = read_csv(
      "name,x,y,z,v\nA,1,2,3,NaN\nB,1,2,3,\nC,1,2,3,inf\n\"D,E\",1,2,3,1e999\nF,1,2,3,1e-999\n");
  const auto values = values_of<double>(dataset.array("v"));
  ASSERT_EQ(values.size(), 5U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_TRUE(std::isnan(values[i])) << i;
  EXPECT_EQ(values[4], 0);
  ASSERT_EQ(dataset.notes.size(), 1U);
  EXPECT_EQ(dataset.notes[0], "a.csv: columns of text are left out: 'name'");
}

TEST(PointText, CommentThatNamesColumns) {
  const Dataset dataset =
      read_csv("# made by a program\n# x y z mass\n1 2 3 4\n5 6 7 8\n", "a.txt");
  EXPECT_EQ(names_in(dataset), std::vector<std::string>{"mass/1"});
  EXPECT_EQ(names_in(read_csv("# of 4 columns here 1\n1 2 3 4\n")),
            std::vector<std::string>{"column 4/1"});
}

TEST(PointText, QuantitiesPerLine) {
  const Dataset dataset = read_csv(
      "# x,y,z,v\n1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16\n"
      "2,2,2,2,2,2,2,2,2,2,2,2,2,2,2,2\n3,3,3,3,3,3,3,3,3,3,3,3,3,3,3,3\n"
      "0,1,0,1,0,1,0,1,0,1,0,1,0,1,0,1\n");
  ASSERT_EQ(dataset.num_positions(), 16);
  const auto positions = values_of<double>(dataset.positions);
  EXPECT_EQ(Doubles(positions.begin() + 3, positions.begin() + 6), (Doubles{2, 2, 3}));
  EXPECT_EQ(names_in(dataset), std::vector<std::string>{"v/1"});
  ASSERT_EQ(dataset.notes.size(), 1U);
  EXPECT_EQ(dataset.notes[0],
            "a.csv: 4 lines of 16 numbers each: taken as one quantity per line, not one point");
  EXPECT_EQ(read_csv("1,2,3,4,5,6,7,8\n1,2,3,4,5,6,7,8\n1,2,3,4,5,6,7,8\n").num_positions(), 3)
      << "8 columns of 3 lines are points";
}

TEST(PointText, ErrorsNameTheLine) {
  EXPECT_EQ(csv_error("x,y,z\n1,2,3\n1,2\n"),
            "file-format: a.csv: line 3: has 2 fields: expected 3");
  EXPECT_EQ(csv_error("x,y,z\n1,2,3\n1,2,3,4\n"),
            "file-format: a.csv: line 3: has more than the 3 fields of the first line of numbers");
  EXPECT_EQ(csv_error("1,2,3\n1,two,3\n"),
            "file-format: a.csv: line 2: field 2 is 'two': expected a number");
  EXPECT_EQ(csv_error("a,b\nc,d\n"),
            "file-format: a.csv: line 2: 'c,d': expected at least three numbers for x, y, z");
  EXPECT_EQ(csv_error("x,y,z\n"),
            "file-format: a.csv: holds no line of numbers: expected rows of x, y, z");
  EXPECT_EQ(csv_error(std::string("1,2,3\n\0", 7)),
            "file-format: a.csv: is no text: it holds bytes that are 0");
  EXPECT_EQ(csv_error("1,2,3,4,5,6,7,8,9,10,11,12\n1,2,3,4,5,6,7,8,9,10,11,12\n1,2,3\n"),
            "file-format: a.csv: line 3: has 3 numbers: expected 12");
  EXPECT_EQ(csv_error(fuzz::gzip("1,2,3\n4,5,6\n").substr(0, 25)).substr(0, 37),
            "file-format: a.csv: the gzip data are");
}

TEST(PointText, ManyRowsKeepTheirOrder) {
  std::string text = "x,y,z,v\n";
  for (int i = 0; i < 20000; ++i)
    text += std::to_string(i) + ",0,1," + std::to_string(2 * i) + "\n";
  const Dataset dataset = read_csv(text);
  ASSERT_EQ(dataset.num_positions(), 20000);
  const auto positions = values_of<double>(dataset.positions);
  const auto values = values_of<double>(dataset.array("v"));
  for (std::size_t i = 0; i < 20000; ++i) {
    ASSERT_EQ(positions[3 * i], static_cast<double>(i));
    ASSERT_EQ(values[i], 2.0 * static_cast<double>(i));
  }
}

TEST(PointText, RoundTrip) {
  const TestFolder folder;
  Dataset dataset;
  dataset.kind = DatasetKind::kParticles;
  dataset.positions =
      make_array("positions", ScalarType::kFloat64, Doubles{0.1, 2, 3, 1.0 / 3, 5e-300, 6}, 3);
  dataset.positions.unit = "m";
  dataset.arrays.push_back(
      make_array("rho, gas", ScalarType::kFloat32, std::vector<float>{0.1F, NAN}));
  dataset.arrays.push_back(
      make_array("v", ScalarType::kInt16, std::vector<std::int16_t>{1, -2, 3, 4}, 2));
  write_dataset(dataset, folder.file("a.csv"));
  EXPECT_EQ(folder.read("a.csv").substr(0, 51),
            "\"x [m]\",\"y [m]\",\"z [m]\",\"rho, gas\",v:0,v:1\n0.1,2,3,");
  const Dataset again = read_dataset({folder.file("a.csv")});
  EXPECT_EQ(values_of<double>(again.positions), values_of<double>(dataset.positions));
  EXPECT_EQ(again.positions.unit, "m");
  EXPECT_EQ(static_cast<float>(values_of<double>(again.array("rho, gas"))[0]), 0.1F);
  EXPECT_TRUE(std::isnan(values_of<double>(again.array("rho, gas"))[1]));
  EXPECT_EQ(values_of<double>(again.array("v")), (Doubles{1, -2, 3, 4}));
}

TEST(NumberFields, WhatIsANumber) {
  for (const auto& [text, value] : std::vector<std::pair<const char*, double>>{{"1", 1},
                                                                               {"+1.5", 1.5},
                                                                               {" -2e3 ", -2000},
                                                                               {"1.5D+01", 15},
                                                                               {"\"7\"", 7},
                                                                               {".5", 0.5}}) {
    const auto parsed = parse_field(text);
    ASSERT_TRUE(parsed.has_value()) << text;
    EXPECT_EQ(*parsed, value) << text;
  }
  for (const char* const text : {"", "NaN", "n/a", "null", "-inf", "-"})
    EXPECT_TRUE(std::isnan(parse_field(text).value())) << text;
  for (const char* const text : {"1.5x", "x", "1,5", "+", "--1", "0x10", "d", "1 2"})
    EXPECT_FALSE(parse_field(text).has_value()) << text;
}

TEST(PointColumns, UnitsInBrackets) {
  EXPECT_EQ(split_unit("x [kpc]").unit, "kpc");
  EXPECT_EQ(split_unit("x(m/s)").name, "x");
  EXPECT_EQ(split_unit("[kpc]").name, "[kpc]");
  EXPECT_EQ(split_unit("a] b").name, "a] b");
}

}  // namespace point_text_test
}  // namespace ovoid::io
