// SPDX-License-Identifier: Apache-2.0
#include "property_look.h"

#include <fmt/format.h>
#include <vtkCamera.h>
#include <vtkCollectionIterator.h>
#include <vtkContourValues.h>
#include <vtkDataArray.h>
#include <vtkImplicitFunction.h>
#include <vtkLight.h>
#include <vtkLightCollection.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPlane.h>
#include <vtkRenderer.h>
#include <vtkVolumeMapper.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "ovoid/channels.h"
#include "ovoid/error.h"

namespace ovoid::mappers {
namespace {

Mode mode_of(int blend_mode) {
  switch (blend_mode) {
    case vtkVolumeMapper::COMPOSITE_BLEND:
    case vtkVolumeMapper::ADDITIVE_BLEND:  // of light that nothing weakens
    case vtkVolumeMapper::SLICE_BLEND:     // a plane beside a field that is not seen
      return Mode::kComposite;
    case vtkVolumeMapper::MAXIMUM_INTENSITY_BLEND:
    case vtkVolumeMapper::MINIMUM_INTENSITY_BLEND:  // the maximum of the negated values
      return Mode::kMaximum;
    case vtkVolumeMapper::AVERAGE_INTENSITY_BLEND:
      return Mode::kMean;
    case vtkVolumeMapper::ISOSURFACE_BLEND:
      return Mode::kIsosurface;
    default:
      throw Error(ErrorCode::kInvalidArgument, fmt::format("blend mode {}: unknown", blend_mode));
  }
}

// What is added at a value is its share of the range times its opacity, a. An opacity of
// 1 - exp(-a) makes the sum, over the unit distance, the frame's optical depth.
void make_additive(vtkPiecewiseFunction* function, double weight, const ValueRange& range,
                   Look* look) {
  const double span = static_cast<double>(range.hi) - range.lo;
  std::vector<double> ends{range.lo, range.hi};
  for (const OpacityPoint& point : opacity_points(function)) {
    if (range.lo < point.x && point.x < range.hi) ends.push_back(point.x);
  }
  std::sort(ends.begin(), ends.end());
  std::vector<OpacityPoint>& points = look->transfer_function.opacities;
  points.clear();
  const auto add = [&](double value) {
    const double share = span > 0 ? (value - range.lo) / span : 1;
    const double opacity = weight * std::clamp(function->GetValue(value), 0.0, 1.0);
    points.push_back({value, -std::expm1(-share * opacity)});
  };
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double step = (ends[i + 1] - ends[i]) / kSubdivisions;
    for (int k = 0; k < kSubdivisions; ++k) add(ends[i] + step * k);
  }
  add(range.hi);
  look->transfer_function.gradient_opacities.clear();
  look->shade = false;
}

// One opaque surface is the isovalue's, which all back ends draw.
void take_isosurfaces(vtkVolumeProperty* property, Look* look) {
  vtkContourValues* const contours = property->GetIsoSurfaceValues();
  std::vector<double> values(
      static_cast<std::size_t>(contours != nullptr ? contours->GetNumberOfContours() : 0));
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = contours->GetValue(static_cast<int>(i));
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (values.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                "blend mode isosurface: the property's IsoSurfaceValues are empty");
  }
  if (values.size() > Look::kMaxIsosurfaces) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("blend mode isosurface: {} values: at most {} are drawn", values.size(),
                            Look::kMaxIsosurfaces));
  }
  look->isovalue = values.front();
  for (const double value : values) {
    const double opacity = look->transfer_function.opacity_at(value);
    if (values.size() > 1 || opacity < 1) look->isosurfaces.push_back({value, {}, opacity});
  }
}

// Lengths of the axis vectors of a lattice, which VTK calls spacing; of kernels the distance that
// stands for one.
double mean_spacing(const Field& field) {
  const LatticeField* const lattice = field.lattice();
  return lattice != nullptr ? lattice->geometry().spacing().mean()
                            : field.default_sampling_distance();
}

// Of a change of value over the mean spacing: where VTK's tables end, at a quarter of the values'
// range. Steeper gradients have the last entry.
double steepest_change(const Field& field) {
  constexpr double kTableEnd = 0.25;
  const ValueRange range = field.value_range();
  return kTableEnd * (static_cast<double>(range.hi) - range.lo);
}

