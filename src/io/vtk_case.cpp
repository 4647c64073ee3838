// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include <vtkGenericEnSightReader.h>
#include <vtkNew.h>

#include "io/mesh_files.h"
#include "io/vtk_timed.h"

namespace ovoid::io {

Dataset read_ensight(const ByteSource& source, const ReadOptions& options) {
  vtkNew<vtkGenericEnSightReader> reader;
  reader->SetCaseFileName(source.name().c_str());
  return read_timed(source, "EnSight", reader, options);
}

}  // namespace ovoid::io

#endif
