// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <random>

#include "io/core/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace transfer_function_test {

constexpr const char* kPresets = R"([
  {"Name": "Rainbow", "ColorSpace": "HSV", "Creator": "somebody", "NanColor": [0.5, 0, 0],
   "RGBPoints": [0, 0, 0, 1, 1, 1, 0, 0]},
  {"Name": "bone and skin", "ColorSpace": "Diverging", "HSVWrap": 0, "DefaultMap": true,
   "RGBPoints": [300, 1, 0.5, 0, -100.5, 0, 0, 1],
   "Points": [-100, 0, 0.5, 0, 300, 0.8, 0.25, 0.75, 100, 0.1, 1, 0],
   "ScalarOpacityUnitDistance": 2.5, "UseLogScale": 0}
])";

void expect_equal(const TransferFunction& a, const TransferFunction& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.color_space, b.color_space);
  EXPECT_EQ(a.nan_color, b.nan_color);
  EXPECT_EQ(a.unit_distance, b.unit_distance);
  ASSERT_EQ(a.colors.size(), b.colors.size());
  for (std::size_t i = 0; i < a.colors.size(); ++i) {
    EXPECT_EQ(a.colors[i].x, b.colors[i].x) << i;
    EXPECT_EQ(a.colors[i].rgb, b.colors[i].rgb) << i;
  }
  ASSERT_EQ(a.opacities.size(), b.opacities.size());
  for (std::size_t i = 0; i < a.opacities.size(); ++i) {
    EXPECT_EQ(a.opacities[i].x, b.opacities[i].x) << i;
    EXPECT_EQ(a.opacities[i].opacity, b.opacities[i].opacity) << i;
    EXPECT_EQ(a.opacities[i].midpoint, b.opacities[i].midpoint) << i;
    EXPECT_EQ(a.opacities[i].sharpness, b.opacities[i].sharpness) << i;
  }
}

TEST(TransferFunctionFile, ReadsTheFirstPresetOrTheNamedOne) {
  const TestFolder folder;
  const std::string path = folder.write("tf.json", kPresets);
  const TransferFunction first = read_transfer_function(path);
  EXPECT_EQ(first.name, "Rainbow");
  EXPECT_EQ(first.color_space, ColorSpace::kHsv);
  EXPECT_EQ(first.nan_color, (Rgb{0.5, 0, 0}));
  EXPECT_TRUE(first.opacities.empty());
  EXPECT_FALSE(first.unit_distance);

  const TransferFunction named = read_transfer_function(path, "bone and skin");
  EXPECT_EQ(named.color_space, ColorSpace::kDiverging);
  EXPECT_EQ(named.nan_color, (Rgb{1, 1, 0}));
  EXPECT_EQ(named.unit_distance, 2.5);
  ASSERT_EQ(named.colors.size(), 2U);  // sorted
  EXPECT_EQ(named.colors[0].x, -100.5);
  EXPECT_EQ(named.colors[1].rgb, (Rgb{1, 0.5, 0}));
  ASSERT_EQ(named.opacities.size(), 3U);
  EXPECT_EQ(named.opacities[1].x, 100);
  EXPECT_EQ(named.opacities[1].midpoint, 1);
  EXPECT_EQ(named.opacities[2].opacity, 0.8);
  EXPECT_EQ(named.opacities[2].sharpness, 0.75);
}

TEST(TransferFunctionFile, ReadsASingleObject) {
  const TestFolder folder;
  const std::string path =
      folder.write("tf.json", R"({"Name": "a", "Points": [0, 0, 0.5, 0, 9, 1, 0.5, 0]})");
  EXPECT_EQ(read_transfer_function(path).opacity_at(4.5), 0.5);
  EXPECT_EQ(read_transfer_function(path, "a").name, "a");
  EXPECT_THROW(read_transfer_function(path, "b"), Error);
}

