// SPDX-License-Identifier: Apache-2.0
// Mouse and keys on the picture and on the tabs "look" and "space": what they do to the view, that
// the picture follows, and that undo takes it back.
#include "screen.h"

namespace ovoid::viewer_tests {
namespace look_window_test {

class WindowHands : public OnScreen {};

TEST_F(WindowHands, OrbitPanRollAndZoomMoveTheCamera) {
  const Viewed viewed = view({make_head(), "--no-panel"},
                             "pace 0\nwait full\nprint camera\npicture $/0.png\n"
                             "drag left picture 40,10\nwait full\nprint camera\npicture $/1.png\n"
                             "drag middle picture 20,-15\nwait full\nprint camera\n"
                             "picture $/2.png\n"
                             "drag right picture 0,-30\nwait full\nprint camera\npicture $/3.png\n"
                             "wheel 3 picture\nwait full\nprint camera\npicture $/4.png\n"
                             "key down ctrl\ndrag left picture@0.8,0.5 0,30\nkey up ctrl\n"
                             "wait full\nprint camera\npicture $/5.png\n"
                             "key r\nwait full\nprint camera\npicture $/6.png\n");
  const auto camera = [&](std::size_t time) { return viewed.json("camera", time); };
  const auto focus = [&](std::size_t time) { return camera(time)["focal_point"]; };
  const auto length = [&](std::size_t time) { return camera(time)["distance"].get<double>(); };
  // Orbit: about the focal point.
  EXPECT_GT(distance(camera(0)["position"], camera(1)["position"]), 0.1 * length(0));
  EXPECT_EQ(focus(0), focus(1));
  EXPECT_NEAR(length(1), length(0), 1e-9 * length(0));
  // Pan: with the focal point.
  EXPECT_GT(distance(focus(2), focus(1)), 0.01 * length(0));
  EXPECT_NEAR(length(2), length(1), 1e-9 * length(0));
  // Upwards comes nearer: 1.008 per pixel, 1.12 per notch.
  EXPECT_NEAR(length(3) * std::pow(1.008, 30), length(2), 1e-6 * length(0));
  EXPECT_NEAR(length(4) * std::pow(1.12, 3), length(3), 1e-6 * length(0));
  EXPECT_EQ(camera(5)["position"], camera(4)["position"]);
  EXPECT_GT(distance(camera(5)["view_up"], camera(4)["view_up"]), 0.1);
  EXPECT_LT(distance(camera(6)["position"], camera(0)["position"]), 1e-9 * length(0));
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(file(std::to_string(i) + ".png") == file(std::to_string(i + 1) + ".png")) << i;
  }
  EXPECT_TRUE(file("6.png") == file("0.png"));
}

TEST_F(WindowHands, KeysLookAlongTheAxesAndToggleThings) {
  const Viewed viewed =
      view({make_head()},
           "pace 0\nwait full\nkey 1\nprint camera.position\nkey 2\n"
           "print camera.position\nkey 5\nprint camera.position\n"
           "print camera.focal_point\nkey p\nexpect camera.parallel == true\nkey p\n"
           "expect camera.parallel == false\nexpect has_panel == true\nkey tab\n"
           "wait 2 frames\nexpect has_panel == false\nexpect picture.width == 680\n"
           "key tab\nwait 2 frames\nexpect picture.width == 340\n"
           "expect help == false\nkey ?\nexpect help == true\nkey escape\n"
           "expect help == false\n");
  const auto focus = viewed.json("camera.focal_point");
  EXPECT_GT(viewed.json("camera.position", 0)[0], focus[0]);  // from +x
  EXPECT_LT(viewed.json("camera.position", 1)[0], focus[0]);  // from -x
  EXPECT_GT(viewed.json("camera.position", 2)[2], focus[2]);  // from +z
}

// Two quick drags from the same place are no double click.
TEST_F(WindowHands, QuickDragsKeepTheFocalPoint) {
  const Viewed viewed = view({make_head(), "--no-panel"},
                             "pace 0\nwait idle\nprint camera.focal_point\n"
                             "drag left picture@0.5,0.4 20,0 2\ndrag left picture@0.5,0.4 20,0 2\n"
                             "drag left picture@0.5,0.4 20,0 2\nprint camera.focal_point\n");
  EXPECT_EQ(viewed.json("camera.focal_point", 0), viewed.json("camera.focal_point", 1));
}

// The place under the mouse becomes the one to turn about.
TEST_F(WindowHands, ADoubleClickTurnsAboutThePlaceUnderTheMouse) {
  const Viewed viewed = view({make_head(), "--no-panel"},
                             "wait idle\nmove picture@0.5,0.4\nwait 3 frames\n"
                             "print picked.position\nclick picture@0.5,0.4 double\nwait 3 frames\n"
                             "print camera.focal_point\n");
  EXPECT_LT(distance(viewed.json("picked.position"), viewed.json("camera.focal_point")), 1e-9);
}

TEST_F(WindowHands, WhatIsUnderTheMouseIsWhatSampleSays) {
  for (const Words& made : {Words{"head", "head.nrrd", "--size", "48"},
                            Words{"blobs", "blobs.ply", "--count", "200"}}) {
    const std::string path = make(made[0], made[1], {made.begin() + 2, made.end()});
    const Viewed viewed =
        view({path, "--no-panel", "--view", "+z", "--fit", "box", "--unit-distance", "0.001"},
             "wait idle\nmove picture@0.5,0.45\nwait 3 frames\nprint picked\nmove 1,1\n"
             "wait 3 frames\nprint all\n");
    const auto picked = viewed.json("picked");
    ASSERT_TRUE(picked.is_object()) << viewed.text("picked");
    EXPECT_EQ(picked["is_defined"], true);
    const auto place = picked["position"];
    write_file(folder_ / "points.csv",
               "x,y,z\n" + place[0].dump() + ',' + place[1].dump() + ',' + place[2].dump() + '\n');
    cli_tests::expect_success(
        {"sample", path, "--points", folder_ / "points.csv", "-o", folder_ / "out.csv"});
    std::istringstream table(file("out.csv"));
    std::string head;
    std::string row;
    std::getline(table, head);
    std::getline(table, row);
    for (int i = 0; i < 3; ++i) row.erase(0, row.find(',') + 1);
    // The same function in double precision; the file has at least the digits of a float.
    const double wanted = std::atof(row.c_str());
    EXPECT_NEAR(picked["value"].get<double>(), wanted, 1e-6 * std::max(1.0, std::abs(wanted)));
    // In the corner there is nothing.
    EXPECT_FALSE(viewed.json("all").contains("picked"));
  }
}

class WindowLook : public OnScreen {};

TEST_F(WindowLook, AnOpacityPointIsDraggedAndTakenBack) {
  const Viewed viewed = view({make_head()},
                             "pace 0\nwait full\nexpect can_undo == false\nprint view.opacities\n"
                             "picture $/0.png\ndrag left look.opacity.1 0,-40\nwait full\n"
                             "print view.opacities\nexpect can_undo == true\npicture $/1.png\n"
                             "key ctrl+z\nwait full\nprint view.opacities\n"
                             "expect can_redo == true\nexpect can_undo == false\npicture $/2.png\n"
                             "key ctrl+y\nwait full\nprint view.opacities\n"
                             "expect can_redo == false\npicture $/3.png\n");
  const auto points = [&](std::size_t time) { return viewed.json("view.opacities", time); };
  EXPECT_GT(points(1)[1]["opacity"], points(0)[1]["opacity"]);
  EXPECT_EQ(points(1)[0], points(0)[0]);
  EXPECT_EQ(points(2), points(0));
  EXPECT_EQ(points(3), points(1));
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_TRUE(file("2.png") == file("0.png"));
  EXPECT_TRUE(file("3.png") == file("1.png"));
}

TEST_F(WindowLook, PointsAreAddedAndDeleted) {
  const Viewed viewed = view({make_head()},
                             "pace 0\nwait full\nprint view.points\n"
                             "click look.opacity@0.7,0.3\nwait full\nprint view.points\n"
                             "print view.opacities\n"
                             "key delete\nwait 3 frames\nprint view.points\nprint view.opacities\n"
                             "click look.opacity.1 right\nwait 3 frames\nprint view.points\n"
                             "click look.colors@0.8,0.5\nwait 3 frames\nprint view.colors\n"
                             "key ctrl+z\nwait 3 frames\nprint view.colors\n"
                             "key ctrl+z\nwait 3 frames\nprint view.points\n");
  const double first = viewed.number("view.points");
  EXPECT_EQ(viewed.number("view.points", 1), first + 1);
  EXPECT_EQ(viewed.number("view.points", 2), first);
  EXPECT_EQ(viewed.number("view.points", 3), first - 1);
  EXPECT_EQ(viewed.number("view.points", 4), first);
  EXPECT_EQ(viewed.number("view.colors", 0), viewed.number("view.colors", 1) + 1);
  // In the order of their values all the while.
  const auto points = viewed.json("view.opacities");
  for (std::size_t i = 1; i < points.size(); ++i) EXPECT_LE(points[i - 1]["x"], points[i]["x"]);
}

// Nothing is left of a curve without points, so the last one stays.
TEST_F(WindowLook, TheLastPointStays) {
  view({make_head()},
       "pace 0\nwait full\nrepeat 12\nclick look.opacity.0 right\nwait 2 frames\n"
       "end\nexpect view.points == 1\nwait full\n");
}

TEST_F(WindowLook, ColorMapModeIsovalueAndUndo) {
  const Viewed viewed =
      view({make_head()},
           "pace 0\nwait full\nprint view.colors\nclick look.map\n"
           "click look.map/plasma\nwait full\nprint view.colors\n"
           "expect view.mode == composite\nclick look.mode\n"
           "click look.mode/isosurface\nwait full\nexpect view.mode == isosurface\n"
           "print view.isovalue\npicture $/0.png\nclick look.isovalue@0.7,0.5\n"
           "wait full\nprint view.isovalue\npicture $/1.png\n"
           "click look.undo\nwait full\nprint view.isovalue\npicture $/2.png\n"
           "click look.undo\nwait full\nexpect view.mode == composite\n"
           "click look.undo\nwait full\nprint view.colors\n"
           "expect can_undo == false\nclick look.redo\nwait 3 frames\n"
           "print view.colors\n");
  EXPECT_NE(viewed.number("view.colors", 1), viewed.number("view.colors", 0));
  EXPECT_EQ(viewed.number("view.colors", 2), viewed.number("view.colors", 0));
  EXPECT_EQ(viewed.number("view.colors", 3), viewed.number("view.colors", 1));
  EXPECT_GT(viewed.number("view.isovalue", 1), viewed.number("view.isovalue", 0));
  EXPECT_EQ(viewed.number("view.isovalue", 2), viewed.number("view.isovalue", 0));
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_TRUE(file("0.png") == file("2.png"));
}

// A number is typed after a double click.
// Fails if a list of isosurfaces does not begin with the one that was there, or does not end as
// one.
TEST_F(WindowLook, IsosurfacesAreAddedAndRemoved) {
  const Viewed viewed =
      view({make_head()},
           "pace 0\nwait full\nclick look.mode\nclick look.mode/isosurface\nwait full\n"
           "picture $/0.png\nprint view.isovalue\nexpect view.isosurfaces == 0\n"
           "click look.iso.add\nwait full\nexpect view.isosurfaces == 2\n"
           "print view.isosurface.0.value\nprint view.isosurface.1.value\npicture $/1.png\n"
           "click look.iso.1.own@0.05,0.5\nwait full\nexpect view.isosurface.1.has_color == true\n"
           "click look.iso.1.remove\nwait full\nexpect view.isosurfaces == 0\npicture $/2.png\n"
           "key ctrl+z\nwait full\nexpect view.isosurfaces == 2\n"
           "repeat 20\nclick look.iso.add\nend\nwait full\nexpect view.isosurfaces == 16\n");
  EXPECT_EQ(viewed.text("view.isosurface.0.value"), viewed.text("view.isovalue"));
  EXPECT_NE(viewed.text("view.isosurface.1.value"), viewed.text("view.isovalue"));
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_TRUE(file("0.png") == file("2.png"));
}

TEST_F(WindowLook, NumbersAreTyped) {
  view({make_head()},
       "pace 0\nwait full\nclick look.range.hi double\nwait 2 frames\n"
       "key ctrl+a\ntype 900\nkey enter\nwait 3 frames\n"
       "expect view.range.1 == 900\nwait full\n");
}

// Keys belong to the field that is typed into, not to the picture.
TEST_F(WindowLook, KeysInATextFieldAreNoShortcuts) {
  view({make_head()},
       "pace 0\nwait full\nprint camera\nclick look.path\nwait 2 frames\nkey p\n"
       "type p\nkey ctrl+z\nwait 2 frames\nexpect camera.parallel == false\n"
       "expect has_panel == true\n");
}

class WindowSpace : public OnScreen {};

TEST_F(WindowSpace, CropByHandleAndSlider) {
  const Viewed viewed = view({make_head(), "--view", "+z", "--fit", "box"},
                             "pace 0\nwait full\npicture $/0.png\nclick tab.space\n"
                             "expect view.has_crop == false\nclick space.crop@0.05,0.5\n"
                             "wait full\nexpect view.has_crop == true\npicture $/1.png\n"
                             "drag left handle.crop.x1 -40,0\nwait full\nprint view.crop\n"
                             "picture $/2.png\nclick space.crop.x1@0.999,0.5\nwait full\n"
                             "print view.crop\npicture $/3.png\n"
                             "click space.crop.x0@0.3,0.5\nwait full\nprint view.crop\n"
                             "picture $/4.png\nclick space.crop@0.05,0.5\nwait full\n"
                             "expect view.has_crop == false\npicture $/5.png\n");
  EXPECT_TRUE(file("0.png") == file("1.png"));  // nothing is cut yet
  EXPECT_TRUE(viewed.json("view.crop", 0)["max"][0].is_number());
  EXPECT_TRUE(viewed.json("view.crop", 0)["max"][1].is_null());  // infinite
  EXPECT_FALSE(file("2.png") == file("1.png"));
  EXPECT_TRUE(viewed.json("view.crop", 1)["max"][0].is_null());  // at the data's end nothing is cut
  EXPECT_TRUE(file("3.png") == file("0.png"));
  EXPECT_TRUE(viewed.json("view.crop", 2)["min"][0].is_number());
  EXPECT_FALSE(file("4.png") == file("0.png"));
  EXPECT_TRUE(file("5.png") == file("0.png"));
}

// However a handle is dragged, something is left.
TEST_F(WindowSpace, ACropNeverCutsAllAway) {
  const Viewed viewed = view({make_head(), "--view", "+z", "--fit", "box"},
                             "pace 0\nwait full\nclick tab.space\nclick space.crop@0.05,0.5\n"
                             "drag left handle.crop.x1 -300,0\nwait full\n"
                             "click space.crop.x0@0.95,0.5\nwait full\nprint view.crop\n");
  const auto crop = viewed.json("view.crop");
  const double lo = crop["min"][0].is_null() ? -HUGE_VAL : crop["min"][0].get<double>();
  EXPECT_LT(lo, crop["max"][0].get<double>());
}

TEST_F(WindowSpace, ClipPlanesAndTheirHandles) {
  const Viewed viewed =
      view({make_head(), "--view", "+z", "--fit", "box"},
           "pace 0\nwait full\nclick tab.space\nclick space.add-clip\n"
           // Seen from the front both handles lie at one place.
           "repeat 8\nkey shift+left\nend\nclick space.clip.0.remove\nwait full\n"
           "picture $/0.png\nkey ctrl+z\nwait full\nexpect view.clips == 1\n"
           "print view.clip\npicture $/1.png\n"
           "drag left handle.clip.0.normal 25,10\nwait full\nprint view.clip\n"
           "picture $/2.png\ndrag left handle.clip.0.offset 30,10\nwait full\n"
           "print view.clip\npicture $/3.png\nclick space.clip.0.flip\nwait full\n"
           "print view.clip\nclick space.clip.0.flip\nclick space.clip.0.remove\n"
           "wait full\nexpect view.clips == 0\npicture $/4.png\n");
  const auto plane = [&](std::size_t time) { return viewed.json("view.clip", time)[0]; };
  EXPECT_GT(distance(plane(1)["normal"], plane(0)["normal"]), 0.05);
  EXPECT_LT(distance(plane(2)["normal"], plane(1)["normal"]), 1e-12);
  EXPECT_NE(plane(2)["offset"], plane(1)["offset"]);
  EXPECT_EQ(plane(3)["offset"].get<double>(), -plane(2)["offset"].get<double>());
  EXPECT_FALSE(file("1.png") == file("0.png"));
  EXPECT_FALSE(file("2.png") == file("1.png"));
  EXPECT_FALSE(file("3.png") == file("2.png"));
  EXPECT_TRUE(file("4.png") == file("0.png"));
}

// A new plane faces the eye, so that both of its handles lie at one place. Fails if dragging them
// turns it, by whichever name.
TEST_F(WindowSpace, AClipPlaneThatFacesTheEyeIsMoved) {
  for (const char* const handle : {"handle.clip.0.offset", "handle.clip.0.normal"}) {
    const Viewed viewed = view({make_head(), "--view", "+z", "--fit", "box"},
                               "pace 0\nwait full\nclick tab.space\nclick space.add-clip\n"
                               "wait full\nprint view.clip\ndrag left " +
                                   std::string(handle) + " 5,20\nwait full\nprint view.clip\n");
    const auto plane = [&](std::size_t time) { return viewed.json("view.clip", time)[0]; };
    EXPECT_LT(distance(plane(1)["normal"], plane(0)["normal"]), 1e-12) << handle;
    EXPECT_NE(plane(1)["offset"], plane(0)["offset"]) << handle;
  }
}

TEST_F(WindowSpace, AsManyClipPlanesAsThereIsRoomFor) {
  const Viewed viewed = view({make_head()},
                             "pace 0\nwait full\nclick tab.space\nrepeat 20\n"
                             "click space.add-clip\nend\n"
                             "click space.crop@0.05,0.5\n"
                             "click space.plane@0.05,0.5\nwait idle\n"
                             "print view.clips\nprint message\n");
  EXPECT_GE(viewed.number("view.clips"), 1);
  EXPECT_EQ(viewed.text("message"), "");
}

// Fails if the two planes of a thick slice go their own ways.
TEST_F(WindowSpace, AThickSliceIsTwoPlanes) {
  const Viewed viewed =
      view({make_head(), "--view", "+z", "--fit", "box"},
           "pace 0\nwait full\npicture $/0.png\nclick tab.space\nclick space.add-slab\n"
           "wait full\nexpect view.clips == 2\nprint view.clip\npicture $/1.png\n"
           "click space.slab.0.offset@0.6,0.5\nwait full\nprint view.clip\npicture $/2.png\n"
           "click space.slab.0.thickness@0.5,0.5\nwait full\nprint view.clip\n"
           "key ctrl+z\nwait full\npicture $/3.png\n"
           "click space.slab.0.remove\nwait full\nexpect view.clips == 0\npicture $/4.png\n");
  const auto offset = [&](std::size_t time, std::size_t plane) {
    return viewed.json("view.clip", time).at(plane).at("offset").get<double>();
  };
  const auto thickness = [&](std::size_t time) { return -offset(time, 0) - offset(time, 1); };
  EXPECT_GT(thickness(0), 0);
  EXPECT_NE(offset(1, 0), offset(0, 0));
  EXPECT_NEAR(thickness(1), thickness(0), 1e-9);
  EXPECT_GT(thickness(2), 1.5 * thickness(1));
  EXPECT_NEAR(offset(2, 0) - offset(2, 1), offset(1, 0) - offset(1, 1), 1e-9);
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("2.png"));
  EXPECT_TRUE(file("2.png") == file("3.png"));
  EXPECT_TRUE(file("0.png") == file("4.png"));
}

