// SPDX-License-Identifier: Apache-2.0
#include "io/formats.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>

#include "io/companions.h"
#include "io/core/byte_stream.h"
#include "io/core/signatures.h"
#include "io/dicom/dicom.h"
#include "io/dicom/dicom_elements.h"
#include "io/images/metaimage.h"
#include "io/images/metaimage_header.h"
#include "io/images/nifti.h"
#include "io/images/nifti_header.h"
#include "io/images/npy.h"
#include "io/images/nrrd.h"
#include "io/images/nrrd_header.h"
#include "io/images/raw.h"
#include "io/images/slc.h"
#include "io/images/slice_pictures.h"
#include "io/images/tiff.h"
#include "io/images/tiff_file.h"
#include "io/meshes/gltf.h"
#include "io/meshes/gltf_file.h"
#include "io/meshes/mesh_files.h"
#include "io/meshes/plot3d.h"
#include "io/meshes/surfaces.h"
#include "io/netcdf/netcdf_grid.h"
#include "io/points/lammps_dump.h"
#include "io/points/npy_points.h"
#include "io/points/ply.h"
#include "io/points/ply_header.h"
#include "io/points/point_text.h"
#include "io/points/snapshot_names.h"
#include "io/reader/reader_session.h"
#include "io/step_times.h"
#include "io/unread_formats.h"
#include "io/vtk/file_series.h"
#include "io/vtk/legacy_vtk_write.h"
#include "io/vtk/vti_write.h"
#include "io/vtk/vtk_set_files.h"
#include "io/vtk/vtu_write.h"
#include "io/xdmf/xdmf.h"
#include "io/zarr/zarr.h"
#include "ovoid/error.h"
#include "ovoid/lattice_file.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kStart = 512;  // bytes that tell a format

// Rows that are told by more than what stands in them.
constexpr const char* kRaw = "raw";
constexpr const char* kText = "CSV and other text";

// Of the kinds of HDF5 files, those that may take a spacing begin so; this one takes an order of
// axes, too (foreign/hdf5_grid.cpp).
constexpr std::string_view kHdf5Grid = "HDF5 grid";

// Classic files, and in HDF5 those with dimension scales (foreign/hdf5_cf.cpp).
constexpr const char* kNetcdf = "netCDF";

using ArrayWriter = void (*)(const Dataset&, const DataArray&, const std::string&,
                             const std::stop_token&);

// A writer of a dataset's one array.
template <ArrayWriter kWrite>
void write_one(const Dataset& dataset, const std::string& path, const std::stop_token& stop) {
  kWrite(dataset, dataset.arrays[0], path, stop);
}

// A reader that opens no other files.
template <Dataset (*kRead)(const ByteSource&, const ReadOptions&)>
Dataset read_one(const ByteSource& source, const ReadOptions& options, const Opener&) {
  return kRead(source, options);
}

// --- the rows -----------------------------------------------------------------------------------

Dataset read_plain_or_packed_nifti(const ByteSource& source, const ReadOptions& options,
                                   const Opener& open) {
  const Encoding encoding = is_gzip(source.text(0, 2)) ? Encoding::kGzip : Encoding::kRaw;
  return read_nifti(source, encoding, options, open);
}

bool begins_like_zip(std::string_view start) {
  return start.starts_with("PK\x03\x04") || start.starts_with("PK\x05\x06");
}

bool begins_like_vdb(std::string_view start) {
  using namespace std::string_view_literals;
  return start.starts_with(" BDV\0\0\0\0"sv);
}

bool begins_like_dump(std::string_view start) {
  return start.starts_with("ITEM: TIME") || start.starts_with("ITEM: UNITS");
}

void write_npy_of(const Dataset& dataset, const DataArray& array, const std::string& path,
                  const std::stop_token& stop) {
  write_npy(dataset.lattice.dims, array, path, stop);
}

void write_raw_of(const Dataset&, const DataArray& array, const std::string& path,
                  const std::stop_token& stop) {
  write_raw(array, path, stop);
}

void write_lattice_file(const Dataset& dataset, const std::string& path,
                        const std::stop_token& stop) {
  LatticeFileWriter writer(path, lattice_file_header(dataset), {stop});
  writer.write_step(dataset);
  writer.finish();
}

using enum DatasetKind;

