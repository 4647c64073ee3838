// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include <vtkGenericEnSightReader.h>
#include <vtkNew.h>
#include <vtkOpenFOAMReader.h>

#include "io/mesh_files.h"
#include "io/vtk_timed.h"

namespace ovoid::io {

Dataset read_ensight(const ByteSource& source, const ReadOptions& options) {
  vtkNew<vtkGenericEnSightReader> reader;
  reader->SetCaseFileName(source.name().c_str());
  return read_timed(source, "EnSight", reader, options);
}

Dataset read_openfoam(const ByteSource& source, const ReadOptions& options) {
  vtkNew<vtkOpenFOAMReader> reader;
  reader->SetFileName(source.name().c_str());
  // The patches bound the mesh and have no volume.
  const auto set_up = [&] {
    reader->DisableAllPatchArrays();
    reader->SetPatchArrayStatus("internalMesh", 1);
    reader->EnableAllCellArrays();
    reader->EnableAllPointArrays();
  };
  return read_timed(source, "OpenFOAM", reader, options, set_up);
}

}  // namespace ovoid::io

#endif
