// SPDX-License-Identifier: Apache-2.0
// --add: surfaces in the scene, from files of all kinds. Fails if a format's faces are not those of
// the others, if colours go to other surfaces than was said, or if what is no surface is drawn.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "program.h"

namespace ovoid::cli_tests {
namespace geometry_test {

// A pyramid whose base looks at -y, where `ovoid render` looks from; and its top.
constexpr float kCorners[5][3] = {
    {-20, -30, -20}, {20, -30, -20}, {20, -30, 20}, {-20, -30, 20}, {0, 30, 0}};
constexpr int kFaces[6][3] = {{0, 1, 2}, {0, 2, 3}, {0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}};

class GeometryFiles : public testing::Test {
 protected:
  void SetUp() override {
    expect_success({"make", "ball", "--size", "32", "-o", ball_});
    write_obj();
    if (run({"info", obj_}).err.find("VTK") != std::string::npos)
      GTEST_SKIP() << "this build has no VTK";
  }

  static float at(int corner, int axis) { return kCorners[corner][axis] / 40; }

  void write_obj() {
    std::ofstream out(obj_);
    for (int c = 0; c < 5; ++c)
      out << "v " << at(c, 0) << ' ' << at(c, 1) << ' ' << at(c, 2) << '\n';
    out << "f 1 2 3 4\n";  // a quadrilateral: the others have triangles
    for (int f = 2; f < 6; ++f)
      out << "f " << kFaces[f][0] + 1 << ' ' << kFaces[f][1] + 1 << ' ' << kFaces[f][2] + 1 << '\n';
  }

  std::string ply() {
    const std::string path = folder_ / "pyramid.ply";
    std::ofstream out(path);
    out << "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty "
           "float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n";
    for (int c = 0; c < 5; ++c) out << at(c, 0) << ' ' << at(c, 1) << ' ' << at(c, 2) << '\n';
    for (const auto& face : kFaces)
      out << "3 " << face[0] << ' ' << face[1] << ' ' << face[2] << '\n';
    return path;
  }

  std::string stl(std::size_t bytes = 84 + 6 * 50) {
    std::string file(84, '\0');
    file[80] = 6;
    for (const auto& face : kFaces) {
      float numbers[12] = {};
      for (int c = 0; c < 3; ++c)
        for (int a = 0; a < 3; ++a) numbers[3 + 3 * c + a] = at(face[c], a);
      file.append(reinterpret_cast<const char*>(numbers), sizeof(numbers)).append(2, '\0');
    }
    const std::string path = folder_ / "pyramid.stl";
    std::ofstream(path, std::ios::binary) << file.substr(0, bytes);
    return path;
  }

  std::string vtp() {
    const std::string path = folder_ / "pyramid.vtp";
    std::ofstream out(path);
    out << R"(<VTKFile type="PolyData" version="0.1"><PolyData><Piece NumberOfPoints="5" )"
        << R"(NumberOfPolys="6"><Points><DataArray type="Float32" NumberOfComponents="3" )"
        << R"(format="ascii">)";
    for (int c = 0; c < 5; ++c) out << at(c, 0) << ' ' << at(c, 1) << ' ' << at(c, 2) << ' ';
    out << R"(</DataArray></Points><Polys><DataArray type="Int32" Name="connectivity" )"
        << R"(format="ascii">)";
    for (const auto& face : kFaces) out << face[0] << ' ' << face[1] << ' ' << face[2] << ' ';
    out << R"(</DataArray><DataArray type="Int32" Name="offsets" format="ascii">)"
        << R"(3 6 9 12 15 18</DataArray></Polys></Piece></PolyData></VTKFile>)";
    return path;
  }

  // Half as large, in a node that doubles it.
  std::string gltf() {
    std::string numbers;
    const auto put = [&](auto number) {
      numbers.append(reinterpret_cast<const char*>(&number), sizeof(number));
    };
    for (int c = 0; c < 5; ++c)
      for (int a = 0; a < 3; ++a) put(at(c, a) / 2);
    for (const auto& face : kFaces)
      for (const int corner : face) put(static_cast<std::uint16_t>(corner));
    std::ofstream(folder_ / "pyramid.bin", std::ios::binary) << numbers;
    const std::string path = folder_ / "pyramid.gltf";
    std::ofstream(path)
        << R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0, "nodes": )"
        << R"([{"mesh": 0, "scale": [2, 2, 2]}], "meshes": [{"primitives": [{"attributes": )"
        << R"({"POSITION": 0}, "indices": 1}]}], "accessors": [{"bufferView": 0, "componentType": )"
        << R"(5126, "count": 5, "type": "VEC3", "min": [-1, -1, -1], "max": [1, 1, 1]}, )"
        << R"({"bufferView": 1, "componentType": 5123, "count": 18, "type": "SCALAR"}], )"
        << R"("bufferViews": [{"buffer": 0, "byteLength": 60}, {"buffer": 0, "byteOffset": 60, )"
        << R"("byteLength": 36}], "buffers": [{"uri": "pyramid.bin", "byteLength": 96}]})";
    return path;
  }

