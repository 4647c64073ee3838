// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include "io/foreign/vtk_image.h"

#include <fmt/format.h>

#include "ovoid/error.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPointData.h>
#include <vtkRectilinearGrid.h>

#include <algorithm>
#include <vector>

#include "io/core/samples.h"
#include "io/foreign/vtk_leaf.h"
#include "io/foreign/vtk_mesh.h"
#include "io/foreign/vtk_reading.h"
#include "io/foreign/vtk_timed.h"
#include "io/meshes/mesh_parts.h"
#include "io/vtk/image_ghosts.h"
#include "io/vtk/rectilinear.h"

namespace ovoid::io {
namespace {

// The image's lattice, with index 0 at its first sample whatever its extent.
LatticeGeometry lattice_of(const ByteSource& source, vtkImageData* image) {
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
  check_geometry(source.name() + ": Spacing, Direction or Origin", lattice.world_from_index);
  return lattice;
}

std::optional<LatticeGeometry> lattice_of(const ByteSource& source, vtkRectilinearGrid* grid) {
  std::array<AxisCoordinates, 3> axes;
  vtkDataArray* const arrays[] = {grid->GetXCoordinates(), grid->GetYCoordinates(),
                                  grid->GetZCoordinates()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const vtkIdType count = grid->GetDimensions()[axis];
    if (arrays[axis] == nullptr || arrays[axis]->GetNumberOfTuples() != count ||
        arrays[axis]->GetNumberOfComponents() != 1) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: VTK finds no {} coordinates for {} samples", source.name(),
                              "xyz"[axis], count));
    }
    axes[axis].is_float32 = arrays[axis]->GetDataType() == VTK_FLOAT;
    for (vtkIdType i = 0; i < count; ++i)
      axes[axis].values.push_back(arrays[axis]->GetComponent(i, 0));
  }
  return lattice_of_coordinates(source.name(), axes);
}

// Empty for a rectilinear grid of unequal spacing.
std::optional<LatticeGeometry> lattice_of(const ByteSource& source, vtkDataSet* data) {
  if (auto* const grid = vtkRectilinearGrid::SafeDownCast(data)) return lattice_of(source, grid);
  return lattice_of(source, vtkImageData::SafeDownCast(data));
}

// Takes over the arrays of points or cells that hold numbers, one tuple for each sample, and
// ghosts, whatever is wanted; adds the names of those that it could take to `names`.
void add_arrays(Dataset& dataset, vtkFieldData* fields, std::int64_t num_expected,
                bool is_cell_data, const std::string& wanted, std::vector<std::string>& names) {
  for (VtkArray& array : numbers_of(dataset.source, fields, num_expected, is_cell_data)) {
    const bool is_of_ghosts = array.numbers && is_ghost_array(*array.numbers);
    const bool is_wanted = wanted.empty() || array.name == wanted || is_of_ghosts;
    if (array.numbers && !is_of_ghosts) names.push_back(array.name);
    if (!is_wanted) continue;
    if (array.numbers)
      dataset.arrays.push_back(std::move(*array.numbers));
    else
      dataset.notes.push_back(std::move(array.note));
  }
}

Dataset lattice_of_leaf(const ByteSource& source, vtkDataSet* image, LatticeGeometry lattice,
                        Dataset dataset, const ReadOptions& options) {
  dataset.lattice = std::move(lattice);
  std::vector<std::string> names;
  add_arrays(dataset, image->GetPointData(), image->GetNumberOfPoints(), false, options.array,
             names);
  add_arrays(dataset, image->GetCellData(), image->GetNumberOfCells(), true, options.array, names);
  const bool is_found = !std::all_of(dataset.arrays.begin(), dataset.arrays.end(), is_ghost_array);
  if (!is_found && !names.empty()) throw_no_array(source, options.array, names);
  if (!is_found) {
    throw Error(
        options.array.empty() ? ErrorCode::kFileFormat : ErrorCode::kInvalidArgument,
        fmt::format("{}: {}", source.name(),
                    options.array.empty() ? "has no array of numbers"
                                          : "has no array '" + options.array + "' of numbers"));
  }
  if (vtkDataArray* const time = image->GetFieldData()->GetArray("TimeValue");
      time != nullptr && time->GetNumberOfTuples() == 1) {
    dataset.times.push_back(time->GetComponent(0, 0));
  }
  shorten_notes(dataset.notes);
  return dataset;
}

}  // namespace

Dataset read_vtk_file(const ByteSource& source, bool is_xml, const ReadOptions& options) {
  VtkRun run(source, options);
  VtkLeaf leaf = read_vtk_leaf(source, is_xml, options, run);
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = format_of_leaf(leaf.grid, is_xml);
  dataset.notes = std::move(run.notes);
  dataset = dataset_of(source, leaf.data, std::move(dataset), options);
  if (dataset.kind == DatasetKind::kLattice) hide_ghosts(dataset);
  if (dataset.kind != DatasetKind::kParticles || !leaf.has_one_array) return dataset;
  // That its cells are vertices is known only now. What was read is let go first.
  leaf = {};
  dataset = {};
  ReadOptions all = options;
  all.array.clear();
  return read_vtk_file(source, is_xml, all);
}

Dataset dataset_of(const ByteSource& source, vtkDataSet* data, Dataset dataset,
                   const ReadOptions& options) {
  const bool may_be_lattice = vtkImageData::SafeDownCast(data) != nullptr ||
                              vtkRectilinearGrid::SafeDownCast(data) != nullptr;
  if (may_be_lattice && data->GetNumberOfPoints() < 1)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: VTK finds no image in it", source.name()));
  auto lattice = may_be_lattice ? lattice_of(source, data) : std::nullopt;
  if (lattice)
    return lattice_of_leaf(source, data, std::move(*lattice), std::move(dataset), options);
  std::vector<MeshPart> parts;
  parts.push_back(part_of(source.name(), data, dataset.notes));
  return mesh_of_parts(std::move(dataset), std::move(parts), options);
}

}  // namespace ovoid::io

#endif
