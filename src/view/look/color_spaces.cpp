// SPDX-License-Identifier: Apache-2.0
#include "view/look/color_spaces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ovoid::view {
namespace {

constexpr double kPi = std::numbers::pi;

// CIE XYZ of the D65 white, and the matrices of IEC 61966-2-1 (four digits, as everybody has them).
constexpr Rgb kWhite{0.9505, 1.0, 1.089};
constexpr double kXyzFromRgb[3][3] = {
    {0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};
constexpr double kRgbFromXyz[3][3] = {
    {3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}};

// CIE 15: the cube root is continued by a straight line below this.
constexpr double kLabLinear = 0.008856;
constexpr double kLabSlope = 7.787;
constexpr double kLabOffset = 16.0 / 116.0;

Rgb product(const double (&m)[3][3], const Rgb& v) {
  Rgb out;
  for (int i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}

Rgb mix(const Rgb& a, const Rgb& b, double s) {
  return {(1 - s) * a[0] + s * b[0], (1 - s) * a[1] + s * b[1], (1 - s) * a[2] + s * b[2]};
}

double linear_from_srgb(double v) {
  return v > 0.04045 ? std::pow((v + 0.055) / 1.055, 2.4) : v / 12.92;
}

double srgb_from_linear(double v) {
  return v > 0.0031308 ? 1.055 * std::pow(v, 1.0 / 2.4) - 0.055 : 12.92 * v;
}

// Lab in polar coordinates about black: magnitude, saturation (angle from the gray axis), hue.
struct Msh {
  double m = 0, s = 0, h = 0;
};

// Below these a colour counts as black or gray, and the angle as unknown.
constexpr double kNoMagnitude = 0.001;
constexpr double kNoSaturation = 0.001;

Msh msh_from_lab(const Rgb& lab) {
  const double m = std::hypot(lab[0], lab[1], lab[2]);
  const double s = m > kNoMagnitude ? std::acos(std::min(lab[0] / m, 1.0)) : 0.0;
  return {m, s, s > kNoSaturation ? std::atan2(lab[2], lab[1]) : 0.0};
}

Rgb lab_from_msh(const Msh& c) {
  return {c.m * std::cos(c.s), c.m * std::sin(c.s) * std::cos(c.h),
          c.m * std::sin(c.s) * std::sin(c.h)};
}

double angle_between(double a, double b) {
  const double turn = std::fmod(std::abs(a - b), 2 * kPi);
  return std::min(turn, 2 * kPi - turn);
}

// The hue to give a gray end of magnitude `gray_m`, so that the way from `saturated` to it looks
// even [Moreland 2009, 4].
double spun_hue(const Msh& saturated, double gray_m) {
  if (saturated.m >= gray_m - 0.1) return saturated.h;
  const double spin = saturated.s * std::sqrt(gray_m * gray_m - saturated.m * saturated.m) /
                      (saturated.m * std::sin(saturated.s));
  return saturated.h > -0.3 * kPi ? saturated.h + spin : saturated.h - spin;  // away from purple
}

Rgb interpolate_diverging(const Rgb& rgb_a, const Rgb& rgb_b, double s) {
  constexpr double kSaturated = 0.05;  // radians: below, the hue does not show
  constexpr double kDistinctHue = 0.33 * kPi;
  constexpr double kWhiteMagnitude = 88.0;  // the least; (0.865, 0.865, 0.865)
  Msh a = msh_from_lab(lab_from_rgb(rgb_a));
  Msh b = msh_from_lab(lab_from_rgb(rgb_b));
  if (a.s > kSaturated && b.s > kSaturated && angle_between(a.h, b.h) > kDistinctHue) {
    const Msh white{std::max({a.m, b.m, kWhiteMagnitude}), 0, 0};
    if (s < 0.5) {
      b = white;
      s = 2 * s;
    } else {
      a = white;
      s = 2 * s - 1;
    }
  }
  if (a.s < kSaturated && b.s > kSaturated) {
    a.h = spun_hue(b, a.m);
  } else if (b.s < kSaturated && a.s > kSaturated) {
    b.h = spun_hue(a, b.m);
  }
  const Rgb msh = mix({a.m, a.s, a.h}, {b.m, b.s, b.h}, s);
  return rgb_from_lab(lab_from_msh({msh[0], msh[1], msh[2]}));
}

Rgb interpolate_hsv(const Rgb& rgb_a, const Rgb& rgb_b, double s, bool wrap) {
  Rgb a = hsv_from_rgb(rgb_a);
  Rgb b = hsv_from_rgb(rgb_b);
  if (wrap && std::abs(a[0] - b[0]) > 0.5) (a[0] > b[0] ? a[0] : b[0]) -= 1.0;
  Rgb hsv = mix(a, b, s);
  if (hsv[0] < 0.0) hsv[0] += 1.0;
  return rgb_from_hsv(hsv);
}

}  // namespace

Rgb lab_from_rgb(const Rgb& rgb) {
  const Rgb xyz = product(
      kXyzFromRgb, {linear_from_srgb(rgb[0]), linear_from_srgb(rgb[1]), linear_from_srgb(rgb[2])});
  Rgb f;
  for (int i = 0; i < 3; ++i) {
    const double v = xyz[i] / kWhite[i];
    f[i] = v > kLabLinear ? std::cbrt(v) : kLabSlope * v + kLabOffset;
  }
  return {116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])};
}

