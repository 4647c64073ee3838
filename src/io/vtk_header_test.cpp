// SPDX-License-Identifier: Apache-2.0
#include "io/vtk_header.h"

#include <gtest/gtest.h>

#include <string>

#include "io/test_volumes.h"
#include "io/xml_tags.h"

namespace ovoid::io {
namespace {

std::string vti_error(const std::string& content) {
  return error_of([&] { check_vti(*open_memory("a.vti", std::as_bytes(std::span(content)))); });
}
std::string vtk_error(const std::string& content) {
  return error_of(
      [&] { check_legacy_vtk(*open_memory("a.vtk", std::as_bytes(std::span(content)))); });
}

const std::string kStored = std::string("\x0c\0\0\0", 4) + "123456789012";

// 3 x 2 x 2 bytes, appended raw behind a UInt32 count.
const std::string kAppended =
    R"(<?xml version="1.0"?>
<!-- a comment with <tags> and a > in it -->
<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian" header_type="UInt32">
<ImageData WholeExtent="0 2 0 1 5 6" Origin="0 0 0" Spacing="1 1 1">
<Piece Extent="0 2 0 1 5 6"><PointData><DataArray type="UInt8" Name="a > b" format="appended" offset="0"/></PointData></Piece>
</ImageData>
<AppendedData encoding="raw">
_)" +
    kStored + "</AppendedData></VTKFile>";

TEST(VtiHeader, AcceptsWhatFits) {
  EXPECT_EQ(vti_error(kAppended), "");
  const std::string inline_text = with(kAppended, R"(format="appended" offset="0"/>)",
                                       R"(format="ascii">1 2 3 4 5 6 7 8 9 1 2 3</DataArray>)");
  EXPECT_EQ(vti_error(inline_text), "");
  // The count 12 in base64 is DAAAAA==.
  EXPECT_EQ(vti_error(with(kAppended, R"(format="appended" offset="0"/>)", R"(format="binary">
     DAAAADEyMzQ1Njc4OTAxMg==</DataArray>)")),
            "");
  // One cell data array: 2 x 1 x 1 cells.
  EXPECT_EQ(vti_error(with(
                with(with(kAppended, "<PointData>", "<CellData>"), "</PointData>", "</CellData>"),
                std::string("\x0c\0\0\0", 4), std::string("\x02\0\0\0", 4))),
            "");
}

TEST(VtiHeader, RefusesWhatTheFileCannotHold) {
  EXPECT_EQ(vti_error(with(kAppended, "UInt8", "Float64")),
            "file-format: a.vti: array 'a > b': states 12 bytes, 12 tuples of 1 Float64 need 96");
  const std::string huge = with(with(kAppended, "0 2 0 1 5 6", "0 9999 0 9999 0 9999"),
                                "0 2 0 1 5 6", "0 9999 0 9999 0 9999");
  EXPECT_EQ(vti_error(huge),
            "file-format: a.vti: array 'a > b': need 1000000000000 bytes, which a file of " +
                std::to_string(huge.size()) + " bytes cannot hold: is it truncated?");
  EXPECT_EQ(vti_error(with(kAppended, "0 2 0 1 5 6", "0 2000000000 0 2000000000 0 2000000000")),
            "file-format: a.vti: WholeExtent: 2000000001x2000000001x2000000001 float64 is larger "
            "than any file");
  EXPECT_EQ(vti_error(with(kAppended, "0 2 0 1 5 6", "0 2 0 1 5 60")),
            "file-format: a.vti: the pieces cover 12 of the 336 samples of WholeExtent");
  EXPECT_EQ(vti_error(with(kAppended, R"(Name="a > b")",
                           R"(Name="v" NumberOfComponents="9000000000000000000")")),
            "file-format: a.vti: array 'v': NumberOfComponents=\"9000000000000000000\": expected 1 "
            "to 1048576");
  EXPECT_EQ(vti_error(with(kAppended, R"(offset="0")", R"(offset="99999")")),
            "file-format: a.vti: array 'a > b': its data are missing: is the file truncated?");
  EXPECT_EQ(vti_error(kAppended.substr(0, kAppended.find("<AppendedData"))),
            "file-format: a.vti: array 'a > b': its data are appended, but no AppendedData follow");
  EXPECT_EQ(vti_error(kAppended.substr(0, 155)),
            "file-format: a.vti: holds no ImageData element: is the file truncated?");
}

// What VTK's parser would take for something else than this one does.
TEST(VtiHeader, RefusesWhatCouldBeReadInTwoWays) {
  EXPECT_EQ(vti_error(with(kAppended, R"(Name="a > b")", R"(NumberOfComponents="&#49;")")),
            "file-format: a.vti: DataArray: NumberOfComponents=\"&#49;\": character references are "
            "not expected here");
  EXPECT_EQ(
      vti_error("<!DOCTYPE a [<!ENTITY b \"c\">]>" + kAppended),
      "unsupported: a.vti: the declaration at byte 0 is not read: expected tags and comments");
  EXPECT_EQ(vti_error(with(kAppended, R"(format="appended")", R"(format="elsewhere")")),
            "file-format: a.vti: array 'a > b': format=\"elsewhere\": expected ascii, binary or "
            "appended");
  EXPECT_EQ(vti_error(with(kAppended, "\n_", "\nx")),
            "file-format: a.vti: AppendedData: do not begin with '_'");
}

TEST(VtiHeader, ChecksTheBlocksOfCompressedArrays) {
  const std::string zlib = with(kAppended, R"(header_type="UInt32")",
                                R"(header_type="UInt32" compressor="vtkZLibDataCompressor")");
  const auto blocks = [&](const std::string& words) {
    return vti_error(with(zlib, kStored, words));
  };
  EXPECT_EQ(blocks(std::string("\1\0\0\0\x0c\0\0\0\0\0\0\0\x05\0\0\0abcde", 21)), "");
  EXPECT_EQ(blocks(std::string("\2\0\0\0\x08\0\0\0\4\0\0\0\x05\0\0\0\5\0\0\0abcde", 25)), "");
  EXPECT_EQ(blocks(std::string("\2\0\0\0\x08\0\0\0\0\0\0\0\x05\0\0\0\5\0\0\0abcde", 25)),
            "file-format: a.vti: array 'a > b': states 16 bytes, 12 tuples of 1 UInt8 need 12");
  EXPECT_NE(blocks(std::string("\xff\xff\xff\xff\x08\0\0\0\0\0\0\0", 12))
                .find("states 4294967295 blocks of 8 bytes"),
            std::string::npos);
}

TEST(VtiHeader, OtherKindsAreUnsupported) {
  EXPECT_EQ(vti_error(with(kAppended, "ImageData", "PolyData")),
            "unsupported: a.vti: VTKFile type 'PolyData': expected ImageData");
  EXPECT_EQ(vti_error("<VTKFile type=\"ImageData\" " + std::string(70000, 'x')),
            "file-format: a.vti: the tag at byte 0 does not end");
}

const std::string kLegacy =
    "# vtk DataFile Version 3.0\ntitle\nBINARY\n\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 "
    "2\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 12\n"
    "SCALARS a b\nunsigned_char\nLOOKUP_TABLE default\n123456789012";

TEST(LegacyVtkHeader, AcceptsWhatFits) {
  const std::string plain = with(kLegacy, "a b\nunsigned_char", "a unsigned_char");
  EXPECT_EQ(vtk_error(plain), "");
  EXPECT_EQ(vtk_error(with(plain, "DIMENSIONS 3 2 2", "dimensions\n3\n2 2")), "");
  EXPECT_EQ(vtk_error(with(with(plain, "POINT_DATA 12", "CELL_DATA 2"), "BINARY", "ascii")), "");
}

TEST(LegacyVtkHeader, RefusesWhatTheFileCannotHold) {
  const std::string plain = with(kLegacy, "a b\nunsigned_char", "a unsigned_char");
  EXPECT_EQ(vtk_error(with(plain, "a unsigned_char", "a double")),
            "file-format: a.vtk: array 'a': 12 tuples of 1 double do not fit the 34 bytes behind "
            "it: is the file truncated?");
  EXPECT_EQ(vtk_error(with(plain, "unsigned_char", "unsigned_char 4")),
            "file-format: a.vtk: array 'a': 12 tuples of 4 unsigned_char do not fit the 34 bytes "
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
  EXPECT_EQ(vtk_error(with(plain, "STRUCTURED_POINTS", "POLYDATA")),
            "unsupported: a.vtk: DATASET 'polydata': expected STRUCTURED_POINTS");
  EXPECT_EQ(vtk_error(""), "file-format: a.vtk: '' after the title: expected ASCII or BINARY");
}

TEST(XmlTags, FindsTagsAcrossTheWindow) {
  // The second tag begins beyond the first MiB that is held at once.
  const std::string text =
      "<a x='1' y = \"<&gt;\"/>" + std::string(std::size_t{1} << 20, ' ') + "<b></b>";
  const auto source = open_memory("a.xml", std::as_bytes(std::span(text)));
  XmlTagReader reader(*source);
  const auto a = reader.next();
  ASSERT_TRUE(a.has_value());
  EXPECT_TRUE(a->is_empty_element);
  EXPECT_EQ(a->attribute("x"), "1");
  EXPECT_EQ(a->attribute("y"), "<&gt;");
  EXPECT_EQ(a->attribute("z", "none"), "none");
  EXPECT_EQ(reader.next()->name, "b");
  EXPECT_EQ(reader.next()->name, "/b");
  EXPECT_FALSE(reader.next().has_value());
}

}  // namespace
}  // namespace ovoid::io
