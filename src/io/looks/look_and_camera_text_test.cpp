// SPDX-License-Identifier: Apache-2.0
// Looks and cameras as text: the same as their files, and back to the bit.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "io/core/test_folder.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace look_and_camera_text_test {

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Every double of a look that is written, as its bits; members that may be absent with a mark.
class Bits {
 public:
  Bits& add(double value) {
    all.push_back(std::bit_cast<std::uint64_t>(value));
    return *this;
  }
  Bits& add(const Rgb& rgb) { return add(rgb[0]).add(rgb[1]).add(rgb[2]); }
  Bits& add(const std::optional<Rgb>& rgb) { return add(rgb ? 1.0 : 0.0).add(rgb.value_or(Rgb{})); }
  Bits& add(const std::vector<OpacityPoint>& points) {
    add(static_cast<double>(points.size()));
    for (const OpacityPoint& p : points) add(p.x).add(p.opacity).add(p.midpoint).add(p.sharpness);
    return *this;
  }
  Bits& add(const Vec3& v) { return add(v.x()).add(v.y()).add(v.z()); }

  std::vector<std::uint64_t> all;
};

std::vector<std::uint64_t> bits_of(const Look& look) {
  const TransferFunction& tf = look.transfer_function;
  Bits bits;
  bits.add(static_cast<double>(tf.colors.size()));
  for (const ColorPoint& p : tf.colors) bits.add(p.x).add(p.rgb);
  bits.add(tf.opacities).add(tf.gradient_opacities);
  bits.add(static_cast<double>(tf.color_space)).add(static_cast<double>(tf.scale));
  bits.add(tf.linear_width).add(tf.below_color).add(tf.above_color).add(tf.nan_color);
  bits.add(tf.unit_distance ? 1.0 : 0.0).add(tf.unit_distance.value_or(0.0));
  const Material& material = look.material;
  bits.add(look.shade ? 1.0 : 0.0).add(material.ambient).add(material.diffuse);
  bits.add(material.specular).add(material.specular_power);
  for (const FurtherLight& light : look.further_lights)
    bits.add(light.direction).add(light.intensity);
  return bits.all;
}

std::vector<std::uint64_t> bits_of(const Camera& camera) {
  Bits bits;
  bits.add(camera.position).add(camera.focal_point).add(camera.view_up);
  bits.add(camera.parallel_projection ? 1.0 : 0.0);
  return bits.add(camera.parallel_scale).add(camera.view_angle).all;
}

using Random = std::mt19937_64;

double unit(Random& random) { return std::uniform_real_distribution<double>(0, 1)(random); }

// Of any size that a double can have, > 0, the subnormal ones too.
double positive(Random& random) {
  return std::ldexp(0.5 + 0.5 * unit(random),
                    std::uniform_int_distribution<int>(-1073, 900)(random));
}

Rgb color(Random& random) { return {unit(random), unit(random), unit(random)}; }

std::vector<OpacityPoint> opacities(Random& random) {
  std::vector<OpacityPoint> points(random() % 6);
  for (OpacityPoint& p : points) p = {positive(random), unit(random), unit(random), unit(random)};
  return points;
}

std::vector<OpacityPoint> sorted(std::vector<OpacityPoint> points) {
  TransferFunction tf;
  tf.opacities = std::move(points);
  tf.sort();
  return tf.opacities;
}

Look random_look(Random& random) {
  Look look;
  TransferFunction& tf = look.transfer_function;
  tf.name = "n\"\\\n\xc3\xa4";
  tf.color_space = static_cast<ColorSpace>(random() % 6);
  tf.scale = static_cast<ValueScale>(random() % 3);
  if (tf.scale == ValueScale::kSymlog) tf.linear_width = positive(random);
  const double sign = tf.scale != ValueScale::kLog && random() % 2 == 0 ? -1 : 1;
  tf.colors.resize(random() % 6);
  for (ColorPoint& p : tf.colors) p = {sign * positive(random), color(random)};
  tf.opacities = opacities(random);
  tf.gradient_opacities = sorted(opacities(random));
  if (random() % 2 == 0) tf.below_color = color(random);
  if (random() % 2 == 0) tf.above_color = color(random);
  if (random() % 2 == 0) tf.unit_distance = positive(random);
  tf.nan_color = color(random);
  tf.sort();
  look.shade = random() % 2 == 0;
  look.material = {unit(random), positive(random), 3 * unit(random), positive(random)};
  look.further_lights.resize(random() % 5);
  for (FurtherLight& light : look.further_lights) {
    light.direction = Vec3(unit(random) + 0.1, -unit(random), 1e9 * unit(random));
    light.intensity = 10 * unit(random);
  }
  return look;
}

