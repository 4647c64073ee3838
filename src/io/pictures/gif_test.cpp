// SPDX-License-Identifier: Apache-2.0
// GIF films, read back with giflib: fails if colours, times, the loop or transparency are otherwise
// than include/ovoid/io.h says.
#include <gif_lib.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/pictures/palette.h"
#include "io/pictures/pictures.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "support/where.h"

namespace ovoid::io {
namespace gif_test {

struct GifFrame {
  std::vector<std::uint8_t> rgba;
  int delay_cs = -1;
  int disposal = -1;
};

struct GifFilm {
  int width = 0, height = 0;
  int num_loops = -1;  // 0: without end
  std::vector<GifFrame> frames;
};

GifFilm read_gif(const std::string& path) {
  int error = 0;
  GifFileType* const gif = DGifOpenFileName(path.c_str(), &error);
  GifFilm film;
  if (gif == nullptr || DGifSlurp(gif) != GIF_OK) {
    ADD_FAILURE() << path << " is no GIF: " << error;
    return film;
  }
  film.width = gif->SWidth;
  film.height = gif->SHeight;
  for (int i = 0; i < gif->ImageCount; ++i) {
    const SavedImage& image = gif->SavedImages[i];
    for (int k = 0; k + 1 < image.ExtensionBlockCount; ++k) {
      const ExtensionBlock& block = image.ExtensionBlocks[k];
      const ExtensionBlock& next = image.ExtensionBlocks[k + 1];
      if (block.Function == APPLICATION_EXT_FUNC_CODE && block.ByteCount == 11 &&
          std::memcmp(block.Bytes, "NETSCAPE2.0", 11) == 0 && next.ByteCount == 3)
        film.num_loops = next.Bytes[1] + 256 * next.Bytes[2];
    }
    GraphicsControlBlock control{};
    EXPECT_EQ(DGifSavedExtensionToGCB(gif, i, &control), GIF_OK);
    GifFrame frame;
    frame.delay_cs = control.DelayTime;
    frame.disposal = control.DisposalMode;
    EXPECT_EQ(image.ImageDesc.Width, film.width);
    EXPECT_EQ(image.ImageDesc.Height, film.height);
    for (int p = 0; p < film.width * film.height; ++p) {
      const int index = image.RasterBits[p];
      const GifColorType& color = gif->SColorMap->Colors[index];
      const bool is_clear = index == control.TransparentColor;
      for (const int value : {+color.Red, +color.Green, +color.Blue, is_clear ? 0 : 255})
        frame.rgba.push_back(static_cast<std::uint8_t>(value));
    }
    film.frames.push_back(frame);
  }
  DGifCloseFile(gif, &error);
  return film;
}

using PixelAt = std::function<std::array<int, 4>(int x, int y)>;

std::vector<std::uint8_t> pixels_of(int width, int height, const PixelAt& pixel_at) {
  std::vector<std::uint8_t> rgba;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int value : pixel_at(x, y)) rgba.push_back(static_cast<std::uint8_t>(value));
    }
  }
  return rgba;
}

TEST(Gif, FewColorsAreTheirOwn) {
  OVOID_NOT_UNDER_TSAN();
  const TestFolder folder;
  std::vector<std::string> names;
  std::vector<std::vector<std::uint8_t>> pictures;
  for (int i = 0; i < 3; ++i) {  // 3 x 85 colours, one apart from the next
    pictures.push_back(pixels_of(17, 5, [&](int x, int y) {
      return std::array<int, 4>{17 * y + x, 3 * i, 255 - 100 * i, 255};
    }));
    names.push_back(folder.file(std::to_string(i) + ".png"));
    write_png(pictures.back(), 17, 5, names.back());
  }
  write_gif(names, folder.file("a.gif"), 25);
  const GifFilm film = read_gif(folder.file("a.gif"));
  EXPECT_EQ(film.width, 17);
  EXPECT_EQ(film.height, 5);
  EXPECT_EQ(film.num_loops, 0);
  ASSERT_EQ(film.frames.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(film.frames[i].rgba, pictures[i]) << i;
    EXPECT_EQ(film.frames[i].delay_cs, 4);
    EXPECT_EQ(film.frames[i].disposal, DISPOSE_DO_NOT);
  }
  EXPECT_EQ(folder.count(), 4);
}

