// SPDX-License-Identifier: Apache-2.0
// `ovoid fit` on the command line. Fails if a goal does not reach the fit, if what is written is
// not read as the data are, or if what cannot be leaves a file.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "program.h"

namespace ovoid::cli_tests {
namespace fit_test {

using nlohmann::json;

class Fit : public testing::Test {
 protected:
  std::string fin() {
    const std::string path = folder_ / "fin.vtu";
    expect_success({"make", "fin", "--count", "2000", "-o", path});
    return path;
  }

  Folder folder_;
};

TEST_F(Fit, MeshesBecomeFewKernels) {
  const std::string mesh = fin(), few = folder_ / "few.ply", report = folder_ / "report.json";
  if (run({"info", mesh}).err.find("no VTK") != std::string::npos)
    GTEST_SKIP() << "this build reads no VTU";
  const Outcome told = run({"fit", mesh, "-o", few, "--kernels", "300", "--report", report});
  ASSERT_EQ(told.exit_code, 0) << told.err;
  for (const char* const word :
       {"kernels         300, of ", "PSNR", "greatest error", "wrongly full"})
    EXPECT_NE(told.out.find(word), std::string::npos) << told.out;
  const json json = json::parse(read_file(report));
  EXPECT_EQ(json["kernels"], 300);
  EXPECT_GT(json["psnr_db"], 28);
  EXPECT_GE(json["bytes"].get<double>(), read_file(few).size());
  EXPECT_EQ(json["steps"].back()["kernels"], 300);
  const auto field = facts_of(few)["field"];
  EXPECT_EQ(field["num_kernels"], 300);
  EXPECT_EQ(field["reconstruction"], "normalized");
  EXPECT_EQ(field["cutoff"], 3.5);
  EXPECT_GT(draw(folder_, {few}).num_covered(), 100U);
  expect_success({"fit", mesh, "-o", few, "--bytes", "20K", "--shape", "ball"});
  EXPECT_LE(read_file(few).size(), 20U * 1024);
  EXPECT_GT(read_file(few).size(), 18U * 1024);
}

// Fails if kernels or their report are left where the command has failed.
TEST_F(Fit, LeavesNothingIfItsAnswerGetsNowhere) {
  const std::string ball = write_ball(folder_), few = folder_ / "few.h5";
  if (!has_hdf5()) GTEST_SKIP() << "this build has no HDF5";
  const Words words = {"fit", ball, "-o", few, "--kernels", "50", "--report", folder_ / "r.json"};
  const std::size_t before = folder_.num_files();
  const Outcome result = run_after([] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); }, words);
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_EQ(folder_.num_files(), before);
  EXPECT_EQ(run(words).exit_code, 0);
  EXPECT_EQ(folder_.num_files(), before + 2);
}

// Fails if fitted kernels are drawn beyond the mesh, or end before it, or if its walls have other
// colours than the fit.
TEST_F(Fit, KernelsAreDrawnWithinTheMesh) {
  const std::string mesh = fin(), few = folder_ / "few.ply";
  if (run({"info", mesh}).err.find("no VTK") != std::string::npos)
    GTEST_SKIP() << "this build reads no VTU";
  expect_success({"fit", mesh, "-o", few, "--kernels", "300"});
  const json facts = facts_of(mesh), range = facts["field"]["range"];
  const auto middle = [&](std::size_t axis) {
    return 0.5 * (facts["bounds"][0][axis].get<double>() + facts["bounds"][1][axis].get<double>());
  };
  const json camera = {{"position", {middle(0) + 2, middle(1) + 3, middle(2) + 20}},
                       {"focal_point", {middle(0), middle(1), middle(2)}},
                       {"view_up", {0, 1, 0}},
                       {"parallel_projection", true},
                       {"parallel_scale", 7}};
  const Words view = {
      "--size",     "60x40",
      "--camera",   camera.dump(),
      "--colormap", "viridis",
      "--range",    fmt::format("{},{}", range[0].get<double>(), range[1].get<double>())};
  const auto picture = [&](Words words) {
    words.insert(words.end(), view.begin(), view.end());
    return draw(folder_, words);
  };
  const auto num_only_in = [](const Picture& one, const Picture& other) {
    std::size_t count = 0;
    for (std::size_t i = 3; i < one.rgba.size(); i += 4)
      count += one.rgba[i] > 0 && other.rgba[i] == 0 ? 1U : 0U;
    return count;
  };
  const Picture walls = picture({mesh, "--surface"});
  EXPECT_GT(num_only_in(picture({few}), walls), 50U);
  EXPECT_EQ(num_only_in(picture({few, "--within", mesh, "--surface=0"}), walls), 0U);
  const Picture within = picture({few, "--within", mesh, "--surface"});
  EXPECT_EQ(num_only_in(within, walls) + num_only_in(walls, within), 0U);
  double error = 0;
  for (std::size_t i = 0; i < walls.rgba.size(); ++i)
    error += std::abs(static_cast<double>(walls.rgba[i] - within.rgba[i]));
  EXPECT_LT(error / static_cast<double>(walls.rgba.size()), 0.02);
  expect_failure({"render", mesh, "--within", mesh, "-o", folder_ / "a.png"}, 1,
                 {"--within: is for lattices, particles and kernels"});
  expect_failure({"render", few, "--within", few, "-o", folder_ / "a.png"}, 1,
                 {"--within: is for meshes"});
  expect_failure({"render", few, "--surface", "-o", folder_ / "a.png"}, 1, {"--within"});
}

