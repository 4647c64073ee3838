// SPDX-License-Identifier: Apache-2.0
// Trails by the program.
#include <algorithm>
#include <array>
#include <cmath>

#include "program.h"

namespace ovoid::cli_tests {
namespace trails_test {

// Particles that go along x by 8 from step to step, with or without numbers.
std::string moving_particles(const Folder& folder, bool has_numbers) {
  std::string text;
  for (int step = 0; step < 3; ++step) {
    text += "ITEM: TIMESTEP\n" + std::to_string(10 * step) +
            "\nITEM: NUMBER OF ATOMS\n60\nITEM: BOX BOUNDS ff ff ff\n-30 30\n-30 30\n-30 30\n"
            "ITEM: ATOMS" +
            (has_numbers ? " id" : "") + " x y z\n";
    for (int i = 0; i < 60; ++i) {
      if (has_numbers) text += std::to_string(i + 1) + " ";
      text += std::to_string(i % 4 * 0.8 + 8 * step) + " " + std::to_string(i / 4 % 4 * 0.8) + " " +
              std::to_string(i / 16 * 0.8) + "\n";
    }
  }
  std::string path = folder / (has_numbers ? "numbered.lammpstrj" : "nameless.lammpstrj");
  write_file(path, text);
  return path;
}

// A block of 4 x 3 x 3 nodes that goes along x by 6 from step to step.
std::string moving_mesh(const Folder& folder) {
  std::string grids;
  for (int step = 0; step < 3; ++step) {
    std::string nodes, values;
    for (int i = 0; i < 36; ++i) {
      nodes += std::to_string(i % 4 + 6 * step) + " " + std::to_string(i / 4 % 3) + " " +
               std::to_string(i / 12) + "\n";
      values += std::to_string(i % 4) + " ";
    }
    const auto item = [](const std::string& dims, const std::string& text) {
      return "<DataItem Dimensions=\"" + dims + "\" Format=\"XML\">" + text + "</DataItem>";
    };
    grids += "<Grid><Time Value=\"" + std::to_string(step) +
             "\"/><Topology TopologyType=\"3DSMesh\" Dimensions=\"3 3 4\"/>"
             "<Geometry GeometryType=\"XYZ\">" +
             item("36 3", nodes) + "</Geometry><Attribute Name=\"heat\" Center=\"Node\">" +
             item("36", values) + "</Attribute></Grid>";
  }
  std::string path = folder / "block.xmf";
  write_file(path,
             "<Xdmf Version=\"3.0\"><Domain><Grid GridType=\"Collection\" "
             "CollectionType=\"Temporal\">" +
                 grids + "</Grid></Domain></Xdmf>");
  return path;
}

// A blob of radius 3 in 64 x 16 x 16 samples, at one place along x after the other.
Words moving_blob(const Folder& folder, const std::vector<int>& places) {
  Words steps;
  for (const int place : places) {
    std::string text = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 64 16 16\nencoding: ascii\n\n";
    for (int i = 0; i < 64 * 16 * 16; ++i) {
      const double distance = std::hypot(i % 64 - place, i / 64 % 16 - 8, i / 1024 - 8);
      text += std::to_string(static_cast<int>(200 * std::clamp(4 - distance, 0.0, 1.0))) + " ";
    }
    steps.push_back(folder / ("blob_" + std::to_string(steps.size()) + ".nrrd"));
    write_file(steps.back(), text);
  }
  return steps;
}

// The first and the last column of a picture in which anything is seen.
std::array<int, 2> columns_seen(const Picture& picture) {
  std::array<int, 2> seen{picture.width, -1};
  for (int i = 0; i < picture.width * picture.height; ++i) {
    if (picture.rgba[static_cast<std::size_t>(4 * i + 3)] < 0.01F) continue;
    seen[0] = std::min(seen[0], i % picture.width);
    seen[1] = std::max(seen[1], i % picture.width);
  }
  return seen;
}

// Pixels of a row of three strips of the picture, from left to right, that are seen.
std::vector<double> seen_in_thirds(const Picture& picture) {
  std::vector<double> seen(3, 0.0);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y * picture.width + x);
      seen[static_cast<std::size_t>(3 * x / picture.width)] +=
          static_cast<double>(picture.rgba[4 * at + 3]);
    }
  }
  return seen;
}

const Words kSmall = {"--size", "96x32", "--view", "-y", "--backend", "cpu"};

Picture draw_small(const Folder& folder, Words words) {
  words.insert(words.end(), kSmall.begin(), kSmall.end());
  return draw(folder, words);
}

