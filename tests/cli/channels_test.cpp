// SPDX-License-Identifier: Apache-2.0
// Channels of one file in one picture. Fails if one has another's colour, if colours that are there
// as numbers come out as others, or if what is wrong is not named.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>

#include "program.h"

namespace ovoid::cli_tests {
namespace channels_test {

constexpr int kSide = 12;

class Channels : public testing::Test {
 protected:
  // An NRRD of `count` components: component c is value(c, x, y, z), a byte.
  template <class Value>
  std::string write_volume(const std::string& name, int count, const Value& value) {
    std::string bytes = "NRRD0005\ntype: uint8\ndimension: 4\nsizes: " + std::to_string(count);
    for (int axis = 0; axis < 3; ++axis) bytes += " " + std::to_string(kSide);
    bytes += "\nkinds: vector domain domain domain\nencoding: raw\n\n";
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
          for (int c = 0; c < count; ++c) bytes += static_cast<char>(value(c, x, y, z));
    write_file(folder_ / name, bytes);
    return folder_ / name;
  }
  // Two stains, the one left and the other right, seen along z.
  std::string two_stains() {
    return write_volume("stains.nrrd", 2, [](int c, int x, int, int) {
      return (c == 0) == (x < kSide / 2) ? 240 : x % 3;
    });
  }
  Picture picture_of(const std::string& data, const Words& more) {
    Words words = {data, "--size", "40x40", "--view", "-z"};
    if (std::find(more.begin(), more.end(), "maximum") == more.end())
      words.insert(words.end(), {"--no-shade", "--occlusion", "0"});
    words.insert(words.end(), more.begin(), more.end());
    return draw(folder_, words);
  }
  using Sums = std::array<double, 3>;
  // Of a column of the picture.
  static Sums colors_at(const Picture& image, int column) {
    Sums sums{};
    for (int y = 10; y < 30; ++y)
      for (std::size_t c = 0; c < 3; ++c)
        sums[c] += image.rgba[4 * static_cast<std::size_t>(40 * y + column) + c];
    return sums;
  }
  // Of the left and the right quarter, whichever way x goes: the first is that with more red.
  static std::array<Sums, 2> halves(const Picture& image) {
    std::array<Sums, 2> both{colors_at(image, 13), colors_at(image, 27)};
    if (both[0][0] < both[1][0]) std::swap(both[0], both[1]);
    return both;
  }

