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
#include "io/formats.h"
#include "io/images/nifti.h"
#include "io/images/npy.h"
#include "io/images/nrrd.h"
#include "io/images/raw.h"
#include "io/points/npy_points.h"
#include "io/points/ply.h"
#include "io/points/point_text.h"
#include "io/vtk/legacy_vtk_write.h"
#include "io/vtk/vti_write.h"
#include "io/vtk/vtu_write.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/lattice_file.h"

namespace ovoid {
namespace {

enum class Target {
  kNrrd,
  kNhdr,
  kNpy,
  kRaw,
  kNifti,
  kVti,
  kLegacyVtk,
  kVtu,
  kPly,
  kNpz,
  kCsv,
  kHdf5
};

Target target_of(const std::string& path) {
  const std::string ending = io::ending_of(path);
  if (ending == ".nrrd") return Target::kNrrd;
  if (ending == ".nhdr") return Target::kNhdr;
  if (ending == ".npy") return Target::kNpy;
  if (ending == ".raw") return Target::kRaw;
  if (ending == ".nii" || ending == ".nii.gz") return Target::kNifti;
  if (ending == ".ply") return Target::kPly;
  if (ending == ".npz") return Target::kNpz;
  if (ending == ".csv") return Target::kCsv;
  if (ending == ".vtu") return Target::kVtu;
  if (ending == ".h5") {
#ifdef OVOID_IO_HDF5
    return Target::kHdf5;
#else
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: this build has no HDF5 and cannot write {}", path, ending));
#endif
  }
  if (ending == ".vti") return Target::kVti;
  if (ending == ".vtk") return Target::kLegacyVtk;
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: the ending '{}' names no format that is written: expected .nrrd, "
                          ".nhdr, .npy, .raw, .nii, .nii.gz, .vti, .vtk or .h5 for volumes, .vtu "
                          "for meshes, .csv, .npz or .ply for particles",
                          path, ending));
}

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

void write_mesh(const Dataset& dataset, const std::string& path, const WriteOptions& options) {
  if (dataset.kind != DatasetKind::kMesh) {
    throw Error(ErrorCode::kUnsupported, fmt::format("{}: .vtu holds a mesh, the dataset is {}",
                                                     path, name_of(dataset.kind)));
  }
  Dataset plain = dataset;  // cheap: arrays share their bytes
  for (DataArray& array : plain.arrays) array = io::plain_values(array);
  io::write_vtu(plain, path, options.stop);
}

void write_points(const Dataset& dataset, Target target, const std::string& path,
                  const WriteOptions& options) {
  const bool is_kernels = dataset.kind == DatasetKind::kKernels;
  if (dataset.kind != DatasetKind::kParticles && !(is_kernels && target == Target::kPly)) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format("{}: {} holds particles{}, the dataset is {}", path, io::ending_of(path),
                    target == Target::kPly ? " or kernels" : "", name_of(dataset.kind)));
  }
  check_points(dataset);
  Dataset plain = dataset;  // cheap: arrays share their bytes
  for (DataArray& array : plain.arrays) array = io::plain_values(array);
  if (target == Target::kPly) return io::write_ply(plain, path, options.stop);
  if (target == Target::kNpz) return io::write_npz(plain, path, options.stop);
  io::write_point_text(plain, path, options.stop);
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

void write_lattice_file(const Dataset& dataset, const std::string& path,
                        const WriteOptions& options) {
  LatticeFileWriter writer(path, lattice_file_header(dataset), options);
  writer.write_step(dataset);
  writer.finish();
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
  const Target target = target_of(path);
  io::check_writable(path);
  if (target == Target::kNhdr) io::check_nhdr_data_path(path);
}

std::vector<std::string> files_written_for(const std::string& path) {
  if (io::ending_of(path) != ".nhdr") return {path};
  return {path, io::nhdr_data_path(path)};
}

void write_dataset(const Dataset& dataset, const std::string& path,
                   const WriteOptions& options) try {
  const Target target = target_of(path);
  const bool is_for_points =
      target == Target::kPly || target == Target::kNpz || target == Target::kCsv;
  if (target == Target::kVtu) return write_mesh(dataset, path, options);
  if (is_for_points) return write_points(dataset, target, path, options);
  if (dataset.kind != DatasetKind::kLattice) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: holds a lattice, the dataset is {}", path, name_of(dataset.kind)));
  }
  if (dataset.arrays.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: the dataset has no array to write", path));
  for (const DataArray& array : dataset.arrays) check_array(dataset, array);
  if (target == Target::kHdf5) return write_lattice_file(dataset, path, options);
  refuse_body_centred(dataset, path);
  if (target == Target::kVti || target == Target::kLegacyVtk) {
    io::check_stop(options.stop);
    Dataset plain = dataset;  // cheap: arrays share their bytes
    for (DataArray& array : plain.arrays) array = io::plain_values(array);
    return target == Target::kVti ? io::write_vti(plain, path, options.stop)
                                  : io::write_legacy_vtk(plain, path, options.stop);
  }

  const bool keeps_scale = target == Target::kNifti;
  const DataArray array =
      keeps_scale ? only_array(dataset, path) : io::plain_values(only_array(dataset, path));
  const LatticeGeometry lattice = io::lattice_of(dataset.lattice, array);
  if (target == Target::kNpy) return io::write_npy(lattice.dims, array, path, options.stop);
  if (target == Target::kRaw) return io::write_raw(array, path, options.stop);
  Dataset described;  // cheap: arrays share their bytes
  described.lattice = lattice;
  described.space = dataset.space;
  if (target == Target::kNifti) return io::write_nifti(described, array, path, options.stop);
  if (target == Target::kNrrd) return io::write_nrrd(described, array, path, options.stop);
  io::write_nhdr(described, array, path, options.stop);
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::kOutOfMemory, path + ": no memory to write it");
}

}  // namespace ovoid
