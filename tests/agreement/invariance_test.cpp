// SPDX-License-Identifier: Apache-2.0
// What must not change a picture of the cpu back end, not even by a bit; and that every SIMD target
// draws what the reference draws.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>

#include "ovoid/error.h"
#include "render/cpu/cpu_renderer.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/scenes.h"
#include "support/where.h"
#include "view/plan/base_plane.h"
#include "view/plan/frame_plan.h"

namespace ovoid::test {
namespace invariance_test {

// The least brick source that the interface allows: acquire() shows one brick and nothing beside
// it, in memory of its own that lives as long as the view's pin and is then overwritten.
class OneBrickSource final : public BrickSource {
 public:
  OneBrickSource(const LatticeField& field, int edge) : field_(field), edge_(edge) {}

  const LatticeGeometry& geometry() const noexcept override { return field_.geometry(); }
  int brick_edge() const noexcept override { return edge_; }
  double value_scale() const noexcept override { return field_.source().value_scale(); }
  double value_offset() const noexcept override { return field_.source().value_offset(); }
  double range_reach() const noexcept override { return field_.source().range_reach(); }
  std::size_t resident_bytes() const noexcept override { return 0; }

  ValueRange brick_range(std::int64_t bx, std::int64_t by,
                         std::int64_t bz) const noexcept override {
    ValueRange merged;
    for_each_inner({bx, by, bz}, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
      const ValueRange range = field_.source().brick_range(x, y, z);
      if (range.is_empty()) return;
      merged.lo = merged.is_empty() ? range.lo : std::min(merged.lo, range.lo);
      merged.hi = std::max(merged.hi, range.hi);
    });
    return merged;
  }

  bool has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override {
    bool any = false;
    for_each_inner({bx, by, bz}, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
      any = any || field_.source().has_missing(x, y, z);
    });
    return any;
  }

  BrickView acquire(std::int64_t bx, std::int64_t by, std::int64_t bz, double time) const override {
    const BrickView all = field_.source().acquire(0, 0, 0, time);
    const Index3 brick{bx, by, bz};
    BrickView one;
    one.type = all.type;
    for (int a = 0; a < 3; ++a) {
      one.lo[a] = brick[a] * edge_;
      one.hi[a] = std::min(one.lo[a] + edge_, geometry().dims[a]);
    }
    one.stride_y = one.hi[0] - one.lo[0];
    one.stride_z = one.stride_y * (one.hi[1] - one.lo[1]);
    const std::size_t size = size_of(all.type);
    const std::size_t bytes =
        static_cast<std::size_t>(one.stride_z * (one.hi[2] - one.lo[2])) * size;
    const std::shared_ptr<std::byte> memory(new std::byte[bytes], [bytes](std::byte* p) {
      std::memset(p, 0xFF, bytes);  // who reads on after letting go sees NaN
      delete[] p;
    });
    std::byte* to = memory.get();
    for (std::int64_t k = one.lo[2]; k < one.hi[2]; ++k) {
      for (std::int64_t j = one.lo[1]; j < one.hi[1]; ++j) {
        const std::int64_t from = one.lo[0] + j * all.stride_y + k * all.stride_z;
        const std::size_t row = static_cast<std::size_t>(one.stride_y) * size;
        std::memcpy(
            to, static_cast<const std::byte*>(all.data) + from * static_cast<std::int64_t>(size),
            row);
        to += row;
      }
    }
    one.data = memory.get();
    one.pin = memory;
    return one;
  }

 private:
  // The smaller bricks of the field's own source inside one of ours.
  template <class Visit>
  void for_each_inner(const Index3& brick, const Visit& visit) const {
    const int inner_edge = field_.source().brick_edge();
    const std::int64_t ratio = edge_ / inner_edge;
    Index3 end;
    for (int a = 0; a < 3; ++a) {
      const std::int64_t count = (geometry().dims[a] + inner_edge - 1) / inner_edge;
      end[a] = std::min((brick[a] + 1) * ratio, count);
    }
    for (std::int64_t z = brick[2] * ratio; z < end[2]; ++z) {
      for (std::int64_t y = brick[1] * ratio; y < end[1]; ++y) {
        for (std::int64_t x = brick[0] * ratio; x < end[0]; ++x) visit(x, y, z);
      }
    }
  }

  LatticeField field_;
  int edge_;
};