// VTK's gradients are per mean spacing.
std::vector<OpacityPoint> gradient_points(vtkPiecewiseFunction* function, const Field& field) {
  const double end = steepest_change(field);
  if (!(end > 0)) return {};
  std::vector<OpacityPoint> points = opacity_points(function);
  if (!points.empty() && points.back().x > end) {
    // Between the last node within and the end the function stays as it is: in small steps.
    std::erase_if(points, [&](const OpacityPoint& point) { return point.x >= end; });
    const double from = points.empty() ? 0 : points.back().x;
    if (!points.empty()) points.back() = {from, points.back().opacity};
    for (int i = points.empty() ? 0 : 1; i <= kSubdivisions; ++i) {
      const double x = from + (end - from) * i / kSubdivisions;
      points.push_back({x, function->GetValue(x)});
    }
  }
  const double per_length = 1 / mean_spacing(field);
  for (OpacityPoint& point : points) {
    point.x *= per_length;
    point.opacity = std::clamp(point.opacity, 0.0, 1.0);
  }
  return points;
}

bool changes_nothing(const std::vector<OpacityPoint>& points) {
  return std::all_of(points.begin(), points.end(),
                     [](const OpacityPoint& point) { return point.opacity == 1; });
}

// The same look for values of the other sign.
void negate(TransferFunction* tf) {
  for (ColorPoint& point : tf->colors) point.x = -point.x;
  for (OpacityPoint& point : tf->opacities) point.x = -point.x;
  std::reverse(tf->colors.begin(), tf->colors.end());
  std::reverse(tf->opacities.begin(), tf->opacities.end());
  // What a node says of the way to the next is now said by the next.
  for (std::size_t i = 0; i + 1 < tf->opacities.size(); ++i) {
    tf->opacities[i].midpoint = 1 - tf->opacities[i + 1].midpoint;
    tf->opacities[i].sharpness = tf->opacities[i + 1].sharpness;
  }
  std::swap(tf->below_color, tf->above_color);
}

void take_property_colors(vtkVolumeProperty* property, int index, TransferFunction* tf) {
  if (property->GetColorChannels(index) == 1)
    take_grays(property->GetGrayTransferFunction(index), tf);
  else
    take_colors(property->GetRGBTransferFunction(index), tf);
}

double luminance(const double color[3]) {
  return 0.30 * color[0] + 0.59 * color[1] + 0.11 * color[2];  // vtkColorTransferFunction's
}

// The eye's light is along each ray, whatever the others do.
struct Lamp {
  bool is_headlight = false;
  Vec3 direction;
  double intensity = 0;
};

std::vector<Lamp> lamps_of(vtkRenderer* renderer, const Vec3& center) {
  std::vector<Lamp> lamps;
  vtkLightCollection* const lights = renderer->GetLights();
  vtkCollectionSimpleIterator place;
  lights->InitTraversal(place);
  while (vtkLight* const light = lights->GetNextLight(place)) {
    Lamp lamp;
    lamp.intensity = light->GetIntensity() * luminance(light->GetDiffuseColor());
    if (light->GetSwitch() == 0 || !(lamp.intensity > 0)) continue;
    lamp.is_headlight = light->LightTypeIsHeadlight() != 0;
    const Vec3 from(light->GetTransformedPosition());
    const Vec3 to = light->GetPositional() != 0 ? center : Vec3(light->GetTransformedFocalPoint());
    lamp.direction = from - to;
    if (!lamp.is_headlight && !(lamp.direction.norm() > 0)) continue;
    lamps.push_back(lamp);
  }
  // The first is the look's own.
  std::stable_sort(lamps.begin(), lamps.end(),
                   [](const Lamp& a, const Lamp& b) { return a.is_headlight && !b.is_headlight; });
  return lamps;
}

}  // namespace

