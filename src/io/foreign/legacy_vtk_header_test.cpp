// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "io/foreign/vtk_header.h"
#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace legacy_vtk_header_test {

std::string vtk_error(const std::string& content) {
  return error_of(
      [&] { check_legacy_vtk(*open_memory("a.vtk", std::as_bytes(std::span(content)))); });
}

const std::string kPlace =
    "DATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 12\n";
const std::string kBinary = "# vtk DataFile Version 3.0\ntitle\nBINARY\n\n" + kPlace;
const std::string kAscii = "# vtk DataFile Version 3.0\ntitle\nASCII\n" + kPlace;
const std::string kScalars = "SCALARS a unsigned_char\nLOOKUP_TABLE default\n123456789012";
const std::string kTwelve = "1 2 3 4 5 6 7 8 9 10 11 12\n";

TEST(LegacyVtkHeader, AcceptsWhatFits) {
  const std::string plain = kBinary + kScalars;
  EXPECT_EQ(vtk_error(plain), "");
  EXPECT_EQ(vtk_error(with(plain, "DIMENSIONS 3 2 2", "dimensions\n3\n2 2")), "");
  EXPECT_EQ(vtk_error(with(with(plain, "POINT_DATA 12", "CELL_DATA 2"), "3456789012", "")), "");
}

TEST(LegacyVtkHeader, RefusesWhatTheFileCannotHold) {
  const std::string plain = kBinary + kScalars;
  EXPECT_EQ(vtk_error(with(plain, "a unsigned_char", "a double")),
            "file-format: a.vtk: array 'a': 12 tuples of 1 double do not fit the 12 bytes behind "
            "it: is the file truncated?");
  EXPECT_EQ(vtk_error(with(plain, "unsigned_char", "unsigned_char 4")),
            "file-format: a.vtk: array 'a': 12 tuples of 4 unsigned_char do not fit the 12 bytes "
            "behind it: is the file truncated?");
  EXPECT_EQ(vtk_error(with(plain, "POINT_DATA 12", "POINT_DATA 13")),
            "file-format: a.vtk: POINT_DATA: '13': DIMENSIONS need 12");
  EXPECT_EQ(vtk_error(with(with(plain, "3 2 2", "3000 2000 2000"), "POINT_DATA 12",
                           "POINT_DATA 12000000000"))
                .substr(0, 61),
            "file-format: a.vtk: POINT_DATA: 12000000000 samples do not fi");
  EXPECT_EQ(vtk_error(with(plain, "3 2 2", "3 0 2")),
            "file-format: a.vtk: DIMENSIONS: '0': expected 1 to 2147483647");
  EXPECT_EQ(vtk_error(plain.substr(0, 110)),
            "file-format: a.vtk: has no POINT_DATA or CELL_DATA: is the file truncated?");
  EXPECT_EQ(vtk_error(with(plain, "STRUCTURED_POINTS", "GRAPH")),
            "unsupported: a.vtk: DATASET 'graph': expected STRUCTURED_POINTS, RECTILINEAR_GRID, "
            "STRUCTURED_GRID, UNSTRUCTURED_GRID or POLYDATA");
  EXPECT_EQ(vtk_error(""), "file-format: a.vtk: '' after the title: expected ASCII or BINARY");
}

