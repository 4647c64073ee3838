// SPDX-License-Identifier: Apache-2.0
#include "make_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "make_field.h"
#include "make_look.h"
#include "ovoid/channels.h"
#include "ovoid/error.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

constexpr std::size_t kMostChannels = Scene::kMaxVolumes;

// Where a channel is: an array, or a component of one.
struct Channel {
  std::string array;
  int component = kUsualComponent;
};

[[noreturn]] void refuse_channels(const std::string& why) {
  throw Error(ErrorCode::kInvalidArgument, "--channels: " + why);
}

const DataArray& chosen_array(const Dataset& dataset, const ModelFlags& model) {
  if (dataset.arrays.empty()) refuse_channels(fmt::format("'{}' has no arrays", dataset.source));
  if (model.array.empty()) return dataset.arrays.front();
  const DataArray* const found = find_array(dataset, model.array);
  if (found == nullptr) refuse_channels(fmt::format("there is no array '{}'", model.array));
  return *found;
}

// The components of one array where --array names it or there is no other, else the arrays.
std::vector<Channel> all_channels(const Dataset& dataset, const ModelFlags& model) {
  std::vector<Channel> all;
  if (dataset.arrays.size() > 1 && model.array.empty()) {
    for (const DataArray& array : dataset.arrays) all.push_back({array.name});
    return all;
  }
  const DataArray& array = chosen_array(dataset, model);
  for (int i = 0; i < array.num_components; ++i) all.push_back({array.name, i});
  return all;
}

std::string names_of(const Dataset& dataset) {
  std::string names;
  for (const DataArray& array : dataset.arrays)
    names += fmt::format("{}'{}'", names.empty() ? "" : " ", array.name);
  return names;
}

// A number is a component of the chosen array.
std::optional<Channel> component_called(const std::string& name, const Dataset& dataset,
                                        const ModelFlags& model) {
  const bool is_number =
      name.size() < 4 && name.find_first_not_of("0123456789") == std::string::npos;
  if (!is_number) return std::nullopt;
  const DataArray& array = chosen_array(dataset, model);
  const int component = std::stoi(name);
  if (array.num_components < 2 || component >= array.num_components) return std::nullopt;
  return Channel{array.name, component};
}

Channel channel_called(const std::string& name, const Dataset& dataset, const ModelFlags& model) {
  if (find_array(dataset, name) != nullptr) return {name};
  if (const auto component = component_called(name, dataset, model)) return *component;
  refuse_channels(fmt::format("'{}' is not an array, expected some of {}, or numbers of components",
                              name, names_of(dataset)));
}

std::vector<Channel> wanted_channels(const Dataset& dataset, const DrawingFlags& drawing) {
  std::vector<Channel> wanted;
  const std::vector<std::string>& names = drawing.channels.names;
  if (names == std::vector<std::string>{"all"}) {
    wanted = all_channels(dataset, drawing.model);
    if (wanted.size() > kMostChannels) {
      refuse_channels(fmt::format("'{}' has {}, at most {} are drawn together: name them, of {}",
                                  dataset.source, wanted.size(), kMostChannels, names_of(dataset)));
    }
    return wanted;
  }
  for (const std::string& name : names) {
    wanted.push_back(channel_called(name, dataset, drawing.model));
    if ((wanted.back().component == kUsualComponent) !=
        (wanted.front().component == kUsualComponent))
      refuse_channels("expected names of arrays, or numbers of components, not both");
  }
  if (wanted.size() > kMostChannels)
    refuse_channels(fmt::format("{} named, expected at most {}", wanted.size(), kMostChannels));
  return wanted;
}

bool are_primaries(const DrawingFlags& drawing) {
  return drawing.channels.names == std::vector<std::string>{"rgb"};
}

const DataArray& array_of_primaries(const Dataset& dataset, const DrawingFlags& drawing) {
  const DataArray& array = chosen_array(dataset, drawing.model);
  if (array.num_components == 3 || array.num_components == 4) return array;
  refuse_channels(
      fmt::format("rgb: array '{}' has {} components, expected red, green, blue and perhaps "
                  "opacity",
                  array.name, array.num_components));
}

LatticeField field_of(const Dataset& dataset, const DrawingFlags& drawing, const Channel& channel,
                      Session& session) {
  ModelFlags model = drawing.model;
  model.array = channel.array;
  model.component = channel.component;
  const Quiet quiet(session);
  return *make_field(dataset, model, drawing.run.threads, session).field.lattice();
}

