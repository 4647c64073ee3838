// SPDX-License-Identifier: Apache-2.0
#include "data/default_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "data/bookkeeping.h"
#include "data/kernels/letters.h"
#include "data/scalar_visit.h"
#include "data/varies.h"
#include "ovoid/error.h"
#include "ovoid/kernel_team.h"

namespace ovoid {
namespace data {

const DataArray* default_array(const Dataset& dataset,
                               const std::function<bool(const DataArray&)>& varies) {
  const auto find = [&](const auto& is_wanted) {
    for (const DataArray& candidate : dataset.arrays) {
      if (!is_bookkeeping(dataset, candidate) && is_wanted(candidate)) return &candidate;
    }
    return static_cast<const DataArray*>(nullptr);
  };
  const DatasetKind kind = dataset.kind;
  const DataArray* found = find([&](const DataArray& a) {
    return kind != DatasetKind::kLattice && kind != DatasetKind::kMesh && is_density(a) &&
           varies(a);
  });
  if (found == nullptr) {
    found = find([&](const DataArray& a) {
      return !a.is_cell_data && varies(a) &&
             !(kind == DatasetKind::kParticles && is_part_of_vector(dataset, a));
    });
  }
  if (found == nullptr)
    found = find([&](const DataArray& a) { return !a.is_cell_data && varies(a); });
  if (found == nullptr)
    found = find([&](const DataArray& a) { return a.is_cell_data && varies(a); });
  if (found == nullptr) found = find([](const DataArray&) { return true; });
  if (found == nullptr && !dataset.arrays.empty()) found = &dataset.arrays.front();
  return found;
}

namespace {

// What a share knows of whether an array varies.
struct Variation {
  bool varies = false;
  bool has_value = false;
  double value = 0;  // the first finite one

  void add(const Variation& other) {
    varies = varies || other.varies || (has_value && other.has_value && value != other.value);
    if (!has_value) {
      has_value = other.has_value;
      value = other.value;
    }
  }
};

Variation variation_of(const DataArray& array) {
  Variation variation;
  variation.varies = data::varies(array);
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    const auto stored = static_cast<std::int64_t>(array.bytes.view.size() / sizeof(T));
    for (std::int64_t i = 0; i < stored && !variation.has_value;
         i += std::max(array.num_components, 1)) {
      variation.value = static_cast<double>(load_scalar<T>(array.bytes.view.data(), i));
      variation.has_value = std::isfinite(variation.value);
    }
  });
  return variation;
}

// Shares that are not of one dataset, or not all of it.
void check_shares(const Dataset& share, KernelTeam& team) {
  std::string names;
  for (const DataArray& array : share.arrays)
    names += fmt::format("{} {}\n", array.name, array.num_components);
  const DatasetShare& rows = share.share.value();
  // Of a mesh's rows some may be left out.
  const bool is_mesh = share.kind == DatasetKind::kMesh;
  const std::int64_t num_rows = is_mesh ? share.cells.count() : share.num_positions();
  const std::array<std::int64_t, 3> own = {rows.first, num_rows, rows.total};
  Letter letter;
  append(letter, std::span<const std::int64_t>(own));
  append(letter, std::span<const char>(names));
  const KernelTeam::Letters letters = gathered_letters(team, letter);
  std::int64_t next = 0;
  for (std::size_t p = 0; p < letters.size(); ++p) {
    LetterReader reader(letters[p]);
    std::vector<std::int64_t> theirs;
    reader.take(own.size(), theirs);
    std::vector<char> their_names;
    reader.take(reader.num_left(), their_names);
    const bool is_next = is_mesh ? theirs[0] >= next : theirs[0] == next;
    if (!is_next || theirs[2] != rows.total ||
        !std::equal(their_names.begin(), their_names.end(), names.begin(), names.end()))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("'{}': process {} has rows {} to {} of {}, or other arrays: expected "
                              "shares of the same data, the next from row {} of {}",
                              share.source, p, theirs[0], theirs[0] + theirs[1], theirs[2], next,
                              rows.total));
    next = theirs[0] + theirs[1];
  }
  if (is_mesh ? next > rows.total : next != rows.total)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("'{}': all shares have {} rows, expected {}", share.source, next, rows.total));
}

}  // namespace
}  // namespace data

void agree_on_array(Dataset& share, KernelTeam& team) {
  if (!share.share)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': was read whole, expected a share of it", share.source));
  data::check_shares(share, team);
  std::vector<data::Variation> own;
  own.reserve(share.arrays.size());
  for (const DataArray& array : share.arrays) own.push_back(data::variation_of(array));
  std::vector<data::Variation> all(own.size());
  for (const auto& theirs : data::gathered(team, std::span<const data::Variation>(own))) {
    for (std::size_t a = 0; a < all.size(); ++a) all[a].add(theirs.at(a));
  }
  const DataArray* const found = data::default_array(share, [&](const DataArray& array) {
    return all[static_cast<std::size_t>(&array - share.arrays.data())].varies;
  });
  if (found != nullptr) share.share->array = found->name;
}

}  // namespace ovoid
