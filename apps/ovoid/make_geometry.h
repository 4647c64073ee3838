// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "histogram.h"
#include "ovoid/dataset.h"
#include "ovoid/field.h"
#include "ovoid/scene.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// The array of zeros that a mesh without arrays has (ReadOptions::faces).
inline constexpr std::string_view kNothing = "nothing";

// The surfaces of --add, in their colours; tells which are nowhere near the field. Throws Error for
// what is no surface.
std::vector<Geometry> make_surfaces(const GeometryFlags& flags, const Field& field,
                                    Session& session);

// Its parts, for whoever keeps surfaces from one scene to the next. What a file says of faces,
// lines and points; the surface of that, as the flags want the n-th, for which `path` is its name.
// Both throw Error, which calls the file one of --add.
Dataset read_faces(const std::string& path, Session& session);
std::shared_ptr<const Surface> surface_of_faces(Dataset mesh, const std::string& path,
                                                const GeometryFlags& flags, std::size_t n,
                                                const Session& session);
// Whether there is something to be drawn but the faces: values of their own, or volume.
bool has_more_than_faces(const Dataset& mesh);
// Whether there is something that has a radius.
bool has_lines_or_points(const Dataset& mesh);
// The arrays whose values may colour what is added, by name.
std::vector<std::string> arrays_for_colors(const Dataset& mesh);

// The colour of the n-th surface where nobody named one: bone, steel, copper and moss, in turn.
Rgb usual_surface_color(std::size_t n);
// How the n-th is drawn, as the flags have it.
struct AddedStyle {
  Rgb color;
  double opacity = 1;
  std::string array;  // gives colours; empty: none
  std::string color_map;
  std::optional<std::pair<double, double>> range;  // that the map spans; none: all values
  double radius = 0;                               // 0: the usual one
};
AddedStyle added_style(const GeometryFlags& flags, std::size_t n);
inline constexpr const char* kUsualAddedMap = "viridis";
// The least and the greatest value; 0 and 1 where there are none.
std::pair<double, double> range_of_values(const Surface& surface);
// The map over the range, or from its one value to one more.
TransferFunction colors_of_values(const std::string& map, const std::pair<double, double>& range);
// The n-th surface as the flags have it.
Geometry styled_surface(const GeometryFlags& flags, std::size_t n,
                        std::shared_ptr<const Surface> surface);

// What slices' colours span where nobody says: nearly all values.
std::pair<double, double> usual_slice_range(const Histogram& histogram, const ValueRange& range);
// The slices of a field whose values occur so often.
std::vector<FieldSlice> make_slices(const GeometryFlags& flags, const Field& field,
                                    const Histogram& histogram);

// What a mesh needs to have a surface, where its own arrays do not count.
DataArray nothing_at_nodes(const Dataset& mesh);

}  // namespace ovoid::cli
