// SPDX-License-Identifier: Apache-2.0
#include "cells_of_any.h"

#include <vtkAppendFilter.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkCompositeDataIterator.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdTypeArray.h>
#include <vtkMultiProcessController.h>
#include <vtkNew.h>
#include <vtkOverlappingAMR.h>
#include <vtkParallelAMRUtilities.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPolyData.h>
#include <vtkStructuredGrid.h>
#include <vtkUniformGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <array>
#include <vector>

namespace ovoid::paraview {
namespace {

using Part = vtkSmartPointer<vtkDataSet>;

// Of a grid's cells those that no finer grid and no other piece has.
bool is_drawn(vtkUnsignedCharArray* flags, vtkIdType cell) {
  constexpr int kLeftOut = vtkDataSetAttributes::DUPLICATECELL | vtkDataSetAttributes::REFINEDCELL |
                           vtkDataSetAttributes::HIDDENCELL;
  return flags == nullptr || (flags->GetValue(cell) & kLeftOut) == 0;
}

Part voxels_of(vtkImageData* grid) {
  vtkUnsignedCharArray* const flags = grid->GetCellGhostArray();
  vtkNew<vtkUnstructuredGrid> voxels;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(grid->GetNumberOfPoints());
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) points->SetPoint(i, grid->GetPoint(i));
  voxels->SetPoints(points);
  voxels->GetPointData()->ShallowCopy(grid->GetPointData());
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkIdList> kept, corners;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    if (!is_drawn(flags, c) || grid->GetCellType(c) != VTK_VOXEL) continue;
    grid->GetCellPoints(c, corners);
    cells->InsertNextCell(corners);
    kept->InsertNextId(c);
  }
  voxels->SetCells(VTK_VOXEL, cells);
  voxels->GetCellData()->CopyAllocate(grid->GetCellData(), kept->GetNumberOfIds());
  vtkNew<vtkIdList> places;
  places->SetNumberOfIds(kept->GetNumberOfIds());
  for (vtkIdType i = 0; i < kept->GetNumberOfIds(); ++i) places->SetId(i, i);
  voxels->GetCellData()->CopyData(grid->GetCellData(), kept, places);
  voxels->GetCellData()->RemoveArray(vtkDataSetAttributes::GhostArrayName());
  voxels->GetPointData()->RemoveArray(vtkDataSetAttributes::GhostArrayName());
  return voxels.Get();
}

Part vertices_of(vtkPointSet* set) {
  vtkNew<vtkUnstructuredGrid> vertices;
  vertices->SetPoints(set->GetPoints());
  vertices->GetPointData()->ShallowCopy(set->GetPointData());
  vtkNew<vtkCellArray> cells;
  for (vtkIdType i = 0; i < set->GetNumberOfPoints(); ++i) cells->InsertNextCell(1, &i);
  vertices->SetCells(VTK_VERTEX, cells);
  return vertices.Get();
}

// Null for what is no part of these kinds.
Part part_of(vtkDataObject* leaf) {
  if (auto* const grid = vtkImageData::SafeDownCast(leaf)) return voxels_of(grid);
  if (auto* const points = vtkPolyData::SafeDownCast(leaf)) return vertices_of(points);
  return vtkStructuredGrid::SafeDownCast(leaf);
}

}  // namespace

vtkSmartPointer<vtkUnstructuredGrid> cells_of_any(vtkDataObject* data) {
  vtkNew<vtkAppendFilter> append;
  int count = 0;
  const auto add = [&](vtkDataObject* leaf) {
    const Part part = part_of(leaf);
    if (part == nullptr || part->GetNumberOfPoints() == 0) return;
    append->AddInputData(part);
    ++count;
  };
  auto* const composite = vtkCompositeDataSet::SafeDownCast(data);
  if (composite == nullptr) {
    if (vtkUnstructuredGrid::SafeDownCast(data) != nullptr) return nullptr;
    add(data);
  } else {
    vtkSmartPointer<vtkCompositeDataSet> parts = composite;
    if (auto* const adaptive = vtkOverlappingAMR::SafeDownCast(data)) {
      vtkNew<vtkOverlappingAMR> blanked;  // flags of its own
      blanked->ShallowCopy(adaptive);
      vtkParallelAMRUtilities::BlankCells(blanked,
                                          vtkMultiProcessController::GetGlobalController());
      parts = blanked.Get();
    }
    const auto leaves = vtkSmartPointer<vtkCompositeDataIterator>::Take(parts->NewIterator());
    for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem()) {
      if (vtkUnstructuredGrid::SafeDownCast(leaves->GetCurrentDataObject()) != nullptr)
        return nullptr;
      add(leaves->GetCurrentDataObject());
    }
  }
  vtkNew<vtkUnstructuredGrid> cells;
  if (count > 0) {
    append->Update();
    cells->ShallowCopy(append->GetOutput());
  }
  return cells.Get();
}

}  // namespace ovoid::paraview
