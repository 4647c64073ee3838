// SPDX-License-Identifier: Apache-2.0
// Hostile and unlucky input: a clear line that names the thing, a non-zero exit, no partial output,
// no crash.
#include <gtest/gtest.h>

#include "program.h"

namespace ovoid::cli_tests {
namespace bad_input_test {

// NRRD text header; `fields` are its lines but magic, type and encoding.
std::string nrrd(const std::string& type, const std::string& fields, const std::string& data,
                 const std::string& encoding = "raw") {
  return "NRRD0004\ntype: " + type + "\nencoding: " + encoding + "\nendian: little\n" + fields +
         "\n\n" + data;
}

class BadInput : public ::testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& bytes) {
    const std::string path = folder_ / name;
    write_file(path, bytes);
    return path;
  }
  // `ovoid render`, `info` and `convert` fail on the input, each with one line that holds the
  // fragments, and write nothing.
  void expect_unreadable(const std::string& input, Words fragments, const Words& more = {}) {
    const std::size_t before = folder_.num_files();
    for (const Words& words :
         {Words{"render", input, "-o", folder_ / "out.png", "--size", "16x16"},
          Words{"info", input}, Words{"convert", input, "-o", folder_ / "out.nrrd"}}) {
      Words all = words;
      all.insert(all.end(), more.begin(), more.end());
      expect_failure(all, 1, fragments);
    }
    EXPECT_EQ(folder_.num_files(), before) << "a failed command left a file";
  }
  // Draws without complaint; the picture is returned.
  Picture expect_drawn(const std::string& input, const Words& more = {}) {
    Words words = {input};
    words.insert(words.end(), more.begin(), more.end());
    return draw(folder_, words);
  }

  Folder folder_;
  std::string ball_ = write_ball(folder_);
};

TEST_F(BadInput, FilesThatAreNotThere) {
  expect_unreadable(folder_ / "missing.nrrd", {"missing.nrrd"});
  expect_unreadable(folder_ / "missing_4x4x4_uint8.raw", {"missing_4x4x4_uint8.raw"});
  expect_unreadable(folder_ / "no/such/folder.npy", {"folder.npy"});
  expect_failure({"render", "", "-o", folder_ / "out.png"}, 2, {"INPUT ''"});
  expect_failure({"info", ""}, 2, {"INPUT ''"});
}

TEST_F(BadInput, ThingsThatAreNoFiles) {
  std::filesystem::create_directory(folder_ / "folder.nrrd");
  expect_unreadable(folder_ / "folder.nrrd", {"folder.nrrd"});
}

TEST_F(BadInput, UnreadableFiles) {
  if (geteuid() == 0) GTEST_SKIP() << "the superuser may read every file";
  const std::string path = file("secret.nrrd", "NRRD0004\n");
  std::filesystem::permissions(path, std::filesystem::perms::none);
  expect_unreadable(path, {"secret.nrrd"});
}