  Folder folder_;
};

TEST_F(Channels, HaveTheColorsThatAreSaid) {
  const Words said = {"--channels", "all", "--channel-color", "red", "--channel-color", "#00ff00"};
  for (const char* const mode : {"composite", "maximum"}) {
    Words words = said;
    words.insert(words.end(), {"--mode", mode});
    const auto [first, second] = halves(picture_of(two_stains(), words));
    EXPECT_GT(first[0], 2) << mode;
    EXPECT_LT(first[1] + first[2], 0.2 * first[0]) << mode;
    EXPECT_GT(second[1], 2) << mode;
    EXPECT_LT(second[0] + second[2], 0.2 * second[1]) << mode;
  }
}

TEST_F(Channels, ComponentsHaveNumbers) {
  const std::string stains = two_stains();
  EXPECT_EQ(picture_of(stains, {"--channels", "0,1"}).rgba,
            picture_of(stains, {"--channels", "all"}).rgba);
  const Words swapped = {"--channels",      "1,0",    "--channel-color", "#ff00ff",
                         "--channel-color", "#00ff00"};
  EXPECT_NE(picture_of(stains, {"--channels", "1"}).rgba,
            picture_of(stains, {"--channels", "0"}).rgba);
  EXPECT_GT(halves(picture_of(stains, swapped))[0][0], 2);
  const std::string out = folder_ / "p.png";
  expect_failure({"render", stains, "-o", out, "--channels", "0,2"}, 1,
                 {"'2' is not an array", "numbers of components"});
  expect_failure({"render", stains, "-o", out, "--channels", "0,stains"}, 1, {"--channels"});
}

TEST_F(Channels, WithoutAWordAreGreenAndMagenta) {
  const auto [magenta, green] = halves(picture_of(two_stains(), {"--channels", "all"}));
  EXPECT_NEAR(magenta[0], magenta[2], 0.05 * magenta[0]);
  EXPECT_LT(magenta[1], 0.2 * magenta[0]);
  EXPECT_GT(green[1], 2);
  EXPECT_LT(green[0], 0.2 * green[1]);
}

TEST_F(Channels, OfOnePlaceAddUp) {
  const std::string same =
      write_volume("same.nrrd", 2, [](int, int x, int, int) { return x < 2 ? x : 200; });
  const Words said = {"--channels",      "all",     "--channel-color", "red",
                      "--channel-color", "#00ff00", "--channel-range", "0,200",
                      "--channel-range", "0,200"};
  const Sums added = colors_at(picture_of(same, said), 20);
  EXPECT_NEAR(added[0], added[1], 0.02 * added[0]);
  Words averaged = said;
  averaged.insert(averaged.end(), {"--mixing", "averaged"});
  EXPECT_LT(colors_at(picture_of(same, averaged), 20)[0], 0.7 * added[0]);
}

// Fails if "all" ends with the first array.
TEST_F(Channels, AreArrays) {
  std::string bytes = "\x93NUMPY\x01";
  std::string header = "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 12, 12, 12), }";
  header.resize(117, ' ');
  bytes += std::string(1, '\0') + std::string("\x76\0", 2) + header + "\n";
  for (int c = 0; c < 2; ++c)
    for (int i = 0; i < kSide * kSide * kSide; ++i)
      bytes += static_cast<char>((c == 0) == (i % kSide < kSide / 2) ? 240 : i % 3);
  write_file(folder_ / "stack.npy", bytes);
  const Words said = {"--axis-order",    "czyx",   "--channel-color", "red",
                      "--channel-color", "#00ff00"};
  for (const char* const names : {"all", "channel 1,channel 2"}) {
    Words words = said;
    words.insert(words.end(), {"--channels", names});
    const auto [first, second] = halves(picture_of(folder_ / "stack.npy", words));
    EXPECT_GT(first[0], 2) << names;
    EXPECT_GT(second[1], 2) << names;
  }
}

// OME-Zarr of the two stains as bytes, the second of `brightness`: `channels` is what omero says.
std::string write_ome(const Folder& folder, const std::string& name, const std::string& channels,
                      int brightness = 240) {
  const std::string store = folder / name;
  std::filesystem::create_directories(store + "/0");
  write_file(store + "/.zgroup", R"({"zarr_format": 2})");
  write_file(store + "/.zattrs",
             R"({"multiscales": [{"version": "0.4", "axes": [
                  {"name": "c", "type": "channel"}, {"name": "z", "type": "space"},
                  {"name": "y", "type": "space"}, {"name": "x", "type": "space"}],
                "datasets": [{"path": "0", "coordinateTransformations":
                  [{"type": "scale", "scale": [1, 1, 1, 1]}]}]}],
                "omero": {"channels": )" +
                 channels + "}}");
  write_file(store + "/0/.zarray",
             R"({"zarr_format": 2, "shape": [2, 12, 12, 12], "chunks": [1, 12, 12, 12],
                 "dtype": "|u1", "order": "C", "compressor": null, "filters": null,
                 "fill_value": 0})");
  for (int c = 0; c < 2; ++c) {
    std::string bytes;
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
      const bool is_stained = (c == 0) == (i % kSide < kSide / 2);
      bytes += static_cast<char>(!is_stained ? i % 3 : c == 0 ? 240 : brightness);
    }
    write_file(store + "/0/" + std::to_string(c) + ".0.0.0", bytes);
  }
  return store;
}

TEST_F(Channels, OfMicroscopesAreInTheFilesColorsWithoutAFlag) {
  const std::string data =
      write_ome(folder_, "stains.ome.zarr",
                R"([{"label": "a", "color": "FF0000"}, {"label": "b", "color": "00FF00"}])");
  const Picture alone = picture_of(data, {});
  const auto [red, green] = halves(alone);
  EXPECT_GT(red[0], 2);
  EXPECT_LT(red[1] + red[2], 0.2 * red[0]);
  EXPECT_GT(green[1], 2);
  EXPECT_LT(green[0] + green[2], 0.2 * green[1]);
  EXPECT_EQ(alone.rgba, picture_of(data, {"--channels", "all"}).rgba);
  // Flags stand above the file; one array is one array.
  const auto [first, second] = halves(picture_of(
      data, {"--channels", "all", "--channel-color", "green", "--channel-color", "red"}));
  EXPECT_GT(second[1], 2);
  EXPECT_LT(first[1], 0.2 * second[1]);
  EXPECT_NE(picture_of(data, {"--array", "a"}).rgba, alone.rgba);
}

