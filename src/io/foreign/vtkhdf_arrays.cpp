// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/vtkhdf_arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::io {

std::vector<DataArray> read_vtkhdf_arrays(
    const VtkHdfGroup& owner, const char* name, bool is_cell_data, const VtkHdfRead& read,
    const std::function<DataArray(const std::string& name, const VtkHdfArray& array)>& rows) {
  const auto group = owner.group(name);
  if (!group) return {};
  const std::vector<VtkHdfGroup::Member> members = group->members();
  const bool has_wanted =
      !read.array.empty() && std::any_of(members.begin(), members.end(), [&](const auto& member) {
        return member.name == read.array;
      });
  std::vector<DataArray> arrays;
  for (const VtkHdfGroup::Member& member : members) {
    const bool is_wanted = member.name == read.array;
    if (has_wanted && !is_wanted && member.name != kGhostArray) continue;
    try {
      if (member.type != H5O_TYPE_DATASET)
        owner.objects().fail(
            fmt::format("'{}/{}' is no dataset of the file's own", group->place(), member.name),
            ErrorCode::kUnsupported);
      DataArray array = rows(member.name, group->needed(member.name));
      array.name = member.name;
      array.is_cell_data = is_cell_data;
      arrays.push_back(std::move(array));
    } catch (const Error& problem) {
      if (is_wanted || problem.code() != ErrorCode::kUnsupported) throw;
      read.notes->push_back(fmt::format("{}: array '{}' is left out: {}", owner.objects().name(),
                                        member.name,
                                        std::string_view(problem.what()).substr(0, 300)));
    }
  }
  return arrays;
}

}  // namespace ovoid::io
#endif