// Scenes of all modes, with holes and without, over several tiles and blocks.
std::vector<std::pair<std::string, TestScene>> scenes() {
  std::vector<std::pair<std::string, TestScene>> result;
  const std::vector<TestVolume> volumes = test_volumes();
  const std::pair<Mode, const char*> modes[] = {{Mode::kComposite, "composite"},
                                                {Mode::kXray, "xray"},
                                                {Mode::kMaximum, "maximum"},
                                                {Mode::kMean, "mean"},
                                                {Mode::kIsosurface, "isosurface"}};
  for (const TestVolume& volume : volumes) {
    for (const auto& [mode, mode_name] : modes) {
      const bool is_parallel = result.size() % 2 == 0;
      TestScene scene{volume.field, askew_camera(volume.field, is_parallel, 1.4),
                      test_looks(volume.lo, volume.hi)[result.size() % 3].look, picture(60, 50)};
      scene.look.mode = mode;
      scene.look.isovalue = volume.lo + 0.55 * (volume.hi - volume.lo);
      result.emplace_back(volume.name + ", " + mode_name, scene);
    }
    TestScene central{volume.field, askew_camera(volume.field, true, 1.4),
                      test_looks(volume.lo, volume.hi)[0].look, picture(60, 50)};
    central.options.gradient = GradientMethod::kCentral;
    result.emplace_back(volume.name + ", central", central);
    TestScene pieces = central;
    pieces.options.classification = Classification::kPreintegrated;
    result.emplace_back(volume.name + ", central, pre-integrated", pieces);
    pieces.options.gradient = GradientMethod::kCorrected;
    pieces.options.sampling_distance = 2.5 * volume.field.default_sampling_distance();
    result.emplace_back(volume.name + ", pre-integrated", pieces);
    pieces.look.transfer_function.gradient_opacities = {{0, 0.1},
                                                        {0.5 * (volume.hi - volume.lo), 1}};
    result.emplace_back(volume.name + ", pre-integrated, fading", pieces);
    TestScene slabs = central;
    slabs.options = picture(60, 50, 0, Slab::kMean);
    result.emplace_back(volume.name + ", slab means", slabs);
    slabs.options.sampling_distance = 4 * volume.field.default_sampling_distance();
    result.emplace_back(volume.name + ", long slabs", slabs);
    TestScene covered{volume.field, askew_camera(volume.field, true, 6), uniform_look(0.9),
                      picture(60, 50)};
    covered.options.sampling_distance = 0.1 * volume.field.default_sampling_distance();
    result.emplace_back(volume.name + ", behind what is opaque", covered);
    for (const Vec3& direction : {Vec3(0.2, 0.1, 1), Vec3(0.1, -1, 0.2), Vec3(1, 0.2, 0.1)}) {
      TestScene on_lattice = central;
      on_lattice.camera.position = on_lattice.camera.focal_point + 100 * direction;
      on_lattice.camera.view_up = {0.3, 0.5, -0.7};
      on_lattice.options.gradient = GradientMethod::kAuto;
      on_lattice.options.sheets = Sheets::kLattice;
      result.emplace_back(fmt::format("{}, lattice sheets from {}", volume.name, direction.x()),
                          on_lattice);
    }
  }
  return result;
}

Frame draw_with(const TestScene& scene, std::unique_ptr<cpu::Runner> runner) {
  const cpu::Machine machine{std::move(runner)};
  const RenderHooks hooks;
  std::optional<view::BasePlane> base;
  if (scene.options.sheets == Sheets::kLattice) {
    base = view::base_plane(scene.lattice(), view::support_of(scene.lattice(), 1.0, 0.0),
                            scene.camera, scene.options);
    EXPECT_TRUE(base);
  }
  return cpu::render({scene.field, scene.camera, scene.look, nullptr, scene.options, hooks, nullptr,
                      base ? &*base : nullptr},
                     machine);
}

// Bits, so that -0 and NaN count too.
::testing::AssertionResult same_bits(const Image& a, const Image& b) {
  if (a.rgba.size() != b.rgba.size() || a.depth.size() != b.depth.size() ||
      a.front_depth.size() != b.front_depth.size()) {
    return ::testing::AssertionFailure() << "pictures of two sizes";
  }
  const auto count_others = [](const std::vector<float>& x, const std::vector<float>& y) {
    std::size_t others = 0;
    for (std::size_t n = 0; n < x.size(); ++n) {
      if (std::memcmp(&x[n], &y[n], sizeof(float)) != 0) ++others;
    }
    return others;
  };
  const std::size_t colors = count_others(a.rgba, b.rgba);
  const std::size_t depths =
      count_others(a.depth, b.depth) + count_others(a.front_depth, b.front_depth);
  if (colors == 0 && depths == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << colors << " components and " << depths << " depths have other bits";
}

// Fails if a tile sees what another one, or an earlier frame, left behind.
TEST(Invariance, ThreadsAndTheirOrder) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  for (const auto& [name, scene] : scenes()) {
    const Image expected = draw_with(scene, cpu::make_runner(1)).image;
    for (const int threads : {2, 3})
      EXPECT_TRUE(same_bits(draw_with(scene, cpu::make_runner(threads)).image, expected))
          << name << ", threads " << threads;
    EXPECT_TRUE(same_bits(draw_with(scene, cpu::make_shuffled_runner()).image, expected))
        << name << ", shuffled";
  }
}

// The same of kernel fields, on levels and without.
TEST(Invariance, ThreadsAndTheirOrderOnKernelSets) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const KernelField field(jittered_ellipsoids(9).source(), Reconstruction::kNormalized);
  for (const double fill : {1.3, 6.0}) {
    const TestScene scene{field, askew_camera(field, false, fill), semi_transparent_look(0, 1),
                          picture(150, 140)};
    const Image expected = draw_with(scene, cpu::make_runner(1)).image;
    for (const int threads : {2, 3})
      EXPECT_TRUE(same_bits(draw_with(scene, cpu::make_runner(threads)).image, expected))
          << threads << " threads";
    EXPECT_TRUE(same_bits(draw_with(scene, cpu::make_shuffled_runner()).image, expected))
        << "shuffled";
  }
}