TEST_F(Channels, TakeTheFilesRanges) {
  const std::string data = write_ome(folder_, "dark.ome.zarr",
                                     R"([{"color": "FF0000", "window": {"start": 0, "end": 240}},
                                         {"color": "00FF00", "window": {"start": 0, "end": 240}}])",
                                     24);
  const auto [red, green] = halves(picture_of(data, {"--mode", "maximum"}));
  EXPECT_NEAR(green[1], 0.1 * red[0], 0.03 * red[0]);
}

// Colours that are one for all, as programs write where nobody has chosen, tell nothing apart.
TEST_F(Channels, OfOneColorAreGreenAndMagenta) {
  const std::string data =
      write_ome(folder_, "white.ome.zarr", R"([{"color": "FFFFFF"}, {"color": "FFFFFF"}])");
  const auto [magenta, green] = halves(picture_of(data, {}));
  EXPECT_LT(magenta[1], 0.2 * magenta[0]);
  EXPECT_LT(green[0], 0.2 * green[1]);
}

// Fails if a colour is taken for a value, or is brighter than it is.
TEST_F(Channels, RedGreenAndBlueAreColors) {
  const std::array<int, 4> color{200, 100, 50, 255};
  const std::string data = write_volume(
      "rgba.nrrd", 4, [&](int c, int, int, int) { return color[static_cast<std::size_t>(c)]; });
  const Picture image =
      picture_of(data, {"--channels", "rgb", "--range", "0,255", "--opacity", "0:0.8,255:0.8"});
  const std::size_t middle = 4 * (40 * 20 + 20);
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(image.rgba[middle + c], color[c] / 255.0 * image.rgba[middle + 3], 5e-3) << c;
  EXPECT_GT(image.rgba[middle + 3], 0.9);
}

// Fails while channels but the first stand still.
TEST_F(Channels, MoveInFilms) {
  const auto stains = [&](const std::string& name, int border) {
    return write_volume(name, 2, [border](int c, int x, int, int) {
      return (c == 0) == (x < border) ? 240 : x % 3;
    });
  };
  const std::string first = stains("s0.nrrd", kSide / 2), second = stains("s1.nrrd", kSide / 4);
  // Nothing of these looks is found in the data, of which each step has its own.
  const Words look = {"--channels", "all", "--channel-range", "0,255", "--channel-range", "0,255",
                      "--fit",      "box", "--size",          "40x40", "--view",          "-z",
                      "--no-shade"};
  const auto run_with = [&](Words words) {
    words.insert(words.end(), look.begin(), look.end());
    expect_success(words);
  };
  run_with({"animate", first, second, "-o", folder_ / "f_%d.npy"});
  for (const int step : {0, 1}) {
    const std::string number = std::to_string(step);
    run_with({"render", first, second, "--step", number, "-o", folder_ / "one.npy"});
    EXPECT_TRUE(read_file(folder_ / ("f_" + number + ".npy")) == read_file(folder_ / "one.npy"))
        << step;
  }
}

TEST_F(Channels, SayWhatIsWrong) {
  const std::string data = two_stains();
  const auto refusal = [&](const Words& more) {
    Words words = {"render", data, "-o", folder_ / "p.png"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = run(words);
    EXPECT_NE(outcome.exit_code, 0);
    return outcome.err;
  };
  const auto has = [](const std::string& text, const char* part) {
    return testing::AssertionResult(text.find(part) != std::string::npos) << text;
  };
  EXPECT_TRUE(has(refusal({"--channels", "DAPI"}), "'DAPI' is not an array"));
  EXPECT_TRUE(has(refusal({"--channels", "rgb"}), "has 2 components"));
  EXPECT_TRUE(has(refusal({"--channels", "all,"}), "--channels"));
  EXPECT_TRUE(has(refusal({"--channels", "all", "--mode", "xray"}), "composite"));
  EXPECT_TRUE(has(refusal({"--channels", "all", "--opacity", "0:0,9:1"}), "--channel-range"));
  EXPECT_TRUE(has(refusal({"--channel-color", "red"}), "without --channels"));
  EXPECT_TRUE(has(refusal({"--channels", "all", "--channel-color", "red", "--channel-color", "red",
                           "--channel-color", "red"}),
                  "given 3 times, for 2 channels"));
}

}  // namespace channels_test
}  // namespace ovoid::cli_tests