TEST(Gif, TimesAreRoundedFromTheFilmsStart) {
  OVOID_NOT_UNDER_TSAN();
  const TestFolder folder;
  const std::string name = folder.file("a.png");
  write_png(pixels_of(2, 2, [](int, int) { return std::array<int, 4>{9, 9, 9, 255}; }), 2, 2, name);
  const auto delays = [&](double fps, std::size_t num_frames) {
    write_gif(std::vector<std::string>(num_frames, name), folder.file("a.gif"), fps);
    std::vector<int> all;
    for (const GifFrame& frame : read_gif(folder.file("a.gif")).frames)
      all.push_back(frame.delay_cs);
    return all;
  };
  EXPECT_EQ(delays(12.5, 3), (std::vector<int>{8, 8, 8}));
  EXPECT_EQ(delays(50, 2), (std::vector<int>{2, 2}));
  // Ends at 3.33, 6.67, 10 hundredths.
  EXPECT_EQ(delays(30, 6), (std::vector<int>{3, 4, 3, 3, 4, 3}));
  EXPECT_EQ(delays(kMinGifFps, 2), (std::vector<int>{50000, 50000}));
}

// 65536 colours in a square, which parts in halves: 256 squares of 16 x 16, whose variance is
// (16^2 - 1) / 12 along each side, and the rounding of a mean adds at most 1/4.
TEST(Gif, APaletteIsAsNearAsItCanBe) {
  OVOID_NOT_UNDER_TSAN();
  ColorCounts counts;
  counts.add(pixels_of(256, 256, [](int x, int y) { return std::array<int, 4>{x, 7, y, 255}; }));
  const std::vector<Rgb8> palette = counts.palette(256);
  EXPECT_EQ(palette.size(), 256U);
  double sum = 0;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      int least = 1 << 20;
      for (const Rgb8& color : palette) {
        least = std::min(least, (color[0] - x) * (color[0] - x) + (color[2] - y) * (color[2] - y));
        EXPECT_EQ(color[1], 7);
      }
      sum += least;
    }
  }
  EXPECT_LE(sum / 65536, 2 * (255.0 / 12 + 0.25));
}

// A thin line of a colour far from all others keeps it, as its error counts by the square. Of its
// 128 pixels that is 128 x 255^2, more than is won where all others, 524288 pixels in a square of
// 256 x 256 colours, are parted to the end: two halves of 16384 pixels whose means lie 32 apart,
// 16384 / 4 x 32^2.
TEST(Gif, RareColorsFarFromOthersStay) {
  OVOID_NOT_UNDER_TSAN();
  ColorCounts counts;
  counts.add(pixels_of(1024, 512, [](int x, int y) {
    return std::array<int, 4>{x / 4, y, 0, 255};
  }));
  counts.add(pixels_of(128, 1, [](int, int) { return std::array<int, 4>{20, 30, 255, 255}; }));
  const std::vector<Rgb8> palette = counts.palette(64);
  EXPECT_EQ(std::count(palette.begin(), palette.end(), Rgb8{20, 30, 255}), 1);
}

// Of a pattern's 64 pixels as many are the other colour as its share says.
TEST(Gif, ColorsBetweenTwoAreMixed) {
  OVOID_NOT_UNDER_TSAN();
  PaletteMatcher matcher({{0, 0, 0}, {255, 255, 255}, {200, 0, 0}});
  const auto count = [&](const Rgb8& color, std::uint8_t index) {
    int sum = 0;
    for (int y = 8; y < 16; ++y) {
      for (int x = 16; x < 24; ++x) sum += matcher.index(color, x, y) == index ? 1 : 0;
    }
    return sum;
  };
  EXPECT_EQ(count({64, 64, 64}, 1), 16);
  EXPECT_EQ(count({64, 64, 64}, 0), 48);
  EXPECT_EQ(count({100, 0, 0}, 2), 32);
  EXPECT_EQ(count({255, 255, 255}, 1), 64);
  EXPECT_EQ(count({200, 0, 0}, 2), 64);
}

// 4096 colours 4 apart: the palette's lie 16 apart, so the nearest is at most 3 x 4 / 2 x sqrt(2)
// away, and the one that is mixed in at most two cells' sides further.
TEST(Gif, ManyColorsAreNearTheirOwn) {
  OVOID_NOT_UNDER_TSAN();
  const TestFolder folder;
  const auto picture = pixels_of(64, 64, [](int x, int y) {
    return std::array<int, 4>{4 * x, 4 * y, 0, 255};
  });
  write_png(picture, 64, 64, folder.file("a.png"));
  write_gif({folder.file("a.png")}, folder.file("a.gif"), 10);
  const GifFilm film = read_gif(folder.file("a.gif"));
  ASSERT_EQ(film.frames.size(), 1U);
  double worst = 0;
  for (std::size_t i = 0; i < picture.size(); i += 4) {
    const auto off = [&](std::size_t c) { return film.frames[0].rgba[i + c] - picture[i + c]; };
    worst = std::max(worst, std::hypot(off(0), off(1), off(2)));
  }
  EXPECT_LE(worst, 8.5 + 32);
}

