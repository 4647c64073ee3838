// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/file_checks.h"

#include <fmt/format.h>

#include <cstdint>
#include <string>

#include "io/netcdf/netcdf_header.h"
#include "ovoid/error.h"

namespace ovoid::io {

void check_exodus(const ByteSource& source) {
  if (is_exodus_header(read_netcdf_header(source))) return;
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: is netCDF, but no Exodus mesh (it has no attribute 'api_version')",
                          source.name()));
}

void check_hdf5_size(const ByteSource& source) {
  const std::string start = source.text(0, 96);
  // Where the address of the end stands, in addresses of 8 bytes, behind which version of the
  // superblock (HDF5 File Format Specification, II.A). Others are left to the library.
  std::size_t place = 0;
  if (start.size() == 96 && (start[8] == 0 || start[8] == 1) && start[13] == 8)
    place = start[8] == 0 ? 40 : 44;
  if (start.size() == 96 && (start[8] == 2 || start[8] == 3) && start[9] == 8) place = 28;
  if (place == 0) return;
  std::uint64_t end = 0;
  for (std::size_t i = 8; i-- > 0;) end = end << 8U | static_cast<unsigned char>(start[place + i]);
  if (end <= static_cast<std::uint64_t>(source.size())) return;
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: the HDF5 file says it has {} bytes, it has {}: is it truncated?",
                          source.name(), end, source.size()));
}

}  // namespace ovoid::io