TEST_F(Fit, RefusesWhatCannotBe) {
  const std::string mesh = fin(), few = folder_ / "few.ply", ball = write_ball(folder_);
  if (run({"info", mesh}).err.find("no VTK") != std::string::npos)
    GTEST_SKIP() << "this build reads no VTU";
  expect_failure({"fit", mesh, "-o", few}, 2, {"no goal given"});
  expect_failure({"fit", mesh, "--kernels", "3"}, 2, {"--output: none given"});
  expect_failure({"fit", mesh, "-o", folder_ / "few.vtu", "--kernels", "3"}, 2, {".ply"});
  expect_failure({"fit", mesh, "-o", few, "--kernels", "3", "--psnr", "30"}, 2, {"--kernels"});
  expect_failure({"fit", mesh, "-o", few, "--tolerance", "0%"}, 2, {"--tolerance"});
  expect_failure({"fit", mesh, "-o", few, "--psnr", "300"}, 1, {"psnr = 300", "reach"});
  expect_failure({"fit", mesh, "-o", few, "--bytes", "10"}, 1, {"bytes = 10"});
  expect_failure({"fit", mesh, "-o", few, "--smooth"}, 1, {"--smooth: is for lattices", "--psnr"});
  expect_failure({"fit", mesh, "-o", few, "--kernels", "3", "--memory-limit", "64K"}, 3,
                 {"more than the limit"});
  expect_failure({"fit", ball, "-o", few, "--kernels", "3"}, 2, {"is a lattice", ".h5"});
  expect_failure({"fit", mesh, "-o", folder_ / "few.h5", "--kernels", "3"}, 2, {"is no lattice"});
  expect_failure({"fit", mesh, "-o", mesh + ".ply", "--report", mesh, "--kernels", "3"}, 2,
                 {"is an input"});
  EXPECT_FALSE(std::filesystem::exists(few));
}

TEST_F(Fit, LatticesBecomeLevels) {
  const std::string head = folder_ / "head.nii", few = folder_ / "few.h5",
                    report = folder_ / "report.json";
  expect_success({"make", "head", "--size", "48", "-o", head});
  const Outcome told = run({"fit", head, "-o", few, "--psnr", "38", "--report", report});
  if (told.err.find("HDF5") != std::string::npos) GTEST_SKIP() << "this build has no HDF5";
  ASSERT_EQ(told.exit_code, 0) << told.err;
  for (const char* const word : {"kernels ", "for samples: 110592", "PSNR", "greatest error"})
    EXPECT_NE(told.out.find(word), std::string::npos) << told.out;
  EXPECT_EQ(told.out.find("wrongly"), std::string::npos) << told.out;
  const json json = json::parse(read_file(report));
  EXPECT_GE(json["psnr_db"], 38);
  EXPECT_LT(json["kernels"], 110592 / 10);
  EXPECT_EQ(json["bytes"], read_file(few).size());
  EXPECT_EQ(json["source_psnr_db"], nullptr);
  const Outcome info = run({"info", few});
  EXPECT_NE(info.out.find("HDF5 lattice, levels"), std::string::npos) << info.out << info.err;
  EXPECT_NE(info.err.find("is stored as levels: "), std::string::npos) << info.err;
  EXPECT_GT(draw(folder_, {few}).num_covered(), 100U);
  // Of bytes and of an error.
  expect_success({"fit", head, "-o", few, "--bytes", "12K"});
  EXPECT_LE(read_file(few).size(), 12U * 1024);
  expect_success({"fit", head, "-o", few, "--tolerance", "5%"});
  expect_failure({"fit", write_ball(folder_), "-o", few, "--smooth"}, 1,
                 {"no noise that can be told"});
  expect_failure({"fit", head, "-o", few, "--smooth", "--psnr", "38"}, 2, {"give one of them"});
  expect_failure({"fit", head, "-o", few, "--psnr", "38", "--memory-limit", "4M"}, 3,
                 {"more than the limit"});
  expect_failure({"fit", head, "-o", few, "--psnr", "38", "--shape", "ball"}, 1,
                 {"--shape: is for meshes, particles and kernels"});
  expect_failure({"fit", head, "-o", few, "--psnr", "38", "--kernel", "gaussian"}, 2,
                 {"--kernel: has no effect on the fit of a lattice"});
}

}  // namespace fit_test
}  // namespace ovoid::cli_tests
