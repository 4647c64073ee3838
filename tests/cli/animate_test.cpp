// SPDX-License-Identifier: Apache-2.0
// Animations: fails if frames are missing, wrongly numbered or not what `ovoid render` draws, if a
// resumed run redraws whole frames or believes damaged ones, or if ffmpeg is called otherwise than
// documented. No ffmpeg is needed: a script stands in for it.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <sys/stat.h>

#include "program.h"

namespace ovoid::cli_tests {
namespace animate_test {

// Steps of 8 x 8 x 8 samples in one NRRD file, a ball that grows, at the times 10, 10.5, 11, ...
std::string write_steps(const Folder& folder, int num_steps = 3) {
  std::string bytes = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 8 8 8 ";
  bytes += std::to_string(num_steps);
  bytes +=
      "\nkinds: space space space time\nspacings: 1 1 1 0.5\naxis mins: 0 0 0 10\n"
      "centerings: node node node node\nencoding: raw\n\n";
  for (int step = 0; step < num_steps; ++step) {
    for (int k = 0; k < 8; ++k) {
      for (int j = 0; j < 8; ++j) {
        for (int i = 0; i < 8; ++i) {
          const double r = std::hypot(i - 3.5, j - 3.5, k - 3.5);
          bytes.push_back(static_cast<char>(
              static_cast<std::uint8_t>(std::max(0.0, 250 * (1 - r / (2.5 + 0.5 * step))))));
        }
      }
    }
  }
  const std::string path = folder / "steps.nrrd";
  write_file(path, bytes);
  return path;
}

Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

const Words kLook = {"--size",       "40x30", "--range", "0,255",
                     "--background", "0,0,0", "--fit",   "box"};

Words animate(const std::string& input, const std::string& output, const Words& more = {}) {
  return with(with({"animate", input, "-o", output}, kLook), more);
}

// Standard error of a run that must do.
std::string done(const Words& words) {
  SCOPED_TRACE(joined(words));
  const Outcome outcome = run(words);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.error_lines(), Words{}) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  return outcome.err;
}

bool is_there(const std::string& path) { return std::filesystem::exists(path); }

TEST(Animate, AFrameForEachStepIsWhatRenderDraws) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  done(animate(steps, folder / "f_%04d.png"));
  EXPECT_FALSE(is_there(folder / "f_0003.png"));
  for (int step = 0; step < 3; ++step) {
    const std::string path = folder / "one.png";
    done(with({"render", steps, "-o", path, "--step", std::to_string(step)}, kLook));
    EXPECT_EQ(read_file(folder / ("f_000" + std::to_string(step) + ".png")), read_file(path))
        << step;
  }
  EXPECT_NE(read_file(folder / "f_0000.png"), read_file(folder / "f_0002.png"));
}

// Their sheets and opacities are those of a picture, though all frames share them.
TEST(Animate, AFrameOfMovingParticlesIsWhatRenderDraws) {
  const Folder folder;
  Words files;
  for (int step = 0; step < 2; ++step) {
    std::string rows = "x,y,z,heat\n";
    for (int i = 0; i < 200; ++i) {
      const double turn = 0.7 * i;
      rows += fmt::format("{},{},{},{}\n", std::cos(turn) + step, std::sin(turn), 0.02 * i, i);
    }
    files.push_back(folder / fmt::format("p{}.csv", step));
    write_file(files.back(), rows);
  }
  Words look = with(kLook, {"--step", "1", "--range", "0,200"});
  look.erase(look.begin() + 2, look.begin() + 4);  // the other range
  const std::string path = folder / "one.png";
  const Words turn = {"--turn", "360", "--frames", "2", "-o", folder / "f_%04d.png"};
  done(with(with({"animate"}, files), with(turn, look)));
  done(with(with({"render"}, files), with({"-o", path}, look)));
  EXPECT_EQ(read_file(folder / "f_0000.png"), read_file(path));
}

