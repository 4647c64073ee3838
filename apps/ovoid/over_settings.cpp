// SPDX-License-Identifier: Apache-2.0
// The table of --over: other volumes in the picture.
#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/further_volumes.h"
#include "setting_forms.h"
#include "settings.h"

namespace ovoid::cli {
namespace {

std::optional<std::string> has_no_layer(const std::string& mode) {
  return if_so(mode != "composite", mode);
}
std::optional<std::string> is_published_by_name(const std::string& way) {
  return if_so(way != "off" && way != "auto", way);
}

}  // namespace

const Table<OverFlags>& over_settings() {
  using O = OverFlags;
  const Rule beside = needs("over", "has no effect without --over");
  static const Table<O> all = {
      {"--over", word("FILE", Content::kFile), &O::files,
       fmt::format("another lattice in the picture, on its own grid and at its own place in the "
                   "world, such as a PET over a CT; at a place extinctions add and colours mix "
                   "(repeatable, up to {}; what follows is said of the first, the second ...)",
                   kMostFurtherVolumes),
       for_data({DatasetKind::kLattice}, "lattices"),
       not_with("mode", "is for --mode composite", has_no_layer),
       not_with("post-convolution", "is for --post-convolution off and auto", is_published_by_name),
       not_with("motion-blur points part dry-run", "{0} is for one volume")},
      {"--over-array", word("NAME"), &O::arrays, "its array, as --array", beside},
      {"--over-tf", look_file(), &O::looks, "its look, as --tf", beside},
      {"--over-preset", Form<std::string>{"NAME", parse_preset, same}, &O::presets,
       "its look, as --preset", beside, not_with("over-tf")},
      {"--over-colormap", Form<std::string>{"NAME|V,R,G,B,...", parse_color_map, same},
       &O::color_maps, "its colours, as --colormap (default hot, then haline, then plasma)",
       beside},
      {"--over-range", form("LO,HI", parse_range), &O::ranges, "as --range", beside},
      {"--over-opacity", form("V:A,V:A,...", parse_opacities), &O::opacities,
       "as --opacity (default: from 0 at 0.3 of the range to 0.5 at its end)", beside},
      {"--over-transform", word("FILE", Content::kFile), &O::transforms,
       "where it lies: a 4x4 matrix as text, from its file's world to the picture's, or an ITK "
       ".tfm (affine, rigid, translation) from the picture to it",
       beside},
  };
  return all;
}

void add_over_flags(Flags& flags, DrawingFlags* drawing) {
  flags.section("several volumes");
  flags.add(channel_settings(), &drawing->channels);
  flags.add(over_settings(), &drawing->over);
}

}  // namespace ovoid::cli
