// SPDX-License-Identifier: Apache-2.0
// What stands beside the data: surfaces, labels and volumes that are read, dropped and renewed.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "app.h"

namespace ovoid::viewer {

bool App::take_drop_beside(const std::vector<std::string>& paths) {
  if (!document_.is_open()) return false;
  const bool are_surfaces = std::all_of(paths.begin(), paths.end(), is_surface_by_name);
  const LabelSurfaces& own = document_.shown->subject.scene.labels;
  const bool is_meant =
      paths.size() == 1 && own.map == nullptr && !is_look_file(paths.front()) &&
      ((is_scene_shown_ && has_panel_) || cli::has_ending(paths.front(), ".seg.nrrd"));
  if (!are_surfaces && !is_meant) return false;
  read_beside({paths, BesideUse::kDrop});
  return true;
}

void App::read_beside(BesideTask task) {
  if (task.paths.empty() && task.renewed.empty() && task.made.empty()) return;
  if (!document_.is_open()) return tell("what is to stand beside the data needs data first", true);
  panel_state_.beside_error.clear();
  const std::string& path = !task.paths.empty()  ? task.paths[0]
                            : !task.made.empty() ? task.made[0].file
                                                 : task.renewed[0].file;
  const std::string first = std::filesystem::path(path).filename().string();
  progress_ = LoadProgress{"reading " + first};
  task.num_volumes = document_.view.volumes.size();
  loader_->read_beside(std::move(task));
}

// Those that are shown are read again.
void App::renew_beside(const std::vector<std::string>& files) {
  BesideTask surfaces{{}, BesideUse::kRenew};
  BesideTask labels{{}, BesideUse::kRenew, BesideKind::kLabels};
  const std::optional<LabelsBeside>& shown = document_.view.labels;
  for (const std::string& file : files) {
    for (SurfaceSource& source : document_.surfaces_of(file))
      surfaces.made.push_back(std::move(source));
    if (shown && shown->file == file) labels.paths.push_back(file);
    for (const AddedVolume& added : document_.view.volumes)
      if (added.of->source.file == file) surfaces.renewed.push_back(added.of->source);
  }
  read_beside(std::move(surfaces));
  read_beside(std::move(labels));
}

// Those of the view, once each.
std::vector<std::string> App::files_beside() const {
  std::vector<std::string> files;
  const auto add = [&](const std::string& file) {
    if (std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
  };
  for (const AddedSurface& added : document_.view.added) add(added.source.file);
  if (document_.view.labels) add(document_.view.labels->file);
  for (const AddedVolume& added : document_.view.volumes) add(added.of->source.file);
  return files;
}

void App::take_beside(const BesideRead& read) {
  progress_.reset();
  for (const auto& surface : read.surfaces) {
    if (read.use == BesideUse::kRenew) {
      document_.renew_surface(surface);
    } else {
      document_.add_surface(surface);
    }
  }
  for (const SurfaceSource& source : read.failed) document_.give_up_surface(source);
  if (read.use == BesideUse::kRenew) awaits_surfaces_ = false;
  for (const LabelsBeside& labels : read.labels) {
    if (read.use == BesideUse::kRenew) {
      document_.renew_labels(labels);
    } else {
      document_.set_labels(labels);
    }
  }
  for (const auto& volume : read.volumes) {
    if (read.use == BesideUse::kRenew) {
      document_.renew_volume(volume);
    } else {
      document_.add_volume(volume);
      tell(volume->source.file + " is drawn with the data");
    }
  }
  std::vector<std::string> errors = read.errors;
  const bool is_nothing_else = read.surfaces.empty() && read.labels.empty() && read.volumes.empty();
  if (!read.data.empty()) {
    if (is_nothing_else && errors.empty()) return open(read.data);
    errors.push_back(fmt::format("{}: not only surfaces: drop them by themselves to open them",
                                 fmt::join(read.data, ", ")));
  }
  for (const std::string& error : errors) tell(error, true);
  if (!errors.empty()) panel_state_.beside_error = fmt::format("{}", fmt::join(errors, "\n"));
  watch_files();
}

// One at a time: of what a slider does meanwhile, only the last is made.
void App::ask_for_surfaces() {
  if (!document_.is_open() || awaits_surfaces_) return;
  std::vector<SurfaceSource> sources = document_.surfaces_to_make();
  if (sources.empty()) return;
  BesideTask task{{}, BesideUse::kRenew};
  task.made = std::move(sources);
  awaits_surfaces_ = true;
  loader_->read_beside(std::move(task));
}

nlohmann::ordered_json App::facts_of_labels() const {
  const View& view = document_.view;
  nlohmann::ordered_json json = {{"file", view.labels ? view.labels->file : ""},
                                 {"are_shown", document_.shows_labels(view)},
                                 {"are_flat", view.are_labels_flat}};
  const LabelSurfaces* const plain = document_.plain_labels(view);
  json["count"] = plain == nullptr ? 0 : plain->styles.size();
  if (plain == nullptr) return json;
  for (const LabelStyle& style : edited(plain->styles, view.label_edits)) {
    json[std::to_string(style.label)] = {
        {"name", style.name},
        {"color", std::vector<double>(style.color.begin(), style.color.end())},
        {"opacity", style.opacity}};
  }
  return json;
}

nlohmann::ordered_json App::facts_of_several() const {
  const View& view = document_.view;
  nlohmann::ordered_json json = {{"are_seen", document_.shows_volumes(view)},
                                 {"channels_are_seen", document_.shows_channels(view)},
                                 {"mixing", static_cast<int>(view.mixing)},
                                 {"volumes", view.volumes.size()},
                                 {"channels", document_.shown->channels.named.size()}};
  for (const AddedVolume& added : view.volumes) {
    double greatest = 0;
    for (const OpacityPoint& point : added.curves.opacities)
      greatest = std::max(greatest, point.opacity);
    json["volume"].push_back({{"file", added.of->source.file},
                              {"is_hidden", added.is_hidden},
                              {"range", {added.curves.lo(), added.curves.hi()}},
                              {"opacity", greatest}});
  }
  const std::vector<ChannelStyle> styles = document_.channels_of(view);
  for (std::size_t i = 0; i < styles.size(); ++i) {
    const Rgb& color = styles[i].color;
    json["channel"].push_back({{"name", document_.shown->channels.named[i].name},
                               {"color", std::vector<double>(color.begin(), color.end())},
                               {"range", {styles[i].range.lo, styles[i].range.hi}},
                               {"is_hidden", styles[i].is_hidden}});
  }
  return json;
}

nlohmann::ordered_json App::facts_of_scene() const {
  const View& view = document_.view;
  const auto list = [](const auto& numbers) {
    return nlohmann::ordered_json(std::vector<double>(numbers.begin(), numbers.end()));
  };
  nlohmann::ordered_json json = {{"surfaces", view.added.size()},
                                 {"edges", view.added_edges},
                                 {"error", panel_state_.beside_error},
                                 {"slices", view.slices.slices.size()},
                                 {"map", view.slices.slice_map},
                                 {"opacity", view.slices.slice_opacity},
                                 {"has_range", view.slices.slice_range.has_value()},
                                 {"shows_empty", view.slices.shows_empty},
                                 {"outlines", view.slices.has_outlines},
                                 {"is_seen", document_.shows_scenery(view)},
                                 {"labels", facts_of_labels()},
                                 {"several", facts_of_several()}};
  for (const AddedSurface& added : view.added) {
    const auto range = added.range.value_or(added.of->values);
    json["surface"].push_back({{"file", added.source.file},
                               {"color", list(added.color)},
                               {"opacity", added.opacity},
                               {"is_hidden", added.is_hidden},
                               {"triangles", added.of->surface->triangles.size()},
                               {"array", added.source.array},
                               {"radius", added.source.radius},
                               {"map", added.color_map},
                               {"has_range", added.range.has_value()},
                               {"range", {range.first, range.second}}});
  }
  for (const cli::SlicePlane& slice : view.slices.slices) {
    json["slice"].push_back(
        {{"normal", list(slice.normal)}, {"offset", document_.offset_of(slice)}});
  }
  if (view.slices.slice_range)
    json["range"] = {view.slices.slice_range->first, view.slices.slice_range->second};
  return json;
}

}  // namespace ovoid::viewer
