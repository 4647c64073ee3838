// SPDX-License-Identifier: Apache-2.0
// Looks of every kind but ParaView's JSON, which has its own test.
#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <tuple>

#include "io/core/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace look_file_test {

constexpr const char* kVp =
    "1\n1\n0.9\n0.1\n0.2\n10\n"
    "6 -100 0 45.5 0.25 300 0.75\n"
    "4 0 1 255 1\n"
    "8 -100 0 0 0 300 1 0.5 0.25\n";

constexpr const char* kVpJson = R"({
  "@schema": "https://example.org/volume-property-schema-v1.0.0.json#",
  "volumeProperties": [{"effectiveRange": [0, 220], "interpolationType": "linear", "components": [{
    "shade": false,
    "lighting": {"diffuse": 1.0, "ambient": 0.25, "specular": 0.5, "specularPower": 3.0},
    "rgbTransferFunction": {"type": "colorTransferFunction", "points": [
      {"x": 0, "color": [0, 0, 0], "midpoint": 0.5, "sharpness": 0},
      {"x": 20, "color": [1, 0, 0], "midpoint": 0.25, "sharpness": 1},
      {"x": 40, "color": [0, 0, 1], "midpoint": 0.5, "sharpness": 0}]},
    "scalarOpacity": {"points": [
      {"x": 0, "y": 0, "midpoint": 0.5, "sharpness": 0.75}, {"x": 40, "y": 1, "midpoint": 0.5,
       "sharpness": 0}]},
    "gradientOpacity": {"points": [{"x": -5, "y": 0, "midpoint": 0.5, "sharpness": 0},
      {"x": 100, "y": 1, "midpoint": 0.5, "sharpness": 0}]},
    "scalarOpacityUnitDistance": 1.5, "disableGradientOpacity": false}]}]})";

constexpr const char* kColorMaps = R"(<?xml version="1.0"?>
<ColorMaps>
  <!-- two of them -->
  <ColorMap name="cold &amp; warm" space="Lab">
    <Point x="1" o="1" r="1" g="0" b="0"/>
    <Point x="0" o="1" r="0" g="0" b="1"/>
    <NaN r="0.25" g="0" b="0"/>
  </ColorMap>
  <ColorMap name="thick" space="RGB" indexedLookup="0">
    <Point x='-1' o='0.25' r='0' g='0' b='0'></Point>
    <Point x='1' o='1' r='1' g='1' b='1'/>
  </ColorMap>
</ColorMaps>)";

TEST(LookFile, ReadsSlicersVolumeProperty) {
  const TestFolder folder;
  const Look look = read_look(folder.write("look.vp", kVp));
  EXPECT_TRUE(look.shade);
  EXPECT_EQ(look.material.diffuse, 0.9);  // before ambient
  EXPECT_EQ(look.material.ambient, 0.1);
  EXPECT_EQ(look.material.specular, 0.2);
  EXPECT_EQ(look.material.specular_power, 10);
  const TransferFunction& tf = look.transfer_function;
  EXPECT_EQ(tf.opacity_at(45.5), 0.25);
  EXPECT_EQ(tf.opacity_at(300), 0.75);
  EXPECT_EQ(tf.color_at(300), (Rgb{1, 0.5, 0.25}));
  EXPECT_TRUE(tf.gradient_opacities.empty());  // 1 throughout
  EXPECT_FALSE(tf.unit_distance);
  EXPECT_EQ(read_transfer_function(folder.file("look.vp")).opacities.size(), 3U);
}

