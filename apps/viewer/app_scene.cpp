// SPDX-License-Identifier: Apache-2.0
// What stands beside the data: surfaces that are read, dropped and renewed.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "app.h"

namespace ovoid::viewer {
namespace {

// Whether a PLY file has faces, by its header: those without are points or kernels, and may be
// large.
bool has_faces(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;  // a pipe would block
  std::ifstream file(path, std::ios::binary);
  std::string head(std::size_t{1} << 16, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  std::istringstream lines(head.substr(0, head.find("end_header")));
  for (std::string word, name; lines >> word;) {
    double count = 0;
    if (word == "element" && lines >> name >> count && name == "face") return count > 0;
  }
  return false;
}

bool may_be_surface(const std::string& path) {
  if (cli::has_ending(path, ".ply")) return has_faces(path);
  return cli::has_ending(path, ".stl") || cli::has_ending(path, ".obj") ||
         cli::has_ending(path, ".vtp");
}

}  // namespace

bool App::take_dropped_surfaces(const std::vector<std::string>& paths) {
  if (!document_.is_open() || !std::all_of(paths.begin(), paths.end(), may_be_surface))
    return false;
  read_surfaces(paths, SurfaceUse::kDrop);
  return true;
}

void App::read_surfaces(const std::vector<std::string>& paths, SurfaceUse use) {
  if (paths.empty()) return;
  if (!document_.is_open()) return tell("a surface beside the data needs data first", true);
  panel_state_.surface_error.clear();
  progress_ = LoadProgress{"reading " + std::filesystem::path(paths.front()).filename().string()};
  loader_->read_surfaces(paths, use);
}

// Those of the view, once each.
std::vector<std::string> App::surface_files() const {
  std::vector<std::string> files;
  for (const AddedSurface& added : document_.view.added) {
    if (std::find(files.begin(), files.end(), added.file) == files.end())
      files.push_back(added.file);
  }
  return files;
}

void App::take_surfaces(const SurfacesRead& read) {
  progress_.reset();
  for (const auto& [path, surface] : read.files) {
    if (read.use == SurfaceUse::kRenew) {
      document_.renew_surface(path, surface);
    } else {
      document_.add_surface(path, surface);
    }
  }
  std::vector<std::string> errors = read.errors;
  if (!read.data.empty()) {
    if (read.files.empty() && errors.empty()) return open(read.data);
    errors.push_back(fmt::format("{}: not only surfaces: drop them by themselves to open them",
                                 fmt::join(read.data, ", ")));
  }
  for (const std::string& error : errors) tell(error, true);
  if (!errors.empty()) panel_state_.surface_error = fmt::format("{}", fmt::join(errors, "\n"));
  watch_files();
}

nlohmann::ordered_json App::facts_of_scene() const {
  const View& view = document_.view;
  const auto list = [](const auto& numbers) {
    return nlohmann::ordered_json(std::vector<double>(numbers.begin(), numbers.end()));
  };
  nlohmann::ordered_json json = {{"surfaces", view.added.size()},
                                 {"edges", view.added_edges},
                                 {"error", panel_state_.surface_error},
                                 {"slices", view.slices.slices.size()},
                                 {"map", view.slices.slice_map},
                                 {"opacity", view.slices.slice_opacity},
                                 {"has_range", view.slices.slice_range.has_value()},
                                 {"shows_empty", view.slices.shows_empty},
                                 {"is_seen", document_.shows_scenery(view)}};
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
