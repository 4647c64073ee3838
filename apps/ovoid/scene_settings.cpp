// SPDX-License-Identifier: Apache-2.0
// The tables of what stands beside the field, or instead of it: surfaces, slices, balls.
#include <fmt/format.h>

#include <string>

#include "color_words.h"
#include "setting_forms.h"
#include "settings.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

namespace {

std::string parse_named_color_map(const std::string& text) {
  if (is_list_of_colors(text)) throw BadValue("expected the name of a colour map");
  return parse_color_map(text);
}

}  // namespace

const Table<GeometryFlags>& geometry_settings() {
  using G = GeometryFlags;
  const Rule beside = needs("add", "has no effect without --add");
  const Rule of_slices = needs("slice", "has no effect without --slice");
  static const Table<G> all = {
      {"--add", word("FILE", Content::kFile), &G::files,
       "a surface in the scene: .stl, .obj, .ply, .vtp or a mesh's outside, in the data's "
       "world; lines are tubes, points balls (repeatable)",
       not_with("mode", "is for --mode composite and isosurface", is_unlit),
       not_with("value-plane motion-blur points")},
      {"--add-color", Form<Rgb>{"COLOR", parse_rgb, [](const Rgb& c) { return text_of(c); }},
       &G::colors,
       "of the first surface, the second, ...; the last counts for the rest (repeatable)", beside},
      {"--add-opacity", number("A", {.lo = 0, .hi = 1}), &G::opacities,
       "of each of its layers, likewise (repeatable; default 1; 0: not drawn)", beside},
      {"--add-array", word("NAME"), &G::arrays,
       "of the first, the second ...: the array whose values give it colours (repeatable)", beside},
      {"--add-colormap", Form<std::string>{"NAME", parse_named_color_map, same}, &G::color_maps,
       "those colours, likewise (repeatable; default viridis)",
       needs("add-array", "has no effect without --add-array")},
      {"--add-range", form("LO,HI", parse_range), &G::ranges,
       "the values that they span, likewise (repeatable; default: all)",
       needs("add-array", "has no effect without --add-array")},
      {"--add-radius", number("R", {.lo = 0}), &G::radii,
       "of lines and points, world, likewise (repeatable; default, and 0: 1/300 of their diagonal)",
       beside},
      {"--add-edges", Toggle(), &G::shows_edges, "the edges of their faces, too", beside},
      {"--slice", form("PLANE", parse_slice_plane), &G::slices,
       "a plane of values in the scene: x, y, z, sagittal, coronal or axial, through the middle or "
       "with =PLACE, or NX,NY,NZ,D, world (repeatable)",
       not_with("mode", "is for --mode composite and isosurface", is_unlit),
       not_with("value-plane motion-blur points")},
      {"--slice-map", Form<std::string>{"NAME", parse_named_color_map, same}, &G::slice_map,
       "colours of slices, as --colormap has them (default {})", of_slices},
      {"--slice-range",
       {"LO,HI", [](G& flags, const std::string& text) { flags.slice_range = parse_range(text); },
        [](const G& flags) {
          return flags.slice_range ? Json(text_of(*flags.slice_range)) : Json();
        }},
       "the values that they span (default: 99 % of the data's)",
       of_slices},
      {"--slice-empty", Toggle(), &G::shows_empty,
       "slices of scans: show also where nothing is (values near the least, if a fifth of all are "
       "so low)",
       of_slices},
      {"--slice-opacity", number("A", {.lo = 0, .hi = 1, .lo_open = true}), &G::slice_opacity,
       "(default {})", of_slices},
      {"--slice-outline",
       {"[=COLOR]",
        [](G& flags, const std::string& text) {
          flags.has_outlines = true;
          flags.outline_color = text.empty() ? std::nullopt : std::optional(parse_rgb(text));
        },
        [](const G& flags) {
          if (!flags.has_outlines) return Json();
          return flags.outline_color ? Json(hex_text(*flags.outline_color)) : Json(true);
        }},
       "a line where slices leave the data's box (default: yellow, green and red of those across "
       "x, y and z, white of others)",
       of_slices},
  };
  return all;
}

const Table<SurfaceFlags>& surface_settings() {
  using S = SurfaceFlags;
  Rule mesh = for_data({DatasetKind::kMesh}, "meshes, which have cells that end, or with --within");
  mesh.unless = {"within"};
  const Rule no_mesh =
      for_data({DatasetKind::kLattice, DatasetKind::kParticles, DatasetKind::kKernels},
               "lattices, particles and kernels, which have no cells that end");
  const Rule mode = not_with("mode", "is for --mode composite", is_no_layer);
  static const Table<S> all = {
      {"--surface",
       {"[=OPACITY]",
        [](S& surface, const std::string& text) {
          surface.opacity = text.empty() ? 1 : parse_number(text, {.lo = 0, .hi = 1});
        },
        [](const S& surface) {
          if (!surface.opacity) return Json();
          return *surface.opacity == 1 ? Json(true) : Json(fmt::format("{}", *surface.opacity));
        }},
       "meshes: show where the cells end, in the field's colours, this opaque (1; less: with the "
       "volume inside; 0: the volume alone; default: what shows the field best, 0 where opacities "
       "or a plane of values are given)",
       mesh,
       mode},
      {"--edges", Toggle(), &S::shows_edges, "the edges of the surface's cells, too", mesh, mode},
      {"--within", word("MESH", Content::kFile), &S::within,
       "draw a field within the surface of this mesh, such as the one that its kernels were fitted "
       "to, as the mesh's own is drawn",
       no_mesh, not_with("points motion-blur")},
  };
  return all;
}

const Table<PointFlags>& point_settings() {
  using P = PointFlags;
  static const Table<P> all = {
      {"--points",
       {"[=SIZE]",
        [](P& points, const std::string& text) {
          points.size = text.empty() ? 1 : parse_number(text, {.lo = 1e-3, .hi = 1e3});
        },
        [](const P& points) {
          if (!points.size) return Json();
          return *points.size == 1 ? Json(true) : Json(fmt::format("{}", *points.size));
        }},
       "particles and kernels: draw each as an opaque, lit ball, SIZE times as large as usual (1)",
       for_data({DatasetKind::kParticles, DatasetKind::kKernels}, "particles and kernels"),
       not_with("mode", "is for --mode composite", is_no_layer),
       not_with("value-plane motion-blur")},
  };
  return all;
}

}  // namespace ovoid::cli
