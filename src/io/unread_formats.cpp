// SPDX-License-Identifier: Apache-2.0
#include "io/unread_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <vector>

#include "io/core/byte_stream.h"
#include "io/core/signatures.h"
#include "io/core/text_scanner.h"
#include "io/images/nifti_header.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using namespace std::string_view_literals;

// Bytes that files of a format have.
struct Magic {
  std::string_view bytes;
  std::size_t at = 0;
};

struct UnreadFormat {
  const char* name;  // behind "is"
  const char* way;   // behind "expected"
  std::vector<std::string_view> endings{};
  std::vector<Magic> magics{};
  bool is_in_container = false;  // HDF5 or netCDF, which are read, under this ending
};

constexpr const char* kBioFormats = "an OME-TIFF, by bfconvert (Bio-Formats) or Fiji";
constexpr const char* kMeshio = "a VTU, by 'meshio convert' or ParaView";
constexpr const char* kModeller =
    "a mesh in STL, OBJ, PLY or glTF, as Blender or a CAD program exports it";
constexpr const char* kPictures = "slices of PNG, JPEG or TIFF";
constexpr const char* kFrames = "pictures of its frames, by 'ffmpeg -i FILE frame%04d.png'";
constexpr const char* kUnpacked = "what is in it, unpacked";

// Those that more than their endings and first bytes tell of.
UnreadFormat analyze() {
  return {"an ANALYZE 7.5 header without NIfTI's magic", "NIfTI, by 'fslchfiletype NIFTI_GZ A'"};
}
UnreadFormat amrex() {
  return {"an AMReX plotfile",
          "VTK's files, by ParaView or yt",
          {},
          {{"HyperCLaw-V"}, {"NavierStokes-V"}}};
}
UnreadFormat openfoam() { return {"an OpenFOAM case", "what foamToVTK makes of it", {".foam"}}; }

// Of medicine.
std::vector<UnreadFormat> medical_formats() {
  return {
      {"a volume of FreeSurfer (MGH, MGZ)",
       "NIfTI, by 'mri_convert A.mgz A.nii.gz'",
       {".mgh", ".mgz", ".mgh.gz"}},
      {"AFNI (HEAD and BRIK)", "NIfTI, by '3dAFNItoNIFTI A+orig'", {".head", ".brik", ".brik.gz"}},
      {"MINC", "NIfTI, by 'mnc2nii A.mnc A.nii'", {".mnc", ".mnc.gz"}, {}, true},
      {"an image of MRtrix",
       "NIfTI, by 'mrconvert A.mif A.nii.gz'",
       {".mif", ".mih", ".mif.gz"},
       {{"mrtrix image"}}},
      {"streamlines of MRtrix",
       "legacy VTK, by 'tckconvert A.tck A.vtk'",
       {".tck"},
       {{"mrtrix tracks"}}},
      {"streamlines of TrackVis",
       "legacy VTK, by nibabel's 'nib-trk2tck' and MRtrix's tckconvert",
       {".trk"},
       {{"TRACK\0"sv}}},
      {"GIFTI", "STL or legacy VTK, by 'mris_convert A.gii A.stl'", {".gii", ".gii.gz"}},
      {"a surface of FreeSurfer",
       "STL or legacy VTK, by 'mris_convert lh.pial lh.stl'",
       {},
       {{"\xff\xff\xfe"}}},
      {"Philips PAR and REC", "NIfTI, by 'dcm2niix A.PAR' or nibabel's parrec2nii", {".par"}},
      {"ECAT", "NIfTI, by nibabel", {}, {{"MATRIX7"}}},
      {"Interfile",
       "an NRRD header (.nhdr) that names its data",
       {".hv", ".i33"},
       {{"!INTERFILE"}, {"!interfile"}}},
      {"Scanco ISQ or AIM",
       "TIFF or NRRD, by Fiji or ITK",
       {".isq", ".aim"},
       {{"CTDATA-HEADER_V1"}, {"AIMDATA_V030"}}},
  };
}

// Of microscopes.
std::vector<UnreadFormat> microscopy_formats() {
  return {
      {"Zeiss CZI", kBioFormats, {".czi"}, {{"ZISRAWFILE"}}},
      {"Leica LIF", kBioFormats, {".lif", ".xlef", ".lof"}, {{"\x70\0\0\0"sv}}},
      {"Nikon ND2", kBioFormats, {".nd2"}, {{"\xda\xce\xbe\x0a"}}},
      {"Olympus OIB, Zeiss ZVI or another OLE2 file",
       kBioFormats,
       {".oib", ".zvi"},
       {{"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"}}},
      {"Olympus OIF, OIR or VSI", kBioFormats, {".oif", ".oir", ".vsi"}},
      {"SlideBook, ICS or another image of a microscope",
       kBioFormats,
       {".sld", ".ics", ".ids", ".dv"}},
      {"Gatan DM3 or DM4", "TIFF, by Fiji, or NPY, by ncempy", {".dm3", ".dm4"}},
      {"MRC or CCP4",
       "TIFF, by IMOD's 'mrc2tif -s', or an NRRD header (.nhdr) beside it with 'byte skip: -1'",
       {".mrc", ".mrcs", ".ccp4", ".mrc.gz", ".ccp4.gz"},
       {{"MAP ", 208}}},
      {"an EM density map in SPIDER or IMAGIC",
       "MRC's way, by EMAN2's e2proc3d.py to .nrrd or .tif",
       {".spi", ".hed"}},
  };
}