// Blue to red as a rainbow, unless the file asks for the shorter way round.
TEST(TransferFunctionFile, HsvWrapsOnlyOnRequest) {
  const TestFolder folder;
  const auto middle = [&](const std::string& wrap) {
    return read_transfer_function(
               folder.write("tf.json", R"({"ColorSpace": "HSV", "RGBPoints": [0,0,0,1, 1,1,0,0])" +
                                           wrap + "}"))
        .color_at(0.5);
  };
  EXPECT_NEAR(middle("")[1], 1.0, 1e-12);
  EXPECT_NEAR(middle(R"(, "HSVWrap": 0)")[1], 1.0, 1e-12);
  EXPECT_NEAR(middle(R"(, "HSVWrap": 1)")[1], 0.0, 1e-12);
  EXPECT_NEAR(middle(R"(, "HSVWrap": true)")[2], 1.0, 1e-12);
}

// Every bit of every number, including those that decimal text likes to lose.
TEST(TransferFunctionFile, RoundTripIsExact) {
  const TestFolder folder;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const ColorSpace space : {ColorSpace::kRgb, ColorSpace::kHsv, ColorSpace::kHsvWrap,
                                 ColorSpace::kLab, ColorSpace::kDiverging, ColorSpace::kStep}) {
    TransferFunction tf;
    tf.name = "\"quoted\"\n\xc3\xa9";
    tf.color_space = space;
    tf.nan_color = {uniform(random), 0.1, 1.0 / 3};
    tf.unit_distance = std::numeric_limits<double>::denorm_min();
    for (int i = 0; i < 50; ++i) {
      tf.colors.push_back(
          {uniform(random) * 1e-3 + i, {uniform(random), uniform(random), uniform(random)}});
      tf.opacities.push_back(
          {1e300 * (i + uniform(random)), uniform(random), uniform(random), uniform(random)});
    }
    write_transfer_function(tf, folder.file("out.json"));
    expect_equal(read_transfer_function(folder.file("out.json")), tf);
  }
  const TransferFunction empty;
  write_transfer_function(empty, folder.file("empty.json"));
  expect_equal(read_transfer_function(folder.file("empty.json")), empty);
}

TEST(TransferFunctionFile, DoesNotWriteWhatItWouldNotRead) {
  const TestFolder folder;
  TransferFunction tf;
  tf.opacities = {{std::numeric_limits<double>::quiet_NaN(), 1}};
  EXPECT_THROW(write_transfer_function(tf, folder.file("tf.json")), Error);
  tf.opacities.clear();
  tf.name = "\xff";
  EXPECT_THROW(write_transfer_function(tf, folder.file("tf.json")), Error);
  EXPECT_EQ(folder.count(), 0);
  try {
    write_transfer_function(TransferFunction(), folder.file("nowhere/tf.json"));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFileWrite);
  }
}

