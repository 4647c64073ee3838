// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/lattice_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "io/core/memory.h"
#include "io/core/point_arrays.h"
#include "io/core/samples.h"
#include "io/core/xml_tags.h"
#include "io/meshes/mesh_parts.h"
#include "io/vtk/image_ghosts.h"
#include "io/vtk/vtk_set_files.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

[[noreturn]] void refuse_pieces(const std::string& source, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source, what));
}

// Where the first sample of a piece is in the whole.
Vec3 first_index(const VtkExtent& whole, const VtkExtent& piece) {
  Vec3 first;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    first[axis] = static_cast<double>(piece.lo[a] - whole.lo[a]);
  }
  return first;
}

// Samples, or cells, along each axis of a part of a whole: where the whole has one sample it has a
// cell, a part of one sample elsewhere has none.
Index3 sizes_of(const VtkExtent& whole, const VtkExtent& part, bool are_cells) {
  Index3 sizes = part.dims();
  for (std::size_t a = 0; are_cells && a < 3; ++a)
    if (whole.lo[a] < whole.hi[a]) --sizes[a];
  return sizes;
}

// Rows along x of a piece, by numbers of their first samples: row(in the piece, in the whole).
template <class Row>
void for_each_row(const VtkExtent& whole, const VtkExtent& piece, bool are_cells, const Row& row) {
  const Index3 all = sizes_of(whole, whole, are_cells);
  const Index3 own = sizes_of(whole, piece, are_cells);
  for (std::int64_t z = 0; z < own[2]; ++z) {
    for (std::int64_t y = 0; y < own[1]; ++y) {
      const std::int64_t in_whole =
          ((z + piece.lo[2] - whole.lo[2]) * all[1] + y + piece.lo[1] - whole.lo[1]) * all[0] +
          piece.lo[0] - whole.lo[0];
      row(static_cast<std::size_t>((z * own[1] + y) * own[0]), static_cast<std::size_t>(in_whole));
    }
  }
}

// VTK's mark of samples and cells that are another piece's.
bool is_duplicate(std::byte ghost) {
  static_assert(kDuplicatePoint == kDuplicateCell);
  return (std::to_integer<unsigned>(ghost) & kDuplicatePoint) != 0;
}

std::span<const std::byte> ghosts_of(const Dataset& dataset, bool is_cell_data) {
  for (const DataArray& array : dataset.arrays) {
    if (array.name == kGhostArray && array.is_cell_data == is_cell_data &&
        array.num_components == 1 && size_of(array.type) == 1)
      return array.bytes.view;
  }
  return {};
}

}  // namespace

LatticeInPieces lattice_in_pieces(const ByteSource& source) {
  LatticeInPieces layout;
  XmlTagReader reader(source);
  auto tag = reader.next();
  while (tag && tag->name != "PImageData" && tag->name != "PRectilinearGrid") tag = reader.next();
  if (!tag) refuse_pieces(source.name(), "has no element PImageData or PRectilinearGrid");
  layout.is_image = tag->name == "PImageData";
  layout.whole = parse_vtk_extent(source, "WholeExtent", tag->attribute("WholeExtent"));
  checked_num_bytes(source.name() + ": WholeExtent", layout.whole.dims(), ScalarType::kUInt8);
  for (VtkSetFile& file : vtk_set_files(source)) {
    const VtkExtent extent = parse_vtk_extent(source, "Piece: Extent", file.extent);
    if (num_samples(extent.dims()) == 0) continue;
    if (!layout.whole.contains(extent)) {
      refuse_pieces(source.name(), fmt::format("Piece: Extent=\"{}\": lies outside WholeExtent",
                                               file.extent.substr(0, 80)));
    }
    layout.pieces.push_back({std::move(file.path), extent});
  }
  return layout;
}

LatticeAssembly::LatticeAssembly(std::string source, LatticeInPieces layout)
    : source_(std::move(source)), layout_(std::move(layout)) {}

