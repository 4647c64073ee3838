// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ovoid/look.h"
#include "support/agreement.h"
#include "support/kernel_sets.h"
#include "support/volumes.h"
#include "support/where.h"
#include "view/look/ciede2000.h"
#include "view/look/color_spaces.h"
#include "view/look/field_samples.h"
#include "view/look/look_table.h"

namespace ovoid {
namespace default_look_test {

// Noise in [-1, 1] that depends on place and seed alone.
double default_look_noise(std::int64_t i, std::int64_t j, std::int64_t k, int seed) {
  auto x = static_cast<std::uint64_t>(i + 1000 * j + 1000000 * k + 7919L * seed);
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1p-52 - 1.0;
}

constexpr std::int64_t kSide = 48;

double radius_at(std::int64_t i, std::int64_t j, std::int64_t k) {
  const double c = 0.5 * (kSide - 1);
  return std::hypot(static_cast<double>(i) - c, static_cast<double>(j) - c,
                    static_cast<double>(k) - c);
}

// A dense core in a thin shell in a noisy background, as scans have them.
LatticeField scan(double noise, int seed = 1, double factor = 1.0) {
  return test::make_field({kSide, kSide, kSide},
                          [=](std::int64_t i, std::int64_t j, std::int64_t k) {
                            const double r = radius_at(i, j, k);
                            const double value = r < 8 ? 200.0 : r < 18 ? 80.0 : 10.0;
                            return factor * (value + noise * default_look_noise(i, j, k, seed));
                          });
}

double opacity_at(const Look& look, double value) {
  return look.transfer_function.opacity_at(value);
}

TEST(DefaultLook, ScanHasATransparentBackgroundAThinShellAndADenseCore) {
  OVOID_NOT_UNDER_TSAN();
  const Look look = default_look(scan(2.0));
  look.validate();
  for (const double background : {8.0, 10.0, 12.0}) EXPECT_EQ(opacity_at(look, background), 0.0);
  EXPECT_GT(opacity_at(look, 80), 0.05);
  EXPECT_GT(opacity_at(look, 200), 2 * opacity_at(look, 80));
  EXPECT_TRUE(look.shade);
}

TEST(DefaultLook, FollowsTheDataWhateverTheirUnit) {
  OVOID_NOT_UNDER_TSAN();
  const Look plain = default_look(scan(2.0));
  for (const double factor : {1e-12, 1e12}) {
    const Look scaled = default_look(scan(2.0, 1, factor));
    for (const double value : {10.0, 50.0, 80.0, 120.0, 200.0}) {
      EXPECT_NEAR(opacity_at(scaled, value * factor), opacity_at(plain, value), 1e-3)
          << value << " x " << factor;
    }
  }
}

// Other noise of the same strength, and a hundredth more of it, move no point of the curves by more
// than 3 % of the range.
TEST(DefaultLook, IsStableUnderSmallChanges) {
  OVOID_NOT_UNDER_TSAN();
  const TransferFunction first = default_look(scan(2.0)).transfer_function;
  for (const auto& [noise, seed] : {std::pair{2.0, 2}, {2.0, 3}, {2.02, 1}, {2.2, 5}}) {
    const TransferFunction other = default_look(scan(noise, seed)).transfer_function;
    ASSERT_EQ(first.opacities.size(), other.opacities.size());
    ASSERT_EQ(first.colors.size(), other.colors.size());
    for (std::size_t i = 0; i < first.opacities.size(); ++i) {
      EXPECT_NEAR(first.opacities[i].x, other.opacities[i].x, 0.03 * 190) << "point " << i;
      EXPECT_NEAR(first.opacities[i].opacity, other.opacities[i].opacity, 0.01) << "point " << i;
    }
    for (std::size_t i = 0; i < first.colors.size(); ++i)
      EXPECT_NEAR(first.colors[i].x, other.colors[i].x, 0.03 * 190) << "point " << i;
  }
}

// Five deviations of the noise would hide the shell with it.
TEST(DefaultLook, NoiseDoesNotHideWhatStandsOutOfIt) {
  OVOID_NOT_UNDER_TSAN();
  const Look look = default_look(scan(20.0));
  EXPECT_EQ(opacity_at(look, 10), 0.0);
  EXPECT_EQ(opacity_at(look, 30), 0.0);  // the noise reaches as far
  EXPECT_GT(opacity_at(look, 80), 0.0);
  EXPECT_GT(opacity_at(look, 200), opacity_at(look, 80));
}

// Light and steep curves would bring out nothing but the noise.
TEST(DefaultLook, NoiseIsDrawnSoft) {
  OVOID_NOT_UNDER_TSAN();
  const auto noise = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return (radius_at(i, j, k) < 15 ? 100.0 : 0.0) * (1.0 + default_look_noise(i, j, k, 1));
  };
  const auto object = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    const double r = radius_at(i, j, k);
    return 100.0 / (1 + std::exp(r - 15)) + 100.0 / (1 + std::exp(r - 8));
  };
  const Look soft = default_look(test::make_field({kSide, kSide, kSide}, noise));
  const Look crisp = default_look(test::make_field({kSide, kSide, kSide}, object));
  EXPECT_GT(soft.flat_rise, 5 * crisp.flat_rise);
  EXPECT_LT(opacity_at(soft, 190), 0.6 * opacity_at(crisp, 190));
  EXPECT_GT(opacity_at(soft, 100), 0.0);
}

