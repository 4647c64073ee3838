// SPDX-License-Identifier: Apache-2.0
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/images/npy.h"
#include "io/images/test_volumes.h"
#include "ovoid/encode.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace write_image_test {

Image small_image() {
  Image image;
  image.width = 3;
  image.height = 2;
  image.rgba = {1,     0,     0,     1,    0, 0.5F, 0, 0.5F, 0, 0, 0, 0,
                0.25F, 0.25F, 0.25F, 0.5F, 0, 0,    1, 1,    1, 1, 1, 1};
  image.depth = {1, 2, std::numeric_limits<float>::infinity(), 4.5F, 5, 6};
  image.front_depth = {0.5F, 1.5F, std::numeric_limits<float>::infinity(), 4, 4.5F, 6};
  return image;
}

TEST(WriteImage, PngReadsBackAsStraightAlpha) {
  const TestFolder folder;
  write_image(small_image(), folder.file("a.png"));
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&png, folder.file("a.png").c_str()), 0);
  EXPECT_EQ(png.width, 3U);
  EXPECT_EQ(png.height, 2U);
  png.format = PNG_FORMAT_RGBA;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(png));
  ASSERT_NE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr), 0);
  EXPECT_EQ(pixels, to_rgba8(small_image()));
  EXPECT_NE(folder.read("a.png").find("sRGB"), std::string::npos);
}

// A header that says so, the size, and after decoding (its mean colour by size alone) a picture on
// its background.
TEST(WriteImage, JpegIsOneOnItsBackground) {
  const TestFolder folder;
  Image image;
  image.width = 40;
  image.height = 24;
  image.rgba.assign(4UL * 40 * 24, 0.0F);
  image.depth.assign(40UL * 24, 1.0F);
  image.front_depth = image.depth;
  write_image(image, folder.file("a.jpg"), Rgb{1, 0.5, 0});
  write_image(image, folder.file("b.jpeg"), Rgb{1, 0.5, 0});
  write_image(image, folder.file("c.jpg"));
  const std::string bytes = folder.read("a.jpg");
  EXPECT_EQ(bytes.substr(0, 3), "\xff\xd8\xff");
  EXPECT_EQ(bytes.substr(bytes.size() - 2), "\xff\xd9");
  EXPECT_NE(bytes.find(std::string("\xff\xc0\x00\x11\x08\x00\x18\x00\x28\x03", 10)),
            std::string::npos);  // 24 rows of 40, three components
  EXPECT_EQ(folder.read("b.jpeg"), bytes);
  EXPECT_NE(folder.read("c.jpg"), bytes);
}

// Fails if one of the two has bytes of its own.
TEST(EncodeImage, GivesTheBytesOfTheFile) {
  const TestFolder folder;
  const Rgb orange{1, 0.5, 0};
  const Image image = small_image();
  write_image(image, folder.file("a.png"));
  write_image(image, folder.file("b.png"), orange);
  write_image(image, folder.file("a.jpg"), orange);
  EXPECT_EQ(encode_png(image), folder.read("a.png"));
  EXPECT_EQ(encode_png(image, orange), folder.read("b.png"));
  EXPECT_EQ(encode_jpeg(image, orange), folder.read("a.jpg"));
  EXPECT_NE(encode_jpeg(image, orange, 20), folder.read("a.jpg"));
  for (const int quality : {0, 101}) EXPECT_THROW(encode_jpeg(image, orange, quality), Error);
  EXPECT_THROW(encode_png(Image{}), Error);
}

// A JPEG's sides have 16 bits; libjpeg refuses longer ones, and its words come through.
TEST(EncodeImage, TellsWhatAFormatCannotHold) {
  Image wide;
  wide.width = 70000;
  wide.height = 1;
  wide.rgba.assign(4UL * 70000, 0.5F);
  wide.depth.assign(70000, 1.0F);
  wide.front_depth = wide.depth;
  try {
    encode_jpeg(wide, Rgb{0, 0, 0});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFileWrite);
    EXPECT_NE(std::string(error.what()).find("65500"), std::string::npos) << error.what();
  }
}

