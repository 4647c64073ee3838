// SPDX-License-Identifier: Apache-2.0
#include "ovoid/look.h"

#include <gtest/gtest.h>

#include <functional>

#include "ovoid/error.h"
#include "support/numbers.h"

namespace ovoid {
namespace {

Look valid() {
  Look look = ramp_look({0.0F, 255.0F});
  look.transfer_function.unit_distance = 2.0;
  look.light_direction = Vec3(0, 0, 1);
  return look;
}

// Fails if a member is not looked at, or if the message does not name it.
TEST(Look, ValidateNamesTheMember) {
  valid().validate();
  Look().validate();
  struct Row {
    const char* named;
    std::function<void(Look&)> spoil;
  };
  const Row rows[] = {
      {"colors[1].x = nan", [](Look& l) { l.transfer_function.colors[1].x = kNan; }},
      {"colors[2].x = 0", [](Look& l) { l.transfer_function.colors[2].x = 0; }},
      {"colors[0].rgb[2] = 1.5", [](Look& l) { l.transfer_function.colors[0].rgb[2] = 1.5; }},
      {"opacities[1].x = -1", [](Look& l) { l.transfer_function.opacities[1].x = -1; }},
      {"opacities[0].x = -inf", [](Look& l) { l.transfer_function.opacities[0].x = -kInfinity; }},
      {"opacities[1].opacity = 2", [](Look& l) { l.transfer_function.opacities[1].opacity = 2; }},
      {"opacities[1].opacity = nan",
       [](Look& l) { l.transfer_function.opacities[1].opacity = kNan; }},
      {"opacities[0].midpoint = -0.5",
       [](Look& l) { l.transfer_function.opacities[0].midpoint = -0.5; }},
      {"opacities[0].sharpness = 3",
       [](Look& l) { l.transfer_function.opacities[0].sharpness = 3; }},
      {"nan_color[1]", [](Look& l) { l.transfer_function.nan_color[1] = -1; }},
      {"span = inf",
       [](Look& l) {
         l.transfer_function.opacities = {{-1e308, 0}, {1e308, 1}};
       }},
      {"transfer function unit_distance = 0",
       [](Look& l) { l.transfer_function.unit_distance = 0; }},
      {"isovalue", [](Look& l) { l.isovalue = kNan; }},
      {"ambient = -1", [](Look& l) { l.material.ambient = -1; }},
      {"diffuse", [](Look& l) { l.material.diffuse = kInfinity; }},
      {"specular = nan", [](Look& l) { l.material.specular = kNan; }},
      {"specular_power = 0", [](Look& l) { l.material.specular_power = 0; }},
      {"light_direction = (0, 0, 0)", [](Look& l) { l.light_direction = Vec3(0, 0, 0); }},
      {"light_direction", [](Look& l) { l.light_direction = Vec3(0, kNan, 1); }},
      {"unit_distance = -1", [](Look& l) { l.unit_distance = -1; }},
  };
  for (const Row& row : rows) {
    Look look = valid();
    row.spoil(look);
    try {
      look.validate();
      ADD_FAILURE() << "accepted: " << row.named;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_NE(std::string(error.what()).find(row.named), std::string::npos) << error.what();
    }
  }
}

TEST(RampLook, RisesOverTheRange) {
  const Look look = ramp_look({-1000.0F, 3071.0F}, "inferno");
  look.validate();
  const TransferFunction& tf = look.transfer_function;
  EXPECT_EQ(tf.lo(), -1000.0);
  EXPECT_EQ(tf.hi(), 3071.0);
  EXPECT_EQ(tf.opacity_at(-1000), 0.0);
  EXPECT_EQ(tf.opacity_at(3071), 0.5);
  EXPECT_EQ(tf.name, "inferno");
  EXPECT_EQ(tf.color_at(-1000), color_map("inferno").color_at(0));
  EXPECT_EQ(look.unit_distance, 0.0);
}

// Fails if a field of one value is invisible, or if no range can be built about it in single
// precision.
TEST(RampLook, ShowsAConstantField) {
  for (const float value : {0.0F, 100.0F, -1e30F, 1e-20F}) {
    const Look look = ramp_look({value, value});
    look.validate();
    EXPECT_NEAR(look.transfer_function.opacity_at(value), 0.25, 1e-12) << value;
  }
}

TEST(RampLook, OfNoValuesIsOverZeroToOne) {
  const Look look = ramp_look(ValueRange());
  look.validate();
  EXPECT_EQ(look.transfer_function.lo(), 0.0);
  EXPECT_EQ(look.transfer_function.hi(), 1.0);
}

}  // namespace
}  // namespace ovoid
