// SPDX-License-Identifier: Apache-2.0
// Small valid inputs for each family of readers, made here: where fuzzing and the mutation test
// start from.
#pragma once

#include <bzlib.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "io/core/test_deflate.h"
#include "io/dicom/test_dicom.h"
#include "io/dicom/test_dicom_streams.h"
#include "io/images/npy.h"
#include "io/images/test_png.h"
#include "io/images/test_tiff.h"
#include "io/netcdf/test_netcdf.h"
#include "io/pictures/pictures.h"
#include "io/xdmf/test_xdmf.h"
#include "io/zarr/test_zarr.h"
#include "ovoid/error.h"
#include "ovoid/lattice_file.h"

namespace ovoid::fuzz {

using io::deflated;

inline std::string gzip(const std::string& data) { return deflated(data, 15 + 16); }

inline std::string bzip2(const std::string& data) {
  std::string out(data.size() + 1000, '\0');
  auto size = static_cast<unsigned>(out.size());
  BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(data.data()),
                           static_cast<unsigned>(data.size()), 9, 0, 0);
  out.resize(size);
  return out;
}

// Bytes that vary and compress.
inline std::string samples(std::size_t count) {
  std::string result;
  for (std::size_t i = 0; i < count; ++i) result += static_cast<char>(i * i / 7 % 251);
  return result;
}

inline std::vector<std::string> nrrd_seeds() {
  const std::string base =
      "NRRD0004\n# a comment\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nkey:=value\n";
  const std::string raw = samples(24);
  std::string text, hex;
  for (const char c : raw) {
    const auto value = static_cast<unsigned char>(c);
    text += std::to_string(value) + " ";
    hex += "0123456789abcdef"[value / 16];
    hex += "0123456789abcdef"[value % 16];
  }
  return {
      base + "encoding: raw\nspacings: 1 2 nan\nbyte skip: -1\n\n" + raw,
      base +
          "encoding: gzip\nspace: LPS\nspace directions: (1,0,0) (0.5,2,0) (0,0,-3)\nspace origin: "
          "(1e6,2,3)\n\n" +
          gzip(raw),
      base + "encoding: bzip2\ncontent: name\nsample units: \"HU\"\n\n" + bzip2(raw),
      base +
          "encoding: ascii\naxis mins: 0 0 0\naxis maxs: 3 3 2\ncenters: node cell cell\nline "
          "skip: 1\n\nline\n" +
          text,
      base + "encoding: hex\nunknown: field\n\n" + hex,
      "NRRD0005\ntype: float\nendian: big\nencoding: raw\ndimension: 4\nsizes: 2 2 2 1\nkinds: "
      "vector domain domain domain\n\n" +
          samples(32),
      "NRRD0001\r\ntype: short\r\nencoding: raw\r\ndimension: 2\r\nsizes: 3 2\r\nendian: "
      "little\r\n\r\n" +
          samples(12),
      base + "encoding: raw\ndata file: a%03d.raw 1 2 1\n",
      base + "encoding: raw\nline skip: 2\nbyte skip: 5\ndata file: LIST 3\none.raw\nmissing.raw\n",
      base + "encoding: gz\ndata file: a.raw\n",
  };
}

inline std::vector<std::string> slice_seeds() {
  using enum io::PngPixels;
  std::vector<std::string> seeds{
      io::png_file({7, 5}, samples(35)),
      io::png_file({3, 5, 16}, samples(30)),
      io::png_file({8, 4, 1}, samples(4)),
      io::png_file({4, 2, 8, kRgb}, samples(24)),
      io::png_file({4, 2, 16, kRgba}, samples(64)),
      io::png_file({4, 2, 4, kPalette, samples(48)}, samples(4)),
  };
  const std::string path = (std::filesystem::temp_directory_path() /
                            ("ovoid_seed_" + std::to_string(::getpid()) + ".jpg"))
                               .string();
  const std::string pixels = samples(4 * 17 * 9);
  io::write_jpeg({reinterpret_cast<const std::uint8_t*>(pixels.data()), pixels.size()}, 17, 9,
                 path);
  std::ifstream stream(path, std::ios::binary);
  seeds.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  return seeds;
}

inline std::vector<std::string> tiff_seeds() {
  const std::vector<std::string> pages{samples(12), samples(13).substr(1)};
  std::vector<std::string> seeds;
  for (const int compression : {1, 5, 8, 32773, 50000}) {
    io::TestTiff tiff;
    tiff.compression = compression;
    tiff.is_big_endian = compression == 5;
    tiff.is_big_tiff = compression == 8;
    seeds.push_back(io::tiff_file(tiff, pages));
  }
  io::TestTiff floats;
  floats.bits = 32;
  floats.format = floats.predictor = 3;
  floats.compression = 8;
  floats.width = 1;
  seeds.push_back(io::tiff_file(floats, pages));
  io::TestTiff wide;
  wide.bits = 12;
  wide.width = 2;
  wide.height = 4;
  seeds.push_back(io::tiff_file(wide, pages));
  io::TestTiff imagej;
  imagej.rows_per_strip = 3;
  imagej.description = "ImageJ=1\nimages=2\nchannels=1\nslices=1\nframes=2\nunit=um\nspacing=2\n";
  seeds.push_back(io::tiff_file(imagej, {pages[0] + pages[1]}));
  io::TestTiff ome;
  ome.description =
      "<OME><Image><Pixels SizeZ=\"1\" SizeC=\"2\" SizeT=\"1\" DimensionOrder=\"XYCZT\" "
      "PhysicalSizeX=\"2\" PhysicalSizeY=\"1\"><Channel Name=\"a\"/><TiffData IFD=\"0\" "
      "FirstC=\"1\"/><TiffData IFD=\"1\"/></Pixels></Image></OME>";
  seeds.push_back(io::tiff_file(ome, pages));
  io::TestTiff tiles;
  tiles.tile = 16;
  tiles.width = 18;
  io::TiffWriter writer(tiles);
  writer.add_page({samples(256), samples(256)});
  seeds.push_back(writer.bytes());
  io::TestTiff jpeg;
  jpeg.compression = 7;
  jpeg.width = jpeg.rows_per_strip = jpeg.height = 8;
  seeds.push_back(io::tiff_file(jpeg, {samples(64)}));
  jpeg.num_samples = 3;
  jpeg.photometric = 6;
  jpeg.has_jpeg_tables = false;
  jpeg.jpeg.is_progressive = true;
  seeds.push_back(io::tiff_file(jpeg, {samples(192)}));
  return seeds;
}

