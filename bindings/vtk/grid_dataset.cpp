// SPDX-License-Identifier: Apache-2.0
#include "grid_dataset.h"

#include <fmt/format.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkDataSetAttributes.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkRectilinearGrid.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/model.h"

namespace ovoid::mappers {
namespace {

// As files of rectilinear grids are read: a step may differ by this share of their mean.
constexpr double kMaxUnevenness = 1e-4;

LatticeGeometry lattice_of(vtkImageData* image) {
  LatticeGeometry lattice;
  Mat3 linear;
  Vec3 first;
  for (int axis = 0; axis < 3; ++axis) {
    lattice.dims[static_cast<std::size_t>(axis)] = image->GetDimensions()[axis];
    first[axis] = image->GetExtent()[2 * axis];
    for (int row = 0; row < 3; ++row) {
      linear(row, axis) =
          image->GetDirectionMatrix()->GetElement(row, axis) * image->GetSpacing()[axis];
    }
  }
  lattice.world_from_index.linear() = linear;
  lattice.world_from_index.translation() = Vec3(image->GetOrigin()) + linear * first;
  return lattice;
}

// Of one axis, and the relative rounding of each.
std::vector<double> coordinates(vtkRectilinearGrid* grid, int axis, double* rounding) {
  vtkDataArray* const arrays[] = {grid->GetXCoordinates(), grid->GetYCoordinates(),
                                  grid->GetZCoordinates()};
  const vtkIdType count = grid->GetDimensions()[axis];
  if (arrays[axis] == nullptr || arrays[axis]->GetNumberOfTuples() != count) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("vtkRectilinearGrid: {} coordinates: expected {}", "xyz"[axis], count));
  }
  std::vector<double> values(static_cast<std::size_t>(count));
  for (vtkIdType i = 0; i < count; ++i)
    values[static_cast<std::size_t>(i)] = arrays[axis]->GetComponent(i, 0);
  *rounding = arrays[axis]->GetDataType() == VTK_FLOAT ? 0x1p-23 : 0x1p-52;
  return values;
}

// The step that all coordinates keep; 0 for a single one.
std::optional<double> common_step(const std::vector<double>& values, double rounding) {
  if (values.size() == 1) return 0;
  const double step = (values.back() - values.front()) / static_cast<double>(values.size() - 1);
  const double greatest = std::max(std::abs(values.front()), std::abs(values.back()));
  // Half a unit in the last place of each of the three coordinates that are compared.
  const double tolerance = kMaxUnevenness * std::abs(step) + 1.5 * rounding * greatest;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double expected = values.front() + step * static_cast<double>(i);
    if (!(std::abs(values[i] - expected) <= tolerance)) return std::nullopt;
  }
  return step;
}

std::optional<LatticeGeometry> lattice_of(vtkRectilinearGrid* grid) {
  LatticeGeometry lattice;
  Vec3 steps, origin;
  double smallest = 0;  // of the axes that have a step
  for (int axis = 0; axis < 3; ++axis) {
    double rounding = 0;
    const std::vector<double> values = coordinates(grid, axis, &rounding);
    const std::optional<double> step = common_step(values, rounding);
    if (!step) return std::nullopt;
    lattice.dims[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(values.size());
    origin[axis] = values.front();
    steps[axis] = *step;
    if (*step == 0) continue;
    smallest = smallest == 0 ? std::abs(*step) : std::min(smallest, std::abs(*step));
  }
  for (double& step : steps) step = step != 0 ? step : smallest != 0 ? smallest : 1;
  lattice.world_from_index.linear() = steps.asDiagonal();
  lattice.world_from_index.translation() = origin;
  return lattice;
}

template <typename T>
DataArray array_owning(std::string name, std::vector<T> values, ScalarType type) {
  DataArray array;
  const auto owner = std::make_shared<const std::vector<T>>(std::move(values));
  array.name = std::move(name);
  array.type = type;
  array.bytes = {owner, std::as_bytes(std::span(*owner))};
  return array;
}

// The positions of a grid of uneven steps, of which the cells are made.
void make_mesh(vtkRectilinearGrid* grid, const Affine3& world_from_data, Dataset& dataset) {
  dataset.kind = DatasetKind::kMesh;
  std::vector<double> places;
  places.reserve(static_cast<std::size_t>(grid->GetNumberOfPoints()) * 3);
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
    const Vec3 place = world_from_data * Vec3(grid->GetPoint(i));
    places.insert(places.end(), place.begin(), place.end());
  }
  dataset.positions = array_owning("positions", std::move(places), ScalarType::kFloat64);
  dataset.positions.num_components = 3;
  dataset.positions.num_tuples = grid->GetNumberOfPoints();
  for (std::size_t axis = 0; axis < 3; ++axis)
    dataset.cells.dims[axis] = grid->GetDimensions()[axis];
}