std::vector<Format> images() {
  return {{.name = "NRRD",
           .endings = {".nrrd", ".nhdr"},
           .begins = looks_like_nrrd,
           .read = read_nrrd,
           .companions = nrrd_companions,
           .kinds = {kLattice},
           .outline = outline_of_nrrd,
           .writers = {{.endings = {".nrrd"},
                        .kinds = {kLattice},
                        .write = write_one<write_nrrd>,
                        .is_one_array = true},
                       {.endings = {".nhdr"},
                        .kinds = {kLattice},
                        .write = write_one<write_nhdr>,
                        .is_one_array = true,
                        .samples_path = nhdr_data_path,
                        .check_samples_path = check_nhdr_data_path}}},
          {.name = "NIfTI",
           .endings = {".nii", ".nii.gz", ".hdr", ".img", ".img.gz"},
           .begins = looks_like_nifti,
           .packing = Packing::kGzip,
           .read = read_plain_or_packed_nifti,
           .companions = nifti_companions,
           .kinds = {kLattice},
           .outline = outline_of_nifti,
           .writers = {{.endings = {".nii", ".nii.gz"},
                        .kinds = {kLattice},
                        .write = write_one<write_nifti>,
                        .is_one_array = true,
                        .keeps_scale = true,
                        .place = PlaceInFile::kInSpaceAlone}}},
          {.name = "MetaImage",
           .endings = {".mhd", ".mha"},
           .begins = looks_like_metaimage,
           .read = read_metaimage,
           .companions = metaimage_companions,
           .kinds = {kLattice},
           .outline = outline_of_metaimage},
          {.name = "SLC",
           .endings = {".slc"},
           .begins = looks_like_slc,
           .read = read_one<read_slc>,
           .kinds = {kLattice}},
          {.name = "NPY",
           .endings = {".npy"},
           .begins = looks_like_npy,
           .read = read_one<read_npy>,
           .says_spacing = false,
           .says_axes = false,
           .outline = outline_of_npy,
           .writers = {{.endings = {".npy"},
                        .kinds = {kLattice},
                        .write = write_one<write_npy_of>,
                        .is_one_array = true,
                        .place = PlaceInFile::kNone}}},
          {.name = "TIFF",
           .endings = {".tif", ".tiff"},
           .begins = looks_like_tiff,
           .read = read_one<read_tiff>,
           .says_spacing = false,
           .says_axes = false,
           .kinds = {kLattice}},
          {.name = "Zarr",
           .endings = {".zarr"},
           .is_file = [](const ByteSource& source,
                         std::string_view start) { return is_zarr(source, start); },
           .read = read_zarr,
           .says_spacing = false,
           .says_axes = false,
           .kinds = {kLattice, kMesh}},
          {.name = kNetcdf,
           .endings = {".nc", ".nc4", ".cdf"},
           .is_file = is_netcdf_grid,
           .read = read_one<read_netcdf_grid>,
           .says_spacing = false,
           .says_axes = false,
           .kinds = {kLattice, kMesh},
           .time = time_of_netcdf},
          {.name = "OpenVDB",
           .endings = {".vdb"},
           .begins = begins_like_vdb,
           .library = "OpenVDB",
           .shares_lattice = true,
           .kinds = {kLattice, kParticles}},
          {.name = "folder of slices", .endings = {}, .says_spacing = false, .kinds = {kLattice}},
          {.name = kRaw,
           .endings = {".raw", ".raw.gz"},
           .read = read_one<read_raw>,
           .says_layout = false,
           .writers = {{.endings = {".raw"},
                        .kinds = {kLattice},
                        .write = write_one<write_raw_of>,
                        .is_one_array = true,
                        .place = PlaceInFile::kNone}}}};
}

