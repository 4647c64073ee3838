// SPDX-License-Identifier: Apache-2.0
// The cpu back end against the reference on meshes and particles that people really have.
#include <gtest/gtest.h>

#include <algorithm>

#include "io/core/test_data.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/model.h"
#include "support/agreement.h"
#include "support/scenes.h"
#include "support/where.h"

namespace ovoid::test {
namespace real_sets_test {

struct RealSet {
  std::vector<std::string> files;
  std::string array{};
};

// Flat cells on a curved body, a flow in a pipe, values of cells, thin plates, smoothing lengths.
const std::vector<RealSet>& real_sets() {
  static const std::vector<RealSet> sets = {
      {{"bluntfin/bluntfinxyz.bin", "bluntfin/bluntfinq.bin"}},
      {{"disk_out_ref/disk_out_ref.ex2"}},
      {{"limb_tetra/limb_ugrid.vtk"}},
      {{"can/can.vtu"}, "EQPS"},
      {{"phantom_sph/adiabatic_00000.h5"}}};
  return sets;
}

// Between which nine tenths of the kernels' values lie: the ends of such data are often met by a
// few kernels only.
ValueRange usual_values(const KernelField& field) {
  std::vector<float> values;
  for (std::int64_t b = 0; b < field.source().num_bricks(); ++b) {
    const KernelView view = field.source().acquire(b, 0.0);
    values.insert(values.end(), view.value[0], view.value[0] + view.count);
  }
  std::sort(values.begin(), values.end());
  return {values[values.size() / 20], values[values.size() - 1 - values.size() / 20]};
}

class RealSets : public testing::TestWithParam<std::size_t> {};

TEST_P(RealSets, AgreeOnEveryLook) {
  OVOID_NOT_UNDER_ASAN();
  OVOID_NOT_UNDER_TSAN();
  OVOID_NIGHTLY_ON_DEVICE();
  const RealSet& set = real_sets()[GetParam()];
  std::vector<std::string> paths;
  for (const std::string& file : set.files) {
    paths.push_back(io::real_data_path(file));
    if (paths.back().empty()) GTEST_SKIP() << "no real data beside the project (OVOID_DATA)";
  }
  KernelModelOptions model;
  model.array = set.array;
  Dataset dataset;
  try {
    dataset = read_dataset(paths);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kUnsupported) GTEST_SKIP() << error.what();
    throw;
  }
  const KernelField field = make_kernel_field(dataset, model);
  const ValueRange range = usual_values(field);
  bool odd = false;
  for (const TestLook& look : test_looks(range.lo, range.hi)) {
    odd = !odd;
    for (const bool is_parallel : {true, false}) {
      if (is_parallel != odd && !is_nightly()) continue;  // the reference takes half a second each
      TestScene scene{field, askew_camera(field, is_parallel), look.look, picture(48, 42)};
      scene.options.post_convolution = PostConvolution::kOff;
      EXPECT_TRUE(backends_agree(scene, set.files[0] + ", " + look.name, 0.004));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Files, RealSets, testing::Range<std::size_t>(0, 5));

}  // namespace real_sets_test
}  // namespace ovoid::test
