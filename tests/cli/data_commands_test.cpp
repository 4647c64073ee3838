// SPDX-License-Identifier: Apache-2.0
// info, make, convert and bench: what they print and write.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program.h"

namespace ovoid::cli_tests {
namespace data_commands_test {

using nlohmann::json;

TEST(Info, TellsWhatIsInTheFile) {
  const Folder folder;
  const json facts = facts_of(write_ball(folder), {"--spacing", "1,2,0.5"});
  EXPECT_EQ(facts["kind"], "lattice");
  EXPECT_EQ(facts["dims"], (json{16, 16, 16}));
  EXPECT_EQ(facts["spacing"], (json{1.0, 2.0, 0.5}));
  EXPECT_EQ(facts["space"], "none");
  // The cells reach half a spacing beyond the first and last sample.
  const json origin = facts["origin"];
  EXPECT_EQ(facts["bounds"][0], (json{origin[0].get<double>() - 0.5, origin[1].get<double>() - 1,
                                      origin[2].get<double>() - 0.25}));
  EXPECT_EQ(facts["bounds"][1], (json{origin[0].get<double>() + 15.5, origin[1].get<double>() + 31,
                                      origin[2].get<double>() + 7.75}));
  ASSERT_EQ(facts["arrays"].size(), 1U);
  EXPECT_EQ(facts["arrays"][0]["type"], "uint8");
  EXPECT_EQ(facts["arrays"][0]["components"], 1);
  EXPECT_EQ(facts["arrays"][0]["missing"], 0);
  // The middle samples lie at sqrt(3)/2 from the centre: 255 (1 - 0.866 / 6) = 218.19.
  EXPECT_EQ(facts["arrays"][0]["range"], (json{0.0, 218.0}));
  EXPECT_EQ(facts["field"]["num_kernels"], 4096);
  EXPECT_EQ(facts["field"]["default_sampling_distance"], 0.25);
  EXPECT_EQ(facts["field"]["default_unit_distance"], 0.5);
  EXPECT_GE(facts["field"]["memory_bytes"], 4096);
  const auto& quantiles = facts["field"]["quantiles"];
  ASSERT_EQ(quantiles.size(), 7U);
  for (std::size_t i = 1; i < quantiles.size(); ++i) {
    EXPECT_GT(quantiles[i][0], quantiles[i - 1][0]);
    EXPECT_GE(quantiles[i][1], quantiles[i - 1][1]);
  }
  std::int64_t counted = 0;
  for (const auto& count : facts["field"]["histogram"]["counts"]) counted += count.get<int>();
  EXPECT_EQ(counted, 16 * 16 * 16);
}

// Fails if a direction is taken for another axis' or for its opposite.
TEST(Info, TellsWhereTheAxesPointInThePatient) {
  const Folder folder;
  const auto orientation = [&folder](const std::string& space, const std::string& directions) {
    const std::string path = folder / "x.nrrd";
    write_file(path, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspace: " +
                         space + "\nspace directions: " + directions + "\n\n01234567");
    return facts_of(path)["orientation"];
  };
  EXPECT_EQ(orientation("LPS", "(1,0,0) (0,1,0) (0,0,1)"), "LPS");
  EXPECT_EQ(orientation("RAS", "(1,0,0) (0,1,0) (0,0,1)"), "RAS");
  EXPECT_EQ(orientation("LPS", "(-2,0.1,0) (0,0.3,-1) (0,4,0.1)"), "RIP");
  EXPECT_EQ(orientation("RAS", "(0,0,3) (-1,0.2,0) (0,-2,0)"), "SLP");
  EXPECT_TRUE(orientation("3D-right-handed", "(1,0,0) (0,1,0) (0,0,1)").is_null());
}

TEST(Info, CountsMissingSamples) {
  const Folder folder;
  std::vector<float> values(27, 2.0F);
  values[3] = std::nanf("");
  values[4] = INFINITY;
  values[5] = -7.5F;
  const std::string path = folder / "x_3x3x3_float32.raw";
  write_file(path, {reinterpret_cast<const char*>(values.data()), 4 * values.size()});
  const json facts = facts_of(path);
  EXPECT_EQ(facts["arrays"][0]["missing"], 2);
  EXPECT_EQ(facts["arrays"][0]["range"], (json{-7.5, 2.0}));
  EXPECT_EQ(facts["field"]["missing"], 2);
}

TEST(Info, DescribesAVolumeOfHoles) {
  const Folder folder;
  const std::vector<float> values(8, std::nanf(""));
  const std::string path = folder / "x_2x2x2_float32.raw";
  write_file(path, {reinterpret_cast<const char*>(values.data()), 4 * values.size()});
  const json facts = facts_of(path);
  EXPECT_EQ(facts["dims"], (json{2, 2, 2}));
  EXPECT_EQ(facts["arrays"][0]["missing"], 8);
  EXPECT_TRUE(facts["field"].is_null());
  const Outcome text = run({"info", path});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("8 missing"), std::string::npos) << text.out;
  EXPECT_NE(text.err.find("nothing can be drawn"), std::string::npos) << text.err;
}

TEST(Info, TextAndJsonSayTheSame) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const Outcome text = run({"info", ball});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  for (const char* const row :
       {"kind", "format", "dims", "spacing", "origin", "axes", "space", "bounds", "array",
        "kernels", "default sampling distance", "default unit distance", "memory of the field"}) {
    EXPECT_NE(('\n' + text.out).find(std::string("\n") + row), std::string::npos) << row;
  }
  EXPECT_NE(text.out.find("16 16 16"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("0 to 218"), std::string::npos) << text.out;
}

TEST(Info, DevicesNeedNoInput) {
  const Outcome text = run({"info", "--devices"});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("cpu"), std::string::npos) << text.out;
  const json devices = json::parse(run({"info", "--devices", "--json"}).out);
  EXPECT_EQ(devices[0]["backend"], "vulkan");
  EXPECT_EQ(devices[0]["devices"].empty(), !devices[0]["problem"].is_null());
  EXPECT_EQ(devices[1]["backend"], "cpu");
  EXPECT_GE(devices[1]["simd_targets"].size(), 1U);
}

