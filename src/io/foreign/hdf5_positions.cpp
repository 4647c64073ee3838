// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_positions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "io/core/text_scanner.h"
#include "io/points/point_columns.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

std::optional<Hdf5Positions> positions_in(const Hdf5Dataset& dataset) {
  const auto& dims = dataset.dims;
  if (!dataset.type || dims.size() != 2 || dims[0] < 1 || dims[1] < 1) return std::nullopt;
  if (dims[1] == 3) return Hdf5Positions{{&dataset}, false, dims[0]};
  if (dims[0] == 3) return Hdf5Positions{{&dataset}, true, dims[1]};
  return std::nullopt;
}

// "particle_position_x" as "particle_position_", "x" as "".
std::optional<std::string> base_of_x(std::string_view name) {
  static constexpr std::array<std::string_view, 8> kBases{
      "", "pos", "pos_", "position_", "particle_position_", "coord_", "coordinates_", "points_"};
  std::string base = lower(name);
  if (!base.ends_with('x')) return std::nullopt;
  base.pop_back();
  if (std::find(kBases.begin(), kBases.end(), base) == kBases.end()) return std::nullopt;
  return base;
}

// The positions of which `x` is the first of three datasets.
std::optional<Hdf5Positions> triple_from(const Hdf5File& file, const Hdf5Dataset& x) {
  const auto base = base_of_x(x.name);
  if (!base || x.dims.size() != 1 || !x.type || x.dims[0] < 1) return std::nullopt;
  Hdf5Positions positions{{&x}, false, x.dims[0]};
  for (const char axis : {'y', 'z'}) {
    for (const Hdf5Dataset& other : file.datasets()) {
      if (other.group == x.group && lower(other.name) == *base + axis && other.dims == x.dims &&
          other.type)
        positions.datasets.push_back(&other);
    }
  }
  return positions.datasets.size() == 3 ? std::optional(positions) : std::nullopt;
}

[[noreturn]] void fail_candidates(const std::string& source,
                                  const std::vector<std::string>& candidates) {
  constexpr std::size_t kListed = 8;
  std::string paths;
  for (std::size_t i = 0; i < std::min(kListed, candidates.size()); ++i)
    paths += fmt::format("{}'{}'", i == 0 ? "" : ", ", candidates[i]);
  if (candidates.size() > kListed)
    paths += fmt::format(" and {} more", candidates.size() - kListed);
  throw Error(
      ErrorCode::kFileFormat,
      candidates.empty()
          ? fmt::format("{}: no dataset [N, 3] is called Coordinates, positions, xyz or the "
                        "like, and none has three axes (z, y, x): expected the path of positions "
                        "with --positions",
                        source)
          : fmt::format("{}: several datasets may be the positions: {}: choose one with "
                        "--positions",
                        source, paths));
}

}  // namespace

std::string absolute_path(const std::string& path) {
  return path.starts_with('/') ? path : "/" + path;
}

// "/PartType4" is 4; -1 for another group.
int gadget_type(std::string_view group) {
  constexpr std::string_view kName = "PartType";
  const auto at = group.rfind('/') + 1;
  group.remove_prefix(at);
  if (!group.starts_with(kName) || group.size() != kName.size() + 1) return -1;
  const char digit = group.back();
  return digit >= '0' && digit <= '9' ? digit - '0' : -1;
}

Hdf5Positions asked_positions(const Hdf5File& file, const std::string& source,
                              const std::string& asked) {
  for (const Hdf5Dataset& dataset : file.datasets()) {
    if (dataset.path != absolute_path(asked)) continue;
    if (const auto found = positions_in(dataset)) return *found;
    if (const auto found = triple_from(file, dataset)) return *found;
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: positions '{}': has shape [{}]{}: expected numbers [N, 3], [3, N], "
                    "or the first of three datasets x, y, z",
                    source, asked, fmt::join(dataset.dims, ", "),
                    dataset.type ? "" : " and holds no numbers"));
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: positions '{}': the file has no such dataset", source, asked));
}

std::vector<Hdf5Positions> candidates_in(const Hdf5File& file) {
  std::vector<Hdf5Positions> candidates;
  for (const Hdf5Dataset& dataset : file.datasets()) {
    const auto found = is_position_name(dataset.name) ? positions_in(dataset) : std::nullopt;
    const auto triple = found ? std::nullopt : triple_from(file, dataset);
    if (found) candidates.push_back(*found);
    if (triple) candidates.push_back(*triple);
  }
  return candidates;
}

std::size_t choose_positions(const std::string& source, const std::vector<PositionsPlace>& places,
                             std::vector<std::string>& notes) {
  if (places.size() == 1) return 0;
  // Gadget's types: gas, then halo, then stars, then the rest.
  const auto rank = [](const PositionsPlace& place) {
    static constexpr std::array<int, 10> kRanks{0, 1, 3, 4, 2, 5, 6, 7, 8, 9};
    const int type = gadget_type(place.group);
    return type < 0 ? -1 : kRanks[static_cast<std::size_t>(type)];
  };
  const bool is_gadget =
      !places.empty() && std::all_of(places.begin(), places.end(),
                                     [&](const PositionsPlace& p) { return rank(p) >= 0; });
  if (!is_gadget) {
    std::vector<std::string> paths;
    paths.reserve(places.size());
    for (const PositionsPlace& place : places) paths.push_back(place.path);
    fail_candidates(source, paths);
  }
  const auto chosen = std::min_element(
      places.begin(), places.end(),
      [&](const PositionsPlace& a, const PositionsPlace& b) { return rank(a) < rank(b); });
  notes.push_back(
      fmt::format("{}: of {} kinds of particles '{}' is read; choose with "
                  "--positions",
                  source, places.size(), chosen->group));
  return static_cast<std::size_t>(chosen - places.begin());
}

}  // namespace ovoid::io
#endif