// Of physics, chemistry, the earth and the sky.
std::vector<UnreadFormat> science_formats() {
  return {
      {"a Gaussian cube file",
       "NPY, by numpy.save of what ase.io.cube.read_cube_data (Python) reads",
       {".cube", ".cub"}},
      {"an OpenDX grid",
       "NPY, by numpy.save of what gridData.Grid (Python) reads",
       {".dx"},
       {{"object 1 class gridpositions"}}},
      {"XSF", "NPY, by numpy.save of what ase.io.xsf.read_xsf (Python) reads", {".xsf"}},
      {"a molecule (PDB, mmCIF)",
       "its atoms as a table of x, y, z in CSV",
       {".pdb", ".cif", ".mol2"}},
      {"SEG-Y", "NPY, by numpy.save of what segyio.tools.cube (Python) reads", {".sgy", ".segy"}},
      {"FITS",
       "NPY, by numpy.save of what astropy.io.fits.getdata (Python) reads",
       {".fits", ".fit", ".fts"},
       {{"SIMPLE  ="}}},
      {"GRIB",
       "netCDF, by 'cdo -f nc copy A.grib A.nc' or grib_to_netcdf",
       {".grib", ".grib2", ".grb", ".grb2"},
       {{"GRIB"}}},
      {"a MATLAB file",
       "NPY, by numpy.save of what scipy.io.loadmat reads, or of version 7.3 what h5py does",
       {".mat"},
       {{"MATLAB "}}},
      {"a ROOT file", "NPY or CSV, by uproot (Python)", {".root"}, {{"root"}}},
      {"an ENVI header", "TIFF, by 'gdal_translate A.img A.tif'", {}, {{"ENVI\n"}, {"ENVI\r"}}},
      {"Amira's or Avizo's mesh",
       "TIFF or NRRD, by Fiji",
       {".am"},
       {{"# AmiraMesh"}, {"# Avizo"}, {"# HyperSurface"}}},
      {"an AVS field", "an NRRD header (.nhdr) that names its data", {".fld"}, {{"# AVS"}}},
      {"PVM",
       "raw samples, by the V3 library's pvm2raw",
       {".pvm"},
       {{"PVM\n"}, {"PVM2\n"}, {"PVM3\n"}, {"DDS v3"}}},
      amrex(),
      openfoam(),
  };
}

// Meshes, and tables of points.
std::vector<UnreadFormat> mesh_formats() {
  return {
      {"CGNS", kMeshio, {".cgns"}, {}, true},
      {"MED (SALOME)", kMeshio, {".med"}, {}, true},
      {"Silo", "VTK's files, by VisIt", {".silo"}, {}, true},
      {"a mesh of Gmsh",
       "a VTU, by 'meshio convert', or legacy VTK, by 'gmsh -save'",
       {".msh"},
       {{"$MeshFormat"}}},
      {"a mesh of Abaqus, AVS or Nastran", kMeshio, {".inp", ".bdf", ".nas"}},
      {"a mesh in OFF, Medit, UNV or SU2", kMeshio, {".off", ".mesh", ".unv", ".su2"}},
      {"Tecplot's binary", "a VTU, by ParaView", {".plt", ".szplt"}, {{"#!TDV"}, {"#!SZPLT"}}},
      {"a case of Fluent", "EnSight or CGNS and then VTU, by Fluent or ParaView", {".cas"}},
      {"FBX", kModeller, {".fbx"}, {{"Kaydara FBX"}}},
      {"a Blender file", kModeller, {".blend"}, {{"BLENDER"}}},
      {"USD", kModeller, {".usd", ".usda", ".usdc"}, {{"PXR-USDC"}, {"#usda"}}},
      {"Alembic", kModeller, {".abc"}, {{"Ogawa"}}},
      {"COLLADA, X3D, VRML or 3DS", kModeller, {".dae", ".x3d", ".wrl", ".3ds"}, {{"#VRML"}}},
      {"STEP or IGES", kModeller, {".step", ".stp", ".iges", ".igs"}, {{"ISO-10303-21"}}},
      {"a LAS or LAZ point cloud",
       "PLY or CSV, by 'pdal translate A.las A.ply'",
       {".las", ".laz"},
       {{"LASF"}}},
      {"an E57 point cloud",
       "PLY, by 'pdal translate A.e57 A.ply' or CloudCompare",
       {".e57"},
       {{"ASTM-E57"}}},
      {"a PCD point cloud", "PLY, by pcl_pcd2ply", {".pcd"}, {{"# .PCD"}}},
      {"Parquet", "CSV, by pandas' read_parquet and to_csv", {".parquet"}, {{"PAR1"}}},
      {"Arrow or Feather",
       "CSV, by pandas' read_feather and to_csv",
       {".feather", ".arrow"},
       {{"ARROW1"}}},
      {"a pickled Python object",
       "an array, by numpy.save",
       {".pkl", ".pickle", ".pt", ".pth"},
       {{"\x80\x02\x8a\x0a\x6c\xfc\x9c\x46"}}},
  };
}