// The values of a blanked point or cell are missing. Null where none is blanked.
vtkUnsignedCharArray* blanks(vtkDataSet* grid, bool is_cell_data, unsigned char* hidden) {
  *hidden = vtkDataSetAttributes::HIDDENPOINT;
  if (is_cell_data) *hidden = vtkDataSetAttributes::HIDDENCELL;
  vtkUnsignedCharArray* const flags =
      is_cell_data ? grid->GetCellGhostArray() : grid->GetPointGhostArray();
  const vtkIdType expected = is_cell_data ? grid->GetNumberOfCells() : grid->GetNumberOfPoints();
  if (flags == nullptr || flags->GetNumberOfTuples() != expected) return nullptr;
  for (vtkIdType i = 0; i < flags->GetNumberOfTuples(); ++i) {
    if ((flags->GetValue(i) & *hidden) != 0) return flags;
  }
  return nullptr;
}

DataArray without_blanks(const DrawnValues& drawn, vtkUnsignedCharArray* flags,
                         unsigned char hidden) {
  const int count = drawn.array->GetNumberOfComponents();
  std::vector<float> values(static_cast<std::size_t>(drawn.array->GetNumberOfValues()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto tuple = static_cast<vtkIdType>(i) / count;
    values[i] = (flags->GetValue(tuple) & hidden) != 0
                    ? std::numeric_limits<float>::quiet_NaN()
                    : static_cast<float>(drawn.array->GetComponent(
                          tuple, static_cast<int>(i % static_cast<std::size_t>(count))));
  }
  const char* const name = drawn.array->GetName();
  DataArray array =
      array_owning(name != nullptr ? name : "(unnamed)", std::move(values), ScalarType::kFloat32);
  array.num_components = count;
  array.num_tuples = drawn.array->GetNumberOfTuples();
  array.is_cell_data = drawn.is_cell_data;
  return array;
}

}  // namespace

Dataset grid_dataset(vtkDataSet* grid, const DrawnValues& drawn, const Affine3& world_from_data) {
  auto* const image = vtkImageData::SafeDownCast(grid);
  auto* const rectilinear = vtkRectilinearGrid::SafeDownCast(grid);
  if (image == nullptr && rectilinear == nullptr) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("a {} is not drawn: expected vtkImageData or vtkRectilinearGrid",
                            grid->GetClassName()));
  }
  Dataset dataset;
  dataset.source = grid->GetClassName();
  dataset.format = "VTK";
  const auto lattice =
      image != nullptr ? std::optional(lattice_of(image)) : lattice_of(rectilinear);
  if (lattice)
    dataset.lattice = *lattice;
  else
    make_mesh(rectilinear, world_from_data, dataset);
  unsigned char hidden = 0;
  vtkUnsignedCharArray* const flags = blanks(grid, drawn.is_cell_data, &hidden);
  dataset.arrays = {flags != nullptr ? without_blanks(drawn, flags, hidden)
                                     : shared_array(drawn.array, drawn.is_cell_data)};
  return dataset;
}

}  // namespace ovoid::mappers