TEST(LookFile, ReadsSlicersJson) {
  const TestFolder folder;
  const Look look = read_look(folder.write("any.name", kVpJson));
  EXPECT_FALSE(look.shade);
  EXPECT_EQ(look.material.ambient, 0.25);
  EXPECT_EQ(look.material.diffuse, 1.0);
  EXPECT_EQ(look.material.specular, 0.5);
  EXPECT_EQ(look.material.specular_power, 3.0);
  const TransferFunction& tf = look.transfer_function;
  EXPECT_EQ(tf.unit_distance, 1.5);
  ASSERT_EQ(tf.opacities.size(), 2U);
  EXPECT_EQ(tf.opacities[0].sharpness, 0.75);
  ASSERT_EQ(tf.gradient_opacities.size(), 2U);
  EXPECT_EQ(tf.gradient_opacities[0].x, 0);  // gradients have no negative length
  EXPECT_EQ(tf.gradient_opacities[1].x, 100);
  // The second colour point's piece is a step a quarter of the way.
  EXPECT_EQ(tf.color_at(10), (Rgb{0.5, 0, 0}));
  EXPECT_EQ(tf.color_at(24.9), (Rgb{1, 0, 0}));
  EXPECT_EQ(tf.color_at(25), (Rgb{0, 0, 1}));
}

