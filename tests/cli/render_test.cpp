// SPDX-License-Identifier: Apache-2.0
// What `ovoid render` draws and writes: formats, the same bytes twice, and which flag wins.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program.h"

namespace ovoid::cli_tests {
namespace render_test {

class Render : public ::testing::Test {
 protected:
  // The bytes of a PNG drawn with these words.
  std::string png(Words words) {
    const std::string path = folder_ / "drawn.png";
    words.insert(words.begin(), {"render", ball_});
    words.insert(words.end(), {"-o", path, "--size", "40x30"});
    expect_success(words);
    return read_file(path);
  }
  std::vector<float> npy(Words words) {
    words.insert(words.begin(), ball_);
    return draw(folder_, words).rgba;
  }

  Folder folder_;
  std::string ball_ = write_ball(folder_);
};

TEST_F(Render, NeedsNoFlagButTheOutput) {
  const std::string path = folder_ / "x.png";
  const Outcome result = run({"render", ball_, "-o", path});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  const std::string bytes = read_file(path);
  ASSERT_GT(bytes.size(), 24U);
  EXPECT_EQ(bytes.compare(0, 8, "\x89PNG\r\n\x1a\n"), 0);
  // IHDR holds width and height, big endian, from byte 16: 1024 and 768.
  EXPECT_EQ(bytes.substr(16, 8), std::string("\0\0\4\0\0\0\3\0", 8));
}

TEST_F(Render, NpyHasTheSizeAndHoldsTheBall) {
  const Picture picture = draw(folder_, {ball_, "--size", "40x30"});
  EXPECT_EQ(picture.width, 40);
  EXPECT_EQ(picture.height, 30);
  // The ball covers the middle and not the corners, however it is lit.
  EXPECT_GT(picture.at(20, 15)[3], 0.1F);
  EXPECT_EQ(picture.at(0, 0)[3], 0.0F);
  EXPECT_EQ(picture.at(39, 29)[3], 0.0F);
}

TEST_F(Render, ExrIsWritten) {
  const std::string path = folder_ / "x.exr";
  expect_success({"render", ball_, "-o", path, "--size", "40x30"});
  const std::string bytes = read_file(path);
  EXPECT_EQ(bytes.compare(0, 4, "\x76\x2f\x31\x01"), 0);  // OpenEXR's magic number
  const auto has = [](const std::string& file, const char* channel) {
    return file.find(std::string(1, '\0') + channel + '\0') != std::string::npos;
  };
  for (const char* const channel : {"N.X", "N.Y", "N.Z", "Z", "half_opacity.Z"})
    EXPECT_TRUE(has(bytes, channel)) << channel;
  expect_success({"render", ball_, "-o", path, "--size", "40x30", "--mode", "xray"});
  EXPECT_FALSE(has(read_file(path), "N.X"));  // of no surface
}

TEST_F(Render, EndingsMayBeUpperCase) {
  expect_success({"render", ball_, "-o", folder_ / "X.PNG", "--size", "8x8"});
}

TEST_F(Render, SameBytesTwiceAndForAnyNumberOfThreads) {
  const std::string once = png({"--threads", "1"});
  EXPECT_GT(once.size(), 100U);
  EXPECT_EQ(png({"--threads", "1"}), once);
  EXPECT_EQ(png({"--threads", "3"}), once);
}

TEST_F(Render, SkippingAndStoppingChangeNoByte) {
  const Words look = {"--opacity", "20:0,60:0.9"};
  const std::string fast = png(look);
  for (const char* const flag : {"--no-skip", "--no-stop"}) {
    Words words = look;
    words.emplace_back(flag);
    EXPECT_EQ(png(words), fast) << flag;
  }
}

TEST_F(Render, AnExistingOutputIsReplaced) {
  const std::string path = folder_ / "drawn.png";
  write_file(path, "old");
  EXPECT_EQ(png({}).compare(1, 3, "PNG"), 0);
}

TEST_F(Render, BackgroundMakesAPngOpaqueAndNoneDoesNot) {
  const std::string transparent = png({"--background", "none"});
  EXPECT_EQ(png({"--background", "transparent"}), transparent);
  EXPECT_NE(png({}), transparent);
  const std::string white = png({"--background", "1,1,1"});
  EXPECT_NE(white, transparent);
  EXPECT_EQ(png({"--background", "white"}), white);
  EXPECT_EQ(png({"--background", "#ffffff"}), white);
  EXPECT_EQ(png({"--background", "#fff"}), white);
}

TEST_F(Render, JpegHasABackgroundAlways) {
  const std::string path = folder_ / "x.jpg";
  expect_success({"render", ball_, "-o", path, "--size", "40x30"});
  const std::string dark = read_file(path);
  expect_success({"render", ball_, "-o", path, "--size", "40x30", "--background", "white"});
  EXPECT_NE(read_file(path), dark);
  expect_failure({"render", ball_, "-o", folder_ / "y.jpg", "--background", "none"}, 2,
                 {"--background none", "y.jpg"});
}

TEST_F(Render, TheReferenceBackEndAgrees) {
  // A loose bound, of 8-bit steps: the exact ones are held by the agreement tests; this one fails
  // if --backend draws something else.
  const std::vector<float> cpu = npy({"--backend", "cpu"});
  const std::vector<float> reference = npy({"--backend", "reference"});
  ASSERT_EQ(cpu.size(), reference.size());
  for (std::size_t i = 0; i < cpu.size(); ++i) ASSERT_NEAR(cpu[i], reference[i], 2.0 / 255) << i;
}

TEST_F(Render, EveryNumberFlagIsTaken) {
  const std::vector<float> plain = npy({});
  const std::vector<Words> changes = {{"--sampling-distance", "0.25"},
                                      {"--classification", "sampled"},
                                      {"--classification", "pre-integrated"},
                                      {"--slab", "mean"},
                                      {"--gradient", "central"},
                                      {"--kernel", "gaussian:0.8,4"},
                                      {"--kernel", "gaussian"},
                                      {"--kernel", "gaussian", "--prefilter"},
                                      {"--kernel", "catmull-rom"},
                                      {"--no-prefilter"},
                                      {"--reconstruction", "sum"},
                                      {"--clip", "1,0,0,8"},
                                      {"--colormap", "inferno"},
                                      {"--opacity", "0:0,255:1"},
                                      {"--range", "0,100"},
                                      {"--shift", "30"},
                                      {"--unit-distance", "3"},
                                      {"--view", "+x"},
                                      {"--roll", "30"},
                                      {"--zoom", "1.5"},
                                      {"--projection", "parallel"},
                                      {"--view-angle", "60"},
                                      {"--mode", "maximum"},
                                      {"--mode", "mean"},
                                      {"--mode", "xray"},
                                      {"--mode", "isosurface", "--iso", "100"},
                                      {"--no-shade"},
                                      {"--no-shade", "--occlusion", "0.9"},
                                      {"--no-shade", "--shadows", "0.9"},
                                      {"--ambient", "0.9"},
                                      {"--diffuse", "0.1"},
                                      {"--specular", "0.9"},
                                      {"--specular-power", "50"},
                                      {"--light", "1,1,0"},
                                      {"--light", "headlight"},
                                      {"--light", "studio:1,1,0"},
                                      {"--flat", "0.5"},
                                      {"--fit", "box"},
                                      {"--spacing", "1,1,2"}};
  for (const Words& change : changes) {
    EXPECT_NE(npy(change), plain) << joined(change);
  }
  // Flags that change the work but, by the contract, hardly the picture, are at least accepted.
  for (const Words& same : std::vector<Words>{
           {"--evaluate", "gather"}, {"--evaluate", "scatter"}, {"--post-convolution", "off"}}) {
    EXPECT_EQ(npy(same).size(), plain.size()) << joined(same);
  }
}

TEST_F(Render, FlagsThatNameTheDefaultChangeNothing) {
  EXPECT_EQ(npy({"--colormap", "viridis", "--range", "0,232", "--shade", "--mode", "composite",
                 "--projection", "perspective", "--view-angle", "30", "--view", "+z",
                 "--post-convolution", "off", "--component", "0"})
                .size(),
            npy({}).size());
  EXPECT_EQ(npy({"--shade", "--mode", "composite", "--projection", "perspective", "--view",
                 "three-quarter", "--fit", "visible", "--light", "studio"}),
            npy({}));
  EXPECT_EQ(npy({"--no-shade", "--occlusion", "0"}), npy({"--no-shade"}));
  EXPECT_NE(npy({"--no-shade", "--occlusion", "0.9"}), npy({"--no-shade"}));
  EXPECT_EQ(npy({"--azimuth", "0", "--elevation=0", "--zoom", "+1"}), npy({}));
  EXPECT_EQ(npy({"--dims", "16x16x16", "--type", "uint8", "--spacing", "1,1,1"}), npy({}));
}

TEST_F(Render, NegativeNumbersAreValuesNotFlags) {
  EXPECT_EQ(npy({"--azimuth", "-90"}), npy({"--azimuth=-90"}));
  EXPECT_EQ(npy({"--view", "-x"}), npy({"--view=-x"}));
  EXPECT_EQ(npy({"--range", "-5,300"}), npy({"--range=-5,300"}));
}

TEST_F(Render, TheViewFitsAtAnyViewAngle) {
  // The ball's support ends inside the volume, so a camera that keeps the volume in sight leaves
  // the picture's border empty.
  for (const char* const angle : {"2", "30", "100"}) {
    const Picture picture = draw(folder_, {ball_, "--view-angle", angle, "--fit", "box"});
    EXPECT_GT(picture.num_covered(), 20U) << angle;
    for (int x = 0; x < picture.width; ++x) {
      EXPECT_EQ(picture.at(x, 0)[3], 0.0F) << angle;
      EXPECT_EQ(picture.at(x, picture.height - 1)[3], 0.0F) << angle;
    }
  }
}

TEST_F(Render, CameraFilesAreTurnedByTheFlags) {
  const std::string camera = folder_ / "camera.json";
  write_file(camera, R"({"position": [8, 8, 60], "focal_point": [8, 8, 8], "view_up": [0, 1, 0]})");
  const std::vector<float> loaded = npy({"--camera", camera});
  EXPECT_NE(loaded, npy({}));
  EXPECT_NE(npy({"--camera", camera, "--azimuth", "40"}), loaded);
  EXPECT_NE(npy({"--camera", camera, "--view-angle", "60"}), loaded);
  EXPECT_NE(npy({"--camera", camera, "--projection", "parallel"}), loaded);
  // The order is fixed, whatever the order on the line.
  EXPECT_EQ(npy({"--camera", camera, "--azimuth", "40", "--elevation", "20"}),
            npy({"--elevation", "20", "--azimuth", "40", "--camera", camera}));
}

TEST_F(Render, ClipPlanesRepeat) {
  // Two planes that leave nothing between them.
  EXPECT_EQ(draw(folder_, {ball_, "--clip", "1,0,0,9", "--clip", "-1,0,0,-5"}).num_covered(), 0U);
  EXPECT_GT(draw(folder_, {ball_, "--clip", "1,0,0,5", "--clip", "-1,0,0,-9"}).num_covered(), 0U);
}

TEST_F(Render, RepeatWritesTheUnturnedFrame) {
  const std::string path = folder_ / "repeated.png";
  const Outcome result = run({"render", ball_, "-o", path, "--size", "40x30", "--repeat", "3"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("median of 3"), std::string::npos) << result.err;
  EXPECT_EQ(read_file(path), png({}));
}

TEST_F(Render, ProgressIsNotShownInAPipe) {
  const Outcome result = run(
      {"render", ball_, "-o", folder_ / "x.png", "--size", "200x150", "--backend", "reference"});
  EXPECT_EQ(result.err.find('\r'), std::string::npos) << result.err;
  EXPECT_EQ(result.err.find('%'), std::string::npos) << result.err;
}

// Colours and opacities
// -----------------------------------------------------------------------------------

class RenderLook : public Render {
 protected:
  std::string preset(const std::string& name, const std::string& json) {
    const std::string path = folder_ / name;
    write_file(path, json);
    return path;
  }

  // Red to blue over 0..255, opacity 0 to 0.5.
  std::string red_ = preset("red.json", R"([{"Name": "red", "ColorSpace": "RGB",
    "RGBPoints": [0, 1, 0, 0, 255, 0, 0, 1], "Points": [0, 0, 0.5, 0, 255, 0.5, 0.5, 0]}])");
};

TEST_F(RenderLook, RangeMovesColoursAndOpacitiesOfTheFile) {
  const std::string moved = preset("moved.json", R"([{"Name": "moved", "ColorSpace": "RGB",
    "RGBPoints": [50, 1, 0, 0, 150, 0, 0, 1], "Points": [50, 0, 0.5, 0, 150, 0.5, 0.5, 0]}])");
  EXPECT_EQ(npy({"--tf", red_, "--range", "50,150"}), npy({"--tf", moved}));
}