TEST(Animate, FilesAreStepsToo) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const std::string other = folder / "more_16x16x16_uint8.raw";
  std::string bytes = ball_bytes();
  for (char& c : bytes) c = static_cast<char>(static_cast<std::uint8_t>(c) / 2);
  write_file(other, bytes);
  done(with({"animate", ball, other, "-o", folder / "%d.png"}, kLook));
  EXPECT_TRUE(is_there(folder / "0.png"));
  EXPECT_TRUE(is_there(folder / "1.png"));
  EXPECT_FALSE(is_there(folder / "2.png"));
  EXPECT_TRUE(is_there(folder / "frames.ovoid"));
}

TEST(Animate, ATurnBeginsWithThePictureAndDoesNotEndWithIt) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  const Words turn = {"--step", "1", "--turn", "360", "--frames", "4", "--clip", "1,0.3,0,3"};
  done(animate(steps, folder / "t%02d.png", turn));
  EXPECT_FALSE(is_there(folder / "t04.png"));
  for (int frame = 0; frame < 4; ++frame) {
    const std::string path = folder / "one.png";
    done(with({"render", steps, "-o", path, "--step", "1", "--azimuth", std::to_string(90 * frame),
               "--clip", "1,0.3,0,3"},
              kLook));
    EXPECT_EQ(read_file(folder / ("t0" + std::to_string(frame) + ".png")), read_file(path));
  }
  EXPECT_NE(read_file(folder / "t00.png"), read_file(folder / "t01.png"));
  EXPECT_NE(read_file(folder / "t00.png"), read_file(folder / "t03.png"));
}

TEST(Animate, AStepAloneHasItsOwnLook) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  const Words size = {"--step", "1", "--size", "40x30", "--fit", "box"};
  done(with({"animate", steps, "-o", folder / "t%d.png", "--turn", "90", "--frames", "1"}, size));
  done(with({"render", steps, "-o", folder / "one.png"}, size));
  EXPECT_EQ(read_file(folder / "t0.png"), read_file(folder / "one.png"));
}

TEST(Animate, StepsTimesAndNumbersOfFrames) {
  const Folder folder;
  const std::string steps = write_steps(folder, 5);  // times 10 to 12
  done(animate(steps, folder / "all_%d.png"));
  const auto expect_steps = [&](const std::string& name, const Words& flags,
                                const std::vector<int>& expected) {
    SCOPED_TRACE(name);
    done(animate(steps, folder / (name + "_%d.png"), flags));
    const auto count = expected.size();
    EXPECT_FALSE(is_there(folder / (name + '_' + std::to_string(count) + ".png")));
    for (std::size_t i = 0; i < count; ++i) {
      const std::string frame = read_file(folder / (name + '_' + std::to_string(i) + ".png"));
      for (int step = 0; step < 5; ++step) {
        const bool is_step = frame == read_file(folder / ("all_" + std::to_string(step) + ".png"));
        EXPECT_EQ(is_step, step == expected[i]) << "frame " << i << ", step " << step;
      }
    }
  };
  constexpr int kBetween = -1;  // steps: none of them
  expect_steps("some", {"--steps", "1:3"}, {1, 2, 3});
  expect_steps("others", {"--steps", ":4:2"}, {0, 2, 4});
  expect_steps("timed", {"--times", "10:12:0.25"},
               {0, kBetween, 1, kBetween, 2, kBetween, 3, kBetween, 4});
  expect_steps("fewer", {"--frames", "3"}, {0, 2, 4});
  expect_steps("more", {"--frames", "3", "--steps", ":2"}, {0, 1, 2});
}

TEST(Animate, ASecondRunKeepsWholeFramesAndMendsOthers) {
  const Folder folder;
  const Words words = animate(write_steps(folder, 4), folder / "f_%d.png");
  done(words);
  const std::string good = read_file(folder / "f_1.png");
  EXPECT_NE(done(words).find("4 of 4 frames are there already"), std::string::npos);
  write_file(folder / "f_1.png", good.substr(0, good.size() - 20));  // cut short
  std::filesystem::remove(folder / "f_2.png");
  write_file(folder / "f_3.png", good);  // whole, and another
  EXPECT_NE(done(words).find("1 of 4 frames are there already"), std::string::npos);
  EXPECT_EQ(read_file(folder / "f_1.png"), good);
  EXPECT_NE(read_file(folder / "f_3.png"), good);
  // Another command has other frames, and a changed input as well.
  EXPECT_EQ(done(with(words, {"--zoom", "1.2"})).find("already"), std::string::npos);
  EXPECT_NE(read_file(folder / "f_1.png"), good);
  done(words);
  write_steps(folder, 5);
  EXPECT_EQ(done(words).find("already"), std::string::npos);
}