// The first piece says where the whole is: what is said beside its extent may lack directions, and
// of rectilinear grids coordinates.
bool LatticeAssembly::lies_in_lattice(const LatticePiece& piece, const LatticeGeometry& lattice) {
  const Vec3 first = first_index(layout_.whole, piece.extent);
  if (num_pieces_ == 0) {
    const Index3 own = piece.extent.dims(), all = layout_.whole.dims();
    for (std::size_t a = 0; a < 3; ++a) {
      // A single layer of coordinates does not tell how far others are.
      if (!layout_.is_image && own[a] == 1 && all[a] > 1) return false;
    }
    lattice_ = lattice;
    lattice_.dims = all;
    lattice_.world_from_index.translate(-first);
    return true;
  }
  constexpr double kSame = 1e-3;  // spacings
  const Affine3& whole = lattice_.world_from_index;
  const double spacing = lattice_.spacing().minCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t length = lattice.dims[static_cast<std::size_t>(axis)] - 1;
    if (length < 1) continue;
    const Vec3 step = lattice.world_from_index.linear().col(axis) - whole.linear().col(axis);
    if (!(step.norm() * static_cast<double>(length) <= kSame * spacing)) return false;
  }
  return (lattice.world_from_index.translation() - whole * first).norm() <= kSame * spacing;
}

// Where an array of a piece goes; null if the first piece of its kind did not have it.
LatticeAssembly::Whole* LatticeAssembly::whole_of(const DataArray& array, bool is_first) {
  const auto found = std::find_if(arrays_.begin(), arrays_.end(), [&](const Whole& whole) {
    return whole.array.name == array.name && whole.array.is_cell_data == array.is_cell_data;
  });
  if (found != arrays_.end()) return &*found;
  if (!is_first) return nullptr;
  Whole whole;
  whole.array = array;
  whole.array.bytes = {};
  const Index3 sizes = sizes_of(layout_.whole, layout_.whole, array.is_cell_data);
  whole.array.num_tuples = num_samples(sizes);
  const std::string name = fmt::format("{}: array '{}'", source_, array.name);
  require_memory(name, checked_num_bytes(name, sizes, array.type, array.num_components));
  whole.array = new_array(std::move(whole.array), whole.to);
  arrays_.push_back(std::move(whole));
  return &arrays_.back();
}

void LatticeAssembly::take(const LatticePiece& piece, const Dataset& dataset, bool is_cell_data) {
  const Index3 sizes = sizes_of(layout_.whole, piece.extent, is_cell_data);
  if (num_samples(sizes) == 0) return;  // a layer of samples has no cells of the whole
  std::vector<bool>& come = is_cell_data ? cells_come_ : points_come_;
  const std::span<const std::byte> ghosts = ghosts_of(dataset, is_cell_data);
  const auto length = static_cast<std::size_t>(sizes[0]);
  const bool is_first = come.empty();
  bool has_any = false;
  for (const DataArray& array : dataset.arrays) {
    if (array.is_cell_data != is_cell_data || is_ghost_array(array)) continue;
    Whole* const whole = whole_of(array, is_first);
    if (whole == nullptr) {
      leaves_arrays_out_ = true;
      continue;
    }
    has_any = true;
    if (whole->array.type != array.type || whole->array.num_components != array.num_components) {
      refuse_pieces(piece.path, fmt::format("array '{}': {} x {}: the piece '{}' has {} x {}",
                                            array.name, name_of(array.type), array.num_components,
                                            layout_.pieces.front().path, name_of(whole->array.type),
                                            whole->array.num_components));
    }
    ++whole->num_pieces;
    const std::size_t size = size_of(array.type) * static_cast<std::size_t>(array.num_components);
    for_each_row(layout_.whole, piece.extent, is_cell_data, [&](std::size_t from, std::size_t to) {
      const std::byte* const source = array.bytes.view.data() + from * size;
      if (ghosts.empty()) {
        std::memcpy(whole->to + to * size, source, length * size);
        return;
      }
      for (std::size_t i = 0; i < length; ++i) {
        if (is_duplicate(ghosts[from + i]) && !is_first && come[to + i]) continue;
        std::memcpy(whole->to + (to + i) * size, source + i * size, size);
      }
    });
  }
  if (!has_any && ghosts.empty()) return;
  mark(piece, ghosts, is_cell_data);
}

