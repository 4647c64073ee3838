// SPDX-License-Identifier: Apache-2.0
// Command lines that cannot be right: exit code 2, one line that names the flag, its value and what
// was expected, and no file.
#include <gtest/gtest.h>

#include "program.h"

namespace ovoid::cli_tests {
namespace usage_test {

// Every case is `ovoid render BALL -o OUT` and these words.
struct Case {
  Words words;
  Words fragments;
};

void expect_all_refused(const std::vector<Case>& cases) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  for (const Case& bad : cases) {
    Words words = {"render", ball, "-o", folder / "out.png"};
    words.insert(words.end(), bad.words.begin(), bad.words.end());
    expect_failure(words, 2, bad.fragments);
  }
  EXPECT_EQ(folder.num_files(), 1U) << "a refused command left a file";
}

TEST(Usage, BadValuesNameFlagValueAndExpectation) {
  expect_all_refused({
      {{"--size", "640"}, {"--size '640'", "expected WIDTHxHEIGHT"}},
      {{"--size", "0x5"}, {"--size '0x5'", "1 to 32768"}},
      {{"--size", "99999x2"}, {"--size '99999x2'", "1 to 32768"}},
      {{"--size", "64x48x2"}, {"--size '64x48x2'"}},
      {{"--size", "64.5x48"}, {"--size '64.5x48'"}},
      {{"--background", "1,1"}, {"--background '1,1'", "expected 3 numbers"}},
      {{"--background", "0,0,2"}, {"--background '0,0,2'", "in [0, 1]"}},
      {{"--dims", "4x4"}, {"--dims '4x4'", "expected XxYxZ"}},
      {{"--dims", "4x4x0"}, {"--dims '4x4x0'"}},
      {{"--dims", "99999999999999999999x1x1"}, {"--dims '99999999999999999999x1x1'"}},
      {{"--type", "uint7"}, {"--type 'uint7'", "expected one of uint8"}},
      {{"--spacing", "1,0,1"}, {"--spacing '1,0,1'", "> 0"}},
      {{"--spacing", "1,nan,1"}, {"--spacing '1,nan,1'"}},
      {{"--spacing", "1e-300,1,1"}, {"--spacing '1e-300,1,1'", "1e-90"}},
      {{"--component", "-1"}, {"--component '-1'", "magnitude"}},
      {{"--colormap", "viridiss"}, {"--colormap 'viridiss'", "did you mean viridis?"}},
      {{"--opacity", "1"}, {"--opacity '1'", "VALUE:OPACITY"}},
      {{"--opacity", "0:0,5:1.5"}, {"--opacity '0:0,5:1.5'", "'5:1.5'"}},
      {{"--opacity", "5:0,2:1"}, {"--opacity '5:0,2:1'", "rising"}},
      {{"--range", "5,5"}, {"--range '5,5'", "LO < HI"}},
      {{"--range", "9,1"}, {"--range '9,1'", "LO < HI"}},
      {{"--range", "0,inf"}, {"--range '0,inf'"}},
      {{"--range", "-1e308,1e308"}, {"--range '-1e308,1e308'", "difference"}},
      {{"--unit-distance", "0"}, {"--unit-distance '0'", "> 0"}},
      {{"--view", "+w"}, {"--view '+w'", "+x, -x"}},
      {{"--azimuth", "12deg"}, {"--azimuth '12deg'", "expected a number"}},
      {{"--zoom", "0"}, {"--zoom '0'", "> 0"}},
      {{"--projection", "oblique"}, {"--projection 'oblique'", "parallel"}},
      {{"--view-angle", "180"}, {"--view-angle '180'", "> 0 and < 180"}},
      {{"--mode", "median"}, {"--mode 'median'", "composite, xray"}},
      {{"--ambient", "-0.1"}, {"--ambient '-0.1'", ">= 0"}},
      {{"--specular-power", "0"}, {"--specular-power '0'"}},
      {{"--light", "0,0,0"}, {"--light '0,0,0'"}},
      {{"--light", "0,0,1@0.5"}, {"--light '0,0,1@0.5'"}},
      {{"--light", "studio", "--light", "headlight"}, {"--light 'headlight'", "X,Y,Z@INTENSITY"}},
      {{"--light", "studio", "--light", "0,0,1@11"}, {"--light '0,0,1@11'", "10"}},
      {{"--light", "0,0,1", "--light", "0,0,1", "--light", "0,0,1", "--light", "0,0,1", "--light",
        "0,0,1", "--light", "0,0,1"},
       {"--light '0,0,1'", "at most 4 lights after the first"}},
      {{"--clip", "1,0,0"}, {"--clip '1,0,0'", "expected 4 numbers"}},
      {{"--clip", "0,0,0,1"}, {"--clip '0,0,0,1'", "normal"}},
      {{"--sampling-distance", "-1"}, {"--sampling-distance '-1'", "> 0"}},
      {{"--slab", "thick"}, {"--slab 'thick'", "mid, mean"}},
      {{"--gradient", "none"}, {"--gradient 'none'", "exact, central"}},
      {{"--kernel", "box"}, {"--kernel 'box'", "gaussian:SIGMA,CUTOFF"}},
      {{"--kernel", "gaussian:9,4"}, {"--kernel 'gaussian:9,4'", "SIGMA"}},
      {{"--kernel", "gaussian:0.5,0"}, {"--kernel 'gaussian:0.5,0'", "CUTOFF"}},
      {{"--kernel", "gaussian:0.1,1"}, {"--kernel 'gaussian:0.1,1'", "gaps"}},
      {{"--reconstruction", "max"}, {"--reconstruction 'max'", "normalized, sum"}},
      {{"--evaluate", "both"}, {"--evaluate 'both'", "gather"}},
      {{"--backend", "gpu"}, {"--backend 'gpu'", "cpu"}},
      {{"--threads", "-2"}, {"--threads '-2'", "whole number"}},
      {{"--repeat", "0"}, {"--repeat '0'", "whole number from 1"}},
  });
}

TEST(Usage, FlagsOfALaterVersionAreRefusedByName) {
  std::vector<Case> cases;
  for (const char* const flag : {"--nan-color"}) {
    const std::string said = std::string(flag) + ": not available in this version";
    cases.push_back({{flag}, {said}});
    cases.push_back({{flag, "3"}, {said}});
    cases.push_back({{std::string(flag) + "=3"}, {said}});
  }
  expect_all_refused(cases);
}

TEST(Usage, ContradictionsAreErrors) {
  expect_all_refused({
      {{"--shade", "--no-shade"}, {"--no-shade: contradicts --shade"}},
      {{"--camera", "c.json", "--view", "+x"}, {"--view: contradicts --camera"}},
      {{"--iso", "5"}, {"--iso: needs --mode isosurface"}},
      {{"--mode", "isosurface"}, {"--mode isosurface: needs --iso"}},
      {{"--mode", "isosurface", "--iso", "1,1"}, {"--iso '1,1': expected each value once"}},
      {{"--mode", "isosurface", "--iso", "1:reddish"}, {"--iso '1:reddish': expected"}},
      {{"--mode", "isosurface", "--iso", "1:red:2"}, {"--iso '1:red:2': expected"}},
      {{"--mode", "isosurface", "--iso", "1:red:1:1"}, {"expected V, V:COLOR or V:COLOR:OPACITY"}},
      {{"--thick-slice", "0,0,1,3,0"}, {"--thick-slice '0,0,1,3,0': expected", "T > 0"}},
      {{"--thick-slice", "0,0,0,3,1"}, {"a normal other than 0,0,0"}},
      {{"--thick-slice", "0,0,1,3"}, {"expected 5 numbers"}},
      {{"--no-shade", "--ambient", "0.5"}, {"--ambient: has no effect with --no-shade"}},
      {{"--no-shade", "--light", "1,0,0"}, {"--light: has no effect with --no-shade"}},
      {{"--no-shade", "--occlusion", "0.4", "--light", "1,0,0"},
       {"--light: has no effect with --no-shade"}},
      {{"--mode", "xray", "--shade"}, {"--shade: has no effect with --mode xray"}},
      {{"--mode", "maximum", "--diffuse", "1"}, {"--diffuse: has no effect with --mode maximum"}},
      {{"--mode", "xray", "--opacity", "0:1"}, {"--opacity: has no effect with --mode xray"}},
      {{"--mode", "isosurface", "--iso", "9", "--opacity", "0:1"},
       {"--opacity: has no effect with --mode isosurface"}},
      {{"--mode", "mean", "--unit-distance", "2"},
       {"--unit-distance: has no effect with --mode mean"}},
      {{"--mode", "maximum", "--gradient-opacity", "0:0,1:1"},
       {"--gradient-opacity: has no effect with --mode maximum"}},
      {{"--tf", "a.vp", "--preset", "ct-bone"}, {"--preset: contradicts --tf"}},
      {{"--tf-name", "a"}, {"--tf-name: needs --tf FILE"}},
      {{"--window", "400,40", "--range", "0,1"}, {"--window: contradicts --range"}},
      {{"--window", "400,40", "--tf", "a.vp"}, {"--window: contradicts --tf"}},
      {{"--window", "400,40", "--preset", "ct-bone"}, {"--window: contradicts --preset"}},
      {{"--log", "--symlog", "1"}, {"--symlog: contradicts --log"}},
      {{"--log", "--range", "0,1"}, {"--range: begins at 0, expected values > 0 with --log"}},
      {{"--log", "--window", "400,40"}, {"--window: begins at -160"}},
      {{"--log", "--opacity", "-1:0,1:1"}, {"--opacity: begins at -1"}},
      {{"--log", "--colormap", "-1,0,0,0,2,1,1,1"}, {"--colormap: begins at -1"}},
  });
}

TEST(Usage, LooksAreSpelledRight) {
  expect_all_refused({
      {{"--preset", "ct-bon"}, {"--preset 'ct-bon'", "did you mean ct-bone?"}},
      {{"--colormap", "0,0,0"}, {"--colormap '0,0,0'", "V,R,G,B", "has 3 numbers"}},
      {{"--colormap", "0,0,0,2"}, {"number 4 is 2: colours must be in [0, 1]"}},
      {{"--colormap", "1,0,0,0,0,1,1,1"}, {"values must rise"}},
      {{"--colormap", "0,0,x,1"}, {"V,R,G,B,...: numbers"}},
      {{"--opacity", "0,1,2"}, {"--opacity '0,1,2'", "has 3 numbers"}},
      {{"--opacity", "0:0,1"}, {"VALUE:OPACITY pairs", "not '1'"}},
      {{"--opacity", "0,0,1,2"}, {"opacities must be in [0, 1]"}},
      {{"--gradient-opacity", "-1:0,1:1"}, {"expected gradients >= 0, not -1"}},
      {{"--window", "0,40"}, {"--window '0,40'", "W > 0"}},
      {{"--window", "40"}, {"expected 2 numbers"}},
      {{"--symlog", "0"}, {"--symlog '0'", "> 0"}},
      {{"--below-color", "1,1,2"}, {"--below-color '1,1,2'", "in [0, 1]"}},
      {{"--above-color", "reddish"}, {"--above-color 'reddish'", "#rrggbb"}},
      {{"--above-color", "#12345"}, {"--above-color '#12345'", "#rrggbb"}},
  });
}

TEST(Usage, FlagsAreGivenOnceAndWithTheirValue) {
  expect_all_refused({
      {{"--tf", "a.json", "--tf", "b.json"}, {"--tf: given 2 times, expected once"}},
      {{"--size", "8x8", "--size=9x9"}, {"--size: given 2 times"}},
      {{"--prefilter", "--prefilter"}, {"--prefilter: given 2 times"}},
      {{"--size"}, {"--size: expected a value, WIDTHxHEIGHT"}},
      {{"--array="}, {"--array: expected a value"}},
      {{"--prefilter=yes"}, {"--prefilter: takes no value"}},
      {{"-o", "twice.png"}, {"--output: given 2 times"}},
  });
}

TEST(Usage, UnknownFlagsGetTheNearest) {
  expect_all_refused({
      {{"--colrmap", "gray"}, {"--colrmap: unknown flag", "did you mean --colormap?"}},
      {{"--colormap=gray", "--backgroud=1,1,1"},
       {"--backgroud: unknown flag", "did you mean --background?"}},
      {{"--frobnicate"}, {"--frobnicate: unknown flag", "ovoid render --help"}},
      {{"-x"}, {"-x: unknown flag"}},
  });
}

TEST(Usage, OutputsAreCheckedBeforeAnythingIsRead) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const std::string missing = folder / "missing.nrrd";
  expect_failure({"render", missing}, 2, {"--output", "none given"});
  expect_failure({"render", missing, "-o", folder / "out.bmp"}, 2,
                 {"out.bmp", ".png, .jpg, .exr or .npy"});
  expect_failure({"render", missing, "-o", folder / "out"}, 2, {"/out'", ".png"});
  expect_failure({"render", "-o", folder / "out.png"}, 2, {"INPUT", "none given"});
  expect_failure({"render", missing, "-o", folder / "no/out.png"}, 1,
                 {"no/out.png", "does not exist"});
  expect_failure({"render", missing, "-o", ball + "/out.png"}, 1, {"out.png", "does not exist"});
  expect_failure({"render", missing, "-o", folder / (std::string(300, 'n') + ".png")}, 1,
                 {"File name too long"});
  for (const char* const format : {"out.exr", "out.npy"}) {
    expect_failure({"render", ball, "-o", folder / format, "--background", "0,0,0"}, 2,
                   {"--background", format});
  }
  std::filesystem::create_directory(folder / "folder.png");
  expect_failure({"render", ball, "-o", folder / "folder.png"}, 1, {"folder.png", "is a folder"});
  expect_failure({"convert", ball, "-o", ball}, 2, {ball, "is an input"});
  expect_failure({"render", ball, "-o", folder / "x.png", "--profile=" + ball}, 2, {"is an input"});
  expect_failure({"render", ball, "-o", folder / "x.png", "--profile=" + (folder / "x.png")}, 2,
                 {"--profile", "same file"});
  EXPECT_EQ(read_file(ball), ball_bytes());
  EXPECT_EQ(folder.num_files(), 2U);
}