// What VTK reads, and PLOT3D.
std::vector<Format> grids() {
  return {
      {.name = "VTK XML",
       .endings = {".vti", ".vtr", ".vts", ".vtu", ".vtp", ".vtm", ".vtpc", ".vtpd", ".vth",
                   ".vthb", ".pvti", ".pvtr", ".pvts", ".pvtu", ".pvtp", ".pvd"},
       .begins = begins_like_vtk_xml,
       .library = "VTK",
       .companions = vtk_xml_companions,
       .names_inputs = true,
       .outline = outline_of_vtk_xml,
       .time = time_of_vtk_xml,
       .writers = {{.endings = {".vti"},
                    .kinds = {kLattice},
                    .write = write_vti,
                    .place = PlaceInFile::kNoSpace},
                   {.endings = {".vtu"}, .kinds = {kMesh}, .write = write_vtu}}},
      {.name = kFileSeries,
       .endings = {".series"},
       .is_file = is_file_series,
       .read = read_file_series,
       .companions = file_series_companions,
       .names_inputs = true},
      {.name = "legacy VTK",
       .endings = {".vtk"},
       .begins = begins_like_legacy_vtk,
       .library = "VTK",
       .outline = outline_of_legacy_vtk,
       .writers = {{.endings = {".vtk"},
                    .kinds = {kLattice},
                    .write = write_legacy_vtk,
                    .place = PlaceInFile::kNoSpace}}},
      {.name = "VTKHDF", .endings = {".vtkhdf", ".hdf"}, .is_file = is_vtk_hdf, .library = "HDF5"},
      {.name = "Exodus", .endings = kExodusEndings, .is_file = is_exodus, .library = "VTK"},
      {.name = "EnSight",
       .endings = {".case", ".encas"},
       .is_file = is_ensight,
       .library = "VTK",
       .companions = ensight_companions},
      {.name = "XDMF",
       .endings = {".xdmf", ".xmf"},
       .is_file = is_xdmf,
       .read = read_xdmf,
       .companions = xdmf_companions,
       .kinds = {kLattice, kMesh, kParticles},
       .time = time_of_xdmf},
      {.name = "Enzo",
       .endings = {".hierarchy"},
       .is_file = is_enzo,
       .library = "VTK",
       .companions = enzo_companions},
      {.name = "STL",
       .endings = {".stl"},
       .is_file = is_stl,
       .read = read_one<read_stl>,
       .kinds = {kMesh}},
      {.name = "OBJ",
       .endings = {".obj"},
       .is_file = is_obj,
       .read = read_one<read_obj>,
       .kinds = {kMesh}},
      {.name = "glTF",
       .endings = {".gltf", ".glb"},
       .is_file = is_gltf,
       .read = read_gltf,
       .companions = gltf_companions,
       .kinds = {kMesh}},
      // Of a PLY file whose faces are asked for (ReadOptions::faces).
      {.name = kPlyFaces, .endings = {}, .library = "VTK", .kinds = {kMesh}},
      {.name = "PLOT3D", .endings = {}, .kinds = {kMesh}}};
}

std::vector<Format> points() {
  return {{.name = "HDF5",
           .endings = {".h5", ".hdf5", ".ims", ".athdf"},
           .begins = is_hdf5,
           .library = "HDF5",
           .sorts_inputs = true,
           .says_spacing = false,  // grids of others say none
           .says_axes = false,     // nor these
           .companions = snapshot_siblings,
           .writers = {{.endings = {".h5"},
                        .kinds = {kLattice},
                        .write = write_lattice_file,
                        .keeps_scale = true,
                        .takes_body_centred = true,
                        .library = "HDF5"}}},
          {.name = kText,
           .endings = {".csv", ".tsv", ".txt", ".dat"},
           .packing = Packing::kGzipOrBzip2,
           .read = read_one<read_point_text>,
           .kinds = {kParticles},
           .writers = {{.endings = {".csv"}, .kinds = {kParticles}, .write = write_point_text}}},
          {.name = "NPZ",
           .endings = {".npz"},
           .begins = begins_like_zip,
           .read = read_one<read_npz>,
           .says_spacing = false,
           .says_axes = false,
           .kinds = {kLattice, kParticles},
           .writers = {{.endings = {".npz"}, .kinds = {kParticles}, .write = write_npz}}},
          {.name = "PLY",
           .endings = {".ply"},
           .begins = looks_like_ply,
           .read = read_one<read_ply>,
           .kinds = {kParticles, kKernels},
           .writers = {{.endings = {".ply"}, .kinds = {kParticles, kKernels}, .write = write_ply}}},
          {.name = "LAMMPS dump",
           .endings = {".lammpstrj", ".dump"},
           .begins = begins_like_dump,
           .packing = Packing::kGzipOrBzip2,
           .read = read_one<read_lammps_dump>,
           .kinds = {kParticles},
           .time = time_of_dump}};
}

std::vector<Format> all_formats() {
  std::vector<Format> all = images();
  for (const auto& more : {grids(), points()}) all.insert(all.end(), more.begin(), more.end());
  // The last: a data set without DICM is told from bytes that others may have.
  all.push_back({.name = "DICOM",
                 .endings = {},
                 .begins = looks_like_dicom,
                 .read = read_one<read_dicom>,
                 .kinds = {kLattice}});
  return all;
}

