// SPDX-License-Identifier: Apache-2.0
// Of the document: what is drawn together, channels of one file or volumes beside the data.
#include <algorithm>
#include <utility>

#include "document.h"
#include "make_channels.h"

namespace ovoid::viewer {
namespace {

bool shows_extremes(Mode mode) { return mode == Mode::kMaximum || mode == Mode::kMinimum; }

bool has_same_light(const Look& a, const Look& b) {
  return a.shade == b.shade && a.material == b.material && a.flat_rise == b.flat_rise &&
         a.lighting() == b.lighting();
}

void take_light(const Look& look, cli::LookFlags& flags) {
  flags.shade = look.shade;
  flags.no_shade = !look.shade;
  if (look.shade) {
    flags.ambient = look.material.ambient;
    flags.diffuse = look.material.diffuse;
    flags.specular = look.material.specular;
    flags.specular_power = look.material.specular_power;
    flags.flat_rise = look.flat_rise;
  }
  if (look.shade || look.shadows > 0) {
    flags.light = look.light;
    flags.light_direction = look.light_direction;
    flags.names_lights = true;
    flags.further_lights = look.further_lights;
  }
  flags.occlusion = look.occlusion;
  flags.shadows = look.shadows;
  flags.scattering_blending.reset();
  flags.scatter = look.scatter;
}

// Modes without light refuse flags about it.
void drop_light(cli::LookFlags& flags) {
  const cli::LookFlags without;
  flags.shade = false;
  flags.ambient = flags.diffuse = flags.specular = flags.specular_power = {};
  flags.light = without.light;
  flags.light_direction.reset();
  flags.names_lights = false;
  flags.further_lights.clear();
  flags.flat_rise = flags.occlusion = flags.shadows = flags.scatter = {};
  flags.scattering_blending.reset();
}

}  // namespace

bool Document::may_show_several(const View& of) const {
  const bool has_blur = shown->trail != nullptr && time.blur_length > 0;
  const PostConvolution way = of.options.post_convolution;
  return (of.look.mode == Mode::kComposite || shows_extremes(of.look.mode)) &&
         shown->field().lattice() != nullptr && !has_blur && !draws_points(of) &&
         (way == PostConvolution::kAuto || way == PostConvolution::kOff);
}

bool Document::shows_channels(const View& of) const {
  const bool is_mode = of.look.mode == Mode::kComposite || !shown->channels.are_primaries();
  return !shown->channels.chosen.empty() && is_mode && may_show_several(of);
}

bool Document::shows_volumes(const View& of) const {
  return !shows_channels(of) && may_show_several(of) &&
         std::any_of(of.volumes.begin(), of.volumes.end(),
                     [](const AddedVolume& volume) { return !volume.is_hidden; });
}

std::vector<ChannelStyle> Document::channels_of(const View& of) const {
  const std::vector<cli::NamedChannel>& named = shown->channels.named;
  if (of.channels.size() == named.size()) return of.channels;
  std::vector<ChannelStyle> styles;
  styles.reserve(named.size());
  for (const cli::NamedChannel& channel : named) styles.push_back({channel.color, channel.range});
  return styles;
}

cli::LookFlags Document::channel_flags(const View& of) const {
  cli::LookFlags flags = shown->channels.flags;
  const Look& look = of.look;
  const Look& first = shown->channels.first_look;
  if (!has_same_light(look, first)) take_light(look, flags);
  if (look.unit_distance != first.unit_distance) flags.unit_distance = look.unit_distance;
  flags.mode = look.mode;
  if (shows_extremes(look.mode)) drop_light(flags);
  return flags;
}

Look Document::channel_look(const View& of, std::size_t channel) const {
  const ShownChannels& all = shown->channels;
  const ChannelStyle style = channels_of(of).at(channel);
  cli::Session silent([](const std::string&) {}, {});
  return cli::make_look(cli::channel_look_flags(channel_flags(of), style.range, style.color),
                        Field(all.named[channel].field), channel == 0 ? shown->subject.unit : "",
                        silent, all.usual[channel]);
}

// As the flags of the command make it: the light is the volume's own until somebody edits it.
Look Document::volume_look(const View& of, const AddedVolume& volume) const {
  Look look = volume.of->volume.look;
  if (!has_same_light(of.look, shown->channels.first_look)) {
    look.shade = of.look.shade;
    look.material = of.look.material;
    look.flat_rise = of.look.flat_rise;
    look.lighting() = of.look.lighting();
  }
  const bool is_lit = of.look.mode == Mode::kComposite && (of.look.shade || of.look.shadows > 0);
  look.light = is_lit ? of.look.light : Look().light;
  look.light_direction = is_lit ? of.look.light_direction : std::nullopt;
  look.mode = of.look.mode;
  look.transfer_function = volume.curves;
  look.unit_distance = volume.unit_distance;
  look.unit_distance = unit_distance_of(look, volume.of->volume.field);
  return look;
}

void Document::add_volume(const std::shared_ptr<const VolumeBeside>& volume) {
  const Look& look = volume->volume.look;
  view.volumes.push_back({volume, look.transfer_function, look.unit_distance});
  touch();
}

void Document::renew_volume(const std::shared_ptr<const VolumeBeside>& volume) {
  change_views([&](View& of) {
    for (AddedVolume& added : of.volumes) {
      if (added.of->source.file == volume->source.file) added.of = volume;
    }
  });
  count_up();
}

cli::AnnotationFlags Document::marks_of(const View& of) const {
  cli::AnnotationFlags marks = of.marks;
  if (shows_channels(of)) marks.color_bar = false;
  return marks;
}

// Channels lie before black, and are added, unless somebody says otherwise.
void Document::take_channels(bool is_first) {
  const ShownChannels& channels = shown->channels;
  const bool had_channels = !view.channels.empty() || view.mixing == Mixing::kColored;
  const bool is_black = view.background == Rgb{0, 0, 0};
  view.channels.clear();
  view.channels = channels_of(view);
  const cli::ChannelFlags& flags = launch->drawing.channels;
  if (channels.are_primaries()) {
    view.mixing = Mixing::kColored;
  } else if (!channels.named.empty()) {
    view.mixing = is_first ? flags.mixing.value_or(Mixing::kAdded) : Mixing::kAdded;
    if (!is_first || !launch->flags->is_given("background")) view.background = {0, 0, 0};
  } else if (had_channels) {
    view.mixing = Mixing::kAveraged;
    if (is_black) view.background = cli::kBackground;
  }
}

std::vector<Volume> Document::volumes_of(const View& of) const {
  std::vector<Volume> volumes;
  if (!shows_volumes(of)) return volumes;
  for (const AddedVolume& added : of.volumes) {
    if (!added.is_hidden) volumes.push_back({added.of->volume.field, volume_look(of, added)});
  }
  return volumes;
}

void Document::put_channels(const View& of, PictureJob& into) const {
  const ShownChannels& channels = shown->channels;
  std::vector<Volume>& volumes = into.scene.volumes;
  if (channels.are_primaries()) {
    cli::DrawingFlags drawing;
    drawing.channels.names = channels.chosen;
    cli::leave_colors_to_channels(drawing, &volumes.front().look);
    const std::vector<Volume>& all = shown->subject.scene.volumes;
    volumes.insert(volumes.end(), all.begin() + 1, all.end());
    return;
  }
  const std::vector<ChannelStyle> styles = channels_of(of);
  bool is_first = true;
  for (std::size_t i = 0; i < styles.size(); ++i) {
    if (styles[i].is_hidden) continue;
    const Field field(channels.named[i].field);
    if (std::exchange(is_first, false)) {
      volumes.front().field = field;
      volumes.front().look = channel_look(of, i);
      into.is_of_shown = false;
    } else {
      volumes.push_back({field, channel_look(of, i)});
    }
  }
}

}  // namespace ovoid::viewer
