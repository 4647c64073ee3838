// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <string>

#include "data/names_text.h"
#include "io/cell_lattice.h"
#include "io/core/atomic_file.h"
#include "io/core/plain_values.h"
#include "io/core/samples.h"
#include "io/core/signatures.h"
#include "io/formats.h"
#include "io/images/nifti.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

void check_array(const Dataset& dataset, const DataArray& array) {
  const std::string where = fmt::format("array '{}'", array.name);
  if (array.num_components < 1) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: has {} components: expected at least 1", where, array.num_components));
  }
  const Index3 dims = io::lattice_of(dataset.lattice, array).dims;
  const std::int64_t num_bytes =
      io::checked_num_bytes(where, dims, array.type, array.num_components);
  if (array.num_tuples != num_samples(dims) ||
      static_cast<std::int64_t>(array.bytes.view.size()) != num_bytes) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: has {} tuples in {} bytes: expected {} tuples in {} bytes for {}",
                            where, array.num_tuples, array.bytes.view.size(), num_samples(dims),
                            num_bytes, io::layout_text(dims, array.type, array.num_components)));
  }
}

const DataArray& only_array(const Dataset& dataset, const std::string& path) {
  if (dataset.arrays.size() == 1) return dataset.arrays[0];
  std::vector<std::string> names;
  for (const DataArray& array : dataset.arrays) names.push_back(array.name);
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: {} holds one array, the dataset has {} ({}): keep one, or write .vti", path,
                  io::ending_of(path), dataset.arrays.size(), data::names_text(names)));
}

// Throws unless every array has a tuple for each position, and the memory for them.
void check_points(const Dataset& dataset) {
  const auto check = [&](const DataArray& array, const std::string& where) {
    const std::int64_t size[] = {dataset.num_positions()};
    const std::int64_t num_bytes =
        io::checked_num_bytes(where, size, array.type, std::max(array.num_components, 1));
    if (array.num_components < 1 || array.num_tuples != size[0] ||
        static_cast<std::int64_t>(array.bytes.view.size()) != num_bytes) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: has {} tuples of {} in {} bytes: expected {} tuples in {} bytes",
                              where, array.num_tuples, array.num_components,
                              array.bytes.view.size(), size[0], num_bytes));
    }
  };
  if (dataset.num_positions() < 1)
    throw Error(ErrorCode::kInvalidArgument, "positions: there are none to write");
  check(dataset.positions, "positions");
  if (dataset.positions.num_components != 3 || !is_floating(dataset.positions.type))
    throw Error(ErrorCode::kInvalidArgument, "positions: must be three floats each");
  for (const DataArray& array : dataset.arrays) check(array, fmt::format("array '{}'", array.name));
}

// What VTK and others have no type for.
void refuse_body_centred(const Dataset& dataset, const std::string& path) {
  if (dataset.lattice.kind != LatticeKind::kBodyCentred) return;
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: {} holds Cartesian lattices, the dataset is body-centred: write .h5, "
                  "or resample it with convert --size",
                  path, io::ending_of(path)));
}

// "a mesh", "particles or kernels"
std::string held_by(const io::FormatWriter& writer) {
  std::string held;
  for (const DatasetKind kind : writer.kinds) {
    const bool is_one = kind == DatasetKind::kLattice || kind == DatasetKind::kMesh;
    held += fmt::format("{}{}{}", held.empty() ? "" : " or ", is_one ? "a " : "", name_of(kind));
  }
  return held;
}

// Throws unless the writer's format can hold what the dataset is.
void check_dataset(const Dataset& dataset, const io::FormatWriter& writer,
                   const std::string& path) {
  if (std::find(writer.kinds.begin(), writer.kinds.end(), dataset.kind) == writer.kinds.end()) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: {} holds {}, the dataset is {}", path, io::ending_of(path),
                            held_by(writer), name_of(dataset.kind)));
  }
  if (dataset.kind == DatasetKind::kMesh) return;
  if (dataset.kind != DatasetKind::kLattice) return check_points(dataset);
  if (dataset.arrays.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: the dataset has no array to write", path));
  for (const DataArray& array : dataset.arrays) check_array(dataset, array);
  if (!writer.takes_body_centred) refuse_body_centred(dataset, path);
}

// What goes into the file: one array alone, or all; cheap, because arrays share their bytes.
Dataset dataset_to_write(const Dataset& dataset, const io::FormatWriter& writer,
                         const std::string& path) {
  Dataset written = dataset;
  if (writer.is_one_array) {
    written.arrays = {only_array(dataset, path)};
    written.lattice = io::lattice_of(dataset.lattice, written.arrays[0]);
  }
  if (!writer.keeps_scale)
    for (DataArray& array : written.arrays) array = io::plain_values(array);
  return written;
}

}  // namespace

namespace io {

LatticeGeometry lattice_of(const LatticeGeometry& points, const DataArray& array) {
  LatticeGeometry lattice = points;
  if (!array.is_cell_data) return lattice;
  Vec3 first = Vec3::Zero();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (lattice.dims[axis] == 1) continue;
    lattice.dims[axis] -= 1;
    first[static_cast<Eigen::Index>(axis)] = 0.5;
  }
  lattice.world_from_index.translate(first);
  return lattice;
}

}  // namespace io

void check_dataset_path(const std::string& path) {
  const io::FormatWriter& writer = io::writer_for(path);
  io::check_writable(path);
  if (writer.check_samples_path != nullptr) writer.check_samples_path(path);
}

std::vector<std::string> files_written_for(const std::string& path) {
  for (const io::Format& format : io::formats())
    for (const io::FormatWriter& writer : format.writers)
      if (writer.samples_path != nullptr && io::is_one_of(writer.endings, io::ending_of(path)))
        return {path, writer.samples_path(path)};
  return {path};
}

std::string lost_place(const Dataset& dataset, const std::string& path) {
  const bool has_space = dataset.space != Space::kNone;
  const bool is_placed = !dataset.lattice.world_from_index.matrix().isIdentity(0);
  if (dataset.kind != DatasetKind::kLattice) return {};
  switch (io::writer_for(path).place) {
    case io::PlaceInFile::kNone:
      return has_space || is_placed ? "holds no spacing, directions and origin: they are lost" : "";
    case io::PlaceInFile::kNoSpace:
      if (!has_space) return {};
      return fmt::format("holds no patient space: that the axes are {} is lost",
                         name_of(dataset.space));
    case io::PlaceInFile::kInSpaceAlone:
      if (has_space || io::is_placed_by_spacing(dataset.lattice)) return {};
      return "holds a place in patient space only: x, y, z are now right, anterior, superior";
    case io::PlaceInFile::kWhole:
      return {};
  }
  return {};
}

void write_dataset(const Dataset& dataset, const std::string& path,
                   const WriteOptions& options) try {
  const io::FormatWriter& writer = io::writer_for(path);
  check_dataset(dataset, writer, path);
  io::check_stop(options.stop);
  writer.write(dataset_to_write(dataset, writer, path), path, options.stop);
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory, path + ": no memory to write it");
}

}  // namespace ovoid