// Zip files: a group with places, an image, version 3.
inline std::vector<std::string> zarr_seeds() {
  io::TestZarray array;
  array.shape = array.chunks = "[2, 3, 2]";
  array.order = "F";
  array.compressor = R"({"id": "zlib"})";
  array.fill = "7";
  io::ZarrFiles group{{".zgroup", io::kZgroup},
                      {"v/.zarray", io::zarray(array)},
                      {"v/0.0.0", deflated(samples(12), 15)}};
  group["v/.zattrs"] =
      R"({"_ARRAY_DIMENSIONS": ["z", "y", "x"], "scale_factor": 2, "missing_value": 3, "units": "K"})";
  for (const char* const name : {"z", "y", "x"}) {
    group[std::string(name) + "/.zarray"] =
        io::zarray({.shape = *name == 'y' ? "[3]" : "[2]", .chunks = "[3]"});
    group[std::string(name) + "/0"] = "\1\3\5";
  }
  io::ZarrFiles image{{".zgroup", io::kZgroup}};
  image[".zattrs"] =
      R"({"multiscales": [{"axes": [{"name": "t", "type": "time"}, {"name": "c", "type": "channel"},
      {"name": "y", "type": "space", "unit": "nanometer"}, {"name": "x", "type": "space"}], "datasets": [
      {"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 2, 0.5]},
      {"type": "translation", "translation": [0, 0, 1, 2]}]}, {"path": "1"}]}],
      "omero": {"channels": [{"label": "a"}, {}]}})";
  const std::pair<const char*, std::string> packs[] = {
      {"blosc", io::with_blosc(samples(32), "lz4", 1, 2)},
      {"blosc", io::with_blosc(samples(32), "blosclz", 2, 2)},
      {"zstd", io::with_zstd(samples(32))},
      {"lz4", io::with_lz4(samples(32))},
      {"bz2", bzip2(samples(32))}};
  std::vector<std::string> seeds{io::zip_of(group)};
  for (const auto& [id, bytes] : packs) {
    array = {.shape = "[2, 2, 3, 4]", .chunks = "[1, 2, 2, 4]", .dtype = ">i2", .separator = "/"};
    array.compressor = std::string(R"({"id": ")") + id + R"("})";
    image["0/.zarray"] = io::zarray(array);
    image["0/0/0/0/0"] = image["0/1/0/1/0"] = bytes;
    seeds.push_back(io::zip_of(image));
  }
  io::ZarrFiles third;
  third["zarr.json"] =
      R"({"zarr_format": 3, "node_type": "array", "shape": [1, 1, 9], "data_type": "uint8",
      "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [1, 1, 9]}},
      "chunk_key_encoding": {"name": "default"}, "fill_value": 0, "dimension_names": ["z", "y", "x"],
      "codecs": [{"name": "bytes"}, {"name": "crc32c"}]})";
  third["c/0/0/0"] = "123456789\x83\x92\x06\xe3";
  seeds.push_back(io::zip_of(third));
  return seeds;
}

inline std::vector<std::string> xdmf_seeds() {
  const auto values = [](int count) {
    return io::xdmf_attribute("u", io::xdmf_item(std::to_string(count), io::xdmf_counting(count)));
  };
  const std::string rectilinear =
      "<Topology Type=\"3DRectMesh\" Dimensions=\"3 2 2\"/><Geometry Type=\"VXVYVZ\">" +
      io::xdmf_item("2", "0 1") + io::xdmf_item("2", "5 7") + io::xdmf_item("3", "1 4 8") +
      "</Geometry>";
  const std::string raw =
      "<DataItem Dimensions=\"2 3 4\" Format=\"Binary\" Seek=\"3\" "
      "Endian=\"Big\" NumberType=\"Int\">b</DataItem>";
  const std::string pieces = "GridType=\"Collection\" CollectionType=\"Spatial\"";
  const std::string mesh = io::xdmf_grid(io::kXdmfMixed + values(9), "Name=\"a\"");
  return {
      io::xdmf_file(io::xdmf_grid(io::kXdmfEven + values(24))),
      io::xdmf_file(io::xdmf_grid(io::kXdmfEven + io::xdmf_attribute("f", raw))),
      io::xdmf_file(io::xdmf_grid(rectilinear + io::xdmf_attribute("f", io::xdmf_slab()))),
      io::xdmf_file(io::xdmf_series()),
      io::xdmf_file(io::xdmf_grid(
          io::kXdmfEven + io::xdmf_attribute("v", io::xdmf_join(), "AttributeType=\"Vector\""))),
      io::xdmf_file(io::xdmf_grid(mesh + mesh, pieces)),
      io::xdmf_file(io::xdmf_grid(io::kXdmfNodes + values(9)) + mesh),
      io::xdmf_file(io::xdmf_item("24", io::xdmf_counting(24)) +
                    io::xdmf_grid(io::kXdmfEven + io::xdmf_attribute("f",
                                                                     "<DataItem Reference=\"XML\">"
                                                                     "//DataItem[1]</DataItem>")))};
}

inline std::vector<std::string> netcdf_seeds() {
  return {io::test_climate(1).bytes(), io::test_climate(5).bytes(),
          io::test_simulation({1, 2, 3}).bytes(), io::test_simulation({1, 2, 4}).bytes()};
}

