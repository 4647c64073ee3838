// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK
#include "io/foreign/vtk_surface.h"

#include <fmt/format.h>
#include <vtkNew.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkTriangleFilter.h>

#include <utility>
#include <vector>

#include "io/foreign/vtk_mesh.h"
#include "io/foreign/vtk_reading.h"
#include "ovoid/error.h"

namespace ovoid::io {

Dataset read_ply_faces(const ByteSource& source, const ReadOptions& options) {
  VtkRun run(source, options);
  vtkNew<vtkPLYReader> reader;
  reader->SetFileName(path_for_vtk(source).c_str());
  run(reader, [&] { reader->Update(); });
  vtkNew<vtkTriangleFilter> triangles;
  triangles->PassVertsOff();
  triangles->PassLinesOff();
  triangles->SetInputConnection(reader->GetOutputPort());
  run(triangles, [&] { triangles->Update(); });
  vtkPolyData* const faces = triangles->GetOutput();
  if (faces->GetNumberOfPolys() == 0)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no faces", source.name()));
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "PLY surfaces";
  dataset.notes = std::move(run.notes);
  std::vector<MeshPart> parts;
  parts.push_back(part_of(source.name(), faces, dataset.notes));
  ReadOptions of_faces = options;
  of_faces.faces = true;
  return mesh_of_parts(std::move(dataset), std::move(parts), of_faces);
}

}  // namespace ovoid::io

#endif