// Straight pieces follow a bent piece of colour: against the same curve, evaluated as opacity,
// which vtkColorTransferFunction uses for each component.
TEST(LookFile, BentColoursFollowTheCurve) {
  const TestFolder folder;
  for (const auto& [midpoint, sharpness, error] :
       {std::tuple{"0.3", "0.0", 1e-12}, {"0.5", "0.4", 0.002}, {"0.7", "0.9", 0.0025}}) {
    const std::string shape =
        std::string(R"(, "midpoint": )") + midpoint + R"(, "sharpness": )" + sharpness + "}";
    const TransferFunction tf =
        read_transfer_function(folder.write("bent.json",
                                            R"({"volumeProperties": [{"components": [{
            "rgbTransferFunction": {"points": [{"x": 0, "color": [0, 0, 0])" +
                                                shape + R"(, {"x": 1, "color": [1, 1, 1]}]},
            "scalarOpacity": {"points": [{"x": 0, "y": 0)" +
                                                shape + R"(, {"x": 1, "y": 1}]}}]}]})"));
    for (int i = 0; i <= 1000; ++i) {
      const double x = i / 1000.0;
      ASSERT_NEAR(tf.color_at(x)[1], tf.opacity_at(x), error) << sharpness << ' ' << x;
    }
  }
}

TEST(LookFile, ReadsParaViewsXmlByName) {
  const TestFolder folder;
  const std::string path = folder.write("maps.xml", kColorMaps);
  const TransferFunction first = read_transfer_function(path);
  EXPECT_EQ(first.name, "cold & warm");
  EXPECT_EQ(first.color_space, ColorSpace::kLab);
  EXPECT_EQ(first.colors.front().rgb, (Rgb{0, 0, 1}));  // sorted
  EXPECT_EQ(first.nan_color, (Rgb{0.25, 0, 0}));
  EXPECT_TRUE(first.opacities.empty());  // opaque throughout: a map of colours alone
  const TransferFunction second = read_transfer_function(path, "thick");
  EXPECT_EQ(second.opacity_at(-1), 0.25);
  EXPECT_EQ(second.color_at(0), (Rgb{0.5, 0.5, 0.5}));
  try {
    read_look(path, "thin");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_NE(std::string(error.what()).find("has cold & warm, thick"), std::string::npos);
  }
  const TransferFunction indexed = read_transfer_function(folder.write(
      "one.xml", R"(<ColorMap space="Step" indexedLookup="1"><Point x="0" r="1" g="0" b="0"/>
      <Point x="1" r="0" g="1" b="0"/></ColorMap>)"));
  EXPECT_EQ(indexed.color_at(0.4), (Rgb{1, 0, 0}));
  EXPECT_EQ(indexed.color_at(0.6), (Rgb{0, 1, 0}));
}

TEST(LookFile, ReadsSlicersPresetsByName) {
  const TestFolder folder;
  const std::string path = folder.write("presets.xml", R"(<MRML>
    <VolumeProperty id="a" name="first" shade="0" scalarOpacity="4 0 0 1 1" colorTransfer="0"/>
    <VolumeProperty id="b" name="second" interpolation="1" shade="1" ambient="0.3" diffuse="0.5"
      specular="0.25" specularPower="4" scalarOpacity="4 -5 0.5 5 1" gradientOpacity="4 0 0 9 1"
      colorTransfer="4 7 1 0.5 0"></VolumeProperty></MRML>)");
  EXPECT_FALSE(read_look(path).shade);
  const Look look = read_look(path, "second");
  EXPECT_TRUE(look.shade);
  EXPECT_EQ(look.material.ambient, 0.3);
  EXPECT_EQ(look.material.diffuse, 0.5);
  EXPECT_EQ(look.material.specular, 0.25);
  EXPECT_EQ(look.material.specular_power, 4);
  EXPECT_EQ(look.transfer_function.opacity_at(0), 0.75);
  EXPECT_EQ(look.transfer_function.gradient_opacities.size(), 2U);
  EXPECT_EQ(look.transfer_function.color_at(0), (Rgb{1, 0.5, 0}));
}

TEST(LookFile, ReadsInviwosFiles) {
  const TestFolder folder;
  const Look xml = read_look(folder.write("sky.itf", R"(<?xml version="1.0" encoding="UTF-8" ?>
    <InviwoWorkspace version="3"><maskMin content="0" /><Points>
      <Point><pos content="0" /><rgba x="1" y="0.5" z="0" w="0.25" /></Point>
      <Point><pos content="1" /><rgba x="0" y="0" z="1" w="1" /></Point>
    </Points></InviwoWorkspace>)"));
  EXPECT_EQ(xml.transfer_function.color_at(0), (Rgb{1, 0.5, 0}));
  EXPECT_EQ(xml.transfer_function.opacity_at(0), 0.25);
  const Look rows =
      read_look(folder.write("rows.txt", "# a comment\n\n0 0.25 #ff8000\r\n10\t1 #0000FF\n"));
  EXPECT_EQ(rows.transfer_function.color_at(0), (Rgb{1, 128 / 255.0, 0}));
  EXPECT_EQ(rows.transfer_function.color_at(10), (Rgb{0, 0, 1}));
  EXPECT_EQ(rows.transfer_function.opacity_at(5), 0.625);
}

// Two columns are opacities, four colours, five both; without rows, groups of four are colours
// where they can be.
TEST(LookFile, ReadsListsOfNumbers) {
  const TestFolder folder;
  const auto read = [&](const std::string& text) {
    return read_transfer_function(folder.write("list.txt", text));
  };
  EXPECT_EQ(read("0,0,0,0,1,1,0.5,0").color_at(1), (Rgb{1, 0.5, 0}));
  EXPECT_EQ(read("\xef\xbb\xbf 0, 0, 0, 0,\n").colors.size(), 1U);
  EXPECT_EQ(read("0,0,100,1,200,0").opacity_at(100), 1.0);
  EXPECT_EQ(read("0 0\n0.5 1\n").opacity_at(0.5), 1.0);
  EXPECT_EQ(read("0,0,100,1").opacity_at(100), 1.0);  // no colours: 100 is none
  EXPECT_EQ(read("0 0 0 0\n1 1 1 1\n").colors.size(), 2U);
  const TransferFunction both = read("0 1 0 0 0.25\n1 0 1 0 0.75\n");
  EXPECT_EQ(both.color_at(0), (Rgb{1, 0, 0}));
  EXPECT_EQ(both.opacity_at(1), 0.75);
}

// Each row: what is in the file, and what the message must say.
TEST(LookFile, OtherFilesAreRefusedByKindOrPlace) {
  struct Row {
    std::string content;
    const char* named;
  };
  const Row rows[] = {
      {"", "look: is empty, expected a look: ParaView JSON"},
      {" \n\t", "is empty"},
      {"\x89PNG\r\n\x1a\n", "looks like a PNG picture, expected a look"},
      {"NRRD0004\ntype: uint8\n", "looks like an NRRD volume"},
      {"# vtk DataFile Version 3.0\n", "looks like a legacy VTK dataset"},
      {std::string("ab\0c", 4), "looks like binary data"},
      {"<VTKFile type=\"ImageData\"><ImageData/></VTKFile>",
       "looks like XML with the root <VTKFile>"},
      {"<!DOCTYPE a [<!ENTITY b \"c\">]><ColorMap/>", "declaration"},
      {"hello, world", "look: line 1: 'hello' is no number, expected a look"},
      {"0 0 0 0\n1 x 1 1\n", "look: line 2: 'x' is no number"},
      {"0,0,0,0,nan,1,1,1", "'nan' is no number"},
      {"0,0,0", "has 3 numbers: must be value,opacity for each point"},
      {"1,0,0,0,0,1,1,1", "number 5 is 0: values must rise, it stands after 1"},
      {"0,0,0,2,1,1,1,7", "number 4 is 2: colours must be in [0, 1]"},
      {"0 0\n1 2\n2 0\n", "number 4 is 2: opacities must be in [0, 1]"},
      {"0 0.5 #ff00\n", "line 1: '#ff00': must be #rrggbb"},
      {"0 0.5 #ff00zz\n", "must be #rrggbb"},
      {"0 0.5 #ff0000\n1 1\n", "line 2: must be a value, an opacity and #rrggbb"},
      {"0 1.5 #ff0000\n", "line 1: 1.5: must be in [0, 1]"},
      {"1\n1\n0.9\n-0.1\n0.2\n10\n4 0 0 1 1\n0 \n4 0 0 0 0\n", "line 4: -0.1: must be >= 0"},
      {"1\n1\n0.9\n0.1\n0.2\n10\n5 0 0 1 1\n4 0 1 1 1\n4 0 0 0 0\n",
       "line 7: must begin with the count of the 4 numbers that follow"},
      {"1\n1\n0.9\n0.1\n0.2\n10\n3 0 0 1\n4 0 1 1 1\n4 0 0 0 0\n",
       "line 7: has 3 numbers: must be 2"},
      {"1\n1\n0.9\n0.1\n0.2\n10\n4 0 0 1 1\n4 0 1 1 1\n4 0 0 0 3\n",
       "line 9: 3: must be in [0, 1]"},
      {"<ColorMap space='CMYK'/>", "space of <ColorMap> at byte 0 = \"CMYK\": must be RGB"},
      {"<ColorMap><Point x='0' r='1' g='1'/></ColorMap>", "b of <Point> at byte 10: is missing"},
      {"<ColorMap><Point x='a' r='1' g='1' b='0'/></ColorMap>", "'a': must be a number"},
      {"<ColorMap><Point x='0' r='1' g='1' b='0'", "does not end"},
      {"<MRML><VolumeProperty scalarOpacity='2 0'/></MRML>", "scalarOpacity of <VolumeProperty>"},
      {"<InviwoWorkspace><Points><Point><rgba x='0' y='0' z='0' w='0'/>",
       "stands before its <pos>"},
      {R"({"volumeProperties": []})", "must hold at least one volume property"},
      {R"({"volumeProperties": [{"components": [{"rgbTransferFunction": {}}]}]})",
       "has no member points"},
      {R"({"volumeProperties": [{"components": [{"scalarOpacity": {"points": [{"x": 0}]}}]}]})",
       "points[0]: has no member y"},
  };
  const TestFolder folder;
  for (const Row& row : rows) {
    try {
      read_look(folder.write("look", row.content));
      ADD_FAILURE() << "accepted: " << row.content;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(row.named), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
}

TEST(LookFile, NamesAreForFilesThatHaveSome) {
  const TestFolder folder;
  for (const char* const content : {kVp, kVpJson, "0,0,1,1"}) {
    try {
      read_look(folder.write("look", content), "bones");
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_NE(std::string(error.what()).find("has no names"), std::string::npos) << error.what();
    }
  }
}

// Fails by time if every small tag is looked at through a large window, or by memory if lists grow
// without end.
TEST(LookFile, LargeFilesEnd) {
  const TestFolder folder;
  std::string tags = "<ColorMaps>";
  while (tags.size() < (std::size_t{4} << 20)) tags += "<a/>";
  EXPECT_THROW(read_look(folder.write("tags.xml", tags)), Error);
  std::string list;
  while (list.size() < (std::size_t{4} << 20)) list += "0,";
  EXPECT_THROW(read_look(folder.write("list.txt", list)), Error);
}

}  // namespace look_file_test
}  // namespace ovoid::io