Look look_of_property(vtkVolumeProperty* property, const DrawnComponent& drawn, int blend_mode,
                      const Field& field) {
  const int index = drawn.property_index;
  Look look;
  look.mode = mode_of(blend_mode);
  TransferFunction& tf = look.transfer_function;
  tf.name = "vtkVolumeProperty";
  take_property_colors(property, index, &tf);
  tf.opacities = opacity_points(property->GetScalarOpacity(index));
  for (OpacityPoint& point : tf.opacities) point.opacity *= drawn.weight;
  if (blend_mode == vtkVolumeMapper::MINIMUM_INTENSITY_BLEND) negate(&tf);
  const bool is_2d = property->GetTransferFunctionMode() == vtkVolumeProperty::TF_2D;
  if (is_2d && blend_mode != vtkVolumeMapper::COMPOSITE_BLEND) {
    throw Error(ErrorCode::kUnsupported,
                "two-dimensional transfer functions: are drawn in the blend mode composite alone");
  }
  if (is_2d) {
    const double change = steepest_change(field);
    look.transfer_function_2d =
        table_of_function(property->GetTransferFunction2D(index), drawn.weight, field.value_range(),
                          (change > 0 ? change : 1) / mean_spacing(field));
  }
  if (look.mode == Mode::kIsosurface) take_isosurfaces(property, &look);
  if (look.mode == Mode::kComposite && !is_2d && property->GetDisableGradientOpacity(index) == 0) {
    tf.gradient_opacities = gradient_points(property->GetGradientOpacity(index), field);
    if (changes_nothing(tf.gradient_opacities)) tf.gradient_opacities.clear();
  }
  look.unit_distance = property->GetScalarOpacityUnitDistance(index);
  look.shade = property->GetShade(index) != 0;
  look.material.ambient = property->GetAmbient(index);
  look.material.diffuse = property->GetDiffuse(index);
  look.material.specular = property->GetSpecular(index);
  look.material.specular_power = property->GetSpecularPower(index);
  if (blend_mode == vtkVolumeMapper::ADDITIVE_BLEND)
    make_additive(property->GetScalarOpacity(index), drawn.weight, field.value_range(), &look);
  return look;
}

void leave_colors(Look* look) {
  look->transfer_function.colors = {{0, {1, 1, 1}}};
  look->transfer_function.below_color.reset();
  look->transfer_function.above_color.reset();
}

Look look_of_color(vtkVolumeProperty* property, const DrawnValues& drawn, std::size_t index,
                   const Field& field) {
  const DrawnComponent& component = drawn.components[index];
  if (drawn.components.size() > 2) {
    const bool is_of_bytes = drawn.array->GetDataType() == VTK_UNSIGNED_CHAR;
    return primary_look(is_of_bytes ? ValueRange{0, 255} : field.value_range(),
                        component.component);
  }
  Look look;
  take_property_colors(property, component.property_index, &look.transfer_function);
  look.transfer_function.opacities = {{0, 1}};  // everywhere, so that all of the field has colours
  look.shade = false;
  return look;
}

FieldSlice slice_of(vtkVolumeProperty* property, const Look& look) {
  vtkImplicitFunction* const function = property->GetSliceFunction();
  auto* const plane = vtkPlane::SafeDownCast(function);
  if (function == nullptr) {
    throw Error(ErrorCode::kInvalidArgument,
                "blend mode slice: the property has no SliceFunction: expected a vtkPlane");
  }
  if (plane == nullptr) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("blend mode slice: SliceFunction is a {}: a vtkPlane is drawn",
                            function->GetClassName()));
  }
  FieldSlice slice;
  slice.normal = Vec3(plane->GetNormal());
  slice.offset = slice.normal.dot(Vec3(plane->GetOrigin()));
  slice.colors = look.transfer_function;
  slice.colors.gradient_opacities.clear();
  return slice;
}

void show_sums(Image* image) {
  for (std::size_t i = 0; i < image->rgba.size(); i += 4) {
    const float sum = std::min(1.0F, -std::log1p(-std::min(image->rgba[i + 3], 0.999F)));
    std::fill_n(image->rgba.begin() + static_cast<std::ptrdiff_t>(i), 4, sum);
  }
}

void take_lights(vtkRenderer* renderer, const Vec3& center, Look* look) {
  if (!look->shade) return;
  const std::vector<Lamp> lamps = lamps_of(renderer, center);
  look->light = Light::kSingle;
  if (lamps.empty()) {
    look->material.diffuse = look->material.specular = 0;
    return;
  }
  if (lamps.size() > Look::kMaxFurtherLights + 1) {
    throw Error(ErrorCode::kUnsupported, fmt::format("{} lights: at most {} are drawn",
                                                     lamps.size(), Look::kMaxFurtherLights + 1));
  }
  const Lamp& own = lamps.front();
  if (!own.is_headlight) look->light_direction = own.direction;
  look->material.diffuse *= own.intensity;
  look->material.specular *= own.intensity;
  const Vec3 to_eye = -Vec3(renderer->GetActiveCamera()->GetDirectionOfProjection());
  for (std::size_t i = 1; i < lamps.size(); ++i) {
    look->further_lights.push_back({lamps[i].is_headlight ? to_eye : lamps[i].direction,
                                    std::min(lamps[i].intensity / own.intensity, 10.0)});
  }
}

}  // namespace ovoid::mappers
