// SPDX-License-Identifier: Apache-2.0
// The values of settings that are more than a number or a name: from their text, which throws
// BadValue, and back.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "settings.h"

namespace ovoid::cli {

inline constexpr Interval kPositive = {.lo = 0, .lo_open = true};

// What a test finds in a value that is so.
inline std::optional<std::string> if_so(bool is_so, const std::string& shown) {
  return is_so ? std::optional(shown) : std::nullopt;
}

// Tests of --mode: whether what it draws is not lit, and whether it is not made of layers.
std::optional<std::string> is_unlit(const std::string& mode);
std::optional<std::string> is_no_layer(const std::string& mode);

// A number of the values' unit, or, with % behind it, a share of their range.
struct Tolerance {
  double number = 0;
  bool is_share = false;
};
Tolerance parse_tolerance(const std::string& text);          // "VALUE[%]", not 0
Tolerance parse_tolerance_or_zero(const std::string& text);  // "VALUE[%]"

LatticeKernel parse_kernel(const std::string& text);  // "bspline", "gaussian:SIGMA,CUTOFF"
int parse_component(const std::string& text);         // "N" or "magnitude"
Vec3 parse_spacing(const std::string& text);          // "A,B,C"
Vec3 parse_direction(const std::string& text);        // "X,Y,Z"
// "studio", "headlight", "X,Y,Z" or "studio:X,Y,Z".
std::pair<Light, std::optional<Vec3>> parse_light(const std::string& text);
std::vector<Isosurface> parse_isosurfaces(const std::string& text);  // "V[:COLOR[:A]],..."
FurtherLight parse_further_light(const std::string& text);           // "X,Y,Z[@INTENSITY]"
Hyperplane parse_hyperplane(const std::string& text);  // "A,B,C,D,E"; without E its offset is NaN
ClipPlane parse_clip(const std::string& text);         // "NX,NY,NZ,D"
// "NX,NY,NZ,D,T", as the two planes that leave it.
std::array<ClipPlane, 2> parse_thick_slice(const std::string& text);
ValuePlane parse_value_plane(const std::string& text);          // "NX,NY,NZ,D[,shown]"
std::string parse_preset(const std::string& text);              // its name
SlicePlane parse_slice_plane(const std::string& text);          // "z", "axial=3" or "nx,ny,nz,d"
std::string parse_color_map(const std::string& text);           // its name, or a list, as it is
std::vector<ColorPoint> parse_colors(const std::string& text);  // "V,R,G,B,..."
std::vector<OpacityPoint> parse_opacities(const std::string& text);           // "V:A,V:A,..."
Ranges2D parse_ranges_2d(const std::string& text);                            // "V,V,G,G"
std::vector<OpacityPoint> parse_gradient_opacities(const std::string& text);  // "G:A,G:A,..."
// "W,L": the values from L - W/2 to L + W/2.
std::pair<double, double> parse_window(const std::string& text);
// "LO:HI,LO:HI,LO:HI"; any of the numbers, or a whole part, may be missing.
std::array<CropFlags::Range, 3> parse_samples(const std::string& text);
Bounds3 parse_world(const std::string& text);

bool is_list_of_colors(const std::string& text);

std::string text_of_component(int component);
std::string text_of(const LatticeKernel& kernel);
std::string text_of(const Vec3& v);
std::string text_of_light(Light light, const std::optional<Vec3>& direction);
std::string text_of(const std::vector<Isosurface>& surfaces);
std::string text_of(const FurtherLight& light);
std::string text_of(const Rgb& rgb);
std::string text_of(const Index3& dims);
std::string text_of(ScalarType type);
std::string text_of(const Hyperplane& plane);
std::string text_of(const ClipPlane& plane);
std::string text_of(const ValuePlane& plane);
std::string text_of(const SlicePlane& plane);
std::string text_of(const std::vector<OpacityPoint>& points);
std::string text_of(const std::pair<double, double>& range);
std::string text_of(const std::array<CropFlags::Range, 3>& samples);
std::string text_of(const Bounds3& world);

// The form of a value by the two.
template <class T>
Form<T> form(std::string shown, T (*parse)(const std::string& text)) {
  return {std::move(shown), parse, [](const T& value) { return text_of(value); }};
}
inline std::string same(const std::string& text) { return text; }

}  // namespace ovoid::cli
