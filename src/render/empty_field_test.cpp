// SPDX-License-Identifier: Apache-2.0
// Fails if a function that takes a field reads through the null source of an empty one.
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/coarse.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"
#include "support/scenes.h"
#include "support/volumes.h"

namespace ovoid {
namespace empty_field_test {

void expect_refused(const char* what, const std::function<void()>& work) {
  SCOPED_TRACE(what);
  try {
    work();
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_EQ(std::string(error.what()).rfind("field: is empty", 0), 0U) << error.what();
  }
}

// Empty from the start, and because they were moved from.
std::vector<Field> empty_fields() {
  LatticeField full = test::constant_field({2, 2, 2}, 1);
  const LatticeField other = std::move(full);
  return {Field(), KernelField(), full};  // NOLINT(bugprone-use-after-move): what is tested
}

TEST(EmptyField, IsRefusedByName) {
  const LatticeGeometry lattice{{2, 2, 2}};
  const Camera camera = test::parallel_camera({0, 0, 0}, {0, 0, 1}, 1);
  const RenderOptions options = test::picture(4, 4);
  for (const Field& field : empty_fields()) {
    for (const Backend backend : {Backend::kAuto, Backend::kCpu, Backend::kReference}) {
      Renderer renderer(backend, 1);
      expect_refused("render", [&] { renderer.render({field, {}}, camera, options); });
      Scene moving(field, {});
      moving.volumes.front().trail = std::make_shared<Trail>();
      expect_refused("with a trail", [&] { renderer.render(moving, camera, options); });
      Scene cut(field, {});
      cut.plane.emplace();
      expect_refused("with a value plane", [&] { renderer.render(cut, camera, options); });
    }
    expect_refused("FieldSampler", [&] { FieldSampler{field}; });
    expect_refused("FieldProbe", [&] { FieldProbe{field}; });
    expect_refused("resample", [&] { resample(field, lattice); });
    expect_refused("coarse_field", [&] { coarse_field(field); });
    expect_refused("default_look", [&] { default_look(field); });
    expect_refused("default_unit_distance", [&] { default_unit_distance(field); });
    expect_refused("holds_labels", [&] { holds_labels(field); });
    expect_refused("materials_of", [&] { materials_of(field); });
  }
  expect_refused("KernelSampler", [] { KernelSampler{KernelField()}; });
  expect_refused("make_kernel_dataset", [] { make_kernel_dataset(KernelField()); });
}

TEST(EmptyField, HasNothingInIt) {
  for (const Field& field : empty_fields()) {
    EXPECT_TRUE(field.is_empty());
    EXPECT_EQ(field.num_kernels(), 0);
    EXPECT_EQ(field.resident_bytes(), 0U);
    EXPECT_TRUE(field.world_bounds().isEmpty());
    EXPECT_GT(field.default_sampling_distance(), 0);
  }
  EXPECT_TRUE(Field().value_range().is_empty());
  EXPECT_FALSE(Field(test::constant_field({2, 2, 2}, 1)).is_empty());
}

}  // namespace empty_field_test
}  // namespace ovoid
