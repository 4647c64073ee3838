// SPDX-License-Identifier: Apache-2.0
// The blend modes maximum and minimum of dependent components: the extreme of the last one, in the
// colours that the others have in the same place.
#pragma once

#include "ovoid/image.h"
#include "ovoid/render_options.h"
#include "ovoid/renderer.h"
#include "ovoid/scene.h"
#include "view.h"

namespace ovoid::mappers {

// `image` is the extreme's picture of the first volume, white, made on image sheets; it takes the
// colours that the others, whose looks are of mode composite, have at its depths. `options` are
// those by which it was made. Cost: a second frame, of which each pixel shows one place. Throws
// what Renderer::render() throws. Returns that frame's milliseconds.
double color_extremes(Renderer& renderer, const Scene& scene, const View& view,
                      const RenderOptions& options, Image* image);

}  // namespace ovoid::mappers
