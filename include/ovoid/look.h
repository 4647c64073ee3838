// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/field.h"
#include "ovoid/math.h"
#include "ovoid/transfer_function.h"
#include "ovoid/transfer_function_2d.h"

namespace OVOID_API ovoid {

// How the samples of a ray become a pixel (docs/numerics.md, "Modes").
enum class Mode { kComposite, kXray, kMaximum, kMean, kIsosurface, kMinimum };

// Blinn-Phong in VTK's words; two-sided. The light is white.
struct Material {
  double ambient = 0.1;
  double diffuse = 0.7;
  double specular = 0.2;
  double specular_power = 10.0;  // > 0

  bool operator==(const Material&) const = default;
};

// What falls on the volume (docs/numerics.md, "Light"). Lights are white.
enum class Light {
  kSingle,  // one light, which reaches both sides of a surface alike
  kStudio   // a key light, and a soft one from the eye: what turns away from the key is not black
};

// A light beside the look's own (docs/numerics.md, "Further lights"). White.
struct FurtherLight {
  Vec3 direction = Vec3::UnitZ();  // world, from the object towards the light, of any length
  double intensity = 1.0;          // share of a single light's, in [0, 10]

  bool operator==(const FurtherLight&) const = default;
};

// The light in a picture.
struct Lighting {
  Light light = Light::kSingle;
  // World, from the object towards the light, or the studio's key light. None: a headlight (along
  // each ray to the eye); of the studio: from above left of the camera, with which it moves.
  std::optional<Vec3> light_direction;
  // Lights beside that one. They reach both sides of a surface alike, cast no shadows, and are
  // weakened by occlusion as the soft light is.
  static constexpr std::size_t kMaxFurtherLights = 4;
  std::vector<FurtherLight> further_lights;
  // Shares, in [0, 1], of what a coarse volume of light tells (docs/numerics.md, "Light from a
  // coarse volume"), composite and isosurface only. `occlusion`: ambient light, a headlight, and
  // the studio's soft light are weaker where much lies around. `shadows`: so is the key light, or a
  // single one with a direction, behind what lies on its way. `scatter`: of what shadows take away,
  // this share of what comes round the corner is given back. Of looks that are not lit (`shade`)
  // both darken the colours, shadows those that lie behind what the studio's key light, or a single
  // one with a direction, would have to pass.
  double occlusion = 0.0;
  double shadows = 0.0;
  double scatter = 0.0;

  bool operator==(const Lighting&) const = default;
};

// One of several surfaces of mode kIsosurface.
struct Isosurface {
  double value = 0.0;
  std::optional<Rgb> color{};  // none: the look's own at that value, or at the colour's attribute
  double opacity = 1.0;        // of one crossing, in [0, 1]
};

// Everything about appearance: classification, material, light, mode.
struct Look : Lighting {
  TransferFunction transfer_function;
  // For fields whose colour comes from an attribute of its own (KernelField::has_own_color()): its
  // colours, over that attribute's values, stand for the transfer function's. None: the transfer
  // function's own colours, at that attribute's values.
  std::optional<TransferFunction> color_function;
  // Colour and opacity by value and gradient (docs/looks2d.md): in mode kComposite these stand for
  // the transfer function's. Other modes, pre-integrated classification, trails, light from a
  // coarse volume, colours by an attribute of their own and gradient opacities are refused beside
  // it; what has no gradient (slices, surfaces, balls) keeps the transfer function's colours. Not
  // by the vulkan back end.
  std::optional<TransferFunction2D> transfer_function_2d;
  Mode mode = Mode::kComposite;
  double isovalue = 0.0;  // for kIsosurface
  // For kIsosurface: these surfaces instead of the one at `isovalue`, in any order, no two at the
  // same value; those that are seen through show what lies behind (docs/numerics.md, "Modes").
  // Empty: that one. Not by the vulkan back end, nor with a trail.
  std::vector<Isosurface> isosurfaces;
  static constexpr std::size_t kMaxIsosurfaces = 16;
  bool shade = true;  // composite and isosurface only
  Material material;
  // Where the field rises, over its smallest spacing, by less than this share of the transfer
  // function's span, light fades to that of a flat region: there normals are noise. In [0, 1].
  // (An isosurface, which is asked for, is lit from 1e-4 of the field's range on.)
  double flat_rise = 1e-4;
  double unit_distance = 0.0;  // world length of the opacities; 0: unit_distance_of()