// Fails if a channel has another name, numbers or order.
TEST(WriteImage, ExrKeepsFloatsDepthsAndNormals) {
  const TestFolder folder;
  Image image = small_image();
  image.normals = {1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, -1, 0.6F, -0.8F, 0.0F, 0, 1, 0};
  write_image(image, folder.file("a.exr"));
  Imf::InputFile file(folder.file("a.exr").c_str());
  Image back = image;
  back.rgba.assign(24, -1);
  back.depth.assign(6, -1);
  back.front_depth.assign(6, -1);
  back.normals.assign(18, -1);
  Imf::FrameBuffer frame;
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_NE(file.header().channels().findChannel(std::string(1, "RGBA"[i])), nullptr);
    frame.insert(std::string(1, "RGBA"[i]),
                 Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(back.rgba.data() + i), 16, 48));
  }
  const auto add = [&](const std::string& name, float* first, std::size_t stride) {
    ASSERT_NE(file.header().channels().findChannel(name), nullptr) << name;
    frame.insert(name,
                 Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(first), 4 * stride, 12 * stride));
  };
  add("Z", back.front_depth.data(), 1);
  add("half_opacity.Z", back.depth.data(), 1);
  for (std::size_t a = 0; a < 3; ++a) add(std::string("N.") + "XYZ"[a], back.normals.data() + a, 3);
  file.setFrameBuffer(frame);
  file.readPixels(0, 1);
  EXPECT_EQ(back, image);
  EXPECT_EQ(file.header().channels()["R"].type, Imf::FLOAT);
  write_image(small_image(), folder.file("b.exr"));
  const Imf::InputFile without(folder.file("b.exr").c_str());
  EXPECT_EQ(without.header().channels().findChannel("N.X"), nullptr);
}

TEST(WriteImage, NpyIsHeightWidthFour) {
  const TestFolder folder;
  const Image image = small_image();
  write_image(image, folder.file("a.npy"));
  const std::string content = folder.read("a.npy");
  const std::int64_t shape[] = {2, 3, 4};
  EXPECT_EQ(content, npy_header(ScalarType::kFloat32, shape) + bytes_of(image.rgba));
}

TEST(WriteImage, SamePictureSameBytes) {
  const TestFolder folder;
  for (const char* ending : {".png", ".exr", ".npy"}) {
    const std::string a = std::string("a") + ending, b = std::string("b") + ending;
    write_image(small_image(), folder.file(a));
    write_image(small_image(), folder.file(b));
    EXPECT_EQ(folder.read(a), folder.read(b)) << ending;
  }
  EXPECT_EQ(folder.count(), 6);
}

TEST(WriteImage, BackgroundGoesBehindPngOnly) {
  const TestFolder folder;
  const Rgb white{1, 1, 1};
  write_image(small_image(), folder.file("a.png"), white);
  write_image(small_image(), folder.file("b.png"));
  EXPECT_NE(folder.read("a.png"), folder.read("b.png"));
}

TEST(WriteImage, Errors) {
  const TestFolder folder;
  Image image = small_image();
  const auto error = [&](const std::string& path) {
    return error_of([&] { write_image(image, path); });
  };
  EXPECT_EQ(error("a.bmp"),
            "unsupported: a.bmp: the ending '.bmp' names no picture format: expected .png, .jpg, "
            ".exr or .npy");
  for (const char* name : {"no/a.png", "no/a.exr", "no/a.npy"})
    EXPECT_EQ(error(folder.file(name)).substr(0, 11), "file-write:") << name;
  EXPECT_EQ(error_of([&] { check_image_path(folder.file("no/a.png")); }).substr(0, 11),
            "file-write:");
  EXPECT_EQ(error_of([] { check_image_path("a.bmp"); }).substr(0, 12), "unsupported:");
  check_image_path(folder.file("a.png"));
  image.depth.pop_back();
  EXPECT_EQ(error(folder.file("a.png")),
            "invalid-argument: image: 3x2 has 24 colour, 5 depth and 6 front depth values: "
            "expected 24, 6 and 6");
  image = small_image();
  image.normals.assign(6, 0.0F);
  EXPECT_EQ(error(folder.file("a.exr")),
            "invalid-argument: image: 3x2 has 6 values of normals: expected 18, or none");
  image = {};
  EXPECT_EQ(error(folder.file("a.png")),
            "invalid-argument: image: is 0x0: expected at least one pixel");
  EXPECT_EQ(folder.count(), 0);
}

}  // namespace write_image_test
}  // namespace ovoid::io
