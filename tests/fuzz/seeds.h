// SPDX-License-Identifier: Apache-2.0
// Small valid inputs for each family of readers, made here: where fuzzing and the mutation test
// start from.
#pragma once

#include <bzlib.h>
#include <zlib.h>

#include <cstdint>
#include <string>
#include <vector>

#include "io/npy.h"

namespace ovoid::fuzz {

// zlib's own container for 15 window bits, gzip's for 16 more.
inline std::string deflated(const std::string& data, int window_bits) {
  std::string out(data.size() + 1000, '\0');
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = static_cast<uInt>(data.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

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
  };
}

inline std::vector<std::string> look_seeds() {
  return {
      R"([{"Name":"a","ColorSpace":"Diverging","RGBPoints":[0,0.1,0.2,0.3,0.5,1,1,1,1,0.7,0,0],"Points":[0,0,0.5,0,1,1,0.2,0.8],)"
      R"("NanColor":[1,1,0],"ScalarOpacityUnitDistance":2.5}])",
      R"([{"Name":"b","ColorSpace":"HSV","RGBPoints":[-1000,0,0,0,3000,1,1,1]},{"Name":"c","ColorSpace":"Lab","RGBPoints":[1,1,0,0,1,0,0,1]}])",
      R"({"Name":"d","ColorSpace":"Step","RGBPoints":[0,0,0,0,1,1,1,1],"Points":[]})",
      R"({"Name":"e","ColorSpace":"Lab/CIEDE2000","UseLogScale":1,"RGBPoints":[1,1,0,0,1000,0,0,1],"UseBelowRangeColor":1,"BelowRangeColor":[0,0,0]})",
      R"({"Name":"f","IndexedColors":[1,0,0,0,1,0],"Annotations":["0","a","7","b"],"Points":[0,0,0.5,0]})",
      R"({"Points":[-5,0,0.5,0,5,1,0.5,0],"SymlogLinearWidth":0.1,"GradientOpacityPoints":[0,0,0.5,0,9,1,0.5,0],"Shade":false,"Ambient":0.3})",
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

inline std::vector<std::string> camera_seeds() {
  return {
      R"({"position":[0,0,5],"focal_point":[0,0,0],"view_up":[0,1,0],"parallel_projection":true,"parallel_scale":2,"view_angle":30})",
      R"({"position":[1e6,-2.5,3],"view_angle":45.5})",
  };
}

}  // namespace ovoid::fuzz