// --- what follows from them ---------------------------------------------------------------------

// ".a, .b or .c"
std::string alternatives(const std::vector<std::string>& words) {
  const std::size_t last = words.size() - 1;
  const std::string before = fmt::format("{}", fmt::join(words.begin(), words.end() - 1, ", "));
  return last == 0 ? words[0] : before + " or " + words[last];
}

[[noreturn]] void refuse_given(const std::string& source, std::string_view format,
                               const char* given) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: the format {} states its own layout: {} can be given for raw files "
                          "only",
                          source, format, given));
}

[[noreturn]] void refuse_spacing(const std::string& source, std::string_view format) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: the format {} states its own spacing: one can be given only where "
                          "the format states none",
                          source, format));
}

[[noreturn]] void refuse_axis_order(const std::string& source, std::string_view format) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: is {}: an axis order can be given for NPY, NPZ, TIFF, Zarr, "
                          "netCDF and grids in HDF5 only",
                          source, format));
}

std::string readable_formats() {
  std::string list;
  for (const Format& format : formats()) {
    if (format.name != std::string_view(kRaw) && format.name != std::string_view(kPlyFaces))
      list += fmt::format("{}, ", format.name);
  }
  return list + "or raw samples with dimensions and type";
}

}  // namespace

const std::vector<Format>& formats() {
  static const std::vector<Format> all = all_formats();
  return all;
}

const Format& format_called(std::string_view name) {
  const auto found = std::find_if(formats().begin(), formats().end(),
                                  [&](const Format& format) { return format.name == name; });
  assert(found != formats().end());
  return *found;
}

bool has_library([[maybe_unused]] std::string_view name) {
#ifdef OVOID_IO_VTK
  if (name == "VTK") return true;
#endif
#ifdef OVOID_IO_HDF5
  if (name == "HDF5") return true;
#endif
#ifdef OVOID_IO_OPENVDB
  if (name == "OpenVDB") return true;
#endif
  return false;
}

const Format* format_by_content(const ByteSource& source) {
  std::string start = source.text(0, kStart);
  if (has_dicom_header(start)) return &format_called("DICOM");  // whatever its preamble looks like
  for (const Format& format : formats())
    if (format.is_file != nullptr && format.is_file(source, start)) return &format;
  const Packing packing = is_gzip(start)    ? Packing::kGzip
                          : is_bzip2(start) ? Packing::kGzipOrBzip2
                                            : Packing::kNone;
  if (packing != Packing::kNone) start = stream_start(source, kStart);
  for (const Format& format : formats())
    if (format.begins != nullptr && format.packing >= packing && format.begins(start))
      return &format;
  return nullptr;
}

const Format* format_of(const ByteSource& source, const RawOptions& raw) {
  if (const Format* const format = format_by_content(source)) return format;
  const RawOptions from_name = parse_raw_name(source.name());
  const Format& samples = format_called(kRaw);
  if (raw.dims || raw.type || (from_name.dims && from_name.type) ||
      is_one_of(samples.endings, ending_of(source.name())))
    return &samples;
  const Format& text = format_called(kText);
  const bool is_text = source.size() > 0 && is_one_of(text.endings, plain_ending_of(source.name()));
  return is_text ? &text : nullptr;
}

void refuse_unknown(const ByteSource& source) {
  const auto fail = [&](ErrorCode code, const std::string& what) {
    throw Error(code, fmt::format("{}: {}", source.name(), what));
  };
  const std::string ending = ending_of(source.name());
  // VTK's reader of OpenFOAM stands on libtiff, and that on JBIG-KIT, which is GPL.
  if (source.size() == 0 && ending != ".foam") fail(ErrorCode::kFileFormat, "is empty");
  const std::string start = source.text(0, kStart);
  if (const std::string picture = picture_format_of(start); !picture.empty()) {
    fail(ErrorCode::kUnsupported,
         slice_reader(picture)
             ? fmt::format("is a {} picture: expected the folder of all slices of a volume, or all "
                           "of their names",
                           picture)
             : fmt::format("is a {} picture, which is not read: expected slices of PNG, JPEG or "
                           "TIFF",
                           picture));
  }
  if (const std::string unread = unread_format_of(source, start); !unread.empty())
    fail(ErrorCode::kUnsupported, unread);
  if (is_gzip(start) || is_bzip2(start)) {
    fail(ErrorCode::kUnsupported,
         fmt::format("is a {} file of something other than {}text, which is not read: expected {}",
                     is_gzip(start) ? "gzip" : "bzip2", is_gzip(start) ? "NIfTI or " : "",
                     readable_formats()));
  }
  if (ending == ".img" || ending == ".img.gz") {
    fail(ErrorCode::kUnsupported,
         "may be the samples of a NIfTI pair: expected its header, the .hdr file beside it");
  }
  for (const Format& format : formats()) {
    if (is_one_of(format.endings, ending)) {
      fail(ErrorCode::kFileFormat,
           fmt::format("the name ends in {} but the content does not begin like it", ending));
    }
  }
  refuse_lone_plot3d(source);
  throw Error(ErrorCode::kUnsupported, fmt::format("{}: the format is not known: expected {}",
                                                   source.name(), readable_formats()));
}

