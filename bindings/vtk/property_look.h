// SPDX-License-Identifier: Apache-2.0
// vtkVolumeProperty, blend mode and lights as a look. What they mean: [VTK 2021].
#pragma once

#include "ovoid/field.h"
#include "ovoid/image.h"
#include "ovoid/look.h"
#include "ovoid/math.h"
#include "ovoid/scene.h"
#include "vtk_arrays.h"

class vtkColorTransferFunction;
class vtkImageData;
class vtkPiecewiseFunction;
class vtkRenderer;
class vtkVolumeProperty;

namespace ovoid::mappers {

// The points of VTK's functions of colour and opacity. Where VTK goes between two nodes as the
// library does not (a midpoint or sharpness of colours, logarithmic scales, Lab/CIEDE2000, discrete
// steps), kSubdivisions of VTK's own values stand between them.
inline constexpr int kSubdivisions = 32;
void take_colors(vtkColorTransferFunction* function, TransferFunction* tf);
void take_grays(vtkPiecewiseFunction* function, TransferFunction* tf);
std::vector<OpacityPoint> opacity_points(vtkPiecewiseFunction* function);

// A two-dimensional function: entries from the least value to the greatest, from no gradient to the
// length `steepest`, in value per world length; beyond, that of the end. Bilinearly fewer where
// there are more than a TransferFunction2D has. Opacities are multiplied by `weight`. Throws
// Error(kInvalidArgument) where there is none, or the image is not one slice of four components.
TransferFunction2D table_of_function(vtkImageData* function, double weight, const ValueRange& range,
                                     double steepest);

// What a vtkVolumeProperty says of a component, drawn in `blend_mode` (vtkVolumeMapper's).
// `field` sets the length over which VTK takes gradients: the mean of its three spacings. Of
// MINIMUM_INTENSITY_BLEND the field must hold the negated values, and so do the look's points. Of
// ADDITIVE_BLEND the look's opacities stand for what is added: show_sums() makes the picture of
// theirs. Of SLICE_BLEND they are those of the plane. The component's weight is a factor of all
// opacities. Throws Error(kUnsupported) for blend modes that are not drawn, or not with a
// two-dimensional function, kInvalidArgument for an isosurface without a value, and what
// table_of_function() throws.
Look look_of_property(vtkVolumeProperty* property, const DrawnComponent& drawn, int blend_mode,
                      const Field& field);

// Looks of dependent components, which Mixing::kColored draws together. That of the first,
// `look`, leaves its colours to the others'; look_of_color() is that of the others,
// drawn.components[ index], in mode composite. Bytes of red, green and blue count from 0 to 255,
// other numbers over the range of each; a single value has the property's colours.
void leave_colors(Look* look);
Look look_of_color(vtkVolumeProperty* property, const DrawnValues& drawn, std::size_t index,
                   const Field& field);

// The plane of SLICE_BLEND in the world, in the look's colours and opacities. Throws Error:
// kInvalidArgument where the property has no slice function, kUnsupported for others than planes.
FieldSlice slice_of(vtkVolumeProperty* property, const Look& look);

// Opacities of a frame as the sums that they stand for: gray, at most 1, as opaque as bright.
void show_sums(Image* image);

// The renderer's lights that are on, by their directions at `center` (world) and intensities;
// colours by their luminance. Throws Error(kUnsupported) for more than five.
void take_lights(vtkRenderer* renderer, const Vec3& center, Look* look);

}  // namespace ovoid::mappers