// Light on a ramp tells where the light is.
TEST(DefaultLook, RampsHaveEvenLight) {
  OVOID_NOT_UNDER_TSAN();
  const auto ramp = [](std::int64_t i, std::int64_t j, std::int64_t) {
    return static_cast<double>(3 * i + j);
  };
  EXPECT_EQ(default_look(test::make_field({kSide, kSide, kSide}, ramp)).flat_rise, 1.0);
}

// A detector's bright pixel must not turn all else into background.
TEST(DefaultLook, SingleOddSamplesChangeLittle) {
  OVOID_NOT_UNDER_TSAN();
  const Look plain = default_look(scan(2.0));
  const Look odd = default_look(
      test::make_field({kSide, kSide, kSide}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        if (i == 20 && j == 20 && k == 20) return 1e6;
        const double r = radius_at(i, j, k);
        return (r < 8 ? 200.0 : r < 18 ? 80.0 : 10.0) + 2.0 * default_look_noise(i, j, k, 1);
      }));
  for (const double value : {10.0, 80.0, 200.0})
    EXPECT_NEAR(opacity_at(odd, value), opacity_at(plain, value), 0.05) << value;
}

TEST(DefaultLook, BrightBackgroundIsTheTransparentOne) {
  OVOID_NOT_UNDER_TSAN();
  const Look look = default_look(
      test::make_field({kSide, kSide, kSide}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        const double r = radius_at(i, j, k);
        return (r < 18 ? 60.0 : 250.0) + default_look_noise(i, j, k, 1);
      }));
  EXPECT_EQ(opacity_at(look, 250), 0.0);
  EXPECT_GT(opacity_at(look, 60), 0.1);
}

// Vorticity, potentials: both signs are the thing.
TEST(DefaultLook, SignedFieldsShowBothSides) {
  OVOID_NOT_UNDER_TSAN();
  const Look look = default_look(
      test::make_field({kSide, kSide, kSide}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        const double r = radius_at(i, j, k);
        return (i < kSide / 2 ? -1.0 : 1.0) * std::exp(-r * r / 60.0);
      }));
  EXPECT_EQ(opacity_at(look, 0), 0.0);
  EXPECT_GT(opacity_at(look, 0.8), 0.1);
  EXPECT_GT(opacity_at(look, -0.8), 0.1);
  const Rgb cold = look.transfer_function.color_at(-0.8);
  const Rgb warm = look.transfer_function.color_at(0.8);
  EXPECT_GT(cold[2], cold[0]);
  EXPECT_GT(warm[0], warm[2]);
}