void refuse_raw_options(const std::string& source, const Format& format, const RawOptions& raw) {
  if (!raw.axis_order.empty() && format.says_axes) refuse_axis_order(source, format.name);
  if (!format.says_layout) return;
  const char* const given = raw.dims         ? "dimensions"
                            : raw.type       ? "a type"
                            : raw.big_endian ? "a byte order"
                                             : nullptr;
  if (given != nullptr) refuse_given(source, format.name, given);
  if (raw.spacing && format.says_spacing) refuse_spacing(source, format.name);
}

Dataset read_as(const Format& format, const ByteSource& source, const ReadOptions& options,
                const Opener& open, const std::vector<std::string>& steps) {
  refuse_raw_options(source.name(), format, options.raw);
  if (const std::string unread = unread_dialect_of(source.name()); !unread.empty())
    throw Error(ErrorCode::kUnsupported, fmt::format("{}: {}", source.name(), unread));
  if (format.read != nullptr) return format.read(source, options, open);
  if (!has_library(format.library)) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: this build has no {} and cannot read {} files", source.name(),
                            format.library, format.name));
  }
  std::vector<std::string> paths{source.name()};
  if (format.sorts_inputs && are_sorted_by_reader(steps)) paths = steps;
  if (format.shares_lattice) paths.insert(paths.end(), steps.begin(), steps.end());
  Dataset dataset = read_foreign(format.name, source.name(), paths, options);
  if (dataset.format == kNetcdf) return dataset;  // whose reader has looked at both
  if (!options.raw.axis_order.empty() && dataset.format != kHdf5Grid)
    refuse_axis_order(source.name(), format.name);
  if (options.raw.spacing) {
    if (!dataset.format.starts_with(kHdf5Grid)) refuse_spacing(source.name(), format.name);
    dataset.lattice.world_from_index.linear() = options.raw.spacing->asDiagonal();
    check_geometry("spacing", dataset.lattice.world_from_index);
  }
  return dataset;
}

bool are_sorted_by_reader(const std::vector<std::string>& paths) {
  return !paths.empty() && std::all_of(paths.begin(), paths.end(), [](const std::string& path) {
    const Format* const format = format_by_content(*open_file(path));
    return format != nullptr && format->sorts_inputs;
  });
}

bool is_one_of(const std::vector<std::string_view>& endings, const std::string& ending) {
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

const FormatWriter& writer_for(const std::string& path) {
  const std::string ending = ending_of(path);
  for (const Format& format : formats()) {
    for (const FormatWriter& writer : format.writers) {
      if (!is_one_of(writer.endings, ending)) continue;
      if (writer.library == nullptr || has_library(writer.library)) return writer;
      throw Error(ErrorCode::kUnsupported, fmt::format("{}: this build has no {} and cannot write "
                                                       "{}",
                                                       path, writer.library, ending));
    }
  }
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: the ending '{}' names no format that is written: expected {} for "
                  "volumes, {} for meshes, {} for particles, {} for kernels",
                  path, ending, alternatives(written_endings(kLattice)),
                  alternatives(written_endings(kMesh)), alternatives(written_endings(kParticles)),
                  alternatives(written_endings(kKernels))));
}

}  // namespace ovoid::io

namespace ovoid {

std::vector<std::string> written_endings(DatasetKind kind) {
  std::vector<std::string> endings;
  for (const io::Format& format : io::formats())
    for (const io::FormatWriter& writer : format.writers)
      if (std::find(writer.kinds.begin(), writer.kinds.end(), kind) != writer.kinds.end())
        endings.insert(endings.end(), writer.endings.begin(), writer.endings.end());
  return endings;
}

}  // namespace ovoid