TEST(Animate, CtrlCLeavesWholeFramesFromWhichItGoesOn) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  const Words words = {"animate", steps,   "-o",       folder / "f_%06d.png",
                       "--turn",  "360",   "--frames", "100000",
                       "--size",  "64x48", "--range",  "0,255"};
  Program program(words);
  for (int i = 0; i < 1000 && !is_there(folder / "f_000002.png"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  program.send(SIGINT);
  const Outcome outcome = program.finish(30);
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_NE(outcome.err.find("the same command goes on"), std::string::npos) << outcome.err;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "")) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".png")) {
      EXPECT_TRUE(name == "steps.nrrd" || name == "f.ovoid") << name;
      continue;
    }
    EXPECT_NE(read_file(entry.path().string()).find("IEND"), std::string::npos) << name;
  }
}

// The record would take its place.
TEST(Animate, AFileOfSomebodyElseIsNoRecord) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  write_file(folder / "fr.ovoid", "my notes\n");
  expect_failure(animate(steps, folder / "fr%d.png"), 1, {"fr.ovoid", "choose another name"});
  EXPECT_EQ(read_file(folder / "fr.ovoid"), "my notes\n");
  std::filesystem::remove(folder / "fr.ovoid");
  write_file(folder / "notes", "my notes\n");
  std::filesystem::create_symlink(folder / "notes", folder / "fr.ovoid");
  expect_failure(animate(steps, folder / "fr%d.png"), 1, {"fr.ovoid"});
  EXPECT_EQ(read_file(folder / "notes"), "my notes\n");
  EXPECT_EQ(folder.num_files(), 3U);
}

// Fails if a command that has drawn nothing leaves its record, or the folder of a film's frames.
// The second volume is there when the flags are checked and has no samples when it is read.
TEST(Animate, LeavesNothingIfNoFrameIsThere) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  write_file(folder / "over.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\n\n");
  for (const char* const name : {"fr%d.png", "film.gif"}) {
    expect_failure(animate(steps, folder / name, {"--over", folder / "over.nrrd"}), 1,
                   {"over.nrrd"});
    EXPECT_EQ(folder.num_files(), 2U) << name;
  }
}

// A program called ffmpeg that writes its arguments, one a line, into the film.
class FakeFfmpeg {
 public:
  FakeFfmpeg(const Folder& folder, const std::string& script) {
    const std::string bin = folder / "bin";
    std::filesystem::create_directory(bin);
    write_file(bin + "/ffmpeg", "#!/bin/sh\n" + script);
    chmod((bin + "/ffmpeg").c_str(), 0755);
    before_ = std::getenv("PATH");
    setenv("PATH", (bin + ":/usr/bin:/bin").c_str(), 1);
  }
  ~FakeFfmpeg() { setenv("PATH", before_.c_str(), 1); }

 private:
  std::string before_;
};

const char* const kWritesItsArguments =
    "for last; do :; done\nprintf '%s\\n' \"$@\" > \"${last#file:}\"\n";

TEST(Animate, FilmsAreMadeByFfmpeg) {
  const Folder folder;
  const FakeFfmpeg ffmpeg(folder, kWritesItsArguments);
  const std::string film = folder / "50%; x.mp4";
  done(animate(write_steps(folder), film, {"--fps", "12.5"}));
  const std::string arguments = read_file(film);
  for (const std::string& expected :
       {std::string("-framerate\n12.5\n"), std::string("-frames:v\n3\n"), std::string("yuv420p"),
        "-i\nfile:" + (folder / "50%%; x.mp4.frames/frame_%06d.png\n"), std::string("-f\nmp4\n")}) {
    EXPECT_NE(arguments.find(expected), std::string::npos) << expected << " in\n" << arguments;
  }
  EXPECT_FALSE(is_there(film + ".frames"));
  EXPECT_EQ(folder.num_files(), 3U);  // steps, bin and the film
}

