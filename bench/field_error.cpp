// SPDX-License-Identifier: Apache-2.0
// What turning a mesh into kernels costs in accuracy: field_error FILE...
//
// The reference is the mesh's own interpolation inside its cells, which VTK evaluates; values of
// cells are first averaged at the nodes, as VTK would. Of vectors the first component counts, as in
// Ovoid's pictures. Places are drawn evenly over the mesh's volume, or evenly over its cells;
// "inside" are those in cells that have no node on the mesh's surface. Prints JSON:
//
//   psnr_db         of the array, over the volume: 20 log10(range / rms error), with the fitted
//                   ellipsoids; and with balls of the same volumes in their place, so that the
//                   difference is what the shapes do
//   psnr_of_means_db  of an array of cells: kernels at the nodes, of the means there, so that both
//                   sides say the same
//   linear          the same for the coordinates x, y, z as values, the worst of them, inside: rms
//                   and 99 % quantile of the error in % of the range. Interpolation in the cells is
//                   exact there, so that all of it comes from the kernels.
//   constant        sums of f = 1 inside: mean and relative standard deviation
#include <vtkCellData.h>
#include <vtkCellSizeFilter.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkDoubleArray.h>
#include <vtkGenericCell.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "ovoid/io.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"

namespace {

using Json = nlohmann::json;
using ovoid::Vec3;

// A column of numbers by node.
std::vector<double> numbers_of(const ovoid::DataArray& array, int component) {
  std::vector<double> numbers(static_cast<std::size_t>(array.num_tuples));
  const auto stride = static_cast<std::size_t>(array.num_components);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t at = i * stride + static_cast<std::size_t>(component);
    if (array.type == ovoid::ScalarType::kFloat64) {
      std::memcpy(&numbers[i], array.bytes.view.data() + at * sizeof(double), sizeof(double));
    } else if (array.type == ovoid::ScalarType::kFloat32) {
      float number = 0;
      std::memcpy(&number, array.bytes.view.data() + at * sizeof(float), sizeof(float));
      numbers[i] = number;
    } else {
      throw std::runtime_error(array.name + ": only floating-point arrays are measured");
    }
  }
  return numbers;
}

ovoid::DataArray array_from(std::string name, std::vector<double> numbers) {
  const auto owner = std::make_shared<std::vector<double>>(std::move(numbers));
  ovoid::DataArray array;
  array.name = std::move(name);
  array.type = ovoid::ScalarType::kFloat64;
  array.num_tuples = static_cast<std::int64_t>(owner->size());
  array.bytes = {owner, std::as_bytes(std::span(*owner))};
  return array;
}

int vtk_type(ovoid::CellType type) {
  switch (type) {
    case ovoid::CellType::kTetrahedron:
      return VTK_TETRA;
    case ovoid::CellType::kHexahedron:
      return VTK_HEXAHEDRON;
    case ovoid::CellType::kVoxel:
      return VTK_VOXEL;
    case ovoid::CellType::kWedge:
      return VTK_WEDGE;
    case ovoid::CellType::kPyramid:
      return VTK_PYRAMID;
    default:
      return VTK_EMPTY_CELL;
  }
}