// Fails if what a sum of kernels of both signs leaves where there is nothing is shown as a haze.
TEST(DefaultLook, SumsThatSwingAboutNothingShowNoHalo) {
  OVOID_NOT_UNDER_TSAN();
  test::KernelNumbers numbers = test::jittered_balls(10);
  std::vector<float>& values = numbers.values[0];
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] < 0.5F) values[i] = i % 2 == 0 ? 0.1F : -0.1F;
  }
  const KernelField field(numbers.source(), Reconstruction::kSum);
  const double swing = -static_cast<double>(field.value_range().lo);
  ASSERT_GT(swing, 0.01);
  const TransferFunction& tf = default_look(field).transfer_function;
  for (const double share : {-1.0, -0.5, 0.0, 0.5, 0.9})
    EXPECT_EQ(tf.opacity_at(share * swing), 0) << share;
  EXPECT_GT(tf.opacity_at(0.7), 0.05);
}

TEST(DefaultLook, FieldsWithoutABackgroundShowTheirUpperHalf) {
  OVOID_NOT_UNDER_TSAN();
  const Look look = default_look(test::make_field(
      {kSide, kSide, kSide},
      [](std::int64_t i, std::int64_t, std::int64_t) { return 3.0 * static_cast<double>(i); }));
  EXPECT_EQ(opacity_at(look, 3.0 * 10), 0.0);
  EXPECT_GT(opacity_at(look, 3.0 * 44), opacity_at(look, 3.0 * 30));
  EXPECT_GT(opacity_at(look, 3.0 * 30), 0.0);
}

// The colours of what is transparent would be of no use to anybody.
TEST(DefaultLook, FieldsWithoutABackgroundSpendTheirColoursOnWhatShows) {
  OVOID_NOT_UNDER_TSAN();
  const Look look = default_look(test::make_field(
      {kSide, kSide, kSide},
      [](std::int64_t i, std::int64_t, std::int64_t) { return 3.0 * static_cast<double>(i); }));
  const double median = 3.0 * (kSide - 1) / 2;
  EXPECT_NEAR(look.transfer_function.colors.front().x, median, 3.0);
  EXPECT_NEAR(look.transfer_function.opacities.front().x, median, 3.0);
}

// docs/looks.md, "The default look": bright, since light and background darken them, and apart.
TEST(DefaultLook, ColoursAreBrightAndApart) {
  OVOID_NOT_UNDER_TSAN();
  const auto shape = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    const double r = radius_at(i, j, k);
    return std::exp(-r * r / 100);
  };
  const Look looks[] = {
      default_look(test::make_field({kSide, kSide, kSide}, shape)),
      default_look(
          test::make_stored_field({kSide, kSide, kSide}, shape, {ScalarType::kUInt8, 0, 255})),
      default_look(KernelField(test::jittered_balls(8).source(), Reconstruction::kSum))};
  EXPECT_NE(looks[0].transfer_function.name, looks[1].transfer_function.name);
  EXPECT_FALSE(looks[2].shade);
  for (const Look& look : looks) {
    const auto& colors = look.transfer_function.colors;
    for (std::size_t i = 0; i < colors.size(); ++i) {
      const Rgb& rgb = colors[i].rgb;
      EXPECT_GE(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2], 0.5)
          << look.transfer_function.name << ", point " << i;
      if (i < 2) continue;
      const Rgb& other = colors[i - 2].rgb;
      EXPECT_GE(view::ciede2000(view::lab_from_rgb(rgb), view::lab_from_rgb(other)), 15)
          << look.transfer_function.name << ", points " << i - 2 << " and " << i;
    }
  }
}

