// SPDX-License-Identifier: Apache-2.0
// VTK's files as programs other than VTK write them, and what else stands in them beside numbers.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "io/core/base64.h"
#include "io/core/test_deflate.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

namespace ovoid::io {
namespace vtk_files_test {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

class VtkFiles : public testing::Test {
 protected:
  void SetUp() override {
    if (error("probe.vti", vti(kValues)).find("no VTK") != std::string::npos)
      GTEST_SKIP() << "this build has no VTK";
  }

  Dataset read(const std::string& name, const std::string& content,
               const ReadOptions& options = {}) const {
    return read_dataset({folder.write(name, content)}, options);
  }
  std::string error(const std::string& name, const std::string& content,
                    const ReadOptions& options = {}) const {
    return error_of([&] { read(name, content, options); });
  }

  // 3 x 2 x 2 samples.
  static std::string vti(const std::string& points, const std::string& cells = "",
                         const std::string& root = "", const std::string& behind = "") {
    return R"(<VTKFile type="ImageData" byte_order="LittleEndian")" + root +
           R"(><ImageData WholeExtent="0 2 0 1 0 1" Origin="1 2 3" Spacing="1 2 4">)"
           R"(<Piece Extent="0 2 0 1 0 1"><PointData>)" +
           points + "</PointData><CellData>" + cells + "</CellData></Piece></ImageData>" + behind +
           "</VTKFile>";
  }

  static std::string array(const std::string& name, const std::string& type,
                           const std::string& values) {
    return fmt::format(R"(<DataArray Name="{}" type="{}" format="ascii">{}</DataArray>)", name,
                       type, values);
  }

  // A tetrahedron whose first node has this value.
  static std::string vtu(const std::string& value, const std::string& more = "") {
    return R"(<VTKFile type="UnstructuredGrid"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1"><PointData>)" +
           (value.empty() ? "" : array("v", "Float32", value + " 2 3 4")) + more +
           R"(</PointData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>)";
  }

  static inline const std::string kValues =
      R"(<DataArray Name="v" type="Int16" format="ascii">1 2 3 4 5 6 7 8 9 10 11 12</DataArray>)";

