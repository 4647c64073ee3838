// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/mesh_readers.h"

#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "io/core/text_scanner.h"
#include "io/foreign/netcdf_header.h"
#include "io/formats.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

std::string enzo_hierarchy(const std::string& path) {
  return path.ends_with(".hierarchy") ? path : path + ".hierarchy";
}

// The HDF5 files of an Enzo hierarchy lie beside it, whatever folder it names.
void check_enzo(const std::string& path) {
  const auto source = open_file(path);
  TextScanner text(*source, 0, source->size());
  std::string last;
  std::int64_t num_files = 0;
  while (auto line = text.line()) {
    const auto parts = words(*line);
    if (parts.size() != 3 || parts[0] != "BaryonFileName" || parts[1] != "=") continue;
    ++num_files;
    const std::string name(std::filesystem::path(parts[2]).filename().string());
    if (name == last) continue;
    last = name;
    const auto file = open_file(path_beside(path, name));
    if (!is_hdf5(file->text(0, 8))) {
      throw Error(
          ErrorCode::kFileFormat,
          fmt::format("{}: is no HDF5 file, {} says it holds its grids", file->name(), path));
    }
    check_hdf5_size(*file);
  }
  if (num_files == 0) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has no BaryonFileName: expected an Enzo hierarchy", path));
  }
}

void check_mesh_file(MeshFile kind, const ByteSource& source) {
  const bool is_new = is_hdf5(source.text(0, 8));
  if (is_new) check_hdf5_size(source);
  if (kind == MeshFile::kExodus && !is_new) check_exodus(source);
  if (kind == MeshFile::kEnzo) check_enzo(enzo_hierarchy(source.name()));
}

}  // namespace

Dataset read_mesh_file(MeshFile kind, const ByteSource& source, const ReadOptions& options) {
  check_mesh_file(kind, source);
#ifdef OVOID_IO_VTK
  switch (kind) {
    case MeshFile::kExodus:
      return read_exodus(source, options);
    case MeshFile::kVtkHdf:
      return read_vtk_hdf(source, options);
    case MeshFile::kEnzo:
      return read_enzo(source, options);
    case MeshFile::kEnSight:
      return read_ensight(source, options);
    case MeshFile::kNone:
      break;
  }
#else
  (void)options;
#endif
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: this build has no VTK and cannot read {} files", source.name(),
                          name_of(kind)));
}

}  // namespace ovoid::io
