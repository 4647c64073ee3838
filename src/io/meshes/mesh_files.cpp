// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/mesh_files.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "io/core/signatures.h"
#include "io/netcdf/netcdf_header.h"
#include "ovoid/error.h"

namespace ovoid::io {

bool is_exodus(const ByteSource& source, std::string_view start) {
  const bool is_netcdf = begins_like_netcdf(start);
  if (!is_netcdf && !is_hdf5(start)) return false;
  if (is_netcdf) {
    try {
      return is_exodus_header(read_netcdf_header(source));
    } catch (const Error&) {
      // Broken: by its name.
    }
  }
  return std::find(kExodusEndings.begin(), kExodusEndings.end(), ending_of(source.name())) !=
         kExodusEndings.end();
}

bool is_vtk_hdf(const ByteSource& source, std::string_view start) {
  // The names of a file's root stand close to its begin in what VTK and h5py write.
  constexpr std::int64_t kSearched = 1 << 16;
  return is_hdf5(start) && !is_exodus(source, start) &&
         source.text(0, kSearched).find("VTKHDF") != std::string::npos;
}

bool is_enzo(const ByteSource& source, std::string_view start) {
  std::error_code ignored;
  return ending_of(source.name()) == ".hierarchy" ||
         (start.find(" = ") != std::string_view::npos &&
          std::filesystem::exists(source.name() + ".hierarchy", ignored));
}

bool is_stl(const ByteSource& source, std::string_view) {
  return ending_of(source.name()) == ".stl";
}

bool is_obj(const ByteSource& source, std::string_view) {
  return ending_of(source.name()) == ".obj";
}

bool is_ensight(const ByteSource& source, std::string_view) {
  const std::string ending = ending_of(source.name());
  return ending == ".case" || ending == ".encas";
}

}  // namespace ovoid::io