TEST(Animate, WhatFfmpegRefusesIsToldAndTheFramesStay) {
  const Folder folder;
  const std::string film = folder / "x.webm";
  const Words words = animate(write_steps(folder), film);
  {
    const FakeFfmpeg ffmpeg(folder, "echo first >&2; echo 'no such codec' >&2; exit 1\n");
    expect_failure(words, 1, {film, "ffmpeg failed: no such codec"});
  }
  EXPECT_FALSE(is_there(film));
  EXPECT_TRUE(is_there(film + ".frames/frame_000002.png"));
  std::filesystem::remove_all(folder / "bin");
  const FakeFfmpeg ffmpeg(folder, kWritesItsArguments);
  EXPECT_NE(done(words).find("3 of 3 frames are there already"), std::string::npos);
  EXPECT_TRUE(is_there(film));
  EXPECT_FALSE(is_there(film + ".frames"));
}

TEST(Animate, WithoutFfmpegNothingIsDrawn) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  const std::string before = std::getenv("PATH");
  setenv("PATH", folder.operator/("").c_str(), 1);
  expect_failure(animate(steps, folder / "x.mp4"), 1,
                 {"x.mp4", "ffmpeg", "x.gif", "frames_%04d.png"});
  setenv("PATH", before.c_str(), 1);
  EXPECT_EQ(folder.num_files(), 1U);
}

// Frames of odd width, with and without a background, and nothing of ffmpeg on PATH.
TEST(Animate, AGifNeedsNoFfmpeg) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  const std::string before = std::getenv("PATH");
  setenv("PATH", folder.operator/("").c_str(), 1);
  const std::string film = folder / "x.gif";
  const auto count = [&](const std::string& bytes) {
    const std::string gif = read_file(film);
    int number = 0;
    for (std::size_t at = 0; (at = gif.find(bytes, at)) != std::string::npos; ++at) ++number;
    return number;
  };
  using namespace std::string_literals;
  const auto words = [&](const Words& more) {
    return with({"animate", steps, "-o", film, "--size", "41x30", "--range", "0,255"}, more);
  };
  done(words({"--fps", "10"}));
  EXPECT_EQ(read_file(film).substr(0, 10), "GIF89a\x29\x00\x1e\x00"s);
  EXPECT_EQ(count("NETSCAPE2.0\x03\x01\x00\x00"s), 1);
  EXPECT_EQ(count("\x21\xf9\x04\x04\x0a\x00"s), 3);  // kept until the next, a tenth of a second
  EXPECT_FALSE(is_there(film + ".frames"));
  done(words({"--fps", "12.5", "--background", "none"}));
  EXPECT_EQ(count("\x21\xf9\x04\x09\x08\x00"s), 3);  // cleared, with a clear colour
  setenv("PATH", before.c_str(), 1);
  EXPECT_EQ(folder.num_files(), 2U);
}

TEST(Animate, RealFfmpegMakesAFilm) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no ffmpeg on PATH";
  const Folder folder;
  const std::string steps = write_steps(folder);
  for (const char* const name : {"x.mp4", "x.webm"}) {
    done(animate(steps, folder / name));
    EXPECT_GT(std::filesystem::file_size(folder / name), 200U);
  }
}