// Fails if a member is left out, or comes back by one bit different.
TEST(LookText, ComesBackToTheBit) {
  const TestFolder folder;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Look look = random_look(random);
    const std::string text = to_text(look);
    const Look back = look_from_text(text);
    EXPECT_EQ(bits_of(back), bits_of(look)) << text;
    EXPECT_EQ(back.transfer_function.name, look.transfer_function.name);
    if (seed >= 20) continue;
    write_look(look, folder.file("l.json"));
    EXPECT_EQ(content(folder.file("l.json")), text);
    EXPECT_EQ(bits_of(read_look(folder.file("l.json"))), bits_of(look));
  }
}

TEST(LookText, TheLooksOwnUnitDistanceComesBackAsTheFunctions) {
  Look look;
  look.transfer_function.unit_distance = 2;
  look.unit_distance = 1.0 / 3;
  EXPECT_EQ(look_from_text(to_text(look)).transfer_function.unit_distance, 1.0 / 3);
}

// What follows the ways of Lab/CIEDE2000 has been replaced by points, which come back.
TEST(LookText, WaysInLabComeBack) {
  const Look look = look_from_text(
      R"({"ColorSpace": "Lab/CIEDE2000", "RGBPoints": [0, 0, 0, 1, 0.7, 1, 0.1, 0]})");
  ASSERT_GT(look.transfer_function.colors.size(), 2U);
  EXPECT_EQ(bits_of(look_from_text(to_text(look))), bits_of(look));
}

TEST(LookText, OtherKindsAreToldFromTheContentToo) {
  EXPECT_EQ(look_from_text("0 0.25 #ff0000\n1 0.5 #0000ff\n").transfer_function.colors.size(), 2U);
  EXPECT_EQ(look_from_text(R"([{"Name": "a", "Points": [0, 1, 0.5, 0]},
                               {"Name": "b", "Points": [7, 1, 0.5, 0]}])",
                           "text", "b")
                .transfer_function.opacities[0]
                .x,
            7);
}

TEST(CameraText, ComesBackToTheBit) {
  const TestFolder folder;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Camera camera;
    // Its square, too, must be a double.
    camera.position = {-std::sqrt(positive(random)), unit(random), unit(random) - 0.5};
    camera.focal_point = {unit(random), -unit(random) / 3, -0.0};
    camera.view_up = {unit(random) / 7, 1, 0.25 * unit(random)};
    camera.parallel_projection = random() % 2 == 0;
    camera.parallel_scale = positive(random);
    camera.view_angle = 180 * (1e-9 + 0.99 * unit(random));
    const std::string text = to_text(camera);
    EXPECT_EQ(bits_of(camera_from_text(text)), bits_of(camera)) << text;
    if (seed >= 20) continue;
    write_camera(camera, folder.file("c.json"));
    EXPECT_EQ(content(folder.file("c.json")), text);
    EXPECT_EQ(bits_of(read_camera(folder.file("c.json"))), bits_of(camera));
  }
}

template <class Read>
void expect_refused(const Read& read, const std::string& said) {
  try {
    read();
    ADD_FAILURE() << "accepted, expected: " << said;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFileFormat);
    EXPECT_EQ(std::string(error.what()).rfind(said, 0), 0U) << error.what();
  }
}

TEST(LookAndCameraText, ErrorsNameTheSource) {
  expect_refused([] { return look_from_text("[{}]", "--tf"); }, "--tf: the preset has neither");
  expect_refused([] { return look_from_text("{", "--tf"); }, "--tf: not JSON");
  expect_refused([] { return look_from_text("", "--tf"); }, "--tf: is empty");
  expect_refused([] { return camera_from_text(R"({"view_angle": 180})", "--camera"); },
                 "--camera: camera view_angle = 180");
  expect_refused([] { return camera_from_text("[]"); }, "text: []: must be an object");
  const std::string large((std::size_t{16} << 20) + 1, ' ');
  expect_refused([&] { return look_from_text(large); }, "text: must have at most 16777216 bytes");
  expect_refused([&] { return camera_from_text(large); }, "text: must have at most 16777216 bytes");
  Camera invalid;
  invalid.parallel_scale = 0;
  EXPECT_THROW(to_text(invalid), Error);
  Look look;
  look.material.ambient = -1;
  EXPECT_THROW(to_text(look), Error);
}

}  // namespace look_and_camera_text_test
}  // namespace ovoid::io
