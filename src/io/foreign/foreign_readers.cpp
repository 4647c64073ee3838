// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/foreign_readers.h"

#include <fmt/format.h>

#include <memory>

#include "io/core/byte_source.h"
#include "io/core/signatures.h"
#include "io/dicom/dicom.h"
#include "io/foreign/file_checks.h"
#include "io/foreign/gdcm_codec.h"
#include "io/foreign/hdf5_cf.h"
#include "io/foreign/hdf5_grid.h"
#include "io/foreign/hdf5_lattice.h"
#include "io/foreign/hdf5_points.h"
#include "io/foreign/hdf5_xdmf.h"
#include "io/foreign/mesh_readers.h"
#include "io/foreign/vtk_sets.h"
#include "io/foreign/vtk_surface.h"
#include "ovoid/error.h"

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
  if (is_hdf5_lattice(source)) return read_hdf5_lattice(source, options);
  const bool is_of_points = !options.hdf5.positions.empty() || !options.hdf5.values.empty();
  if (is_of_points) return read_hdf5_points(source, options);
  const bool may_be_grid = !options.array.empty() || !has_hdf5_positions(source);
  // Axes x, y and z that are as long as each other are called as positions are.
  if (auto grid =
          read_hdf5_cf(source, options, may_be_grid ? Hdf5Axes::kScalesOrNames : Hdf5Axes::kScales))
    return std::move(*grid);
  if (may_be_grid)
    if (auto grid = read_hdf5_grid(source, options)) return std::move(*grid);
  return read_hdf5_points(source, options);
}
#endif

const std::vector<ForeignReader>& foreign_readers() {
  static const std::vector<ForeignReader> readers{
#ifdef OVOID_IO_VTK
      {"VTK XML", nullptr, read_vtk},
      {"legacy VTK", nullptr, read_vtk},
      {"VTKHDF", check_hdf5_size, read_vtk_hdf},
      {"Exodus", check_exodus_or_hdf5, read_exodus},
      {"EnSight", nullptr, read_ensight},
      {"Enzo", check_enzo, read_enzo},
      {"PLY surfaces", nullptr, read_ply_faces},
#endif
#ifdef OVOID_IO_HDF5
      {"HDF5", nullptr, read_hdf5},
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
