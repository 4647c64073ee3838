// SPDX-License-Identifier: Apache-2.0
#include "ranks.h"

#include <vtkBoundingBox.h>
#include <vtkCellData.h>
#include <vtkCommunicator.h>
#include <vtkIdList.h>
#include <vtkMatrix4x4.h>
#include <vtkMultiProcessController.h>
#include <vtkNew.h>
#include <vtkPVRenderView.h>
#include <vtkPVRenderViewDataDeliveryManager.h>
#include <vtkPointData.h>
#include <vtkRedistributeDataSetFilter.h>
#include <vtkStaticPointLocator.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ovoid::paraview {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();

// Beyond its box a rank takes this many of its own greatest cells: kernels reach 1.75 spacings, and
// their shapes and weights depend on the cells around those, less with each.
constexpr double kCellsBeyond = 6;

// A particle's kernel reaches to its 32nd neighbour, which reaches as far again for its own.
constexpr int kNeighbours = 32;
constexpr double kReachesBeyond = 2.2;

vtkMultiProcessController* controller() { return vtkMultiProcessController::GetGlobalController(); }

double reduced(double number, int operation) {
  if (!has_several_ranks()) return number;
  double result = number;
  controller()->AllReduce(&number, &result, 1, operation);
  return result;
}

double farthest_neighbour(vtkUnstructuredGrid* points) {
  vtkNew<vtkStaticPointLocator> locator;
  locator->SetDataSet(points);
  locator->BuildLocator();
  vtkNew<vtkIdList> neighbours;
  double farthest = 0;
  for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) {
    const double* const place = points->GetPoint(i);
    const double at[3] = {place[0], place[1], place[2]};
    locator->FindClosestNPoints(kNeighbours, at, neighbours);
    double there[3];
    points->GetPoint(neighbours->GetId(neighbours->GetNumberOfIds() - 1), there);
    const double x = there[0] - at[0], y = there[1] - at[1], z = there[2] - at[2];
    farthest = std::max(farthest, std::sqrt(x * x + y * y + z * z));
  }
  return farthest;
}

// How far beyond its box a rank needs data.
double margin_of(vtkUnstructuredGrid* own) {
  double longest = 0;  // edge of a cell's bounds
  for (vtkIdType c = 0; c < own->GetNumberOfCells(); ++c) {
    double bounds[6];
    own->GetCellBounds(c, bounds);
    for (int axis = 0; axis < 3; ++axis)
      longest = std::max(longest, bounds[2 * axis + 1] - bounds[2 * axis]);
  }
  if (longest > 0) return kCellsBeyond * longest;
  return own->GetNumberOfPoints() > 1 ? kReachesBeyond * farthest_neighbour(own) : 0;
}

// Cells that a neighbour owns are cells like others here.
void forget_duplicates(vtkUnstructuredGrid* grid) {
  const auto forget = [](vtkUnsignedCharArray* flags, unsigned char bit) {
    if (flags == nullptr) return;
    for (vtkIdType i = 0; i < flags->GetNumberOfTuples(); ++i)
      flags->SetValue(i, static_cast<unsigned char>(flags->GetValue(i) & ~bit));
  };
  forget(grid->GetCellGhostArray(), vtkDataSetAttributes::DUPLICATECELL);
  forget(grid->GetPointGhostArray(), vtkDataSetAttributes::DUPLICATEPOINT);
}

}  // namespace

bool has_several_ranks() {
  return controller() != nullptr && controller()->GetNumberOfProcesses() > 1;
}

std::vector<vtkBoundingBox> boxes_of_ranks(vtkView* view) {
  auto* const render_view = vtkPVRenderView::SafeDownCast(view);
  if (render_view == nullptr || !has_several_ranks() || !render_view->GetUseOrderedCompositing())
    return {};
  auto* const manager =
      vtkPVRenderViewDataDeliveryManager::SafeDownCast(render_view->GetDeliveryManager());
  const auto count = static_cast<std::size_t>(controller()->GetNumberOfProcesses());
  if (manager == nullptr || manager->GetCuts().size() != count) return {};
  return manager->GetCuts();
}

std::vector<double> owned_bounds(const std::vector<vtkBoundingBox>& boxes,
                                 vtkMatrix4x4* world_from_data) {
  vtkBoundingBox all;
  for (const vtkBoundingBox& box : boxes) all.AddBox(box);
  std::vector<double> bounds(6);
  boxes[static_cast<std::size_t>(controller()->GetLocalProcessId())].GetBounds(bounds.data());
  double ends[6];
  all.GetBounds(ends);
  // A thousand-millionth of the scene: bounds of pieces are rounded.
  const double rounding = 1e-9 * all.GetDiagonalLength();
  for (std::size_t side = 0; side < 6; ++side) {
    if (std::abs(bounds[side] - ends[side]) > rounding) continue;
    bounds[side] = side % 2 == 0 ? -kEndless : kEndless;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto lo = static_cast<std::size_t>(2 * axis);
    const double scale = world_from_data->GetElement(axis, axis);
    for (const std::size_t side : {lo, lo + 1})
      bounds[side] = scale * bounds[side] + world_from_data->GetElement(axis, 3);
    if (scale < 0) std::swap(bounds[lo], bounds[lo + 1]);
  }
  return bounds;
}

std::vector<double> sums_of_ranks(const std::vector<double>& numbers) {
  std::vector<double> sums = numbers;
  controller()->AllReduce(numbers.data(), sums.data(), static_cast<vtkIdType>(numbers.size()),
                          vtkCommunicator::SUM_OP);
  return sums;
}

double least_of_ranks(double number) { return reduced(number, vtkCommunicator::MIN_OP); }
double greatest_of_ranks(double number) { return reduced(number, vtkCommunicator::MAX_OP); }

vtkSmartPointer<vtkUnstructuredGrid> with_neighbours(vtkUnstructuredGrid* own,
                                                     const std::vector<vtkBoundingBox>& boxes) {
  const double margin = margin_of(own);
  std::vector<double> margins(boxes.size());
  controller()->AllGather(&margin, margins.data(), 1);
  std::vector<vtkBoundingBox> wider = boxes;
  for (std::size_t i = 0; i < wider.size(); ++i) {
    if (wider[i].IsValid()) wider[i].Inflate(margins[i]);
  }
  vtkNew<vtkRedistributeDataSetFilter> exchange;
  exchange->SetController(controller());
  exchange->SetUseExplicitCuts(true);
  exchange->SetExplicitCuts(wider);
  exchange->SetExpandExplicitCuts(true);
  exchange->SetBoundaryModeToAssignToAllIntersectingRegions();
  exchange->SetInputData(own);
  exchange->Update();
  vtkNew<vtkUnstructuredGrid> grid;
  if (auto* const output = vtkUnstructuredGrid::SafeDownCast(exchange->GetOutputDataObject(0)))
    grid->ShallowCopy(output);
  forget_duplicates(grid);
  return grid;
}

}  // namespace ovoid::paraview
