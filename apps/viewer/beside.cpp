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
#include "make_over.h"
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

// What things stand beside, and how that was opened.
struct Beside {
  const Dataset& data;
  const cli::DrawingFlags& opened;
};

std::shared_ptr<const VolumeBeside> made_volume(VolumeSource source, Volume volume,
                                                const cli::Session& session) {
  auto made = std::make_shared<VolumeBeside>();
  made->source = std::move(source);
  made->histogram = cli::histogram_of(volume.field, session.stop());
  made->volume = std::move(volume);
  return made;
}

// `number`: how many are there already, by which colours are chosen.
std::shared_ptr<const VolumeBeside> read_volume(const VolumeSource& source, std::size_t number,
                                                const Beside& beside, cli::Session& session) {
  cli::DrawingFlags drawing = beside.opened;
  drawing.look = {};
  drawing.look.mode = beside.opened.look.mode;
  drawing.over = {};
  drawing.over.files.assign(number + 1, source.file);
  drawing.over.arrays.assign(number + 1, source.array);
  drawing.over.transforms.assign(number + 1, source.transform);
  Volume volume = cli::make_over_volume(drawing, number, beside.data.space, session);
  const std::string why =
      cli::out_of_sight(volume.field.world_bounds(), beside.data.lattice.world_bounds());
  if (!why.empty())
    throw Error(ErrorCode::kInvalidArgument, fmt::format("'{}' {}", source.file, why));
  if (!volume.field.world_bounds().intersects(beside.data.lattice.world_bounds()))
    session.note(fmt::format("'{}' lies beside the data, nowhere within them", source.file));
  return made_volume(source, std::move(volume), session);
}

void take_lattice(const std::string& path, const Dataset& dataset, const BesideTask& task,
                  const Beside& beside, BesideRead& read, cli::Session& session) {
  const cli::DrawingFlags& opened = beside.opened;
  const std::size_t number = task.num_volumes + read.volumes.size();
  if (are_labels(dataset, opened, session)) {
    read.labels.push_back(labels_in(dataset, path, opened, session));
  } else if (beside.data.kind != DatasetKind::kLattice && read.use == BesideUse::kDrop) {
    read.data.push_back(path);
  } else if (beside.data.kind != DatasetKind::kLattice) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("'{}' holds a lattice, which only other lattices are drawn with", path));
  } else if (number >= cli::kMostOver) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': at most {} volumes are drawn with the data; remove one", path,
                            cli::kMostOver));
  } else {
    read.volumes.push_back(read_volume({path, {}, {}}, number, beside, session));
  }
}

void read_one(const std::string& path, const BesideTask& task, const Beside& beside,
              SurfaceFiles& surfaces, BesideRead& read, cli::Session& session) {
  if (task.kind == BesideKind::kLabels) {
    read.labels.push_back(labels_beside(path, beside.opened, session));
    return;
  }
  SurfaceFiles::Found found = surfaces.find({path}, session);
  if (found.lattice != nullptr) {
    take_lattice(path, *found.lattice, task, beside, read, session);
  } else if (read.use != BesideUse::kDrop || found.is_alone) {
    read.surfaces.push_back(std::move(found.read));
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

std::vector<std::shared_ptr<const VolumeBeside>> volumes_beside(const Dataset& data,
                                                                const cli::DrawingFlags& opened,
                                                                cli::Session& session) {
  std::vector<std::shared_ptr<const VolumeBeside>> all;
  const cli::OverFlags& over = opened.over;
  const auto said = [](const std::vector<std::string>& words, std::size_t i) {
    return i < words.size() ? words[i] : std::string();
  };
  for (cli::OverVolume& made : cli::make_over_volumes(opened, data, session)) {
    const std::size_t i = made.number;
    all.push_back(made_volume({over.files[i], said(over.arrays, i), said(over.transforms, i)},
                              std::move(made.volume), session));
  }
  return all;
}

BesideRead read_beside(const BesideTask& task, const Dataset& data, const cli::DrawingFlags& opened,
                       SurfaceFiles& surfaces, cli::Session& session,
                       const std::function<void(const std::string& path)>& told) {
  const Beside beside{data, opened};
  BesideRead read;
  read.use = task.use;
  const auto take = [&](const std::string& path, const auto& read_it) {
    told(path);
    try {
      read_it();
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kCancelled) throw;
      if (task.use == BesideUse::kDrop && may_be_data(path)) {
        read.data.push_back(path);
      } else {
        read.errors.push_back(cli::message_line(error.what()));
      }
    }
  };
  for (const std::string& path : task.paths)
    take(path, [&] { read_one(path, task, beside, surfaces, read, session); });
  for (const SurfaceSource& source : task.made) {
    const std::size_t errors = read.errors.size();
    take(source.file, [&] { read.surfaces.push_back(surfaces.read(source, session)); });
    if (read.errors.size() > errors) read.failed.push_back(source);
  }
  for (std::size_t i = 0; i < task.renewed.size(); ++i) {
    const VolumeSource& source = task.renewed[i];
    take(source.file, [&] { read.volumes.push_back(read_volume(source, i, beside, session)); });
  }
  return read;
}

}  // namespace ovoid::viewer
