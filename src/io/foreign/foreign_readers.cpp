// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/foreign_readers.h"

#include <memory>

#include "io/core/byte_source.h"
#include "io/dicom/dicom.h"
#include "io/foreign/gdcm_codec.h"
#include "io/foreign/hdf5_lattice.h"
#include "io/foreign/hdf5_points.h"
#include "io/foreign/mesh_readers.h"
#include "io/foreign/vtk_sets.h"
#include "ovoid/error.h"

namespace ovoid::io {

Dataset read_here(const ReaderRequest& request) {
  const ReadOptions& options = request.options;
  if (request.paths.empty())
    throw Error(ErrorCode::kInvalidArgument, request.source + ": no file is named");
  if (request.format == ForeignFormat::kDicom) {
    use_gdcm();
    return read_dicom(request.source, request.paths, options);
  }
  const std::unique_ptr<ByteSource> source = open_file(request.paths.front());
  switch (request.format) {
    case ForeignFormat::kVtk:
#ifdef OVOID_IO_VTK
      return read_vtk(*source, options);
#else
      throw Error(ErrorCode::kUnsupported,
                  request.source + ": this build has no VTK and cannot read VTK files");
#endif
    case ForeignFormat::kExodus:
      return read_mesh_file(MeshFile::kExodus, *source, options);
    case ForeignFormat::kVtkHdf:
      return read_mesh_file(MeshFile::kVtkHdf, *source, options);
    case ForeignFormat::kEnzo:
      return read_mesh_file(MeshFile::kEnzo, *source, options);
    case ForeignFormat::kEnSight:
      return read_mesh_file(MeshFile::kEnSight, *source, options);
    case ForeignFormat::kHdf5:
    case ForeignFormat::kDicom:
      break;
  }
  if (is_hdf5_lattice(*source)) return read_hdf5_lattice(*source, options);
  return read_hdf5_points(*source, options);
}

}  // namespace ovoid::io
