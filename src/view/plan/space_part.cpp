// SPDX-License-Identifier: Apache-2.0
#include "view/plan/space_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "data/lattice/large_pages.h"
#include "ovoid/error.h"
#include "ovoid/render_options.h"

namespace ovoid {
namespace view {
namespace {

// The place on the ray of a pixel at a depth, along a plane's normal: value + depth * slope.
struct AlongNormal {
  // As functions of the pixel.
  double value[3], slope[3];

  AlongNormal(const SpacePart::Side& side, const ViewLattice& lattice) {
    const SheetMap at = lattice.world_map(0);
    const SheetMap direction = lattice.ray_direction();
    const double depth = lattice.depth(0);
    const Vec3* const places[3] = {&at.origin, &at.per_x, &at.per_y};
    const Vec3* const steps[3] = {&direction.origin, &direction.per_x, &direction.per_y};
    for (int i = 0; i < 3; ++i) {
      slope[i] = side.normal.dot(*steps[i]);
      value[i] = side.normal.dot(*places[i]) - depth * slope[i];
    }
  }
};

double at_pixel(const double (&map)[3], int x, int y) { return map[0] + map[1] * x + map[2] * y; }

// The first piece that has its middle at this depth or behind it.
std::int32_t piece_behind(const ViewLattice& lattice, double depth) {
  // The piece that ends on sheet k has its middle half a sampling distance before it.
  const double number = std::ceil((depth - lattice.depth(0)) / lattice.sampling_distance() + 0.5);
  return static_cast<std::int32_t>(std::clamp<double>(number, kFirstSheet, kLastSheet));
}

struct Pieces {
  std::int32_t first, last;
};

// What a plane leaves of a ray: `number` is that of the first piece behind it.
void cut(const SpacePart::Side& side, const AlongNormal& along, const ViewLattice& lattice, int x,
         int y, Pieces& pieces) {
  const double slope = at_pixel(along.slope, x, y);
  const double value = at_pixel(along.value, x, y);
  if (slope == 0) {
    if ((value >= side.offset) != side.is_beyond) pieces.last = pieces.first;
    return;
  }
  const std::int32_t number = piece_behind(lattice, (side.offset - value) / slope);
  if ((slope > 0) == side.is_beyond) {
    pieces.first = std::max(pieces.first, number);
  } else {
    pieces.last = std::min(pieces.last, number);
  }
}

std::size_t num_pixels(const PartSheets& sheets) {
  return static_cast<std::size_t>(sheets.width) * static_cast<std::size_t>(sheets.height);
}

// The depth of the sheet before a ray's piece, where it begins.
float begin_of(const ViewLattice& lattice, std::int32_t piece) {
  if (piece == kFirstSheet) return -std::numeric_limits<float>::infinity();
  if (piece == kLastSheet) return std::numeric_limits<float>::infinity();
  return static_cast<float>(lattice.depth(piece - 1));
}

// The stops of a pixel between two depths; where somebody else draws on there are seams.
void add_stops(std::span<const DepthLimits::Stop> within, bool is_limited, float from, float to,
               std::vector<DepthLimits::Stop>& stops) {
  bool is_drawn = !is_limited;
  auto next = within.begin();
  for (; next != within.end() && next->depth < from; ++next) is_drawn = next->is_field_behind;
  if (is_drawn) stops.push_back({from, true, true, {}});
  for (; next != within.end() && next->depth < to; ++next) {
    stops.push_back(*next);
    is_drawn = next->is_field_behind;
  }
  if (is_drawn && std::isfinite(to)) stops.push_back({to, false, true, {}});
}

// The most stops that pixels have: two seams each, and those that there are otherwise.
std::size_t most_stops(const PartSheets& sheets, const DepthLimits* within) {
  std::size_t count = within == nullptr ? 0 : within->stops.size();
  for (std::size_t pixel = 0; pixel < num_pixels(sheets); ++pixel) {
    if (sheets.first[pixel] < sheets.last[pixel]) count += sheets.last[pixel] < kLastSheet ? 2 : 1;
  }
  return count;
}

}  // namespace

PartSheets sheets_of_part(const SpacePart& part, const ViewLattice& lattice) {
  PartSheets sheets;
  sheets.width = lattice.width();
  sheets.height = lattice.height();
  sheets.first.assign(num_pixels(sheets), kFirstSheet);
  sheets.last.assign(num_pixels(sheets), kLastSheet);
  for (const SpacePart::Side& side : part.sides) {
    const AlongNormal along(side, lattice);
    for (int y = 0; y < sheets.height; ++y) {
      for (int x = 0; x < sheets.width; ++x) {
        const std::size_t at =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(sheets.width) +
            static_cast<std::size_t>(x);
        Pieces pieces{sheets.first[at], sheets.last[at]};
        cut(side, along, lattice, x, y, pieces);
        sheets.first[at] = pieces.first;
        sheets.last[at] = pieces.last;
      }
    }
  }
  return sheets;
}

DepthLimits limits_of_part(const PartSheets& sheets, const ViewLattice& lattice,
                           const DepthLimits* within) {
  DepthLimits limits;
  limits.width = sheets.width;
  limits.height = sheets.height;
  limits.first.assign(num_pixels(sheets) + 1, 0);
  data::reserve_large_pages(limits.stops, most_stops(sheets, within));
  for (std::size_t pixel = 0; pixel < num_pixels(sheets); ++pixel) {
    if (sheets.first[pixel] < sheets.last[pixel]) {
      std::span<const DepthLimits::Stop> stops;
      if (within != nullptr)
        stops = std::span(within->stops)
                    .subspan(within->first[pixel], within->first[pixel + 1] - within->first[pixel]);
      add_stops(stops, within != nullptr, begin_of(lattice, sheets.first[pixel]),
                begin_of(lattice, sheets.last[pixel]), limits.stops);
    }
    limits.first[pixel + 1] = static_cast<std::uint32_t>(limits.stops.size());
  }
  return limits;
}

std::vector<ClipPlane> planes_around(const SpacePart& part, const ViewLattice& lattice) {
  // The longest way of a ray from sheet to sheet, at the picture's corners.
  const SheetMap direction = lattice.ray_direction();
  double longest = 0;
  for (const double x : {0.0, lattice.width() - 1.0}) {
    for (const double y : {0.0, lattice.height() - 1.0})
      longest = std::max(longest, direction.at(x, y).norm());
  }
  const double around = 2 * longest * lattice.sampling_distance();
  std::vector<ClipPlane> planes;
  for (const SpacePart::Side& side : part.sides) {
    const double scale = (side.is_beyond ? 1 : -1) / side.normal.norm();
    planes.push_back({side.normal * scale, side.offset * scale - around});
  }
  return planes;
}

DeepImage runs_of_part(const Image& image, Mode mode, const PartSheets& sheets,
                       std::span<const float> coverage) {
  DeepImage seen;
  seen.width = image.width;
  seen.height = image.height;
  seen.mode = mode;
  seen.first.assign(num_pixels(sheets) + 1, 0);
  std::size_t num_runs = 0;
  for (std::size_t pixel = 0; pixel < num_pixels(sheets); ++pixel)
    num_runs += image.rgba[4 * pixel + 3] > 0 ? 1 : 0;
  data::reserve_large_pages(seen.runs, num_runs);
  for (std::size_t pixel = 0; pixel < num_pixels(sheets); ++pixel) {
    const float* const rgba = &image.rgba[4 * pixel];
    if (rgba[3] > 0)
      seen.runs.push_back({sheets.first[pixel],
                           sheets.last[pixel],
                           {rgba[0], rgba[1], rgba[2], rgba[3]},
                           image.depth[pixel],
                           image.front_depth[pixel],
                           coverage.empty() ? 1.0F : coverage[pixel]});
    seen.first[pixel + 1] = static_cast<std::uint32_t>(seen.runs.size());
  }
  return seen;
}

DeepImage runs_of_surfaces(const Image& image, const SpacePart& part, const Camera& camera) {
  // They have no sheets of their own: any will do, if all take the same.
  const ViewLattice pixels(camera, image.width, image.height, 1.0, LatticeGeometry{});
  const double pitch = pixels.pitch(0);
  const ViewLattice lattice(camera, image.width, image.height, pitch, LatticeGeometry{});
  const PartSheets sheets = sheets_of_part(part, lattice);
  Image own = image;
  PartSheets places = sheets;
  for (std::size_t pixel = 0; pixel < num_pixels(sheets); ++pixel) {
    // What is too faint to have a depth is of the farthest part.
    const float depth = image.front_depth[pixel];
    const std::int32_t piece = std::isfinite(depth) ? piece_behind(lattice, depth) : kLastSheet - 1;
    if (piece < sheets.first[pixel] || piece >= sheets.last[pixel]) own.rgba[4 * pixel + 3] = 0;
    places.first[pixel] = piece;
    places.last[pixel] = piece + 1;
  }
  return runs_of_part(own, Mode::kComposite, places, {});
}

}  // namespace view

PartSheets sheets_of_part(const SpacePart& part, const Camera& camera, int width, int height,
                          double sampling_distance) {
  camera.validate();
  RenderOptions options;
  options.width = width;
  options.height = height;
  options.sampling_distance = sampling_distance;
  options.validate();
  if (sampling_distance == 0)
    throw Error(ErrorCode::kInvalidArgument, "sampling_distance = 0: must be > 0");
  return view::sheets_of_part(
      part, view::ViewLattice(camera, width, height, sampling_distance, LatticeGeometry{}));
}

}  // namespace ovoid