// Whatever the command line names for reading must not be lost to what it writes.
TEST(Usage, OutputsThatAreReadAreRefused) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const std::string raw = folder / "q.raw";
  const std::string header = folder / "q.nhdr";
  const std::string json = folder / "look.json";
  write_file(raw, ball_bytes());
  write_file(header,
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 16 16 16\nencoding: raw\ndata "
             "file: q.raw\n");
  write_file(json, R"([{"RGBPoints": [0, 1, 0, 0, 255, 0, 0, 1]}])");
  std::filesystem::create_symlink(raw, folder / "link.raw");
  const std::string png = folder / "x.png";
  expect_failure({"convert", header, "-o", raw}, 2,
                 {"--output '" + raw + "': is a data file of '" + header + "'"});
  expect_failure({"convert", header, "-o", folder / "link.raw"}, 2, {"is a data file of"});
  expect_failure({"convert", raw, "--dims", "16x16x16", "--type", "uint8", "-o", header}, 2,
                 {"--output '" + header + "': its samples' file '" + raw + "' is an input"});
  expect_failure({"convert", json, "-o", json}, 2, {"--output '" + json + "': is an input"});
  expect_failure({"render", header, "-o", png, "--profile=" + raw}, 2,
                 {"--profile '" + raw + "': is a data file of"});
  expect_failure({"render", ball, "-o", png, "--tf", json, "--profile=" + json}, 2,
                 {"--profile '" + json + "': is the look of --tf"});
  expect_failure({"render", ball, "-o", png, "--camera", json, "--profile=" + json}, 2,
                 {"--profile '" + json + "': is the camera of --camera"});
  write_file(png, "not a look");
  expect_failure({"render", ball, "-o", png, "--tf", png}, 2,
                 {"--output '" + png + "': is the look"});
  expect_failure({"render", ball, "-o", folder / "y.png", "--profile=" + (folder / "./y.png")}, 2,
                 {"--profile", "is the same file as --output"});
  EXPECT_EQ(read_file(raw), ball_bytes());
  EXPECT_EQ(folder.num_files(), 6U);
}

