// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vdb.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data/names_text.h"
#include "io/core/memory.h"
#include "io/core/samples.h"
#include "io/foreign/vdb_blocks.h"
#include "io/foreign/vdb_file.h"
#include "io/foreign/vdb_points.h"
#include "io/foreign/vdb_samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Voxels of the background around the active ones.
constexpr std::int64_t kMargin = 1;

template <typename Filter>
std::vector<std::string> names_of(const std::vector<VdbGrid>& grids, const Filter& is_meant) {
  std::vector<std::string> names;
  for (const VdbGrid& grid : grids)
    if (is_meant(grid)) names.push_back(grid.name);
  return names;
}

bool is_any(const VdbGrid&) { return true; }
bool is_in_frustum(const VdbGrid& grid) { return grid.values && !grid.is_affine; }
bool has_no_numbers(const VdbGrid& grid) { return !grid.values && !grid.is_of_points; }

Index3 negated(const Index3& index) { return {-index[0], -index[1], -index[2]}; }

class VdbReader {
 public:
  explicit VdbReader(const ReaderRequest& request)
      : request_(request),
        options_(request.options),
        file_(request.source, request.paths.front()) {}

  Dataset read() {
    dataset_.source = file_.source();
    dataset_.format = "OpenVDB";
    VdbBlock block = choose();
    tell_of_others(block);
    if (block.is_of_points)
      read_vdb_points(file_, block.members.front().grid, options_, dataset_);
    else
      read_lattice(block);
    return std::move(dataset_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kUnsupported) const {
    throw Error(code, fmt::format("{}: {}", file_.source(), what));
  }
  void note(const std::string& what) {
    dataset_.notes.push_back(fmt::format("{}: {}", file_.source(), what));
  }

  // --- what is read -----------------------------------------------------------------------------

  VdbBlock choose() {
    const std::vector<VdbGrid>& grids = file_.grids();
    if (grids.empty()) fail("has no grids", ErrorCode::kFileFormat);
    blocks_ = blocks_of(grids);
    if (auto block = chosen_block(blocks_, options_)) return std::move(*block);
    if (!options_.block.empty()) refuse_choice("block", options_.block, names_of_blocks());
    for (const VdbGrid& grid : grids)
      if (options_.array.empty() || grid.name == options_.array) refuse(grid);
    refuse_choice("array", options_.array, names_of(grids, is_any));
  }

  [[noreturn]] void refuse_choice(const char* what, const std::string& asked,
                                  const std::vector<std::string>& names) const {
    fail(
        fmt::format("{} '{}': not there: expected one of {}", what, asked, data::names_text(names)),
        ErrorCode::kInvalidArgument);
  }

  [[noreturn]] void refuse(const VdbGrid& grid) const {
    const std::string name = data::name_text(grid.name);
    if (grid.values) {
      fail(
          fmt::format("grid {} lies in a camera's frustum, whose voxels are no lattice: expected "
                      "a grid of an affine transform, which OpenVDB can resample it to",
                      name));
    }
    fail(
        fmt::format("grid {} is of the type {}, which is not read: expected numbers, vectors of "
                    "three or points",
                    name, grid.type));
  }

  std::vector<std::string> names_of_blocks() const {
    std::vector<std::string> names;
    for (const VdbBlock& block : blocks_) names.push_back(block.name);
    return names;
  }

  void tell_of_others(const VdbBlock& read) {
    if (blocks_.size() > 1) {
      for (const VdbBlock& block : blocks_)
        dataset_.blocks.push_back({block.name, description_of(block)});
      dataset_.block = read.name;
      if (options_.block.empty() && options_.array.empty()) {
        note(fmt::format("holds grids at {} kinds of places, {} is read; choose with --block",
                         blocks_.size(), data::name_text(read.name)));
      }
    }
    const auto tell = [&](const auto& is_meant, const char* what) {
      const auto names = names_of(file_.grids(), is_meant);
      if (!names.empty()) note(fmt::format("{}: {}", what, data::names_text(names)));
    };
    tell(is_in_frustum, "grids in a camera's frustum are not read");
    tell(has_no_numbers, "grids that hold no numbers are not read");
  }

  static std::string description_of(const VdbBlock& block) {
    if (block.is_of_points) return "points";
    const Vec3 voxel = block.world_from_index.linear().colwise().norm();
    std::vector<std::string> names;
    for (const VdbMember& member : block.members) names.push_back(member.grid.name);
    return fmt::format("voxels of {:.6g} x {:.6g} x {:.6g}: {}", voxel[0], voxel[1], voxel[2],
                       data::names_text(names));
  }

  // --- lattices ---------------------------------------------------------------------------------

  void read_lattice(VdbBlock& block) {
    VoxelBox box;
    if (request_.paths.size() > 1) join_series(block, box);
    check_geometry(
        fmt::format("{}: the transform of grid {}", file_.source(), data::name_text(block.name)),
        block.world_from_index);
    std::vector<openvdb::GridBase::Ptr> grids;
    for (const VdbMember& member : block.members) {
      stop_if_asked();
      grids.push_back(file_.read(member.grid));
      box.add(active_box(*grids.back()).moved(negated(member.offset)));
    }
    if (box.is_empty()) {
      std::vector<std::string> names;
      for (const VdbMember& member : block.members) names.push_back(member.grid.name);
      fail(fmt::format("has no active voxels in {}: there is nothing to draw",
                       data::names_text(names)),
           ErrorCode::kFileFormat);
    }
    const VoxelBox samples = with_margin(box);
    place(block, samples);
    ReadProgress progress(options_, checked_size(block, samples, grids));
    for (std::size_t i = 0; i < grids.size(); ++i) {
      const VdbMember& member = block.members[i];
      dataset_.arrays.push_back(
          dense_samples(*grids[i], member.grid, samples.moved(member.offset), progress));
      grids[i].reset();
      tell_of_kind(member.grid);
    }
  }

  // Indices are counted as in all files of the series, and the box is that of all.
  void join_series(VdbBlock& block, VoxelBox& box) const {
    const VdbSeries series =
        series_of({request_.paths.begin() + 1, request_.paths.end()}, options_);
    if (!series.world_from_index) return;
    std::vector<VdbMember> members = block.members;
    for (VdbMember& member : members) {
      const auto offset = offset_in(*series.world_from_index, member.grid);
      if (!offset) return;  // another lattice: who compares the steps says so
      member.offset = *offset;
    }
    block.members = std::move(members);
    block.world_from_index = *series.world_from_index;
    box = series.box;
  }

  void stop_if_asked() const {
    if (options_.stop.stop_requested())
      throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
  }

  VoxelBox with_margin(const VoxelBox& active) const {
    VoxelBox box = active;
    for (std::size_t a = 0; a < 3; ++a) {
      box.first[a] -= kMargin;
      box.last[a] += kMargin;
      if (box.first[a] < -kFarthestVoxel || box.last[a] > kFarthestVoxel) {
        fail(fmt::format("has active voxels from index {} to {}: expected {} to {}",
                         active.first[a], active.last[a], -kFarthestVoxel, kFarthestVoxel),
             ErrorCode::kFileFormat);
      }
    }
    return box;
  }

  void place(const VdbBlock& block, const VoxelBox& samples) {
    dataset_.lattice.dims = samples.dims();
    dataset_.lattice.world_from_index = block.world_from_index;
    dataset_.lattice.world_from_index.translate(Vec3(static_cast<double>(samples.first[0]),
                                                     static_cast<double>(samples.first[1]),
                                                     static_cast<double>(samples.first[2])));
  }

  // The bytes of all arrays. Throws unless memory holds them: a small file may have voxels
  // anywhere.
  std::int64_t checked_size(const VdbBlock& block, const VoxelBox& samples,
                            const std::vector<openvdb::GridBase::Ptr>& grids) const {
    const Index3 dims = samples.dims();
    double num_bytes = 0;
    for (const VdbMember& member : block.members) {
      num_bytes += static_cast<double>(dims[0]) * static_cast<double>(dims[1]) *
                   static_cast<double>(dims[2]) *
                   static_cast<double>(member.grid.values->num_components) *
                   static_cast<double>(size_of(member.grid.values->type));
    }
    if (num_bytes <= static_cast<double>(available_memory()))
      return static_cast<std::int64_t>(num_bytes);
    std::uint64_t num_active = 0;
    for (const auto& grid : grids) num_active += grid->activeVoxelCount();
    const char* const way_out =
        block.members.size() > 1 ? ", and --array NAME reads one of them" : "";
    fail(fmt::format("{} voxels of {} are active, in a box of {}, whose samples take {:.3g} GiB of "
                     "memory: {:.3g} are free{}",
                     num_active,
                     block.members.size() == 1 ? "grid " + data::name_text(block.name)
                                               : fmt::format("{} grids", block.members.size()),
                     dims_text(dims), num_bytes / (1 << 30),
                     static_cast<double>(available_memory()) / (1 << 30), way_out),
         ErrorCode::kOutOfMemory);
  }

  void tell_of_kind(const VdbGrid& grid) {
    if (grid.is_level_set) {
      note(
          fmt::format("grid {} is a level set, a distance that is 0 on a surface: --mode "
                      "isosurface --iso 0 draws that",
                      data::name_text(grid.name)));
    }
    if (grid.is_staggered) {
      note(
          fmt::format("grid {} is staggered: its components are those on the faces of voxels, "
                      "half a voxel before where they are drawn",
                      data::name_text(grid.name)));
    }
  }

  const ReaderRequest& request_;
  const ReadOptions& options_;
  VdbFile file_;
  std::vector<VdbBlock> blocks_;
  Dataset dataset_;
};

}  // namespace

Dataset read_vdb_here(const ReaderRequest& request) {
  if (request.format != "OpenVDB" || request.paths.empty()) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: ovoid-read-vdb reads OpenVDB files alone", request.source));
  }
  // Threads would take addresses, which are limited, and find nothing to do.
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  openvdb::initialize();
  return VdbReader(request).read();
}

}  // namespace ovoid::io
