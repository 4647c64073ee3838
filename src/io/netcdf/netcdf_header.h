// SPDX-License-Identifier: Apache-2.0
// The header of a classic netCDF file: CDF-1, CDF-2 and CDF-5 [netCDF].
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/cf_file.h"

namespace ovoid::io {

// Where a variable's numbers lie.
struct NetcdfPlace {
  bool has_records = false;    // along its first dimension
  std::int64_t begin = 0;      // in the file
  std::int64_t num_bytes = 0;  // of one record, or of all
};

// Attributes hold text, or the first numbers: what is longer than a reader needs is passed over.
// Unlimited is the dimension of the records, whose size is how many there are.
struct NetcdfHeader : CfDescription {
  std::vector<NetcdfPlace> places;  // of the variables
  std::int64_t record_stride = 0;   // bytes from a record to the next

  const NetcdfPlace& place_of(const CfVariable& variable) const {
    return places[static_cast<std::size_t>(&variable - variables.data())];
  }
};

bool begins_like_netcdf(std::string_view start) noexcept;

// Reads and checks it: all is well-formed, and the file as long as its variables say with all
// records (one that says it is still being written has the records that fit). Nothing is allocated
// in proportion to a claim. Throws Error(kFileFormat) naming the variable, what it needs and what
// there is. Cost: the header.
NetcdfHeader read_netcdf_header(const ByteSource& source);

// Is it one of Exodus'? These have the attribute `api_version`, and other netCDF files have not.
bool is_exodus_header(const NetcdfHeader& header);

// The values of a variable of numbers and one dimension, or none, of at most `most`; empty for any
// other.
std::vector<double> netcdf_numbers(const ByteSource& source, const NetcdfHeader& header,
                                   const CfVariable& variable, std::int64_t most);

}  // namespace ovoid::io