TEST(Usage, OtherCommandsCheckTheirWordsToo) {
  const Folder folder;
  expect_failure({"make", "-o", folder / "x.nrrd"}, 2, {"NAME", "0 given"});
  expect_failure({"make", "marschner-lob", "-o", folder / "x.nrrd"}, 2,
                 {"'marschner-lob'", "did you mean marschner-lobb?"});
  expect_failure({"make", "marschner-lobb"}, 2, {"--output"});
  expect_failure({"make", "marschner-lobb", "-o", folder / "x.nrrd", "--size", "0"}, 2,
                 {"--size '0'", "N or XxYxZ"});
  expect_failure({"make", "marschner-lobb", "-o", folder / "x.nrrd", "--type", "int64"}, 2,
                 {"--type 'int64'", "uint16"});
  expect_failure({"make", "marschner-lobb", "-o", folder / "x.nrrd", "--seed", "-1"}, 2,
                 {"--seed '-1'"});
  expect_failure({"info"}, 2, {"INPUT", "none given"});
  expect_failure({"convert", "a.nrrd"}, 2, {"--output"});
  expect_failure({"convert", "a.vp", "b.vp", "-o", folder / "b.json"}, 2,
                 {"b.json", "expected one look"});
  expect_failure({"bench", "nothing-like-it"}, 2, {"'nothing-like-it'", "--list"});
  expect_failure({"bench", "--frames", "3"}, 2, {"--frames '3'", "from 10"});
  EXPECT_EQ(folder.num_files(), 0U);
}

}  // namespace usage_test
}  // namespace ovoid::cli_tests
