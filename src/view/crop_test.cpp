// SPDX-License-Identifier: Apache-2.0
#include "ovoid/crop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "ovoid/error.h"
#include "ovoid/renderer.h"
#include "support/volumes.h"

namespace ovoid {
namespace crop_test {

constexpr double kCropInfinity = std::numeric_limits<double>::infinity();

LatticeGeometry cropped_lattice(const Affine3& axes) { return {{10, 12, 14}, axes}; }

bool is_kept(const std::vector<ClipPlane>& planes, const Vec3& world) {
  return std::all_of(planes.begin(), planes.end(), [&](const ClipPlane& plane) {
    return plane.normal.dot(world) >= plane.offset;
  });
}

std::string refusal_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "not refused";
}

// Fails if a face lies anywhere but half a spacing beyond the last sample, in oblique and
// left-handed axes, too.
TEST(Crop, IndexPlanesKeepTheCellsOfTheSamples) {
  const LatticeGeometry lattice = cropped_lattice(test::oblique_axes());
  const auto planes = crop_planes(lattice, {2, 3, 4}, {5, 6, 7});
  EXPECT_EQ(planes.size(), 6U);
  const Vec3 middle(3.5, 4.5, 5.5);
  for (int a = 0; a < 3; ++a) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 inside = middle;
      inside[a] += side * 1.999;
      Vec3 outside = middle;
      outside[a] += side * 2.001;
      EXPECT_TRUE(is_kept(planes, lattice.world_from_index * inside)) << a << ' ' << side;
      EXPECT_FALSE(is_kept(planes, lattice.world_from_index * outside)) << a << ' ' << side;
    }
  }
}

// Fails if planes are spent where nothing is cut: a sum's fringe would go, too.
TEST(Crop, FacesOfTheLatticeAndInfinityTakeNoPlane) {
  const LatticeGeometry lattice = cropped_lattice(Affine3::Identity());
  EXPECT_TRUE(crop_planes(lattice, {0, 0, 0}, {9, 11, 13}).empty());
  EXPECT_EQ(crop_planes(lattice, {0, 1, 0}, {9, 11, 12}).size(), 2U);
  const Bounds3 endless(Vec3::Constant(-kCropInfinity), Vec3::Constant(kCropInfinity));
  EXPECT_TRUE(crop_planes(endless).empty());
  EXPECT_EQ(crop_planes(Bounds3(Vec3(0, -kCropInfinity, 1), Vec3::Constant(kCropInfinity))).size(),
            2U);
}

TEST(Crop, WorldPlanesKeepTheBox) {
  const auto planes = crop_planes(Bounds3(Vec3(-1, -2, -3), Vec3(1, 2, 3)));
  EXPECT_EQ(planes.size(), 6U);
  EXPECT_TRUE(is_kept(planes, Vec3(0.999, -1.999, 2.999)));
  for (int a = 0; a < 3; ++a) {
    EXPECT_FALSE(is_kept(planes, (a + 1.001) * Vec3::Unit(a)));
    EXPECT_FALSE(is_kept(planes, -(a + 1.001) * Vec3::Unit(a)));
  }
}

TEST(Crop, BoxesAreWhatIsLeft) {
  const LatticeGeometry oblique = cropped_lattice(test::oblique_axes());
  const Box box = crop_box(oblique, {2, 0, 4}, {5, 11, 4});
  EXPECT_EQ(box.bounds.min(), Vec3(1.5, -0.5, 3.5));
  EXPECT_EQ(box.bounds.max(), Vec3(5.5, 11.5, 4.5));
  EXPECT_TRUE(box.world_from_box.isApprox(oblique.world_from_index));
  EXPECT_TRUE(box_of(oblique).world_bounds().isApprox(oblique.world_bounds()));

  // Axes that run backwards: the world's box in the lattice's own.
  const LatticeGeometry turned = cropped_lattice(test::scaled_axes(Vec3(-2, 1, 1)));
  const Bounds3 half(Vec3(-8, -kCropInfinity, 0), Vec3(kCropInfinity, 5, kCropInfinity));
  const Box part = crop_box(turned, half);
  EXPECT_TRUE(part.bounds.min().isApprox(Vec3(-0.5, -0.5, 0)));
  EXPECT_TRUE(part.bounds.max().isApprox(Vec3(4, 5, 13.5)));
  EXPECT_TRUE(part.world_bounds().min().isApprox(Vec3(-8, -0.5, 0)));

  // Oblique: the world's axes.
  const Bounds3 whole = oblique.world_bounds();
  const Box common = crop_box(oblique, Bounds3(whole.center(), Vec3::Constant(1e9)));
  EXPECT_TRUE(common.world_from_box.isApprox(Affine3::Identity()));
  EXPECT_TRUE(common.bounds.min().isApprox(whole.center()));
  EXPECT_TRUE(common.bounds.max().isApprox(whole.max()));
}

