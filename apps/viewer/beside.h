// SPDX-License-Identifier: Apache-2.0
// What stands beside the data in the picture, as files have it: surfaces, labels and volumes.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "histogram.h"
#include "ovoid/dataset.h"
#include "ovoid/labels.h"
#include "ovoid/scene.h"
#include "session.h"
#include "settings.h"
#include "surface_files.h"

namespace ovoid::viewer {

// kAdd: into the scene; kDrop: where it is surfaces and nothing more, or may be beside lattices;
// kRenew: in the place of what was read before.
enum class BesideUse { kAdd, kDrop, kRenew };
// What a file is to be; kAny: what it looks like.
enum class BesideKind { kAny, kLabels };

// Where a volume of --over is, and where it lies; empty: not said.
struct VolumeSource {
  std::string file, array, transform;
};

struct BesideTask {
  std::vector<std::string> paths;
  BesideUse use = BesideUse::kAdd;
  BesideKind kind = BesideKind::kAny;
  std::size_t num_volumes = 0;          // that are beside the data so far
  std::vector<VolumeSource> renewed{};  // volumes, which are read again
  std::vector<SurfaceSource> made{};    // surfaces, which are read again, or made otherwise
};

// A label map's file, and how it is drawn where nothing is said of single labels.
struct LabelsBeside {
  std::string file;
  std::shared_ptr<const LabelSurfaces> surfaces;
};

// A further volume, with the look that it begins with.
struct VolumeBeside {
  VolumeSource source;
  Volume volume;
  cli::Histogram histogram;
};

struct BesideRead {
  BesideUse use = BesideUse::kAdd;
  std::vector<std::shared_ptr<const ReadSurface>> surfaces;
  std::vector<SurfaceSource> failed;  // of those that were to be made
  std::vector<LabelsBeside> labels;
  std::vector<std::shared_ptr<const VolumeBeside>> volumes;
  std::vector<std::string> data;    // of kDrop: are to be opened instead
  std::vector<std::string> errors;  // of those that cannot be read, one each
};

// Of .stl, .obj, .vtp, and of .ply what has faces. Opens no file but the last.
bool is_surface_by_name(const std::string& path);

// The labels of a file beside data that were opened with these flags. Throws Error.
LabelsBeside labels_beside(const std::string& path, const cli::DrawingFlags& opened,
                           cli::Session& session);

// The volumes of --over beside data that were opened with these flags. Throws Error.
std::vector<std::shared_ptr<const VolumeBeside>> volumes_beside(const Dataset& data,
                                                                const cli::DrawingFlags& opened,
                                                                cli::Session& session);

// `data` were opened with the flags `opened`. `told`: each path, before it is read. Throws
// Error(kCancelled).
BesideRead read_beside(const BesideTask& task, const Dataset& data, const cli::DrawingFlags& opened,
                       SurfaceFiles& surfaces, cli::Session& session,
                       const std::function<void(const std::string& path)>& told);

}  // namespace ovoid::viewer