// Shells of materials whose values are near each other: as far apart as main structures are to be,
// whichever map they are drawn with, and in the map's order. Fails where colours go by value alone:
// there neighbours are 4 to 9 apart.
TEST(DefaultLook, ColoursTellMaterialsApart) {
  OVOID_NOT_UNDER_TSAN();
  const std::vector<std::vector<double>> volumes = {
      {5, 180, 215}, {5, 60, 90, 210}, {3, 150, 190, 230}, {20, 200, 250}};
  for (const auto& values : volumes) {
    const auto shells = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      const double r = radius_at(i, j, k) + 0.3 * default_look_noise(i, j, k, 1);
      const auto inside = static_cast<std::size_t>(std::max(0.0, (23 - r) / 6) + (r < 23 ? 1 : 0));
      return (values[std::min(inside, values.size() - 1)] + default_look_noise(i, j, k, 2)) / 255;
    };
    const Look counted = default_look(
        test::make_stored_field({kSide, kSide, kSide}, shells, {ScalarType::kUInt8, 0, 255}));
    const Look measured = default_look(test::make_field({kSide, kSide, kSide}, shells));
    EXPECT_NE(counted.transfer_function.name, measured.transfer_function.name);
    for (const auto& [look, unit] : {std::pair(counted, 1.0), std::pair(measured, 1.0 / 255)}) {
      const TransferFunction& tf = look.transfer_function;
      for (std::size_t m = 2; m < values.size(); ++m) {
        const double apart = view::ciede2000(view::lab_from_rgb(tf.color_at(values[m - 1] * unit)),
                                             view::lab_from_rgb(tf.color_at(values[m] * unit)));
        EXPECT_GE(apart, 15) << tf.name << " " << values[m - 1] << " and " << values[m];
      }
      for (std::size_t i = 1; i < tf.colors.size(); ++i)
        EXPECT_LE(tf.colors[i - 1].x, tf.colors[i].x) << tf.name;
    }
  }
}

// Of a part that its background is no longer in sight of, scanners' data look like things, too.
TEST(DefaultLook, ACropOfAScanHasTheScansColours) {
  OVOID_NOT_UNDER_TSAN();
  const auto inside = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return 0.5 + 0.2 * std::sin(0.2 * static_cast<double>(i)) *
                     std::cos(0.15 * static_cast<double>(j + 2 * k));
  };
  const Look look = default_look(
      test::make_stored_field({kSide, kSide, kSide}, inside, {ScalarType::kUInt8, 0, 255}));
  EXPECT_EQ(look.transfer_function.name, "clay to ivory");
}

// Densities over decades: clusters in a void that is not empty.
TEST(DefaultLook, DensitiesOverDecadesGetALogarithm) {
  OVOID_NOT_UNDER_TSAN();
  const auto density = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    const double r = radius_at(i, j, k);
    return 1e-3 * std::pow(10.0, 0.3 * default_look_noise(i, j, k, 1)) +
           1e3 * std::exp(-r * r / 12);
  };
  const Look look = default_look(test::make_field({kSide, kSide, kSide}, density));
  look.validate();
  EXPECT_EQ(look.transfer_function.scale, ValueScale::kLog);
  EXPECT_EQ(opacity_at(look, 1e-3), 0.0);
  EXPECT_GT(opacity_at(look, 1.0), 0.02);
  EXPECT_GT(opacity_at(look, 500.0), opacity_at(look, 1.0));
  // What fades away to nothing does not.
  const Look fading = default_look(
      test::make_field({kSide, kSide, kSide}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return std::exp(-radius_at(i, j, k));
      }));
  EXPECT_EQ(fading.transfer_function.scale, ValueScale::kLinear);
}

LatticeField head_in_hounsfield_units() {
  return test::make_field(
      {kSide, kSide, kSide}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        const double r = radius_at(i, j, k);
        const double value = r < 14 ? 40.0 : r < 17 ? 900.0 : r < 20 ? 30.0 : -1000.0;
        return value + 5.0 * default_look_noise(i, j, k, 1);
      });
}

TEST(DefaultLook, HounsfieldUnitsShowBoneThroughFaintTissue) {
  OVOID_NOT_UNDER_TSAN();
  for (const char* const unit : {"HU", ""}) {
    const Look look = default_look(head_in_hounsfield_units(), unit);
    EXPECT_EQ(look.transfer_function.name, "CT in Hounsfield units");
    EXPECT_EQ(opacity_at(look, -1000), 0.0);
    EXPECT_GT(opacity_at(look, 900), 0.5);
    EXPECT_GT(opacity_at(look, 40), 0.0);
    EXPECT_LT(opacity_at(look, 40), 0.05);
  }
  EXPECT_NE(default_look(head_in_hounsfield_units(), "K").transfer_function.name,
            "CT in Hounsfield units");
}

