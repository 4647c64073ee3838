// SPDX-License-Identifier: Apache-2.0
// The tab "solid": a control mesh as a solid, whose vertices are dragged, and the command for it.
#include "screen.h"

namespace ovoid::viewer_tests {
namespace solid_window_test {

class WindowSolid : public OnScreen {
 protected:
  std::string make_control() { return make("solid", "star.vtu", {"--levels", "0"}); }
  static constexpr const char* kShow =
      "pace 0\nwait idle\nclick tab.solid\nclick solid.show@0.05,0.5\nwait idle\n";

  // The copied command draws the picture, byte for byte.
  void expect_command_draws(const std::string& command, const std::string& picture) const {
    const Outcome outcome = cli_tests::run({"-c", "cd '" + (folder_ / "") + "' && PATH='" +
                                                      bin_folder() + "':\"$PATH\" && " + command},
                                           "/bin/sh");
    EXPECT_EQ(outcome.exit_code, 0) << command << '\n' << outcome.err;
    EXPECT_TRUE(file("picture.png") == file(picture)) << command;
  }
};

TEST_F(WindowSolid, IsThePictureOfTheCommand) {
  const Viewed viewed =
      view({make_control()}, std::string(kShow) +
                                 "expect solid.levels == 1\nexpect solid.vertices == 258\n"
                                 "expect solid.is_saved == true\nexpect kernels == 1405\n"
                                 "picture $/solid.png\nkey ctrl+c\nprint clipboard\n");
  expect_command_draws(viewed.text("clipboard"), "solid.png");
}

// A drag moves the vertex in the plane of the picture, the picture follows, and undo is back at
// the file. Until it is saved there is no command, and then it is that of what was saved.
TEST_F(WindowSolid, AVertexIsDraggedSavedAndTakenBack) {
  const Viewed viewed =
      view({make_control(), "--view", "top"},
           std::string(kShow) +
               "picture $/before.png\nclick handle.vertex.255\nwait 2 frames\n"
               "expect solid.vertex == 255\nprint solid.place\nprint camera\n"
               "wait 500 ms\ndrag left handle.vertex.255 6,4\nwait idle\n"
               "print solid.place\nexpect solid.refusal == \"\"\npicture $/moved.png\n"
               "expect solid.is_saved == false\nkey ctrl+c\nprint clipboard\n"
               "click solid.control.path\nkey ctrl+a\ntype $/moved.vtu\n"
               "click solid.control.save\nexpect solid.is_saved == true\n"
               "key ctrl+c\nprint clipboard\n"
               "click solid.kernels.path\nkey ctrl+a\ntype $/moved.ply\n"
               "click solid.kernels.save\nmove picture\nkey ctrl+z\nwait idle\n"
               "print solid.place\nexpect solid.is_saved == true\npicture $/back.png\n"
               "key ctrl+y\nwait idle\nprint solid.place\npicture $/again.png\n");
  const auto place = [&](std::size_t time) { return viewed.json("solid.place", time); };
  EXPECT_GT(distance(place(0), place(1)), 1e-3);
  // Parallel to the picture, which is seen from above.
  EXPECT_NEAR(place(0)[2].get<double>(), place(1)[2].get<double>(), 1e-6);
  EXPECT_EQ(place(2), place(0));
  EXPECT_EQ(place(3), place(1));
  EXPECT_FALSE(file("before.png") == file("moved.png"));
  EXPECT_TRUE(file("before.png") == file("back.png"));
  EXPECT_TRUE(file("moved.png") == file("again.png"));
  EXPECT_EQ(viewed.text("clipboard", 0).substr(0, 2), "# ") << viewed.text("clipboard", 0);
  const std::string command = viewed.text("clipboard", 1);
  expect_command_draws(command, "moved.png");
  EXPECT_NE(command.find("moved.vtu"), std::string::npos) << command;
  EXPECT_TRUE(file("solid.ply") == file("moved.ply"));
}

TEST_F(WindowSolid, NumbersOfAVertex) {
  const Viewed viewed =
      view({make_control()},
           std::string(kShow) +
               "picture $/before.png\nclick handle.vertex.255\nwait 2 frames\nprint solid.density\n"
               "wait 500 ms\nclick solid.density double\nkey ctrl+a\ntype 0.875\nkey enter\n"
               "wait idle\nexpect solid.density == 0.875\npicture $/after.png\n"
               "click solid.basis\nclick solid.basis/two\nwait idle\nexpect kernels == 2810\n"
               "key ctrl+z\nkey ctrl+z\nwait idle\nprint solid.density\npicture $/back.png\n");
  EXPECT_EQ(viewed.text("solid.density", 0), viewed.text("solid.density", 1));
  EXPECT_FALSE(file("before.png") == file("after.png"));
  EXPECT_TRUE(file("before.png") == file("back.png"));
}

// The command of a mesh names a file that holds it: not one that another mesh was written to since,
// nor one whose densities are rounded.
TEST_F(WindowSolid, TheCommandNamesAFileThatHoldsTheMesh) {
  const auto type_density = [](const std::string& density) {
    return "wait 500 ms\nclick solid.density double\nkey ctrl+a\ntype " + density +
           "\nkey enter\nwait idle\n";
  };
  const std::string save = "click solid.control.save\nwait idle\nexpect solid.is_saved == true\n";
  const Viewed viewed =
      view({make_control()}, std::string(kShow) +
                                 "click handle.vertex.255\nwait 2 frames\n"
                                 "click solid.control.path\nkey ctrl+a\ntype $/saved.vtu\n" +
                                 type_density("0.3") + save + type_density("0.7") + save +
                                 "picture $/solid.png\nkey ctrl+c\nprint clipboard\n"
                                 "move picture@0.1,0.9\nkey ctrl+z\nwait idle\n"
                                 "print solid.density\nexpect solid.is_saved == false\n");
  expect_command_draws(viewed.text("clipboard"), "solid.png");
}

// A cell inside out is no solid.
TEST_F(WindowSolid, AVertexStaysWhereACellWouldTurnInsideOut) {
  const Viewed viewed =
      view({make_control()}, std::string(kShow) +
                                 "click handle.vertex.255\nwait 500 ms\n"
                                 "drag left handle.vertex.255 120,0\nwait idle\n"
                                 "print solid.refusal\nprint solid.place\n"
                                 "key ctrl+c\nexpect clipboard contains \"not saved\"\n");
  EXPECT_NE(viewed.text("solid.refusal").find("inside out"), std::string::npos)
      << viewed.text("solid.refusal");
}

// The mesh again, by the box and by undo; states know no solid.
TEST_F(WindowSolid, ShowsTheMeshAgain) {
  view({make_control()},
       "pace 0\nwait idle\nprint kernels\npicture $/mesh.png\nclick tab.solid\n"
       "click solid.show@0.05,0.5\nwait idle\nexpect kernels == 1405\nkey ctrl+s\n"
       "expect message contains \"state\"\nkey ctrl+z\nwait idle\n"
       "expect kernels == 258\npicture $/undone.png\nkey ctrl+y\nwait idle\n"
       "expect kernels == 1405\nclick solid.show@0.05,0.5\nwait idle\n"
       "expect kernels == 258\npicture $/off.png\n");
  EXPECT_TRUE(file("undone.png") == file("mesh.png"));
  EXPECT_TRUE(file("off.png") == file("mesh.png"));
  EXPECT_FALSE(std::filesystem::exists("state.json"));
}

// What is no mesh of hexahedra has no such tab.
TEST_F(WindowSolid, IsForHexahedraAlone) {
  const Viewed viewed = replay({make("fin", "fin.vtu", {"--count", "500"})},
                               "pace 0\nwait idle\nclick tab.time\nclick tab.solid\n");
  EXPECT_EQ(viewed.outcome.exit_code, 1);
  EXPECT_NE(viewed.outcome.err.find("there is no 'tab.solid'"), std::string::npos)
      << viewed.outcome.err;
}

}  // namespace solid_window_test
}  // namespace ovoid::viewer_tests
