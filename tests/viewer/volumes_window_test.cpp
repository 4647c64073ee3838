// SPDX-License-Identifier: Apache-2.0
// Several volumes in the tab "scene": beside the data, and channels of one file. Fails if the
// command or the state draws another picture than the window, if what is hidden or removed is still
// seen, or if the data are lost on the way.
#include "screen.h"

namespace ovoid::viewer_tests {
namespace volumes_window_test {

class WindowVolumes : public OnScreen {
 protected:
  std::string make_scan() { return make("head", "scan.nrrd", {"--size", "24"}); }
  std::string make_uptake() { return make("gaussians", "up.nrrd", {"--size", "20"}); }
  // Bytes: a ball for each component, beside each other.
  std::string make_stains(int count) const {
    constexpr int kSide = 14;
    std::string bytes = "NRRD0005\ntype: uint8\ndimension: 4\nsizes: " + std::to_string(count) +
                        " 14 14 14\nkinds: vector domain domain domain\nencoding: raw\n\n";
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
          for (int c = 0; c < count; ++c) {
            const int dx = x - 3 - 3 * c;
            const int square = dx * dx + (y - 6) * (y - 6) + (z - 6) * (z - 6);
            bytes += static_cast<char>(square < 12 ? 240 - square : (x + y) % 3);
          }
    write_file(folder_ / "stains.nrrd", bytes);
    return folder_ / "stains.nrrd";
  }
  static std::string add(const std::string& path) {
    return "click scene.path\nkey ctrl+a\ntype " + path + "\nclick scene.add\nwait idle\n";
  }
  static constexpr const char* kBegin = "pace 0\nwait idle\nclick tab.scene\n";
  // The window's picture of flags alone.
  std::string rendered(const Words& words) const {
    Words all = {"render"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(),
               {"--size", "340x240", "--backend", "cpu", "--axes", "-o", folder_ / "rendered.png"});
    cli_tests::expect_success(all);
    return file("rendered.png");
  }
};

TEST_F(WindowVolumes, AVolumeIsThatOfTheCommandAndTheState) {
  const std::string scan = make_scan();
  make_uptake();
  const Viewed viewed =
      view({scan, "--opacity", "-300:0,0:0.01,1000:0.2"},
           std::string(kBegin) + "picture $/0.png\n" + add("$/up.nrrd") +
               "expect scene.several.volumes == 1\nexpect scene.several.are_seen == true\n"
               "picture $/1.png\nclick scene.volume.0.map\nclick scene.volume.0.map/viridis\n"
               "click scene.volume.0.opacity@0.9,0.5\nclick scene.volume.0.curve@0.4,0.4\n"
               "click scene.mixing\nclick scene.mixing/added\nwait idle\n" +
               kSave);
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("window.png"));
  expect_same(viewed, "window.png", "s.json");
  EXPECT_NE(viewed.text("clipboard").find("--mixing added"), std::string::npos);
  // The state and what it names can be moved together.
  EXPECT_EQ(nlohmann::json::parse(file("s.json"))["flags"]["over"], nlohmann::json({"up.nrrd"}));
  view({"--state", folder_ / "s.json"},
       std::string(kBegin) + "expect scene.several.volumes == 1\npicture $/again.png\n");
  EXPECT_TRUE(file("again.png") == file("window.png"));
}

TEST_F(WindowVolumes, BeginAsFlagsHaveThem) {
  const std::string scan = make_scan();
  const std::string up = make_uptake();
  write_file(folder_ / "m.txt", "0.9 0.1 0 0.15\n-0.1 0.9 0 0\n0 0 0.9 0\n0 0 0 1\n");
  const Words words = {
      scan, "--over",          up,        "--over-transform", folder_ / "m.txt", "--over",
      up,   "--over-colormap", "viridis", "--preset",         "ct-bone"};
  const Viewed viewed = view(words, std::string(kBegin) + "picture $/0.png\n");
  Words with_bar = words;
  with_bar.push_back("--colorbar");
  EXPECT_TRUE(file("0.png") == rendered(with_bar));
  // Light is the whole picture's, and a transform stays with its volume.
  const Viewed changed =
      view(words,
           "pace 0\nwait idle\nclick look.ambient@0.8,0.5\nclick tab.scene\n"
           "click scene.volume.1.show@0.05,0.5\nwait idle\nexpect scene.several.volumes == 2\n" +
               std::string(kSave));
  EXPECT_NE(changed.text("clipboard").find("m.txt"), std::string::npos);
  expect_same(changed, "window.png", "s.json");
}

TEST_F(WindowVolumes, AreHiddenTakenBackRemovedAndAtMostThree) {
  const std::string scan = make_scan();
  make_uptake();
  const std::string three = add("$/up.nrrd") + add("$/up.nrrd");
  view({scan}, std::string(kBegin) + "picture $/0.png\n" + add("$/up.nrrd") +
                   "picture $/1.png\nclick scene.volume.0.show@0.05,0.5\nwait idle\n"
                   "picture $/hidden.png\nclick scene.volume.0.show@0.05,0.5\nwait idle\n"
                   "picture $/shown.png\nmove picture@0.1,0.9\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z\n"
                   "wait idle\nexpect scene.several.volumes == 0\npicture $/undone.png\n"
                   "key ctrl+y\nwait idle\npicture $/redone.png\n" +
                   three + add("$/up.nrrd") +
                   "expect scene.several.volumes == 3\nexpect scene.error contains \"at most 3\"\n"
                   "click scene.volume.2.remove\nclick scene.volume.1.remove\n"
                   "click scene.volume.0.remove\nwait idle\npicture $/removed.png\n");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  for (const char* const name : {"hidden.png", "undone.png", "removed.png"})
    EXPECT_TRUE(file(name) == file("0.png")) << name;
  for (const char* const name : {"shown.png", "redone.png"})
    EXPECT_TRUE(file(name) == file("1.png")) << name;
}

TEST_F(WindowVolumes, MaximaOfSeveralAddAndOtherModesShowNone) {
  const std::string scan = make_scan();
  const std::string up = make_uptake();
  const Viewed viewed = view({scan, "--over", up},
                             "pace 0\nwait idle\nclick look.mode\nclick look.mode/maximum\n"
                             "wait idle\nexpect scene.several.are_seen == true\n" +
                                 std::string(kSave));
  expect_same(viewed, "window.png", "s.json");
  const Viewed mean = view({scan, "--over", up},
                           "pace 0\nwait idle\nclick look.mode\nclick look.mode/mean\n"
                           "wait idle\nexpect scene.several.are_seen == false\n" +
                               std::string(kSave));
  expect_same(mean, "window.png", "s.json");
}

TEST_F(WindowVolumes, ADroppedVolumeIsAddedWhileTheTabIsOpen) {
  const std::string scan = make_scan();
  make_uptake();
  view({scan}, std::string(kBegin) +
                   "drop $/up.nrrd\nwait idle\nexpect scene.several.volumes == 1\n"
                   "expect array == head\nclick tab.look\ndrop $/up.nrrd\nwait 20 frames\n"
                   "wait idle\nexpect scene.several.volumes == 0\nexpect array != head\n");
}

// Whole numbers that do not look like names can be said to be.
TEST_F(WindowVolumes, AVolumeBecomesLabels) {
  const std::string scan = make_scan();
  make("head-labels", "map.nrrd", {"--size", "24", "--type", "uint8"});
  std::string bytes = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 12 12 12\nencoding: raw\n\n";
  for (int i = 0; i < 12 * 12 * 12; ++i) bytes += static_cast<char>(i % 12 < 6 ? 40 : i % 97);
  write_file(folder_ / "numbers.nrrd", bytes);
  view({scan}, std::string(kBegin) + add("$/numbers.nrrd") +
                   "expect scene.several.volumes == 1\nclick scene.volume.0.labels\nwait idle\n"
                   "expect scene.labels.file contains numbers.nrrd\n"
                   "expect scene.several.volume.0.is_hidden == true\n");
}

TEST_F(WindowVolumes, ComponentsAreChannelsAndComeBack) {
  const std::string stains = make_stains(2);
  const Viewed viewed =
      view({stains},
           std::string(kBegin) +
               "picture $/0.png\nclick scene.channels\n"
               "click \"scene.channels/as channels\"\nwait 20 frames\nwait idle\n"
               "expect scene.several.channels == 2\n"
               "expect scene.several.channels_are_seen == true\npicture $/1.png\n"
               "click scene.channel.1.color\n"
               "click scene.channel.1.color/picker@0.1,0.2\nkey escape\n"
               "drag left scene.channel.0.hi -40,0\nwait idle\n" +
               kSave +
               "click scene.channel.0.show@0.05,0.5\nwait idle\npicture $/second.png\nkey ctrl+c\n"
               "print clipboard\nstate $/second.json\nclick scene.channels\n"
               "click \"scene.channels/by itself\"\nwait 20 frames\nwait idle\n"
               "expect scene.several.channels == 0\npicture $/back.png\n");
  EXPECT_FALSE(file("0.png") == file("1.png"));
  EXPECT_FALSE(file("1.png") == file("window.png"));
  EXPECT_FALSE(file("second.png") == file("window.png"));
  EXPECT_TRUE(file("back.png") == file("0.png"));
  expect_same(viewed, "window.png", "s.json");
  cli_tests::expect_success({"render", "--state", folder_ / "second.json", "-o",
                             folder_ / "second-state.png", "--backend", "cpu"});
  EXPECT_TRUE(file("second-state.png") == file("second.png"));
  view({"--state", folder_ / "s.json"}, std::string(kBegin) +
                                            "expect scene.several.channels == 2\n"
                                            "picture $/again.png\n");
  EXPECT_TRUE(file("again.png") == file("window.png"));
}

TEST_F(WindowVolumes, ChannelsHaveLightAndModesOfThePicture) {
  const std::string stains = make_stains(3);
  const Words words = {stains, "--channels", "all", "--channel-color", "red"};
  const Viewed lit = view(words,
                          "pace 0\nwait idle\npicture $/0.png\nclick look.ambient@0.9,0.5\n"
                          "click look.shadows@0.5,0.5\nwait idle\n" +
                              std::string(kSave));
  EXPECT_TRUE(file("0.png") == rendered(words));
  EXPECT_FALSE(file("0.png") == file("window.png"));
  expect_same(lit, "window.png", "s.json");
  for (const char* const mode : {"maximum", "x-ray"}) {
    const Viewed viewed = view(words, "pace 0\nwait idle\nclick look.mode\nclick look.mode/" +
                                          std::string(mode) + "\nwait idle\n" + kSave);
    expect_same(viewed, "window.png", "s.json");
  }
}

// Two arrays with colours of their own, as a microscope's file has them.
TEST_F(WindowVolumes, FilesBeginWithTheColoursThatTheyName) {
  std::filesystem::create_directories(folder_ / "o.ome.zarr/0");
  write_file(folder_ / "o.ome.zarr/.zgroup", R"({"zarr_format": 2})");
  write_file(folder_ / "o.ome.zarr/.zattrs",
             R"({"multiscales": [{"version": "0.4", "axes": [{"name": "c", "type": "channel"},)"
             R"({"name": "z", "type": "space"}, {"name": "y", "type": "space"},)"
             R"({"name": "x", "type": "space"}], "datasets": [{"path": "0",)"
             R"("coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1, 1]}]}]}],)"
             R"("omero": {"channels": [{"label": "DAPI", "color": "0000FF"},)"
             R"({"label": "GFP", "color": "00FF00"}]}})");
  write_file(folder_ / "o.ome.zarr/0/.zarray",
             R"({"zarr_format": 2, "shape": [2, 8, 8, 8], "chunks": [2, 8, 8, 8], "dtype": "|u1",)"
             R"("compressor": null, "fill_value": 0, "order": "C", "filters": null})");
  std::string bytes;
  for (int i = 0; i < 2 * 8 * 8 * 8; ++i)
    bytes += static_cast<char>((i % 8 < 4) == (i < 512) ? 200 - i % 23 : i % 5);
  write_file(folder_ / "o.ome.zarr/0/0.0.0.0", bytes);
  const Viewed viewed = view({folder_ / "o.ome.zarr"},
                             std::string(kBegin) +
                                 "expect scene.several.channels == 2\n"
                                 "expect scene.several.channel.1.name == GFP\n"
                                 "drag left scene.channel.1.hi -30,0\nwait idle\n" +
                                 kSave +
                                 "click scene.channels\nclick \"scene.channels/by itself\"\n"
                                 "wait 20 frames\nwait idle\nexpect scene.several.channels == 0\n");
  expect_same(viewed, "window.png", "s.json");
}

TEST_F(WindowVolumes, RedGreenAndBlueAreColours) {
  const std::string stains = make_stains(3);
  const Viewed viewed = view({stains}, std::string(kBegin) +
                                           "picture $/0.png\nclick scene.channels\n"
                                           "click \"scene.channels/as red, green, blue\"\n"
                                           "wait 20 frames\nwait idle\nclick tab.look\n"
                                           "click look.opacity@0.5,0.3\nwait idle\n" +
                                           kSave);
  EXPECT_FALSE(file("0.png") == file("window.png"));
  EXPECT_NE(viewed.text("clipboard").find("--channels rgb"), std::string::npos);
  expect_same(viewed, "window.png", "s.json");
  // In a mode without them what is beside is mixed as ever.
  make_uptake();
  const Viewed maximum = view({stains, "--channels", "rgb"},
                              std::string(kBegin) + add("$/up.nrrd") +
                                  "click tab.look\nclick look.mode\nclick look.mode/maximum\n"
                                  "wait idle\nexpect scene.several.are_seen == true\n" +
                                  kSave);
  expect_same(maximum, "window.png", "s.json");
}

}  // namespace volumes_window_test
}  // namespace ovoid::viewer_tests
