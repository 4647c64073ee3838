// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include <fmt/format.h>
#include <vtkDataSet.h>
#include <vtkHDFReader.h>
#include <vtkNew.h>

#include "io/foreign/mesh_readers.h"
#include "io/foreign/vtk_reading.h"
#include "io/foreign/vtk_timed.h"
#include "io/vtk/image_ghosts.h"
#include "ovoid/error.h"

namespace ovoid::io {

Dataset read_vtk_hdf(const ByteSource& source, const ReadOptions& options) {
  vtkNew<vtkHDFReader> reader;
  reader->SetFileName(path_for_vtk(source).c_str());
  VtkRun run(source, options);
  run(reader, [&] { reader->Update(); });
  vtkDataSet* const data = reader->GetOutputAsDataSet();
  if (data == nullptr)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: VTK finds no data in it", source.name()));
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "VTKHDF";
  dataset.notes = run.notes;
  dataset = dataset_of(source, data, std::move(dataset), options);
  if (dataset.kind == DatasetKind::kLattice) hide_ghosts(dataset);
  return dataset;
}

}  // namespace ovoid::io

#endif