// The mesh's solid cells as VTK's.
vtkSmartPointer<vtkUnstructuredGrid> grid_of(const ovoid::Dataset& mesh) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int axis = 0; axis < 3; ++axis) {
    const auto column = numbers_of(mesh.positions, axis);
    points->SetNumberOfPoints(static_cast<vtkIdType>(column.size()));
    for (std::size_t i = 0; i < column.size(); ++i)
      points->GetData()->SetComponent(static_cast<vtkIdType>(i), axis, column[i]);
  }
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->Allocate(mesh.cells.count());
  const ovoid::Cells& cells = mesh.cells;
  if (cells.is_structured()) {
    const vtkIdType nx = cells.dims[0], ny = cells.dims[1], nz = cells.dims[2];
    for (vtkIdType k = 0; k + 1 < nz; ++k) {
      for (vtkIdType j = 0; j + 1 < ny; ++j) {
        for (vtkIdType i = 0; i + 1 < nx; ++i) {
          const vtkIdType a = i + nx * (j + ny * k), up = nx * ny;
          const std::array<vtkIdType, 8> corners{a,      a + 1,      a + 1 + nx,      a + nx,
                                                 a + up, a + 1 + up, a + 1 + nx + up, a + nx + up};
          grid->InsertNextCell(VTK_HEXAHEDRON, 8, corners.data());
        }
      }
    }
    return grid;
  }
  for (std::size_t c = 0; c < cells.types.size(); ++c) {
    const int type = vtk_type(cells.types[c]);
    if (type == VTK_EMPTY_CELL) continue;
    const std::vector<vtkIdType> corners(cells.connectivity.begin() + cells.offsets[c],
                                         cells.connectivity.begin() + cells.offsets[c + 1]);
    grid->InsertNextCell(type, static_cast<vtkIdType>(corners.size()), corners.data());
  }
  if (grid->GetNumberOfCells() == 0)
    throw std::runtime_error(mesh.source + ": has no linear solid cells");
  return grid;
}

std::vector<bool> nodes_on_surface(vtkUnstructuredGrid* grid) {
  vtkNew<vtkDataSetSurfaceFilter> surface;
  surface->SetInputData(grid);
  surface->PassThroughPointIdsOn();
  surface->Update();
  auto* ids = vtkIdTypeArray::SafeDownCast(
      surface->GetOutput()->GetPointData()->GetArray(surface->GetOriginalPointIdsName()));
  std::vector<bool> is_on(static_cast<std::size_t>(grid->GetNumberOfPoints()));
  for (vtkIdType i = 0; i < ids->GetNumberOfTuples(); ++i)
    is_on[static_cast<std::size_t>(ids->GetValue(i))] = true;
  return is_on;
}

std::vector<double> volumes_of(vtkUnstructuredGrid* grid) {
  vtkNew<vtkCellSizeFilter> size;
  size->SetInputData(grid);
  size->Update();
  vtkDataArray* column =
      vtkDataSet::SafeDownCast(size->GetOutput())->GetCellData()->GetArray("Volume");
  std::vector<double> volumes(static_cast<std::size_t>(column->GetNumberOfTuples()));
  for (std::size_t c = 0; c < volumes.size(); ++c)
    volumes[c] = std::abs(column->GetComponent(static_cast<vtkIdType>(c), 0));
  return volumes;
}

// A place in a cell and what its nodes count for there.
struct Place {
  Vec3 at;
  std::vector<std::pair<std::size_t, double>> nodes;
  bool is_inside = false;

  double interpolated(const std::vector<double>& values) const {
    double sum = 0;
    for (const auto& [node, weight] : nodes) sum += weight * values[node];
    return sum;
  }
};

// `share` of each cell: its chance of being drawn.
std::vector<Place> draw_places(vtkUnstructuredGrid* grid, const std::vector<double>& share,
                               int count) {
  const std::vector<bool> is_surface = nodes_on_surface(grid);
  std::mt19937_64 random(20240229);
  std::discrete_distribution<vtkIdType> cells(share.begin(), share.end());
  std::uniform_real_distribution<double> unit;
  std::vector<Place> places(static_cast<std::size_t>(count));
  vtkNew<vtkGenericCell> cell;
  std::array<double, 8> weights{};
  for (Place& place : places) {
    grid->GetCell(cells(random), cell);
    std::array<double, 3> within{};
    do {
      for (double& w : within) w = unit(random);
    } while ((cell->GetCellType() == VTK_TETRA && within[0] + within[1] + within[2] > 1) ||
             (cell->GetCellType() == VTK_WEDGE && within[0] + within[1] > 1));
    int part = 0;
    cell->EvaluateLocation(part, within.data(), place.at.data(), weights.data());
    place.is_inside = true;
    for (int i = 0; i < static_cast<int>(cell->GetNumberOfPoints()); ++i) {
      const auto node = static_cast<std::size_t>(cell->GetPointId(i));
      place.nodes.emplace_back(node, weights[static_cast<std::size_t>(i)]);
      if (is_surface[node]) place.is_inside = false;
    }
  }
  return places;
}

