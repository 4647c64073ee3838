// SPDX-License-Identifier: Apache-2.0
#include "make_over.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "load.h"
#include "make_field.h"
#include "make_look.h"
#include "ovoid/error.h"
#include "placement.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

// Colours of volumes that say nothing of them: unlike each other, and unlike the picture's own.
constexpr const char* kOverMaps[kMostOver] = {"hot", "haline", "plasma"};

// Opacities of volumes that say nothing of them: what is low is not seen, so that it does not hide
// the picture's own. Of what a scan of uptake has, low is nearly all: the rest of the body.
constexpr double kOverLow = 0.3;  // of the range
constexpr double kOverMost = 0.5;

// What the i-th volume says; the default: nothing.
template <class T>
T said(const std::vector<T>& all, std::size_t i) {
  return i < all.size() ? all[i] : T{};
}

void require_as_many(const OverFlags& over) {
  const auto require = [&](const char* flag, std::size_t count) {
    if (count <= over.files.size()) return;
    throw UsageError(
        fmt::format("{}: given {} times, for {} of --over", flag, count, over.files.size()));
  };
  require("--over-array", over.arrays.size());
  require("--over-tf", over.looks.size());
  require("--over-preset", over.presets.size());
  require("--over-colormap", over.color_maps.size());
  require("--over-range", over.ranges.size());
  require("--over-opacity", over.opacities.size());
  require("--over-transform", over.transforms.size());
}

// The flags about light are those of the whole picture, those about colour and opacity its own.
LookFlags look_flags(const OverFlags& over, std::size_t i, const LookFlags& picture,
                     const ValueRange& values) {
  LookFlags own = picture;
  own.file = said(over.looks, i);
  own.file_name.clear();
  own.color_file.clear();
  own.preset = said(over.presets, i);
  own.color_map = said(over.color_maps, i);
  own.opacities = said(over.opacities, i);
  own.gradient_opacities.clear();
  own.file_2d.clear();
  own.range_2d.reset();
  own.range.reset();
  if (i < over.ranges.size()) own.range = over.ranges[i];
  own.shift = 0;
  own.is_window = own.is_log = false;
  own.linear_width.reset();
  own.below_color.reset();
  own.above_color.reset();
  own.unit_distance.reset();
  if (!own.file.empty() || !own.preset.empty()) return own;
  if (own.color_map.empty()) own.color_map = kOverMaps[i];
  const auto [lo, hi] = own.range.value_or(std::pair<double, double>(values.lo, values.hi));
  if (own.opacities.empty() && lo < hi)
    own.opacities = {{lo + kOverLow * (hi - lo), 0.0}, {hi, kOverMost}};
  return own;
}

void place(const OverFlags& over, std::size_t i, Space space, Dataset* dataset, Session& session) {
  const bool is_unsaid = dataset->space == Space::kNone || space == Space::kNone;
  if (dataset->space != space && is_unsaid) {
    session.note(
        fmt::format("'{}' is in {}, the picture in {}: taken to be the same world", dataset->source,
                    dataset->space == Space::kNone ? "no patient's space" : name_of(dataset->space),
                    space == Space::kNone ? "no patient's space" : name_of(space)));
  }
  Affine3 placed = between_spaces(dataset->space, space) * dataset->lattice.world_from_index;
  if (const std::string& file = said(over.transforms, i); !file.empty()) {
    try {
      placed = read_placement(file, space) * placed;
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("--over-transform: {}", error.what()));
    }
  }
  dataset->lattice.world_from_index = placed;
  dataset->space = space;
}

}  // namespace

Volume make_over_volume(const DrawingFlags& drawing, std::size_t i, Space space, Session& session) {
  const OverFlags& over = drawing.over;
  DataFlags data;
  data.inputs = {over.files[i]};
  data.array = said(over.arrays, i);
  data.may_stay_in_file = true;
  Dataset dataset = load(data, session);
  if (dataset.kind != DatasetKind::kLattice) refuse_kind("--over", "lattices", dataset);
  place(over, i, space, &dataset, session);
  ModelFlags model;
  model.array = data.array;
  const Modelled modelled = make_field(dataset, model, drawing.run.threads, session);
  const std::string unit = unit_of(dataset, modelled, Role::kOpacity);
  const Quiet quiet(session);
  Look look = make_look(look_flags(over, i, drawing.look, modelled.field.value_range()),
                        modelled.field, unit, session);
  return {modelled.field, std::move(look)};
}

std::string out_of_sight(const Bounds3& volume, const Bounds3& picture) {
  // At this distance, in sizes of the larger, neither takes more than a few pixels of a picture of
  // both; and at this ratio of sizes the smaller takes none.
  constexpr double kFarthest = 100;
  constexpr double kGreatestRatio = 1e4;
  const double size = volume.diagonal().stableNorm(), other = picture.diagonal().stableNorm();
  const Vec3 gap = (picture.min() - volume.max()).cwiseMax(volume.min() - picture.max());
  const double distance = gap.cwiseMax(0.0).stableNorm();
  if (!(distance <= kFarthest * std::max(size, other)))
    return fmt::format("lies outside, {:.3g} away from the picture's volume, whose size is {:.3g}",
                       distance, other);
  if (!(std::max(size, other) <= kGreatestRatio * std::min(size, other)))
    return fmt::format("has the size {:.3g}, the picture's volume {:.3g}", size, other);
  return "";
}

std::vector<OverVolume> make_over_volumes(const DrawingFlags& drawing, const Dataset& dataset,
                                          Session& session) {
  const OverFlags& over = drawing.over;
  if (over.files.size() > kMostOver) {
    throw UsageError(
        fmt::format("--over: given {} times, expected at most {}", over.files.size(), kMostOver));
  }
  require_as_many(over);
  std::vector<OverVolume> volumes;
  const Bounds3 picture = dataset.lattice.world_bounds();
  Bounds3 all = picture;
  for (std::size_t i = 0; i < over.files.size(); ++i) {
    Volume volume = make_over_volume(drawing, i, dataset.space, session);
    const Bounds3 own = volume.field.world_bounds();
    if (const std::string why = out_of_sight(own, picture); !why.empty()) {
      session.note(
          fmt::format("'{}' {}: it is left out (--over-transform, or the unit of lengths, "
                      "may be another's)",
                      over.files[i], why));
      continue;
    }
    if (!own.intersects(all))
      session.note(fmt::format("'{}' lies beside the others, nowhere within them", over.files[i]));
    all.extend(own);
    volumes.push_back({i, std::move(volume)});
  }
  return volumes;
}

std::vector<Volume> make_over(const DrawingFlags& drawing, const Dataset& dataset,
                              Session& session) {
  std::vector<Volume> volumes;
  if (drawing.over.files.empty()) return volumes;
  for (OverVolume& made : make_over_volumes(drawing, dataset, session))
    volumes.push_back(std::move(made.volume));
  return volumes;
}

Bounds3 bounds_with(const Bounds3& bounds, const Scene& scene) {
  Bounds3 all = bounds;
  for (std::size_t i = 1; i < scene.volumes.size(); ++i)
    all.extend(scene.volumes[i].field.world_bounds());
  return all;
}

}  // namespace ovoid::cli