TEST_F(RenderLook, ColormapReplacesTheFilesColoursAlone) {
  const std::vector<float> file = npy({"--tf", red_, "--no-shade"});
  const std::vector<float> gray = npy({"--tf", red_, "--colormap", "gray", "--no-shade"});
  ASSERT_EQ(file.size(), gray.size());
  for (std::size_t i = 0; i < file.size(); i += 4) {
    ASSERT_EQ(file[i + 3], gray[i + 3]) << "opacity of pixel " << i / 4;
    ASSERT_NEAR(gray[i], gray[i + 1], 1e-5) << "gray pixel " << i / 4;
  }
  EXPECT_NE(file, gray);
}

TEST_F(RenderLook, OpacityReplacesTheFilesOpacitiesAndStaysAbsolute) {
  const std::string steep = preset("steep.json", R"([{"Name": "steep", "ColorSpace": "RGB",
    "RGBPoints": [0, 1, 0, 0, 255, 0, 0, 1], "Points": [20, 0, 0.5, 0, 60, 0.9, 0.5, 0]}])");
  EXPECT_EQ(npy({"--tf", red_, "--opacity", "20:0,60:0.9"}), npy({"--tf", steep}));
  // --range moves colours only here: with a colour map of one colour nothing changes at all.
  const std::string white = preset("white.json", R"([{"Name": "white", "ColorSpace": "RGB",
    "RGBPoints": [0, 1, 1, 1, 255, 1, 1, 1], "Points": [0, 0, 0.5, 0, 255, 0.5, 0.5, 0]}])");
  // Nothing but the rounding of the looked-up opacities: the tables' 4096 entries divide another
  // span. A ramp of 0.9 over 40 values errs by a quarter of an entry's rise at its kinks, 0.9 / 40
  // * 255 / 4096 / 4 = 3.5e-4, at each of at most 16 samples.
  const std::vector<float> ranged =
      npy({"--tf", white, "--opacity", "20:0,60:0.9", "--range", "0,100", "--no-shade"});
  const std::vector<float> plain = npy({"--tf", white, "--opacity", "20:0,60:0.9", "--no-shade"});
  ASSERT_EQ(ranged.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) ASSERT_NEAR(ranged[i], plain[i], 16 * 3.5e-4) << i;
}

