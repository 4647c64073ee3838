// SPDX-License-Identifier: Apache-2.0
#include "surface_files.h"

#include <system_error>
#include <utility>

#include "make_geometry.h"

namespace ovoid::viewer {

SurfaceFiles::Found SurfaceFiles::find(const std::string& path, cli::Session& session) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path place = fs::absolute(path, error).lexically_normal();
  // Before it is read: what is written meanwhile is read the next time.
  Kept now{fs::last_write_time(place, error), fs::file_size(place, error), false, {}};
  if (const auto known = kept_.find(place); known != kept_.end() && !error) {
    const Kept& kept = known->second;
    auto surface = kept.surface.lock();
    if (surface != nullptr && kept.time == now.time && kept.size == now.size)
      return {std::move(surface), kept.is_alone, nullptr};
  }
  std::erase_if(kept_, [](const auto& entry) { return entry.second.surface.expired(); });
  Dataset mesh = cli::read_faces(path, session);
  if (mesh.kind == DatasetKind::kLattice)
    return {nullptr, false, std::make_shared<const Dataset>(std::move(mesh))};
  now.is_alone = !cli::has_more_than_faces(mesh);
  Found found{cli::surface_of_faces(std::move(mesh), path, {}, 0, session), now.is_alone, nullptr};
  now.surface = found.surface;
  kept_[place] = std::move(now);
  return found;
}

std::shared_ptr<const Surface> SurfaceFiles::read(const std::string& path, cli::Session& session) {
  Found found = find(path, session);
  if (found.lattice != nullptr)
    cli::surface_of_faces(*found.lattice, path, {}, 0, session);  // refuses it
  return std::move(found.surface);
}

}  // namespace ovoid::viewer