struct Errors {
  double rms = 0, quantile99 = 0;
  std::int64_t count = 0, undefined = 0;
};

Errors errors_of(const ovoid::KernelField& field, const std::vector<double>& values,
                 const std::vector<Place>& places, bool only_inside) {
  const ovoid::FieldSampler sampler{ovoid::Field(field)};
  std::vector<double> off;
  Errors errors;
  double squares = 0;
  for (const Place& place : places) {
    if (only_inside && !place.is_inside) continue;
    const double wanted = place.interpolated(values);
    if (std::isnan(wanted)) continue;
    const ovoid::FieldSample sample = sampler.at(place.at);
    if (!sample.is_defined) {
      ++errors.undefined;
      continue;
    }
    const double error = std::abs(sample.value - wanted);
    off.push_back(error);
    squares += error * error;
  }
  errors.count = static_cast<std::int64_t>(off.size());
  if (off.empty()) return errors;
  errors.rms = std::sqrt(squares / static_cast<double>(off.size()));
  const auto at = off.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(off.size()));
  std::nth_element(off.begin(), at, off.end());
  errors.quantile99 = *at;
  return errors;
}

double range_of(const std::vector<double>& values) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values) {
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  }
  return high - low;
}

double psnr(const Errors& errors, double range) { return 20 * std::log10(range / errors.rms); }

ovoid::KernelField field_of(const ovoid::Dataset& mesh, const std::string& array) {
  ovoid::KernelModelOptions options;
  options.array = array;
  return ovoid::make_kernel_field(mesh, options);
}

// Every ellipsoid made a ball of its volume.
ovoid::KernelField with_balls(const ovoid::KernelField& field) {
  ovoid::Dataset kernels = ovoid::make_kernel_dataset(field);
  for (ovoid::DataArray& array : kernels.arrays) {
    if (array.name != "scale") continue;
    const auto scales = std::make_shared<std::vector<float>>(
        reinterpret_cast<const float*>(array.bytes.view.data()),
        reinterpret_cast<const float*>(array.bytes.view.data() + array.bytes.view.size()));
    for (std::size_t i = 0; i + 2 < scales->size(); i += 3) {
      float* const s = scales->data() + i;
      s[0] = s[1] = s[2] = std::cbrt(s[0] * s[1] * s[2]);
    }
    array.bytes = {scales, std::as_bytes(std::span(*scales))};
  }
  ovoid::KernelModelOptions options;
  options.array = field.source().attributes()[0].name;
  options.cutoff = field.source().cutoff();
  options.reconstruction = field.reconstruction();
  return ovoid::make_kernel_field(kernels, options);
}

Json linear_errors(const ovoid::Dataset& mesh, const std::vector<Place>& places) {
  double rms = 0, quantile = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto values = numbers_of(mesh.positions, axis);
    ovoid::Dataset copy = mesh;
    copy.arrays = {array_from("coordinate", values)};
    const Errors errors = errors_of(field_of(copy, "coordinate"), values, places, true);
    rms = std::max(rms, 100 * errors.rms / range_of(values));
    quantile = std::max(quantile, 100 * errors.quantile99 / range_of(values));
  }
  return {{"rms_percent", rms}, {"quantile99_percent", quantile}};
}

Json constant_sums(const ovoid::Dataset& mesh, const std::vector<Place>& places) {
  ovoid::Dataset copy = mesh;
  copy.arrays = {
      array_from("one", std::vector<double>(static_cast<std::size_t>(mesh.num_positions()), 1))};
  const ovoid::FieldSampler sampler{ovoid::Field(field_of(copy, "one"))};
  double sum = 0, squares = 0, count = 0;
  for (const Place& place : places) {
    if (!place.is_inside) continue;
    const double weight = sampler.at(place.at).weight;
    sum += weight;
    squares += weight * weight;
    ++count;
  }
  const double mean = sum / count;
  return {{"mean", mean},
          {"deviation", std::sqrt(std::max(squares / count - mean * mean, 0.0)) / mean}};
}

