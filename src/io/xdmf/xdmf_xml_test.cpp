// SPDX-License-Identifier: Apache-2.0
// What an XDMF file may say in XML. What would make it fail: a form that writers use and the reader
// does not, a path that costs more than a look at each element.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io/images/test_volumes.h"
#include "io/read_source.h"
#include "io/xdmf/test_xdmf.h"
#include "io/xdmf/xdmf.h"

namespace ovoid::io {
namespace xdmf_xml_test {

using testing::HasSubstr;

const std::string kValues = xdmf_attribute("f", xdmf_item("2 3 4", xdmf_counting(24)));
const std::string kFile = xdmf_file(xdmf_grid(kXdmfEven + kValues));

Dataset read_text(const std::string& content, const MemoryFiles& files = {}) {
  return read_source(*open_memory("a.xmf", std::as_bytes(std::span(content))), {}, files.opener());
}

void expect_the_values(const std::string& content) {
  const Dataset dataset = read_text(content);
  EXPECT_EQ(values_of<float>(dataset.array()), counting<float>(24)) << content;
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(10, 20, 30));
}

TEST(XdmfXml, CdataIsText) {
  expect_the_values(
      with(kFile, "<Topology",
           "<Information Name=\"i\"><![CDATA[<main a='&b;'>]]></Information><Topology"));
  expect_the_values(with(kFile, xdmf_counting(24), "<![CDATA[" + xdmf_counting(24) + "]]>"));
  expect_the_values(
      with(kFile, xdmf_counting(24), with(xdmf_counting(24), "7 8", "<![CDATA[7 ]]> 8")));
}

TEST(XdmfXml, CommentsAndInstructionsMayStandAnywhere) {
  expect_the_values(with(kFile, "<Xdmf", "<!-- <Xdmf> --><?look at=\"this\"?>\n<Xdmf"));
  expect_the_values(with(kFile, "<Topology", "<?a?><!-- - --><Topology"));
  expect_the_values(
      with(kFile, xdmf_counting(24), with(xdmf_counting(24), "7 8", "7 <!-- > 1 2 --> 8")));
  expect_the_values(with(kFile, "</Xdmf>", "</Xdmf><!-- the end -->"));
}

TEST(XdmfXml, EntitiesOfXmlAreLetters) {
  expect_the_values(with(kFile, xdmf_counting(24), with(xdmf_counting(24), "7 8", "7&#32;&#x38;")));
  const Dataset dataset = read_text(with(kFile, "\"f\"", "\"&lt;f&#x3e; &amp;amp;\""));
  EXPECT_EQ(dataset.arrays[0].name, "<f> &amp;");
}

TEST(XdmfXml, EntitiesOfTheFileArePutIn) {
  const auto declared = [](const std::string& declarations, const std::string& file) {
    return with(file, "[]", "[\n" + declarations + "\n]");
  };
  expect_the_values(declared("<!ENTITY origin \"30 20 10\">", with(kFile, "30 20 10", "&origin;")));
  expect_the_values(declared("<!ENTITY dims '2 3 4'>", with(kFile, "\"2 3 4\"", "\"&dims;\"")));
  expect_the_values(
      declared("<!ENTITY shape '" + kXdmfEven + "'>", with(kFile, kXdmfEven, "&shape;")));
  MemoryFiles files;
  files.files["b.bin"] = bytes_of(counting<float>(24));
  const std::string raw = with(with(kFile, xdmf_counting(24), "&HeavyData;"), "\"2 3 4\" >",
                               "\"2 3 4\" Format=\"Binary\">");
  EXPECT_EQ(
      values_of<float>(read_text(declared("<!ENTITY HeavyData \"b.bin\">", raw), files).array()),
      counting<float>(24));
  const auto source = open_memory("a.xmf", std::as_bytes(std::span(raw)));
  EXPECT_EQ(error_of([&] { read_text(declared("<!ENTITY HeavyData SYSTEM \"b.bin\">", raw)); }),
            "unsupported: a.xmf: the entity '&HeavyData;' stands for 'b.bin', another file, which "
            "is not read");
}

TEST(XdmfXml, PrefixesAreLeftOut) {
  std::string prefixed = kFile;
  for (const char* const name : {"Grid", "Attribute", "Topology", "Geometry"}) {
    prefixed = with(prefixed, std::string("<") + name, std::string("<x:") + name);
    if (name != std::string("Topology"))
      prefixed = with(prefixed, std::string("</") + name, std::string("</x:") + name);
  }
  expect_the_values(prefixed);
}

// Writers count elements where others name them.
TEST(XdmfXml, PointersOfEitherForm) {
  const std::string grids = xdmf_grid(kXdmfEven + kValues, "Name=\"a\"");
  for (const char* const pointer :
       {"xpointer(//Grid[@Name='a']/*[self::Topology or self::Geometry])",
        "xpointer(//Grid[@Name=&quot;a&quot;]/*[position()=1 or position()=2])",
        "xpointer(/Xdmf/Domain/Grid[1]/*[self::Geometry or self::Topology])"}) {
    const std::string include = std::string("<xi:include xpointer=\"") + pointer + "\"/>";
    expect_the_values(xdmf_file(grids + xdmf_grid(include + kValues)));
  }
  const std::string counted =
      "<xi:include xpointer=\"element(/1/1/1/1)\"/><xi:include xpointer=\"element(/1/1/1/2)\"/>";
  const std::string file = xdmf_file(grids + xdmf_grid(counted + kValues, "Name=\"b\""));
  ReadOptions options;
  options.block = "b";
  const Dataset dataset =
      read_source(*open_memory("a.xmf", std::as_bytes(std::span(file))), options, open_file);
  EXPECT_EQ(dataset.block, "b");
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
}

// A file of each step, and one that names them.
TEST(XdmfXml, OtherFilesAreIncluded) {
  MemoryFiles files;
  std::string includes;
  for (const char* const step : {"1", "2"}) {
    const std::string name = std::string("s") + step + ".xmf";
    const std::string grid = kXdmfEven + "<Time Value=\"" + step + "\"/>" + kValues;
    files.files[name] = xdmf_file(xdmf_grid(grid));
    files.files[std::string("g") + step] = xdmf_grid(grid);
    includes += "<xi:include href=\"" + name + "\" xpointer=\"xpointer(//Xdmf/Domain/Grid)\"/>";
  }
  const std::string series = "GridType=\"Collection\" CollectionType=\"Temporal\"";
  const std::string file = xdmf_file(xdmf_grid(includes, series));
  const Dataset dataset = read_text(file, files);
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_EQ(dataset.times, (std::vector<double>{1, 2}));
  EXPECT_EQ(values_of<float>(dataset.array()), counting<float>(24));
  // A file that is no more than a grid, and a part of one.
  EXPECT_EQ(read_text(xdmf_file("<xi:include href=\"g1\"/>"), files).times,
            (std::vector<double>{1}));
  const std::string shape =
      "<xi:include href=\"s1.xmf\" xpointer=\"xpointer(//Grid/*[self::Topology or "
      "self::Geometry])\"/>";
  EXPECT_EQ(read_text(xdmf_file(xdmf_grid(shape + kValues)), files).lattice.dims,
            (Index3{4, 3, 2}));
  EXPECT_THAT(error_of([&] { read_text(with(file, "s2.xmf", "s3.xmf"), files); }),
              HasSubstr("s3.xmf: no such file"));
  EXPECT_THAT(error_of([&] { read_text(with(file, "Domain/Grid", "Domain/Gird"), files); }),
              HasSubstr("'xpointer(//Xdmf/Domain/Gird)' is not in s1.xmf"));
  // One that includes itself.
  files.files["a.xmf"] =
      xdmf_file(xdmf_grid("<xi:include href=\"a.xmf\" "
                          "xpointer=\"xpointer(//Grid)\"/>",
                          "GridType=\"Tree\""));
  EXPECT_THAT(error_of([&] { read_text(files.files["a.xmf"], files); }), HasSubstr("is too deep"));
}

TEST(XdmfXml, PathsThatCostMuchAreRefused) {
  const std::string item = xdmf_item("2 3 4", xdmf_counting(24), "Name=\"kept\"");
  const auto error = [&](const std::string& path) {
    const std::string reference = "<DataItem Reference=\"XML\">" + path + "</DataItem>";
    const std::string file =
        xdmf_file(item + xdmf_grid(kXdmfEven + xdmf_attribute("f", reference)));
    return error_of([&] { read_text(file); });
  };
  EXPECT_EQ(error("//DataItem[@Name='kept']"), "");
  EXPECT_EQ(error("//DataItem[@Name='kept' and @Dimensions='2 3 4'][1]"), "");
  for (const char* const path :
       {"//*[count(//*) > 1]", "//*//*", "/Xdmf/../Xdmf/Domain/DataItem", "//DataItem[//Grid]",
        "//DataItem[Grid='a']", "descendant::DataItem", "//DataItem | //Grid", "id('a')",
        "//DataItem[[1]]", "//DataItem[contains(@Name, 'k')]"})
    EXPECT_THAT(error(path), HasSubstr("' is not read: expected steps like /Domain")) << path;
  EXPECT_THAT(error("//DataItem["), HasSubstr("is not read"));
  EXPECT_THAT(error("/Xdmf/Domain/DataItem[@Name='kept'"), HasSubstr("is not read"));
}

// Each grid holds itself ten times.
TEST(XdmfXml, GridsWithinThemselvesEnd) {
  std::string includes;
  for (int i = 0; i < 10; ++i) includes += "<xi:include xpointer=\"xpointer(//Grid)\"/>";
  EXPECT_THAT(error_of([&] { read_text(xdmf_file(xdmf_grid(includes, "GridType=\"Tree\""))); }),
              HasSubstr("more often than can be followed"));
}

TEST(XdmfXml, TimesAreFoundBehindAnything) {
  const std::string file = with(with(kFile, "<Topology", "<Time Value=\"2.5\"/><Topology"), "<Grid",
                                "<Information><![CDATA[<Time Value=\"1\"/>]]></Information><Grid");
  EXPECT_EQ(time_of_xdmf(*open_memory("a.xmf", std::as_bytes(std::span(file)))), 2.5);
}

}  // namespace xdmf_xml_test
}  // namespace ovoid::io