// That the piece has come, and what is hidden of it.
void LatticeAssembly::mark(const LatticePiece& piece, std::span<const std::byte> ghosts,
                           bool is_cell_data) {
  std::vector<bool>& come = is_cell_data ? cells_come_ : points_come_;
  std::vector<std::byte>& all = is_cell_data ? cell_ghosts_ : point_ghosts_;
  const auto count =
      static_cast<std::size_t>(num_samples(sizes_of(layout_.whole, layout_.whole, is_cell_data)));
  if (come.empty()) come.resize(count);
  if (!ghosts.empty() && all.empty()) all.resize(count);
  const auto length =
      static_cast<std::size_t>(sizes_of(layout_.whole, piece.extent, is_cell_data)[0]);
  for_each_row(layout_.whole, piece.extent, is_cell_data, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = 0; i < length; ++i) {
      const std::byte ghost = ghosts.empty() ? std::byte{0} : ghosts[from + i];
      const bool is_anothers = is_duplicate(ghost) && come[to + i];
      if (!all.empty() && !is_anothers) all[to + i] = ghost;
      come[to + i] = true;
    }
  });
}

DataArray LatticeAssembly::ghost_array(bool is_cell_data) {
  DataArray array;
  array.name = kGhostArray;
  array.type = ScalarType::kUInt8;
  array.is_cell_data = is_cell_data;
  std::vector<std::byte>& all = is_cell_data ? cell_ghosts_ : point_ghosts_;
  array.num_tuples = std::ssize(all);
  array.bytes = bytes_owning(std::move(all));
  return array;
}

bool LatticeAssembly::add(std::size_t index, const Dataset& dataset) {
  const LatticePiece& piece = layout_.pieces[index];
  if (dataset.kind != DatasetKind::kLattice) return false;
  if (dataset.lattice.dims != piece.extent.dims()) {
    refuse_pieces(piece.path, fmt::format("is {}: '{}' says {}", dims_text(dataset.lattice.dims),
                                          source_, dims_text(piece.extent.dims())));
  }
  if (!lies_in_lattice(piece, dataset.lattice)) return false;
  for (const bool is_cell_data : {false, true}) take(piece, dataset, is_cell_data);
  if (num_pieces_++ == 0) times_ = dataset.times;
  for (const std::string& note : dataset.notes)
    if (notes_.size() < 100) notes_.push_back(note);
  return true;
}

Dataset LatticeAssembly::finish(Dataset dataset) {
  std::size_t num_whole = 0;
  for (Whole& whole : arrays_) {
    // A piece of no cells has no values for them.
    const bool is_cell_data = whole.array.is_cell_data;
    const auto num_expected = static_cast<std::size_t>(
        std::count_if(layout_.pieces.begin(), layout_.pieces.end(), [&](const LatticePiece& piece) {
          return num_samples(sizes_of(layout_.whole, piece.extent, is_cell_data)) > 0;
        }));
    if (whole.num_pieces < num_expected) {
      leaves_arrays_out_ = true;
      continue;
    }
    ++num_whole;
    const std::vector<bool>& come = is_cell_data ? cells_come_ : points_come_;
    const auto count = std::count(come.begin(), come.end(), true);
    if (count < std::ssize(come)) {
      refuse_pieces(source_, fmt::format("its pieces hold {} of {} {}", count, come.size(),
                                         is_cell_data ? "cells" : "samples"));
    }
    dataset.arrays.push_back(std::move(whole.array));
  }
  if (num_whole == 0) refuse_pieces(source_, "has no array of numbers that is in all pieces");
  if (leaves_arrays_out_)
    notes_.push_back(fmt::format("{}: arrays that not all pieces have are left out", source_));
  dataset.kind = DatasetKind::kLattice;
  dataset.lattice = lattice_;
  dataset.times = times_;
  dataset.notes.insert(dataset.notes.end(), notes_.begin(), notes_.end());
  if (!point_ghosts_.empty()) dataset.arrays.push_back(ghost_array(false));
  if (!cell_ghosts_.empty()) dataset.arrays.push_back(ghost_array(true));
  hide_ghosts(dataset);
  shorten_notes(dataset.notes);
  return dataset;
}

}  // namespace ovoid::io
