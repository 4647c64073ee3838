// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_blocks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "data/names_text.h"
#include "io/core/memory.h"
#include "io/core/point_arrays.h"
#include "io/core/samples.h"
#include "io/foreign/hdf5_storage.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

class BlockReader {
 public:
  BlockReader(const Hdf5File& file, const std::vector<Hdf5Block>& blocks,
              const ReadOptions& options, Dataset dataset)
      : file_(file), blocks_(blocks), options_(options), dataset_(std::move(dataset)) {}

  Dataset run(const std::vector<Hdf5BlockArray>& arrays) {
    check_blocks();
    std::vector<const Hdf5BlockArray*> chosen;
    std::vector<std::string> names;
    for (const Hdf5BlockArray& array : arrays) {
      names.push_back(array.name);
      if (options_.array.empty() || options_.array == array.name) chosen.push_back(&array);
    }
    if (chosen.empty()) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: array '{}': no such array: it has {}", dataset_.source,
                              options_.array, data::names_text(names)));
    }
    dataset_.kind = DatasetKind::kBoxes;
    constexpr std::int64_t kPlaceBytes = 6 * sizeof(double);
    require_memory(fmt::format("{}: {} cells", dataset_.source, num_cells_),
                   num_cells_ * kPlaceBytes);
    std::int64_t total = 0;
    for (const Hdf5BlockArray* array : chosen)
      total += num_cells_ * static_cast<std::int64_t>(size_of(array->dataset->type->type));
    ReadProgress progress(options_, total);
    for (const Hdf5BlockArray* array : chosen) add(*array, progress);
    add_places();
    shorten_notes(dataset_.notes);
    return std::move(dataset_);
  }

 private:
  // z, y, x.
  std::array<std::int64_t, 3> shape_of(const Hdf5Block& block) const {
    return {std::ssize(block.faces[2]) - 1, std::ssize(block.faces[1]) - 1,
            std::ssize(block.faces[0]) - 1};
  }

  void check_blocks() {
    if (blocks_.empty())
      throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no blocks", dataset_.source));
    shape_ = shape_of(blocks_[0]);
    for (const Hdf5Block& block : blocks_) {
      for (const std::vector<double>& faces : block.faces) {
        const bool do_rise = std::adjacent_find(faces.begin(), faces.end(), [](double a, double b) {
                               return !(a < b);
                             }) == faces.end();
        if (do_rise && faces.size() > 1 && std::isfinite(faces.front()) &&
            std::isfinite(faces.back()))
          continue;
        throw Error(ErrorCode::kFileFormat, fmt::format("{}: block {}: its cells have no size",
                                                        dataset_.source, block.row));
      }
    }
    std::vector<std::int64_t> factors(shape_.begin(), shape_.end());
    factors.push_back(std::ssize(blocks_));
    const auto count = checked_product(factors);
    if (!count || *count > std::numeric_limits<std::uint32_t>::max()) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: {} blocks of {} cells: at most 2^32 - 1 cells are read",
                              dataset_.source, blocks_.size(), dims_text(shape_)));
    }
    num_cells_ = *count;
  }

  void add(const Hdf5BlockArray& described, ReadProgress& progress) {
    const Hdf5Dataset& stored = *described.dataset;
    const std::string where = fmt::format("{}: '{}'", file_.source().name(), stored.path);
    const bool has_variables = described.variable >= 0;
    const std::size_t block_axis = has_variables ? 1 : 0;
    if (stored.dims.size() != block_axis + 4 ||
        !std::equal(shape_.begin(), shape_.end(), stored.dims.end() - 3) ||
        blocks_.back().row >= stored.dims[block_axis] ||
        (has_variables && described.variable >= stored.dims[0])) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: has shape [{}]: expected {}blocks of [{}]", where,
                              fmt::join(stored.dims, ", "), has_variables ? "variables, " : "",
                              fmt::join(shape_, ", ")));
    }
    const Hdf5Handle dataset(H5Dopen2(file_.id(), stored.path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.is_open()) throw Error(ErrorCode::kFileFormat, where + " is broken");
    checked_num_bytes(where, stored.dims, stored.type->type);
    const Hdf5Extent extent{where, *stored.type, stored.dims};
    check_hdf5_storage(dataset.get(), extent, file_.source());
    std::byte* to = nullptr;
    DataArray array =
        new_array({described.name, extent.type.type, 1, num_cells_, "", false, {}}, to);
    std::vector<std::int64_t> first(stored.dims.size(), 0), count = stored.dims;
    if (has_variables) {
      first[0] = described.variable;
      count[0] = 1;
    }
    const std::int64_t block_bytes = num_cells_ / std::ssize(blocks_) * extent.item_size();
    const std::int64_t most = std::max<std::int64_t>(ReadProgress::kChunk / block_bytes, 1);
    for (std::size_t b = 0; b < blocks_.size();) {
      // Blocks that lie behind each other are read at once.
      std::int64_t run = 1;
      while (b + static_cast<std::size_t>(run) < blocks_.size() && run < most &&
             blocks_[b + static_cast<std::size_t>(run)].row == blocks_[b].row + run)
        ++run;
      first[block_axis] = blocks_[b].row;
      count[block_axis] = run;
      read_hdf5_box(dataset.get(), extent, first, count,
                    {to, static_cast<std::size_t>(run * block_bytes)}, progress);
      to += run * block_bytes;
      b += static_cast<std::size_t>(run);
    }
    dataset_.arrays.push_back(std::move(array));
  }

  void add_places() {
    std::vector<double> centers, sizes;
    centers.reserve(static_cast<std::size_t>(3 * num_cells_));
    sizes.reserve(static_cast<std::size_t>(3 * num_cells_));
    for (const Hdf5Block& block : blocks_) {
      std::array<std::size_t, 3> at{};
      for (at[2] = 0; at[2] + 1 < block.faces[2].size(); ++at[2]) {
        for (at[1] = 0; at[1] + 1 < block.faces[1].size(); ++at[1]) {
          for (at[0] = 0; at[0] + 1 < block.faces[0].size(); ++at[0]) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
              const double lo = block.faces[axis][at[axis]], hi = block.faces[axis][at[axis] + 1];
              centers.push_back(lo + (hi - lo) / 2);
              sizes.push_back(hi - lo);
            }
          }
        }
      }
    }
    const auto vectors = [&](const char* name, std::vector<double> values) {
      DataArray array{name, ScalarType::kFloat64, 3, num_cells_, "", false, {}};
      array.bytes = bytes_owning(std::move(values));
      return array;
    };
    dataset_.positions = vectors("positions", std::move(centers));
    dataset_.box_sizes = vectors("box_sizes", std::move(sizes));
  }

  const Hdf5File& file_;
  const std::vector<Hdf5Block>& blocks_;
  const ReadOptions& options_;
  Dataset dataset_;
  std::array<std::int64_t, 3> shape_{};  // cells of a block: z, y, x
  std::int64_t num_cells_ = 0;
};

}  // namespace

Dataset boxes_of_blocks(const Hdf5File& file, const std::vector<Hdf5Block>& blocks,
                        const std::vector<Hdf5BlockArray>& arrays, const ReadOptions& options,
                        Dataset dataset) {
  return BlockReader(file, blocks, options, std::move(dataset)).run(arrays);
}

}  // namespace ovoid::io
#endif
