// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "model/mesh/local_mesh.h"
#include "ovoid/surface.h"

namespace ovoid::model {

// make_surface() of a mesh and of boxes: in a team, where all call it, of the parts of all, in each
// process. Null if there are no faces.
std::shared_ptr<const Surface> surface_of_mesh(const ModelRun& run, const LocalMesh& mesh);
std::shared_ptr<const Surface> surface_of_boxes(const ModelRun& run, const LocalBoxes& local);

}  // namespace ovoid::model
