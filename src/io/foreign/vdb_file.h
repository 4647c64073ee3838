// SPDX-License-Identifier: Apache-2.0
// What is in an OpenVDB file, through OpenVDB: its grids by name, and where their voxels are.
#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/error.h"

namespace ovoid::io {

// Samples that are stored for each voxel.
struct VdbValues {
  ScalarType type = ScalarType::kFloat32;
  int num_components = 1;
};

// A box of voxels by their indices, of which both ends are in it; empty if last < first.
struct VoxelBox {
  Index3 first{0, 0, 0}, last{-1, -1, -1};

  bool is_empty() const noexcept { return last[0] < first[0]; }
  void add(const VoxelBox& other) noexcept;
  VoxelBox moved(const Index3& by) const noexcept;
  Index3 dims() const noexcept;
};

// What a file says of a grid before its voxels are read.
struct VdbGrid {
  std::string name;                 // "density", of several of a name "density[1]"; "values" of ""
  std::string key;                  // what OpenVDB finds it by
  std::string type;                 // "Tree_float_5_4_3"
  std::optional<VdbValues> values;  // none: no grid of numbers that are read
  bool is_of_points = false;
  bool is_affine = true;  // else the transform is a frustum's
  Affine3 world_from_index = Affine3::Identity();
  bool is_level_set = false;
  bool is_staggered = false;
  VoxelBox told;  // that of the active voxels, as the metadata say, which may be wrong or missing
};

class VdbFile {
 public:
  // Opens the file, whose header is checked first (read_vdb_header). `source` names it in messages.
  // Throws Error.
  VdbFile(std::string source, const std::string& path);

  const std::string& source() const noexcept { return source_; }
  // Of the file's order, those called "density" before all.
  const std::vector<VdbGrid>& grids() const noexcept { return grids_; }

  // With its voxels. Throws Error(kFileFormat) if OpenVDB does not read it.
  openvdb::GridBase::Ptr read(const VdbGrid& grid);

  // Runs `action`, whose exceptions of OpenVDB's become Error(kFileFormat), or kOutOfMemory.
  template <typename Action>
  auto guarded(const Action& action) const {
    try {
      return action();
    } catch (const Error&) {
      throw;
    } catch (const std::bad_alloc&) {
      fail_for_memory();
    } catch (const std::exception& error) {
      fail(error.what());
    }
  }

 private:
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail_for_memory() const;

  std::string source_;
  std::unique_ptr<openvdb::io::File> file_;
  std::vector<VdbGrid> grids_;
};

// Where a grid that was read has active voxels.
VoxelBox active_box(const openvdb::GridBase& grid);

}  // namespace ovoid::io