TEST(Make, WritesWhatWasAskedFor) {
  const Folder folder;
  const std::string path = folder / "ml.nrrd";
  expect_success({"make", "marschner-lobb", "-o", path, "--size", "9x8x7", "--type", "uint8"});
  const json facts = facts_of(path);
  EXPECT_EQ(facts["dims"], (json{9, 8, 7}));
  EXPECT_EQ(facts["arrays"][0]["type"], "uint8");
  expect_success({"make", "marschner-lobb", "-o", folder / "cube.npy", "--size", "6"});
  EXPECT_EQ(facts_of(folder / "cube.npy")["dims"], (json{6, 6, 6}));
  expect_success({"make", "marschner-lobb", "-o", folder / "again.nrrd", "--size", "9x8x7",
                  "--type", "uint8"});
  EXPECT_EQ(read_file(path), read_file(folder / "again.nrrd"));
}

TEST(Make, EveryNameInTheHelpWorks) {
  const Folder folder;
  const std::string help = run({"make", "--help"}).out;
  std::istringstream names(help.substr(help.find("\nnames:\n") + 8));
  int count = 0;
  for (std::string line; std::getline(names, line) && line.rfind("  ", 0) == 0;) {
    if (line[2] == ' ') continue;  // the second line of a description
    const std::string name = line.substr(2, line.find(' ', 2) - 2);
    const bool is_mesh = name == "fin";
    if (is_mesh || name == "galaxy" || name == "blobs") {
      expect_success(
          {"make", name, "-o", folder / (name + (is_mesh ? ".vtu" : ".ply")), "--count", "100"});
    } else if (name == "solid") {
      expect_success({"make", name, "-o", folder / (name + ".ply"), "--levels", "0"});
    } else {
      expect_success({"make", name, "-o", folder / (name + ".nrrd"), "--size", "8"});
    }
    ++count;
  }
  EXPECT_GE(count, 3) << help;
}

