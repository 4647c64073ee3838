// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include <vtkGenericEnSightReader.h>
#include <vtkNew.h>

#include "io/foreign/mesh_readers.h"
#include "io/foreign/vtk_reading.h"
#include "io/foreign/vtk_timed.h"

namespace ovoid::io {

Dataset read_ensight(const ByteSource& source, const ReadOptions& options) {
  vtkNew<vtkGenericEnSightReader> reader;
  reader->SetCaseFileName(path_for_vtk(source).c_str());
  return read_timed(source, "EnSight", reader, options);
}

}  // namespace ovoid::io

#endif
