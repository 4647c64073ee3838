// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "io/foreign/hdf5_dialects.h"
#include "io/foreign/hdf5_storage.h"
#include "io/foreign/hdf5_volumes.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Why a dataset is no volume, and no list of points by its name.
std::string reason(const Hdf5Dataset& dataset) {
  const auto& dims = dataset.dims;
  if (!dataset.type) return "holds " + dataset.type_text;
  if (std::count(dims.begin(), dims.end(), 0) > 0) return "is empty";
  if (dims.empty() || dims.size() > Hdf5Extent::kMaxRank)
    return fmt::format("has {} axes", dims.size());
  if (dims.size() < 3) return dims.size() == 1 ? "has one axis" : "has two axes";
  return "is one row of samples";
}

}  // namespace

void refuse_hdf5(const Hdf5File& file, const ReadOptions& options) {
  const std::string& source = file.source().name();
  std::vector<const Hdf5Dataset*> all;
  for (const Hdf5Dataset& dataset : file.datasets()) all.push_back(&dataset);
  for (const Hdf5Dataset& dataset : file.others()) all.push_back(&dataset);
  // The largest first: these are meant.
  const auto size_of_dataset = [](const Hdf5Dataset* dataset) {
    double size = dataset->dims.empty() ? 0 : 1;
    for (const std::int64_t dim : dataset->dims) size *= static_cast<double>(dim);
    return size;
  };
  std::stable_sort(all.begin(), all.end(), [&](const Hdf5Dataset* a, const Hdf5Dataset* b) {
    return size_of_dataset(a) > size_of_dataset(b);
  });
  if (!options.array.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: array '{}': the file has no such array that is drawn: it has {}",
                            source, options.array, all.empty() ? "none" : hdf5_list(all)));
  }
  constexpr std::size_t kListed = 5;
  std::string list;
  for (std::size_t i = 0; i < std::min(kListed, all.size()); ++i)
    list += fmt::format("{}'{}' [{}] {}", i == 0 ? "" : ", ", hdf5_path_text(all[i]->path),
                        fmt::join(all[i]->dims, ", "), reason(*all[i]));
  if (all.size() > kListed) list += fmt::format(" and {} more", all.size() - kListed);
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: nothing in it is drawn: {}: expected numbers with three axes (z, y, "
                          "x), or positions [N, 3] called Coordinates, positions, xyz or the like, "
                          "or named with --positions",
                          source, all.empty() ? "it has no datasets" : list));
}

}  // namespace ovoid::io
#endif