TEST(Make, UnknownEndingsAreErrors) {
  const Folder folder;
  expect_failure({"make", "marschner-lobb", "-o", folder / "x.xyz", "--size", "4"}, 2,
                 {"--output", "x.xyz", "expected .nrrd"});
  expect_failure({"convert", folder / "missing.nrrd", "-o", folder / "x.png"}, 2,
                 {"--output", "x.png", "expected .nrrd"});
  EXPECT_EQ(folder.num_files(), 0U);
}

TEST(Make, ADetachedHeaderReplacesItsOwnSamplesOnly) {
  const Folder folder;
  const std::string header = folder / "ball.nhdr";
  const std::string samples = folder / "ball.raw";
  write_file(samples, "precious");
  expect_failure({"make", "ball", "--size", "4", "-o", header}, 1,
                 {header, samples, "belongs to something else"});
  EXPECT_EQ(read_file(samples), "precious");
  std::filesystem::remove(samples);
  expect_success({"make", "ball", "--size", "4", "-o", header});
  expect_success({"make", "ball", "--size", "5", "-o", header});
  EXPECT_EQ(read_file(samples).size(), 5U * 5 * 5 * 4);
  EXPECT_EQ(folder.num_files(), 2U);
}

TEST(Convert, KeepsSamplesAndGeometry) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const std::string a = folder / "a.nrrd";
  expect_success({"convert", ball, "-o", a, "--spacing", "1,2,3"});
  const json facts = facts_of(a);
  EXPECT_EQ(facts["spacing"], (json{1.0, 2.0, 3.0}));
  const std::string b = folder / "b.nhdr";
  expect_success({"convert", a, "-o", b});
  const std::string c = folder / "c_16x16x16_uint8.raw";
  expect_success({"convert", b, "-o", c});
  EXPECT_EQ(read_file(c), ball_bytes());
  expect_success({"convert", ball, "-o", folder / "d.npy"});
  expect_success({"convert", folder / "d.npy", "-o", folder / "e_16x16x16_uint8.raw"});
  EXPECT_EQ(read_file(folder / "e_16x16x16_uint8.raw"), ball_bytes());
}

// A NIfTI file's scale is shown by info, stays in NIfTI and becomes values elsewhere.
TEST(Convert, ScaledValuesOfNifti) {
  const Folder folder;
  const std::string source = folder / "a_2x2x2_uint8.raw";
  write_file(source, std::string("\0\1\2\3\4\5\6\7", 8));
  const std::string nii = folder / "a.nii";
  expect_success({"convert", source, "-o", nii});
  std::string content = read_file(nii);
  const float scale[] = {0.5F, -1.0F};
  std::memcpy(content.data() + 112, scale, sizeof(scale));
  write_file(nii, content);
  const std::string packed = folder / "b.nii.gz";
  expect_success({"convert", nii, "-o", packed});
  for (const std::string& path : {nii, packed}) {
    const json facts = facts_of(path);
    EXPECT_EQ(facts["format"], "NIfTI-1");
    EXPECT_EQ(facts["arrays"][0]["type"], "uint8");
    EXPECT_EQ(facts["arrays"][0]["range"], (json{-1.0, 2.5}));
    EXPECT_EQ(facts["arrays"][0]["value_scale"], 0.5);
  }
  expect_success({"convert", packed, "-o", folder / "c.nrrd"});
  const json facts = facts_of(folder / "c.nrrd");
  EXPECT_EQ(facts["arrays"][0]["type"], "float32");
  EXPECT_EQ(facts["arrays"][0]["range"], (json{-1.0, 2.5}));
  // Turned or moved without a patient space: it gets one, and that is told.
  const Outcome moved = run({"make", "ball", "--size", "4", "-o", folder / "d.nrrd"});
  EXPECT_EQ(moved.exit_code, 0);
  const Outcome result = run({"convert", folder / "d.nrrd", "-o", folder / "d.nii"});
  EXPECT_EQ(result.err, "note: " + (folder / "d.nii") +
                            ": holds a place in patient space only: x, y, z are now right, "
                            "anterior, superior\n");
  expect_failure({"convert", nii, "-o", nii}, 2, {"--output", "is an input"});
}

