// SPDX-License-Identifier: Apache-2.0
#include "ovoid/look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>
#include <string>

#include "ovoid/error.h"
#include "support/numbers.h"

namespace ovoid {
namespace look_test {

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
      {"isosurfaces[1].value = 3: must differ",
       [](Look& l) {
         l.isosurfaces = {{3}, {3}};
       }},
      {"isosurfaces[0].value = nan", [](Look& l) { l.isosurfaces = {{kNan}}; }},
      {"isosurfaces[0].opacity = 1.5",
       [](Look& l) {
         l.isosurfaces = {{1, {}, 1.5}};
       }},
      {"isosurfaces[0].color[2]",
       [](Look& l) {
         l.isosurfaces = {{1, Rgb{0, 0, -1}}};
       }},
      {"isosurfaces: 17, must be at most 16", [](Look& l) { l.isosurfaces.resize(17); }},
      {"nan_color[1]", [](Look& l) { l.transfer_function.nan_color[1] = -1; }},
      {"below_color[2] = 1.25",
       [](Look& l) {
         l.transfer_function.below_color = Rgb{0, 0, 1.25};
       }},
      {"above_color[0] = nan",
       [](Look& l) {
         l.transfer_function.above_color = Rgb{kNan, 0, 0};
       }},
      {"colors[0].x = 0: must be > 0 on a logarithmic scale",
       [](Look& l) { l.transfer_function.scale = ValueScale::kLog; }},
      {"opacities[0].x = -2: must be > 0 on a logarithmic scale",
       [](Look& l) {
         l.transfer_function.colors.clear();
         l.transfer_function.opacities = {{-2, 0}, {1, 1}};
         l.transfer_function.scale = ValueScale::kLog;
       }},
      {"linear_width = 0", [](Look& l) { l.transfer_function.linear_width = 0; }},
      {"linear_width = inf", [](Look& l) { l.transfer_function.linear_width = kInfinity; }},
      {"gradient_opacities[0].x = -1: must be >= 0",
       [](Look& l) {
         l.transfer_function.gradient_opacities = {{-1, 0}, {1, 1}};
       }},
      {"gradient_opacities[1].x = 1",
       [](Look& l) {
         l.transfer_function.gradient_opacities = {{2, 0}, {1, 1}};
       }},
      {"gradient_opacities[0].opacity = 2",
       [](Look& l) {
         l.transfer_function.gradient_opacities = {{0, 2}};
       }},
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
      {"further_lights: 5 given, at most 4", [](Look& l) { l.further_lights.resize(5); }},
      {"further_lights[1].direction = (0, 0, 0)",
       [](Look& l) {
         l.further_lights = {{}, {Vec3::Zero(), 1}};
       }},
      {"further_lights[0].direction",
       [](Look& l) {
         l.further_lights = {{Vec3(1, kInfinity, 0), 1}};
       }},
      {"further_lights[0].intensity = -1",
       [](Look& l) {
         l.further_lights = {{Vec3(1, 0, 0), -1}};
       }},
      {"further_lights[0].intensity = nan",
       [](Look& l) {
         l.further_lights = {{Vec3(1, 0, 0), kNan}};
       }},
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

// ---- presets

TEST(LookPreset, EveryNameIsAValidLook) {
  for (const std::string& name : look_preset_names()) {
    const Look look = look_preset(name, {10.0F, 20.0F});
    look.validate();
    EXPECT_EQ(look.transfer_function.name, name);
    EXPECT_FALSE(look.transfer_function.unit_distance) << name;
    double greatest = 0;
    for (const OpacityPoint& p : look.transfer_function.opacities) {
      greatest = std::max(greatest, p.opacity);
    }
    EXPECT_GT(greatest, 0.05) << name;
    EXPECT_EQ(look.transfer_function.opacities.front().opacity, 0.0) << name;
  }
  try {
    look_preset("ct-bones");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("ct-bone ct-skin"), std::string::npos);
  }
}

// Fails if CT looks move with the data, or MR ones do not.
TEST(LookPreset, CtIsAbsoluteAndMrIsRelative) {
  for (const std::string& name : look_preset_names()) {
    const TransferFunction near = look_preset(name, {0.0F, 1.0F}).transfer_function;
    const TransferFunction far = look_preset(name, {100.0F, 200.0F}).transfer_function;
    if (name.starts_with("mr-") || name == kCinematicPreset) {
      EXPECT_EQ(far.lo(), 100.0) << name;
      EXPECT_EQ(far.hi(), 200.0) << name;
      EXPECT_NEAR(far.opacity_at(150), near.opacity_at(0.5), 1e-12) << name;
    } else {
      EXPECT_EQ(far.lo(), near.lo()) << name;
      EXPECT_EQ(far.hi(), near.hi()) << name;
    }
  }
  look_preset("mr-default", {5.0F, 5.0F}).validate();
  look_preset("mr-default").validate();
}

TEST(LookPreset, LabelsAreDistinctAndBackgroundShowsNothing) {
  const TransferFunction tf = look_preset("label").transfer_function;
  EXPECT_EQ(tf.opacity_at(0), 0.0);
  EXPECT_EQ(tf.opacity_at(0.4), 0.0);
  std::set<Rgb> colors;
  for (int label = 1; label <= 256; ++label) {
    EXPECT_NEAR(tf.opacity_at(label), 0.9, 1e-15);
    colors.insert(tf.color_at(label));
    EXPECT_EQ(tf.color_at(label - 0.4), tf.color_at(label + 0.4));
  }
  EXPECT_EQ(colors.size(), 256U);
}

// Beyond 256 labels colours begin again, beyond 2000 numbers share them, all show as far as the
// data go, and 0 stays clear of it.
TEST(LookPreset, LabelsReachAsFarAsTheData) {
  const TransferFunction few = look_preset("label").transfer_function;
  const TransferFunction some = look_preset("label", {0.0F, 1900.0F}).transfer_function;
  for (const int label : {1, 2, 255, 256, 257, 1900}) {
    EXPECT_EQ(some.color_at(label), few.color_at((label - 1) % 256 + 1)) << label;
    EXPECT_EQ(some.opacity_at(label), 0.5) << label;
  }
  for (const double greatest : {2001.0, 65535.0, 16777216.0, 3e9}) {
    const Look look = look_preset("label", {0.0F, static_cast<float>(greatest)});
    look.validate();
    const TransferFunction& tf = look.transfer_function;
    EXPECT_LE(tf.colors.size(), 2U * 2001U);
    EXPECT_EQ(tf.opacity_at(0.4), 0.0);
    EXPECT_EQ(tf.opacity_at(1), 0.5);
    EXPECT_EQ(tf.opacity_at(greatest), 0.5);
    EXPECT_EQ(tf.color_at(1), few.color_at(1));
    EXPECT_EQ(tf.color_at(0.6), few.color_at(1));
    // Each five hundredth of the way has another colour than the next.
    const double most = std::min(greatest, 16777216.0);
    for (int i = 1; i < 500; ++i)
      EXPECT_NE(tf.color_at(most * i / 500), tf.color_at(most * (i + 1) / 500)) << i;
  }
}

}  // namespace look_test
}  // namespace ovoid
