// SPDX-License-Identifier: Apache-2.0
#include "crop_flags.h"

#include <fmt/format.h>

#include <limits>

#include "ovoid/error.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

// The three "LO:HI" of "LO:HI,LO:HI,LO:HI" as text; any of the numbers, or a whole part, may be
// missing.
std::array<std::array<std::string, 2>, 3> parse_parts(const std::string& text) {
  const std::vector<std::string> axes = split(text, ',');
  if (axes.size() != 3) throw BadValue("expected three ranges LO:HI, each may be empty");
  std::array<std::array<std::string, 2>, 3> parts;
  for (std::size_t a = 0; a < 3; ++a) {
    if (axes[a].empty()) continue;
    const std::vector<std::string> ends = split(axes[a], ':');
    if (ends.size() != 2) throw BadValue(fmt::format("expected LO:HI, not '{}'", axes[a]));
    parts[a] = {ends[0], ends[1]};
  }
  return parts;
}

std::array<CropFlags::Range, 3> parse_samples(const std::string& text) {
  constexpr std::int64_t kGreatest = std::numeric_limits<std::int64_t>::max();
  const auto parts = parse_parts(text);
  std::array<CropFlags::Range, 3> ranges;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto& [first, last] = parts[a];
    if (!first.empty()) ranges[a].first = parse_integer(first, 0, kGreatest);
    if (!last.empty()) ranges[a].last = parse_integer(last, 0, kGreatest);
    if (ranges[a].first && ranges[a].last && *ranges[a].first > *ranges[a].last)
      throw BadValue(fmt::format("expected FIRST:LAST with FIRST <= LAST, not {}:{}", first, last));
  }
  return ranges;
}

Bounds3 parse_world(const std::string& text) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto parts = parse_parts(text);
  Bounds3 world;
  for (int a = 0; a < 3; ++a) {
    const auto& [lo, hi] = parts[static_cast<std::size_t>(a)];
    world.min()[a] = lo.empty() ? -kInfinity : parse_number(lo);
    world.max()[a] = hi.empty() ? kInfinity : parse_number(hi);
    if (!(world.min()[a] < world.max()[a]))
      throw BadValue(fmt::format("expected LO:HI with LO < HI, not {}:{}", lo, hi));
  }
  return world;
}

// The box that is left, and the planes that cut it out.
std::pair<Box, std::vector<ClipPlane>> cut(const CropFlags& crop, const Field& field) {
  if (field.lattice() == nullptr) {  // a crop by samples has been refused
    const Bounds3 bounds = field.world_bounds();
    if (!crop.world) return {{Affine3::Identity(), bounds}, {}};
    return {crop_box(bounds, *crop.world), crop_planes(*crop.world)};
  }
  const LatticeGeometry& geometry = field.lattice()->geometry();
  if (crop.world) return {crop_box(geometry, *crop.world), crop_planes(*crop.world)};
  if (!crop.samples) return {box_of(geometry), {}};
  Index3 lo{};
  Index3 hi{};
  for (std::size_t a = 0; a < 3; ++a) {
    const CropFlags::Range& range = (*crop.samples)[a];
    lo[a] = range.first.value_or(0);
    hi[a] = range.last.value_or(std::max(lo[a], geometry.dims[a] - 1));
  }
  return {crop_box(geometry, lo, hi), crop_planes(geometry, lo, hi)};
}

}  // namespace

void add_crop_flags(Flags& flags, CropFlags* crop) {
  flags.section("part of the data");
  flags.value(
      "--crop", "I0:I1,J0:J1,K0:K1",
      "draw only these samples of a lattice, counted from 0, both ends included; empty: all of "
      "that axis",
      [crop](const std::string& text) { crop->samples = parse_samples(text); });
  flags.value("--crop-world", "X0:X1,Y0:Y1,Z0:Z1",
              "draw only what lies in this box, world; empty: no end",
              [crop](const std::string& text) { crop->world = parse_world(text); });
}

void check_crop_flags(const Flags& flags) {
  if (flags.is_given("--crop") && flags.is_given("--crop-world")) {
    throw UsageError("--crop-world: contradicts --crop; give one of them");
  }
}

Box apply_crop(const CropFlags& crop, const Field& field, RenderOptions* options) {
  try {
    const auto [box, planes] = cut(crop, field);
    const std::size_t given = options->clip_planes.size();
    if (given + planes.size() > RenderOptions::kMaxClipPlanes) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("crop: needs {} clip planes beside the {} of --clip, which is more "
                              "than {} in all",
                              planes.size(), given, RenderOptions::kMaxClipPlanes));
    }
    options->clip_planes.insert(options->clip_planes.end(), planes.begin(), planes.end());
    return box;
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("--{}", error.what()));
  }
}

}  // namespace ovoid::cli
