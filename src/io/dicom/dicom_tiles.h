// SPDX-License-Identifier: Apache-2.0
// Volumes whose slices are tiles of one picture: the mosaics of Siemens (ImageType MOSAIC) and the
// grids of United Imaging (ImageType VFRAME). Sources: [NIPY mosaic], [NIPY CSA], [dcm2niix UIH].
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::io {

// What the image header of Siemens' CSA (0029,xx10) says that a volume needs.
struct CsaHeader {
  std::optional<double> num_slices;  // NumberOfImagesInMosaic
  std::optional<double> b_value;     // s/mm^2
  std::optional<Vec3> normal;        // SliceNormalVector: from slice to slice
};

// Both versions of the header. What is damaged ends it: what stood before counts.
CsaHeader read_csa_header(std::string_view bytes);

// What a file states about its tiles, whoever has parsed it.
struct StatedTiles {
  bool is_mosaic = false, is_grid = false;  // by ImageType
  std::optional<double> num_slices;         // of a private element
  std::optional<double> num_slice_times;    // MosaicRefAcqTimes has as many
  CsaHeader csa;
  std::vector<std::optional<Vec3>> positions;  // of a grid's slices
};

// How a stored picture is divided. `across` tiles lie in each row of tiles; the first is at the
// top left, the next to its right; behind the last may be empty ones.
struct DicomTiles {
  std::int64_t count = 1, across = 1, down = 1;
  std::string fault;  // why the picture is not divided, for people; empty if nothing is wrong
  std::string note;   // what is odd, for people
};

// `rows`, `columns`, `num_frames`: of the stored pictures. A file that states no tiles has one.
DicomTiles divide_tiles(const StatedTiles& stated, std::int64_t rows, std::int64_t columns,
                        std::int64_t num_frames);

}  // namespace ovoid::io