// Each row: what is in the file, what kind of error, and the place and expectation that the message
// must name.
TEST(TransferFunctionFile, ErrorsNameFileKeyAndIndex) {
  struct Row {
    const char* content;
    ErrorCode code;
    const char* named;
  };
  const auto kFormat = ErrorCode::kFileFormat;
  const Row rows[] = {
      {"", kFormat, "tf.json: is empty, expected a look"},
      {"[{\"Points\": [0, 0, 0.5", kFormat, "tf.json: not JSON at byte"},
      {"3", kFormat, "tf.json: has 1 numbers: must be value,opacity"},
      {"[]", kFormat, "at least one preset"},
      {"[7]", kFormat, "tf.json: [0] = 7: must be an object"},
      {"{}", kFormat, "tf.json: the preset has neither RGBPoints, IndexedColors"},
      {R"({"Name": "n"})", kFormat, "tf.json: preset 'n' has neither RGBPoints, IndexedColors"},
      {R"({"Name": "n\n"})", kFormat, "preset 'n?' has"},
      {R"({"position": [0, 0, 1], "focal_point": [0, 0, 0]})", kFormat, "looks like a camera"},
      {R"({"IndexedColors": []})", kFormat, "IndexedColors = []: must have at least one colour"},
      {R"({"IndexedColors": [1, 0]})", kFormat, "must have three numbers per colour"},
      {R"({"IndexedColors": [1, 0, 0], "Annotations": ["H", "hydrogen"]})", kFormat,
       "Annotations[0] = \"H\": must be a number"},
      {R"({"IndexedColors": [1, 0, 0], "Annotations": ["1"]})", kFormat, "a value and a text"},
      {R"([{"Points": [1, 0, 0.5, 0, 0, 1, 0.5, 0], "UseLogScale": 1}])", kFormat,
       "tf.json: [0].Points[4] = 0: must be > 0 with UseLogScale"},
      {R"({"RGBPoints": [-1, 0, 0, 0], "UseLogScale": 1})", kFormat, "RGBPoints[0] = -1"},
      {R"({"Points": [], "SymlogLinearWidth": 0})", kFormat, "SymlogLinearWidth = 0: must be > 0"},
      {R"({"Points": [], "UseBelowRangeColor": 1})", kFormat, "has no member BelowRangeColor"},
      {R"({"Points": [], "UseAboveRangeColor": 1, "AboveRangeColor": [0, 2, 0]})", kFormat,
       "AboveRangeColor[1] = 2"},
      {R"({"Points": [], "Ambient": -1})", kFormat, "Ambient = -1: must be >= 0"},
      {R"({"Points": [], "SpecularPower": 0})", kFormat, "specular_power = 0: must be"},
      {R"({"Points": [], "GradientOpacityPoints": [-1, 1, 0.5, 0]})", kFormat,
       "gradient_opacities[0].x = -1: must be >= 0"},
      {R"({"Points": [-1e308, 0, 0.5, 0, 1e308, 1, 0.5, 0]})", kFormat,
       "tf.json: transfer function span"},
      {R"({"Points": [], "ColorSpace": "CMYK"})", kFormat,
       "tf.json: ColorSpace = \"CMYK\": must be RGB"},
      {R"({"Points": [], "ColorSpace": 1})", kFormat, "ColorSpace = 1: must be a string"},
      {R"({"Points": {"a": 1}})", kFormat, "Points = {...}: must be an array"},
      {R"({"Points": [0, 0, 0.5, 0, 1]})", kFormat,
       "Points = [5 elements]: must have four numbers per point"},
      {R"({"Points": [0, 0, 0.5, 0, 1, 1, "x", 0]})", kFormat,
       "tf.json: Points[6] = \"x\": must be a number"},
      {R"([{"RGBPoints": [0, 0, 0, 1.5]}])", kFormat,
       "tf.json: [0].RGBPoints[3] = 1.5: must be in [0, 1]"},
      {R"({"Points": [0, -1, 0.5, 0]})", kFormat, "Points[1] = -1: must be in [0, 1]"},
      {R"({"Points": [0, 0, 2, 0]})", kFormat, "Points[2] = 2"},
      {R"({"Points": [0, 0, 0.5, null]})", kFormat, "Points[3] = null"},
      {R"({"Points": [1e999, 0, 0.5, 0]})", kFormat, "number that double cannot"},
      {R"({"Points": [NaN, 0, 0.5, 0]})", kFormat, "not JSON"},
      {R"({"Points": [], "NanColor": [1, 1]})", kFormat, "NanColor = [1,1]: must have 3 elements"},
      {R"({"Points": [], "NanColor": [1, 1, 9]})", kFormat, "NanColor[2] = 9"},
      {R"({"Points": [], "Name": 4})", kFormat, "Name = 4: must be a string"},
      {R"({"Points": [], "ScalarOpacityUnitDistance": 0})", kFormat,
       "ScalarOpacityUnitDistance = 0: must be > 0"},
      {R"({"Points": [], "ColorSpace": "HSV", "HSVWrap": "yes"})", kFormat, "HSVWrap = \"yes\""},
      {R"({"Points": [], "Lights": {"Direction": [0, 0, 1]}})", kFormat, "must be an array"},
      {R"({"Points": [], "Lights": [1]})", kFormat, "Lights[0] = 1: must be an object"},
      {R"({"Points": [], "Lights": [{"Intensity": 1}]})", kFormat, "has no member Direction"},
      {R"({"Points": [], "Lights": [{"Direction": [0, 0, 0]}]})", kFormat,
       "Lights[0].Direction = [0,0,0]: must be a direction"},
      {R"({"Points": [], "Lights": [{"Direction": [0, 1]}]})", kFormat, "must have 3 elements"},
      {R"({"Points": [], "Lights": [{"Direction": [0, 0, 1], "Intensity": -1}]})", kFormat,
       "Lights[0].Intensity = -1: must be in [0, 10]"},
      {R"({"Points": [], "Lights": [{}, {}, {}, {}, {}]})", kFormat, "must have at most 4 lights"},
  };
  const TestFolder folder;
  for (const Row& row : rows) {
    try {
      read_transfer_function(folder.write("tf.json", row.content));
      ADD_FAILURE() << "accepted: " << row.content;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), row.code) << row.content;
      EXPECT_NE(std::string(error.what()).find(row.named), std::string::npos) << error.what();
    }
  }
}

