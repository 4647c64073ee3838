// SPDX-License-Identifier: Apache-2.0
// The tab "fit": fewer kernels in the background, beside the data, saved as the command saves them.
#include "screen.h"

namespace ovoid::viewer_tests {
namespace fit_window_test {

class WindowFit : public OnScreen {
 protected:
  // What a copied command says, run with its own name for the output.
  void run_command(const std::string& command) const {
    const Outcome outcome = cli_tests::run({"-c", "cd '" + (folder_ / "") + "' && PATH='" +
                                                      bin_folder() + "':\"$PATH\" && " + command},
                                           "/bin/sh");
    EXPECT_EQ(outcome.exit_code, 0) << command << '\n' << outcome.err;
  }
  // Saves under a name without a folder's, into which the script's "$/" would not lead.
  static std::string save_as(const std::string& path) {
    return "click fit.path\nkey ctrl+a\ntype " + path + "\nclick fit.save\n";
  }
};

TEST_F(WindowFit, OfAScanIsTheFileOfTheCommand) {
  const Viewed viewed =
      view({make("head", "head.nrrd", {"--size", "24"})},
           "pace 0\nwait idle\npicture $/data.png\nclick tab.fit\nexpect fit.has_result == false\n"
           "drag left fit.psnr -150,0\nclick fit.start\nwait idle\nexpect fit.error == \"\"\n"
           "expect fit.has_result == true\nexpect fit.is_compared == true\n"
           "expect compare.mode == 2\nexpect fit.kernels > 10\nprint fit.psnr\n"
           "print compare.psnr\n" +
               save_as("$/fit.h5") +
               "click fit.copy\nprint clipboard\nprint fit.bytes\nclick fit.show\n"
               "click \"fit.show/the data alone\"\nwait idle\n"
               "picture $/again.png\n");
  EXPECT_LT(viewed.number("compare.psnr"), 90);  // the pictures of two fields
  const std::string saved = file("fit.h5");
  EXPECT_EQ(static_cast<double>(saved.size()), viewed.number("fit.bytes"));
  std::string command = viewed.text("clipboard");
  EXPECT_NE(command.find("ovoid fit"), std::string::npos) << command;
  std::filesystem::remove(folder_ / "fit.h5");
  run_command(command);
  EXPECT_TRUE(file("fit.h5") == saved) << command;
  // What is saved while both are shown is the data's picture.
  EXPECT_TRUE(file("again.png") == file("data.png"));
}

TEST_F(WindowFit, OfAMeshIsTheFileOfTheCommand) {
  const Viewed viewed =
      view({make("fin", "fin.vtu", {"--count", "600"}), "--array", "density"},
           "pace 0\nwait idle\nclick tab.fit\nclick fit.goal\n"
           "click \"fit.goal/number of kernels\"\ndrag left fit.kernels -245,0\n"
           "click fit.start\nwait idle\nexpect fit.error == \"\"\nexpect fit.kernels < 500\n"
           "screenshot $/within.png\nclick fit.surface@0.05,0.5\nwait idle\n"
           "screenshot $/alone.png\nwait 2 frames\n" +
               save_as("$/fit.ply") +
               "click fit.copy\nprint clipboard\nprint fit.kernels\nclick fit.open\nwait idle\n"
               "print kernels\nexpect fit.has_result == false\n");
  EXPECT_EQ(viewed.text("kernels"), viewed.text("fit.kernels"));
  const std::string saved = file("fit.ply");
  ASSERT_GT(saved.size(), 500U);
  std::filesystem::remove(folder_ / "fit.ply");
  run_command(viewed.text("clipboard"));
  EXPECT_TRUE(file("fit.ply") == saved) << viewed.text("clipboard");
  EXPECT_FALSE(file("within.png") == file("alone.png"));
}

// The array that is shown is what is fitted, and the fit waits until it is shown again.
TEST_F(WindowFit, IsOfTheArrayThatWasShown) {
  view({make("fin", "fin.vtu", {"--count", "600"})},
       "pace 0\nwait idle\nclick tab.data\nclick data.array.pressure\nwait idle\n"
       "click tab.fit\nclick fit.goal\nclick \"fit.goal/number of kernels\"\n"
       "drag left fit.kernels -245,0\nclick fit.start\nwait idle\n"
       "expect fit.is_of_shown == true\n"
       "click fit.copy\nexpect clipboard contains \"--array pressure\"\n"
       "click tab.data\nclick data.array.density\nwait idle\nexpect fit.is_of_shown == false\n"
       "expect fit.is_compared == false\nclick data.array.pressure\nwait idle\n"
       "expect fit.is_of_shown == true\nexpect fit.is_compared == true\n");
}

TEST_F(WindowFit, IsCancelledAndDrawnMeanwhile) {
  view({make("head", "head.nrrd", {"--size", "96"}), "--preset", "ct-bone"},
       "pace 0\nwait idle\nclick tab.fit\nclick fit.start\nexpect fit.is_running == true\n"
       "drag left picture 40,10\nwait full\nexpect fit.is_running == true\n"
       "click fit.cancel\nwait 2 frames\nexpect fit.is_running == false\nwait idle\n"
       "expect fit.has_result == false\nexpect fit.error == \"\"\n"
       // Again, and closed meanwhile.
       "click fit.start\nwait 300 ms\nexpect fit.is_running == true\nclose\n");
}

TEST_F(WindowFit, EndsWhereOtherDataAreOpened) {
  const std::string other = make("head", "other.nrrd", {"--size", "16"});
  view({make("head", "head.nrrd", {"--size", "96"})},
       "pace 0\nwait idle\nclick tab.fit\nclick fit.start\nexpect fit.is_running == true\n"
       "drop " +
           other +
           "\nwait idle\nexpect kernels == 4096\nexpect fit.is_running == false\n"
           "expect fit.has_result == false\n");
}

TEST_F(WindowFit, SaysWhyThereIsNone) {
  view({make("fin", "fin.vtu", {"--count", "200"}), "--array", "pressure"},
       "pace 0\nwait idle\nclick tab.fit\ndrag left fit.psnr 600,0\nclick fit.start\n"
       "wait idle\nexpect fit.has_result == false\nexpect fit.is_compared == false\n"
       "expect fit.error contains \"kernels reach\"\n");
}

// What is read is not written over, and the ending says what it is.
TEST_F(WindowFit, IsNotSavedOverItsDataOrUnderAnotherEnding) {
  const std::string blobs = make("blobs", "blobs.ply", {"--count", "200"});
  const std::string before = file("blobs.ply");
  view({blobs},
       "pace 0\nwait idle\nclick tab.fit\nclick fit.goal\n"
       "click \"fit.goal/number of kernels\"\ndrag left fit.kernels -245,0\n"
       "click fit.start\nwait idle\n"
       "expect fit.has_result == true\n" +
           save_as("$/blobs.ply") + "expect message contains blobs.ply\n" + save_as("$/fit.h5") +
           "expect message contains .ply\n");
  EXPECT_TRUE(file("blobs.ply") == before);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "fit.h5"));
}

}  // namespace fit_window_test
}  // namespace ovoid::viewer_tests