ChannelDisplay display_of(const Dataset& dataset, const Channel& channel) {
  return find_array(dataset, channel.array)->display;
}

// The file's, where it gives each channel one and they are told apart.
std::vector<Rgb> usual_colors(const Dataset& dataset, const std::vector<Channel>& channels) {
  std::vector<Rgb> colors;
  for (const Channel& channel : channels)
    if (const auto color = display_of(dataset, channel).color) colors.push_back(*color);
  const bool are_all = colors.size() == channels.size();
  const bool are_same =
      colors.size() > 1 &&
      std::adjacent_find(colors.begin(), colors.end(), std::not_equal_to<>()) == colors.end();
  return are_all && !are_same ? colors : channel_colors(channels.size());
}

Rgb color_of(const Dataset& dataset, const ChannelFlags& flags,
             const std::vector<Channel>& channels, std::size_t i) {
  return i < flags.colors.size() ? flags.colors[i] : usual_colors(dataset, channels).at(i);
}

ValueRange range_of(const ChannelFlags& flags, std::size_t i, const ChannelDisplay& display,
                    const LatticeField& field) {
  const auto as_floats = [](double lo, double hi) {
    return ValueRange{static_cast<float>(lo), static_cast<float>(hi)};
  };
  if (i < flags.ranges.size()) return as_floats(flags.ranges[i].first, flags.ranges[i].second);
  if (display.range) return as_floats((*display.range)[0], (*display.range)[1]);
  return channel_range(field);
}

// What cannot be drawn of several, or says what one of them is to look like.
constexpr const char* kOfOneVolume[] = {
    "label-surfaces", "colormap", "value-plane", "kernel",           "tf",        "opacity",
    "motion-blur",    "log",      "tf2d",        "save-look",        "component", "shift",
    "array",          "over",     "pick",        "post-convolution", "symlog",    "window",
    "points",         "colorbar", "dry-run",     "gradient-opacity", "preset",    "labels",
    "range"};

// Whether the file says in which colours its channels show, and nothing else was asked for.
bool shows_channels_itself(const Dataset& dataset, const Flags& flags, const DrawingFlags& drawing,
                           Session& session) {
  const std::size_t count = dataset.arrays.size();
  const bool has_flag = std::any_of(flags.forms().begin(), flags.forms().end(),
                                    [](const FlagForm& form) { return form.name == "channels"; });
  if (!has_flag || dataset.kind != DatasetKind::kLattice || count < 2) return false;
  if (!drawing.model.array.empty()) return false;  // chosen in a window
  const bool are_shown =
      std::all_of(dataset.arrays.begin(), dataset.arrays.end(),
                  [](const DataArray& array) { return array.display.color.has_value(); });
  const bool is_of_one = std::any_of(std::begin(kOfOneVolume), std::end(kOfOneVolume),
                                     [&](const char* flag) { return flags.is_given(flag); }) ||
                         drawing.run.backend == Backend::kVulkan;
  const Mode mode = drawing.look.mode;
  const bool is_whole = session.team() == nullptr && !flags.is_given("part");
  const bool is_mode_of_several =
      mode == Mode::kComposite || (is_whole && (mode == Mode::kMaximum || mode == Mode::kMinimum));
  if (!are_shown || is_of_one || !is_mode_of_several) return false;
  if (count > kMostChannels) {
    session.note(
        fmt::format("'{}' has {} channels, of which one is drawn: --channels NAME,... draws "
                    "up to {} together",
                    dataset.source, count, kMostChannels));
    return false;
  }
  session.note(
      fmt::format("its {} channels are drawn in the colours that the file names (--array "
                  "NAME for one)",
                  count));
  return true;
}

}  // namespace

LookFlags channel_look_flags(const LookFlags& picture, const ValueRange& range, const Rgb& color) {
  const Look look = channel_look(range, color, picture.mode);
  const TransferFunction& tf = look.transfer_function;
  LookFlags own = picture;
  own.color_map.clear();
  for (const ColorPoint& point : tf.colors) {
    own.color_map += fmt::format("{}{},{},{},{}", own.color_map.empty() ? "" : ",", point.x,
                                 point.rgb[0], point.rgb[1], point.rgb[2]);
  }
  own.opacities = tf.opacities;
  return own;
}

