// SPDX-License-Identifier: Apache-2.0
// Fails if a frame that a back end does not draw is handed to it, or one that it draws is not.
#include "render/features.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "ovoid/error.h"
#include "render/back_end.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/volumes.h"

namespace ovoid {
namespace features_test {

struct Used {
  std::string name;  // of the row that refuses it on a device; empty: it is drawn
  bool is_set = false;
  std::function<void(Look& look, RenderOptions& options)> change = [](Look&, RenderOptions&) {};
  bool has_trail = false;
  std::size_t num_further = 0;
};

std::string refusal(Backend by, const Used& used) {
  const Field lattice(test::constant_field({4, 4, 4}, 1));
  const Field set(KernelField(test::jittered_balls(3).source(), Reconstruction::kNormalized));
  Look look = ramp_look({0, 1});
  RenderOptions options;
  used.change(look, options);
  const view::TrailView trail{};
  const std::vector<FurtherVolume> further(used.num_further, {*lattice.lattice(), look});
  const Camera camera;
  const RenderHooks hooks;
  try {
    require_features(
        by, {used.is_set ? set : lattice, camera, look, used.has_trail ? &trail : nullptr, options,
             hooks, nullptr, nullptr, further});
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnsupported);
    return error.what();
  }
  return {};
}

std::vector<Used> frames() {
  const auto surfaces = [](Look& look, RenderOptions&) {
    look.mode = Mode::kIsosurface;
    look.isosurfaces = {{0.2}, {0.7}};
  };
  const auto by_gradient = [](Look& look, RenderOptions&) {
    look.transfer_function_2d =
        TransferFunction2D({{.values = {0, 1}, .gradients = {0, 1}, .opacity = 0.5}});
  };
  const auto in_limits = [](Look&, RenderOptions& options) {
    options.depth_limits = std::make_shared<DepthLimits>();
    options.part = std::make_shared<SpacePart>();
  };
  return {{.name = ""},
          {.name = "", .is_set = true},
          {.name = "", .change = in_limits},
          {.name = "", .has_trail = true},
          {.name = "trails of sets of kernels", .is_set = true, .has_trail = true},
          {.name = "several volumes", .num_further = 1},
          {.name = "several isosurfaces", .change = surfaces},
          {.name = "2-D transfer functions", .change = by_gradient}};
}

TEST(Features, ADeviceRefusesWhatItDoesNotDraw) {
  for (const Used& used : frames()) {
    const std::string said = refusal(Backend::kVulkan, used);
    if (used.name.empty()) {
      EXPECT_EQ(said, "");
    } else {
      EXPECT_EQ(said, used.name + ": not by backend vulkan, take cpu or auto");
    }
    EXPECT_EQ(refusal(Backend::kCpu, used), "") << used.name;
    EXPECT_EQ(refusal(Backend::kReference, used), "") << used.name;
  }
}

TEST(Features, TheTableHasARowForEach) {
  const auto rows = back_end_features();
  EXPECT_EQ(rows.size(), static_cast<std::size_t>(Feature::kHalfSheets) + 1);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto feature = static_cast<Feature>(i);
    EXPECT_EQ(draws(Backend::kVulkan, feature), rows[i].by_vulkan);
    EXPECT_EQ(draws(Backend::kCpu, feature), rows[i].by_cpu);
    EXPECT_EQ(draws(Backend::kReference, feature), rows[i].by_reference);
  }
}

}  // namespace features_test
}  // namespace ovoid
