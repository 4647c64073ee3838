// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK
#include "io/foreign/vtk_surface.h"

#include <fmt/format.h>
#include <vtkCompositeDataGeometryFilter.h>
#include <vtkGLTFReader.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkTriangleFilter.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "io/core/text_scanner.h"
#include "io/foreign/vtk_mesh.h"
#include "io/foreign/vtk_reading.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kStlHeader = 84;    // bytes, with the number of triangles at the end
constexpr std::int64_t kStlTriangle = 50;  // bytes

// Runs a reader to its triangles.
Dataset triangles_of(const ByteSource& source, const ReadOptions& options, const char* format,
                     vtkAlgorithm* reader, vtkAlgorithm* to_polygons) {
  VtkRun run(source, options);
  vtkNew<vtkTriangleFilter> triangles;
  triangles->PassVertsOff();
  triangles->PassLinesOff();
  run(reader, [&] { reader->Update(); });
  if (to_polygons != nullptr) to_polygons->SetInputConnection(reader->GetOutputPort());
  triangles->SetInputConnection((to_polygons != nullptr ? to_polygons : reader)->GetOutputPort());
  run(triangles, [&] { triangles->Update(); });
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = format;
  dataset.notes = std::move(run.notes);
  vtkPolyData* const faces = triangles->GetOutput();
  if (faces->GetNumberOfPolys() == 0)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no faces", source.name()));
  std::vector<MeshPart> parts;
  parts.push_back(part_of(source.name(), faces, dataset.notes));
  std::erase_if(parts.back().arrays,
                [](const DataArray& array) { return array.name.starts_with("STL"); });
  ReadOptions of_faces = options;
  of_faces.faces = true;
  return mesh_of_parts(std::move(dataset), std::move(parts), of_faces);
}

template <class Reader>
Dataset read_named(const ByteSource& source, const ReadOptions& options, const char* format) {
  vtkNew<Reader> reader;
  reader->SetFileName(path_for_vtk(source).c_str());
  return triangles_of(source, options, format, reader, nullptr);
}

}  // namespace

void check_stl(const ByteSource& source) {
  const std::string start = source.text(0, kStlHeader);
  const std::int64_t size = source.size();
  if (size >= kStlHeader) {
    std::uint32_t count = 0;
    std::memcpy(&count, start.data() + kStlHeader - 4, sizeof(count));
    if (size >= kStlHeader + kStlTriangle * std::int64_t{count} && count > 0) return;
  }
  if (lower(trimmed(start.substr(0, 6))).starts_with("solid")) return;
  throw Error(
      ErrorCode::kFileFormat,
      fmt::format("{}: is no STL file: neither text that begins with 'solid', nor as long as "
                  "its number of triangles says",
                  source.name()));
}

Dataset read_stl(const ByteSource& source, const ReadOptions& options) {
  return read_named<vtkSTLReader>(source, options, "STL");
}

Dataset read_obj(const ByteSource& source, const ReadOptions& options) {
  return read_named<vtkOBJReader>(source, options, "OBJ");
}

Dataset read_ply_faces(const ByteSource& source, const ReadOptions& options) {
  return read_named<vtkPLYReader>(source, options, "PLY: surfaces");
}

Dataset read_gltf(const ByteSource& source, const ReadOptions& options) {
  vtkNew<vtkGLTFReader> reader;
  reader->SetFileName(path_for_vtk(source).c_str());
  vtkNew<vtkCompositeDataGeometryFilter> polygons;
  return triangles_of(source, options, "glTF", reader, polygons);
}

}  // namespace ovoid::io

#endif
