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
        "PosX,PosY,PosZ", "coordinates:0,coordinates:1,coordinates:2", "X,Y,Z",
        "x-coordinate,y-coordinate,z-coordinate", "X (mm),Y (mm),Z (mm)", "x_mm,y_mm,z_mm",
        "X Location (m),Y Location (m),Z Location (m)", "x_pos,y_pos,z_pos",
        "Position_X,Position_Y,Position_Z"}) {
    const Dataset dataset = read_csv("a," + std::string(names) + "\n9,1,2,3\n8,4,5,6\n");
    EXPECT_EQ(values_of<double>(dataset.positions), (Doubles{1, 2, 3, 4, 5, 6})) << names;
    EXPECT_TRUE(dataset.notes.empty()) << names;
  }
  const Dataset momenta = read_csv("px,py,pz\n1,2,3\n");
  EXPECT_EQ(momenta.notes,
            std::vector<std::string>{"a.csv: positions: x is 'px', y is 'py', z is 'pz'"});
  EXPECT_EQ(values_of<double>(read_csv("id,time,a,b,c\n1,2,3,4,5\n").positions),
            (Doubles{3, 4, 5}));
  EXPECT_EQ(csv_error("a,x,y,z,b\n1,one,2,3,4\n"),
            "file-format: a.csv: column 'x' of the positions holds no numbers");
  EXPECT_EQ(read_csv("x [m],y [m],z [km]\n1,2,3\n").notes,
            std::vector<std::string>{"a.csv: positions have several units (m, m, km): their "
                                     "numbers are taken as they are"});
  const Dataset first = read_csv("a,b,c\n1,2,3\n");
  ASSERT_EQ(first.notes.size(), 1U);
  EXPECT_EQ(first.notes[0],
            "a.csv: no columns are called x, y, z: 'a', 'b' and 'c' are taken for "
            "the positions");
}