TEST(Convert, SeveralInputsAreSteps) {
  const Folder folder;
  const std::string a = folder / "a_2x1x1_uint8.raw";
  const std::string b = folder / "b_2x1x1_uint8.raw";
  write_file(a, "xx");
  write_file(b, "yz");
  const Outcome found = run({"info", a, b, "--json"});
  EXPECT_EQ(json::parse(found.out)["step"], 1);
  EXPECT_EQ(json::parse(found.out)["steps"], 2);
  EXPECT_EQ(found.err, "note: " + b + ": step 1 of 2, the first that varies; choose with --step\n");
  expect_success({"convert", a, b, "--step", "0", "-o", folder / "c_2x1x1_uint8.raw"});
  EXPECT_EQ(read_file(folder / "c_2x1x1_uint8.raw"), "xx");
  expect_failure({"info", a, b, "--step", "2"}, 1, {"step 2", "expected 0 to 1"});
  expect_failure({"convert", a, b, "-o", b}, 2, {"--output", "is an input"});
}

TEST(Convert, NotesWhatTheFormatCannotHold) {
  const Folder folder;
  const std::string placed = folder / "placed.nrrd";
  write_file(placed,
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspace: LPS\nspace "
             "directions: (2,0,0) (0,1,0) (0,0,1)\n\n12345678");
  const auto notes = [&](const std::string& from, const std::string& to) {
    const Outcome result = run({"convert", from, "-o", folder / to});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  EXPECT_EQ(
      notes(placed, "a.npy"),
      "note: " + (folder / "a.npy") + ": holds no spacing, directions and origin: they are lost\n");
  EXPECT_NE(notes(placed, "a_2x2x2_uint8.raw").find("are lost"), std::string::npos);
  EXPECT_EQ(notes(placed, "a.nrrd"), "");
  EXPECT_EQ(notes(write_ball(folder), "ball.npy"), "");
  const std::string vti = folder / "a.vti";
  if (run({"convert", placed, "-o", vti}).exit_code != 0) return;  // a build without VTK
  EXPECT_EQ(notes(placed, "a.vti"),
            "note: " + vti + ": holds no patient space: that the axes are LPS is lost\n");
}

TEST(Convert, LatticeFilesDenseAndAsRuns) {
  const Folder folder;
  const std::string ball = write_ball(folder);
  const std::string dense = folder / "dense.h5", runs = folder / "runs.h5";
  const Outcome first = run({"convert", ball, "-o", dense});
  if (first.err.find("no HDF5") != std::string::npos) GTEST_SKIP() << first.err;
  EXPECT_EQ(first.exit_code, 0) << first.err;
  const json facts = facts_of(dense);
  EXPECT_EQ(facts["format"], "HDF5 lattice, dense");
  EXPECT_EQ(facts["lattice"], "cartesian");
  EXPECT_EQ(facts["series"], "steps");
  EXPECT_EQ(facts["sublattices"].size(), 1U);
  expect_success({"convert", dense, "-o", folder / "again_16x16x16_uint8.raw"});
  EXPECT_EQ(read_file(folder / "again_16x16x16_uint8.raw"), read_file(ball));

  const Outcome kept = run({"convert", ball, "-o", runs, "--relevant-above", "100"});
  EXPECT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_NE(kept.err.find("of 4096 samples are relevant ("), std::string::npos) << kept.err;
  EXPECT_NE(kept.err.find("bytes, 4096 dense"), std::string::npos) << kept.err;
  const Outcome told = run({"info", runs});
  EXPECT_NE(told.out.find("HDF5 lattice, runs"), std::string::npos) << told.out;
  EXPECT_NE(told.err.find("is stored as runs: "), std::string::npos) << told.err;
  expect_success({"convert", ball, "-o", dense, "--array", "values"});
  const std::string samples = read_file(ball);
  run({"convert", runs, "-o", folder / "kept_16x16x16_uint8.raw"});
  std::string expected = samples;
  for (char& c : expected)
    if (static_cast<unsigned char>(c) <= 100) c = 0;
  EXPECT_EQ(read_file(folder / "kept_16x16x16_uint8.raw"), expected);

  expect_failure({"convert", ball, "-o", folder / "a.nrrd", "--relevant-above", "100"}, 2,
                 {"--relevant-above", "a.nrrd' holds no runs, only .h5 does"});
  expect_failure({"convert", ball, "-o", runs, "--background-value", "1"}, 2,
                 {"--background-value", "--relevant-above"});
}

TEST(Convert, TakesTheTypesThatNamesTake) {
  const Folder folder;
  write_file(folder / "x.raw", ball_bytes());
  expect_success({"convert", folder / "x.raw", "--dims", "16x16x16", "--type", "uchar", "-o",
                  folder / "y.nrrd"});
  EXPECT_EQ(facts_of(folder / "y.nrrd")["arrays"][0]["type"], "uint8");
}

TEST(Convert, RewritesLooks) {
  const Folder folder;
  const std::string path = folder / "look.json";
  write_file(path, R"([{"Name": "n", "ColorSpace": "Lab", "RGBPoints": [5, 0, 0, 1, 0, 1, 0, 0],
    "Points": [0, 0, 0.5, 0, 5, 1, 0.25, 0.5], "ScalarOpacityUnitDistance": 2}])");
  const std::string once = folder / "once.json";
  const std::string twice = folder / "twice.json";
  expect_success({"convert", path, "-o", once});
  expect_success({"convert", once, "-o", twice});
  EXPECT_EQ(read_file(once), read_file(twice));
  const json look = json::parse(read_file(once))[0];
  EXPECT_EQ(look["ColorSpace"], "Lab");
  EXPECT_EQ(look["RGBPoints"], (json{0.0, 1.0, 0.0, 0.0, 5.0, 0.0, 0.0, 1.0}));  // sorted by value
  EXPECT_EQ(look["ScalarOpacityUnitDistance"], 2.0);
}