  Lighting& lighting() noexcept { return *this; }
  const Lighting& lighting() const noexcept { return *this; }

  // Throws Error(kInvalidArgument) that names the member.
  void validate() const;
};

// The unit distance when nobody names one: the field's default sampling distance (its smallest
// spacing), so that an opacity of 0.5 is what one sample step of a plain ray caster would absorb.
double default_unit_distance(const Field& field);

// That of a look: its own, else its transfer function's, else the default.
double unit_distance_of(const Look& look, const Field& field);

// The plainest look for values in `range`: the named colour map over the range, opacity rising from
// 0 at the low end to 0.5 at the high end.
Look ramp_look(const ValueRange& range, const std::string& color_map_name = "viridis");

// The plainest look for pictures that show one value of each ray: kMaximum, kMinimum, kMean. The
// range is that which rays along the field's axes show, without what few of them do and without
// rays that meet background alone; logarithmic where most of them would be dark
// (docs/looks.md, "Projections"). Cost and errors as of default_look(); of kernel sets some
// thousands of values.
Look projection_look(const Field& field, Mode mode, const std::string& color_map_name = "viridis");

// A look that shows something of a field that nobody said anything about: labels get categorical
// colours, CT in Hounsfield units skin and bone, what stands in a background its layers, what fills
// its box its upper half (docs/looks.md, "The default look"). `unit`: the array's, if known; "HU"
// decides. A small change of the data is a small change of the look. Cost: some ten milliseconds;
// for labels one pass. Throws what the field's source throws.
Look default_look(const Field& field, std::string_view unit = {});

// The value of water, if the field's values look like CT: 0 in Hounsfield units, 1024 in scanners'
// raw numbers. None for everything else, kernel sets and CT in other scales (8 bits) among it.
// `unit`, cost and errors as of default_look().
std::optional<double> value_of_water(const Field& field, std::string_view unit = {});

// Where CT in a scale of its own has air and dense bone, as far as samples tell: what most of the
// outer faces share, and the value under which 99.9 % of all samples lie. None where the faces
// share nothing. Cost and errors as of default_look().
std::optional<std::pair<double, double>> air_and_bone(const Field& field);

// What the samples of a field tell of what it is made of, from values and slopes together.
struct Materials {
  std::vector<double> values;      // rising: values that many samples share where they rise little
  std::vector<double> boundaries;  // one between each two of them: where the field rises most
  double noise = 0;      // how much noise alone makes the field rise over its smallest spacing
  double noisiness = 0;  // from 0, surfaces or smooth, to 1, speckle or noise and little else
};
// Of a lattice, by about a hundred thousand of its samples; of a kernel set nothing is found.
// Errors as of default_look(). Cost: some tens of milliseconds. [Kindlmann 1998]
Materials materials_of(const Field& field);

// True if the field's values look like labels: at most 64 different integers in [0, 65535] in
// regions, or more, up to 2^24, in flat regions with sharp ends. Between two labels the field
// passes all values between them, so labels want kernels so narrow that nobody sees them:
// kLabelKernel, and with it GradientMethod::kCentral. Cost and errors as of default_look().
bool holds_labels(const Field& field);
inline constexpr LatticeKernel kLabelKernel{.sigma = 0.15, .cutoff = 10.0};

// A look made for one kind of data, by name (docs/looks.md, "Presets"): those that begin with "ct-"
// are in Hounsfield units, absolute; "label" has colours for whole numbers, up to 256 or the end of
// `range`, the data's values; those that begin with "mr-" are spread over it. Transfer function,
// shading and material are set, the unit distance is left to the field. Throws
// Error(kInvalidArgument) that lists the names.
// "cinematic" is ramp_look(range) under add_cinematic_light(); programs that have the field take
// its default_look() for the colours and opacities.
Look look_preset(const std::string& name, const ValueRange& range = {});
std::vector<std::string> look_preset_names();
inline constexpr const char* kCinematicPreset = "cinematic";

// Lights a look as a photographer would: a studio with shadows, soft ones in what lies deep, and
// light that comes back from the sides; a material that shines a little. Colours and opacities
// stay.
void add_cinematic_light(Look& look);

}  // namespace ovoid
