// SPDX-License-Identifier: Apache-2.0
// The table of --channels: arrays or components of one file as colours of one picture.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string>
#include <vector>

#include "ovoid/further_volumes.h"
#include "setting_forms.h"
#include "settings.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

std::optional<std::string> has_no_channels(const std::string& mode) {
  return if_so(mode != "composite" && mode != "maximum" && mode != "mip" && mode != "minimum",
               mode);
}
std::optional<std::string> is_published_with_channels(const std::string& way) {
  return if_so(way != "off" && way != "auto", way);
}
std::optional<std::string> is_one_name(const std::string& names) {
  return if_so(names == "rgb", names);
}

std::vector<std::string> parse_channels(const std::string& text) {
  std::vector<std::string> names = split(text, ',');
  for (const std::string& name : names)
    if (name.empty()) throw BadValue("expected all, rgb, or names of arrays with commas between");
  return names;
}

const Names<Mixing> kMixings = {{"averaged", Mixing::kAveraged}, {"added", Mixing::kAdded}};

}  // namespace

const Table<ChannelFlags>& channel_settings() {
  using C = ChannelFlags;
  const Rule beside = needs("channels", "has no effect without --channels");
  const Rule of_colors = not_with("channels", "{0} rgb has its own colours", is_one_name);
  static const Table<C> all = {
      {"--channels",
       {"all|rgb|NAME,...",
        [](C& flags, const std::string& text) { flags.names = parse_channels(text); },
        [](const C& flags) {
          return flags.names.empty() ? Json()
                                     : Json(fmt::format("{}", fmt::join(flags.names, ",")));
        }},
       fmt::format("arrays of one file in one picture, each in a colour, as a microscope's are "
                   "(at most {}; all: its arrays, or the components of --array; rgb: components "
                   "that are red, green, blue and perhaps opacity)",
                   kMostFurtherVolumes + 1),
       for_data({DatasetKind::kLattice}, "lattices"),
       not_with("mode", "is for --mode composite, maximum and minimum", has_no_channels),
       not_with("post-convolution", "is for --post-convolution off and auto",
                is_published_with_channels),
       not_with("motion-blur points part dry-run over labels label-surfaces component colorbar "
                "pick save-look",
                "{0} is for one volume")},
      {"--channel-color", form("COLOR", parse_rgb), &C::colors,
       "of the first, the second ... (default: white for one, else green, magenta, azure, amber)",
       beside, of_colors},
      {"--channel-range", form("LO,HI", parse_range), &C::ranges,
       "values from which it shows to where it is as bright as it gets (default: what stands out "
       "of "
       "its background)",
       beside, of_colors},
      {"--mixing", choice(kMixings), &C::mixing,
       "what volumes that are drawn together show at a place: averaged, as two fogs in one room; "
       "added, as lights (default: added of --channels, averaged of --over)",
       needs("channels over", "has no effect without --channels or --over"), of_colors},
  };
  return all;
}

}  // namespace ovoid::cli