TEST_F(RenderLook, UnitDistanceBeatsTheFile) {
  const std::string thick = preset("thick.json", R"([{"Name": "thick", "ColorSpace": "RGB",
    "RGBPoints": [0, 1, 0, 0, 255, 0, 0, 1], "Points": [0, 0, 0.5, 0, 255, 0.5, 0.5, 0],
    "ScalarOpacityUnitDistance": 7}])");
  EXPECT_EQ(npy({"--tf", thick, "--unit-distance", "3"}),
            npy({"--tf", red_, "--unit-distance", "3"}));
  EXPECT_EQ(npy({"--tf", thick}), npy({"--tf", red_, "--unit-distance", "7"}));
}

TEST_F(RenderLook, AFileWithoutOpacitiesGetsTheRampAndANote) {
  const std::string colors = preset("colors.json", R"([{"Name": "colors", "ColorSpace": "RGB",
    "RGBPoints": [0, 1, 0, 0, 255, 0, 0, 1]}])");
  const Outcome result =
      run({"render", ball_, "-o", folder_ / "x.npy", "--size", "40x30", "--tf", colors});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("note: " + colors), std::string::npos) << result.err;
  EXPECT_EQ(read_npy(folder_ / "x.npy").rgba, npy({"--tf", red_}));
}

