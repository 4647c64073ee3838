// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/meshes/amr_boxes.h"

// NOLINTBEGIN(cppcoreguidelines-virtual-class-destructor): VTK counts references
class vtkImageData;
// NOLINTEND(cppcoreguidelines-virtual-class-destructor)

namespace ovoid::io {

// One grid of cells as VTK has read it. Throws Error(kUnsupported) if its axes are turned. Only
// with VTK.
AmrGrid amr_grid_of(const std::string& source, vtkImageData* data, int level,
                    std::vector<std::string>& notes);

}  // namespace ovoid::io