// What no data are.
std::vector<UnreadFormat> other_formats() {
  return {
      {"an OpenEXR picture", kPictures, {".exr"}, {{"\x76\x2f\x31\x01"}}},
      {"a JPEG 2000 picture",
       kPictures,
       {".jp2", ".j2k"},
       {{"\0\0\0\x0cjP  "sv}, {"\xff\x4f\xff\x51"}}},
      {"a GIF picture", kPictures, {".gif"}, {{"GIF8"}}},
      {"a WebP picture", kPictures, {".webp"}, {{"WEBP", 8}}},
      {"a PGM, PPM or PSD picture", kPictures, {".pgm", ".ppm", ".psd"}, {{"8BPS"}}},
      {"a film",
       kFrames,
       {".mp4", ".mov", ".avi", ".mkv", ".webm"},
       {{"ftyp", 4}, {"AVI ", 8}, {"\x1a\x45\xdf\xa3"}}},
      {"a PDF document", "a file of data", {".pdf"}, {{"%PDF-"}}},
      {"a 7z, RAR, xz, Zstandard or tar archive",
       kUnpacked,
       {".7z", ".rar", ".xz", ".zst", ".tar", ".tgz"},
       {{"7z\xbc\xaf"}, {"Rar!"}, {"\xfd\x37zXZ"}, {"\x28\xb5\x2f\xfd"}, {"ustar", 257}}},
  };
}

const std::vector<UnreadFormat>& unread_formats() {
  static const std::vector<UnreadFormat> all = [] {
    std::vector<UnreadFormat> rows = medical_formats();
    for (const auto& more :
         {microscopy_formats(), science_formats(), mesh_formats(), other_formats()})
      rows.insert(rows.end(), more.begin(), more.end());
    return rows;
  }();
  return all;
}

std::string told(const UnreadFormat& format) {
  return fmt::format("is {}, which is not read: expected {}", format.name, format.way);
}

bool begins_like(const UnreadFormat& format, std::string_view start) {
  return std::any_of(format.magics.begin(), format.magics.end(), [&](const Magic& magic) {
    return start.size() >= magic.at + magic.bytes.size() &&
           start.substr(magic.at, magic.bytes.size()) == magic.bytes;
  });
}

bool is_called_like(const UnreadFormat& format, const std::string& path) {
  const std::string ending = ending_of(path);
  return !ending.empty() &&
         std::find(format.endings.begin(), format.endings.end(), ending) != format.endings.end();
}

}  // namespace

std::string unread_format_of(const ByteSource& source, std::string_view start) {
  std::string unpacked;
  if (is_gzip(start) || is_bzip2(start)) unpacked = stream_start(source, start.size());
  for (const UnreadFormat& format : unread_formats())
    if (begins_like(format, start) || begins_like(format, unpacked)) return told(format);
  for (const UnreadFormat& format : unread_formats())
    if (is_called_like(format, source.name())) return told(format);
  if (looks_like_analyze(start)) return told(analyze());
  return {};
}

std::string unread_dialect_of(const std::string& path) {
  for (const UnreadFormat& format : unread_formats())
    if (format.is_in_container && is_called_like(format, path)) return told(format);
  return {};
}

std::string unread_folder_of(const std::string& path) {
  struct Marker {
    const char* file;  // that is in the folder
    UnreadFormat format;
    bool has_magic = false;  // the file begins with one of the format's
  };
  static const Marker kMarkers[] = {
      {"Header", amrex(), true},
      {"system/controlDict", openfoam()},
      {"2dseq",
       {"an image of Bruker ParaVision", "NIfTI, by brkraw or dcm2niix of its DICOM export"}},
      {"acqp", {"a scan of Bruker ParaVision", "NIfTI, by brkraw or dcm2niix of its DICOM export"}},
      {"attributes.json", {"N5", "Zarr"}}};
  for (const Marker& marker : kMarkers) {
    const std::filesystem::path file = std::filesystem::path(path) / marker.file;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) continue;
    if (!marker.has_magic || begins_like(marker.format, open_file(file.string())->text(0, 32)))
      return told(marker.format);
  }
  return {};
}

}  // namespace ovoid::io
