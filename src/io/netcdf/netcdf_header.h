// SPDX-License-Identifier: Apache-2.0
// The header of a classic netCDF file: CDF-1, CDF-2 and CDF-5 [netCDF].
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// Text, or the first numbers: what is longer than a header's reader needs is passed over.
struct NetcdfAttribute {
  std::string name;
  std::string text;
  std::vector<double> numbers;
};

struct NetcdfDimension {
  std::string name;
  std::int64_t size = 0;  // of that of the records: how many there are
  bool is_of_records = false;
};

struct NetcdfVariable {
  std::string name;
  std::optional<ScalarType> type;  // none: text
  std::vector<std::size_t> dims;   // numbers of dimensions, the slowest first
  std::vector<NetcdfAttribute> attributes;
  bool has_records = false;    // along its first dimension
  std::int64_t begin = 0;      // in the file
  std::int64_t num_bytes = 0;  // of one record, or of all

  const NetcdfAttribute* attribute(std::string_view wanted) const;  // null: not there
  std::string text(std::string_view wanted) const;                  // empty: not there
};

struct NetcdfHeader {
  std::vector<NetcdfDimension> dimensions;
  std::vector<NetcdfAttribute> attributes;
  std::vector<NetcdfVariable> variables;
  std::int64_t record_stride = 0;  // bytes from a record to the next

  std::vector<std::int64_t> shape(const NetcdfVariable& variable) const;
  // Of these names; null: not there.
  const NetcdfVariable* variable(std::string_view wanted) const;
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
                                   const NetcdfVariable& variable, std::int64_t most);

}  // namespace ovoid::io
