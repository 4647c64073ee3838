// SPDX-License-Identifier: Apache-2.0
#include "beside.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "make_field.h"
#include "make_labels.h"
#include "ovoid/error.h"
#include "ovoid/look.h"
#include "ovoid/model.h"

namespace ovoid::viewer {
namespace {

LabelsBeside labels_in(const Dataset& dataset, const std::string& path,
                       const cli::DrawingFlags& opened, cli::Session& session) {
  cli::DrawingFlags drawing = opened;
  cli::LabelFlags& labels = drawing.labels;
  if (labels.file != path) {  // what was said of others
    labels.inside.clear();
    labels.outside.clear();
  }
  labels.opacities.clear();
  labels.colors.clear();
  return {path,
          std::make_shared<const LabelSurfaces>(cli::make_labels_of(dataset, drawing, session))};
}

// As data that are drawn by themselves are taken for labels.
bool are_labels(const Dataset& dataset, const cli::DrawingFlags& opened, cli::Session& session) {
  if (cli::is_segmentation(dataset)) return true;
  const cli::Quiet quiet(session);
  return holds_labels(
      cli::make_field(dataset, cli::ModelFlags(), opened.run.threads, session).field);
}

void take_lattice(const std::string& path, const Dataset& dataset, const cli::DrawingFlags& opened,
                  BesideRead& read, cli::Session& session) {
  if (are_labels(dataset, opened, session)) {
    read.labels.push_back(labels_in(dataset, path, opened, session));
  } else if (read.use == BesideUse::kDrop) {
    read.data.push_back(path);
  } else {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}' holds a lattice whose values are no labels, expected a surface "
                            "or a label map",
                            path));
  }
}

void read_one(const std::string& path, BesideKind kind, const cli::DrawingFlags& opened,
              SurfaceFiles& surfaces, BesideRead& read, cli::Session& session) {
  if (kind == BesideKind::kLabels) {
    read.labels.push_back(labels_beside(path, opened, session));
    return;
  }
  SurfaceFiles::Found found = surfaces.find(path, session);
  if (found.lattice != nullptr) {
    take_lattice(path, *found.lattice, opened, read, session);
  } else if (read.use != BesideUse::kDrop || found.is_alone) {
    read.files.push_back({path, std::move(found.surface)});
  } else {
    read.data.push_back(path);
  }
}

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

}  // namespace

bool is_surface_by_name(const std::string& path) {
  if (cli::has_ending(path, ".ply")) return has_faces(path);
  return cli::has_ending(path, ".stl") || cli::has_ending(path, ".obj") ||
         cli::has_ending(path, ".vtp");
}

namespace {

// Whether what is dropped, and is nothing beside data, may still be opened. A .vtp file may be of
// points.
bool may_be_data(const std::string& path) {
  return !is_surface_by_name(path) || cli::has_ending(path, ".vtp");
}

}  // namespace

LabelsBeside labels_beside(const std::string& path, const cli::DrawingFlags& opened,
                           cli::Session& session) {
  return labels_in(cli::read_labels(path, session), path, opened, session);
}

BesideRead read_beside(const BesideTask& task, const cli::DrawingFlags& opened,
                       SurfaceFiles& surfaces, cli::Session& session,
                       const std::function<void(const std::string& path)>& told) {
  BesideRead read;
  read.use = task.use;
  for (const std::string& path : task.paths) {
    told(path);
    try {
      read_one(path, task.kind, opened, surfaces, read, session);
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kCancelled) throw;
      if (task.use == BesideUse::kDrop && may_be_data(path)) {
        read.data.push_back(path);
      } else {
        read.errors.push_back(cli::one_line(error.what()));
      }
    }
  }
  return read;
}

}  // namespace ovoid::viewer