// Any array, not only the first, in either encoding.
TEST(LegacyVtkHeader, MeasuresEveryArray) {
  const auto binary = [](const std::string& arrays) {
    return vtk_error(kBinary + kScalars + "\n" + arrays);
  };
  const auto ascii = [](const std::string& arrays) { return vtk_error(kAscii + arrays); };
  const auto ends_early = [](const std::string& what, const std::string& layout, int num_left) {
    return "file-format: a.vtk: " + what + ": " + layout + " do not fit the " +
           std::to_string(num_left) + " bytes behind it: is the file truncated?";
  };
  EXPECT_EQ(binary("FIELD F 1\na 1 1000000000 int\n1234"),
            ends_early("array 'a'", "1000000000 tuples of 1 int", 5));
  EXPECT_EQ(binary("FIELD F 2\na 1 4 char\n1234\nb 1 5 char\n1234"),
            ends_early("array 'b'", "5 tuples of 1 char", 4));
  EXPECT_EQ(binary("FIELD F 1\na 1 1000000000 string\n1234"),
            ends_early("array 'a'", "1000000000 tuples of 1 string", 5));
  EXPECT_EQ(binary("SCALARS w double 100000000\nLOOKUP_TABLE default\n1"),
            "file-format: a.vtk: array 'w': '100000000': expected a number of components or "
            "LOOKUP_TABLE");
  EXPECT_EQ(binary("COLOR_SCALARS c 100000000\n1"),
            "file-format: a.vtk: array 'c': '100000000': expected 1 to 1048576");
  EXPECT_EQ(binary("COLOR_SCALARS c 1000000\n1"),
            ends_early("array 'c'", "12 tuples of 1000000 unsigned_char", 2));
  EXPECT_EQ(binary("LOOKUP_TABLE t 2000000000\n1"),
            ends_early("LOOKUP_TABLE 't'", "2000000000 tuples of 4 unsigned_char", 2));
  EXPECT_EQ(binary("LOOKUP_TABLE t -5\n1"),
            "file-format: a.vtk: LOOKUP_TABLE 't': '-5': expected 0 to 2147483647");
  EXPECT_EQ(binary("TENSORS t double\n1"), ends_early("array 't'", "12 tuples of 9 double", 2));
  EXPECT_EQ(binary("FIELD F 2000000000\n"),
            "file-format: a.vtk: FIELD 'F': '2000000000': expected 0 to 10000");
  EXPECT_EQ(ascii("FIELD F 1\na 1 1000000000 string\n1\n2\n"),
            ends_early("array 'a'", "1000000000 tuples of 1 string", 5));
  EXPECT_EQ(ascii("VECTORS v float\n1 2 3"), ends_early("array 'v'", "12 tuples of 3 float", 6));
  EXPECT_EQ(ascii("SCALARS s int\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8 9 10 11     "),
            "file-format: a.vtk: array 's': ends after 11 of 12 numbers: is the file truncated?");
  EXPECT_EQ(vtk_error(with(kBinary, "DATASET STRUCTURED_POINTS",
                           "DATASET STRUCTURED_POINTS\nFIELD F 1\nz 1 1000000000 double\n")
                          .substr(0, 110)),
            ends_early("array 'z'", "1000000000 tuples of 1 double", 12));
}

TEST(LegacyVtkHeader, AcceptsEveryKindOfArray) {
  const std::string threes = kTwelve + kTwelve + kTwelve;
  EXPECT_EQ(
      vtk_error(kAscii + "SCALARS s int 1\nLOOKUP_TABLE t\n" + kTwelve + "LOOKUP_TABLE t 3\n" +
                kTwelve + "COLOR_SCALARS c 1\n" + kTwelve + "VECTORS v float\n" + threes +
                "NORMALS n double\n" + threes + "TENSORS t float\n" + threes + threes + threes +
                "TENSORS6 t6 float\n" + threes + threes + "TEXTURE_COORDINATES x 3 float\n" +
                threes + "GLOBAL_IDS g vtkIdType\n" + kTwelve + "PEDIGREE_IDS p vtkIdType\n" +
                kTwelve + "EDGE_FLAGS e bit\n" + kTwelve + "CELL_DATA 2\nFIELD F 3\n" +
                "NULL_ARRAY\nmany 2 6 int\n" + kTwelve + "text 1 2 string\none\ntwo\n"),
      "");
  EXPECT_EQ(vtk_error(kBinary + "FIELD F 4\nbits 1 12 bit\nab\nnone 1 0 int\n\n" +
                      "text 1 3 string\n\xc3one\x80\x03two" +
                      std::string("\0\0\0\0\0\0\0\5three", 13) + "\nlast 1 4 char\n1234\n\n\n"),
            "");
}