TEST_F(RenderLook, AFileWithoutColoursGetsTheDefaultOnesAndANote) {
  const std::string points = preset("points.json", R"([{"Name": "points",
    "Points": [20, 0, 0.5, 0, 60, 0.9, 0.5, 0]}])");
  const Outcome result =
      run({"render", ball_, "-o", folder_ / "x.npy", "--size", "40x30", "--tf", points});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("note: " + points), std::string::npos) << result.err;
  EXPECT_EQ(read_npy(folder_ / "x.npy").rgba,
            npy({"--range", "20,60", "--opacity", "20:0,60:0.9", "--occlusion", "0"}));
}

TEST_F(RenderLook, AFileOfASinglePointIsALook) {
  const std::string one = preset("one.json", R"([{"Name": "one", "RGBPoints": [9, 1, 0, 0],
    "Points": [9, 0.5, 0.5, 0]}])");
  EXPECT_GT(draw(folder_, {ball_, "--tf", one}).num_covered(), 0U);
  EXPECT_GT(draw(folder_, {ball_, "--tf", one, "--colormap", "gray"}).num_covered(), 0U);
}

// Fails if a picture without anything in it passes for a success, or if the note blames the wrong
// thing.
TEST_F(RenderLook, EmptyPicturesAreNoted) {
  const auto note = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> words = {"render", ball_, "-o", folder_ / "x.npy", "--size", "40x30"};
    words.insert(words.end(), flags.begin(), flags.end());
    const Outcome result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  EXPECT_EQ(note({}).find("nothing shows"), std::string::npos);
  EXPECT_NE(note({"--opacity", "1000:0,1001:0.5"}).find("no opacity"), std::string::npos);
  EXPECT_NE(note({"--mode", "isosurface", "--iso", "1e6"}).find("--iso 1e+06"), std::string::npos);
  EXPECT_NE(note({"--clip", "0,0,1,1e6"}).find("clipped away"), std::string::npos);
}

