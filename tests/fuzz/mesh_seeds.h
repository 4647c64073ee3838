// SPDX-License-Identifier: Apache-2.0
// Seeds of meshes, and of headers that are checked before a library reads the file.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "fuzz/seed_bytes.h"

namespace ovoid::fuzz {

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

}  // namespace ovoid::fuzz