// Values at the nodes: the mean over the cells around, of an array of cells.
std::vector<double> node_values(const ovoid::DataArray& array, vtkUnstructuredGrid* grid) {
  std::vector<double> numbers = numbers_of(array, 0);
  if (!array.is_cell_data) return numbers;
  if (static_cast<vtkIdType>(numbers.size()) != grid->GetNumberOfCells())
    throw std::runtime_error(array.name + ": of cells that are not all linear and solid");
  std::vector<double> sums(static_cast<std::size_t>(grid->GetNumberOfPoints())), counts(sums);
  vtkNew<vtkIdList> nodes;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    grid->GetCellPoints(c, nodes);
    for (vtkIdType i = 0; i < nodes->GetNumberOfIds(); ++i) {
      const auto node = static_cast<std::size_t>(nodes->GetId(i));
      sums[node] += numbers[static_cast<std::size_t>(c)];
      ++counts[node];
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] /= counts[i];
  return sums;
}

Json measure(const std::vector<std::string>& paths, const std::string& name, int count) {
  const ovoid::Dataset mesh = ovoid::read_dataset(paths);
  if (mesh.kind != ovoid::DatasetKind::kMesh)
    throw std::runtime_error(mesh.source + ": not a mesh");
  const ovoid::DataArray& array = mesh.array(name);
  const auto grid = grid_of(mesh);
  const std::vector<double> values = node_values(array, grid);
  const std::vector<double> volumes = volumes_of(grid);
  const ovoid::KernelField field = field_of(mesh, array.name), balls = with_balls(field);
  std::optional<ovoid::KernelField> of_means;
  if (array.is_cell_data) {
    ovoid::Dataset copy = mesh;
    copy.arrays = {array_from("means", values)};
    of_means = field_of(copy, "means");
  }
  const double range = range_of(values);
  Json report{{"mesh", mesh.source},
              {"array", array.name},
              {"cells", grid->GetNumberOfCells()},
              {"kernels", field.source().num_kernels()}};
  const std::pair<const char*, std::vector<double>> drawn[] = {
      {"volume", volumes}, {"cells", std::vector<double>(volumes.size(), 1)}};
  for (const auto& [by, share] : drawn) {
    const std::vector<Place> places = draw_places(grid, share, count);
    const Errors all = errors_of(field, values, places, false);
    const auto inside = std::count_if(places.begin(), places.end(),
                                      [](const Place& place) { return place.is_inside; });
    Json& row = report["by_" + std::string(by)];
    if (array.is_cell_data)
      row["psnr_of_means_db"] = psnr(errors_of(*of_means, values, places, false), range);
    row.update(Json{{"psnr_db", psnr(all, range)},
                    {"psnr_balls_db", psnr(errors_of(balls, values, places, false), range)},
                    {"undefined", all.undefined},
                    {"inside", static_cast<double>(inside) / count}});
    if (inside == 0) continue;
    row["psnr_inside_db"] = psnr(errors_of(field, values, places, true), range);
    row["linear"] = linear_errors(mesh, places);
    row["constant"] = constant_sums(mesh, places);
  }
  return report;
}

}  // namespace

int main(int argc, char** argv) try {
  std::vector<std::string> paths;
  std::string array;
  int places = 100'000;
  CLI::App app("Kernels against interpolation in a mesh's cells");
  app.add_option("files", paths, "of one mesh, as for `ovoid render`")->required();
  app.add_option("--array", array, "of the nodes; default: Ovoid's");
  app.add_option("--places", places, "where both are evaluated")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  std::cout << measure(paths, array, places).dump(1) << '\n';
} catch (const std::exception& error) {
  std::cerr << "field_error: " << error.what() << '\n';
  return 1;
}