TEST_F(RenderLook, ListsAreColoursAndOpacities) {
  EXPECT_EQ(npy({"--opacity", "20,0,60,0.9"}), npy({"--opacity", "20:0,60:0.9"}));
  EXPECT_EQ(npy({"--colormap", "0,0,0,0, 1,1,1,1"}), npy({"--colormap", "gray"}));
  const std::string gray = preset("gray.json", R"([{"Name": "g", "ColorSpace": "RGB",
    "RGBPoints": [20, 0, 0, 0, 90, 1, 1, 1], "Points": [0, 0, 0.5, 0, 255, 0.5, 0.5, 0]}])");
  const std::vector<float> absolute =
      npy({"--tf", red_, "--colormap", "20,0,0,0,90,1,1,1", "--no-shade"});
  EXPECT_EQ(absolute, npy({"--tf", gray, "--no-shade"}));
}

TEST_F(RenderLook, WindowIsAGrayRange) {
  EXPECT_EQ(npy({"--window", "100,80"}), npy({"--range", "30,130", "--colormap", "gray"}));
  EXPECT_EQ(npy({"--window", "100,80", "--colormap", "hot"}),
            npy({"--range", "30,130", "--colormap", "hot"}));
}

TEST_F(RenderLook, OtherProgramsLooksAreReadWithTheirLight) {
  const std::string vp = preset("look.vp",
                                "1\n0\n0.9\n0.1\n0.2\n10\n4 0 0 255 0.5\n4 0 1 9 1\n"
                                "8 0 1 0 0 255 0 0 1\n");
  EXPECT_EQ(npy({"--tf", vp}), npy({"--tf", red_, "--no-shade"}));
  EXPECT_EQ(npy({"--tf", vp, "--shade", "--ambient", "0.3"}),
            npy({"--tf", red_, "--ambient", "0.3", "--diffuse", "0.9"}));
  const std::string json = folder_ / "converted.json";
  expect_success({"convert", vp, "-o", json});
  EXPECT_EQ(npy({"--tf", json}), npy({"--tf", vp}));
}

TEST_F(RenderLook, NamesChooseALook) {
  const std::string two = preset("two.json", R"([{"Name": "a", "ColorSpace": "RGB",
    "RGBPoints": [0, 0, 1, 0, 255, 0, 1, 0], "Points": [0, 0, 0.5, 0, 255, 0.5, 0.5, 0]},
    {"Name": "b", "ColorSpace": "RGB", "RGBPoints": [0, 1, 0, 0, 255, 0, 0, 1],
    "Points": [0, 0, 0.5, 0, 255, 0.5, 0.5, 0]}])");
  EXPECT_EQ(npy({"--tf", two, "--tf-name", "b"}), npy({"--tf", red_}));
  expect_failure({"render", ball_, "-o", folder_ / "x.npy", "--tf", two, "--tf-name", "c"}, 1,
                 {"two.json has a, b"});
}

