// SPDX-License-Identifier: Apache-2.0
// Bricks of a label map, which many threads ask for while they draw.
#include "labels/label_grid.h"

#include <gtest/gtest.h>

#include <latch>
#include <thread>

#include "model/own_array.h"
#include "ovoid/labels.h"
#include "ovoid/model.h"

namespace ovoid::labels {
namespace label_grid_test {

// Slanted layers of three labels, so that every brick has several.
LatticeField layers(std::int64_t side) {
  std::vector<float> values;
  for (std::int64_t k = 0; k < side; ++k)
    for (std::int64_t j = 0; j < side; ++j)
      for (std::int64_t i = 0; i < side; ++i)
        values.push_back(static_cast<float>((i + 2 * j + 3 * k) / 5 % 3));
  Dataset dataset;
  dataset.lattice.dims = {side, side, side};
  dataset.arrays = {model::array_of_numbers("labels", 1, std::move(values))};
  LatticeModelOptions options;
  options.kernel = kLabelKernel;
  return make_lattice_field(dataset, options);
}

std::vector<const LabelBrick*> bricks_from(const LabelGrid& grid, std::size_t first) {
  const Index3& dims = grid.num_bricks();
  const auto count = static_cast<std::size_t>(num_samples(dims));
  std::vector<const LabelBrick*> bricks(count);
  for (std::size_t n = 0; n < count; ++n) {
    const auto b = static_cast<std::int64_t>((first + n) % count);
    bricks[static_cast<std::size_t>(b)] =
        &grid.brick(b % dims[0], b / dims[0] % dims[1], b / (dims[0] * dims[1]));
  }
  return bricks;
}

// Fails if a thread is given a brick that another has not finished, or one that is no longer there.
TEST(LabelGrid, AllThreadsGetTheSameBricks) {
  const LatticeField field = layers(20);
  const LabelGrid grid(field, 1, {}), alone(field, 1, {});
  constexpr std::size_t kThreads = 4;
  std::vector<std::vector<const LabelBrick*>> given(kThreads);
  std::latch all_are_there(kThreads);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      all_are_there.arrive_and_wait();
      // Two by two from the same brick on, so that some want the same at the same time.
      given[t] = bricks_from(grid, t / 2 * 5);
      for (const LabelBrick* const brick : given[t]) EXPECT_GT(brick->ranks.size(), 1U);
    });
  }
  for (std::thread& thread : threads) thread.join();
  const std::vector<const LabelBrick*> expected = bricks_from(alone, 0);
  for (const auto& bricks : given) EXPECT_EQ(bricks, given[0]);
  for (std::size_t b = 0; b < expected.size(); ++b) {
    EXPECT_EQ(given[0][b]->ranks, expected[b]->ranks);
    EXPECT_EQ(given[0][b]->fine, expected[b]->fine);
    EXPECT_EQ(given[0][b]->candidates, expected[b]->candidates);
  }
}

}  // namespace label_grid_test
}  // namespace ovoid::labels
