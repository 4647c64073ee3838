// SPDX-License-Identifier: Apache-2.0
#include "io/formats.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <string>

#include "io/core/test_folder.h"
#include "io/foreign/foreign_readers.h"
#include "io/reader/reader_program.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace formats_test {

using Endings = std::set<std::string>;
using Row = std::vector<std::string>;  // the cells of a table's row

// The rows of the table in docs/formats.md whose first line begins so.
std::vector<Row> table_of_docs(const std::string& head) {
  std::ifstream page(OVOID_SOURCE_DIR "/docs/formats.md");
  std::vector<Row> rows;
  bool is_inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with(head)) is_inside = true;
    if (!line.starts_with("|")) is_inside = false;
    if (!is_inside || line.starts_with(head) || line.starts_with("|---")) continue;
    Row& row = rows.emplace_back();
    for (std::size_t at = 1, end = 0; (end = line.find('|', at)) != std::string::npos; at = end + 1)
      row.push_back(line.substr(at + 1, end - at - 2));
  }
  return rows;
}

// The endings that stand in a cell: "`.nii`, `.nii.gz`".
Endings endings_in(const std::string& cell) {
  Endings endings;
  for (std::size_t at = 0; (at = cell.find("`.", at)) != std::string::npos;) {
    const std::size_t end = cell.find('`', at + 1);
    endings.insert(cell.substr(at + 1, end - at - 1));
    at = end;
  }
  return endings;
}

struct Documented {
  Endings read;
  bool is_written = false;
};

// By format: the text of the first cell up to a colon.
std::map<std::string, Documented> documented_formats() {
  std::map<std::string, Documented> formats;
  for (const Row& row : table_of_docs("| format | endings |")) {
    if (row[2] == "no" || row[0].starts_with("look") || row[0].starts_with("camera")) continue;
    Documented& format = formats[row[0].substr(0, row[0].find(':'))];
    format.read.merge(endings_in(row[1]));
    format.is_written = format.is_written || row[3] != "no";
  }
  return formats;
}

// Fails if a format, an ending or a writer is in the program and not in docs/formats.md, or the
// other way round.
TEST(Formats, AreThoseOfTheDocs) {
  const auto documented = documented_formats();
  EXPECT_EQ(documented.size(), formats().size());
  Endings written;
  for (const Format& format : formats()) {
    SCOPED_TRACE(format.name);
    ASSERT_TRUE(documented.contains(format.name));
    const Documented& docs = documented.at(format.name);
    EXPECT_EQ(Endings(format.endings.begin(), format.endings.end()), docs.read);
    EXPECT_EQ(!format.writers.empty(), docs.is_written);
    for (const FormatWriter& writer : format.writers)
      written.insert(writer.endings.begin(), writer.endings.end());
  }
  Endings in_docs;
  for (const Row& row : table_of_docs("| ending | content | what is lost |"))
    in_docs.merge(endings_in(row[0]));
  EXPECT_EQ(written, in_docs);
}

// Fails if two formats claim an ending, or two writers do: the first would win silently.
TEST(Formats, ShareNoEnding) {
  Endings read, written;
  for (const Format& format : formats()) {
    for (const std::string_view ending : format.endings)
      EXPECT_TRUE(read.emplace(ending).second) << ending;
    for (const FormatWriter& writer : format.writers)
      for (const std::string_view ending : writer.endings)
        EXPECT_TRUE(written.emplace(ending).second) << ending;
  }
}

// Fails if a row names a reader of ovoid-read's that is not there.
TEST(Formats, HaveAReader) {
  const TestFolder folder;
  for (const Format& format : formats()) {
    if (format.library == nullptr) {
      EXPECT_TRUE(format.read != nullptr || format.name == std::string_view("PLOT3D") ||
                  format.name == std::string_view("folder of slices"));
      continue;
    }
    if (reader_program_of(format.name) != "ovoid-read") continue;  // io/vdb/vdb_test.cpp
    ReaderRequest request;
    request.format = format.name;
    request.source = "FILE";
    request.paths = {folder.file("missing")};
    std::string message;
    try {
      read_here(request);
    } catch (const Error& error) {
      message = error.what();
    }
    const bool is_there = message.find("no such file") != std::string::npos;
    EXPECT_EQ(is_there, has_library(format.library)) << message;
  }
}

// A format's name decides only where its content does not.
TEST(Formats, AreToldByContentFirst) {
  const TestFolder folder;
  const auto name_of_format = [&](const std::string& name, const std::string& content) {
    folder.write(name, content);
    const Format* const format = format_of(*open_file(folder.file(name)), {});
    return format == nullptr ? std::string("none") : std::string(format->name);
  };
  EXPECT_EQ(name_of_format("a.csv", "NRRD0001\n"), "NRRD");
  EXPECT_EQ(name_of_format("b_2x2x2_uint8.dat", "12345678"), "raw");
  EXPECT_EQ(name_of_format("c.dat", "1 2 3\n"), "CSV and other text");
  EXPECT_EQ(name_of_format("d.case", "FORMAT"), "EnSight");
  EXPECT_EQ(name_of_format("d", "<?xml version=\"1.0\"?>\n<Xdmf>"), "XDMF");
  EXPECT_EQ(name_of_format("d.xmf", "<?xml version=\"1.0\"?>\n<!-- by"), "XDMF");
  EXPECT_EQ(name_of_format("e.vti", "\xef\xbb\xbf <VTKFile type"), "VTK XML");
  EXPECT_EQ(name_of_format("f.ex2", "\x89HDF\r\n\x1a\n VTKHDF"), "Exodus");
  EXPECT_EQ(name_of_format("g", "\x89HDF\r\n\x1a\n VTKHDF"), "VTKHDF");
  EXPECT_EQ(name_of_format("h", "\x89HDF\r\n\x1a\n"), "HDF5");
  EXPECT_EQ(name_of_format("i.vti", "nothing"), "none");
  EXPECT_EQ(name_of_format("j.ex2", "CDF\x01 cut"), "Exodus");
  EXPECT_EQ(name_of_format("j", "CDF\x01 cut"), "netCDF");
}

}  // namespace formats_test
}  // namespace ovoid::io