// As scanners store them: whole numbers, water at 1024.
TEST(DefaultLook, RawCtIsHounsfieldUnitsMoved) {
  OVOID_NOT_UNDER_TSAN();
  EXPECT_EQ(value_of_water(head_in_hounsfield_units()), 0.0);
  EXPECT_EQ(value_of_water(head_in_hounsfield_units(), "HU"), 0.0);
  EXPECT_EQ(value_of_water(scan(2.0)), std::nullopt);
  const Field raw = test::make_stored_field(
      {kSide, kSide, kSide},
      [](std::int64_t i, std::int64_t j, std::int64_t k) {
        const double r = radius_at(i, j, k);
        const double value = r < 14 ? 40.0 : r < 17 ? 900.0 : r < 20 ? 30.0 : -1000.0;
        return (1024 + value + 5.0 * default_look_noise(i, j, k, 1)) / 65535;
      },
      {ScalarType::kUInt16, 0, 65535});
  EXPECT_EQ(value_of_water(raw), 1024.0);
  const Look moved = default_look(raw);
  const Look plain = default_look(head_in_hounsfield_units());
  for (const double value : {-1000.0, 40.0, 200.0, 900.0})
    EXPECT_NEAR(opacity_at(moved, value + 1024), opacity_at(plain, value), 1e-6) << value;
}

// In 8 bits nothing says where water is; air and bone are seen.
TEST(DefaultLook, AirAndBoneOfOtherScales) {
  OVOID_NOT_UNDER_TSAN();
  const auto ends = air_and_bone(scan(2.0));
  ASSERT_TRUE(ends);
  EXPECT_NEAR(ends->first, 10, 2);  // noise is in [-2, 2]
  EXPECT_NEAR(ends->second, 201, 2);
  EXPECT_EQ(air_and_bone(test::constant_field({8, 8, 8}, 3)), std::nullopt);
}

// Tissue with a bright tube in it, or with bright fat around it.
LatticeField bright_in_tissue(bool is_inside, double bright) {
  return test::make_field(
      {kSide, kSide, kSide}, [=](std::int64_t i, std::int64_t j, std::int64_t k) {
        const double r = radius_at(i, j, k);
        const double to_tube = std::hypot(static_cast<double>(i) - 27, static_cast<double>(j) - 22);
        const bool is_bright = is_inside ? to_tube < 2 && r < 14 : r > 18.5 && r < 20;
        const double value = is_bright ? bright : r < 20 ? 300.0 : 20.0;
        return value + 12.0 * default_look_noise(i, j, k, 1);
      });
}

TEST(DefaultLook, VesselsShowThroughTissue) {
  OVOID_NOT_UNDER_TSAN();
  const Look look = default_look(bright_in_tissue(true, 900));
  EXPECT_EQ(look.transfer_function.name, "vessels");
  EXPECT_EQ(opacity_at(look, 20), 0.0);
  EXPECT_GT(opacity_at(look, 300), 0.0);
  EXPECT_LT(opacity_at(look, 300), 0.05);
  EXPECT_GT(opacity_at(look, 880), 0.5);
  // Beside the background it is skin, and a little brighter than tissue anything.
  EXPECT_NE(default_look(bright_in_tissue(false, 900)).transfer_function.name, "vessels");
  EXPECT_NE(default_look(bright_in_tissue(true, 420)).transfer_function.name, "vessels");
}

LatticeField labels(const std::vector<double>& values) {
  return test::make_field({kSide, kSide, kSide},
                          [&](std::int64_t i, std::int64_t j, std::int64_t k) {
                            if (radius_at(i, j, k) > 20) return values[0];
                            const auto part = static_cast<std::size_t>(i * 3 / kSide);
                            return values[std::min(part + 1, values.size() - 1)];
                          });
}