// A binary header, number by number, in either byte order.
class BinaryHeader {
 public:
  BinaryHeader(std::size_t size, bool is_big_endian)
      : bytes_(size, '\0'), is_swapped_(is_big_endian) {}

  template <typename T>
  BinaryHeader& put(std::size_t at, std::initializer_list<T> values) {
    for (const T value : values) {
      std::memcpy(bytes_.data() + at, &value, sizeof(T));
      char* const raw = bytes_.data() + at;
      if (is_swapped_) std::reverse(raw, raw + sizeof(T));
      at += sizeof(T);
    }
    return *this;
  }
  BinaryHeader& text(std::size_t at, const std::string& value) {
    std::memcpy(bytes_.data() + at, value.data(), value.size());
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  bool is_swapped_;  // the machines that run tests are little endian
};

// dims: number of axes, then samples along each. Spacing 1 2 3, a step of time 0.5; no transform.
inline BinaryHeader nifti1(std::initializer_list<std::int16_t> dims, std::int16_t type,
                           std::int16_t bits, bool is_big_endian = false) {
  BinaryHeader header(352, is_big_endian);
  header.put<std::int32_t>(0, {348}).put(40, dims).put<std::int16_t>(70, {type, bits});
  header.put<float>(76, {1, 1, 2, 3, 0.5F}).put<float>(108, {352});
  return header.text(344, "n+1");
}

inline BinaryHeader nifti2(std::initializer_list<std::int64_t> dims, std::int16_t type,
                           std::int16_t bits, bool is_big_endian = false) {
  BinaryHeader header(544, is_big_endian);
  header.put<std::int32_t>(0, {540}).text(4, std::string("n+2\0\r\n\x1a\n", 8));
  header.put<std::int16_t>(12, {type, bits}).put(16, dims);
  header.put<double>(104, {1, 1, 2, 3, 0.5}).put<std::int64_t>(168, {544});
  return header;
}

// The last one is the header of a pair.
inline std::vector<std::string> nifti_seeds() {
  auto placed = nifti1({3, 4, 3, 2}, 4, 16);
  placed.put<std::int16_t>(252, {1, 1}).put<float>(256, {0, 0, 0.70710678F, 5, 6, 7});
  placed.put<float>(280, {0, -2, 0, 5, 1, 0, 0, 6, 0, 0, 3, 7}).put<float>(112, {2, -1});
  auto in_time = nifti1({5, 2, 2, 2, 2, 3}, 16, 32, true);
  in_time.put<char>(123, {2 + 16});
  auto pair = nifti1({3, 2, 2, 2}, 2, 8);
  pair.put<float>(108, {0}).text(344, "ni1");
  return {
      placed.bytes() + samples(48),
      in_time.bytes() + samples(192),
      gzip(nifti2({4, 3, 3, 1, 2}, 1280, 64, true).bytes() + samples(144)),
      nifti2({3, 3, 2, 2}, 64, 64).bytes() + samples(96),
      nifti1({3, 3, 2, 2}, 128, 24).bytes() + samples(36),
      pair.bytes(),
  };
}

// The last ones have data in other files.
inline std::vector<std::string> metaimage_seeds() {
  const std::string base =
      "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\n";
  const std::string raw = samples(24);
  std::string text;
  for (const char c : raw) text += std::to_string(static_cast<unsigned char>(c)) + " ";
  return {
      base +
          "BinaryData = True\nTransformMatrix = 1 0 0 0 0 1 0 -1 0\nOffset = 1 2 -3\n"
          "CenterOfRotation = 0 0 1\nElementSpacing = 1 2 0.5\nElementDataFile = LOCAL\n" +
          raw,
      base +
          "CompressedData = True\nCompressedDataSize = 20\nUnknown = 1\nElementDataFile = LOCAL\n" +
          deflated(raw, 15),
      base + "BinaryData = False\nElementDataFile = LOCAL\n" + text,
      "NDims = 4\nDimSize = 2 2 1 3\nElementType = MET_SHORT\nElementByteOrderMSB = True\n"
      "ElementNumberOfChannels = 2\nElementDataFile = LOCAL\n" +
          samples(48),
      base + "HeaderSize = -1\nElementDataFile = LOCAL\n" + raw,
      base + "HeaderSize = 5\nElementDataFile = a.raw\n",
      base + "ElementDataFile = a%03d.raw 1 2 1\n",
      base + "ElementDataFile = LIST 2\none.raw\nmissing.raw\n",
  };
}

inline std::vector<std::string> slc_seeds() {
  const std::string start = "11111 4 3 2 8 1.0 2.0 0.5 1 1 0 ";
  const std::string icon = "2 1 X" + samples(6);
  return {
      start + "0\n" + icon + samples(24),
      // 12 samples: ten times 7, then two as they are; then four, three runs of two and two single.
      start + "1\n" + icon + "6 X" + std::string("\x0a\7\x82\1\2\0", 6) + "15X" +
          std::string("\x84\1\2\3\4\2\5\2\6\2\7\x82\1\2\0", 15),
  };
}

// An NPY file of version 2: its header's length has four bytes.
inline std::string npy2(const std::string& dict, const std::string& data) {
  std::string result = "\x93NUMPY\x02";
  result += '\0';
  result += static_cast<char>(dict.size());
  return result + std::string(3, '\0') + dict + data;
}

inline std::vector<std::string> npy_seeds() {
  const std::int64_t shape[] = {2, 3, 4};
  const std::int64_t vectors[] = {2, 2, 2, 3};
  return {
      io::npy_header(ScalarType::kFloat32, shape) + samples(96),
      io::npy_header(ScalarType::kInt16, vectors) + samples(48),
      npy2("{'descr': '>i2', 'fortran_order': True, 'shape': (2, 3L, 4), }\n", samples(48)),
      npy2("{\"shape\":(1,2,3,2),\"fortran_order\":True,\"descr\":\"|b1\"}", samples(12)),
  };
}

inline std::vector<std::string> raw_name_seeds() {
  return {"folder/x_4x4x4_uint8.raw", "a_b_2x4x8_uint8_le.raw", "x_2x2x2_float64.bin",
          "x_4x4x2_int16"};
}

inline std::vector<std::string> dicom_seeds() {
  std::vector<std::string> seeds;
  for (const char* uid : {io::kImplicitUid, io::kExplicitUid, io::kBigUid, io::kDeflatedUid}) {
    io::TestSlice slice;
    slice.uid = uid;
    seeds.push_back(io::dicom_slice(slice));
  }
  seeds.push_back(io::dicom_slice(io::enhanced_slices(true)));
  seeds.push_back(io::dicom_slice(io::enhanced_slices(false)));
  seeds.push_back(io::data_set_of(io::TestSlice{}));
  io::TestSlice times = io::enhanced_slices();
  times.groups = io::DicomElements();
  times.orientation = "1\\0\\0\\0\\1\\0";
  times.position = "0\\0\\0";
  seeds.push_back(io::dicom_slice(times));
  io::TestSlice packed;
  packed.uid = io::kRleUid;
  packed.is_encapsulated = true;
  packed.pixels = io::encapsulated({io::rle_frame(samples(12))});
  seeds.push_back(io::dicom_slice(packed));
  return seeds;
}

inline std::vector<std::string> dicom_codec_seeds() {
  const std::string samples = io::pixels_of(17 * 23, 4095);
  std::vector<std::string> seeds{std::string(1, '\0') + io::rle_frame(samples)};
#ifdef OVOID_IO_GDCM
  seeds.push_back('\1' + io::jpeg_lossless(samples));
  seeds.push_back('\3' + io::jpeg_ls(samples));
  seeds.push_back('\4' + io::jpeg2000(samples));
  gdcm::JPEGCodec lossy;
  lossy.SetLossless(false);
  seeds.push_back('\2' + io::encoded(lossy, samples, 12, 12));
#endif
  return seeds;
}

inline std::vector<std::string> vtk_header_seeds() {
  const std::string piece = "<Piece Extent=\"0 2 0 1 5 6\">\n<PointData Scalars=\"v\">\n";
  const std::string start =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"0.1\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt32\"";
  const std::string image =
      "<ImageData WholeExtent=\"0 2 0 1 5 6\" Origin=\"0 0 0\" Spacing=\"1 1 1\" Direction=\"1 0 0 "
      "0 1 0 0 0 1\">\n";
  const std::string array = "<DataArray type=\"UInt8\" Name=\"v\" NumberOfComponents=\"1\" ";
  const std::string end = "</PointData>\n<CellData/>\n</Piece>\n</ImageData>\n";
  const std::string compressed = deflated(samples(12), 15);
  return {
      start + ">\n" + image + piece + array +
          "format=\"ascii\">1 2 3 4 5 6 7 8 9 10 11 12</DataArray>\n" + end + "</VTKFile>\n",
      start + ">\n" + image + piece + array +
          "format=\"binary\">\nDAAAADEyMzQ1Njc4OTAxMg==\n</DataArray>\n" + end + "</VTKFile>\n",
      start + ">\n" + image + piece + array + "format=\"appended\" offset=\"0\"/>\n" + end +
          "<AppendedData encoding=\"raw\">\n_" + std::string("\x0c\0\0\0", 4) + samples(12) +
          "\n</AppendedData>\n</VTKFile>\n",
      start + " compressor=\"vtkZLibDataCompressor\">\n<!-- > -->" + image + piece + array +
          "format=\"appended\" offset=\"0\"/>\n" + end + "<AppendedData encoding=\"raw\">\n_" +
          std::string("\1\0\0\0\x0c\0\0\0\0\0\0\0", 12) + static_cast<char>(compressed.size()) +
          std::string(3, '\0') + compressed + "\n</AppendedData>\n</VTKFile>\n",
      "# vtk DataFile Version 3.0\ntitle\nBINARY\n\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 "
      "2\nSPACING 1 1 1\nORIGIN 0 0 0\n"
      "POINT_DATA 12\nSCALARS v unsigned_char 1\nLOOKUP_TABLE default\n" +
          samples(12),
      "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 "
      "2\nASPECT_RATIO 1 1 1\nORIGIN 0 0 0\n"
      "POINT_DATA 8\nVECTORS v float\n1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 "
      "24\nCELL_DATA 1\nSCALARS c int\n"
      "LOOKUP_TABLE default\n7\n",
      "<VTKFile type=\"RectilinearGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<RectilinearGrid WholeExtent=\"0 2 0 1 0 1\">\n<Piece Extent=\"0 2 0 1 0 "
      "1\">\n<PointData>\n" +
          array +
          "format=\"ascii\">1 2 3 4 5 6 7 8 9 10 11 12</DataArray>\n</PointData>\n"
          "<Coordinates>\n<DataArray type=\"Float32\" Name=\"x\" format=\"ascii\">0 0.5 "
          "1</DataArray>\n<DataArray type=\"Float64\" Name=\"y\" format=\"ascii\">0 "
          "3</DataArray>\n<DataArray type=\"Int32\" Name=\"z\" format=\"ascii\">5 "
          "4</DataArray>\n</Coordinates>\n</Piece>\n</RectilinearGrid>\n</VTKFile>\n",
      "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 3 2 "
      "1\nX_COORDINATES 3 float\n0 0.5 1\nY_COORDINATES 2 double\n1 2\nZ_COORDINATES 1 int\n7\n"
      "POINT_DATA 6\nSCALARS v float\nLOOKUP_TABLE default\n1 2 3 4 5 6\n",
      "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n0 0 0 "
      "1 0 0 0 1 0 0 0 1 1 1 1\nCELLS 2 10\n4 0 1 2 3\n4 1 2 3 4\nCELL_TYPES 2\n10\n10\n"
      "CELL_DATA 2\nSCALARS v float\nLOOKUP_TABLE default\n1 2\n",
      "# vtk DataFile Version 5.1\ntitle\nASCII\nDATASET POLYDATA\nPOINTS 3 double\n0 0 0 1 0 0 0 "
      "1 "
      "0\nPOLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\n",
      "# vtk DataFile Version 3.0\ntitle\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n" +
          std::string(12, '\0') + "\nCELLS 1 2\n" + std::string("\0\0\0\1\0\0\0\0", 8) +
          "\nCELL_TYPES 1\n" + std::string("\0\0\0\1", 4) + "\n",
      "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"><UnstructuredGrid>\n"
      "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><PointData>" +
          array +
          "format=\"ascii\">1 2 3 4</DataArray></PointData>\n<Points><DataArray type=\"Float32\" "
          "NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>\n"
          "<Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2 "
          "3</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"binary\">"
          "BAAAAAQAAAA=</DataArray><DataArray type=\"UInt8\" Name=\"types\" "
          "format=\"ascii\">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>\n",
      "<VTKFile type=\"StructuredGrid\" byte_order=\"LittleEndian\"><StructuredGrid "
      "WholeExtent=\"0 1 0 1 0 0\"><Piece Extent=\"0 1 0 1 0 0\"><PointData>" +
          array +
          "format=\"ascii\">1 2 3 4</DataArray></PointData><Points><DataArray type=\"Float32\" "
          "NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 1 1 "
          "0</DataArray></Points></Piece></StructuredGrid></VTKFile>\n",
      "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\"><PolyData><Piece "
      "NumberOfPoints=\"3\" NumberOfVerts=\"0\" NumberOfPolys=\"1\"><PointData>" +
          array +
          "format=\"ascii\">1 2 3</DataArray></PointData><Points><DataArray type=\"Float32\" "
          "NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Polys>"
          "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray>"
          "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3</DataArray></Polys>"
          "</Piece></PolyData></VTKFile>\n",
  };
}

// Parts of pictures, as they are written: one with runs, one without.
inline std::vector<std::string> picture_part_seeds() {
  std::vector<std::string> seeds;
  for (const bool has_runs : {true, false}) {
    PicturePart part;
    part.picture = "size 3x2\n";
    part.count = 2;
    part.look.transfer_function.colors = {{0, {0, 0, 0}}, {1, {1, 1, 1}}};
    part.seen.width = 3;
    part.seen.height = 2;
    part.seen.first.assign(7, 0);
    if (has_runs) {
      part.seen.first = {0, 0, 2, 2, 3, 3, 3};
      part.seen.runs = {{-20, -3, {0.1F, 0.2F, 0.3F, 0.4F}, 3, 2.5F, 1},
                        {-3, 40, {0.5F, 0.25F, 0, 1}, 7, 6, 1},
                        {1, 2, {1, 1, 0, 1}, 1, 1, 0.5F}};
    }
    const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                       ("ovoid_seed_" + std::to_string(::getpid()) + ".exr");
    write_picture_part(part, path.string());
    std::ifstream stream(path, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    std::filesystem::remove(path);
  }
  return seeds;
}

// Regions, a table, ParaView's boxes, a grid of RGBA.
inline std::vector<std::string> look_2d_seeds() {
  return {
      R"({"Regions":[{"Values":[0,10],"Gradients":[0,5],"Color":[1,0,0],"Opacity":0.5,"Softness":0.25,"Foot":0.5},)"
      R"({"Shape":"Gaussian","Values":[-1,3],"Gradients":[1,2]}]})",
      R"({"Values":[0,1],"Gradients":[0,2],"Size":[2,2],"RGBA":[1,0,0,1,0,1,0,0.5,0,0,1,0.25,1,1,1,0]})",
      R"([{"Name":"a","Points":[0,0,0.5,0],"TransferFunction2D":{"Regions":[{"Values":[0,1],"Gradients":[0,1]}]}}])",
      R"(<ParaView><Proxy group="transfer_2d_functions" type="TransferFunction2D" id="2">)"
      R"(<Property name="Boxes" number_of_elements="8"><Element index="0" value="10"/>)"
      R"(<Element index="1" value="2"/><Element index="2" value="30"/><Element index="3" value="4"/>)"
      R"(<Element index="4" value="1"/><Element index="5" value="0.5"/><Element index="6" value="0"/>)"
      R"(<Element index="7" value="0.25"/></Property></Proxy></ParaView>)",
      "NRRD0004\ntype: float\ndimension: 4\nsizes: 4 2 2 1\nkinds: vector domain domain domain\n"
      "space dimension: 3\nspace directions: none (10,0,0) (0,3,0) (0,0,1)\n"
      "space origin: (5,1,0)\nencoding: ascii\n\n1 0 0 0.5 0 1 0 0.5 0 0 1 0.25 1 1 1 1\n"};
}

// Slicer's table and segmentation, ITK-SNAP's, FreeSurfer's, BIDS', and rows.
inline std::vector<std::string> label_table_seeds() {
  return {"# Color table file\n1 skin 255 128 0 255\n2 left_lung 0 0 255 128\n",
          "NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 1 1 1\nencoding: raw\n"
          "Segment0_LabelValue:=1\nSegment0_Layer:=0\nSegment0_Color:=1 0 0\nSegment0_Name:=a\n"
          "Segment1_LabelValue:=3\nSegment1_Layer:=1\nSegment1_Color:=0 0.5 1\n\n12",
          "    0     0    0    0        0  0  0    \"Clear Label\"\n"
          "    1   255    0    0      0.5  1  1    \"a \\ b\"\n",
          "#No. Label Name:  R G B A\n0 Unknown 0 0 0 0\n1004 ctx-lh 25 100 40 0\n",
          "index\tname\tcolor\n1\tone\t#ff0000\n2\ttwo\tn/a\n",
          "1 Precentral_L 2001\n-5 minus\n"};
}

inline std::vector<std::string> look_seeds() {
  return {
      R"([{"Name":"a","ColorSpace":"Diverging","RGBPoints":[0,0.1,0.2,0.3,0.5,1,1,1,1,0.7,0,0],"Points":[0,0,0.5,0,1,1,0.2,0.8],)"
      R"("NanColor":[1,1,0],"ScalarOpacityUnitDistance":2.5}])",
      R"([{"Name":"b","ColorSpace":"HSV","RGBPoints":[-1000,0,0,0,3000,1,1,1]},{"Name":"c","ColorSpace":"Lab","RGBPoints":[1,1,0,0,1,0,0,1]}])",
      R"({"Name":"d","ColorSpace":"Step","RGBPoints":[0,0,0,0,1,1,1,1],"Points":[]})",
      R"({"Name":"e","ColorSpace":"Lab/CIEDE2000","UseLogScale":1,"RGBPoints":[1,1,0,0,1000,0,0,1],"UseBelowRangeColor":1,"BelowRangeColor":[0,0,0]})",
      R"({"Name":"f","IndexedColors":[1,0,0,0,1,0],"Annotations":["0","a","7","b"],"Points":[0,0,0.5,0]})",
      R"({"Points":[-5,0,0.5,0,5,1,0.5,0],"SymlogLinearWidth":0.1,"GradientOpacityPoints":[0,0,0.5,0,9,1,0.5,0],"Shade":false,"Ambient":0.3,"Lights":[{"Direction":[1,0,-2],"Intensity":0.4},{"Direction":[0,1,0]}]})",
      R"({"@schema":"s","volumeProperties":[{"components":[{"shade":true,"lighting":{"ambient":0.2,"specularPower":5},)"
      R"("rgbTransferFunction":{"points":[{"x":0,"color":[0,0,0],"midpoint":0.3,"sharpness":0.5},{"x":9,"color":[1,1,1]}]},)"
      R"("scalarOpacity":{"points":[{"x":0,"y":0},{"x":9,"y":1}]},"gradientOpacity":{"points":[{"x":0,"y":0}]},"scalarOpacityUnitDistance":1}]}]})",
      "1\n1\n0.9\n0.1\n0.2\n10\n4 -100 0 300 0.75\n4 0 0 255 1\n8 -100 0 0 0 300 1 0.5 0.25\n",
      "<ColorMaps><ColorMap name=\"a&amp;b\" space=\"Lab\"><Point x=\"0\" o=\"0.5\" r=\"1\" "
      "g=\"0\" b=\"0\"/>"
      "<Point x=\"1\" o=\"1\" r=\"0\" g=\"0\" b=\"1\"/><NaN r=\"0\" g=\"0\" "
      "b=\"0\"/></ColorMap></ColorMaps>",
      "<ColorMap indexedLookup=\"1\" space=\"Lab/CIEDE2000\"><Point x='0' r='1' g='0' "
      "b='0'/></ColorMap>",
      "<MRML><VolumeProperty name=\"p\" shade=\"1\" ambient=\"0.1\" scalarOpacity=\"4 0 0 9 1\" "
      "gradientOpacity=\"4 0 0 9 1\" colorTransfer=\"4 0 1 0 0\"/></MRML>",
      "<InviwoWorkspace><Points><Point><pos content=\"0\"/><rgba x=\"1\" y=\"0\" z=\"0\" "
      "w=\"0.5\"/></Point></Points></InviwoWorkspace>",
      "# rows\n0 0.25 #ff8000\n10 1 #0000ff\n",
      "0,0,0,0,0.5,1,0,0,1,1,1,1",
      "0 0\n0.5 1\n1 0\n",
      "0 1 0 0 0.25\n1 0 1 0 0.75\n",
  };
}

// A grid of 2 x 1 x 1 nodes and its solution, little endian, behind the byte that splits them.
inline std::vector<std::string> plot3d_seeds() {
  const auto integer = [](int value) { return std::string{static_cast<char>(value), 0, 0, 0}; };
  const auto numbers = [](int count) {
    std::string bytes;
    for (int i = 0; i < count; ++i) bytes += std::string{0, 0, static_cast<char>(i), 0x40};
    return bytes;
  };
  const auto record = [&](const std::string& bytes) {
    return integer(static_cast<int>(bytes.size())) + bytes +
           integer(static_cast<int>(bytes.size()));
  };
  const std::string dims = integer(2) + integer(1) + integer(1);
  const auto joined = [](const std::string& grid, const std::string& solution) {
    for (unsigned byte = 0; byte < 256; ++byte) {
      if ((grid.size() + solution.size()) * byte / 255 == grid.size())
        return static_cast<char>(byte) + grid + solution;
    }
    return std::string();
  };
  return {joined(dims + numbers(6), dims + numbers(14)),
          joined(dims + numbers(6) + integer(1) + integer(-1), dims + numbers(14)),
          joined(integer(1) + dims + numbers(6), integer(1) + dims + numbers(14)),
          joined(record(dims) + record(numbers(6)),
                 record(dims) + record(numbers(4)) + record(numbers(10)))};
}

inline std::vector<std::string> netcdf_header_seeds() {
  const auto word = [](int value) { return std::string{0, 0, 0, static_cast<char>(value)}; };
  const std::string dims = word(10) + word(2) + word(1) + "n" + std::string(3, '\0') + word(3) +
                           word(1) + "t" + std::string(3, '\0') + word(0);
  const std::string attributes = word(12) + word(1) + word(11) + "api_version" +
                                 std::string(1, '\0') + word(2) + word(2) + "hi" +
                                 std::string(2, '\0');
  const std::string variable = word(1) + "v" + std::string(3, '\0') + word(2) + word(1) + word(0) +
                               word(0) + word(0) + word(6) + word(24);
  const std::string start = word(2) + dims + attributes + word(11) + word(1) + variable;
  return {"CDF\x01" + start + word(100) + std::string(200, '\0'),
          "CDF\x02" + start + word(0) + word(100) + std::string(200, '\0'),
          "\x89HDF\r\n\x1a\n" + std::string("\0\0\0\0\0\x08\x08\0", 8) + std::string(112, '\0')};
}

// A triangle that a node moves: binary, and as text with its numbers in it.
inline std::vector<std::string> gltf_seeds() {
  const auto number = [](std::size_t value) {
    std::string bytes;
    for (int i = 0; i < 4; ++i, value >>= 8U)
      bytes += static_cast<char>(static_cast<unsigned char>(value & 0xffU));
    return bytes;
  };
  const auto text = [](const std::string& uri) {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
           R"("nodes":[{"children":[1]},{"mesh":0,"translation":[10,0,0]}],)"
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)"
           R"("min":[0,0,0],"max":[1,1,0]},)"
           R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],)"
           R"("bufferViews":[{"buffer":0,"byteLength":36},)"
           R"({"buffer":0,"byteOffset":36,"byteLength":6}],)"
           R"("buffers":[{)" +
           uri + R"("byteLength":42}]})";
  };
  std::string json = text("");
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string numbers(44, '\0');
  const float one = 1;
  std::memcpy(numbers.data() + 12, &one, sizeof(one));  // (1 0 0)
  std::memcpy(numbers.data() + 28, &one, sizeof(one));  // (0 1 0)
  numbers[38] = 1;
  numbers[40] = 2;
  const std::string chunks = number(json.size()) + "JSON" + json + number(numbers.size()) +
                             std::string("BIN\0", 4) + numbers;
  return {"glTF" + number(2) + number(12 + chunks.size()) + chunks,
          text(R"("uri":"data:application/octet-stream;base64,)" + std::string(16, 'A') +
               R"(AACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA",)")};
}

