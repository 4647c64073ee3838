// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "io/core/byte_source.h"
#include "io/core/byte_stream.h"
#include "io/core/decode.h"
#include "io/dicom/dicom.h"
#include "io/dicom/dicom_elements.h"
#include "io/formats.h"
#include "io/images/metaimage.h"
#include "io/images/nifti.h"
#include "io/images/npy.h"
#include "io/images/nrrd.h"
#include "io/images/raw.h"
#include "io/images/slc.h"
#include "io/input_files.h"
#include "io/meshes/mesh_files.h"
#include "io/meshes/plot3d.h"
#include "io/points/lammps_dump.h"
#include "io/points/npy_points.h"
#include "io/points/ply.h"
#include "io/points/point_text.h"
#include "io/read_source.h"
#include "io/reader/reader_session.h"
#include "io/step_files.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

constexpr const char* kReadable =
    "NRRD, NPY, NIfTI, MetaImage, SLC, VTK's files, Exodus, VTKHDF, PLOT3D, Enzo, EnSight, DICOM, "
    "CSV, NPZ, PLY, HDF5, a LAMMPS dump, or raw samples with dimensions and type";

// What a raw file cannot say, said about a file that says it itself: one of both is a mistake.
void refuse_raw_options(const std::string& path, const char* format, const RawOptions& raw,
                        bool knows_spacing) {
  const char* const given = raw.dims                       ? "dimensions"
                            : raw.type                     ? "a type"
                            : raw.big_endian               ? "a byte order"
                            : raw.spacing && knows_spacing ? "a spacing"
                                                           : nullptr;
  if (given != nullptr) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: is {} and states its own layout: {} can be given for raw files only", path,
                    format, given));
  }
}

// Half of a PLOT3D dataset.
void refuse_lone_plot3d(const io::ByteSource& source) {
  if (io::find_plot3d(source, io::Plot3dContent::kGrid)) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: is a PLOT3D grid, which has no arrays: give its solution (q file) "
                            "behind it",
                            source.name()));
  }
  if (io::find_plot3d(source, io::Plot3dContent::kSolution)) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: is a PLOT3D solution, which has no points: give its grid before "
                            "it",
                            source.name()));
  }
}

Dataset read_unknown(const io::ByteSource& source, const std::string& start,
                     const ReadOptions& options) {
  const RawOptions from_name = io::parse_raw_name(source.name());
  const std::string ending = io::ending_of(source.name());
  const bool is_raw = options.raw.dims || options.raw.type || (from_name.dims && from_name.type);
  if (is_raw || ending == ".raw" || ending == ".raw.gz") return io::read_raw(source, options);
  if (ending == ".foam") {
    // VTK's reader stands on libtiff, and that on JBIG-KIT, which is GPL.
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: is an OpenFOAM case, which is not read: expected what foamToVTK "
                            "makes of it",
                            source.name()));
  }
  if (source.size() == 0)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: is empty", source.name()));
  if (io::is_point_text_name(source.name())) {
    refuse_raw_options(source.name(), "text", options.raw, true);
    return io::read_point_text(source, options);
  }
  for (const char* known :
       {".nrrd", ".nhdr",   ".npy",  ".nii",  ".nii.gz", ".mhd",  ".mha",       ".slc",
        ".vti",  ".vtr",    ".vts",  ".vtu",  ".vtp",    ".vtm",  ".vth",       ".vthb",
        ".pvtu", ".pvtp",   ".pvts", ".pvtr", ".pvd",    ".vtk",  ".ex2",       ".exo",
        ".e",    ".vtkhdf", ".ply",  ".npz",  ".h5",     ".hdf5", ".lammpstrj", ".dump"}) {
    if (ending == known) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: the name ends in {} but the content does not begin like it",
                              source.name(), known));
    }
  }
  if (ending == ".img" || ending == ".img.gz") {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: may be the samples of a NIfTI pair: expected its header, the .hdr "
                            "file beside it",
                            source.name()));
  }
  refuse_lone_plot3d(source);
  const std::string kind = io::unsupported_kind_of(start);
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: {}: expected {}", source.name(),
                  kind.empty() ? "the format is not known" : "is " + kind + ", which is not read",
                  kReadable));
}

