// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/space_part.h"

namespace ovoid::io {
namespace deep_exr_test {

// 3 x 2 pixels: one with two runs, one with one, four with none.
PicturePart small_part() {
  constexpr float kNowhere = std::numeric_limits<float>::infinity();
  PicturePart part;
  part.number = 2;
  part.count = 7;
  part.picture = "size 3x2\ncamera {}\n";
  part.look.transfer_function.colors = {{0, {0, 0, 0}}, {1, {1, 0.5, 0.25}}};
  part.look.transfer_function.opacities = {{0, 0}, {1, 1}};
  part.seen.width = 3;
  part.seen.height = 2;
  part.seen.mode = Mode::kMean;
  part.seen.first = {0, 0, 2, 2, 3, 3, 3};
  part.seen.runs = {{-20, -3, {0.1F, 0.2F, 0.3F, 0.4F}, kNowhere, 2.5F, 1},
                    {-3, 40, {0.5F, 0.25F, 0, 1}, 7, 6, 1},
                    {kFirstSheet, kLastSheet, {1, 2, 0, 1}, 1, 1, 0.5F}};
  return part;
}

TEST(PictureParts, AreReadAsTheyWereWritten) {
  const TestFolder folder;
  const PicturePart part = small_part();
  write_picture_part(part, folder.file("a.exr"));
  const PicturePart back = read_picture_part(folder.file("a.exr"));
  EXPECT_EQ(back.seen, part.seen);
  EXPECT_EQ(back.number, 2);
  EXPECT_EQ(back.count, 7);
  EXPECT_EQ(back.picture, part.picture);
  EXPECT_EQ(to_text(back.look), to_text(part.look));
}

// Fails if a mode goes by the word of another, so that another picture is made of the parts.
TEST(PictureParts, KeepTheirMode) {
  const TestFolder folder;
  for (const Mode mode : {Mode::kComposite, Mode::kXray, Mode::kMaximum, Mode::kMean,
                          Mode::kIsosurface, Mode::kMinimum}) {
    PicturePart part = small_part();
    part.seen.mode = mode;
    write_picture_part(part, folder.file("a.exr"));
    EXPECT_EQ(read_picture_part(folder.file("a.exr")).seen.mode, mode);
  }
}

// A file whose mode's word is unknown is refused, and not taken for the first mode.
TEST(PictureParts, RefuseAnUnknownMode) {
  const TestFolder folder;
  write_picture_part(small_part(), folder.file("a.exr"));
  std::string content = folder.read("a.exr");
  const std::size_t at = content.find("mean", content.find("ovoid.mode"));
  ASSERT_NE(at, std::string::npos);
  folder.write("b.exr", content.replace(at, 4, "most"));
  EXPECT_EQ(error_of([&] { read_picture_part(folder.file("b.exr")); }),
            "file-format: " + folder.file("b.exr") + ": ovoid.mode: an unknown mode");
}

TEST(PictureParts, AreToldFromPictures) {
  const TestFolder folder;
  Image image;
  image.width = image.height = 1;
  image.rgba = {0, 0, 0, 0};
  image.depth = image.front_depth = {1};
  write_image(image, folder.file("flat.exr"));
  folder.write("text.exr", "no picture");
  for (const char* const name : {"flat.exr", "text.exr"}) {
    try {
      read_picture_part(folder.file(name));
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFileFormat) << name;
      const std::string said = error.what();
      EXPECT_NE(said.find(name), std::string::npos) << said;
      EXPECT_NE(said.find("not a part of a picture: expected what ovoid render --part"),
                std::string::npos)
          << said;
    }
  }
  EXPECT_THROW(read_picture_part(folder.file("none.exr")), Error);
}

// Wherever a file ends too early it is refused.
TEST(PictureParts, MayNotEndEarly) {
  const TestFolder folder;
  write_picture_part(small_part(), folder.file("a.exr"));
  const std::string whole = folder.read("a.exr");
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    folder.write("b.exr", whole.substr(0, size));
    EXPECT_THROW(read_picture_part(folder.file("b.exr")), Error) << size;
  }
}

}  // namespace deep_exr_test
}  // namespace ovoid::io