Rgb rgb_from_lab(const Rgb& lab) {
  const double y = (lab[0] + 16.0) / 116.0;
  const Rgb f{y + lab[1] / 500.0, y, y - lab[2] / 200.0};
  Rgb xyz;
  for (int i = 0; i < 3; ++i) {
    const double cube = f[i] * f[i] * f[i];
    xyz[i] = kWhite[i] * (cube > kLabLinear ? cube : (f[i] - kLabOffset) / kLabSlope);
  }
  Rgb rgb = product(kRgbFromXyz, xyz);
  for (double& v : rgb) v = srgb_from_linear(v);
  const double greatest = std::max({rgb[0], rgb[1], rgb[2], 1.0});
  for (double& v : rgb) v = std::max(v / greatest, 0.0);
  return rgb;
}

Rgb hsv_from_rgb(const Rgb& rgb) {
  const auto [r, g, b] = rgb;
  const double value = std::max({r, g, b});
  const double chroma = value - std::min({r, g, b});
  if (!(chroma > 0.0)) return {0.0, 0.0, value};
  double sextant = 0.0;
  if (r == value) {
    sextant = (g - b) / chroma;
  } else if (g == value) {
    sextant = 2.0 + (b - r) / chroma;
  } else {
    sextant = 4.0 + (r - g) / chroma;
  }
  const double hue = sextant / 6.0;
  return {hue < 0.0 ? hue + 1.0 : hue, chroma / value, value};
}

Rgb rgb_from_hsv(const Rgb& hsv) {
  const double turn = 6.0 * hsv[0];
  // The pure hue: each primary is at 1 over a third of the circle about itself and falls to 0 over
  // a sixth on either side.
  const Rgb pure{std::abs(turn - 3.0) - 1.0, 2.0 - std::abs(turn - 2.0),
                 2.0 - std::abs(turn - 4.0)};
  Rgb rgb;
  for (int i = 0; i < 3; ++i)
    rgb[i] = hsv[2] * (1.0 - hsv[1] + hsv[1] * std::clamp(pure[i], 0.0, 1.0));
  return rgb;
}

Rgb interpolate(ColorSpace space, const Rgb& a, const Rgb& b, double s) {
  switch (space) {
    case ColorSpace::kRgb:
      return mix(a, b, s);
    case ColorSpace::kHsv:
      return interpolate_hsv(a, b, s, false);
    case ColorSpace::kHsvWrap:
      return interpolate_hsv(a, b, s, true);
    case ColorSpace::kLab:
      return rgb_from_lab(mix(lab_from_rgb(a), lab_from_rgb(b), s));
    case ColorSpace::kDiverging:
      return interpolate_diverging(a, b, s);
    case ColorSpace::kStep:
      return s > 0.0 ? b : a;
  }
  return a;
}

}  // namespace ovoid::view