// Fails if data that begin at 0 cannot be drawn with --log, or if the file's values move.
TEST_F(RenderLook, LogarithmsNeedValuesAboveZero) {
  const Outcome result =
      run({"render", ball_, "-o", folder_ / "x.npy", "--size", "40x30", "--log"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("three decades"), std::string::npos) << result.err;
  expect_failure({"render", ball_, "-o", folder_ / "x.npy", "--log", "--tf", red_}, 1,
                 {"red.json begins at the value 0", "--range"});
  EXPECT_NE(npy({"--log", "--range", "1,255"}), npy({"--range", "1,255"}));
  EXPECT_NE(npy({"--symlog", "1"}), npy({}));
}

TEST_F(RenderLook, PresetsAreDrawn) {
  EXPECT_GT(draw(folder_, {ball_, "--preset", "mr-default"}).num_covered(), 0U);
  EXPECT_GT(draw(folder_, {ball_, "--preset", "label"}).num_covered(), 0U);
  const Outcome far = run({"render", ball_, "-o", folder_ / "x.npy", "--size", "40x30", "--preset",
                           "ct-bone", "--above-color", "1,0,0"});
  EXPECT_EQ(far.exit_code, 0) << far.err;
}

TEST_F(RenderLook, AFileBesideTheDataIsNoted) {
  const Outcome result = run(
      {"render", ball_, "-o", folder_ / "x.npy", "--size", "40x30", "--tf",
       preset("far.json",
              R"([{"Name": "far", "ColorSpace": "RGB", "RGBPoints": [1000, 1, 0, 0, 2000, 0, 0, 1],
    "Points": [1000, 0, 0.5, 0, 2000, 1, 0.5, 0]}])")});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("1000 to 2000"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("--range"), std::string::npos) << result.err;
}

TEST_F(RenderLook, XrayPngIsColouredAndFloatsAreIntegrals) {
  const Outcome result = run({"render", ball_, "-o", folder_ / "x.png", "--size", "40x30", "--mode",
                              "xray", "--colormap", "gray", "--kernel", "gaussian"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("note: x-ray: colours span the integrals 0 to "), std::string::npos)
      << result.err;
  const Outcome ranged = run({"render", ball_, "-o", folder_ / "y.png", "--size", "40x30", "--mode",
                              "xray", "--colormap", "gray", "--range", "0,9000"});
  EXPECT_NE(ranged.err.find("integrals 0 to 9000"), std::string::npos) << ranged.err;
  EXPECT_NE(read_file(folder_ / "x.png"), read_file(folder_ / "y.png"));
  // Through the middle the ball's integral is 2 * 255 * (6 - 3) = 1530 on paper; the kernels blur
  // it and the view is a perspective.
  const Picture picture = draw(folder_, {ball_, "--mode", "xray", "--range", "0,1"});
  EXPECT_NEAR(picture.at(20, 15)[0], 1530, 250);
  EXPECT_EQ(picture.at(20, 15)[0], picture.at(20, 15)[2]);
  EXPECT_EQ(picture.at(20, 15)[3], 1.0F);
}

// What is saved draws the same picture, of the default look and of one that flags have changed.
// Fails if a part of the look is left out, or another one is written.
TEST_F(Render, ASavedLookDrawsTheSamePicture) {
  const std::string look = folder_ / "look.json";
  for (const Words& flags : {Words{}, Words{"--colormap", "inferno", "--specular", "0.7"},
                             Words{"--preset", "cinematic", "--shift", "3"}}) {
    Words words = {"render",      ball_, "-o",     folder_ / "a.npy",
                   "--save-look", look,  "--size", "60x40"};
    words.insert(words.end(), flags.begin(), flags.end());
    const Outcome saved = run(words);
    ASSERT_EQ(saved.exit_code, 0) << saved.err;
    const Outcome drawn =
        run({"render", ball_, "-o", folder_ / "b.npy", "--tf", look, "--size", "60x40"});
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
    EXPECT_TRUE(read_file(folder_ / "a.npy") == read_file(folder_ / "b.npy")) << joined(flags);
  }
  // It is an output like others.
  const std::string picture = folder_ / "c.png";
  EXPECT_EQ(run({"render", ball_, "-o", picture, "--save-look", picture}).exit_code, 2);
  EXPECT_EQ(run({"render", ball_, "-o", picture, "--tf", look, "--save-look", look}).exit_code, 2);
  EXPECT_EQ(run({"render", ball_, "--dry-run", "--save-look", look}).exit_code, 2);
}

// Fails if a picture is left, or one is replaced, where the command's last answer gets nowhere.
TEST_F(Render, SeveralFilesAreWrittenTogether) {
  const std::string picture = folder_ / "picture.png", look = folder_ / "look.json";
  const Words words = {"render", ball_,         "-o", picture,  "--size",
                       "40x30",  "--save-look", look, "--pick", "20,15"};
  const auto fill_out = [] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); };
  const std::size_t before = folder_.num_files();
  EXPECT_EQ(run_after(fill_out, words).exit_code, 1);
  EXPECT_EQ(folder_.num_files(), before);
  write_file(picture, "old");
  EXPECT_EQ(run_after(fill_out, words).exit_code, 1);
  EXPECT_EQ(read_file(picture), "old");
  EXPECT_EQ(folder_.num_files(), before + 1);
  expect_success(words);
  EXPECT_NE(read_file(picture), "old");
  EXPECT_EQ(folder_.num_files(), before + 2);
}

