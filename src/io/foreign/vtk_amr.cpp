// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include "io/foreign/vtk_amr.h"

#include <fmt/format.h>
#include <vtkAMREnzoReader.h>
#include <vtkCellData.h>
#include <vtkDataArraySelection.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkOverlappingAMR.h>
#include <vtkUniformGrid.h>

#include <algorithm>

#include "io/foreign/mesh_readers.h"
#include "io/foreign/vtk_reading.h"
#include "ovoid/error.h"

namespace ovoid::io {

AmrGrid amr_grid_of(const std::string& source, vtkImageData* data, int level,
                    std::vector<std::string>& notes) {
  if (!data->GetDirectionMatrix()->IsIdentity()) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: a grid whose axes are turned: expected the world's", source));
  }
  AmrGrid grid;
  grid.source = source;
  grid.level = level;
  grid.origin = Vec3(data->GetOrigin());
  grid.spacing = Vec3(data->GetSpacing());
  for (int axis = 0; axis < 3; ++axis) {
    grid.num_cells[static_cast<std::size_t>(axis)] =
        std::max<std::int64_t>(1, data->GetDimensions()[axis] - 1);
    grid.origin[axis] += data->GetExtent()[2 * axis] * grid.spacing[axis];
  }
  for (VtkArray& array : numbers_of(source, data->GetCellData(), data->GetNumberOfCells(), true)) {
    if (array.numbers)
      grid.arrays.push_back(std::move(*array.numbers));
    else
      notes.push_back(std::move(array.note));
  }
  return grid;
}

Dataset read_enzo(const ByteSource& source, const ReadOptions& options) {
  const std::string ending = ".hierarchy";
  const std::string named = path_for_vtk(source);
  const std::string path = named.ends_with(ending) ? named : named + ending;
  vtkNew<vtkAMREnzoReader> reader;
  reader->ConvertToCGSOff();  // the values are the file's
  reader->SetFileName(path.c_str());
  VtkRun run(source, options);
  run(reader, [&] {
    reader->UpdateInformation();
    reader->GetCellDataArraySelection()->EnableAllArrays();
    constexpr int kAllLevels = 1000;
    reader->SetMaxLevel(kAllLevels);
    reader->Update();
  });
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "Enzo";
  dataset.notes = run.notes;
  vtkOverlappingAMR* const amr = reader->GetOutput();
  std::vector<AmrGrid> grids;
  for (unsigned level = 0; amr != nullptr && level < amr->GetNumberOfLevels(); ++level) {
    for (unsigned i = 0; i < amr->GetNumberOfDataSets(level); ++i) {
      if (vtkUniformGrid* const data = amr->GetDataSet(level, i); data != nullptr)
        grids.push_back(amr_grid_of(source.name(), data, static_cast<int>(level), dataset.notes));
    }
  }
  return boxes_of_grids(std::move(dataset), grids, options);
}

}  // namespace ovoid::io

#endif
