// SPDX-License-Identifier: Apache-2.0
// Athena++'s output .athdf [Athena++]: the blocks of its mesh, all of which are leaves, the faces
// of their cells along each axis, and datasets of several variables each, which attributes name.
#ifdef OVOID_IO_HDF5
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "io/foreign/hdf5_blocks.h"
#include "io/foreign/hdf5_dialects.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::array<const char*, 3> kFaces{"/x1f", "/x2f", "/x3f"};

[[noreturn]] void refuse_athena(const Hdf5File& file, const std::string& what) {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: is Athena++'s, but {}", file.source().name(), what));
}

std::vector<Hdf5Block> blocks_of(const Hdf5File& file) {
  std::vector<Hdf5Block> blocks;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Hdf5Dataset* const faces = file.find(kFaces[axis]);
    if (faces == nullptr || !faces->type || faces->dims.size() != 2 || faces->dims[0] < 1 ||
        faces->dims[1] < 2 || (axis > 0 && faces->dims[0] != std::ssize(blocks)))
      refuse_athena(file, fmt::format("'{}' does not hold the faces of each block", kFaces[axis]));
    const std::vector<double> all = file.values(*faces);
    const auto count = static_cast<std::size_t>(faces->dims[1]);
    blocks.resize(static_cast<std::size_t>(faces->dims[0]));
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const auto from = all.begin() + static_cast<std::ptrdiff_t>(b * count);
      blocks[b].row = static_cast<std::int64_t>(b);
      blocks[b].faces[axis].assign(from, from + static_cast<std::ptrdiff_t>(count));
    }
  }
  return blocks;
}

// DatasetNames, NumVariables of each, and VariableNames of all, in their order.
std::vector<Hdf5BlockArray> variables_of(const Hdf5File& file) {
  const std::vector<std::string> datasets = file.texts("/", "DatasetNames"),
                                 names = file.texts("/", "VariableNames");
  const std::vector<double> counts = file.numbers("/", "NumVariables");
  if (datasets.empty() || counts.size() != datasets.size())
    refuse_athena(file, "its attributes DatasetNames and NumVariables do not fit each other");
  std::vector<Hdf5BlockArray> variables;
  for (std::size_t d = 0; d < datasets.size(); ++d) {
    const Hdf5Dataset* const dataset = file.find("/" + datasets[d]);
    if (dataset == nullptr || !dataset->type || dataset->dims.size() != 5)
      refuse_athena(file,
                    fmt::format("'{}' is no dataset of five axes", datasets[d].substr(0, 60)));
    if (static_cast<double>(dataset->dims[0]) != counts[d] ||
        variables.size() + static_cast<std::size_t>(dataset->dims[0]) > names.size())
      refuse_athena(file, fmt::format("'{}' has {} variables, its attributes name another number",
                                      datasets[d].substr(0, 60), dataset->dims[0]));
    for (std::int64_t v = 0; v < dataset->dims[0]; ++v)
      variables.push_back({dataset, names[variables.size()], v});
  }
  return variables;
}

}  // namespace

std::optional<Dataset> read_athena(const Hdf5File& file, const ReadOptions& options) {
  if (file.find("/LogicalLocations") == nullptr || file.find("/Levels") == nullptr ||
      file.find(kFaces[0]) == nullptr)
    return std::nullopt;
  Dataset dataset;
  dataset.source = file.source().name();
  dataset.format = "Athena++";
  const auto coordinates = file.text("/", "Coordinates");
  if (coordinates && *coordinates != "cartesian" && *coordinates != "minkowski") {
    dataset.notes.push_back(
        fmt::format("{}: its coordinates are {}: they are drawn as if they were x, y, z",
                    dataset.source, *coordinates));
  }
  const std::vector<double> time = file.numbers("/", "Time");
  if (time.size() == 1 && std::isfinite(time[0])) dataset.times = time;
  const std::vector<Hdf5Block> blocks = blocks_of(file);
  const std::vector<Hdf5BlockArray> variables = variables_of(file);
  dataset.notes.push_back(fmt::format("{}: {} blocks of cells, finer where the mesh is refined",
                                      dataset.source, blocks.size()));
  return boxes_of_blocks(file, blocks, variables, options, std::move(dataset));
}

}  // namespace ovoid::io
#endif
