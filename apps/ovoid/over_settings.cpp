// SPDX-License-Identifier: Apache-2.0
// The tables of --channels and --over: several volumes in one picture.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/scene.h"
#include "setting_forms.h"
#include "settings.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

std::optional<std::string> is_of_one(const std::string& mode) {
  return if_so(mode != "composite" && mode != "maximum" && mode != "mip" && mode != "minimum" &&
                   mode != "minip",
               mode);
}
std::optional<std::string> is_published_by_name(const std::string& way) {
  return if_so(way != "off" && way != "auto", way);
}

std::optional<std::string> is_rgb(const std::string& names) { return if_so(names == "rgb", names); }

std::optional<std::string> has_own_colors(const std::string& names) {
  return if_so(names != "rgb", names);
}

std::vector<std::string> parse_channels(const std::string& text) {
  std::vector<std::string> names = split(text, ',');
  for (const std::string& name : names)
    if (name.empty()) throw BadValue("expected all, rgb, or names of arrays with commas between");
  return names;
}

const Names<Mixing> kMixings = {{"averaged", Mixing::kAveraged}, {"added", Mixing::kAdded}};

// Of both.
Rule of_modes() {
  return not_with("mode", "is for --mode composite, maximum and minimum", is_of_one);
}
Rule of_sheets() {
  return not_with("post-convolution", "is for --post-convolution off and auto",
                  is_published_by_name);
}

}  // namespace

const Table<ChannelFlags>& channel_settings() {
  using C = ChannelFlags;
  const Rule beside = needs("channels", "has no effect without --channels");
  const Rule of_colors = not_with("channels", "{0} rgb has its own colours", is_rgb);
  static const Table<C> all = {
      {"--channels",
       {"all|rgb|NAME,...",
        [](C& flags, const std::string& text) { flags.names = parse_channels(text); },
        [](const C& flags) {
          return flags.names.empty() ? Json()
                                     : Json(fmt::format("{}", fmt::join(flags.names, ",")));
        }},
       fmt::format("arrays of one file in one picture, each in a colour, as a microscope's are "
                   "(at most {}; all: its arrays, or the components of --array, "
                   "which numbers from 0 name, too; rgb: components that are red, green, blue and "
                   "perhaps opacity)",
                   Scene::kMaxVolumes),
       for_data({DatasetKind::kLattice}, "lattices"),
       of_modes(),
       of_sheets(),
       not_with("motion-blur points dry-run over labels label-surfaces component colorbar "
                "pick save-look",
                "{0} is for one volume"),
       not_with("tf preset colormap opacity gradient-opacity tf2d range window log symlog shift",
                "has no use for {0}; --channel-color and --channel-range say how channels look",
                nullptr, has_own_colors)},
      {"--channel-color", form("COLOR", parse_rgb), &C::colors,
       "of the first, the second ... (default: white for one, else green, magenta, azure, amber)",
       beside, of_colors},
      {"--channel-range", form("LO,HI", parse_range), &C::ranges,
       "values from which it shows to where it is as bright as it gets (default: what "
       "stands out of its background)",
       beside, of_colors},
      {"--mixing", choice(kMixings), &C::mixing,
       "what volumes that are drawn together show at a place: averaged, as two fogs in one room; "
       "added, as lights (default: added of --channels, averaged of --over)",
       needs("channels over", "has no effect without --channels or --over"), of_colors},
  };
  return all;
}

const Table<OverFlags>& over_settings() {
  using O = OverFlags;
  const Rule beside = needs("over", "has no effect without --over");
  static const Table<O> all = {
      {"--over", word("FILE", Content::kFile), &O::files,
       fmt::format("another lattice in the picture, on its own grid and at its own place in the "
                   "world, such as a PET over a CT; at a place extinctions add and colours mix "
                   "(repeatable, up to {}; what follows is said of the first, the second ...)",
                   kMostOver),
       for_data({DatasetKind::kLattice}, "lattices"), of_modes(), of_sheets(),
       not_with("motion-blur points dry-run", "{0} is for one volume")},
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
