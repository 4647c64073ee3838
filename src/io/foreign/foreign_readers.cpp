// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/foreign_readers.h"

#include <fmt/format.h>

#include <memory>

#include "io/core/byte_source.h"
#include "io/core/signatures.h"
#include "io/dicom/dicom.h"
#include "io/foreign/file_checks.h"
#include "io/foreign/gdcm_codec.h"
#include "io/foreign/hdf5_lattice.h"
#include "io/foreign/hdf5_points.h"
#include "io/foreign/hdf5_snapshot.h"
#include "io/foreign/hdf5_xdmf.h"
#include "io/foreign/mesh_readers.h"
#include "io/foreign/vtk_sets.h"
#include "io/foreign/vtk_surface.h"
#include "io/foreign/vtkhdf.h"
#include "io/step_files.h"
#include "ovoid/error.h"
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_cf.h"
#include "io/foreign/hdf5_dialects.h"
#include "io/foreign/hdf5_filters.h"
#include "io/foreign/hdf5_grid.h"
#endif

namespace ovoid::io {
namespace {

// How a format is read here: what is checked first, and what of it VTK or HDF5 then read.
struct ForeignReader {
  std::string_view format;  // as formats() call it
  void (*check)(const ByteSource&);
  Dataset (*read)(const ByteSource&, const ReadOptions&);
};

#ifdef OVOID_IO_VTK
void check_exodus_or_hdf5(const ByteSource& source) {
  is_hdf5(source.text(0, 8)) ? check_hdf5_size(source) : check_exodus(source);
}
#endif

#ifdef OVOID_IO_HDF5
Dataset read_hdf5(const ByteSource& source, const ReadOptions& options) {
  const Hdf5Silence silence;
  if (is_hdf5_lattice(source)) return read_hdf5_lattice(source, options);
  if (!options.hdf5.positions.empty() || !options.hdf5.values.empty())
    return read_hdf5_points(source, options);
  const Hdf5File file(source.name(), Hdf5Extent::kMaxRank);
  for (const auto read_dialect :
       {read_flash, read_athena, read_imaris, read_big_data_viewer, read_openpmd}) {
    if (auto dataset = read_dialect(file, options)) return std::move(*dataset);
  }
  const bool has_points = has_hdf5_positions(source);
  const bool may_be_grid = !options.array.empty() || !has_points;
  // Axes x, y and z that are as long as each other are called as positions are.
  if (auto grid =
          read_hdf5_cf(file, options, may_be_grid ? Hdf5Axes::kScalesOrNames : Hdf5Axes::kScales))
    return std::move(*grid);
  if (may_be_grid)
    if (auto grid = read_hdf5_grid(file, options)) return std::move(*grid);
  if (has_points) return read_hdf5_points(source, options);
  refuse_hdf5(file, options);
}

// One file, or several of which each, or some together, are a step.
Dataset read_hdf5_files(const std::vector<std::string>& paths, const ReadOptions& options) {
  const std::vector<Snapshot> snapshots = sort_snapshots(paths);
  const auto read = [&](std::int64_t step, const ReadOptions& own) {
    const Snapshot& snapshot = snapshots[static_cast<std::size_t>(step)];
    return snapshot.header ? read_snapshot(snapshot, own)
                           : read_hdf5(*open_file(snapshot.source), own);
  };
  if (paths.size() == 1) return read(0, options);
  return read_one_step(fmt::format("{} and {} more", paths[0], paths.size() - 1),
                       static_cast<std::int64_t>(snapshots.size()), options, read);
}
#endif

const std::vector<ForeignReader>& foreign_readers() {
  static const std::vector<ForeignReader> readers{
#ifdef OVOID_IO_VTK
      {"VTK XML", nullptr, read_vtk},
      {"legacy VTK", nullptr, read_vtk},
      {"Exodus", check_exodus_or_hdf5, read_exodus},
      {"EnSight", nullptr, read_ensight},
      {"Enzo", check_enzo, read_enzo},
      {"PLY surfaces", nullptr, read_ply_faces},
#endif
#ifdef OVOID_IO_HDF5
      {"VTKHDF", check_hdf5_size, read_vtk_hdf},
      {"XDMF", nullptr, read_xdmf_with_hdf5},
#endif
  };
  return readers;
}

}  // namespace

Dataset read_here(const ReaderRequest& request) {
  if (request.paths.empty())
    throw Error(ErrorCode::kInvalidArgument, request.source + ": no file is named");
  if (request.format == "DICOM") {
    use_gdcm();
    return read_dicom(request.source, request.paths, request.options);
  }
#ifdef OVOID_IO_HDF5
  if (request.format == "HDF5") return read_hdf5_files(request.paths, request.options);
#endif
  for (const ForeignReader& reader : foreign_readers()) {
    if (reader.format != request.format) continue;
    const std::unique_ptr<ByteSource> source = open_file(request.paths.front());
    if (reader.check != nullptr) reader.check(*source);
    return reader.read(*source, request.options);
  }
  throw Error(ErrorCode::kUnsupported, fmt::format("{}: this build of ovoid-read has no reader of "
                                                   "the format {}",
                                                   request.source, request.format));
}

}  // namespace ovoid::io
