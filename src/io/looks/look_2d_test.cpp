// SPDX-License-Identifier: Apache-2.0
// Files of 2-D transfer functions.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>

#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace look_2d_test {

std::string written_2d(const std::string& name, const std::string& content) {
  const std::string path = (std::filesystem::path(testing::TempDir()) / name).string();
  write_file(path, content);
  return path;
}

void expect_refused(const std::function<void()>& read, ErrorCode code, const std::string& words) {
  try {
    read();
    ADD_FAILURE() << "read, for " << words;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(Look2DFile, LooksComeBackToTheBit) {
  Look look;
  look.transfer_function.opacities = {{0, 0}, {1, 1}};
  const TransferFunction2D::Rgba odd{0.1F, 1.0F / 3, 0.7F, 1e-7F};
  look.transfer_function_2d =
      TransferFunction2D({-0.1, 1.0 / 3, 2}, {0.2, 7, 3}, std::vector(6, odd));
  const Look table = look_from_text(to_text(look));
  ASSERT_TRUE(table.transfer_function_2d);
  EXPECT_EQ(table.transfer_function_2d->values().last, 1.0 / 3);
  EXPECT_EQ(table.transfer_function_2d->gradients().count, 3);
  for (const auto& entry : table.transfer_function_2d->entries()) EXPECT_EQ(entry, odd);

  look.transfer_function_2d = TransferFunction2D({{.shape = LookRegion::Shape::kGaussian,
                                                   .values = {-1, 1.0 / 3},
                                                   .gradients = {0.1, 5},
                                                   .rgb = {0.1, 0.2, 0.3},
                                                   .opacity = 0.7,
                                                   .softness = 0.3,
                                                   .foot = 0.9}});
  const Look regions = look_from_text(to_text(look));
  ASSERT_EQ(regions.transfer_function_2d->regions().size(), 1U);
  const LookRegion& region = regions.transfer_function_2d->regions()[0];
  EXPECT_EQ(region.shape, LookRegion::Shape::kGaussian);
  EXPECT_EQ(region.values[1], 1.0 / 3);
  EXPECT_EQ(region.gradients[0], 0.1);
  EXPECT_EQ(region.rgb[2], 0.3);
  EXPECT_EQ(region.softness, 0.3);
  EXPECT_EQ(region.foot, 0.9);
}

TEST(Look2DFile, ReadsTheBoxesOfParaViewsStates) {
  const std::string path = written_2d("boxes.pvsm", R"(<ParaView>
<ServerManagerState version="5.11.0">
  <Proxy group="lookup_tables" type="PVLookupTable" id="1"><Property name="Boxes" number_of_elements="1"><Element index="0" value="9"/></Property></Proxy>
  <Proxy group="transfer_2d_functions" type="TransferFunction2D" id="2" servers="21">
    <Property name="Boxes" id="2.Boxes" number_of_elements="8">
      <Element index="0" value="10"/><Element index="1" value="2"/>
      <Element index="2" value="30"/><Element index="3" value="4"/>
      <Element index="4" value="1"/><Element index="5" value="0.5"/>
      <Element index="6" value="0"/><Element index="7" value="0.25"/>
    </Property>
    <Property name="Range" id="2.Range" number_of_elements="4"><Element index="0" value="0"/></Property>
  </Proxy>
</ServerManagerState></ParaView>)");
  const TransferFunction2D function = read_transfer_function_2d(path);
  ASSERT_EQ(function.regions().size(), 1U);
  EXPECT_EQ(function.regions()[0].values[1], 40);
  EXPECT_EQ(function.regions()[0].gradients[1], 6);
  EXPECT_NEAR(function.at(25, 4)[3], 0.25, 1e-3);
  EXPECT_NEAR(function.at(25, 4)[1], 0.5, 1e-6);
}

TEST(Look2DFile, ReadsPicturesFromBelow) {
  Image image;
  image.width = 2;
  image.height = 2;
  image.rgba = {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1, 1};
  image.depth.assign(4, 1);
  image.front_depth = image.depth;
  const std::string path = (std::filesystem::path(testing::TempDir()) / "plane.png").string();
  write_image(image, path);
  const TransferFunction2D function = read_transfer_function_2d(path, Ranges2D{{0, 10}, {0, 4}});
  EXPECT_EQ(function.at(0, 4)[0], 1);  // red is at the top
  EXPECT_EQ(function.at(0, 0)[2], 1);
  EXPECT_EQ(function.at(0, 0)[0], 0);
  expect_refused([&] { read_transfer_function_2d(path); }, ErrorCode::kInvalidArgument,
                 "needs the ranges");
}

TEST(Look2DFile, ReadsGridsOfColors) {
  const std::string path = written_2d("plane.nrrd", R"(NRRD0004
type: float
dimension: 4
sizes: 4 2 2 1
kinds: vector domain domain domain
space dimension: 3
space directions: none (10,0,0) (0,3,0) (0,0,1)
space origin: (5,1,0)
encoding: ascii

1 0 0 0.5  0 1 0 0.5
0 0 1 0.25  1 1 1 1
)");
  const TransferFunction2D function = read_transfer_function_2d(path);
  EXPECT_EQ(function.values().first, 5);
  EXPECT_EQ(function.values().last, 15);
  EXPECT_EQ(function.gradients().last, 4);
  EXPECT_EQ(function.at(15, 1)[1], 1);
  EXPECT_EQ(function.at(5, 4)[3], 0.25);
}

TEST(Look2DFile, RefusesWhatIsNone) {
  const auto refused = [](const std::string& text, const std::string& words) {
    expect_refused([&] { transfer_function_2d_from_text(text); }, ErrorCode::kFileFormat, words);
  };
  refused("{}", "Regions");
  refused(R"({"Regions": []})", "0 regions");
  refused(R"({"Regions": [{"Values": [1, 0], "Gradients": [0, 1]}]})", "regions[0].values = 1, 0");
  refused(R"({"Regions": [{"Values": [0, 1]}]})", "Gradients");
  refused(R"({"Regions": [{"Values": [0, 1], "Gradients": [0, 1], "Shape": "Disc"}]})",
          "must be Box");
  refused(R"({"Values": [0, 1], "Gradients": [0, 1], "Size": [2, 2.5], "RGBA": []})",
          "whole number");
  refused(R"({"Values": [0, 1], "Gradients": [0, 1], "Size": [2, 2], "RGBA": [1, 1, 1]})",
          "four numbers");
  refused(R"({"Values": [0, 1], "Gradients": [0, 1], "Size": [2, 2], "RGBA": [1, 1, 1, 1]})",
          "1 entries");
  refused("[]", "expected JSON with Regions");
  refused(R"([{"Points": [0, 0, 0.5, 0]}])", "expected JSON with Regions");
  const std::string state = written_2d("none.pvsm", "<ParaView></ParaView>");
  expect_refused([&] { read_transfer_function_2d(state); }, ErrorCode::kFileFormat,
                 "has 0 numbers");
  expect_refused([&] { read_transfer_function_2d(state, Ranges2D{}); }, ErrorCode::kInvalidArgument,
                 "ranges are for pictures");
}

}  // namespace look_2d_test
}  // namespace ovoid
