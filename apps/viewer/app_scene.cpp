// SPDX-License-Identifier: Apache-2.0
// What stands beside the data: surfaces and labels that are read, dropped and renewed.
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
  const LabelSurfaces& own = document_.shown->subject.scenery.labels;
  const bool may_be_labels =
      paths.size() == 1 && own.map == nullptr && !is_look_file(paths.front()) &&
      ((is_scene_shown_ && has_panel_) || cli::has_ending(paths.front(), ".seg.nrrd"));
  if (!are_surfaces && !may_be_labels) return false;
  read_beside({paths, BesideUse::kDrop});
  return true;
}

void App::read_beside(BesideTask task) {
  if (task.paths.empty()) return;
  if (!document_.is_open())
    return tell("a surface or labels beside the data need data first", true);
  panel_state_.beside_error.clear();
  const std::string first = std::filesystem::path(task.paths.front()).filename().string();
  progress_ = LoadProgress{"reading " + first};
  loader_->read_beside(std::move(task));
}

// Those that are shown are read again.
void App::renew_beside(const std::vector<std::string>& files) {
  BesideTask surfaces{{}, BesideUse::kRenew};
  BesideTask labels{{}, BesideUse::kRenew, BesideKind::kLabels};
  const std::optional<LabelsBeside>& shown = document_.view.labels;
  for (const std::string& file : files)
    (shown && shown->file == file ? labels : surfaces).paths.push_back(file);
  read_beside(std::move(surfaces));
  read_beside(std::move(labels));
}

// Those of the view, once each.
std::vector<std::string> App::files_beside() const {
  std::vector<std::string> files;
  const auto add = [&](const std::string& file) {
    if (std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
  };
  for (const AddedSurface& added : document_.view.added) add(added.file);
  if (document_.view.labels) add(document_.view.labels->file);
  return files;
}

void App::take_beside(const BesideRead& read) {
  progress_.reset();
  for (const auto& [path, surface] : read.files) {
    if (read.use == BesideUse::kRenew) {
      document_.renew_surface(path, surface);
    } else {
      document_.add_surface(path, surface);
    }
  }
  for (const LabelsBeside& labels : read.labels) {
    if (read.use == BesideUse::kRenew) {
      document_.renew_labels(labels);
    } else {
      document_.set_labels(labels);
    }
  }
  std::vector<std::string> errors = read.errors;
  if (!read.data.empty()) {
    if (read.files.empty() && read.labels.empty() && errors.empty()) return open(read.data);
    errors.push_back(fmt::format("{}: not only surfaces: drop them by themselves to open them",
                                 fmt::join(read.data, ", ")));
  }
  for (const std::string& error : errors) tell(error, true);
  if (!errors.empty()) panel_state_.beside_error = fmt::format("{}", fmt::join(errors, "\n"));
  watch_files();
}

nlohmann::ordered_json App::facts_of_labels() const {
  const View& view = document_.view;
  nlohmann::ordered_json json = {{"file", view.labels ? view.labels->file : ""},
                                 {"are_shown", document_.shows_labels(view)}};
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
                                 {"is_seen", document_.shows_scenery(view)},
                                 {"labels", facts_of_labels()}};
  for (const AddedSurface& added : view.added) {
    json["surface"].push_back({{"file", added.file},
                               {"color", list(added.color)},
                               {"opacity", added.opacity},
                               {"is_hidden", added.is_hidden},
                               {"triangles", added.surface->triangles.size()}});
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