TEST(Gif, LessThanHalfOpaqueIsClear) {
  OVOID_NOT_UNDER_TSAN();
  const TestFolder folder;
  std::vector<std::string> names;
  for (int i = 0; i < 2; ++i) {
    names.push_back(folder.file(std::to_string(i) + ".png"));
    write_png(pixels_of(16, 16,
                        [&](int x, int y) {
                          return std::array<int, 4>{x, 10, 0, i == 0 ? 16 * x + y : 255};
                        }),
              16, 16, names.back());
  }
  write_gif(names, folder.file("a.gif"), 10);
  const GifFilm film = read_gif(folder.file("a.gif"));
  ASSERT_EQ(film.frames.size(), 2U);
  for (const GifFrame& frame : film.frames) EXPECT_EQ(frame.disposal, DISPOSE_BACKGROUND);
  for (std::size_t y = 0; y < 16; ++y) {
    for (std::size_t x = 0; x < 16; ++x) {
      const std::uint8_t* const first = film.frames[0].rgba.data() + 4 * (16 * y + x);
      EXPECT_EQ(first[3], 16 * x + y >= 128 ? 255 : 0);
      if (first[3] != 0) {
        EXPECT_EQ(first[0], x);
      }
      EXPECT_EQ(film.frames[1].rgba[4 * (16 * y + x) + 3], 255);
    }
  }
  // Nothing but background.
  write_png(std::vector<std::uint8_t>(4), 1, 1, names[0]);
  write_gif({names[0]}, folder.file("a.gif"), 10);
  EXPECT_EQ(read_gif(folder.file("a.gif")).frames.at(0).rgba[3], 0);
}

TEST(Gif, Errors) {
  OVOID_NOT_UNDER_TSAN();
  const TestFolder folder;
  const std::string film = folder.file("a.gif");
  const std::string large = folder.file("large.png");
  const std::string small = folder.file("small.png");
  write_png(std::vector<std::uint8_t>(16, 255), 2, 2, large);
  write_png(std::vector<std::uint8_t>(8, 255), 2, 1, small);
  const auto error = [&](const std::vector<std::string>& names, const std::string& path,
                         double fps) { return error_of([&] { write_gif(names, path, fps); }); };
  folder.write("a.gif", "what was there");
  EXPECT_EQ(error({}, film, 10), "invalid-argument: pictures: is empty: expected at least one");
  EXPECT_EQ(error({large, small}, film, 10),
            "invalid-argument: " + small + ": is 2x1: expected 2x2, as the first picture is");
  for (const double fps : {50.1, 0.0019, std::nan("")}) {
    EXPECT_NE(error({large}, film, fps).find("expected 0.002 to 50"), std::string::npos) << fps;
  }
  EXPECT_EQ(error({folder.write("no.png", "no picture")}, film, 10).substr(0, 12), "file-format:");
  EXPECT_EQ(error({large}, folder.file("no/a.gif"), 10).substr(0, 11), "file-write:");
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(error_of([&] { write_gif({large}, film, 10, {source.get_token()}); }).substr(0, 10),
            "cancelled:");
  EXPECT_EQ(folder.read("a.gif"), "what was there");
  EXPECT_EQ(folder.count(), 4);
}

// Fails if the second reading of the pictures is not told of, or the token not looked at between
// them.
TEST(Gif, TellsHowFarItIsAndStops) {
  OVOID_NOT_UNDER_TSAN();
  const TestFolder folder;
  const std::string name = folder.file("a.png");
  write_png(std::vector<std::uint8_t>(16, 255), 2, 2, name);
  const std::vector<std::string> names(4, name);
  std::vector<double> told;
  WriteOptions options;
  options.progress = [&](double fraction) { told.push_back(fraction); };
  write_gif(names, folder.file("a.gif"), 10, options);
  ASSERT_EQ(told.size(), 8U);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GT(told.front(), 0);
  EXPECT_DOUBLE_EQ(told.back(), 1);
  for (const std::size_t last : {2U, 6U}) {
    std::stop_source source;
    options.stop = source.get_token();
    told.clear();
    options.progress = [&](double fraction) {
      told.push_back(fraction);
      if (told.size() == last) source.request_stop();
    };
    EXPECT_EQ(error_of([&] { write_gif(names, folder.file("b.gif"), 10, options); }).substr(0, 10),
              "cancelled:");
    EXPECT_EQ(told.size(), last);
  }
  EXPECT_EQ(folder.count(), 2);
}

// A device that takes nothing.
TEST(Gif, AFullDiskIsTold) {
  OVOID_NOT_UNDER_TSAN();
  const TestFolder folder;
  write_png(std::vector<std::uint8_t>(16, 255), 2, 2, folder.file("a.png"));
  EXPECT_EQ(error_of([&] { write_gif({folder.file("a.png")}, "/dev/full", 10); }).substr(0, 11),
            "file-write:");
}

}  // namespace gif_test
}  // namespace ovoid::io
