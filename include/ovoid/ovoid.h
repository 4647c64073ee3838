// SPDX-License-Identifier: Apache-2.0
// Everything: volumes drawn straight from their points. A file to a picture:
//
//   auto field = ovoid::make_field(ovoid::read_dataset({"head.nrrd"}));
//   auto camera = ovoid::default_camera(field.world_bounds());
//   auto look = ovoid::default_look(field);
//   auto frame = ovoid::Renderer{}.render(field, camera, look);
//   ovoid::write_image(frame.image, "head.png");
#pragma once

#include "ovoid/annotate.h"
#include "ovoid/camera.h"
#include "ovoid/coarse.h"
#include "ovoid/crop.h"
#include "ovoid/dataset.h"
#include "ovoid/deep_image.h"
#include "ovoid/depth_limits.h"
#include "ovoid/devices.h"
#include "ovoid/encode.h"
#include "ovoid/error.h"
#include "ovoid/field.h"
#include "ovoid/fit.h"
#include "ovoid/framing.h"
#include "ovoid/geometry.h"
#include "ovoid/hyperslice.h"
#include "ovoid/image.h"
#include "ovoid/io.h"
#include "ovoid/kernel_field.h"
#include "ovoid/kernels.h"
#include "ovoid/lattice.h"
#include "ovoid/lattice_boxes.h"
#include "ovoid/lattice_file.h"
#include "ovoid/lattice_levels.h"
#include "ovoid/look.h"
#include "ovoid/math.h"
#include "ovoid/model.h"
#include "ovoid/pick.h"
#include "ovoid/relevant.h"
#include "ovoid/render_mesh.h"
#include "ovoid/render_options.h"
#include "ovoid/render_points.h"
#include "ovoid/render_surface.h"
#include "ovoid/renderer.h"
#include "ovoid/resample.h"
#include "ovoid/sampler.h"
#include "ovoid/series.h"
#include "ovoid/simplify.h"
#include "ovoid/slices.h"
#include "ovoid/solid.h"
#include "ovoid/space_part.h"
#include "ovoid/surface.h"
#include "ovoid/transfer_function.h"
#include "ovoid/value_plane.h"
#include "ovoid/version.h"