TEST(DefaultLook, LabelsGetAColourEach) {
  OVOID_NOT_UNDER_TSAN();
  const LatticeField field = labels({0, 7, 2, 40});
  EXPECT_TRUE(holds_labels(field));
  const Look look = default_look(field);
  EXPECT_EQ(opacity_at(look, 0), 0.0);
  std::vector<Rgb> colors;
  for (const double label : {2.0, 7.0, 40.0}) {
    EXPECT_GE(opacity_at(look, label), 0.95) << label;
    const Rgb color = look.transfer_function.color_at(label);
    // Flat around the label, so that rounding changes nothing.
    EXPECT_EQ(color, look.transfer_function.color_at(label + 0.4)) << label;
    EXPECT_EQ(color, look.transfer_function.color_at(label - 0.4)) << label;
    for (const Rgb& other : colors) {
      EXPECT_GT(std::abs(color[0] - other[0]) + std::abs(color[1] - other[1]) +
                    std::abs(color[2] - other[2]),
                0.2);
    }
    colors.push_back(color);
  }
}

// The field passes through all values between two labels. What is passed must not show, or all
// labels would have the colour of the first: three quarters of the values between are clear.
TEST(DefaultLook, BetweenLabelsIsMostlyNothing) {
  OVOID_NOT_UNDER_TSAN();
  const Look look = default_look(labels({0, 7, 2, 40}));
  int num_clear = 0;
  for (int i = 0; i < 400; ++i) {
    if (opacity_at(look, 0.1 * i + 0.05) == 0.0) ++num_clear;
  }
  EXPECT_GT(num_clear, 300);
}

// Blocks of labels, each its own, a number times `stride`.
LatticeField many_labels(int stride) {
  return test::make_field({80, 64, 48}, [=](std::int64_t i, std::int64_t j, std::int64_t k) {
    const std::int64_t block = i / 4 + 20 * (j / 4 + 16 * (k / 4));
    return k < 4 ? 0.0 : static_cast<double>(1 + block * stride);
  });
}

// 3840 labels up to 65,000 and 20 million: neighbours differ, the background is clear, the cpu's
// table tells them as exact evaluation does.
TEST(DefaultLook, ManyLabelsGetColoursThatDiffer) {
  OVOID_NOT_UNDER_TSAN();
  const LatticeField field = many_labels(17);
  EXPECT_TRUE(holds_labels(field));
  const Look look = default_look(field);
  look.validate();
  const TransferFunction& tf = look.transfer_function;
  EXPECT_LE(tf.colors.size(), 2 * 2002);
  EXPECT_EQ(opacity_at(look, 0), 0.0);
  const view::LookTable table(tf);
  int num_pairs = 0;
  int num_alike = 0;
  for (int block = 400; block < 3800; ++block) {
    const double label = 1 + block * 17.0;
    EXPECT_EQ(opacity_at(look, label), 0.5);
    EXPECT_NEAR(table.at(static_cast<float>(label)).r, tf.color_at(label)[0], 1e-6) << label;
    for (const int step : {20, 320}) {  // beside and above
      const Rgb one = view::lab_from_rgb(tf.color_at(label));
      const Rgb other = view::lab_from_rgb(tf.color_at(label + step * 17.0));
      ++num_pairs;
      if (view::ciede2000(one, other) < 15) ++num_alike;
    }
  }
  EXPECT_LT(num_alike, num_pairs / 6);
  EXPECT_FALSE(holds_labels(many_labels(5300)));  // float tells them apart no longer
}

// A label keeps its colour where others are missing.
TEST(DefaultLook, AManyLabelsColourIsItsOwn) {
  OVOID_NOT_UNDER_TSAN();
  const auto with_gap = [](std::int64_t gap) {
    return test::make_field({80, 64, 16}, [=](std::int64_t i, std::int64_t j, std::int64_t k) {
      const std::int64_t block = i / 8 + 10 * (j / 8 + 8 * (k / 8));
      return block == gap ? 0.0 : static_cast<double>(block);
    });
  };
  const TransferFunction all = default_look(with_gap(-1)).transfer_function;
  const TransferFunction fewer = default_look(with_gap(20)).transfer_function;
  for (const double label : {5.0, 40.0, 100.0, 159.0})
    EXPECT_EQ(all.color_at(label), fewer.color_at(label)) << label;
}