// A grid, and another that shares its tree; and a file without offsets.
inline std::vector<std::string> vdb_header_seeds() {
  const auto number = [](std::uint64_t value, std::size_t size) {
    std::string bytes;
    for (std::size_t i = 0; i < size; ++i, value >>= 8U)
      bytes += static_cast<char>(static_cast<unsigned char>(value & 0xffU));
    return bytes;
  };
  const auto text = [&](const std::string& words) { return number(words.size(), 4) + words; };
  const auto metadata = [&](const std::string& name) {
    return number(1, 4) + text(name) + text("string") + text("level set");
  };
  const auto begin = [&](char has_offsets) {
    return std::string(" BDV\0\0\0\0", 8) + number(224, 4) + number(10, 4) + number(0, 4) +
           has_offsets + std::string(36, 'a') + metadata("creator");
  };
  std::string file = begin(1) + number(2, 4);
  for (const std::string& parent : {std::string(), std::string("density")}) {
    const std::string words = text(parent.empty() ? "density"
                                                  : "a\x1e"
                                                    "1") +
                              text("Tree_float_5_4_3") + text(parent);
    const std::string data = number(6, 4) + metadata("class") + std::string(20, 'b');
    const std::size_t at = file.size() + words.size() + 24;
    file += words + number(at, 8) + number(parent.empty() ? at + 20 : 0, 8) +
            number(at + data.size(), 8) + data;
  }
  return {file, begin(0) + std::string(60, 'c')};
}

