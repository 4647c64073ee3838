// SPDX-License-Identifier: Apache-2.0
// Seeds of particles and stored kernels.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "fuzz/seed_bytes.h"
#include "io/images/npy.h"

namespace ovoid::fuzz {

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

}  // namespace ovoid::fuzz