// Profiles
// -------------------------------------------------------------------------------------------------

Words keys_of(const nlohmann::json& json) {
  Words keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  return keys;
}

TEST_F(Render, ProfileHoldsExactlyTheDocumentedMembers) {
  for (const Words& repeat : {Words{}, Words{"--repeat", "3"}}) {
    const std::string path = folder_ / "profile.json";
    Words words = {"render", ball_,       "-o", folder_ / "x.png",  "--size",
                   "40x30",  "--threads", "2",  "--profile=" + path};
    words.insert(words.end(), repeat.begin(), repeat.end());
    const Outcome result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    const nlohmann::json json = nlohmann::json::parse(read_file(path));
    EXPECT_EQ(keys_of(json), (Words{"backend", "blocks", "bytes_loaded", "bytes_uploaded",
                                    "command", "device", "frame_ms", "kernels", "load_ms",
                                    "model_ms", "multiply_adds", "peak_memory_bytes", "samples",
                                    "simd_target", "size", "stages_ms", "threads"}));
    EXPECT_EQ(keys_of(json["frame_ms"]), (Words{"max", "median", "min"}));
    EXPECT_EQ(keys_of(json["kernels"]), (Words{"drawn", "total"}));
    EXPECT_EQ(keys_of(json["samples"]), (Words{"gradients", "reconstructed", "shaded"}));
    EXPECT_EQ(keys_of(json["multiply_adds"]), (Words{"done", "peak"}));
    EXPECT_EQ(keys_of(json["bytes_loaded"]), (Words{"done", "peak"}));
    EXPECT_GE(json["bytes_loaded"]["done"], 16 * 16 * 16);
    EXPECT_EQ(keys_of(json["blocks"]), (Words{"drawn", "skipped", "total"}));
    EXPECT_EQ(keys_of(json["blocks"]["skipped"]), (Words{"empty", "irrelevant", "opaque"}));
    EXPECT_GE(json["stages_ms"].size(), 3U);
    EXPECT_EQ(json["kernels"]["total"], 16 * 16 * 16);
    EXPECT_GT(json["samples"]["shaded"], 0);
    EXPECT_GE(json["samples"]["reconstructed"], json["samples"]["shaded"]);
    EXPECT_LE(json["frame_ms"]["min"], json["frame_ms"]["median"]);
    EXPECT_LE(json["frame_ms"]["median"], json["frame_ms"]["max"]);
    EXPECT_GT(json["frame_ms"]["min"], 0);
    EXPECT_GT(json["peak_memory_bytes"], 1 << 20);
    EXPECT_EQ(json["backend"], "cpu");
    EXPECT_EQ(json["threads"], 2);
    EXPECT_EQ(json["size"], (std::vector<int>{40, 30}));
    EXPECT_NE(json["command"].get<std::string>().find("--profile="), std::string::npos);
  }
}

TEST_F(Render, ProfileWithoutAFileIsATableOnStandardError) {
  const Outcome result =
      run({"render", "--profile", ball_, "-o", folder_ / "x.png", "--size", "40x30"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  for (const char* const row :
       {"load", "model", "frame", "kernels", "samples", "blocks", "peak memory"}) {
    EXPECT_NE(result.err.find(row), std::string::npos) << row << " not in:\n" << result.err;
  }
}

}  // namespace render_test
}  // namespace ovoid::cli_tests
