// SPDX-License-Identifier: Apache-2.0
// Seeds of volumes and series of slices.
#pragma once

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "fuzz/seed_bytes.h"
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
  const auto with = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const auto even_piece = [&](const std::string& origin) {
    return io::xdmf_grid(with(io::kXdmfEven, "30 20 10", origin) + values(24));
  };
  const std::string entity =
      with(io::xdmf_file(io::xdmf_grid("<Information><![CDATA[<a>]]></Information>" +
                                       with(io::kXdmfEven, "30 20 10", "&origin;") + values(24))),
           "[]", "[<!ENTITY ten \"10\"><!ENTITY origin \"30 20 &ten;\">]");
  return {
      io::xdmf_file(io::xdmf_grid(io::kXdmfEven + values(24))),
      io::xdmf_file(io::xdmf_grid(io::kXdmfEven + io::xdmf_attribute("f", raw))),
      io::xdmf_file(io::xdmf_grid(rectilinear + io::xdmf_attribute("f", io::xdmf_slab()))),
      io::xdmf_file(io::xdmf_series()),
      io::xdmf_file(io::xdmf_grid(
          io::kXdmfEven + io::xdmf_attribute("v", io::xdmf_join(), "AttributeType=\"Vector\""))),
      io::xdmf_file(io::xdmf_grid(mesh + mesh, pieces)),
      io::xdmf_file(io::xdmf_grid(even_piece("30 20 10") + even_piece("30 20 11.5"), pieces)),
      io::xdmf_file(io::xdmf_grid(even_piece("30 20 10") + even_piece("30 20 99"), pieces)),
      entity,
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
