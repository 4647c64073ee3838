// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vdb.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include "data/names_text.h"
#include "io/core/memory.h"
#include "io/core/samples.h"
#include "io/foreign/vdb_file.h"
#include "io/foreign/vdb_points.h"
#include "io/foreign/vdb_samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

// Voxels of the background around the active ones.
constexpr std::int64_t kMargin = 1;

// OpenVDB counts voxels in 32 bits, and the ends of nodes beyond the last must not overflow.
constexpr std::int64_t kFarthest = (std::int64_t{1} << 31) - (std::int64_t{1} << 13);

// How far voxels of two grids may lie apart, in voxels, and be the same.
constexpr double kSamePlace = 1e-3;

std::string quoted(const VdbGrid& grid) { return fmt::format("'{}'", grid.name); }

template <typename Grids, typename Filter>
std::vector<std::string> names_of(const Grids& grids, const Filter& is_meant) {
  std::vector<std::string> names;
  for (const VdbGrid& grid : grids)
    if (is_meant(grid)) names.push_back(grid.name);
  return names;
}

bool is_lattice(const VdbGrid& grid) { return grid.values && grid.is_affine; }

// By which indices of `other` are counted more than those of `lead` at the same place; nothing if
// the voxels of one are not those of the other.
std::optional<Index3> offset_between(const VdbGrid& lead, const VdbGrid& other) {
  if (!is_lattice(other)) return std::nullopt;
  const Mat3 axes = lead.world_from_index.linear();
  const double voxel = axes.colwise().norm().minCoeff();
  const Mat3 difference = axes - other.world_from_index.linear();
  if (!(difference.cwiseAbs().maxCoeff() <= 1e-6 * voxel)) return std::nullopt;
  const Vec3 apart = axes.inverse() * (lead.world_from_index.translation() -
                                       other.world_from_index.translation());
  Index3 offset{};
  for (int a = 0; a < 3; ++a) {
    const double whole = std::round(apart[a]);
    if (!(std::abs(apart[a] - whole) <= kSamePlace) ||
        std::abs(whole) > static_cast<double>(kFarthest))
      return std::nullopt;
    offset[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(whole);
  }
  return offset;
}

Index3 negated(const Index3& index) { return {-index[0], -index[1], -index[2]}; }

// A grid of the lattice that is read, with the offset of its indices from the lead's.
struct Member {
  const VdbGrid* described = nullptr;
  Index3 offset{0, 0, 0};
};

// The grid that decides which lattice is read: the one that is asked for, or the first of numbers.
const VdbGrid* lead_of(const std::vector<VdbGrid>& grids, const std::string& wanted) {
  const auto found = std::find_if(grids.begin(), grids.end(), [&](const VdbGrid& grid) {
    return wanted.empty() ? is_lattice(grid) : grid.name == wanted;
  });
  return found == grids.end() ? nullptr : &*found;
}

std::vector<Member> members_of(const std::vector<VdbGrid>& grids, const VdbGrid& lead,
                               const std::string& wanted) {
  std::vector<Member> members;
  for (const VdbGrid& grid : grids) {
    if (!wanted.empty() && grid.name != wanted) continue;
    if (const auto offset = offset_between(lead, grid)) members.push_back({&grid, *offset});
  }
  return members;
}

// What files of a series say of their grids. The process reads one step after the other, and each
// asks for all.
class KnownFiles {
 public:
  const std::vector<VdbGrid>& grids_in(const std::string& path) {
    std::error_code ignored;
    const auto stamp = std::pair(fs::file_size(path, ignored), fs::last_write_time(path, ignored));
    const auto found = known_.find(path);
    if (found != known_.end() && found->second.stamp == stamp) return found->second.grids;
    VdbFile file(path, path);
    std::vector<VdbGrid> grids = file.grids();
    for (VdbGrid& grid : grids)
      if (is_lattice(grid) && grid.told.is_empty()) grid.told = active_box(*file.read(grid));
    return (known_[path] = {stamp, std::move(grids)}).grids;
  }

 private:
  struct Known {
    std::pair<std::uintmax_t, fs::file_time_type> stamp;
    std::vector<VdbGrid> grids;
  };
  std::map<std::string, Known> known_;
};

// The lead of a series, that of its first file that has one, and the box of all its steps.
struct SharedLattice {
  std::optional<VdbGrid> lead;
  VoxelBox box;
};

SharedLattice lattice_of_steps(const std::vector<std::string>& paths, const std::string& wanted) {
  static KnownFiles known;
  SharedLattice shared;
  for (std::size_t i = 1; i < paths.size(); ++i) {
    const std::vector<VdbGrid>& grids = known.grids_in(paths[i]);
    if (!shared.lead) {
      const VdbGrid* const lead = lead_of(grids, wanted);
      if (lead != nullptr && is_lattice(*lead)) shared.lead = *lead;
    }
    if (!shared.lead) continue;
    for (const Member& member : members_of(grids, *shared.lead, wanted))
      shared.box.add(member.described->told.moved(negated(member.offset)));
  }
  return shared;
}

class VdbReader {
 public:
  VdbReader(const std::string& source, const std::vector<std::string>& paths,
            const ReadOptions& options)
      : paths_(paths), options_(options), file_(source, paths.front()) {}

  Dataset read() {
    dataset_.source = file_.source();
    dataset_.format = "OpenVDB";
    const VdbGrid* const lead = find_lead();
    if (lead->is_of_points) {
      read_vdb_points(file_, *lead, options_, dataset_);
      note_others({{lead, {}}});
      return std::move(dataset_);
    }
    read_lattice(*lead);
    return std::move(dataset_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kUnsupported) const {
    throw Error(code, fmt::format("{}: {}", file_.source(), what));
  }

  const VdbGrid* find_lead() const {
    const std::vector<VdbGrid>& grids = file_.grids();
    if (grids.empty()) fail("has no grids", ErrorCode::kFileFormat);
    if (const VdbGrid* const lead = lead_of(grids, options_.array)) {
      if (!is_lattice(*lead) && !lead->is_of_points) refuse(*lead);
      return lead;
    }
    if (!options_.array.empty()) {
      const auto names = names_of(grids, [](const VdbGrid&) { return true; });
      fail(fmt::format("array '{}': not there: expected one of {}", options_.array,
                       data::names_text(names)),
           ErrorCode::kInvalidArgument);
    }
    const auto points = std::find_if(grids.begin(), grids.end(),
                                     [](const VdbGrid& grid) { return grid.is_of_points; });
    if (points == grids.end()) refuse(grids.front());
    return &*points;
  }

  [[noreturn]] void refuse(const VdbGrid& grid) const {
    if (grid.values) {
      fail(fmt::format("grid {} lies in a camera's frustum, whose voxels are no lattice: expected a "
                       "grid of an affine transform, to which OpenVDB can resample it",
                       quoted(grid)));
    }
    fail(fmt::format("grid {} is of the type {}, which is not read: expected numbers, vectors of "
                     "three or points",
                     quoted(grid), grid.type));
  }

  void read_lattice(const VdbGrid& lead_here) {
    SharedLattice shared = lattice_of_steps(paths_, options_.array);
    const VdbGrid lead = shared.lead.value_or(lead_here);
    std::vector<Member> members = members_of(file_.grids(), lead, options_.array);
    if (members.empty()) {  // of a step with another lattice: Series says so
      shared.box = {};
      return read_members(lead_here, {{&lead_here, {}}}, {});
    }
    read_members(lead, members, shared.box);
  }

  // `box`: that of all steps, so far as it is known.
  void read_members(const VdbGrid& lead, const std::vector<Member>& members, VoxelBox box) {
    check_geometry(fmt::format("{}: the transform of grid {}", file_.source(), quoted(lead)),
                   lead.world_from_index);
    std::vector<openvdb::GridBase::Ptr> grids;
    for (const Member& member : members) {
      grids.push_back(file_.read(*member.described));
      box.add(active_box(*grids.back()).moved(negated(member.offset)));
      stop_if_asked();
    }
    if (box.is_empty()) {
      const auto names = names_of(file_.grids(), is_lattice);
      fail(fmt::format("has no active voxels, in {}: nothing is there to draw",
                       data::names_text(names)),
           ErrorCode::kFileFormat);
    }
    place(lead, box);
    const std::int64_t num_bytes = checked_size(members, box);
    ReadProgress progress(options_, num_bytes);
    for (std::size_t i = 0; i < members.size(); ++i) {
      const Member& member = members[i];
      dataset_.arrays.push_back(dense_samples(*grids[i], *member.described,
                                              box_.moved(member.offset), progress));
      if (dataset_.arrays.back().name.empty()) dataset_.arrays.back().name = "values";
      grids[i].reset();
      note_kind(*member.described);
    }
    note_others(members);
  }

  void stop_if_asked() const {
    ReadProgress nothing(options_, 0);
    nothing.advance(0);
  }

  // The box with its margin, and where it is.
  void place(const VdbGrid& lead, const VoxelBox& active) {
    box_ = active;
    for (std::size_t a = 0; a < 3; ++a) {
      box_.first[a] -= kMargin;
      box_.last[a] += kMargin;
    }
    dataset_.lattice.dims = box_.dims();
    dataset_.lattice.world_from_index = lead.world_from_index;
    dataset_.lattice.world_from_index.translate(Vec3(static_cast<double>(box_.first[0]),
                                                     static_cast<double>(box_.first[1]),
                                                     static_cast<double>(box_.first[2])));
  }

  // Of all arrays. Throws unless voxels can be counted and memory holds their samples.
  std::int64_t checked_size(const std::vector<Member>& members, const VoxelBox& active) const {
    const std::string where = fmt::format("{}: the box of its active voxels, {}", file_.source(),
                                          dims_text(active.dims()));
    for (std::size_t a = 0; a < 3; ++a) {
      if (box_.first[a] < -kFarthest || box_.last[a] > kFarthest)
        fail(fmt::format("has active voxels at index {} and {}: expected at most {} from 0",
                         active.first[a], active.last[a], kFarthest),
             ErrorCode::kFileFormat);
    }
    std::int64_t num_bytes = 0;
    for (const Member& member : members) {
      const VdbValues values = *member.described->values;
      num_bytes += checked_num_bytes(where, box_.dims(), values.type, values.num_components);
      num_bytes = std::min(num_bytes, kMaxNumBytes);
    }
    require_memory(members.size() == 1
                       ? where
                       : fmt::format("{}, with {} grids (--array NAME reads one)", where,
                                     members.size()),
                   num_bytes);
    return num_bytes;
  }

  void note(const std::string& what) {
    dataset_.notes.push_back(fmt::format("{}: {}", file_.source(), what));
  }

  void note_kind(const VdbGrid& grid) {
    if (grid.is_level_set) {
      note(fmt::format("grid {} is a level set, a distance that is 0 on a surface: --mode "
                       "isosurface --iso 0 draws that",
                       quoted(grid)));
    }
    if (grid.is_staggered) {
      note(fmt::format("grid {} is staggered: its components lie on the faces of voxels, half a "
                       "voxel from where they are drawn",
                       quoted(grid)));
    }
  }

  // What is not read, and how it would be.
  void note_others(const std::vector<Member>& read) {
    if (!options_.array.empty()) return;
    const auto is_read = [&](const VdbGrid& grid) {
      return std::any_of(read.begin(), read.end(),
                         [&](const Member& member) { return member.described == &grid; });
    };
    const auto tell = [&](const auto& is_meant, const std::string& what) {
      const auto names = names_of(
          file_.grids(), [&](const VdbGrid& grid) { return !is_read(grid) && is_meant(grid); });
      if (!names.empty()) note(fmt::format("{}: {}", what, data::names_text(names)));
    };
    tell(is_lattice, "grids with voxels at other places are left out, --array NAME reads one");
    tell([](const VdbGrid& grid) { return grid.is_of_points; },
         "grids of points are left out, --array NAME reads one");
    tell([](const VdbGrid& grid) { return grid.values && !grid.is_affine; },
         "grids in a camera's frustum are not read");
    tell([](const VdbGrid& grid) { return !grid.values && !grid.is_of_points; },
         "grids that hold no numbers are not read");
  }

  const std::vector<std::string>& paths_;
  const ReadOptions& options_;
  VdbFile file_;
  VoxelBox box_;
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
  return VdbReader(request.source, request.paths, request.options).read();
}

}  // namespace ovoid::io
