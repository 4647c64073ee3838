// SPDX-License-Identifier: Apache-2.0
// The tab "scene": surfaces and slices beside the data. Fails if the command or the state draws
// another picture, if a dropped surface takes the place of the data or data that of a surface, or
// if a file that cannot be read costs anything.
#include <thread>

#include "screen.h"

namespace ovoid::viewer_tests {
namespace scene_window_test {

class WindowScene : public OnScreen {
 protected:
  // A tetrahedron around a place, as three formats have it.
  static constexpr float kCorners[4][3] = {
      {-0.3F, -0.3F, -0.2F}, {0.3F, -0.3F, -0.2F}, {0, 0.3F, -0.2F}, {0, 0, 0.5F}};
  static constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

  std::string obj(const std::string& name, float x = 0.5F) const {
    std::ofstream out(folder_ / name);
    for (const auto& corner : kCorners)
      out << "v " << corner[0] + x << ' ' << corner[1] - 0.6F << ' ' << corner[2] << '\n';
    for (const auto& face : kFaces)
      out << "f " << face[0] + 1 << ' ' << face[1] + 1 << ' ' << face[2] + 1 << '\n';
    return folder_ / name;
  }
  std::string ply(const std::string& name, bool has_faces) const {
    std::ofstream out(folder_ / name);
    out << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        << "property float z\nproperty float heat\n";
    if (has_faces) out << "element face 4\nproperty list uchar int vertex_indices\n";
    out << "end_header\n";
    for (const auto& corner : kCorners)
      out << corner[0] << ' ' << corner[1] << ' ' << corner[2] << " 1\n";
    for (const auto& face : kFaces) {
      if (has_faces) out << "3 " << face[0] << ' ' << face[1] << ' ' << face[2] << '\n';
    }
    return folder_ / name;
  }
  std::string vtp(const std::string& name, const std::string& array) const {
    std::ofstream out(folder_ / name);
    out << R"(<VTKFile type="PolyData" version="0.1"><PolyData><Piece NumberOfPoints="4" )"
        << R"(NumberOfPolys="4"><PointData><DataArray type="Float32" format="ascii" Name=")"
        << array << R"(">1 2 3 4</DataArray></PointData><Points><DataArray type="Float32" )"
        << R"(NumberOfComponents="3" format="ascii">)";
    for (const auto& corner : kCorners)
      out << corner[0] << ' ' << corner[1] << ' ' << corner[2] << ' ';
    out << R"(</DataArray></Points><Polys><DataArray type="Int32" Name="connectivity" )"
        << R"(format="ascii">)";
    for (const auto& face : kFaces) out << face[0] << ' ' << face[1] << ' ' << face[2] << ' ';
    out << R"(</DataArray><DataArray type="Int32" Name="offsets" format="ascii">3 6 9 12)"
        << R"(</DataArray></Polys></Piece></PolyData></VTKFile>)";
    return folder_ / name;
  }
  bool has_vtk() const {
    return cli_tests::run({"info", vtp("probe.vtp", "heat")}).err.find("VTK") == std::string::npos;
  }

  static std::string add(const std::string& path) {
    return "click scene.path\nkey ctrl+a\ntype " + path + "\nclick scene.add\nwait idle\n";
  }
  static constexpr const char* kBegin = "pace 0\nwait idle\nclick tab.scene\n";
};

TEST_F(WindowScene, SurfacesAreThoseOfTheCommandAndTheState) {
  obj("a.obj");
  obj("b.obj", 0.2F);
  const Viewed viewed =
      view({make_head()}, std::string(kBegin) + "picture $/alone.png\n" + add("$/a.obj") +
                              "expect scene.surfaces == 1\nexpect scene.surface.0.triangles == 4\n"
                              "picture $/one.png\n" +
                              add("$/b.obj") +
                              "click scene.surface.1.opacity@0.5,0.5\nclick scene.edges@0.05,0.5\n"
                              "wait idle\n" +
                              kSave);
  EXPECT_FALSE(file("alone.png") == file("one.png"));
  EXPECT_FALSE(file("one.png") == file("window.png"));
  expect_same(viewed, "window.png", "s.json");
  // The state and what it names can be moved together.
  const auto state = nlohmann::json::parse(file("s.json"));
  EXPECT_EQ(state["flags"]["add"], nlohmann::json({"a.obj", "b.obj"})) << file("s.json");
  EXPECT_EQ(state["flags"]["add-edges"], true);
}

