// SPDX-License-Identifier: Apache-2.0
// Several processes draw one scene: each owns a box of it, draws what lies within, and ParaView
// composites the boxes' pictures in the order in which the eye meets them.
#pragma once

#include <vtkSmartPointer.h>

#include <optional>
#include <vector>

class vtkBoundingBox;
class vtkMatrix4x4;
class vtkView;
class vtkUnstructuredGrid;

namespace ovoid::paraview {

bool has_several_ranks();

// All functions but the first are called on every rank.

// What ParaView has given to each rank to draw; empty where a single process draws everything.
std::vector<vtkBoundingBox> boxes_of_ranks(vtkView* view);

// This rank's box, for vtkOvoidVolumeMapper::SetOwnedBounds(). Sides at the end of the scene are
// infinite, since kernels reach beyond what they are made of. `world_from_data` moves and stretches
// the boxes with the volume; what else it does is left out.
std::vector<double> owned_bounds(const std::vector<vtkBoundingBox>& boxes,
                                 vtkMatrix4x4* world_from_data);

// The least and the greatest of all ranks' numbers.
double least_of_ranks(double number);
double greatest_of_ranks(double number);

// Each number, summed over all ranks.
std::vector<double> sums_of_ranks(const std::vector<double>& numbers);

// This rank's cells and those of the others that its kernels and their shapes depend on. `own` are
// the cells that ParaView gave to this rank.
vtkSmartPointer<vtkUnstructuredGrid> with_neighbours(vtkUnstructuredGrid* own,
                                                     const std::vector<vtkBoundingBox>& boxes);

}  // namespace ovoid::paraview