inline std::vector<std::string> camera_seeds() {
  return {
      R"({"position":[0,0,5],"focal_point":[0,0,0],"view_up":[0,1,0],"parallel_projection":true,"parallel_scale":2,"view_angle":30})",
      R"({"position":[1e6,-2.5,3],"view_angle":45.5})",
  };
}

inline std::vector<std::string> point_text_seeds() {
  std::string by_line = "# x,y,z\n";
  for (int line = 0; line < 3; ++line) {
    for (int i = 0; i < 14; ++i) by_line += std::to_string(i * line) + ".5,";
    by_line.back() = '\n';
  }
  return {
      "x [kpc],y,z,velocity:0,velocity:1,velocity:2,name,\"rho, gas\"\n"
      "1,2,3,4e-3,5,+6,\"a,b\",nan\n1.5,2,-3,4,5,6,c,\n7,8,9,1,2,3,d,1D+02,\n",
      "# a comment\n1 2 3\n\n 4\t5 6\r\n7 8 9",
      "1;2;3;4\n5;6;7;8\n",
      by_line,
      gzip("Points:0,Points:1,Points:2,id\n1,2,3,4\n5,6,7,8\n"),
      bzip2("1,2,3\n4,5,6\n"),
  };
}

// One entry of a zip file, and its part of the directory.
struct ZipPiece {
  std::string local, central;
};