TEST(TransferFunctionFile, ReadsParaViewsOtherKeys) {
  const TestFolder folder;
  const TransferFunction tf = read_transfer_function(folder.write("tf.json", R"({
    "RGBPoints": [1, 0, 0, 0, 100, 1, 1, 1], "UseLogScale": 1,
    "BelowRangeColor": [0, 0, 1], "UseBelowRangeColor": 1,
    "AboveRangeColor": [1, 0, 0], "UseAboveRangeColor": 0,
    "NanOpacity": 1, "NumberOfTableValues": 256, "Discretize": 1})"));
  EXPECT_EQ(tf.scale, ValueScale::kLog);
  EXPECT_NEAR(tf.color_at(10)[0], 0.5, 1e-15);
  EXPECT_EQ(tf.color_at(0.5), (Rgb{0, 0, 1}));
  EXPECT_FALSE(tf.above_color);
}

TEST(TransferFunctionFile, ReadsCategories) {
  const TestFolder folder;
  const Rgb red{1, 0, 0}, green{0, 1, 0};
  const TransferFunction plain = read_transfer_function(
      folder.write("tf.json", R"({"Name": "c", "IndexedColors": [1, 0, 0, 0, 1, 0]})"));
  EXPECT_EQ(plain.color_at(0.4), red);
  EXPECT_EQ(plain.color_at(0.6), green);
  const TransferFunction annotated = read_transfer_function(
      folder.write("tf.json", R"({"IndexedColors": [1, 0, 0, 0, 1, 0], "IndexedLookup": true,
        "RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1], "Annotations": ["10", "a", "4", "b", 20, "c"]})"));
  EXPECT_EQ(annotated.color_at(4), green);
  EXPECT_EQ(annotated.color_at(10), red);
  EXPECT_EQ(annotated.color_at(20), red);  // colours repeat
}

TEST(TransferFunctionFile, ReadsCiede2000AsLab) {
  const TestFolder folder;
  const TransferFunction tf = read_transfer_function(folder.write(
      "tf.json", R"({"ColorSpace": "Lab/CIEDE2000", "RGBPoints": [1, 0, 0, 1, 0, 1, 0, 0]})"));
  EXPECT_EQ(tf.color_space, ColorSpace::kLab);
  const Rgb middle = tf.color_at(0.5);  // as VTK's own test has it
  EXPECT_NEAR(middle[0], 196 / 255.0, 1.0 / 255);
  EXPECT_NEAR(middle[1], 16 / 255.0, 1.0 / 255);
  EXPECT_NEAR(middle[2], 123 / 255.0, 1.0 / 255);
  std::string many = R"({"ColorSpace": "Lab/CIEDE2000", "RGBPoints": [0, 0, 0, 0)";
  for (int i = 1; i <= 256; ++i) many += ", " + std::to_string(i) + ", 1, 0, 0";
  try {
    read_transfer_function(folder.write("many.json", many + "]}"));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnsupported);
    EXPECT_NE(std::string(error.what()).find("many.json: RGBPoints"), std::string::npos);
  }
}