TEST(Bench, ListsItsScenes) {
  const Outcome list = run({"bench", "--list", "head", "512px"});
  EXPECT_EQ(list.exit_code, 0) << list.err;
  std::istringstream lines(list.out);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_TRUE(line.find("head") != std::string::npos || line.find("512px") != std::string::npos)
        << line;
  }
  EXPECT_EQ(count, 14);  // 4 scenes of the head, and 10 more at 512 pixels
}

TEST(Bench, ReportsTimesAndCountsOfOneScene) {
  const Outcome result = run({"bench", "marschner-lobb-128-256px-opaque", "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_EQ(report["frames"], 10);
  EXPECT_EQ(report["backend"], "cpu");
  ASSERT_EQ(report["scenes"].size(), 1U);
  const json& scene = report["scenes"][0];
  EXPECT_EQ(scene["name"], "marschner-lobb-128-256px-opaque");
  EXPECT_GT(scene["frame_ms"]["q1"], 0);
  EXPECT_LE(scene["frame_ms"]["q1"], scene["frame_ms"]["median"]);
  EXPECT_LE(scene["frame_ms"]["median"], scene["frame_ms"]["q3"]);
  EXPECT_GT(scene["samples"]["shaded"], 0);
  EXPECT_GT(scene["samples_reconstructed_per_second"], 0);
  EXPECT_GT(report["peak_memory_bytes"], 128 * 128 * 128);
}

}  // namespace data_commands_test
}  // namespace ovoid::cli_tests
