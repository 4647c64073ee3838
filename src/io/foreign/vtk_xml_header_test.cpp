// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vtk_header.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "io/core/test_deflate.h"
#include "io/core/xml_tags.h"
#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace vtk_xml_header_test {

std::string vti_error(const std::string& content) {
  return error_of([&] { check_vtk_xml(*open_memory("a.vti", std::as_bytes(std::span(content)))); });
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

// The array's data within its tags.
std::string inline_data(const std::string& format, const std::string& data,
                        const std::string& type = "UInt8") {
  const std::string name = with(with(kAppended, "a > b", "v"), "UInt8", type);
  return with(name, R"(format="appended" offset="0"/>)",
              "format=\"" + format + "\">" + data + "</DataArray>");
}

// The count 12 in base64 is DAAAAA==.
const std::string kBase64 = "DAAAADEyMzQ1Njc4OTAxMg==";

TEST(VtiHeader, AcceptsWhatFits) {
  EXPECT_EQ(vti_error(kAppended), "");
  EXPECT_EQ(vti_error(inline_data("ascii", "1 2 3 4 5 6 7 8 9 1 2 3")), "");
  EXPECT_EQ(vti_error(inline_data("binary", "\n     " + kBase64)), "");
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
            "file-format: a.vti: the pieces cover 2 of the 110 cells of WholeExtent");
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

// A cut file of megabytes must be told from a whole one by its last byte.
TEST(VtiHeader, RefusesDataThatEndEarly) {
  const std::string raw = kAppended.substr(0, kAppended.find("</AppendedData>"));
  EXPECT_EQ(vti_error(raw), "");
  EXPECT_EQ(vti_error(raw.substr(0, raw.size() - 1)),
            "file-format: a.vti: array 'a > b': holds 11 bytes, its header says 12: is the file "
            "truncated?");
  const std::string zlib =
      with(with(raw, R"(header_type="UInt32")",
                R"(header_type="UInt32" compressor="vtkZLibDataCompressor")"),
           kStored, std::string("\1\0\0\0\x0c\0\0\0\0\0\0\0\x05\0\0\0abcde", 21));
  EXPECT_EQ(vti_error(zlib), "");
  EXPECT_EQ(vti_error(zlib.substr(0, zlib.size() - 2)),
            "file-format: a.vti: array 'a > b': holds 3 bytes, its header says 5: is the file "
            "truncated?");
  const std::string base64 = with(with(raw, "\"raw\"", "\"base64\""), kStored, kBase64);
  EXPECT_EQ(vti_error(base64), "");
  EXPECT_EQ(vti_error(base64.substr(0, base64.size() - 4)),
            "file-format: a.vti: array 'a > b': holds 11 bytes, its header says 12: is the file "
            "truncated?");
}

TEST(VtiHeader, RefusesTextThatDoesNotHoldItsArray) {
  EXPECT_EQ(vti_error(inline_data("binary", kBase64.substr(0, 12) + "\n" + kBase64.substr(12))),
            "file-format: a.vti: array 'v': holds 5 bytes, its header says 12: is the file "
            "truncated?");
  EXPECT_EQ(vti_error(inline_data("binary", kBase64.substr(0, 18))),
            "file-format: a.vti: array 'v': holds 9 bytes, its header says 12: is the file "
            "truncated?");
  EXPECT_EQ(vti_error(inline_data("ascii", "1 2 3 4 5 6 7 8 9 10 11                ")),
            "file-format: a.vti: array 'v': holds 11 numbers, 12 tuples of 1 UInt8 need more");
  EXPECT_EQ(vti_error(inline_data("ascii", "1 2 3 4.5 5 6 7 8 9 10 11 12")),
            "file-format: a.vti: array 'v': '4.5' after 3 numbers: expected 12 tuples of 1 UInt8");
  EXPECT_EQ(vti_error(inline_data("ascii", "1 2 3 4.5 5 6 7 8 NaN -10 1e1 .5", "Float32")), "");
  EXPECT_EQ(vti_error(inline_data("ascii", "1 2 3")),
            "file-format: a.vti: array 'v': 5 bytes of text cannot hold 12 tuples of 1 UInt8");
  // Many values in little text, as zeros are.
  EXPECT_EQ(vti_error(inline_data("ascii", "0 0 0 0 0 0 0 0 0 0 0 0", "Float64")), "");
}

// VTK would leave the samples of no piece as memory happens to be.
TEST(VtiHeader, RefusesPiecesThatDoNotTileTheExtent) {
  const auto pieces = [](const std::string& extents) {
    std::string text = kAppended;
    const std::string piece = R"(<Piece Extent="0 2 0 1 5 6"/>)";
    text = text.substr(0, text.find("<Piece"));
    for (std::size_t i = 0; i < extents.size(); i += 4)
      text += with(piece, "0 2", extents.substr(i, 3));
    return vti_error(text + "</ImageData></VTKFile>");
  };
  EXPECT_EQ(pieces("0 2"), "");
  EXPECT_EQ(pieces("0 1,1 2"), "");
  EXPECT_EQ(pieces("0 1,1 2,2 1"), "");  // an empty one
  EXPECT_EQ(pieces("4 6"),
            "file-format: a.vti: Piece Extent=\"4 6 0 1 5 6\": lies outside WholeExtent");
  EXPECT_EQ(pieces("0 1,0 1"), "file-format: a.vti: pieces 0 and 1 overlap");
  EXPECT_EQ(pieces("0 1,2 2"),
            "file-format: a.vti: the pieces cover 1 of the 2 cells of WholeExtent");
}

// VTK would take its defaults instead.
TEST(VtiHeader, RefusesPlacesThatAreNoNumbers) {
  EXPECT_EQ(vti_error(with(kAppended, R"(Spacing="1 1 1")", R"(Spacing="nan 1 1")")),
            "file-format: a.vti: Spacing=\"nan 1 1\": expected 3 numbers");
  EXPECT_EQ(vti_error(with(kAppended, R"(Spacing="1 1 1")", R"(Spacing="3 2")")),
            "file-format: a.vti: Spacing=\"3 2\": expected 3 numbers");
  EXPECT_EQ(vti_error(with(kAppended, R"(Origin="0 0 0")", R"(Origin="inf 0 0")")),
            "file-format: a.vti: Origin=\"inf 0 0\": expected 3 numbers");
  EXPECT_EQ(vti_error(with(kAppended, R"(Origin="0 0 0")", R"(Direction="1 0 0")")),
            "file-format: a.vti: Direction=\"1 0 0\": expected 9 numbers");
}

// VTK is told to leave text out, so that nothing of it has to be right.
TEST(VtiHeader, TellsWhichArraysAreText) {
  const auto texts = [](const std::string& content) {
    return check_vtk_xml(*open_memory("a.vti", std::as_bytes(std::span(content)))).texts;
  };
  const auto of_points = texts(inline_data("ascii", "", "String"));
  ASSERT_EQ(of_points.size(), 1U);
  EXPECT_EQ(of_points[0].name, "v");
  EXPECT_FALSE(of_points[0].is_cell_data);
  const auto of_cells = texts(with(kAppended, "</PointData>",
                                   R"(</PointData><CellData><Array Name="&lt;" type="String" )"
                                   R"(format="ascii">65</Array></CellData>)"));
  ASSERT_EQ(of_cells.size(), 1U);
  EXPECT_EQ(of_cells[0].name, "<");
  EXPECT_TRUE(of_cells[0].is_cell_data);
  EXPECT_EQ(vti_error(inline_data("ascii", "", "Variant")),
            "unsupported: a.vti: array 'v': type 'Variant': expected String, Bit or a type of "
            "numbers");
  EXPECT_TRUE(texts(kAppended).empty());
  EXPECT_EQ(vti_error(with(kAppended, "<Piece",
                           R"(<FieldData><Array type="String" Name="t" format="ascii">65 0</Array>)"
                           "</FieldData><Piece")),
            "");
  EXPECT_EQ(vti_error(inline_data("ascii", "1 0 1 0 1 0 1 0 1 0 1 0", "Bit")), "");
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
  EXPECT_EQ(vti_error(with(inline_data("ascii", "1 2 3 4 5 6 7 8 9 1 2 3"), "\"v\"", "\"v>w\"")),
            "file-format: a.vti: DataArray: Name=\"v>w\": expected '&gt;' for '>' where the data "
            "are within the tags");
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

// VTK allocates as many node numbers as the last offset says, which a compressor hides.
TEST(VtuHeader, TheLastOffsetIsReadThroughZlib) {
  const auto error = [](const std::vector<std::int32_t>& offsets) {
    // Two blocks of one offset each: number, size, size of a shorter last one, compressed sizes.
    const std::string first = deflated(bytes_of(std::vector{offsets[0]}), 15);
    const std::string second = deflated(bytes_of(std::vector{offsets[1]}), 15);
    const std::vector<std::uint32_t> header{2, 4, 0, static_cast<std::uint32_t>(first.size()),
                                            static_cast<std::uint32_t>(second.size())};
    const std::string content =
        R"(<VTKFile type="UnstructuredGrid" byte_order="LittleEndian" )"
        R"(compressor="vtkZLibDataCompressor"><UnstructuredGrid>)"
        R"(<Piece NumberOfPoints="2" NumberOfCells="2"><Points>)"
        R"(<DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 1 0 0</DataArray>)"
        R"(</Points><Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1</DataArray>)"
        R"(<DataArray type="Int32" Name="offsets" format="appended" offset="0"/>)"
        R"(<DataArray type="UInt8" Name="types" format="ascii">1 1</DataArray></Cells></Piece>)"
        R"(</UnstructuredGrid><AppendedData encoding="raw">_)" +
        bytes_of(header) + first + second + "</AppendedData></VTKFile>";
    return error_of(
        [&] { check_vtk_xml(*open_memory("a.vtu", std::as_bytes(std::span(content)))); });
  };
  EXPECT_EQ(error({1, 2}), "");
  EXPECT_EQ(
      error({1, 3}),
      "file-format: a.vtu: array 'connectivity': 3 bytes of text cannot hold 3 node numbers of 8 "
      "bytes");
  EXPECT_EQ(error({1, 2000000000}),
            "file-format: a.vtu: array 'connectivity': 3 bytes of text cannot hold 2000000000 node "
            "numbers of 8 bytes");
}

TEST(VtiHeader, OtherKindsAreUnsupported) {
  EXPECT_EQ(vti_error(with(kAppended, "ImageData", "HyperTreeGrid")),
            "unsupported: a.vti: VTKFile type 'HyperTreeGrid': expected ImageData, "
            "RectilinearGrid, StructuredGrid, UnstructuredGrid or PolyData");
  EXPECT_EQ(vti_error("<VTKFile type=\"ImageData\" " + std::string(70000, 'x')),
            "file-format: a.vti: the tag at byte 0 does not end");
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

}  // namespace vtk_xml_header_test
}  // namespace ovoid::io