TEST_F(BadInput, UnwritableFolders) {
  if (geteuid() == 0) GTEST_SKIP() << "the superuser may write everywhere";
  std::filesystem::create_directory(folder_ / "locked");
  std::filesystem::permissions(
      folder_ / "locked", std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  expect_failure({"render", ball_, "-o", folder_ / "locked/out.png"}, 1,
                 {"locked/out.png", "cannot be written"});
}

TEST_F(BadInput, FilesOfNoKnownFormat) {
  expect_unreadable(file("noise.dat", std::string(1000, '\xa5')), {"noise.dat"});
  expect_unreadable(file("empty.nrrd", ""), {"empty.nrrd"});
  expect_unreadable(file("empty.npy", ""), {"empty.npy"});
  expect_unreadable(file("text.nrrd", "hello"), {"text.nrrd"});
}

TEST_F(BadInput, RawFilesOfTheWrongSize) {
  expect_unreadable(file("short_16x16x16_uint8.raw", std::string(4095, 'x')),
                    {"short_16x16x16_uint8.raw", "4096"});
  expect_unreadable(file("long_16x16x16_uint8.raw", std::string(4097, 'x')),
                    {"long_16x16x16_uint8.raw", "4096"});
  expect_unreadable(file("nameless.raw", std::string(64, 'x')),
                    {"nameless.raw", "--dims", "--type"});
  expect_unreadable(ball_, {"ball_16x16x16_uint8.raw"}, {"--dims", "16x16x17"});
  expect_unreadable(ball_, {"ball_16x16x16_uint8.raw"}, {"--type", "float64"});
}

TEST_F(BadInput, RawFlagsOnFilesThatSayItThemselves) {
  const std::string path =
      file("a.nrrd", nrrd("uint8", "dimension: 3\nsizes: 2 2 2", std::string(8, 'x')));
  expect_unreadable(path, {"a.nrrd"}, {"--dims", "2x2x2"});
}

TEST_F(BadInput, TruncatedFiles) {
  const std::string whole = nrrd("uint8", "dimension: 3\nsizes: 16 16 16", ball_bytes());
  expect_unreadable(file("cut.nrrd", whole.substr(0, whole.size() - 1)), {"cut.nrrd"});
  expect_unreadable(file("headless.nrrd", whole.substr(0, 40)), {"headless.nrrd"});
  std::string npy = "\x93NUMPY";
  npy += std::string("\1\0\x76\0", 4) +
         "{'descr': '|u1', 'fortran_order': False, 'shape': (16, 16, 16), }";
  npy.resize(127, ' ');
  npy += '\n';
  expect_drawn(file("whole.npy", npy + ball_bytes()));
  expect_unreadable(file("cut.npy", npy + ball_bytes().substr(1)), {"cut.npy"});
  expect_unreadable(file("headless.npy", npy.substr(0, 60)), {"headless.npy"});
}

// A header may claim anything; what it claims must not be allocated.
TEST_F(BadInput, HugeDimensionsAreNotAllocated) {
  expect_unreadable(
      file("huge.nrrd", nrrd("float", "dimension: 3\nsizes: 100000 100000 100000", "abc")),
      {"huge.nrrd"});
  expect_unreadable(
      file("wrap.nrrd",
           nrrd("uint8", "dimension: 3\nsizes: 4294967296 4294967296 4294967296", "abc")),
      {"wrap.nrrd"});
  expect_unreadable(file("big.nrrd", nrrd("uint8", "dimension: 3\nsizes: 4096 4096 4096",
                                          std::string(100, 'z'), "gzip")),
                    {"big.nrrd"});
  expect_unreadable(file("x_99999x99999x99999_float64.raw", "abc"),
                    {"x_99999x99999x99999_float64.raw"});
  expect_unreadable(ball_, {"ball"}, {"--dims", "4611686018427387904x4x4"});
  expect_failure({"make", "marschner-lobb", "-o", folder_ / "x.nrrd", "--size", "1000000"}, 2,
                 {"--size", "1000000", "1 to 8192"});
}

TEST_F(BadInput, HeadersThatContradictThemselves) {
  const std::string data(27, 'x');
  expect_unreadable(file("neg.nrrd", nrrd("uint8", "dimension: 3\nsizes: 3 -3 3", data)),
                    {"neg.nrrd"});
  expect_unreadable(file("zero.nrrd", nrrd("uint8", "dimension: 3\nsizes: 3 0 3", data)),
                    {"zero.nrrd"});
  expect_unreadable(file("two.nrrd", nrrd("uint8", "dimension: 3\nsizes: 3 9", data)),
                    {"two.nrrd"});
  expect_unreadable(file("type.nrrd", nrrd("uint9", "dimension: 3\nsizes: 3 3 3", data)),
                    {"type.nrrd", "uint9"});
  expect_unreadable(
      file("flat.nrrd", nrrd("uint8", "dimension: 3\nsizes: 3 3 3\nspacings: 1 0 1", data)),
      {"flat.nrrd", "spacing"});
  expect_unreadable(
      file("nan.nrrd", nrrd("uint8", "dimension: 3\nsizes: 3 3 3\nspacings: 1 inf 1", data)),
      {"nan.nrrd"});
  expect_unreadable(
      file("axes.nrrd", nrrd("uint8",
                             "dimension: 3\nsizes: 3 3 3\nspace: left-posterior-superior\n"
                             "space directions: (1,0,0) (2,0,0) (0,0,1)\nspace origin: (0,0,0)",
                             data)),
      {"axes.nrrd"});
  expect_unreadable(file("nogz.nrrd", nrrd("uint8", "dimension: 3\nsizes: 3 3 3", data, "gzip")),
                    {"nogz.nrrd"});
  expect_unreadable(file("enc.nrrd", nrrd("uint8", "dimension: 3\nsizes: 3 3 3", data, "zstd")),
                    {"enc.nrrd", "zstd"});
  expect_unreadable(file("away.nhdr",
                         "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 3 3\nencoding: raw\ndata "
                         "file: away.raw\n\n"),
                    {"away.raw"});
}

TEST_F(BadInput, SeveralInputsThatAreNotOneDataset) {
  // Each has steps of its own, so they cannot be the steps of one.
  const std::string in_time =
      file("in_time.nrrd",
           nrrd("uint8", "dimension: 4\nsizes: 3 3 1 3\nkinds: domain domain domain time",
                std::string("abcdefghijklmnopqrstuvwxyzz")));
  const std::size_t before = folder_.num_files();
  expect_failure({"render", in_time, ball_, "-o", folder_ / "out.png"}, 1,
                 {"in_time.nrrd", "3 steps of its own"});
  EXPECT_EQ(folder_.num_files(), before);
}

TEST_F(BadInput, UnknownArraysAndComponents) {
  expect_unreadable(ball_, {"density"}, {"--array", "density"});
  expect_failure({"render", ball_, "-o", folder_ / "out.png", "--component", "3"}, 1,
                 {"component", "3"});
}

TEST_F(BadInput, LooksAndCamerasThatAreNone) {
  const auto fails = [&](const char* flag, const std::string& path, const Words& fragments) {
    expect_failure({"render", ball_, "-o", folder_ / "out.png", flag, path}, 1, fragments);
  };
  fails("--tf", folder_ / "missing.json", {"missing.json"});
  fails("--tf", file("bad.json", "{"), {"bad.json"});
  fails("--tf", file("odd.json", R"([{"RGBPoints": [0, 1, 0]}])"), {"odd.json", "RGBPoints"});
  fails("--tf", file("list.json", "[]"), {"list.json"});
  fails("--tf", file("number.json", "3"), {"number.json: has 1 numbers"});
  expect_failure({"render", ball_, "-o", folder_ / "out.png", "--zoom", "1e-300"}, 1, {"--zoom"});
  fails("--camera", folder_ / "missing.json", {"missing.json"});
  fails("--camera", file("cam.json", R"({"position": [0, 0]})"), {"cam.json", "position"});
  fails("--camera", file("same.json", R"({"position": [1, 1, 1], "focal_point": [1, 1, 1]})"),
        {"position"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.png"));
}

TEST_F(BadInput, PatientDirectionsNeedAPatientSpace) {
  expect_failure({"render", ball_, "-o", folder_ / "out.png", "--view", "anterior"}, 1,
                 {"anterior"});
}

// Odd, but data
// ------------------------------------------------------------------------------------------

std::string floats(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
}

TEST_F(BadInput, MissingSamplesAreCountedOnce) {
  std::vector<float> values(64, 1.0F);
  values[5] = values[40] = std::nanf("");
  values[9] = -INFINITY;
  for (std::size_t i = 32; i < 64; ++i) values[i] += 1;
  const std::string path = file("holes_4x4x4_float32.raw", floats(values));
  const Outcome result = run({"render", path, "-o", folder_ / "x.npy", "--size", "20x20"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find('3'), std::string::npos) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  for (const float v : read_npy(folder_ / "x.npy").rgba) ASSERT_TRUE(std::isfinite(v));
}

TEST_F(BadInput, AVolumeOfNothingButHolesSaysSo) {
  const std::string path =
      file("void_4x4x4_float32.raw", floats(std::vector<float>(64, std::nanf(""))));
  const Outcome result = run({"render", path, "-o", folder_ / "x.npy", "--size", "20x20"});
  if (result.exit_code == 0) {
    EXPECT_NE(result.err.find("64"), std::string::npos) << result.err;
    EXPECT_EQ(read_npy(folder_ / "x.npy").num_covered(), 0U);
  } else {
    EXPECT_EQ(result.exit_code, 1) << result.err;
    EXPECT_EQ(result.error_lines().size(), 1U) << result.err;
  }
}

// A slice is seen from every side. Of a row or a voxel a normalized field has hardly more than the
// middle, where no sheet need lie; their sums reach further.
TEST_F(BadInput, OneVoxelOneSliceAndOneRowAreDrawn) {
  const std::string slice = file("b_16x16x1_uint8.raw", std::string(256, 'd'));
  EXPECT_GT(expect_drawn(slice, {"--opacity", "0:0.9"}).num_covered(), 20U);
  EXPECT_GT(expect_drawn(slice, {"--opacity", "0:0.9", "--view", "+x"}).num_covered(), 0U);
  for (const std::string& path :
       {file("c_16x1x1_uint8.raw", std::string(16, 'd')), file("a_1x1x1_uint8.raw", "d")}) {
    for (const char* const mode : {"composite", "xray", "maximum", "mean"}) {
      for (const float v : expect_drawn(path, {"--mode", mode}).rgba) ASSERT_TRUE(std::isfinite(v));
    }
    EXPECT_GT(expect_drawn(path, {"--reconstruction", "sum", "--opacity", "0:0.9"}).num_covered(),
              20U);
    expect_success({"info", path});
  }
}

TEST_F(BadInput, AConstantVolumeHasAnEmptyRangeAndIsDrawn) {
  const std::string path = file("flat_8x8x8_uint8.raw", std::string(512, '\x2a'));
  for (const char* const mode : {"composite", "xray", "maximum", "mean"}) {
    for (const float v : expect_drawn(path, {"--mode", mode}).rgba)
      ASSERT_TRUE(std::isfinite(v)) << mode;
  }
  expect_success({"render", path, "-o", folder_ / "x.png", "--size", "16x16", "--mode", "xray"});
  expect_success({"info", path});
}

TEST_F(BadInput, NothingInSightIsAnEmptyPicture) {
  EXPECT_EQ(expect_drawn(ball_, {"--clip", "1,0,0,1000"}).num_covered(), 0U);
  EXPECT_EQ(expect_drawn(ball_, {"--mode", "isosurface", "--iso", "5000"}).num_covered(), 0U);
  EXPECT_EQ(expect_drawn(ball_, {"--mode", "xray", "--clip", "1,0,0,1000"}).num_covered(), 0U);
  expect_success({"render", ball_, "-o", folder_ / "x.png", "--size", "16x16", "--mode", "xray",
                  "--clip", "1,0,0,1000"});
}

TEST_F(BadInput, NamesWithControlCharactersStayOneLine) {
  expect_failure({"render", folder_ / "two\nlines.nrrd", "-o", folder_ / "x.png"}, 1,
                 {"two?lines.nrrd"});
}

// Real files
// ---------------------------------------------------------------------------------------------

TEST_F(BadInput, TheFuelHeaderThatLiesAboutItsEncoding) {
  const std::string path = real_data("fuel/fuel.nhdr");
  if (path.empty()) GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
  // It says gzip, the data file is not: a clear error, or the data read as it is; never garbage.
  const Outcome result = run({"render", path, "-o", folder_ / "fuel.npy", "--size", "32x32"});
  if (result.exit_code != 0) {
    EXPECT_EQ(result.exit_code, 1);
    ASSERT_EQ(result.error_lines().size(), 1U) << result.err;
    EXPECT_NE(result.error_lines()[0].find("fuel"), std::string::npos) << result.err;
    EXPECT_NE(result.error_lines()[0].find("gzip"), std::string::npos) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "fuel.npy"));
  } else {
    EXPECT_NE(result.err.find("gzip"), std::string::npos)
        << "read as it is, but not told: " << result.err;
    const std::string json = run({"info", path, "--json"}).out;
    EXPECT_NE(json.find("255"), std::string::npos) << json;
  }
}

// Fails if what is built looks for libraries where it is called: in the folder of the data.
TEST_F(BadInput, LibrariesBesideTheDataAreNotLoaded) {
  for (const char* const name : {"libc.so.6", "libm.so.6", "libstdc++.so.6", "libblosc.so.1",
                                 "libfmt.so.9", "libvtkCommonCore-9.1.so.1", "libz.so.1"})
    write_file(folder_ / name, "no library");
  const auto in_folder = [&] { ASSERT_EQ(chdir((folder_ / "").c_str()), 0); };
  expect_success({"make", "fin", "-o", folder_ / "fin.vtu"});
  const Outcome result = run_after(in_folder, {"info", "fin.vtu"});
  EXPECT_TRUE(result.exit_code == 0 || result.err.find("no VTK") != std::string::npos)
      << result.err;
}

TEST_F(BadInput, RealVolumesDrawWithoutFlags) {
  bool is_any_there = false;
  for (const char* const name : {"headsq/quarter.nhdr", "hydrogen_ironprot/hydrogen.vti",
                                 "hydrogen_ironprot/ironProt.vtk"}) {
    const std::string path = real_data(name);
    if (path.empty()) continue;
    is_any_there = true;
    const Outcome info = run({"info", path});
    if (info.err.find("VTK") != std::string::npos && info.exit_code != 0)
      continue;  // a build without VTK says so
    EXPECT_GT(expect_drawn(path).num_covered(), 20U) << name;
  }
  if (!is_any_there) GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
}

}  // namespace bad_input_test
}  // namespace ovoid::cli_tests