TEST_F(WindowScene, SlicesAreThoseOfTheCommandAndTheState) {
  const Viewed viewed = view(
      {make_head()},
      std::string(kBegin) +
          "picture $/0.png\nclick scene.slice.axial\nwait idle\npicture $/1.png\n"
          "expect scene.slices == 1\nexpect scene.slice.0.normal.2 == 1\nprint "
          "scene.slice.0.offset\n"
          "click scene.slice.0.offset@0.4,0.5\nwait idle\nprint scene.slice.0.offset\n"
          "picture $/2.png\nclick scene.slice.oblique\nclick scene.map\nclick scene.map/viridis\n"
          "click scene.opacity@0.8,0.5\nclick scene.clear@0.05,0.5\n"
          "click scene.outlines@0.05,0.5\n"
          "click scene.range.usual@0.05,0.5\nexpect scene.has_range == true\n"
          "drag left scene.range.window -20,0\nwait idle\n" +
          kSave);
  for (const char* const other : {"0.png", "1.png", "2.png"})
    EXPECT_FALSE(file(other) == file("window.png")) << other;
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("2.png"));
  EXPECT_NE(viewed.number("scene.slice.0.offset", 0), viewed.number("scene.slice.0.offset", 1));
  expect_same(viewed, "window.png", "s.json");
  // What the command line says is what the tab shows.
  const Viewed again =
      view({"--state", folder_ / "s.json"}, std::string(kBegin) +
                                                "expect scene.slices == 2\n"
                                                "expect scene.map == viridis\n"
                                                "expect scene.shows_empty == true\n"
                                                "expect scene.outlines == true\n"
                                                "expect scene.has_range == true\n"
                                                "picture $/again.png\n");
  EXPECT_TRUE(file("again.png") == file("window.png"));
}

// The dot in the picture moves a slice, undo brings it back, and the slice can go.
TEST_F(WindowScene, ASliceIsDraggedTakenBackAndRemoved) {
  const Viewed viewed =
      view({make_head(), "--view", "top"},
           std::string(kBegin) +
               "picture $/0.png\nclick scene.slice.sagittal\nwait idle\npicture $/1.png\n"
               "print scene.slice.0.offset\ndrag left handle.slice.0.offset 15,0\nwait idle\n"
               "print scene.slice.0.offset\nkey ctrl+z\nwait idle\npicture $/back.png\n"
               "click scene.slice.0.remove\nwait idle\nexpect scene.slices == 0\n"
               "picture $/removed.png\n");
  EXPECT_GT(std::abs(viewed.number("scene.slice.0.offset", 1)), 0.02);  // it was in the middle
  EXPECT_TRUE(file("back.png") == file("1.png"));
  EXPECT_TRUE(file("removed.png") == file("0.png"));
}

// Fails if a hidden surface is seen or forgotten, or comes back otherwise than it was.
TEST_F(WindowScene, WhatIsHiddenComesBackAsItWas) {
  obj("a.obj");
  obj("b.obj", 0.2F);
  const Viewed viewed = view(
      {make_head(), "--add", folder_ / "a.obj", "--add", folder_ / "b.obj", "--add-opacity", "0.5"},
      std::string(kBegin) +
          "expect scene.surfaces == 2\npicture $/both.png\n"
          "click scene.surface.0.show@0.02,0.5\nwait idle\n" +
          kSave);
  EXPECT_EQ(viewed.text("clipboard").find("a.obj"), std::string::npos);
  EXPECT_FALSE(file("both.png") == file("window.png"));
  expect_same(viewed, "window.png", "s.json");
  view({"--state", folder_ / "s.json"},
       std::string(kBegin) +
           "expect scene.surfaces == 2\nexpect scene.surface.0.is_hidden == true\n"
           "expect scene.surface.0.opacity == 0.5\nclick scene.surface.0.show@0.02,0.5\n"
           "wait idle\npicture $/again.png\n");
  EXPECT_TRUE(file("again.png") == file("both.png"));
}

TEST_F(WindowScene, UndoTakesBackWhatWasAddedAndRemoved) {
  obj("a.obj");
  view({make_head()}, std::string(kBegin) + "picture $/0.png\n" + add("$/a.obj") +
                          "picture $/1.png\nmove picture@0.1,0.9\nkey ctrl+z\nwait idle\n"
                          "expect scene.surfaces == 0\npicture $/undone.png\n"
                          "key ctrl+y\nwait idle\npicture $/redone.png\n"
                          "click scene.surface.0.remove\nwait idle\nexpect scene.surfaces == 0\n"
                          "picture $/removed.png\nmove picture@0.1,0.9\nkey ctrl+z\nwait idle\n"
                          "expect scene.surfaces == 1\npicture $/back.png\n");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  for (const char* const name : {"undone.png", "removed.png"})
    EXPECT_TRUE(file(name) == file("0.png")) << name;
  for (const char* const name : {"redone.png", "back.png"})
    EXPECT_TRUE(file(name) == file("1.png")) << name;
}

TEST_F(WindowScene, ADroppedSurfaceIsAddedAndDataAreOpened) {
  obj("a.obj");
  obj("b.obj", 0.2F);
  ply("points.ply", false);
  view({make_head()}, std::string(kBegin) +
                          "print kernels\ndrop $/a.obj $/b.obj\nwait idle\n"
                          "expect scene.surfaces == 2\nexpect array == head\n"
                          "drop $/points.ply\nwait 20 frames\nwait idle\n"
                          "expect kernels == 4\nexpect scene.surfaces == 0\n");
  // Where nothing is shown there is nothing to be beside.
  view({},
       "pace 0\ndrop $/a.obj\nwait 20 frames\nwait idle\nexpect kernels == 4\n"
       "expect scene.surfaces == 0\n");
  // Nor is it what somebody asks to be opened.
  view({make_head()},
       "pace 0\nwait idle\nclick tab.data\nclick data.open.path\ntype $/a.obj\nclick data.open\n"
       "wait 20 frames\nwait idle\nexpect kernels == 4\n");
}