inline ZipPiece zip_piece(const std::string& name, const std::string& content, bool is_deflated,
                          std::size_t offset) {
  const auto number = [](std::size_t value, int size) {
    std::string bytes;
    for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
    return bytes;
  };
  const std::string packed = is_deflated ? deflated(content, -15) : content;
  const auto* const bytes = reinterpret_cast<const Bytef*>(content.data());
  const std::size_t crc = crc32(0, bytes, static_cast<uInt>(content.size()));
  const std::string common = number(20, 2) + number(0, 2) + number(is_deflated ? 8 : 0, 2) +
                             number(0, 4) + number(crc, 4) + number(packed.size(), 4) +
                             number(content.size(), 4) + number(name.size(), 2) + number(0, 2);
  return {"PK\x03\x04" + common + name + packed,
          "PK\x01\x02" + number(20, 2) + common + std::string(10, '\0') + number(offset, 4) + name};
}

// A zip file as other programs write it, without 64-bit sizes.
inline std::string zip_file(const std::vector<std::pair<std::string, std::string>>& entries,
                            bool is_deflated) {
  std::string locals, directory;
  for (const auto& [name, content] : entries) {
    const ZipPiece piece = zip_piece(name, content, is_deflated, locals.size());
    locals += piece.local;
    directory += piece.central;
  }
  std::string end(18, '\0');
  const auto put = [&](std::size_t at, std::size_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) end[at + i] = static_cast<char>(value >> (8 * i) & 0xff);
  };
  put(4, entries.size(), 2);
  put(6, entries.size(), 2);
  put(8, directory.size(), 4);
  put(12, locals.size(), 4);
  return locals + directory + "PK\x05\x06" + end;
}