TEST(Animate, BadCommandLinesAreToldAtOnce) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  const std::string good = folder / "f_%d.png";
  const auto expect_usage = [&](const std::string& output, const Words& flags,
                                const Words& fragments) {
    expect_failure(animate(steps, output, flags), 2, fragments);
  };
  expect_usage(folder / "f.png", {}, {"f.png", "f_%04d.png"});
  expect_usage(folder / "f.jpg", {}, {"f.jpg"});
  expect_usage(folder / "f_%d.bmp", {}, {"f_%d.bmp", ".png, .jpg, .exr or .npy"});
  expect_usage(folder / "f_%d_%d.png", {}, {"exactly one number"});
  expect_usage(folder / "f_%s.png", {}, {"exactly one number"});
  expect_usage(folder / "f_%5d.png", {}, {"exactly one number"});
  expect_usage(folder / "f_%.png", {}, {"exactly one number"});
  expect_usage(good, {"--fps", "25"}, {"--fps", "films"});
  expect_usage(good, {"--frames", "0"}, {"--frames", "'0'"});
  expect_usage(good, {"--steps", "2:1"}, {"--steps", "A <= B"});
  expect_usage(good, {"--steps", "0:2:0"}, {"--steps", "STEP >= 1"});
  expect_usage(good, {"--steps", "1"}, {"--steps", "A:B"});
  expect_usage(good, {"--times", "10:11"}, {"--times", "A:B:STEP"});
  expect_usage(good, {"--times", "11:10:1"}, {"--times", "A <= B"});
  expect_usage(good, {"--times", "10:11:-1"}, {"--times", "STEP > 0"});
  expect_usage(good, {"--times", "10:11:1", "--steps", "0:1"}, {"--times", "contradicts --steps"});
  expect_usage(good, {"--times", "10:11:1", "--frames", "5"}, {"--times", "contradicts --frames"});
  expect_usage(good, {"--frames", "5", "--steps", "0:2:2"}, {"--frames", "--steps"});
  expect_failure({"animate", steps, "-o", folder / "x.mp4", "--size", "41x30"}, 2,
                 {"41x30", "even"});
  expect_failure({"animate", steps, "-o", folder / "x.mp4", "--background", "none"}, 2,
                 {"--background none", "x.mp4", ".gif"});
  for (const char* const fps : {"60", "0.001"})
    expect_usage(folder / "x.gif", {"--fps", fps}, {fps, "0.002 to 50", "x.gif"});
  EXPECT_EQ(folder.num_files(), 1U);
}

TEST(Animate, WhatTheDataDoNotHaveIsTold) {
  const Folder folder;
  const std::string steps = write_steps(folder);
  const std::string good = folder / "f_%d.png";
  expect_failure(animate(steps, good, {"--steps", "1:7"}), 1, {"--steps", "0 to 2"});
  expect_failure(animate(steps, good, {"--times", "9:11:1"}), 1, {"--times", "10 to 11"});
  expect_failure(animate(steps, good, {"--step", "0"}), 1, {"steps.nrrd", "--turn"});
  expect_failure(animate(write_ball(folder), good, {"--times", "0:1:1"}), 1, {"names no times"});
  expect_failure(animate(steps, folder / "none/f_%d.png"), 1, {"the folder", "does not exist"});
  const std::string wrong = folder / "wrong_8x8x8_uint8.raw";
  write_file(wrong, std::string(512, 'x'));
  expect_failure(with({"animate", write_ball(folder), wrong, "-o", good}, kLook), 1,
                 {wrong, "step 1", "8 x 8 x 8", "16 x 16 x 16"});
  const std::string frame = folder / "in_1.nrrd";
  std::filesystem::copy_file(steps, frame);
  std::filesystem::rename(frame, folder / "in_1.png");
  expect_failure(animate(folder / "in_1.png", folder / "in_%d.png"), 2, {"frame 1", "an input"});
}

// Real data in time: one command each.
TEST(Animate, RealSeriesMove) {
  const std::vector<Words> series = {
      {"isabel/isabel_30.vti", "isabel/isabel_31.vti", "isabel/isabel_32.vti"},
      {"can/can_0.hdf", "can/can_1.hdf", "can/can_2.hdf"},
      {"mug/mug.e"},
      {"md_water/spce_all_coords.lammpstrj.bz2"},
      {"mri_nifti/example4d.nii.gz"}};
  for (const Words& names : series) {
    const Folder folder;
    Words words = {"animate"};
    for (const std::string& name : names) words.push_back(real_data(name));
    if (words[1].empty()) GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
    words = with(words, {"-o", folder / "f%d.npy", "--size", "48x36", "--frames", "2"});
    const Outcome outcome = run(words);
    if (outcome.err.find("this build has no VTK") != std::string::npos) continue;
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const Picture first = read_npy(folder / "f0.npy"), second = read_npy(folder / "f1.npy");
    EXPECT_GT(second.num_covered(), 0U) << names[0];
    EXPECT_NE(first.rgba, second.rgba) << names[0];
  }
}

}  // namespace animate_test
}  // namespace ovoid::cli_tests
