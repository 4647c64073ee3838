// SPDX-License-Identifier: Apache-2.0
// Watching, stopping and failing frames: the cpu back end and the reference alike.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <stdexcept>

#include "ovoid/error.h"
#include "render/cpu/cpu_renderer.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace hooks_test {

// Fails to read any brick once `num_reads` have been read.
class FailingSource final : public BrickSource {
 public:
  FailingSource(const LatticeField& field, int num_reads) : field_(field), reads_left_(num_reads) {}
  const LatticeGeometry& geometry() const noexcept override { return field_.geometry(); }
  int brick_edge() const noexcept override { return field_.source().brick_edge(); }
  double range_reach() const noexcept override { return field_.source().range_reach(); }
  ValueRange brick_range(std::int64_t x, std::int64_t y, std::int64_t z) const noexcept override {
    return field_.source().brick_range(x, y, z);
  }
  bool has_missing(std::int64_t, std::int64_t, std::int64_t) const noexcept override {
    return false;
  }
  BrickView acquire(std::int64_t x, std::int64_t y, std::int64_t z, double time) const override {
    if (reads_left_-- <= 0) throw Error(ErrorCode::kFileFormat, "brick 7: no such bytes");
    return field_.source().acquire(x, y, z, time);
  }
  std::size_t resident_bytes() const noexcept override { return 0; }

 private:
  LatticeField field_;
  mutable std::atomic<int> reads_left_;
};

TestScene scene_of_many_tiles() {
  TestScene scene = small_scene(Mode::kComposite, true);
  scene.options = picture(101, 83);
  return scene;
}

class Hooks : public ::testing::TestWithParam<Backend> {
 protected:
  Frame render(const TestScene& scene, const RenderHooks& hooks, int threads = 3) const {
    return Renderer(GetParam(), threads)
        .render({scene.field, scene.look}, scene.camera, scene.options, hooks);
  }
};

ErrorCode code_of(const std::function<void()>& work, std::string* message = nullptr) {
  try {
    work();
  } catch (const Error& error) {
    if (message != nullptr) *message = error.what();
    return error.code();
  }
  throw std::logic_error("no Error was thrown");
}

// Fails if tiles overlap, leave gaps or arrive before their pixels, if callbacks meet, or if
// progress falls or does not end at 1.
TEST_P(Hooks, TilesCoverThePictureOnce) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TestScene scene = scene_of_many_tiles();
  std::vector<int> times(static_cast<std::size_t>(scene.options.width * scene.options.height), 0);
  Image copied;
  copied.width = scene.options.width;
  copied.height = scene.options.height;
  copied.rgba.assign(4 * times.size(), -1.0F);
  copied.depth.assign(times.size(), -1.0F);
  copied.front_depth = copied.depth;
  std::vector<double> fractions;
  std::atomic<int> inside{0};
  RenderHooks hooks;
  hooks.tile_done = [&](const TileDone& tile) {
    EXPECT_EQ(inside++, 0);
    ASSERT_TRUE(0 <= tile.x0 && tile.x0 < tile.x1 && tile.x1 <= scene.options.width);
    ASSERT_TRUE(0 <= tile.y0 && tile.y0 < tile.y1 && tile.y1 <= scene.options.height);
    for (int y = tile.y0; y < tile.y1; ++y) {
      for (int x = tile.x0; x < tile.x1; ++x) {
        const auto p = static_cast<std::size_t>(y * scene.options.width + x);
        ++times[p];
        for (std::size_t c = 0; c < 4; ++c) copied.rgba[4 * p + c] = tile.image->rgba[4 * p + c];
        copied.depth[p] = tile.image->depth[p];
        copied.front_depth[p] = tile.image->front_depth[p];
      }
    }
    --inside;
  };
  hooks.progress = [&](double fraction) {
    EXPECT_EQ(inside++, 0);
    fractions.push_back(fraction);
    --inside;
  };
  const Frame frame = render(scene, hooks);
  for (const int n : times) ASSERT_EQ(n, 1);
  EXPECT_EQ(copied, frame.image);
  ASSERT_FALSE(fractions.empty());
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_GE(fractions.front(), 0.0);
  EXPECT_EQ(fractions.back(), 1.0);
}

// Fails if a frame is drawn though it was stopped before.
TEST_P(Hooks, StoppedBefore) {
  OVOID_NIGHTLY_ON_DEVICE();
  std::stop_source source;
  source.request_stop();
  RenderHooks hooks;
  hooks.stop = source.get_token();
  hooks.tile_done = [](const TileDone&) { ADD_FAILURE() << "a tile was drawn"; };
  EXPECT_EQ(code_of([&] { render(scene_of_many_tiles(), hooks); }), ErrorCode::kCancelled);
}

// Fails if a frame goes on to its end after a stop, or the renderer cannot be used afterwards.
TEST_P(Hooks, StoppedAtTheFirstTile) {
  OVOID_NIGHTLY_ON_DEVICE();
  const TestScene scene = scene_of_many_tiles();
  Renderer renderer(GetParam(), 2);
  const auto frame = [&](const RenderHooks& hooks) {
    return renderer.render({scene.field, scene.look}, scene.camera, scene.options, hooks).image;
  };
  std::stop_source source;
  int num_tiles = 0;
  RenderHooks hooks;
  hooks.stop = source.get_token();
  hooks.tile_done = [&](const TileDone&) {
    source.request_stop();
    ++num_tiles;
  };
  EXPECT_EQ(code_of([&] { frame(hooks); }), ErrorCode::kCancelled);
  EXPECT_LE(num_tiles, 4);  // those under way when the first was done
  EXPECT_EQ(frame({}), render(scene, {}).image);
}

// Fails if what a brick source throws is lost, changed, or ends the process.
TEST_P(Hooks, BrickSourceErrorsArrive) {
  OVOID_NIGHTLY_ON_DEVICE();
  for (const int num_reads : {0, 1}) {
    TestScene scene = scene_of_many_tiles();
    scene.field = LatticeField(std::make_shared<FailingSource>(scene.lattice(), num_reads),
                               scene.lattice().kernel(), scene.field.reconstruction());
    std::string message;
    EXPECT_EQ(code_of([&] { render(scene, {}); }, &message), ErrorCode::kFileFormat);
    EXPECT_EQ(message, "brick 7: no such bytes");
  }
}

// Fails if a hook's own exception is lost.
TEST_P(Hooks, HookExceptionsArrive) {
  OVOID_NIGHTLY_ON_DEVICE();
  RenderHooks hooks;
  hooks.progress = [](double) { throw std::runtime_error("the watcher fell asleep"); };
  EXPECT_THROW(render(scene_of_many_tiles(), hooks), std::runtime_error);
}

INSTANTIATE_TEST_SUITE_P(Backends, Hooks, ::testing::Values(Backend::kCpu, Backend::kReference),
                         [](const auto& test) {
                           return test.param == Backend::kCpu ? "cpu" : "reference";
                         });

}  // namespace hooks_test
}  // namespace ovoid::test
