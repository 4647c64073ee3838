// SPDX-License-Identifier: Apache-2.0
// Lattices in pieces, a file each: images (.pvti), and rectilinear grids (.pvtr) of equal spacing.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/vtk/vtk_extent.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// A piece that is not empty.
struct LatticePiece {
  std::string path;
  VtkExtent extent;  // of its samples, ghosts included, within that of the whole
};

// What the file says that names the pieces.
struct LatticeInPieces {
  bool is_image = true;  // else a rectilinear grid
  VtkExtent whole;
  std::vector<LatticePiece> pieces;
};

// Throws Error(kFileFormat) for extents that are none, a whole without samples, pieces beyond it.
LatticeInPieces lattice_in_pieces(const ByteSource& source);

// Puts the pieces together, as they come.
class LatticeAssembly {
 public:
  LatticeAssembly(std::string source, LatticeInPieces layout);

  const std::vector<LatticePiece>& pieces() const noexcept { return layout_.pieces; }

  // Takes over what was read of piece `index`; arrays named kGhostArray say which of its samples
  // are another's, whose values are then taken, and which are hidden. False if it does not lie in
  // one lattice with those before, as rectilinear grids of unequal spacing: nothing can then be put
  // together. Throws Error: kFileFormat if a piece is not what the whole says of it, kOutOfMemory.
  bool add(std::size_t index, const Dataset& dataset);

  // The whole: arrays that every piece has, and a note on others; what is hidden is missing
  // (hide_ghosts). Throws Error(kFileFormat) if
  // samples are in no piece, or no array is in all.
  Dataset finish(Dataset dataset);

 private:
  struct Whole {
    DataArray array;
    std::byte* to = nullptr;
    std::size_t num_pieces = 0;  // that have it
  };

  bool lies_in_lattice(const LatticePiece& piece, const LatticeGeometry& lattice);
  Whole* whole_of(const DataArray& array, bool is_first);
  void take(const LatticePiece& piece, const Dataset& dataset, bool is_cell_data);
  void mark(const LatticePiece& piece, std::span<const std::byte> ghosts, bool is_cell_data);
  DataArray ghost_array(bool is_cell_data);

  std::string source_;
  LatticeInPieces layout_;
  LatticeGeometry lattice_;  // once a piece has come
  std::vector<Whole> arrays_;
  std::vector<bool> points_come_, cells_come_;  // from some piece; empty without arrays of theirs
  std::vector<std::byte> point_ghosts_, cell_ghosts_;  // VTK's bits; empty: no piece has any
  std::size_t num_pieces_ = 0;                         // that have come
  bool leaves_arrays_out_ = false;
  std::vector<std::string> notes_;
  std::vector<double> times_;
};

}  // namespace ovoid::io
