// SPDX-License-Identifier: Apache-2.0
#include "io/core/cf_file.h"

#include <algorithm>

namespace ovoid::io {

std::vector<std::int64_t> CfDescription::shape(const CfVariable& variable) const {
  std::vector<std::int64_t> sizes;
  sizes.reserve(variable.dims.size());
  for (const std::size_t number : variable.dims) sizes.push_back(dimensions[number].size);
  return sizes;
}

const CfVariable* CfDescription::variable(std::string_view wanted) const {
  const auto found =
      std::find_if(variables.begin(), variables.end(),
                   [&](const CfVariable& variable) { return variable.name == wanted; });
  return found == variables.end() ? nullptr : &*found;
}

}  // namespace ovoid::io