std::vector<NamedChannel> named_channels(const Dataset& dataset, const DrawingFlags& drawing,
                                         const std::vector<Volume>& volumes) {
  std::vector<NamedChannel> named;
  if (drawing.channels.names.empty() || are_primaries(drawing)) return named;
  const std::vector<Channel> channels = wanted_channels(dataset, drawing);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const bool is_array = channels[i].component == kUsualComponent;
    const std::string number = std::to_string(channels[i].component);
    const LatticeField& field = *volumes.at(i).field.lattice();
    named.push_back({is_array ? channels[i].array : number,
                     is_array ? channels[i].array : "component " + number, field,
                     range_of(drawing.channels, i, display_of(dataset, channels[i]), field),
                     color_of(dataset, drawing.channels, channels, i)});
  }
  return named;
}

void take_channels(const Dataset& dataset, const Flags& flags, DrawingFlags* drawing,
                   Session& session) {
  if (drawing->channels.names.empty() && shows_channels_itself(dataset, flags, *drawing, session))
    drawing->channels.names = {"all"};
  if (drawing->channels.names.empty()) return;
  if (dataset.kind != DatasetKind::kLattice) refuse_channels("are of lattices");
  if (are_primaries(*drawing)) {
    const DataArray& array = array_of_primaries(dataset, *drawing);
    drawing->model.array = array.name;
    drawing->model.component = array.num_components == 4 ? 3 : LatticeModelOptions::kMagnitude;
    if (array.num_components == 3)
      session.note("rgb: there is no fourth component, so what is bright is opaque");
    return;
  }
  const std::vector<Channel> channels = wanted_channels(dataset, *drawing);
  ChannelFlags& said = drawing->channels;
  if (channels[0].component == kUsualComponent) {  // arrays, which "all" no longer is from here on
    said.names.clear();
    for (const Channel& channel : channels) said.names.push_back(channel.array);
  }
  const std::size_t most = std::max(said.colors.size(), said.ranges.size());
  if (most > channels.size()) {
    throw UsageError(fmt::format("{}: given {} times, for {} channels",
                                 said.colors.size() == most ? "--channel-color" : "--channel-range",
                                 most, channels.size()));
  }
  drawing->model.array = channels[0].array;
  drawing->model.component = channels[0].component;
  if (!flags.is_given("background")) drawing->background = Rgb{0, 0, 0};
}

void take_channel_look(const Dataset& dataset, const LatticeField& field, DrawingFlags* drawing) {
  const ChannelFlags& said = drawing->channels;
  if (said.names.empty() || are_primaries(*drawing)) return;
  const std::vector<Channel> channels = wanted_channels(dataset, *drawing);
  const ValueRange range = range_of(said, 0, display_of(dataset, channels[0]), field);
  const Rgb color = color_of(dataset, said, channels, 0);
  drawing->look = channel_look_flags(drawing->look, range, color);
}

std::vector<Volume> make_channels(const Dataset& dataset, const DrawingFlags& drawing,
                                  Session& session) {
  const ChannelFlags& said = drawing.channels;
  std::vector<Volume> volumes;
  if (said.names.empty()) return volumes;
  if (are_primaries(drawing)) {
    const DataArray& array = array_of_primaries(dataset, drawing);
    for (int i = 0; i < 3; ++i) {
      const LatticeField field = field_of(dataset, drawing, {array.name, i}, session);
      const bool is_of_bytes = array.type == ScalarType::kUInt8;
      const Look look = primary_look(is_of_bytes ? ValueRange{0, 255} : field.value_range(), i);
      volumes.push_back({field, look});
    }
    return volumes;
  }
  const std::vector<Channel> channels = wanted_channels(dataset, drawing);
  for (std::size_t i = 1; i < channels.size(); ++i) {
    const LatticeField field = field_of(dataset, drawing, channels[i], session);
    const ValueRange range = range_of(said, i, display_of(dataset, channels[i]), field);
    const LookFlags own =
        channel_look_flags(drawing.look, range, color_of(dataset, said, channels, i));
    const Quiet quiet(session);
    volumes.push_back({field, make_look(own, Field(field), "", session)});
  }
  return volumes;
}

void leave_colors_to_channels(const DrawingFlags& drawing, Look* look) {
  if (!are_primaries(drawing)) return;
  for (ColorPoint& point : look->transfer_function.colors) point.rgb = {1, 1, 1};
}

Mixing mixing_of(const DrawingFlags& drawing) {
  if (are_primaries(drawing)) return Mixing::kColored;
  return drawing.channels.mixing.value_or(drawing.channels.names.empty() ? Mixing::kAveraged
                                                                         : Mixing::kAdded);
}

}  // namespace ovoid::cli