// Fails if a member of the look is left out, or comes back changed.
TEST(LookFile, RoundTripIsExact) {
  const TestFolder folder;
  Look look;
  TransferFunction& tf = look.transfer_function;
  tf.name = "n";
  tf.colors = {{0.1, {1, 0, 0}}, {7, {0, 0.25, 1}}};
  tf.opacities = {{0.1, 0}, {7, 1.0 / 3}};
  tf.gradient_opacities = {{0, 0, 0.25, 0.5}, {1e3, 1}};
  tf.below_color = Rgb{0.1, 0.2, 0.3};
  tf.above_color = Rgb{0.4, 0.5, 0.6};
  tf.unit_distance = 2.5;
  look.shade = false;
  look.material = {.ambient = 0.3, .diffuse = 1.5, .specular = 0, .specular_power = 7};
  for (const ValueScale scale : {ValueScale::kLinear, ValueScale::kLog, ValueScale::kSymlog}) {
    tf.scale = scale;
    tf.linear_width = scale == ValueScale::kSymlog ? 0.125 : 1.0;
    write_look(look, folder.file("out.json"));
    const Look back = read_look(folder.file("out.json"));
    expect_equal(back.transfer_function, tf);
    EXPECT_EQ(back.transfer_function.scale, scale);
    EXPECT_EQ(back.transfer_function.linear_width, tf.linear_width);
    EXPECT_EQ(back.transfer_function.below_color, tf.below_color);
    EXPECT_EQ(back.transfer_function.above_color, tf.above_color);
    ASSERT_EQ(back.transfer_function.gradient_opacities.size(), 2U);
    EXPECT_EQ(back.transfer_function.gradient_opacities[0].midpoint, 0.25);
    EXPECT_EQ(back.transfer_function.gradient_opacities[0].sharpness, 0.5);
    EXPECT_EQ(back.shade, false);
    EXPECT_EQ(back.material.ambient, 0.3);
    EXPECT_EQ(back.material.diffuse, 1.5);
    EXPECT_EQ(back.material.specular, 0);
    EXPECT_EQ(back.material.specular_power, 7);
  }
  look.unit_distance = 9;  // beats the transfer function's
  write_look(look, folder.file("out.json"));
  EXPECT_EQ(read_look(folder.file("out.json")).transfer_function.unit_distance, 9);
}

TEST(TransferFunctionFile, AnUnknownPresetListsTheNames) {
  const TestFolder folder;
  try {
    read_transfer_function(folder.write("tf.json", kPresets), "bones");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_NE(std::string(error.what()).find("Rainbow, bone and skin"), std::string::npos)
        << error.what();
  }
}

// Fails (by time or memory) if a hostile file is read without limits.
TEST(TransferFunctionFile, HostileFilesAreRefused) {
  const TestFolder folder;
  const auto code = [](const std::string& path) {
    try {
      read_transfer_function(path);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kCancelled;
  };
  EXPECT_EQ(code(folder.file("missing.json")), ErrorCode::kFileNotFound);
  EXPECT_EQ(code(folder.file("")), ErrorCode::kUnsupported);  // a folder
  EXPECT_EQ(code("/dev/zero"), ErrorCode::kUnsupported);      // endless
  EXPECT_EQ(code(folder.write("deep.json", std::string(1000000, '['))), ErrorCode::kFileFormat);
  EXPECT_EQ(code(folder.write("zeros.json", std::string(100000, '\0'))), ErrorCode::kFileFormat);
  std::string many = "{\"Points\": []";
  for (int i = 0; i < 100000; ++i) many += ",\"" + std::to_string(i) + "\":0";
  EXPECT_EQ(code(folder.write("many.json", many + "}")),
            ErrorCode::kCancelled);  // extra keys are no error
}

// Fails if the page of docs shows a file that cannot be read, or leaves out a colour map.
TEST(TransferFunctionFile, TheDocumentedExampleAndNamesHold) {
  std::ifstream stream(std::string(OVOID_SOURCE_DIR) + "/docs/looks.md");
  const std::string page{std::istreambuf_iterator<char>(stream), {}};
  const auto begin = page.find("```json\n") + 8;
  ASSERT_LT(begin, page.size());
  const TestFolder folder;
  const std::string path =
      folder.write("tf.json", page.substr(begin, page.find("```", begin) - begin));
  const TransferFunction tf = read_transfer_function(path, "bone over skin");
  EXPECT_EQ(tf.color_space, ColorSpace::kDiverging);
  EXPECT_EQ(tf.colors.size(), 3U);
  EXPECT_EQ(tf.opacities.size(), 4U);
  EXPECT_EQ(tf.unit_distance, 1.0);
  for (const auto& names : {color_map_names(), look_preset_names()}) {
    for (const std::string& name : names) {
      EXPECT_NE(page.find("`" + name + "`"), std::string::npos) << name;
    }
  }
}

}  // namespace transfer_function_test
}  // namespace ovoid::io