inline std::vector<std::string> npz_seeds() {
  const std::int64_t points[] = {3, 3}, rows[] = {3};
  const std::string positions = io::npy_header(ScalarType::kFloat32, points) + samples(36);
  const std::string radii = io::npy_header(ScalarType::kUInt16, rows) + samples(6);
  return {zip_file({{"positions.npy", positions}, {"radii.npy", radii}, {"text", "no"}}, false),
          zip_file({{"radii.npy", radii}, {"pos.npy", positions}}, true)};
}

inline std::vector<std::string> ply_seeds() {
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  std::string kernel = "ply\nformat binary_little_endian 1.0\nelement vertex 2\n" + xyz;
  for (const char* const name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1",
                                 "rot_2", "rot_3", "weight", "f_dc_0"})
    kernel += std::string("property float ") + name + "\n";
  return {
      "ply\nformat ascii 1.0\ncomment a\nelement vertex 2\n" + xyz + "property uchar red\n" + face +
          "end_header\n0 0 0 255\n1 2.5 -3e1 0\n3 0 1 0\n",
      kernel + "end_header\n" + samples(104),
      "ply\nformat binary_big_endian 1.0\n" + face + "element vertex 2\n" + xyz +
          "property double d\nend_header\n" + std::string("\x02\0\0\0\x01\0\0\0\x02", 9) +
          samples(40),
  };
}