TEST_F(WindowScene, MeshesWithValuesOpenWhereTheyAreDropped) {
  if (!has_vtk()) GTEST_SKIP() << "this build has no VTK";
  ply("faces.ply", true);
  // Fewer faces than it says: no surface, but no points either.
  std::string lying = file("faces.ply");
  lying.replace(lying.find("element face 4"), 14, "element face 9000000");
  write_file(folder_ / "lying.ply", lying);
  vtp("plain.vtp", "Normals");
  vtp("values.vtp", "heat");
  view({make_head()}, std::string(kBegin) +
                          "drop $/faces.ply\nwait idle\nexpect scene.surfaces == 1\n"
                          "drop $/lying.ply\nwait 20 frames\nwait idle\nexpect array == head\n"
                          "expect scene.error contains lying.ply\n"
                          "drop $/plain.vtp\nwait idle\nexpect scene.surfaces == 2\n"
                          "drop $/plain.vtp $/values.vtp\nwait idle\n"
                          "expect scene.surfaces == 3\nexpect scene.error contains values.vtp\n"
                          "expect array == head\n"
                          "drop $/values.vtp\nwait 20 frames\nwait idle\nexpect array == heat\n");
}

TEST_F(WindowScene, WhatCannotBeReadIsSaidAndNothingIsLost) {
  obj("a.obj");
  write_file(folder_ / "broken.obj", "v 0 0 0\nv 1 0 0\nf 1 2 77\n");
  const std::string head = make_head();
  view({head},
       std::string(kBegin) + add("$/a.obj") + "picture $/0.png\n" + add("$/missing.stl") +
           "expect scene.error contains missing.stl\nexpect message contains missing.stl\n" +
           add("$/broken.obj") + "expect scene.error contains broken.obj\n" +
           "drop $/broken.obj\nwait idle\nexpect scene.error contains broken.obj\n"
           "expect array == head\nexpect scene.surfaces == 1\npicture $/1.png\n" +
           add("$/a.obj") + "expect scene.error == \"\"\nexpect scene.surfaces == 2\n");
  EXPECT_TRUE(file("0.png") == file("1.png"));
}

// Modes without depth show none, and the command names none.
TEST_F(WindowScene, ModesOfOneValueShowNone) {
  obj("a.obj");
  const std::string head = make_head();
  const Viewed viewed =
      view({head, "--add", folder_ / "a.obj", "--slice", "z"},
           "pace 0\nwait idle\nclick look.mode\nclick look.mode/maximum\nwait idle\n"
           "expect scene.is_seen == false\npicture $/window.png\nkey ctrl+c\nprint clipboard\n"
           "state $/s.json\nclick look.mode\nclick look.mode/composite\nwait idle\n"
           "expect scene.is_seen == true\nexpect scene.surfaces == 1\n");
  expect_same(viewed, "window.png", "s.json");
}

// The surface's file is written again while the window watches it.
TEST_F(WindowScene, WatchedSurfacesAreReadAgain) {
  obj("a.obj");
  const std::string head = make_head();
  write_file(folder_ / "script.txt",
             "wait idle\nkey ctrl+c\nprint version\npicture " + (folder_ / "0.png") +
                 "\nwait 3000 ms\nwait idle\npicture " + (folder_ / "1.png") +
                 "\nprint version\nexpect scene.surfaces == 1\nprint clipboard\nstate " +
                 (folder_ / "s.json") + "\n");
  Program viewer({head, "--add", folder_ / "a.obj", "--watch", "--no-panel", "--size", "160x120",
                  "--backend", "cpu", "--script", folder_ / "script.txt"},
                 OVOID_VIEWER_PROGRAM);
  for (int i = 0; i < 3000 && !std::filesystem::exists(folder_ / "0.png"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  obj("a.obj", 0.2F);
  Viewed viewed;
  viewed.take(viewer.finish(kLimitSeconds));
  EXPECT_EQ(viewed.outcome.exit_code, 0);
  EXPECT_EQ(viewed.outcome.err, "");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_GT(viewed.number("version", 1), viewed.number("version", 0));
  expect_same(viewed, "1.png", "s.json");
}

// Over steps in time a surface stays; the slice shows each step's own values.
TEST_F(WindowScene, StaysOverStepsInTime) {
  obj("a.obj", 12);
  const Viewed viewed = view({make("tornado", "all.h5", {"--size", "24", "--steps", "4"}),
                              "--slice", "z", "--add", folder_ / "a.obj"},
                             "pace 0\nwait idle\npicture $/0.png\nkey right\nwait idle\n"
                             "expect time.now > 0\nexpect scene.surfaces == 1\n" +
                                 std::string(kSave));
  EXPECT_FALSE(file("0.png") == file("window.png"));
  expect_same(viewed, "window.png", "s.json");
}

}  // namespace scene_window_test
}  // namespace ovoid::viewer_tests
