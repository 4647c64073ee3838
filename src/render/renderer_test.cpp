// SPDX-License-Identifier: Apache-2.0
#include "ovoid/renderer.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>

#include "ovoid/devices.h"
#include "ovoid/error.h"
#include "support/numbers.h"
#include "support/scenes.h"
#include "support/volumes.h"

namespace ovoid {
namespace renderer_test {

// Expects an Error(kInvalidArgument) whose message starts with `start`.
void expect_refused(const std::function<void()>& work, const std::string& start) {
  try {
    work();
    ADD_FAILURE() << "accepted; expected: " << start;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_EQ(std::string(error.what()).substr(0, start.size()), start);
  }
}

RenderOptions with(const std::function<void(RenderOptions&)>& change) {
  RenderOptions options;
  change(options);
  return options;
}

// Fails if a member is not checked, or its message does not name it and its value.
TEST(RenderOptions, EachMemberIsNamed) {
  const std::pair<RenderOptions, const char*> cases[] = {
      {with([](auto& o) { o.width = 0; }), "width = 0: must be 1 to 32768"},
      {with([](auto& o) { o.width = 32769; }), "width = 32769: "},
      {with([](auto& o) { o.height = -3; }), "height = -3: must be 1 to 32768"},
      {with([](auto& o) { o.sampling_distance = -0.5; }), "sampling_distance = -0.5: must be > 0"},
      {with([](auto& o) { o.sampling_distance = kNan; }), "sampling_distance = nan: "},
      {with([](auto& o) { o.sampling_distance = kInfinity; }), "sampling_distance = inf: "},
      {with([](auto& o) { o.clip_planes.resize(17); }), "clip_planes: 17 given, at most 16"},
      {with([](auto& o) { o.spread = Spread::kBilinear; }),
       "spread: bilinear needs a published way of post-convolution"},
      {with([](auto& o) {
         o.clip_planes = {{}, {{0, 0, 0}, 1}};
       }),
       "clip_planes[1].normal: "},
      {with([](auto& o) {
         o.clip_planes = {{{kNan, 0, 0}, 1}};
       }),
       "clip_planes[0].normal: "},
      {with([](auto& o) {
         o.clip_planes = {{{1, 0, 0}, kInfinity}};
       }),
       "clip_planes[0].offset: "},
  };
  for (const auto& wrong : cases) expect_refused([&] { wrong.first.validate(); }, wrong.second);
}

// Fails if a bound itself is refused.
TEST(RenderOptions, DefaultsAndBoundsAreValid) {
  RenderOptions().validate();
  with([](auto& o) {
    o.width = 1;
    o.height = RenderOptions::kMaxImageSide;
    o.sampling_distance = 1e-3;
    o.clip_planes.resize(RenderOptions::kMaxClipPlanes);
  }).validate();
}

TEST(Renderer, RefusesNegativeThreads) {
  expect_refused([] { Renderer(Backend::kCpu, -1); }, "threads = -1: must be >= 1, or 0");
}

// Fails if either back end draws before camera, look and options have been looked at.
TEST(Renderer, ChecksItsArguments) {
  const LatticeField field = test::constant_field({2, 2, 2}, 1);
  const Camera camera = test::parallel_camera({0, 0, 0}, {0, 0, 1}, 1);
  const RenderOptions options = test::picture(4, 4);
  Camera flat = camera;
  flat.parallel_scale = 0;
  Look dark;
  dark.material.ambient = -1;
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    Renderer renderer(backend, 1);
    expect_refused(
        [&] {
          renderer.render({field, {}}, flat, options);
        },
        "camera parallel_scale = 0");
    expect_refused([&] { renderer.render({field, dark}, camera, options); }, "ambient = -1");
    expect_refused(
        [&] {
          renderer.render({field, {}}, camera, test::picture(4, 0));
        },
        "height = 0");
    expect_refused(
        [&] {
          renderer.render({field, {}}, camera, test::picture(4, 4, 1e-9));
        },
        "sampling_distance = ");
  }
}

// Fails if kAuto draws with the reference, or a frame's profile names the wrong back end.
TEST(Renderer, AutoIsTheCpuWhereThereIsNoHardwareDevice) {
  const LatticeField field = test::constant_field({2, 2, 2}, 1);
  const Camera camera = test::parallel_camera({0, 0, 0}, {0, 0, 1}, 1);
  const auto backend_of = [&](Backend backend) {
    return Renderer(backend, 1).render({field, {}}, camera, test::picture(4, 4)).profile.backend;
  };
  const std::vector<DeviceInfo> devices = list_devices().devices;
  const bool has_hardware = std::any_of(
      devices.begin(), devices.end(),
      [](const DeviceInfo& device) { return device.is_hardware() && device.is_usable(); });
  EXPECT_EQ(backend_of(Backend::kAuto), has_hardware ? "vulkan" : "cpu");
  EXPECT_EQ(backend_of(Backend::kCpu), "cpu");
  EXPECT_EQ(backend_of(Backend::kReference), "reference");
}

// Fails if a back end without half sheets ignores the wish for them without a word.
TEST(Renderer, SaysWhereHalfSheetsHaveNoEffect) {
  const LatticeField field = test::constant_field({2, 2, 2}, 1);
  const Camera camera = test::parallel_camera({0, 0, 0}, {0, 0, 1}, 1);
  RenderOptions options = test::picture(4, 4);
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    Renderer renderer(backend, 1);
    options.sheet_precision = SheetPrecision::kSingle;
    EXPECT_EQ(renderer.render({field, {}}, camera, options).profile.notice, "");
    options.sheet_precision = SheetPrecision::kHalf;
    const FrameProfile profile = renderer.render({field, {}}, camera, options).profile;
    EXPECT_EQ(profile.notice,
              "sheet precision: floats; backend " + profile.backend + " has no half sheets");
  }
}

struct FromCallback {
  int number;
};

// Fails if an exception of a callback is lost, changed or ends the process, if callbacks go on, or
// if the renderer is of no use afterwards.
TEST(Renderer, PassesOnWhatCallbacksThrow) {
  const LatticeField field = test::constant_field({8, 8, 8}, 1);
  const Camera camera = test::parallel_camera({0, 0, 0}, {0, 0, 1}, 1);
  const RenderOptions options = test::picture(200, 150);
  for (const Backend backend : {Backend::kCpu, Backend::kReference}) {
    Renderer renderer(backend, 3);
    const Image expected = renderer.render({field, {}}, camera, options).image;
    int num_calls = 0;
    const auto fail = [&] {
      if (++num_calls == 3) throw FromCallback{num_calls};
    };
    RenderHooks progress, tiles;
    progress.progress = [&](double) { fail(); };
    tiles.tile_done = [&](const TileDone&) { fail(); };
    for (const RenderHooks& hooks : {progress, tiles}) {
      num_calls = 0;
      try {
        renderer.render({field, {}}, camera, options, hooks);
        ADD_FAILURE() << "nothing was thrown";
      } catch (const FromCallback& thrown) {
        EXPECT_EQ(thrown.number, 3);
      }
      EXPECT_EQ(num_calls, 3);
      EXPECT_EQ(renderer.render({field, {}}, camera, options).image, expected);
    }
  }
}

}  // namespace renderer_test
}  // namespace ovoid
