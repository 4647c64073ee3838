// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vtk_header_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/core/samples.h"

namespace ovoid::io {

void fail_header(const ByteSource& source, const std::string& what, ErrorCode code) {
  throw Error(code, fmt::format("{}: {}", source.name(), what));
}

std::int64_t num_points(const ByteSource& source, const std::string& field,
                        const std::array<std::int64_t, 3>& dims) {
  if (dims[0] == 0) return 0;
  checked_num_bytes(source.name() + ": " + field, dims, ScalarType::kFloat64);
  return *checked_product(dims);
}

std::int64_t num_cells(const std::array<std::int64_t, 3>& dims) {
  if (dims[0] == 0) return 0;
  std::int64_t result = 1;
  for (const std::int64_t dim : dims) result *= std::max<std::int64_t>(1, dim - 1);
  return result;
}

}  // namespace ovoid::io