// Fails if a renderer's second frame is not its first, or another field's frame between shows.
TEST(Invariance, FramesOfOneRenderer) {
  OVOID_NIGHTLY_ON_DEVICE();
  Renderer renderer(Backend::kCpu, 2);
  std::vector<Image> first;
  const auto all = scenes();
  const auto frame = [&](const TestScene& s) {
    return renderer.render({s.field, s.look}, s.camera, s.options).image;
  };
  for (const auto& [name, scene] : all) first.push_back(frame(scene));
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_TRUE(same_bits(frame(all[i].second), first[i])) << all[i].first;
  }
}

// Fails if a sample that can be seen is skipped, or one more neighbour changes a sample's bits.
TEST(Invariance, SkippingChangesNothing) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  std::int64_t skipped_irrelevant = 0;
  std::int64_t skipped_opaque = 0;
  for (const auto& [name, scene] : scenes()) {
    const Frame frame = draw_with(scene, cpu::make_runner(2));
    skipped_irrelevant += frame.profile.blocks_skipped_irrelevant;
    skipped_opaque += frame.profile.blocks_skipped_opaque;
    for (const bool keeps_irrelevant : {true, false}) {
      for (const bool keeps_opaque : {true, false}) {
        TestScene all = scene;
        all.options.skip_irrelevant = !keeps_irrelevant;
        all.options.stop_opaque = !keeps_opaque;
        const Frame thorough = draw_with(all, cpu::make_runner(2));
        EXPECT_TRUE(same_bits(frame.image, thorough.image))
            << name << (keeps_irrelevant ? ", nothing irrelevant" : "")
            << (keeps_opaque ? ", nothing opaque" : "");
        if (keeps_irrelevant) {
          EXPECT_EQ(thorough.profile.blocks_skipped_irrelevant, 0) << name;
        }
        if (keeps_opaque) {
          EXPECT_EQ(thorough.profile.blocks_skipped_opaque, 0) << name;
        }
      }
    }
  }
  EXPECT_GT(skipped_irrelevant, 0);
  EXPECT_GT(skipped_opaque, 0);
}

// Fails if asking for times changes a picture, or gives none.
TEST(Invariance, ProfilesChangeNothing) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NIGHTLY_ON_DEVICE();
  for (const auto& [name, scene] : scenes()) {
    TestScene timed = scene;
    timed.options.collect_profile = true;
    const Frame frame = draw_with(timed, cpu::make_runner(2));
    EXPECT_TRUE(same_bits(frame.image, draw_with(scene, cpu::make_runner(2)).image)) << name;
    EXPECT_FALSE(frame.profile.stages_ms.empty());
    EXPECT_EQ(frame.profile.backend, "cpu");
    EXPECT_EQ(frame.profile.threads, 2);
  }
}

// Fails if the back end reads beyond the brick it asked for, keeps samples after their pin, or
// draws by the size of bricks.
TEST(Invariance, BricksOneAtATime) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  for (const auto& [name, scene] : scenes()) {
    const Image expected = draw_with(scene, cpu::make_runner(2)).image;
    for (const int edge : {4, 8, 16, 64}) {
      TestScene bricked = scene;
      bricked.field = LatticeField(std::make_shared<OneBrickSource>(scene.lattice(), edge),
                                   scene.lattice().kernel(), scene.field.reconstruction());
      EXPECT_TRUE(same_bits(draw_with(bricked, cpu::make_runner(2)).image, expected))
          << name << ", bricks of " << edge;
    }
  }
}

// Fails if a target's code differs from the others' in what it computes, or is not run at all.
TEST(SimdTargets, EachAgreesWithTheReference) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  ASSERT_FALSE(simd_targets().empty());
  for (const auto& [name, scene] : scenes()) {
    if (scene.options.slab == Slab::kMean) continue;  // its reference takes long
    const Image expected = draw(scene, Backend::kReference).image;
    for (const std::string& target : simd_targets()) {
      Renderer renderer(
          RendererSetup{.backend = Backend::kCpu, .threads = 2, .simd_target = target});
      const Frame frame = renderer.render({scene.field, scene.look}, scene.camera, scene.options);
      EXPECT_EQ(frame.profile.simd_target, target) << name;
      EXPECT_TRUE(images_agree(frame.image, expected, scene, target + ", " + name, 0));
    }
  }
}

// Fails if a misspelt target falls back to another in silence.
TEST(SimdTargets, UnknownNameIsAnError) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  try {
    Renderer(RendererSetup{.backend = Backend::kCpu, .simd_target = "mmx"});
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_NE(std::string(error.what()).find("simd_target = mmx: must be one of "),
              std::string::npos)
        << error.what();
  }
}

}  // namespace invariance_test
}  // namespace ovoid::test
