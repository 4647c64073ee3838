// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/mesh_files.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "io/formats.h"

namespace ovoid::io {
namespace {

bool is_exodus_ending(const std::string& ending) {
  constexpr std::array<std::string_view, 6> kEndings{".e", ".ex2", ".exo", ".exii", ".ex2v2", ".g"};
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

// The names of a file's root stand close to its begin in what VTK and h5py write.
bool has_vtk_group(const ByteSource& source) {
  constexpr std::int64_t kSearched = 1 << 16;
  return source.text(0, kSearched).find("VTKHDF") != std::string::npos;
}

}  // namespace

const char* name_of(MeshFile kind) noexcept {
  switch (kind) {
    case MeshFile::kNone:
      return "";
    case MeshFile::kExodus:
      return "Exodus";
    case MeshFile::kVtkHdf:
      return "VTKHDF";
    case MeshFile::kEnzo:
      return "Enzo";
    case MeshFile::kEnSight:
      return "EnSight";
  }
  return "";
}

MeshFile mesh_file_of(const ByteSource& source, std::string_view start) {
  const std::string ending = ending_of(source.name());
  if (start.starts_with("CDF\x01") || start.starts_with("CDF\x02") || start.starts_with("CDF\x05"))
    return MeshFile::kExodus;
  if (is_hdf5(start)) {
    if (is_exodus_ending(ending)) return MeshFile::kExodus;
    return has_vtk_group(source) ? MeshFile::kVtkHdf : MeshFile::kNone;
  }
  std::error_code ignored;
  if (ending == ".hierarchy" || (start.find(" = ") != std::string_view::npos &&
                                 std::filesystem::exists(source.name() + ".hierarchy", ignored)))
    return MeshFile::kEnzo;
  if (ending == ".case" || ending == ".encas") return MeshFile::kEnSight;
  return MeshFile::kNone;
}

}  // namespace ovoid::io