  TestFolder folder;
};

std::vector<std::int16_t> one_to_twelve() {
  std::vector<std::int16_t> values(12);
  std::iota(values.begin(), values.end(), std::int16_t{1});
  return values;
}

// --- text among numbers -------------------------------------------------------------------------

TEST_F(VtkFiles, TextIsLeftOutWithANote) {
  const std::string names =
      R"(<Array Name="names" type="String" format="ascii">97 0 98 0</Array>)";  // ends early
  const std::string bits = array("bits", "Bit", "1 0 1 0 1 0 1 0 1 0 1 1");
  const Dataset image = read("a.vti", vti(names + kValues + bits, names));
  EXPECT_EQ(image.arrays.size(), 2U);
  EXPECT_EQ(values_of<std::int16_t>(image.array("v")), one_to_twelve());
  EXPECT_EQ(values_of<std::uint8_t>(image.array("bits")),
            (std::vector<std::uint8_t>{1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 1}));
  EXPECT_THAT(image.notes, Contains(HasSubstr("array 'names' is left out: it holds text")));
  ReadOptions options;
  options.array = "names";
  EXPECT_THAT(error("a.vti", vti(names + kValues), options),
              HasSubstr("array 'names': holds text: expected one of 'v'"));
  options.array = "v";
  EXPECT_EQ(read("a.vti", vti(names + kValues), options).array().name, "v");
  const Dataset mesh = read("a.vtu", vtu("1", names));
  EXPECT_EQ(values_of<float>(mesh.array("v")), (std::vector<float>{1, 2, 3, 4}));
  EXPECT_THAT(mesh.notes, Contains(HasSubstr("'names'")));
}

TEST_F(VtkFiles, TextInLegacyFields) {
  const auto file = [](const std::string& fields) {
    return "# vtk DataFile Version 4.2\ntitle\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 1\n"
           "ORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 4\nFIELD f 2\n" +
           fields + "v 1 4 float\n1 2 3 4\n";
  };
  for (const std::string text :
       {"n 1 4 string\na\n\nb%20c\nd\n", "n 1 4 utf8_string\na\n\nb\n\xc3\xa4\n",
        "n 1 4 variant\n6 0\n6 1\n6 2\n13 a%20b\n"}) {
    const Dataset image = read("a.vtk", file(text));
    EXPECT_EQ(values_of<float>(image.array("v")), (std::vector<float>{1, 2, 3, 4})) << text;
    EXPECT_THAT(image.notes, Contains(HasSubstr("array 'n'"))) << text;
  }
}

// --- base64 -------------------------------------------------------------------------------------

struct Base64Style {
  std::size_t width = 0;  // of a line; 0: one line
  bool has_long_sizes = false;
  bool is_apart = false;  // the header is encoded by itself
  bool is_packed = false;
  std::string line_end = "\n";
};

std::string size_words(const Base64Style& style, const std::vector<std::uint64_t>& words) {
  if (style.has_long_sizes) return bytes_of(words);
  return bytes_of(std::vector<std::uint32_t>(words.begin(), words.end()));
}

std::string base64_of(const Base64Style& style) {
  const std::string data = bytes_of(one_to_twelve());
  std::string header = size_words(style, {data.size()}), stored = data;
  if (style.is_packed) {  // in three blocks, the last of which is shorter
    const std::vector<std::string> blocks{deflated(data.substr(0, 10), 15),
                                          deflated(data.substr(10, 10), 15),
                                          deflated(data.substr(20), 15)};
    header = size_words(style, {3, 10, 4, blocks[0].size(), blocks[1].size(), blocks[2].size()});
    stored = blocks[0] + blocks[1] + blocks[2];
  }
  const std::string text = style.is_apart ? encoded_base64(header) + encoded_base64(stored)
                                          : encoded_base64(header + stored);
  if (style.width == 0) return text;
  std::string lines;
  for (std::size_t i = 0; i < text.size(); i += style.width)
    lines += text.substr(i, style.width) + style.line_end;
  return lines;
}

std::string root_of(const Base64Style& style) {
  return fmt::format(R"( header_type="{}"{})", style.has_long_sizes ? "UInt64" : "UInt32",
                     style.is_packed ? R"( compressor="vtkZLibDataCompressor")" : "");
}

std::vector<Base64Style> base64_styles() {
  std::vector<Base64Style> styles;
  for (const std::size_t width : {0U, 7U, 76U}) {
    for (unsigned i = 0; i < 8; ++i) {
      styles.push_back(
          {width, (i & 1U) != 0, (i & 2U) != 0, (i & 4U) != 0, i % 3 == 0 ? "\r\n   " : "\n"});
    }
  }
  return styles;
}

// VTK 9.1 alone leaves what lies behind a line end as memory happens to be.
TEST_F(VtkFiles, Base64InLinesAndInPieces) {
  for (const Base64Style& style : base64_styles()) {
    const std::string what =
        fmt::format("width {}, long sizes {}, apart {}, packed {}", style.width,
                    style.has_long_sizes, style.is_apart, style.is_packed);
    const std::string text = base64_of(style);
    const std::string within = R"(<DataArray Name="v" type="Int16" format="binary">)" + text +
                               "</DataArray>" + array("w", "UInt8", "1 2 3 4 5 6 7 8 9 10 11 12");
    const Dataset image = read("a.vti", vti(within, "", root_of(style)));
    EXPECT_EQ(values_of<std::int16_t>(image.array("v")), one_to_twelve()) << what;
    EXPECT_EQ(image.arrays.size(), 2U) << what;
    // Appended, offsets counted with the line ends. VTK knows no compressed arrays whose header is
    // not apart, and here is no room to put them right.
    if (style.is_packed && !style.is_apart) continue;
    const std::string two =
        fmt::format(R"(<DataArray Name="v" type="Int16" format="appended" offset="0"/>)"
                    R"(<DataArray Name="w" type="Int16" format="appended" offset="{}"/>)",
                    text.size());
    const Dataset appended = read(
        "b.vti", vti(two, "", root_of(style),
                     R"(<AppendedData encoding="base64">_)" + text + text + "</AppendedData>"));
    EXPECT_EQ(values_of<std::int16_t>(appended.array("v")), one_to_twelve()) << what;
    EXPECT_EQ(values_of<std::int16_t>(appended.array("w")), one_to_twelve()) << what;
  }
}

TEST_F(VtkFiles, AppendedOffsetsMayPassOverLineEnds) {
  Base64Style style;
  const std::string one = base64_of(style);
  const std::string all = one + one;
  std::string lines;
  for (std::size_t i = 0; i < all.size(); i += 10) lines += all.substr(i, 10) + "\n";
  const std::string two =
      fmt::format(R"(<DataArray Name="v" type="Int16" format="appended" offset="0"/>)"
                  R"(<DataArray Name="w" type="Int16" format="appended" offset="{}"/>)",
                  one.size());
  const Dataset image = read("a.vti", vti(two, "", root_of(style),
                                          R"(<AppendedData encoding="base64">
  _)" + lines + "</AppendedData>"));
  EXPECT_EQ(values_of<std::int16_t>(image.array("v")), one_to_twelve());
  EXPECT_EQ(values_of<std::int16_t>(image.array("w")), one_to_twelve());
}

TEST_F(VtkFiles, Base64ThatEndsEarlyIsAnError) {
  Base64Style style;
  style.width = 16;
  const std::string text = base64_of(style);
  EXPECT_THAT(error("a.vti", vti(R"(<DataArray Name="v" type="Int16" format="binary">)" +
                                     text.substr(0, text.size() - 6) + "</DataArray>",
                                 "", root_of(style))),
              HasSubstr("array 'v': holds 22 bytes, its header says 24: is the file truncated?"));
}

// --- samples that are hidden --------------------------------------------------------------------

TEST_F(VtkFiles, HiddenSamplesAreMissing) {
  const std::string ghosts = array("vtkGhostType", "UInt8", "2 0 0 1 0 0 0 0 0 0 0 0");
  const std::string cells = array("c", "Int32", "7 8");
  ReadOptions options;
  options.array = "v";
  for (const ReadOptions& wanted : {ReadOptions(), options}) {
    const Dataset image = read("a.vti", vti(kValues + ghosts, cells), wanted);
    EXPECT_EQ(image.arrays.size(), wanted.array.empty() ? 2U : 1U);
    const auto values = values_of<float>(image.array("v"));
    EXPECT_TRUE(std::isnan(values[0]));
    EXPECT_EQ(std::vector(values.begin() + 1, values.end()),
              (std::vector<float>{2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
    EXPECT_THAT(image.notes, Contains(HasSubstr("1 samples and 1 cells are hidden")));
    if (!wanted.array.empty()) continue;
    // The cell at the hidden corner is not seen either; int32 needs float64.
    const auto of_cells = values_of<double>(image.array("c"));
    EXPECT_TRUE(std::isnan(of_cells[0]));
    EXPECT_EQ(of_cells[1], 8);
  }
  // Duplicates are values like others.
  const Dataset shared =
      read("b.vti", vti(kValues + array("vtkGhostType", "UInt8", "1 1 0 0 0 0 0 0 0 0 0 0")));
  EXPECT_EQ(values_of<std::int16_t>(shared.array()), one_to_twelve());
  EXPECT_EQ(shared.arrays.size(), 1U);
  EXPECT_THAT(error("c.vti", vti(ghosts)), HasSubstr("no array of numbers"));
}

// A hidden cell takes those samples with it that no other cell has: here x = 0.
TEST_F(VtkFiles, HiddenCellsAreMissing) {
  const Dataset image = read(
      "a.vti", vti(kValues, array("c", "Float32", "7 8") + array("vtkGhostType", "UInt8", "32 0")));
  const auto cells = values_of<float>(image.array("c"));
  EXPECT_TRUE(std::isnan(cells[0]));
  EXPECT_EQ(cells[1], 8);
  const auto values = values_of<float>(image.array("v"));
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(std::isnan(values[i]), i % 3 == 0) << i;
}

TEST_F(VtkFiles, HiddenSamplesOfPieces) {
  const auto piece = [&](const std::string& name, const std::string& extent,
                         const std::string& values, const std::string& ghosts) {
    folder.write(name, R"(<VTKFile type="ImageData"><ImageData WholeExtent=")" + extent +
                           R"(" Origin="0 0 0" Spacing="1 1 1"><Piece Extent=")" + extent +
                           R"("><PointData>)" + array("v", "UInt8", values) +
                           (ghosts.empty() ? "" : array("vtkGhostType", "UInt8", ghosts)) +
                           "</PointData></Piece></ImageData></VTKFile>");
  };
  piece("a.vti", "0 2 0 0 0 0", "1 2 9", "2 0 1");
  piece("b.vti", "2 3 0 0 0 0", "3 4", "");
  const Dataset image = read("a.pvti", R"(<VTKFile type="PImageData">
<PImageData WholeExtent="0 3 0 0 0 0" GhostLevel="0"><Piece Extent="0 2 0 0 0 0" Source="a.vti"/>
<Piece Extent="2 3 0 0 0 0" Source="b.vti"/></PImageData></VTKFile>)");
  const auto values = values_of<float>(image.array());
  ASSERT_EQ(values.size(), 4U);
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_EQ(std::vector(values.begin() + 1, values.end()), (std::vector<float>{2, 3, 4}));
  EXPECT_EQ(image.arrays.size(), 1U);
}

TEST_F(VtkFiles, GhostLevelsOfOldFilesAreDuplicates) {
  const std::string levels = R"(<CellData><DataArray Name="vtkGhostLevels" type="UInt8"
format="ascii">1</DataArray></CellData><Points>)";
  for (const char* const version : {"0.1", "2.0"}) {
    const std::string content = with(with(vtu("1"), "<Points>", levels), "<VTKFile ",
                                     fmt::format("<VTKFile version=\"{}\" ", version));
    EXPECT_THAT(error("a.vtu", content), HasSubstr("all 1 cells or points are hidden")) << version;
  }
}

// --- sets ---------------------------------------------------------------------------------------

TEST_F(VtkFiles, PartitionedCollections) {
  folder.write("a.vtu", vtu("1"));
  folder.write("b.vtu", with(vtu("5"), "0 0 0 1 0 0 0 1 0 0 0 1", "9 0 0 8 0 0 9 1 0 9 0 1"));
  const std::string both = R"(<DataSet index="0" file="a.vtu"/><DataSet index="1" file="b.vtu"/>)";
  const Dataset all = read("a.vtpc", R"(<?xml version="1.0"?>
<VTKFile type="vtkPartitionedDataSetCollection" version="1.0"><vtkPartitionedDataSetCollection>
<Partitions index="0" name="solid">)" + both +
                                         R"(</Partitions><Partitions index="1"/>
<Partitions index="2"><DataSet index="0" file="b.vtu"/></Partitions>
<DataAssembly encoding="base64">PD94bWw=</DataAssembly>
</vtkPartitionedDataSetCollection></VTKFile>)");
  EXPECT_EQ(all.format, "VTPC");
  ASSERT_EQ(all.blocks.size(), 2U);
  EXPECT_EQ(all.blocks[0].name, "solid");
  EXPECT_EQ(all.blocks[0].description, "8 points, 2 cells");
  EXPECT_EQ(all.blocks[1].name, "2");
  const Dataset pieces =
      read("a.vtpd", R"(<VTKFile type="vtkPartitionedDataSet"><vtkPartitionedDataSet>)" + both +
                         "</vtkPartitionedDataSet></VTKFile>");
  EXPECT_EQ(pieces.format, "VTPD");
  EXPECT_TRUE(pieces.blocks.empty());
  EXPECT_EQ(pieces.cells.count(), 2);
  // Pieces of one block of blocks.
  const Dataset blocks = read(
      "a.vtm",
      R"(<VTKFile type="vtkMultiBlockDataSet"><vtkMultiBlockDataSet><Piece index="0" name="p">)" +
          both + R"(</Piece><DataSet index="1" file="a.vtu"/></vtkMultiBlockDataSet></VTKFile>)");
  ASSERT_EQ(blocks.blocks.size(), 2U);
  EXPECT_EQ(blocks.blocks[0].name, "p");
  EXPECT_EQ(blocks.blocks[0].description, "8 points, 2 cells");
  EXPECT_EQ(blocks.blocks[1].name, "1");
}

TEST_F(VtkFiles, FileSeries) {
  folder.write("a.vtu", vtu("1"));
  folder.write("b.vtu", vtu("5"));
  folder.write("c.vtm", R"(<VTKFile type="vtkMultiBlockDataSet"><vtkMultiBlockDataSet>
<DataSet index="0" file="b.vtu"/></vtkMultiBlockDataSet></VTKFile>)");
  const auto series = [](const std::string& files) {
    return R"({ "files": [)" + files + R"(], "file-series-version" : "1.0" })";
  };
  const std::string path =
      folder.write("mesh.vtm.series",
                   series(R"({"name": "c.vtm", "time": 0.5}, {"name": "./a.vtu", "time": -1})"));
  const auto steps = open_steps({path});
  EXPECT_EQ(steps->num_steps(), 2);
  EXPECT_EQ(steps->times(), (std::vector<double>{-1, 0.5}));
  EXPECT_EQ(values_of<float>(steps->read(0, {}).array("v"))[0], 1);
  EXPECT_EQ(values_of<float>(steps->read(1, {}).array("v"))[0], 5);
  EXPECT_EQ(files_read_for(path),
            (std::vector{path, folder.file("a.vtu"), folder.file("c.vtm"), folder.file("b.vtu")}));
  // Without times, or under another name.
  EXPECT_EQ(read("a.json", R"({"file-series-version": "1.0", "files": [{"name": "a.vtu"}]})")
                .array("v")
                .num_tuples,
            4);
  EXPECT_TRUE(read("b.series", series(R"({"name": "a.vtu"}, {"name": "b.vtu"})")).times.empty());

  const auto refusal = [&](const std::string& files) { return error("e.series", series(files)); };
  EXPECT_THAT(refusal(R"({"name": "a.vtu", "time": 0}, {"name": "z.vtu", "time": 1})"),
              HasSubstr("e.series: names a step that cannot be read: "));
  EXPECT_THAT(refusal(R"({"name": "e.series"})"), HasSubstr("a file series within a file series"));
  EXPECT_THAT(refusal(R"({"name": "../../a.vtu"})"), Not(HasSubstr("series within")));
  EXPECT_THAT(refusal(""), HasSubstr("files = []: expected at least one file"));
  EXPECT_THAT(refusal(R"({"time": 1})"), HasSubstr("files[0]: has no member name"));
  EXPECT_THAT(refusal(R"({"name": 5})"), HasSubstr("files[0].name = 5: must be a string"));
  EXPECT_THAT(error("e.series", "{"), HasSubstr("not JSON at byte"));
}

TEST_F(VtkFiles, MeshesWithoutArrays) {
  const Dataset mesh = read("a.vtu", vtu(""));
  EXPECT_EQ(mesh.kind, DatasetKind::kMesh);
  EXPECT_EQ(mesh.cells.count(), 1);
  EXPECT_THAT(mesh.notes, Contains(HasSubstr("its surface can be drawn, without values")));
}

}  // namespace vtk_files_test
}  // namespace ovoid::io
