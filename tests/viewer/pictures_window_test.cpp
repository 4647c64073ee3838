// SPDX-License-Identifier: Apache-2.0
// The picture in the window is the picture that `ovoid render` draws, byte for byte: by the state
// that was saved, and by the command that was copied.
#include "screen.h"

namespace ovoid::viewer_tests {
namespace pictures_window_test {

// How the data come to look before the picture is saved.
struct Situation {
  const char* name;
  const char* data;  // make_data() knows them
  Words flags;
  const char* script;
};

void PrintTo(const Situation& situation, std::ostream* out) { *out << situation.name; }

class WindowPictures : public OnScreen, public ::testing::WithParamInterface<Situation> {
 protected:
  Words make_data(const std::string& name) {
    if (name == "head") return {make_head()};
    if (name == "fin") return {make("fin", "fin.vtu", {"--count", "2000"})};
    if (name == "galaxy") return {make("galaxy", "galaxy.csv", {"--count", "2000"})};
    if (name == "blobs") return {make("blobs", "blobs.ply", {"--count", "200"})};
    if (name == "labels") {
      std::string samples;
      for (int i = 0; i < 24 * 24 * 24; ++i)
        samples.push_back(static_cast<char>(i / 6 % 4 == 0 ? i / 1728 % 4 : 0));
      write_file(folder_ / "labels_24x24x24_uint8.raw", samples);
      return {folder_ / "labels_24x24x24_uint8.raw"};
    }
    const std::string whole = make("tornado", "all.h5", {"--size", "24", "--steps", "4"});
    if (name == "tornado") return {whole};
    Words steps;  // a file for each
    for (int i = 0; i < 4; ++i) {
      steps.push_back(folder_ / "step_" + std::to_string(i) + ".nrrd");
      cli_tests::expect_success(
          {"convert", whole, "--step", std::to_string(i), "-o", steps.back()});
    }
    return steps;
  }
};

TEST_P(WindowPictures, AreThoseOfTheStateAndOfTheCommand) {
  const Situation& situation = GetParam();
  Words words = make_data(situation.data);
  words.insert(words.end(), situation.flags.begin(), situation.flags.end());
  const Viewed viewed =
      view(words, std::string("pace 0\nwait idle\npicture $/first.png\n") + situation.script +
                      "wait 3 frames\nwait full\nwait idle\n"
                      "key ctrl+c\nexpect clipboard contains \"ovoid render\"\n"
                      "picture $/window.png\nstate $/state.json\n"
                      "print clipboard\n");
  const std::string picture = file("window.png");
  ASSERT_GT(picture.size(), 500U);
  if (*situation.script != '\0') {
    EXPECT_FALSE(picture == file("first.png")) << "the script changed nothing";
  }
  const Outcome by_state = cli_tests::run({"render", "--state", folder_ / "state.json", "-o",
                                           folder_ / "state.png", "--backend", "cpu"});
  EXPECT_EQ(by_state.exit_code, 0) << by_state.err;
  EXPECT_TRUE(file("state.png") == picture) << file("state.json");
  const std::string command = viewed.text("clipboard");
  const Outcome by_command = cli_tests::run(
      {"-c", "cd '" + (folder_ / "") + "' && PATH='" + bin_folder() + "':\"$PATH\" && " + command},
      "/bin/sh");
  EXPECT_EQ(by_command.exit_code, 0) << by_command.err;
  EXPECT_TRUE(file("picture.png") == picture) << command;
}

const Situation kSituations[] = {
    {"Perspective", "head", {}, ""},
    {"Turned", "head", {}, "drag left picture 60,-35\nwheel 3 picture@0.3,0.6\n"},
    {"Parallel", "head", {"--no-panel"}, "key p\nkey shift+left\n"},
    {"WithoutMarks", "head", {}, "click tab.space\nclick space.axes\nclick space.colorbar\n"},
    {"AllMarks", "head", {}, "click tab.space\nclick space.box\nclick space.scale-bar\n"},
    {"CropByHandle",
     "head",
     {},
     "click tab.space\nclick space.crop\ndrag left handle.crop.x1 -40,8\n"
     "drag left handle.crop.y0 20,-30\n"},
    {"CropBySlider",
     "head",
     {},
     "click tab.space\nclick space.crop\nclick space.crop.z1@0.6,0.5\n"},
    {"Clip",
     "head",
     {},
     "click tab.space\nclick space.add-clip\nrepeat 8\nkey shift+left\nend\n"
     "drag left handle.clip.0.normal 15,20\n"},
    {"ClipAndCropOfTheFlags",
     "head",
     {"--clip", "1,1,0,4", "--crop", "4:44,0:40,:", "--no-panel"},
     "drag left picture 9,9\n"},
    {"LogScale", "galaxy", {"--array", "mass"}, "click look.scale\nclick look.scale/log\n"},
    {"SymlogScale", "head", {}, "click look.scale\nclick look.scale/symlog\n"},
    {"Isosurface",
     "head",
     {},
     "click look.mode\nclick look.mode/isosurface\nclick look.isovalue@0.4,0.5\n"},
    {"Isosurfaces",
     "head",
     {},
     "click look.mode\nclick look.mode/isosurface\nclick look.iso.add\n"
     "click look.iso.0.opacity@0.3,0.5\nclick look.iso.1.own@0.05,0.5\n"
     "click look.iso.1.value@0.7,0.5\n"},
    {"ThickSlice",
     "head",
     {"--mode", "minimum"},
     "click tab.space\nclick space.add-slab\nclick space.slab.0.thickness@0.3,0.5\n"},
    {"ThickSliceOfTheFlags",
     "head",
     {"--mode", "mean", "--thick-slice", "0,1,0,0,0.4"},
     "click tab.space\nclick space.slab.0.offset@0.55,0.5\n"},
    {"Maximum", "head", {}, "click look.mode\nclick look.mode/maximum\n"},
    {"Mean", "head", {}, "click look.mode\nclick look.mode/mean\n"},
    {"Xray", "head", {}, "click look.mode\nclick look.mode/x-ray\n"},
    {"XrayWithARange", "head", {"--mode", "xray", "--range", "0,60"}, "drag left picture 30,5\n"},
    {"ColorMap", "head", {}, "click look.map\nclick look.map/viridis\n"},
    {"Preset", "head", {}, "click look.preset\nclick look.preset/ct-bone\n"},
    {"OpacityPoint", "head", {}, "drag left look.opacity.1 8,-20\n"},
    {"ColorPoint", "head", {}, "drag left look.colors.1 9,0\n"},
    {"Range", "head", {}, "drag left look.range.lo 25,0\n"},
    {"UnitDistance", "head", {}, "drag left look.unit-distance 60,0\n"},
    {"LightFromADirection",
     "head",
     {},
     "click look.headlight@0.05,0.5\ndrag left look.light@0.5,0.5 60,0\n"},
    {"WithoutLight", "head", {}, "click look.shade@0.05,0.5\n"},
    {"Material", "head", {}, "click look.specular@0.9,0.5\n"},
    {"GradientOpacity", "head", {}, "click look.gradient@0.05,0.5\n"},
    {"ValuePlane",
     "head",
     {},
     "click tab.space\nclick space.plane@0.1,0.5\ndrag left handle.plane.offset 4,18\n"},
    {"ValuePlaneAndWhatIsBeforeIt",
     "head",
     {"--value-plane", "1,1,0,0.4"},
     "click tab.space\nclick space.plane.front@0.05,0.5\n"},
    {"Background", "head", {"--background", "1,0.9,0.8", "--no-panel"}, ""},
    {"SamplingDistance",
     "head",
     {},
     "click tab.quality\ndrag left quality.sampling-distance 40,0\n"},
    {"Quality", "head", {}, "click tab.quality\nclick quality\nclick quality/fine\n"},
    {"PostConvolution",
     "head",
     {},
     "click tab.quality\nclick quality.post-convolution\nclick quality.post-convolution/cubic\n"},
    {"PreIntegrated",
     "head",
     {},
     "click tab.quality\nclick quality.classification\n"
     "click quality.classification/pre-integrated\n"},
    {"Labels", "labels", {"--no-panel"}, "drag left picture 30,20\n"},
    {"Mesh", "fin", {}, "drag left picture 30,20\n"},
    {"MeshAnotherArray", "fin", {}, "click tab.data\nclick data.array.pressure\nwait 2 frames\n"},
    {"MeshAnotherColor", "fin", {}, "click tab.data\nclick data.color.pressure\nwait 2 frames\n"},
    {"Particles", "galaxy", {"--no-panel"}, "wheel 2 picture\n"},
    {"Density", "galaxy", {"--quantity", "density", "--no-panel"}, "wheel 2 picture\n"},
    {"Kernels", "blobs", {"--no-panel"}, "drag left picture 30,20\n"},
    {"AStep", "tornado", {"--no-panel"}, "key right\nkey right\n"},
    {"AStepOfTheFlags", "tornado", {"--step", "2", "--no-panel"}, "drag left picture 30,20\n"},
    {"AStepOfSeveralFiles", "steps", {"--no-panel"}, "key right\n"},
    {"BetweenSteps",
     "tornado",
     {},
     "click tab.time\nclick time.interpolate@0.05,0.5\nclick time.now@0.4,0.5\n"},
    {"BetweenStepsOfSeveralFiles",
     "steps",
     {},
     "click tab.time\nclick time.interpolate@0.05,0.5\nclick time.now@0.4,0.5\n"},
    {"MotionBlur",
     "tornado",
     {"--mode", "isosurface", "--iso", "0.4"},
     "click tab.time\nclick time.last\nclick time.blur@0.05,0.5\n"},
};

INSTANTIATE_TEST_SUITE_P(Window, WindowPictures, ::testing::ValuesIn(kSituations),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

}  // namespace pictures_window_test
}  // namespace ovoid::viewer_tests