TEST(LegacyVtkHeader, ReadsMetadataInOneWayOnly) {
  const auto with_metadata = [](const std::string& lines) {
    return vtk_error(kAscii + "SCALARS s int\nLOOKUP_TABLE default\n" + kTwelve + "METADATA\n" +
                     lines + "\n\nSCALARS t int\nLOOKUP_TABLE default\n" + kTwelve);
  };
  const auto refusal = [](const std::string& line) {
    return "file-format: a.vtk: array 's': METADATA: '" + line +
           "': not understood, or the file is truncated";
  };
  EXPECT_EQ(with_metadata("COMPONENT_NAMES\nx\nINFORMATION 2\nNAME L2_NORM_RANGE LOCATION "
                          "vtkDataArray\nDATA 2 0 1.5\nNAME UNITS_LABEL LOCATION "
                          "vtkDataArray\nDATA 5\n"),
            "");
  EXPECT_EQ(with_metadata("INFORMATION 2000000000"), refusal(""));
  EXPECT_EQ(with_metadata("INFORMATION 1\nNAME ORIGIN LOCATION vtkDataObject\nDATA 2000000000 1"),
            refusal("DATA 2000000000 1"));
  EXPECT_EQ(with_metadata("INFORMATION 1\nNAME ORIGIN LOCATION vtkDataObject\nDATA -1 1"),
            refusal("DATA -1 1"));
  EXPECT_EQ(with_metadata("SCALARS u double"), refusal("SCALARS u double"));
}

// What VTK would read on from in another place than this walk, or not read at all.
TEST(LegacyVtkHeader, RefusesWhatVtkReadsOtherwise) {
  const auto scalars = [](const std::string& numbers) {
    return vtk_error(kAscii + "SCALARS s int\nLOOKUP_TABLE default\n" + numbers);
  };
  EXPECT_EQ(scalars("1 2 3-4 5 6 7 8 9 10 11 12 13 14"),
            "file-format: a.vtk: array 's': '3-4' after 2 of 12 numbers: expected a number of type "
            "int");
  EXPECT_EQ(scalars("1 2 nan 4 5 6 7 8 9 10 11 12"),
            "file-format: a.vtk: array 's': 'nan' after 2 of 12 numbers: expected a number of type "
            "int");
  EXPECT_EQ(scalars(kTwelve + std::string(300, ' ')),
            "file-format: a.vtk: array 's': followed by more than 255 blanks");
  EXPECT_EQ(scalars(kTwelve + "POINT_DATA 12\n"), "file-format: a.vtk: POINT_DATA: stands twice");
  EXPECT_EQ(scalars(kTwelve + "SCALARS2 t\n"),
            "file-format: a.vtk: 'scalars2' behind the arrays: expected SCALARS, VECTORS, FIELD or "
            "another array");
  EXPECT_EQ(vtk_error(kAscii + "SCALARS s int\n" + kTwelve),
            "file-format: a.vtk: array 's': '2': expected LOOKUP_TABLE default");
  EXPECT_EQ(vtk_error(kAscii + "SCALARS s integer\nLOOKUP_TABLE default\n" + kTwelve),
            "file-format: a.vtk: array 's': type 'integer': expected char, short, int, long, float "
            "or another of VTK's types of numbers");
  EXPECT_EQ(vtk_error(kAscii + "SCALARS " + std::string(300, 'n')),
            "file-format: a.vtk: '" + std::string(40, 'n') +
                "...': expected a word of at most 255 characters");
  EXPECT_EQ(vtk_error(kBinary + "SCALARS s char\nLOOKUP_TABLE default" + std::string(300, ' ') +
                      "\n123456789012"),
            "file-format: a.vtk: array 's': its line does not end before the data");
  EXPECT_EQ(vtk_error(with(kBinary + kScalars, "SPACING 1 1 1", "SPACING foo 1 1")),
            "file-format: a.vtk: SPACING: 'foo': expected three numbers");
  EXPECT_EQ(vtk_error(kBinary + "SCALARS s char\n" + std::string(3, '\0') + "x"),
            "file-format: a.vtk: array 's': '???x': expected a number of components or "
            "LOOKUP_TABLE");
  EXPECT_EQ(vtk_error(with(kBinary + kScalars, "ORIGIN", "DIMENSIONS 9 9 9\nORIGIN")),
            "file-format: a.vtk: DIMENSIONS: stand twice");
}

}  // namespace legacy_vtk_header_test
}  // namespace ovoid::io
