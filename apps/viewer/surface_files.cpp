// SPDX-License-Identifier: Apache-2.0
#include "surface_files.h"

#include <system_error>
#include <utility>

#include "make_geometry.h"

namespace ovoid::viewer {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostKeptBytes = std::size_t{64} << 20;

std::size_t bytes_of(const Dataset& mesh) {
  std::size_t bytes = mesh.positions.bytes.view.size() +
                      mesh.cells.connectivity.view().size_bytes() +
                      mesh.cells.offsets.view().size_bytes();
  for (const DataArray& array : mesh.arrays) bytes += array.bytes.view.size();
  return bytes;
}

}  // namespace

Dataset SurfaceFiles::mesh_at(const fs::path& place, const std::string& path, const State& state,
                              cli::Session& session) {
  if (last_ && last_->place == place && last_->state == state) return last_->mesh;
  last_.reset();
  Dataset mesh = cli::read_faces(path, session);
  if (mesh.kind != DatasetKind::kLattice && bytes_of(mesh) <= kMostKeptBytes)
    last_ = Mesh{place, state, mesh};
  return mesh;
}

SurfaceFiles::Found SurfaceFiles::find(const SurfaceSource& source, cli::Session& session) {
  const std::string& path = source.file;
  std::error_code error;
  const fs::path place = fs::absolute(path, error).lexically_normal();
  // Before it is read: what is written meanwhile is read the next time.
  const State state{fs::last_write_time(place, error), fs::file_size(place, error)};
  const auto key = std::pair(place, std::pair(source.array, source.radius));
  if (const auto known = kept_.find(key); known != kept_.end() && !error) {
    const Kept& kept = known->second;
    auto read = kept.read.lock();
    // By the name that it has now.
    if (read != nullptr && kept.state == state && read->source == source)
      return {std::move(read), kept.is_alone, nullptr};
  }
  if (error) last_.reset();
  std::erase_if(kept_, [](const auto& entry) { return entry.second.read.expired(); });
  Dataset mesh = mesh_at(place, path, state, session);
  if (mesh.kind == DatasetKind::kLattice)
    return {nullptr, false, std::make_shared<const Dataset>(std::move(mesh))};
  auto read = std::make_shared<ReadSurface>();
  read->source = source;
  read->arrays = cli::arrays_for_colors(mesh);
  read->has_radius = cli::has_lines_or_points(mesh);
  const bool is_alone = !cli::has_more_than_faces(mesh);
  cli::GeometryFlags flags;
  flags.arrays = {source.array};
  flags.radii = {source.radius};
  read->surface = cli::surface_of_faces(std::move(mesh), path, flags, 0, session);
  if (!source.array.empty()) read->values = cli::range_of_values(*read->surface);
  kept_[key] = {state, is_alone, read};
  return {std::move(read), is_alone, nullptr};
}

std::shared_ptr<const ReadSurface> SurfaceFiles::read(const SurfaceSource& source,
                                                      cli::Session& session) {
  Found found = find(source, session);
  if (found.lattice != nullptr)
    cli::surface_of_faces(*found.lattice, source.file, {}, 0, session);  // refuses it
  return std::move(found.read);
}

}  // namespace ovoid::viewer