  Picture drawn(const Words& more) {
    Words words{ball_, "--size", "64x64", "--projection", "parallel"};
    words.insert(words.end(), more.begin(), more.end());
    return draw(folder_, words);
  }

  Folder folder_;
  std::string ball_ = folder_ / "ball.nrrd", obj_ = folder_ / "pyramid.obj";
};

// But for rounding: their faces have other corners first.
float greatest_difference(const Picture& a, const Picture& b) {
  float greatest = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    greatest = std::max(greatest, std::abs(a.rgba[i] - b.rgba[i]));
  return greatest;
}

TEST_F(GeometryFiles, AllFormatsShowTheSameFaces) {
  const Picture expected = drawn({"--add", obj_});
  EXPECT_GT(greatest_difference(expected, drawn({})), 0.2F);
  for (const std::string& file : {ply(), stl(), vtp(), gltf()})
    EXPECT_LT(greatest_difference(expected, drawn({"--add", file})), 1e-3F) << file;
}

TEST_F(GeometryFiles, ColoursGoToTheirSurfaces) {
  const auto middle = [&](const Words& more) {
    Words words{"--no-shade", "--occlusion", "0", "--add", obj_};
    words.insert(words.end(), more.begin(), more.end());
    const Picture picture = drawn(words);
    const std::size_t at = 4 * (32 * 64 + 32);
    // Red, less green: what the data before the surface add to both.
    return picture.rgba[at] - picture.rgba[at + 1];
  };
  const float red = middle({"--add-color", "1,0,0"});
  EXPECT_GT(red, 0.3F);
  EXPECT_LT(middle({"--add-color", "0,1,0"}), -0.3F);
  // Of two in one place the first is before the second.
  EXPECT_NEAR(middle({"--add-color", "1,0,0", "--add", stl(), "--add-color", "0,1,0"}), red, 1e-3F);
  EXPECT_LT(middle({"--add-color", "1,0,0", "--add-opacity", "0.25"}), 0.7F * red);
}

TEST_F(GeometryFiles, SlicesShowTheData) {
  const Picture gray = drawn({"--opacity", "0:0,1:0", "--slice", "coronal", "--slice-empty"});
  const std::size_t at = 4 * (32 * 64 + 32);
  EXPECT_EQ(gray.rgba[at + 3], 1);  // opaque, and gray
  EXPECT_NEAR(gray.rgba[at], gray.rgba[at + 2], 1e-4F);
  const Picture half =
      drawn({"--opacity", "0:0,1:0", "--slice", "0,1,0,0", "--slice-opacity", "0.5", "--slice-map",
             "viridis", "--slice-range", "0,2", "--slice-empty"});
  EXPECT_NEAR(half.rgba[at + 3], 0.5F, 1e-4F);
}

TEST_F(GeometryFiles, SurfacesAreFilesOfTheirOwn) {
  const Outcome info = run({"info", stl()});
  EXPECT_NE(info.out.find("6 triangle"), std::string::npos) << info.out << info.err;
  EXPECT_NE(run({"info", ply()}).out.find("particles"), std::string::npos);  // its points, as ever
}

TEST_F(GeometryFiles, WhatIsNoSurface) {
  const std::string out = folder_ / "out.png";
  const auto refused = [&](const Words& more, int code, const Words& said) {
    Words words{"render", ball_, "--size", "32x32", "-o", out};
    words.insert(words.end(), more.begin(), more.end());
    expect_failure(words, code, said);
    EXPECT_FALSE(std::filesystem::exists(out));
  };
  refused({"--add", ball_}, 1, {"--add", "holds a lattice"});
  refused({"--add", stl(), "--add-array", "speed"}, 1, {"speed"});
  refused({"--add", folder_ / "missing.stl"}, 1, {"missing.stl"});
  refused({"--add", stl(200)}, 1, {"pyramid.stl", "no STL file"});
  std::ofstream(obj_) << "v 0 0 0\nv 1 0 0\nf 1 2 77\n";
  refused({"--add", obj_}, 1, {"pyramid.obj"});
  std::ofstream(obj_) << "v 0 0 0\nv 1 0 0\nl 1\n";
  refused({"--add", obj_}, 1, {"pyramid.obj", "a line of 1"});
  refused({"--add", stl(), "--add-radius", "-1"}, 2, {"--add-radius"});
  refused({"--add", stl(), "--add-colormap", "hot"}, 2, {"without --add-array"});
  std::ofstream(obj_) << "v 0 0 0\n";
  refused({"--add", obj_}, 1, {"pyramid.obj"});
  refused({"--add", stl(), "--mode", "maximum"}, 2, {"--add", "composite and isosurface"});
  refused({"--add", stl(), "--value-plane", "1,0,0,0"}, 2, {"contradicts --value-plane"});
  refused({"--add-color", "1,0,0"}, 2, {"without --add"});
  refused({"--slice", "w"}, 2, {"--slice 'w'", "sagittal, coronal or axial"});
  refused({"--slice", "z=far"}, 2, {"--slice 'z=far'"});
  refused({"--slice", "0,0,0,1"}, 2, {"--slice '0,0,0,1'"});
  refused({"--slice-map", "viridis"}, 2, {"without --slice"});
  refused({"--slice", "z", "--slice-map", "viridi"}, 2, {"viridis"});
  refused({"--add", stl(), "--add-opacity", "-0.1"}, 2, {"--add-opacity"});
}

// Fails if a line or a point is not drawn, or is as thick as another.
// Fails if nobody hears that what was added is nowhere to be seen.
TEST_F(GeometryFiles, OutsideOfTheDataIsTold) {
  const auto said = [&](const std::string& path) {
    return run({"render", ball_, "--add", path, "--size", "20x20", "-o", folder_ / "p.png"}).err;
  };
  EXPECT_EQ(said(obj_).find("lies outside"), std::string::npos);
  for (const char* const x : {"5", "1e9", "1e30"}) {
    std::ofstream(folder_ / "far.obj")
        << "v " << x << " 0 0\nv " << x << " 1 0\nv " << x << " 0 1\nf 1 2 3\n";
    EXPECT_NE(said(folder_ / "far.obj").find("lies outside of the data"), std::string::npos) << x;
  }
}

TEST_F(GeometryFiles, LinesAreTubesAndPointsAreBalls) {
  const std::string line = folder_ / "line.obj", points = folder_ / "points.csv";
  std::ofstream(line) << "v -0.9 -2 0\nv 0 -2 0\nv 0.9 -2 0\nl 1 2 3\n";
  std::ofstream(points) << "x,y,z\n0,-2,0\n";
  const auto num_red = [&](const std::string& file, const char* radius) {
    const Picture picture = drawn({"--opacity", "0:0", "--add", file, "--add-color", "1,0,0",
                                   "--add-radius", radius, "--occlusion", "0"});
    double sum = 0;
    for (std::size_t i = 3; i < picture.rgba.size(); i += 4) sum += picture.rgba[i];
    return sum;
  };
  const double pixels = num_red(line, "0.2");
  EXPECT_GT(pixels, 100);
  EXPECT_NEAR(num_red(line, "0.1"), pixels / 2, 0.05 * pixels);
  const double disc = num_red(points, "0.4");
  EXPECT_NEAR(num_red(points, "0.2"), disc / 4, 0.05 * disc);
  EXPECT_NEAR(disc / pixels, std::acos(-1.0) * 0.16 / (1.8 * 0.4), 0.05);
}

// Streamlines: a VTP of lines with a speed at each node.
TEST_F(GeometryFiles, ArraysGiveColors) {
  const std::string path = folder_ / "lines.vtp";
  std::ofstream(path)
      << R"(<VTKFile type="PolyData" version="0.1"><PolyData><Piece NumberOfPoints="3" )"
      << R"(NumberOfLines="1"><PointData><DataArray type="Float32" Name="speed" format="ascii">)"
      << R"(0 5 10</DataArray></PointData><Points><DataArray type="Float32" )"
      << R"(NumberOfComponents="3" format="ascii">-0.9 -2 0 0 -2 0 0.9 -2 0</DataArray></Points>)"
      << R"(<Lines><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2</DataArray>)"
      << R"(<DataArray type="Int32" Name="offsets" format="ascii">3</DataArray></Lines></Piece>)"
      << R"(</PolyData></VTKFile>)";
  const auto colors = [&](const Words& more) {
    Words words{"--opacity", "0:0",          "--no-shade",  "--occlusion", "0",
                "--add",     path,           "--add-array", "speed",       "--add-colormap",
                "gray",      "--add-radius", "0.2"};
    words.insert(words.end(), more.begin(), more.end());
    const Picture picture = drawn(words);
    std::vector<float> reds;
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4)
      if (picture.rgba[i + 3] > 0.99F) reds.push_back(picture.rgba[i]);
    EXPECT_GT(reds.size(), 10U);
    return std::pair(*std::min_element(reds.begin(), reds.end()),
                     *std::max_element(reds.begin(), reds.end()));
  };
  const auto [least, most] = colors({});
  EXPECT_LT(least, 0.2F);
  EXPECT_GT(most, 0.7F);
  EXPECT_LT(colors({"--add-range", "0,100"}).second, 0.2F);
}

// Fails if what is hidden is seen, or read, or takes the colour of the next.
TEST_F(GeometryFiles, AnOpacityOfZeroHides) {
  const Words hidden = {"--add", folder_ / "missing.stl", "--add-color",
                        "1,0,0", "--add-opacity",         "0"};
  EXPECT_EQ(drawn(hidden).rgba, drawn({}).rgba);
  Words both = hidden;
  const Words seen = {"--add", obj_, "--add-color", "0,1,0", "--add-opacity", "0.5"};
  both.insert(both.end(), seen.begin(), seen.end());
  EXPECT_EQ(drawn(both).rgba, drawn(seen).rgba);
}

}  // namespace geometry_test
}  // namespace ovoid::cli_tests