// Only NIfTI and text are read through compression; other headers speak of places in the file.
io::FileKind packed_kind_of(const io::ByteSource& source, bool is_gzip) {
  const io::FileKind kind = io::kind_of(io::stream_start(source, 512));
  const bool is_read =
      kind == io::FileKind::kLammpsDump || (is_gzip && kind == io::FileKind::kNifti);
  return is_read ? kind : io::FileKind::kUnknown;
}

io::ForeignFormat format_of(io::MeshFile kind) {
  switch (kind) {
    case io::MeshFile::kExodus:
      return io::ForeignFormat::kExodus;
    case io::MeshFile::kEnzo:
      return io::ForeignFormat::kEnzo;
    case io::MeshFile::kEnSight:
      return io::ForeignFormat::kEnSight;
    case io::MeshFile::kVtkHdf:
    case io::MeshFile::kNone:
      break;
  }
  return io::ForeignFormat::kVtkHdf;
}

// By the process that has the library for it.
Dataset read_elsewhere(io::ForeignFormat format, const io::ByteSource& source,
                       const ReadOptions& options) {
  return io::read_foreign(format, source.name(), {source.name()}, options);
}

Dataset read_any(const io::ByteSource& source, const ReadOptions& options, const io::Opener& open) {
  const std::string start = source.text(0, 512);
  if (const io::MeshFile mesh = io::mesh_file_of(source, start); mesh != io::MeshFile::kNone) {
    refuse_raw_options(source.name(), io::name_of(mesh), options.raw, true);
    return read_elsewhere(format_of(mesh), source, options);
  }
  const bool is_gzip = io::is_gzip(start);
  const bool is_packed = is_gzip || io::is_bzip2(start);
  const io::FileKind kind = is_packed ? packed_kind_of(source, is_gzip) : io::kind_of(start);
  switch (kind) {
    case io::FileKind::kNrrd:
      refuse_raw_options(source.name(), "NRRD", options.raw, true);
      return io::read_nrrd(source, options, open);
    case io::FileKind::kNpy:
      refuse_raw_options(source.name(), "NPY", options.raw, false);
      return io::read_npy(source, options);
    case io::FileKind::kDicom:
      refuse_raw_options(source.name(), "DICOM", options.raw, true);
      return io::read_dicom(source, options);
    case io::FileKind::kNifti:
      refuse_raw_options(source.name(), "NIfTI", options.raw, true);
      return io::read_nifti(source, is_gzip ? io::Encoding::kGzip : io::Encoding::kRaw, options,
                            open);
    case io::FileKind::kMetaImage:
      refuse_raw_options(source.name(), "MetaImage", options.raw, true);
      return io::read_metaimage(source, options, open);
    case io::FileKind::kSlc:
      refuse_raw_options(source.name(), "SLC", options.raw, true);
      return io::read_slc(source, options);
    case io::FileKind::kVtkXml:
    case io::FileKind::kVtkLegacy:
      refuse_raw_options(source.name(), "VTK", options.raw, true);
      return read_elsewhere(io::ForeignFormat::kVtk, source, options);
    case io::FileKind::kPly:
      refuse_raw_options(source.name(), "PLY", options.raw, true);
      return io::read_ply(source, options);
    case io::FileKind::kZip:
      refuse_raw_options(source.name(), "NPZ", options.raw, true);
      return io::read_npz(source, options);
    case io::FileKind::kHdf5:
      refuse_raw_options(source.name(), "HDF5", options.raw, true);
      return read_elsewhere(io::ForeignFormat::kHdf5, source, options);
    case io::FileKind::kLammpsDump:
      refuse_raw_options(source.name(), "a LAMMPS dump", options.raw, true);
      return io::read_lammps_dump(source, options);
    case io::FileKind::kUnknown:
      break;
  }
  return read_unknown(source, start, options);
}