// Fails if there is no trail, if it is not between the steps, or if the picture is not wide enough
// for it.
TEST(Trails, OfParticlesReachBackAlongTheirWays) {
  const Folder folder;
  const std::string data = moving_particles(folder, true);
  const auto seen =
      seen_in_thirds(draw_small(folder, {data, "--time", "20", "--motion-blur", "20"}));
  EXPECT_GT(seen[1], 5);
  EXPECT_GT(seen[0], 5);
  const auto alone =
      seen_in_thirds(draw_small(folder, {data, "--time", "20", "--motion-blur", "0.01"}));
  EXPECT_GT(alone[1], 5);  // which fills the picture
  const auto isosurface =
      seen_in_thirds(draw_small(folder, {data, "--time", "20", "--motion-blur", "20", "--mode",
                                         "isosurface", "--iso", "0.5"}));
  EXPECT_GT(isosurface[1], 1);
  expect_success({"animate", data, "--times", "10:20:5", "--motion-blur", "10", "-o",
                  folder / "f_%02d.png", "--size", "32x32"});
}

TEST(Trails, OfParticlesWithoutNumbersAreTheStepsAndSaySo) {
  const Folder folder;
  const std::string data = moving_particles(folder, false);
  Words words{"render", data, "--time", "20", "--motion-blur", "20", "-o", folder / "a.png"};
  words.insert(words.end(), kSmall.begin(), kSmall.end());
  const Outcome outcome = run(words);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("show the steps themselves, since particles have no numbers"),
            std::string::npos)
      << outcome.err;
}

// Fails if a mesh's surface cuts its trail off, or the trail covers what is in front.
TEST(Trails, OfMeshesAreBeyondTheirSurfaces) {
  const Folder folder;
  const std::string data = moving_mesh(folder);
  for (const Words& how : {Words{}, Words{"--surface=0"}, Words{"--surface=1"},
                           Words{"--mode", "isosurface", "--iso", "1.5"}}) {
    Words words{data, "--time", "2", "--motion-blur", "2"};
    words.insert(words.end(), how.begin(), how.end());
    const auto seen = seen_in_thirds(draw_small(folder, words));
    EXPECT_GT(seen[1], 5) << joined(how);
    EXPECT_GT(seen[0], 5) << joined(how);
  }
}

// Fails if the camera has in sight only what is there, or what was there at the trail's beginning.
TEST(Trails, OfLatticesFillThePictureFromEndToEnd) {
  const Folder folder;
  const Words line = moving_blob(folder, {10, 20, 30, 40, 50});
  const Words there_and_back = moving_blob(folder, {10, 25, 40, 54, 40, 25, 10});
  for (const Words& data : {line, there_and_back}) {
    for (const Words& how :
         {Words{"--opacity", "0:0,20:0.5"}, Words{"--mode", "isosurface", "--iso", "20"}}) {
      Words words = data;
      words.insert(words.end(), {"--step", std::to_string(data.size() - 1), "--motion-blur", "9"});
      words.insert(words.end(), how.begin(), how.end());
      const auto [first, last] = columns_seen(draw_small(folder, words));
      EXPECT_GT(first, 0) << joined(words);
      EXPECT_LT(first, 12) << joined(words);
      EXPECT_GT(last, 83) << joined(words);
      EXPECT_LT(last, 95) << joined(words);
    }
  }
}

TEST(Trails, RefuseWhatTheyAreNotFor) {
  const Folder folder;
  const std::string data = moving_particles(folder, true);
  const auto refused = [&](const Words& how, int code, const Words& said) {
    Words words{"render", data, "-o", folder / "a.png", "--motion-blur", "3"};
    words.insert(words.end(), how.begin(), how.end());
    expect_failure(words, code, said);
  };
  refused({"--mode", "maximum"}, 2, {"--motion-blur: is for --mode"});
  refused({"--points=1"}, 2, {"--motion-blur"});
  refused({"--post-convolution", "cubic"}, 2, {"--post-convolution"});
  refused({"--time", "21"}, 1, {"21"});
  const std::string galaxy = folder / "galaxy.csv";
  expect_success({"make", "galaxy", "--count", "100", "-o", galaxy});
  expect_failure({"render", galaxy, "--motion-blur", "1", "-o", folder / "a.png"}, 1,
                 {"--motion-blur", "one step"});
}

}  // namespace trails_test
}  // namespace ovoid::cli_tests