// Whole numbers in plenty, but smooth: what scans are.
TEST(DefaultLook, ScansInWholeNumbersAreNoLabels) {
  OVOID_NOT_UNDER_TSAN();
  const Field field =
      test::make_stored_field({kSide, kSide, kSide},
                              [](std::int64_t i, std::int64_t j, std::int64_t k) {
                                return 1.0 / (1.0 + std::exp(0.5 * (radius_at(i, j, k) - 15)));
                              },
                              {ScalarType::kUInt16, 0, 4000});
  EXPECT_FALSE(holds_labels(field));
}

// Of many samples rounding leaves stretches of the same number with steps of one between, which are
// as sharp as those of labels. Where the field is steep it differs by more, and is flat nowhere.
TEST(DefaultLook, SmoothFieldsOfManySamplesAreNoLabels) {
  OVOID_NOT_UNDER_TSAN();
  constexpr std::int64_t kLong = 512, kOther = 64;
  const auto place = [](std::int64_t i, std::int64_t count) {
    return 2.0 * static_cast<double>(i) / static_cast<double>(count - 1) - 1;
  };
  const Field field = test::make_field(
      {kLong, kOther, kOther}, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        const double x = place(i, kLong), y = place(j, kOther), z = place(k, kOther);
        const double ripples = std::sin(14 * x) * std::sin(14 * y) * std::sin(14 * z);
        return std::floor(220 * std::exp(-2.5 * (x * x + y * y + z * z)) * (0.7 + 0.3 * ripples));
      });
  EXPECT_FALSE(holds_labels(field));
}

TEST(DefaultLook, OtherIntegersAreNoLabels) {
  OVOID_NOT_UNDER_TSAN();
  EXPECT_FALSE(holds_labels(labels({0, 7.5, 2})));     // not an integer
  EXPECT_FALSE(holds_labels(labels({-1000, 0, 40})));  // CT
  EXPECT_FALSE(holds_labels(test::make_field(          // quantized, but no regions
      {kSide, kSide, kSide}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return std::floor(10 + 5 * default_look_noise(i, j, k, 1));
      })));
}

TEST(DefaultLook, FieldsOfOneValueGetTheRamp) {
  OVOID_NOT_UNDER_TSAN();
  const Look look = default_look(test::constant_field({8, 8, 8}, 5.0));
  EXPECT_EQ(opacity_at(look, 5), 0.25);
  look.validate();
}

TEST(DefaultLook, TinyFieldsAreNoTrouble) {
  OVOID_NOT_UNDER_TSAN();
  for (const Index3& dims : {Index3{1, 1, 1}, Index3{2, 1, 1}, Index3{2, 2, 2}, Index3{5, 5, 1}}) {
    const Look look =
        default_look(test::make_field(dims, [](std::int64_t i, std::int64_t j, std::int64_t k) {
          return static_cast<double>(i - k) + 0.3 * static_cast<double>(j);
        }));
    look.validate();
    EXPECT_GT(opacity_at(look, 4), 0.0);
  }
}

TEST(FieldSamples, AreSpreadOverAllOfAFieldAndLimited) {
  const Index3 dims{200, 150, 100};
  const LatticeField field =
      test::make_field(dims, [](std::int64_t i, std::int64_t j, std::int64_t k) {
        return static_cast<double>(i + 200 * (j + 150 * k));
      });
  const data::FieldSamples samples = data::take_samples(field.samples());
  EXPECT_NEAR(static_cast<double>(samples.values.size()), 3e6 / std::ceil(3e6 / (1 << 18)), 5000);
  for (const double q : {0.0, 0.1, 0.5, 0.9, 1.0})
    EXPECT_NEAR(view::quantile(samples.values, q), q * 3e6, 0.003 * 3e6) << q;
  EXPECT_EQ(samples.share_of_equals, 0.0);
}

}  // namespace default_look_test
}  // namespace ovoid