// Fails if places are mirrored or swapped without a word.
TEST(PointText, PlacesOnEarth) {
  for (const char* const names :
       {"time,latitude,longitude,depth,mag", "time,LAT,LON,Depth (km),mag", "t,Lat,Lng,depth_km,m",
        "when,lat_deg,lon_deg,DEPTH,m", "a,\"latitude (degrees_north)\",longitude,depths [m],m"}) {
    const Dataset dataset =
        read_csv(std::string(names) + "\n2024-01-01T00:00:00Z,35,-120,5,2\n2024,36,-121,-1,3\n");
    EXPECT_EQ(values_of<double>(dataset.positions), (Doubles{-120, 35, -5, -121, 36, 1})) << names;
    ASSERT_GE(dataset.notes.size(), 2U) << names;
    EXPECT_NE(dataset.notes[0].find("z is minus '"), std::string::npos) << dataset.notes[0];
  }
  const Dataset up = read_csv("longitude,latitude,altitude,v\n1,2,3,4\n");
  EXPECT_EQ(values_of<double>(up.positions), (Doubles{1, 2, 3}));
  EXPECT_EQ(up.notes, std::vector<std::string>{"a.csv: positions: x is 'longitude', y is "
                                               "'latitude', z is 'altitude'"});
  const Dataset flat = read_csv("lat,lon,v\n1,2,3\n4,5,6\n");
  EXPECT_EQ(values_of<double>(flat.positions), (Doubles{2, 1, 0, 5, 4, 0}));
  EXPECT_EQ(flat.notes,
            std::vector<std::string>{"a.csv: positions: x is 'lon', y is 'lat', z is 0, since no "
                                     "column is called z, depth, altitude or the like"});
  EXPECT_EQ(values_of<double>(read_csv("v,northing,easting,elevation\n9,1,2,3\n").positions),
            (Doubles{2, 1, 3}));
  EXPECT_EQ(values_of<double>(read_csv("# depth lon lat\n1,2,3,4,5,6,7,8,9,10,11,12\n"
                                       "1,1,1,1,1,1,1,1,1,1,1,1\n2,2,2,2,2,2,2,2,2,2,2,2\n")
                                  .positions)[5],
            -2)
      << "lines of quantities are placed by the same rules";
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

// What spreadsheets and programs write where a number is missing, at a row's start, too.
TEST(PointText, WordsOfMissingValues) {
  const Dataset dataset = read_csv(
      "v;x;y;z\n#N/A;1;2;3\n#DIV/"
      "0!;1;2;3\nNA;1;2;3\nnull;1;2;3\n-nan(ind);1;2;3\n;1;2;3\n5;1;2;3\n");
  const auto values = values_of<double>(dataset.array("v"));
  ASSERT_EQ(values.size(), 7U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_TRUE(std::isnan(values[i])) << i;
  EXPECT_EQ(values[6], 5);
  // A row without a value is one where the names say so.
  EXPECT_EQ(read_csv("x,y,z,v\nNA,NA,2,NA\n1,2,3,4\n").num_positions(), 2);
}

// Fails if a comma between digits is taken for what separates numbers, or the other way round.
TEST(PointText, DecimalCommas) {
  const Doubles expected{0.5, 1, 2.25, 3, 4.5, -6000};
  for (const char* const text :
       {"x;y;z\n0,5;1;2,25\n3;4,5;-6,0E3\n", "x\ty\tz\n0,5\t1\t2,25\n3\t4,5\t-6e3\n",
        "0,5 1,0 2,25\n3,0 4,5 -6000\n", "x,y,z\n\"0,5\",\"1,0\",\"2,25\"\n3,\"4,5\",-6000\n"}) {
    const Dataset dataset = read_csv(text);
    EXPECT_EQ(values_of<double>(dataset.positions), expected) << text;
    ASSERT_EQ(dataset.notes.size(), 1U) << text;
    EXPECT_EQ(dataset.notes[0], "a.csv: commas are taken for decimal ones");
  }
  // They may begin after more lines than are looked at first.
  std::string late = "x;y;z\n";
  for (int i = 0; i < 200; ++i) late += "1;2;3\n";
  const auto positions = values_of<double>(read_csv(late + "1,5;2;3\n").positions);
  EXPECT_EQ(positions[600], 1.5);
}

TEST(PointText, OtherEncodingsAreNamed) {
  EXPECT_EQ(csv_error(std::string("\xff\xfex\0,\0", 6)),
            "unsupported: a.csv: is text in UTF-16, which is not read: expected UTF-8, which "
            "spreadsheets save as 'CSV UTF-8'");
}

TEST(PointText, ThousandsAreNamed) {
  const std::string what =
      "numbers with marks between their thousands are not read: expected "
      "them without";
  EXPECT_EQ(csv_error("x,y,z\n\"1,234.5\",2,3\n"),
            "file-format: a.csv: line 2: '1,234.5': " + what);
  EXPECT_EQ(csv_error("x,y,z,v\n1,2,3,4\n1,2,3,\"1,234\"\n"),
            "file-format: a.csv: line 3: '1,234': " + what);
  EXPECT_EQ(csv_error("x;y;z\n1,5;2;3\n1.234,5;2;3\n"),
            "file-format: a.csv: line 3: '1.234,5': " + what);
  EXPECT_EQ(csv_error("x;y;z\n1,5;2;3\n1.25;2;3\n"),
            "file-format: a.csv: line 3: field 1 is '1.25': other numbers have decimal commas, so "
            "that its point may set thousands apart: expected commas or points alone");
}

TEST(PointText, LineThatSaysTheSeparator) {
  const Doubles expected{1, 2, 3};
  for (const char* const text : {"sep=;\nx;y;z\n1;2;3\n", "SEP=,\nx,y,z\n1,2,3\n",
                                 "\xef\xbb\xbf\"sep=|\"\r\nx|y|z\r\n1|2|3\r\n"}) {
    const Dataset dataset = read_csv(text);
    EXPECT_EQ(values_of<double>(dataset.positions), expected) << text;
    EXPECT_TRUE(dataset.notes.empty()) << text;
  }
}

// Empty columns at the end, in the rows alone or in the names, too.
TEST(PointText, EmptyColumnsAtTheEnd) {
  for (const char* const text :
       {"x;y;z;v;;\n1;2;3;4;;\n5;6;7;8;;\n", "x;y;z;v\n1;2;3;4;;\n5;6;7;8;;\n"})
    EXPECT_EQ(names_in(read_csv(text)), std::vector<std::string>{"v/1"}) << text;
}

TEST(PointText, QuotesHoldSeparatorsAndLineBreaks) {
  const Dataset dataset = read_csv(
      "site,\"x\n(mm)\",y,z,\"a \"\"b\"\"\"\n\"one, \"\"two\"\"\nand "
      "three\",1,2,3,4\n\"1;2\",5,6,7,8\n");
  EXPECT_EQ(values_of<double>(dataset.positions), (Doubles{1, 2, 3, 5, 6, 7}));
  EXPECT_EQ(names_in(dataset), std::vector<std::string>{"a \"b\"/1"});
  EXPECT_EQ(csv_error("site,x,y,z\n\"open,1,2,3\n4,5,6\n"),
            "file-format: a.csv: line 2: a field's quote is not closed");
}

// COMSOL pads names to a width, and units in brackets have blanks before them.
TEST(PointText, NamesInTheLastComment) {
  const Dataset dataset = read_csv(
      "% Model:              a.mph\n% Dimension:          3\n% Length unit:        mm\n"
      "% x                       y                        z                        T (K)"
      "                    v_x (m/s) @ t=0          comp1.spf.U_long_name (m/s) @ 1: t=0.5\n"
      "1.5                      2.0                      3.0                      4.0"
      "                      5.0                      6.0\n");
  EXPECT_EQ(values_of<double>(dataset.positions), (Doubles{1.5, 2, 3}));
  EXPECT_EQ(names_in(dataset),
            (std::vector<std::string>{"T/1", "v_x @ t=0/1", "comp1.spf.U_long_name @ 1: t=0.5/1"}));
  EXPECT_EQ(dataset.array("v_x @ t=0").unit, "m/s");
  for (const char* const mark : {"#", "%", "!", "//", "%%", "# "})
    EXPECT_EQ(names_in(read_csv(std::string(mark) + " x y z T (K) @ t=1 p\n1 2 3 4 5\n")),
              (std::vector<std::string>{"T @ t=1/1", "p/1"}))
        << mark;
  // Names in an earlier comment, if the last says something else.
  EXPECT_EQ(names_in(read_csv("# columns: x y z mass\n# units m m m kg\n# 2 lines\n1 2 3 4\n")),
            std::vector<std::string>{"mass/1"});
}

TEST(PointText, HeadingsOfPrograms) {
  const Dataset cfd = read_csv(
      "[Name]\nPoint Cloud 1\n\n[Data]\nX [ m ], Y [ m ], Z [ m ], Pressure [ Pa ]\n1,2,3,4\n");
  EXPECT_EQ(cfd.positions.unit, "m");
  EXPECT_EQ(cfd.array("Pressure").unit, "Pa");
  ASSERT_EQ(cfd.notes.size(), 1U);
  EXPECT_EQ(cfd.notes[0], "a.csv: 3 lines before the numbers are passed over: '[Name]' and others");
  const Dataset fluent = read_csv(
      "nodenumber,    x-coordinate,    y-coordinate,    z-coordinate,        pressure\n"
      "         1, 1.500000000E+00, 2.000000000E+00, 3.000000000E+00, 4.000000000E+00\n",
      "a.txt");
  EXPECT_EQ(values_of<double>(fluent.positions), (Doubles{1.5, 2, 3}));
  EXPECT_TRUE(fluent.notes.empty());
  EXPECT_EQ(fluent.array().name, "pressure") << "a number of nodes is not drawn by default";
  const Dataset units = read_csv("time,x,y,z,T\nUTC,km,km,km,\n2024-01-01T00:00:00Z,1,2,3,4\n");
  EXPECT_EQ(units.positions.unit, "km");
  EXPECT_EQ(units.num_positions(), 1);
  EXPECT_EQ(csv_error("TITLE = \"a\"\nVARIABLES = \"X\", \"Y\", \"Z\"\nZONE I=1\n1 2 3\n"),
            "unsupported: a.csv: line 1: is a Tecplot file, which is not read: expected a table "
            "whose first line names the columns, as its data are exported to CSV");
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
            "file-format: a.csv: holds no line of numbers: expected rows of x, y, z");
  std::string prose;
  for (int i = 0; i < 300; ++i) prose += "once upon a time\n";
  EXPECT_EQ(csv_error(prose),
            "file-format: a.csv: line 257: 'once upon a time': expected at least three numbers for "
            "x, y, z in one of the first lines");
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
  for (const auto& [text, value] :
       std::vector<std::pair<const char*, double>>{{"1", 1},
                                                   {"+1.5", 1.5},
                                                   {" -2e3 ", -2000},
                                                   {"1.5D+01", 15},
                                                   {"\"7\"", 7},
                                                   {"1.5-103", 1.5e-103},
                                                   {"-2.5+100", -2.5e100},
                                                   {".5", 0.5}}) {
    const auto parsed = parse_field(text);
    ASSERT_TRUE(parsed.has_value()) << text;
    EXPECT_EQ(*parsed, value) << text;
  }
  for (const char* const text : {"", "NaN", "n/a", "null", "-inf", "-", "#N/A", "1.#IND", "--"})
    EXPECT_TRUE(std::isnan(parse_field(text).value())) << text;
  for (const char* const text : {"1.5x", "x", "1,5", "+", "--1", "0x10", "d", "1 2"})
    EXPECT_FALSE(parse_field(text).has_value()) << text;
}

TEST(PointColumns, UnitsInBrackets) {
  EXPECT_EQ(split_unit("x [kpc]").unit, "kpc");
  EXPECT_EQ(split_unit("x(m/s)").name, "x");
  EXPECT_EQ(split_unit("[kpc]").name, "[kpc]");
  EXPECT_EQ(split_unit("a] b").name, "a] b");
  EXPECT_EQ(split_unit("rho (kg/(m*s))").unit, "kg/(m*s)");
  EXPECT_EQ(split_unit("T (K) @ t=0").name, "T @ t=0");
  EXPECT_EQ(split_unit("T (K) @ t=0").unit, "K");
}

}  // namespace point_text_test
}  // namespace ovoid::io