inline std::vector<std::string> lammps_seeds() {
  const std::string frame =
      "ITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 10\n0 10\n-1 "
      "1e1\nITEM: ATOMS id type element xs ys zs vx\n1 1 H 0.5 0.5 0.5 1\n2 1 O 0.25 0 0.75 2\n";
  const std::string tilted =
      "ITEM: UNITS\nmetal\nITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS xy xz yz "
      "pp "
      "pp ff\n0 3 1\n0 2 0\n0 2 0.5\nITEM: ATOMS xu yu zu q\n1 2 3 4\n";
  return {frame + frame, tilted, gzip(frame), bzip2(frame + tilted)};
}

inline std::vector<std::string> relevant_runs_seeds() {
  // 10 x 4: a row of two runs, of none, of one that fills it, of one.
  const std::string runs{2, 0, 1, 1, 0, 5, 0, 3, 2, 3, 10, 1};
  return {std::string{9, 3, 4} + runs + samples(16),
          std::string{0, 0, 1} + std::string("\x01\0\x01x", 4)};
}

// One of each kind; none in a build without HDF5.
inline std::vector<std::string> hdf5_lattice_seeds() {
  std::vector<std::string> seeds;
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("ovoid_seed_" + std::to_string(::getpid()) + ".h5");
  const std::string bytes = samples(2 * 4 * 3 * 2 * 2);
  const auto keep = [&] {
    std::ifstream stream(path, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  };
  const auto add = [&](LatticeKind kind, SeriesKind series, std::vector<double> times,
                       bool is_runs = false) {
    LatticeFileHeader header;
    header.lattice = {{4, 3, 2}, Affine3::Identity(), kind};
    header.series = series;
    header.arrays = {{"a", ScalarType::kInt16, 1, "K", 0.5, 1},
                     {"b", ScalarType::kUInt8, 2, "", 1, 0}};
    header.times = std::move(times);
    if (is_runs) {
      header.arrays.pop_back();
      header.relevant = RelevantSamples{5000, -1};
    }
    LatticeFileWriter writer(path.string(), header);
    const Bytes all{nullptr, std::as_bytes(std::span(bytes).first(48))};
    for (std::size_t step = 0; step < std::max<std::size_t>(header.times.size(), 1); ++step)
      writer.write_step(std::vector<Bytes>(header.arrays.size(), all));
    writer.finish();
    keep();
  };
  try {
    add(LatticeKind::kCartesian, SeriesKind::kSteps, {});
    add(LatticeKind::kBodyCentred, SeriesKind::kSteps, {});
    add(LatticeKind::kCartesian, SeriesKind::kSteps, {0, 1, 5});
    add(LatticeKind::kCartesian, SeriesKind::kStaggered, {0, 1});
    add(LatticeKind::kCartesian, SeriesKind::kStaggered, {0, 1}, true);
    LatticeFileHeader header;
    header.lattice = {{4, 3, 2}, Affine3::Identity(), LatticeKind::kCartesian};
    header.arrays = {{}};
    header.content = LatticeContent::kLevels;
    LatticeFileWriter writer(path.string(), header);
    LatticeLevels levels{
        {4, 3, 2},   1, 0, 9, false, 0.5, {{{1, 5, 22}, {7, -2, 900}}, {{0, 1}, {3, 4}}},
        {2, 3, 4, 1}};
    writer.write_levels({&levels, 1});
    writer.finish();
    keep();
    header.content = LatticeContent::kBoxes;
    LatticeFileWriter other(path.string(), header);
    LatticeBoxes boxes{
        {4, 3, 2}, 0, 9, 1, false, 0.5, {{1, {2, 2, 2}, 7, {1, -2, 900}}, {3, {3, 1, 1}, 3, {}}}};
    other.write_boxes({&boxes, 1});
    other.finish();
    keep();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUnsupported) throw;
  }
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  return seeds;
}

}  // namespace ovoid::fuzz
