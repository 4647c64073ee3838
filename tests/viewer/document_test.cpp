// SPDX-License-Identifier: Apache-2.0
// What is open and how it is shown, filled by the loader and without a window; and the command that
// says the same.
#include "document.h"
#include "projection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "cli/program.h"
#include "command.h"
#include "ovoid/camera.h"
#include "ovoid/error.h"
#include "panels.h"

namespace ovoid::viewer {
namespace document_test {

using cli_tests::Folder;

constexpr Size kPicture{64, 48};
constexpr double kAspect = 64.0 / 48;

// Hands over all that the loader reports until it has nothing more to do; returns its complaint.
std::string load(Loader& loader, Document& document) {
  std::string failure;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  for (bool is_busy = true; is_busy;) {
    is_busy = loader.is_busy();
    for (LoadReport& report : loader.take_reports()) {
      if (auto* opened = std::get_if<Opened>(&report)) document.take(*opened);
      if (auto* ready = std::get_if<ShownReady>(&report)) document.take(*ready, kAspect);
      if (auto* extras = std::get_if<std::shared_ptr<const Extras>>(&report))
        document.extras = *extras;
      if (auto* read = std::get_if<BesideRead>(&report)) {
        for (const auto& surface : read->surfaces) {
          if (read->use == BesideUse::kRenew) {
            document.renew_surface(surface);
          } else {
            document.add_surface(surface);
          }
        }
        for (const SurfaceSource& source : read->failed) document.give_up_surface(source);
        for (const std::string& error : read->errors) failure = error;
      }
      if (auto* failed = std::get_if<LoadFailed>(&report)) failure = failed->message;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (std::chrono::steady_clock::now() > deadline) return "not loaded in time";
  }
  return failure;
}

class Documents : public ::testing::Test {
 protected:
  void open(std::vector<std::string> flags = {}) {
    path_ = cli_tests::write_ball(folder_);
    flags.insert(flags.begin(), path_);
    loader_.open(parse_launch(flags));
    ASSERT_EQ(load(loader_, document_), "");
    ASSERT_TRUE(document_.is_open());
  }
  std::vector<std::string> words() const { return flags_of(document_, kPicture).words(); }
  // The word behind a flag; "" if it is not there.
  std::string told(const std::string& flag) const {
    const cli::FlagSet flags = flags_of(document_, kPicture);
    const auto* const value = flags.find(flag);
    if (value == nullptr) return "";
    return value->is_string() ? value->get<std::string>() : value->dump();
  }

  Folder folder_;
  std::string path_;
  Loader loader_;
  Document document_;
};

TEST_F(Documents, AreFilledByTheLoader) {
  open();
  EXPECT_EQ(document_.info->title, "ball_16x16x16_uint8.raw");
  EXPECT_FALSE(document_.has_time());
  EXPECT_EQ(document_.shown->field().num_kernels(), 4096);
  ASSERT_NE(document_.extras, nullptr);
  EXPECT_EQ(document_.extras->of, document_.shown);
  EXPECT_FALSE(document_.extras->histogram.linear.counts.empty());
  EXPECT_TRUE(document_.extras->probe != nullptr);
  EXPECT_NO_THROW(document_.camera.validate());
}

TEST_F(Documents, WhatCannotBeReadLeavesWhatIsThere) {
  open();
  const auto shown = document_.shown;
  const std::string missing = folder_ / "missing.nrrd";
  loader_.open(parse_launch({missing}));
  EXPECT_NE(load(loader_, document_).find(missing), std::string::npos);
  EXPECT_EQ(document_.shown, shown);
}

// All that flags say of the view is there from the beginning, and is said again by the command.
TEST_F(Documents, TakeWhatTheFlagsSay) {
  open({"--value-plane", "0,0,1,2", "--clip", "1,0,0,3", "--crop-world", "1:,:,:", "--background",
        "1,0.5,0.25", "--mode", "isosurface", "--iso", "100", "--backend", "reference",
        "--sampling-distance", "0.5", "--scale-bar"});
  const View& view = document_.view;
  ASSERT_TRUE(view.plane.has_value());
  EXPECT_EQ(view.plane->offset, 2);
  ASSERT_EQ(view.clip_planes.size(), 1U);
  EXPECT_EQ(view.clip_planes[0].offset, 3);
  ASSERT_TRUE(view.crop.has_value());
  EXPECT_EQ(view.crop->min().x(), 1);
  EXPECT_EQ(view.background, (Rgb{1, 0.5, 0.25}));
  EXPECT_EQ(view.look.mode, Mode::kIsosurface);
  EXPECT_EQ(view.look.isovalue, 100);
  EXPECT_EQ(document_.setup.backend, Backend::kReference);
  EXPECT_EQ(view.options.sampling_distance, 0.5);
  EXPECT_TRUE(view.marks.scale_bar);
  EXPECT_NE(told("value-plane"), "");
  EXPECT_NE(told("clip"), "");
  EXPECT_EQ(told("crop-world"), "1:,:,:");
  EXPECT_EQ(told("background"), "1,0.5,0.25");
  EXPECT_EQ(told("iso"), "100");
  EXPECT_EQ(told("backend"), "reference");
  EXPECT_EQ(told("sampling-distance"), "0.5");
  EXPECT_EQ(told("scale-bar"), "true");
  EXPECT_EQ(told("size"), "64x48");
}

TEST_F(Documents, UndoAndRedo) {
  open();
  EXPECT_FALSE(document_.can_undo());
  EXPECT_FALSE(document_.can_redo());
  document_.undo();  // has no effect
  const Rgb first = document_.view.background;
  const auto edit = [&](double red) {
    document_.view.background = {red, 0, 0};
    document_.touch();
    document_.remember();
  };
  edit(0.25);
  edit(0.5);
  const std::uint64_t version = document_.version();
  document_.undo();
  EXPECT_EQ(document_.view.background[0], 0.25);
  EXPECT_GT(document_.version(), version);  // so that a picture is asked for
  document_.undo();
  EXPECT_EQ(document_.view.background, first);
  EXPECT_FALSE(document_.can_undo());
  document_.redo();
  document_.redo();
  EXPECT_EQ(document_.view.background[0], 0.5);
  EXPECT_FALSE(document_.can_redo());
  document_.undo();
  edit(0.75);  // another future
  EXPECT_FALSE(document_.can_redo());
  document_.undo();
  EXPECT_EQ(document_.view.background[0], 0.25);
}

// The window calls remember() after whatever was done.
TEST_F(Documents, WhatIsNoEditIsNotUndone) {
  open();
  document_.remember();
  EXPECT_FALSE(document_.can_undo());
  document_.touch_beside_view();
  document_.remember();
  EXPECT_FALSE(document_.can_undo());
  document_.view.background = {1, 0, 0};
  document_.touch();
  document_.remember();
  document_.undo();
  document_.remember();
  EXPECT_FALSE(document_.can_undo());
  ASSERT_TRUE(document_.can_redo());
  document_.redo();
  document_.remember();
  EXPECT_EQ(document_.view.background[0], 1);
  EXPECT_TRUE(document_.can_undo());
  EXPECT_FALSE(document_.can_redo());
}

TEST_F(Documents, UndoForgetsTheOldestOfManySteps) {
  open();
  for (int i = 0; i < 300; ++i) {
    document_.view.background = {i / 300.0, 0, 0};
    document_.touch();
    document_.remember();
  }
  int steps = 0;
  for (; document_.can_undo(); ++steps) document_.undo();
  EXPECT_EQ(steps, 200);
  EXPECT_NEAR(document_.view.background[0], 99 / 300.0, 1e-12);
}

TEST_F(Documents, BoundsAreWhatTheCropLeaves) {
  open();
  const Bounds3 all = document_.data_bounds();
  EXPECT_EQ(document_.bounds().min(), all.min());
  EXPECT_EQ(document_.bounds().max(), all.max());
  const Vec3 far = Vec3::Constant(HUGE_VAL);
  document_.view.crop = Bounds3(Vec3(5, -HUGE_VAL, -HUGE_VAL), Vec3(9, HUGE_VAL, 7));
  EXPECT_EQ(document_.bounds().min(), Vec3(5, all.min().y(), all.min().z()));
  EXPECT_EQ(document_.bounds().max(), Vec3(9, all.max().y(), 7));
  EXPECT_EQ(document_.options_of(document_.view, kPicture).clip_planes.size(), 3U);
  // A crop that would leave nothing cuts nothing.
  document_.view.crop = Bounds3(Vec3::Constant(1e6), far);
  EXPECT_EQ(document_.bounds().min(), all.min());
  EXPECT_TRUE(document_.options_of(document_.view, kPicture).clip_planes.empty());
}

TEST_F(Documents, ResetTheCameraButNotItsProjection) {
  open();
  const Camera first = document_.camera;
  document_.camera.position += Vec3(1, 2, 3);
  document_.camera.parallel_projection = true;
  document_.reset_camera(kAspect);
  EXPECT_EQ(document_.camera.position, first.position);
  EXPECT_TRUE(document_.camera.parallel_projection);
  document_.reset_camera(kAspect, "-x");
  EXPECT_TRUE(document_.camera.parallel_projection);
  const Vec3 from = (document_.camera.position - document_.camera.focal_point).normalized();
  EXPECT_LT((from - Vec3(-1, 0, 0)).norm(), 1e-12);
}

TEST_F(Documents, JobsAreOneOrTwo) {
  open();
  EXPECT_EQ(document_.jobs(kPicture).size(), 1U);
  document_.other = Setting{document_.view, document_.setup};
  document_.other->setup.backend = Backend::kReference;
  EXPECT_EQ(document_.jobs(kPicture).size(), 1U);
  document_.compare = CompareMode::kSideBySide;
  auto jobs = document_.jobs(kPicture);
  ASSERT_EQ(jobs.size(), 2U);
  EXPECT_EQ(jobs[0]->setup.backend, Backend::kReference);
  EXPECT_EQ(jobs[0]->options.width, 32);
  EXPECT_EQ(jobs[1]->options.width, 32);
  // Half as wide, and the whole width of the view in it.
  const Projection whole(document_.camera, 64, 48);
  const Projection half(jobs[1]->camera, 32, 48);
  const double depth = whole.focal_depth();
  EXPECT_NEAR(half.pixel_size_at(depth) * 32, whole.pixel_size_at(depth) * 64, 1e-9 * depth);
  // Of a view that alone is wider.
  const Projection wider(document_.camera, 96, 48);
  const Projection narrow(document_.jobs(kPicture, 96)[1]->camera, 32, 48);
  EXPECT_NEAR(narrow.pixel_size_at(depth) * 32, wider.pixel_size_at(depth) * 96, 1e-9 * depth);
  for (const CompareMode mode : {CompareMode::kDivided, CompareMode::kDifference}) {
    document_.compare = mode;
    jobs = document_.jobs(kPicture);
    EXPECT_EQ(jobs[0]->options.width, 64);
    EXPECT_EQ(jobs[1]->options.height, 48);
    EXPECT_EQ(jobs[0]->camera.view_angle, document_.camera.view_angle);
  }
}

// A reload keeps what was set; other data do not.
TEST_F(Documents, AReloadKeepsTheView) {
  open();
  document_.view.background = {1, 0, 0};
  document_.camera.position += Vec3(1, 2, 3);
  const Camera camera = document_.camera;
  const auto shown = document_.shown;
  loader_.open(document_.launch, true);
  ASSERT_EQ(load(loader_, document_), "");
  EXPECT_NE(document_.shown, shown);
  EXPECT_EQ(document_.view.background[0], 1);
  EXPECT_EQ(document_.camera.position, camera.position);
  loader_.open(parse_launch({path_}));
  ASSERT_EQ(load(loader_, document_), "");
  EXPECT_NE(document_.view.background[0], 1);
  EXPECT_NE(document_.camera.position, camera.position);
}

// Fails if a surface is read again for another array or step, or again although its file is as it
// was; or if a changed file is not.
TEST_F(Documents, SurfacesAreReadOnce) {
  const auto write = [&](const char* top) {
    cli_tests::write_file(folder_ / "a.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 ") +
                                                 top + "\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n");
  };
  write("1");
  const std::string path = folder_ / "a.obj";
  open({"--add", path, "--add-color", "1,0,0", "--slice", "z"});
  ASSERT_EQ(document_.view.added.size(), 1U);
  EXPECT_EQ(document_.view.added[0].color, (Rgb{1, 0, 0}));
  const auto surface = document_.view.added[0].of->surface;
  loader_.read_beside({{path}, BesideUse::kAdd});
  ASSERT_EQ(load(loader_, document_), "");
  ASSERT_EQ(document_.view.added.size(), 2U);
  EXPECT_EQ(document_.view.added[1].of->surface, surface);
  EXPECT_EQ(told("add-color"), "[\"1,0,0\",\"0.55,0.66,0.78\"]");
  document_.remember();
  write("1.25");
  loader_.read_beside({{}, BesideUse::kRenew, BesideKind::kAny, 0, {}, {{path}}});
  ASSERT_EQ(load(loader_, document_), "");
  const auto renewed = document_.view.added[0].of->surface;
  EXPECT_NE(renewed, surface);
  EXPECT_EQ(document_.view.added[1].of->surface, renewed);
  document_.undo();  // what is taken back is the list, not the file
  ASSERT_EQ(document_.view.added.size(), 1U);
  EXPECT_EQ(document_.view.added[0].of->surface, renewed);
  std::filesystem::remove(path);
  const auto shown = document_.shown;
  loader_.choose(choice_of(*shown));
  ASSERT_EQ(load(loader_, document_), "");
  EXPECT_NE(document_.shown, shown);
  EXPECT_EQ(document_.view.added[0].of->surface, renewed);
  EXPECT_EQ(told("slice"), "[\"z\"]");
}

// Fails if what is wanted otherwise is not told, is not put where it is wanted, or cannot be given
// up; or if undo forgets what was wanted before.
TEST_F(Documents, SurfacesAreMadeOtherwise) {
  const std::string path = folder_ / "p.csv";
  cli_tests::write_file(path, "x,y,z,heat\n0,0,0,2\n1,0,0,7\n");
  open({"--add", path});
  document_.remember();
  AddedSurface& added = document_.view.added.at(0);
  EXPECT_EQ(added.of->arrays, std::vector<std::string>{"heat"});
  EXPECT_TRUE(added.of->has_radius);
  EXPECT_TRUE(document_.surfaces_to_make().empty());
  EXPECT_EQ(told("add-array"), "");
  EXPECT_EQ(told("add-radius"), "");
  const SurfaceSource plain = added.source;
  added.source.array = "heat";
  added.source.radius = 0.25;
  document_.touch();
  document_.remember();
  const std::vector<SurfaceSource> wanted = document_.surfaces_to_make();
  ASSERT_EQ(wanted, std::vector{added.source});
  EXPECT_FALSE(added.geometry(false).colors);  // of values that are not there yet
  loader_.read_beside({{}, BesideUse::kRenew, BesideKind::kAny, 0, {}, wanted});
  ASSERT_EQ(load(loader_, document_), "");
  EXPECT_TRUE(document_.surfaces_to_make().empty());
  EXPECT_TRUE(added.is_made());
  EXPECT_EQ(added.of->values, std::pair(2.0, 7.0));
  ASSERT_TRUE(added.geometry(false).colors);
  EXPECT_EQ(added.geometry(false).colors->lo(), 2);
  EXPECT_EQ(told("add-array"), "[\"heat\"]");
  EXPECT_EQ(told("add-radius"), "[\"0.25\"]");
  EXPECT_EQ(told("add-range"), "");
  document_.undo();
  EXPECT_EQ(document_.surfaces_to_make(), std::vector{plain});  // undo keeps none of its own
  document_.redo();
  EXPECT_TRUE(document_.surfaces_to_make().empty());
  document_.view.added[0].source.array = "cold";
  loader_.read_beside(
      {{}, BesideUse::kRenew, BesideKind::kAny, 0, {}, document_.surfaces_to_make()});
  EXPECT_NE(load(loader_, document_).find("cold"), std::string::npos);
  EXPECT_EQ(document_.view.added[0].source.array, "heat");
}

// Numbers are told so that the same are read again, and other words so that a shell leaves them be.
TEST_F(Documents, CommandsAreQuotedForAShell) {
  open();
  document_.camera.position = Vec3(1.0 / 3, -2e-17, 12345.678901234567);
  const std::string odd = folder_ / "it's $HOME & \"more\"_4x4x4_uint8.raw";
  cli_tests::write_file(odd, std::string(64, '\x7f'));
  auto launch = parse_launch({odd});
  document_.launch = launch;
  const std::string command = command_of(document_, kPicture);
  EXPECT_EQ(command.rfind("ovoid render ", 0), 0U);
  EXPECT_EQ(command.find('\n'), std::string::npos);
  // A shell hands over the words as they were.
  const auto shell = cli_tests::run(
      {"-c", "ovoid() { for word in \"$@\"; do printf '%s\\n' \"$word\"; done; }\n" + command},
      "/bin/sh");
  EXPECT_EQ(shell.exit_code, 0) << shell.err;
  std::vector<std::string> wanted = {"render", odd};
  for (const std::string& word : words()) wanted.push_back(word);
  wanted.insert(wanted.end(), {"-o", "picture.png"});
  std::istringstream lines(shell.out);
  std::vector<std::string> got;
  for (std::string line; std::getline(lines, line);) got.push_back(line);
  EXPECT_EQ(got, wanted);
  const auto camera = nlohmann::json::parse(told("camera"));
  EXPECT_EQ(camera["position"][0].get<double>(), 1.0 / 3);
  EXPECT_EQ(camera["position"][1].get<double>(), -2e-17);
  EXPECT_EQ(camera["position"][2].get<double>(), 12345.678901234567);
}

// What the window wants back of a state, and what is no such thing.
TEST_F(Documents, TheWindowsPartOfAState) {
  open();
  document_.time.loops = false;
  document_.time.is_interpolated = true;
  document_.time.is_fastest = true;
  document_.time.rate = 2.5;
  const nlohmann::ordered_json kept = window_state(document_);
  document_.time = {};
  take_window_state(kept, document_);
  EXPECT_FALSE(document_.time.loops);
  EXPECT_TRUE(document_.time.is_interpolated);
  EXPECT_TRUE(document_.time.is_fastest);
  EXPECT_EQ(document_.time.rate, 2.5);
  for (const char* const damaged :
       {"[]", "3", "null", R"({"loops": 3, "rate": "fast"})", R"({"rate": -1})", R"({"rate": 0})"})
    take_window_state(nlohmann::ordered_json::parse(damaged), document_);
  EXPECT_FALSE(document_.time.loops);
  EXPECT_EQ(document_.time.rate, 2.5);
}

// Fails if the last step does not read as the last, or if a step's number stands twice.
TEST(TimeLabels, SayWhichStepItIs) {
  const auto text_of = [](const std::vector<double>& times, const std::string& unit, double time) {
    const TimeLabel label = time_label(times, unit, time);
    return label.before + "#" + label.after;
  };
  EXPECT_EQ(text_of({0, 1, 2, 3}, "", 3), "step # of 0 to 3");
  EXPECT_EQ(text_of({0, 1, 2, 3}, "", 0.5), "#");
  EXPECT_EQ(text_of({0, 1, 2, 3}, "s", 3), "# s (step 3 of 0 to 3)");
  EXPECT_EQ(text_of({0, 0.5, 2.5}, "", 0.5), "# (step 1 of 0 to 2)");
  EXPECT_EQ(text_of({0, 0.5, 2.5}, "ms", 0.6), "# ms");
  EXPECT_EQ(time_label({0, 50}, "%", 50).format(), "%.6g %% (step 1 of 0 to 1)");
}

}  // namespace document_test
}  // namespace ovoid::viewer
