// SPDX-License-Identifier: Apache-2.0
#include "io/zarr/zarr_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "io/core/axis_order.h"
#include "io/core/cf_conventions.h"
#include "io/core/length_units.h"

namespace ovoid::io {
namespace {

constexpr std::string_view kSpaceLetters = "xyz";

}  // namespace

void place_ome_level(const OmeImage& image, const OmeLevel& level, Dataset& dataset) {
  Vec3 spacing(1, 1, 1), origin(0, 0, 0);
  const auto unit_of = [&](char letter) {
    const auto place = axis_place(image.axes, letter);
    return place ? plain_unit(image.units[*place]) : std::string();
  };
  const std::string unit = unit_of('x');
  const std::optional<double> metres = metres_in(unit);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto place = axis_place(image.axes, kSpaceLetters[i]);
    const auto axis = static_cast<Eigen::Index>(i);
    if (!place) {
      spacing[axis] = spacing[0];  // of a plane
      continue;
    }
    const std::string own_unit = unit_of(kSpaceLetters[i]);
    const std::optional<double> own = metres_in(own_unit);
    const double factor = own && metres && own_unit != unit ? *own / *metres : 1.0;
    spacing[axis] = level.scale[*place] * factor;
    origin[axis] = level.translation[*place] * factor;
  }
  dataset.lattice.world_from_index.linear() = spacing.asDiagonal();
  dataset.lattice.world_from_index.translation() = origin;
  if (!unit.empty() && unit != "mm") {
    dataset.notes.push_back(
        fmt::format("{}: lengths are in {}, as the file has them", dataset.source, unit));
  }
  const auto time = axis_place(image.axes, 't');
  if (!time) return;
  std::vector<double> times;
  for (std::int64_t step = 0; step < dataset.num_steps; ++step)
    times.push_back(level.translation[*time] + static_cast<double>(step) * level.scale[*time]);
  set_cf_times(std::move(times), image.units[*time], dataset);
}

}  // namespace ovoid::io