TEST_F(WindowSpace, ValuePlane) {
  const Viewed viewed =
      view({make_head()},
           "pace 0\nwait full\npicture $/0.png\nclick tab.space\n"
           "expect view.has_plane == false\nclick space.plane@0.05,0.5\nwait full\n"
           "expect view.has_plane == true\nprint view.plane.offset\npicture $/1.png\n"
           "drag left handle.plane.offset 0,-20\nwait full\nprint view.plane.offset\n"
           "picture $/2.png\nclick space.plane.across\nclick space.plane.across/y\n"
           "wait full\npicture $/3.png\nclick space.plane.offset@0.2,0.5\nwait full\n"
           "print view.plane.offset\npicture $/4.png\n"
           "click space.plane.front@0.05,0.5\nwait full\npicture $/5.png\n"
           "click space.plane@0.05,0.5\nwait full\npicture $/6.png\n");
  EXPECT_NE(viewed.number("view.plane.offset", 1), viewed.number("view.plane.offset", 0));
  for (int i = 0; i < 6; ++i)
    EXPECT_FALSE(file(std::to_string(i) + ".png") == file(std::to_string(i + 1) + ".png")) << i;
  EXPECT_TRUE(file("6.png") == file("0.png"));
}

// Handles lie over what they belong to; where they are hidden, the mouse turns instead.
TEST_F(WindowSpace, WithoutHandlesTheMouseTurns) {
  const Viewed viewed = view({make_head(), "--view", "+z", "--fit", "box"},
                             "pace 0\nwait full\nclick tab.space\nclick space.crop@0.05,0.5\n"
                             "print camera.position\nclick space.handles@0.05,0.5\nwait 3 frames\n"
                             "drag left picture -40,0\nwait full\nprint camera.position\n"
                             "expect view.crop.max.0 == null\n");
  EXPECT_GT(distance(viewed.json("camera.position", 0), viewed.json("camera.position", 1)), 0.01);
}

// Fails if a function over value and gradient is not left by its button, or does not come back.
TEST_F(WindowHands, LooksOfTwoDimensionsAreLeftAndComeBack) {
  view({make_head(), "--tf2d",
        R"({"Regions": [{"Values": [400, 1400], "Gradients": [0, 1000000], "Opacity": 0.9}]})"},
       "wait idle\npicture $/both.png\nclick look.leave-2d\nwait idle\npicture $/value.png\n"
       "click look.undo\nwait idle\npicture $/again.png\nclick look.leave-2d\n");
  EXPECT_FALSE(file("both.png").empty());
  EXPECT_FALSE(file("both.png") == file("value.png"));
  EXPECT_TRUE(file("both.png") == file("again.png"));
}

}  // namespace look_window_test
}  // namespace ovoid::viewer_tests