// Readers of files that hold one volume, or one step, need not look at what was asked for.
void check_choice(const Dataset& dataset, const ReadOptions& options) {
  if (!options.block.empty() && dataset.blocks.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: block '{}': the input is one volume and has no blocks",
                            dataset.source, options.block));
  }
  if (options.step.value_or(0) >= dataset.num_steps || options.step.value_or(0) < 0) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: step {}: expected 0 to {}", dataset.source, *options.step,
                            dataset.num_steps - 1));
  }
}

// What a file wrote into a message must not steer the terminal that shows it, nor break the line.
std::string printable(std::string text) {
  for (char& c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) c = '?';
  }
  return text;
}

// Is the first of several inputs half of a PLOT3D dataset? The flags of raw files say that it is
// not.
bool is_plot3d(const std::string& path, const RawOptions& raw, io::Plot3dContent content) {
  const RawOptions from_name = io::parse_raw_name(path);
  if (raw.dims || raw.type || from_name.dims || from_name.type) return false;
  const auto source = io::open_file(path);
  return io::kind_of(source->text(0, 512)) == io::FileKind::kUnknown &&
         io::find_plot3d(*source, content).has_value();
}

// What every reader's result goes through, and its error.
template <typename Read>
Dataset finished(const Read& read, const ReadOptions& options) {
  try {
    Dataset dataset = read();
    check_choice(dataset, options);
    for (std::string& note : dataset.notes) note = printable(std::move(note));
    for (DataArray& array : dataset.arrays) {
      array.name = printable(std::move(array.name));
      array.unit = printable(std::move(array.unit));
    }
    for (DatasetBlock& block : dataset.blocks) {
      block.name = printable(std::move(block.name));
      block.description = printable(std::move(block.description));
    }
    return dataset;
  } catch (const Error& error) {
    throw Error(error.code(), printable(error.what()));
  }
}

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

// A missing file is told as such, whatever it was meant to be.
bool is_dicom(const std::string& path) {
  return io::looks_like_dicom(io::open_file(path)->text(0, 512));
}

// A folder, or several files: the slices of a DICOM series.
Dataset read_dicom_parts(const std::vector<std::string>& paths, const ReadOptions& options) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    if (is_folder(path)) {
      const std::vector<std::string> inner = io::dicom_files_in(path);
      files.insert(files.end(), inner.begin(), inner.end());
      continue;
    }
    if (!is_dicom(path)) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: is no DICOM file: expected more slices of the series that {} "
                              "belongs to",
                              path, paths[0]));
    }
    files.push_back(path);
  }
  const std::string source =
      paths.size() == 1 ? paths[0] : fmt::format("{} and {} more", paths[0], paths.size() - 1);
  refuse_raw_options(source, "DICOM", options.raw, true);
  return io::read_dicom(source, files, options);
}

}  // namespace

namespace io {

Dataset read_source(const ByteSource& source, const ReadOptions& options, const Opener& open) {
  return finished([&] { return read_any(source, options, open); }, options);
}

}  // namespace io

Dataset read_dataset(const std::vector<std::string>& paths, const ReadOptions& options) {
  if (paths.empty()) throw Error(ErrorCode::kInvalidArgument, "input: no file is named");
  if (!options.session) {
    ReadOptions own = options;
    own.session = std::make_shared<ReaderSession>(paths);
    return read_dataset(paths, own);
  }
  if (is_folder(paths[0]) || (paths.size() > 1 && is_dicom(paths[0])))
    return finished([&] { return read_dicom_parts(paths, options); }, options);
  if (paths.size() == 2 && is_plot3d(paths[0], options.raw, io::Plot3dContent::kSolution) &&
      is_plot3d(paths[1], options.raw, io::Plot3dContent::kGrid)) {
    return finished([&] { return io::read_plot3d(paths[1], {paths[0]}, options); }, options);
  }
  if (paths.size() > 1 && is_plot3d(paths[0], options.raw, io::Plot3dContent::kGrid)) {
    const std::vector<std::string> solutions(paths.begin() + 1, paths.end());
    return finished([&] { return io::read_plot3d(paths[0], solutions, options); }, options);
  }
  if (paths.size() > 1) return io::read_step_files(paths, options);
  return io::read_source(*io::open_file(paths[0]), options,
                         io::opener_of_named_files(paths[0], options));
}

}  // namespace ovoid
