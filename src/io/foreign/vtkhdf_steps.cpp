// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/vtkhdf_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include "data/scalar_visit.h"
#include "io/foreign/hdf5_attributes.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostSteps = 1'000'000;

std::vector<double> reals_of(const VtkHdfArray& array, std::int64_t count) {
  const ReadOptions options;
  ReadProgress progress(options, 0);
  const DataArray read = array.rows(0, count, progress);
  return data::visit_scalar(read.type, [&]<class T>(std::type_identity<T>) {
    std::vector<double> values;
    for (std::int64_t i = 0; i < read.num_tuples; ++i)
      values.push_back(static_cast<double>(
          data::load_scalar<T>(read.bytes.view.data(), i * read.num_components)));
    return values;
  });
}

}  // namespace

VtkHdfSteps::VtkHdfSteps(const VtkHdfGroup& owner) : group_(owner.group("Steps")) {
  if (!group_) return;
  const Hdf5Objects& objects = owner.objects();
  const VtkHdfArray* const values = group_->has("Values") ? &group_->needed("Values") : nullptr;
  if (has_hdf5_attribute(group_->id(), "NSteps"))
    count_ = objects.count(group_->id(), group_->place(), "NSteps", kMostSteps);
  else if (values != nullptr)
    count_ = values->num_rows();
  if (count_ < 1 || count_ > kMostSteps)
    objects.fail(
        fmt::format("'{}' has {} steps: expected 1 to {}", group_->place(), count_, kMostSteps));
  if (values == nullptr) return;
  if (values->num_rows() < count_)
    objects.fail(
        fmt::format("'{}' has {} times for {} steps", values->place(), values->num_rows(), count_));
  times_ = reals_of(*values, count_);
}

std::optional<VtkHdfGroup> VtkHdfSteps::level(int level) const {
  return group_ ? group_->group(fmt::format("Level{}", level)) : std::nullopt;
}

std::int64_t VtkHdfSteps::offset(const char* name, std::int64_t step, std::int64_t column) const {
  return group_ ? group_->count_at(name, step, column) : 0;
}

std::optional<std::int64_t> VtkHdfSteps::offset_of_array(const char* group,
                                                         const std::string& array,
                                                         std::int64_t step) const {
  const auto offsets = group_ ? group_->group(group) : std::nullopt;
  if (!offsets || !offsets->has(array)) return std::nullopt;
  return offsets->count_at(array, step);
}

std::int64_t VtkHdfSteps::num_parts(std::int64_t step, std::int64_t num_parts) const {
  if (!group_) return num_parts;
  if (group_->has("NumberOfParts")) return group_->count_at("NumberOfParts", step);
  // Without the array each step has as many, or all have the same ones.
  const std::vector<std::int64_t> offsets = group_->counts("PartOffsets");
  const bool are_same =
      std::all_of(offsets.begin(), offsets.end(), [](std::int64_t offset) { return offset == 0; });
  return are_same ? num_parts : num_parts / count_;
}

}  // namespace ovoid::io
#endif