TEST(Crop, RefusesWhatIsEmptyOrOutside) {
  const LatticeGeometry lattice = cropped_lattice(Affine3::Identity());
  EXPECT_EQ(refusal_of([&] {
              crop_planes(lattice, {0, 5, 0}, {9, 4, 13});
            }),
            "crop j = 5:4: must not be empty");
  EXPECT_EQ(refusal_of([&] {
              crop_box(lattice, {0, 0, 0}, {9, 11, 14});
            }),
            "crop k = 0:14: must lie within the data's samples 0 to 13");
  EXPECT_EQ(refusal_of([&] {
              crop_box(lattice, {-1, 0, 0}, {9, 11, 13});
            }),
            "crop i = -1:9: must lie within the data's samples 0 to 9");
  EXPECT_EQ(refusal_of([] { crop_planes(Bounds3(Vec3(0, 0, 0), Vec3(1, 0, 1))); }),
            "crop-world y = 0:0: must not be empty");
  EXPECT_EQ(refusal_of([&] { crop_box(lattice, Bounds3(Vec3(0, 0, 20), Vec3(1, 1, 30))); }),
            "crop-world z = 20:30: must meet the data, which lies from -0.5 to 13.5");
}

// Fails if cropping changes the field near the cut, as copying a part would: there the kernels of
// samples beyond it still count.
TEST(Crop, TheFieldIsTheSameAsUncropped) {
  const LatticeField field =
      test::make_field({9, 9, 9}, [](auto i, auto, auto) { return i < 5 ? 0 : 1; });
  Camera camera;
  camera.position = Vec3(4, 4, 30);
  camera.focal_point = Vec3(4, 4, 4);
  camera.parallel_projection = true;
  camera.parallel_scale = 5;
  Look look = ramp_look({0, 1});
  look.mode = Mode::kMaximum;
  RenderOptions options;
  options.width = options.height = 40;  // a quarter of a spacing
  options.sheets = Sheets::kImage;
  Renderer renderer(Backend::kReference, 1);
  const Image whole = renderer.render({field, look}, camera, options).image;
  options.clip_planes = crop_planes(field.geometry(), {0, 0, 0}, {4, 8, 8});
  const Image part = renderer.render({field, look}, camera, options).image;
  for (int x = 0; x < 40; ++x) {
    // The pixel's middle in the world; the cut is at 4.5.
    const bool is_kept_here = (x + 0.5) / 4 - 1 < 4.5;
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t at = 4U * (20U * 40U + static_cast<std::size_t>(x)) + c;
      EXPECT_EQ(part.rgba[at], is_kept_here ? whole.rgba[at] : 0.0F) << x << ' ' << c;
    }
  }
  // In the last kept column the field rises to the sample beyond the cut; a copy would be 0 here.
  EXPECT_GT(part.rgba[4U * (20U * 40U + 21U) + 3U], 0.1F);
}

// Fails if the normal's length or the offset's sign is lost.
TEST(Crop, ThickSlicesLieAroundTheirPlane) {
  const auto planes = slice_planes({{0, 0, -2}, -6}, 1);  // z = 3
  const auto is_left = [&](double z) {
    return std::all_of(planes.begin(), planes.end(), [&](const ClipPlane& plane) {
      return plane.normal.dot(Vec3(7, -9, z)) >= plane.offset;
    });
  };
  EXPECT_TRUE(is_left(2.51) && is_left(3) && is_left(3.49));
  EXPECT_FALSE(is_left(2.49) || is_left(3.51));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto refusal = [](const ClipPlane& middle, double thickness) -> std::string {
    try {
      slice_planes(middle, thickness);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      return error.what();
    }
    return "";
  };
  const ClipPlane middle{{0, 0, 1}, 0};
  for (const double thickness : {0.0, -1.0, kNan, kCropInfinity})
    EXPECT_NE(refusal(middle, thickness).find("slice thickness = "), std::string::npos);
  for (const Vec3& normal : {Vec3(0, 0, 0), Vec3(kNan, 0, 0), Vec3(kCropInfinity, 0, 0)})
    EXPECT_NE(refusal({normal, 0}, 1).find("slice normal: "), std::string::npos);
  EXPECT_NE(refusal({{1, 0, 0}, kNan}, 1).find("slice offset: "), std::string::npos);
}

}  // namespace crop_test
}  // namespace ovoid
