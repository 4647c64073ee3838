// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/kernels.h"
#include "ovoid/lattice.h"

namespace OVOID_API ovoid {

// Bytes that are owned, or borrowed from a caller who keeps them alive through `owner`. Cheap to
// copy, immutable.
struct Bytes {
  // What keeps `view` valid; may be empty for memory that outlives the library's use.
  std::shared_ptr<const void> owner;
  std::span<const std::byte> view;
};

// Values in a row, immutable and shared: copies share the memory. Made of a vector, whose values it
// takes over, or of memory that `owner` keeps valid.
template <typename T>
class SharedValues {
 public:
  SharedValues() = default;
  SharedValues(std::vector<T> values) {  // NOLINT(google-explicit-constructor): as a vector is
    const auto owner = std::make_shared<const std::vector<T>>(std::move(values));
    view_ = *owner;
    owner_ = owner;
  }
  SharedValues(std::initializer_list<T> values) : SharedValues(std::vector<T>(values)) {}
  SharedValues(std::shared_ptr<const void> owner, std::span<const T> view)
      : owner_(std::move(owner)), view_(view) {}

  std::span<const T> view() const noexcept { return view_; }
  operator std::span<const T>() const noexcept {
    return view_;
  }  // NOLINT(google-explicit-constructor)
  std::size_t size() const noexcept { return view_.size(); }
  bool empty() const noexcept { return view_.empty(); }
  const T& operator[](std::size_t i) const noexcept { return view_[i]; }
  const T& front() const noexcept { return view_.front(); }
  const T& back() const noexcept { return view_.back(); }
  auto begin() const noexcept { return view_.begin(); }
  auto end() const noexcept { return view_.end(); }
  // A copy, to be changed.
  std::vector<T> to_vector() const { return {view_.begin(), view_.end()}; }
  friend bool operator==(const SharedValues& a, const SharedValues& b) noexcept {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  std::shared_ptr<const void> owner_;
  std::span<const T> view_;
};

// Samples that stay in their file, since memory does not hold them. Immutable; all members are
// called from many threads at once.
class StoredSamples {
 public:
  virtual ~StoredSamples() = default;
  virtual std::int64_t num_bytes() const noexcept = 0;
  // Fills `out` from byte `offset` on, native byte order; both are multiples of a sample's size and
  // within num_bytes(). Throws Error: kFileFormat if the file has shrunk, kFileNotFound if the
  // system cannot read it.
  virtual void read(std::int64_t offset, std::span<std::byte> out) const = 0;
  // How much of them may be kept in memory.
  virtual std::int64_t memory_for_pages() const noexcept = 0;
};

// How a microscope's file says to show a channel [OME]: empty where it says nothing.
struct ChannelDisplay {
  std::optional<std::array<double, 3>> color{};  // red, green, blue: sRGB, 0 to 1
  // Where it begins to show, and where it is as bright as it gets: first < second.
  std::optional<std::array<double, 2>> range{};
};

// One named array of a dataset: `num_tuples` tuples of `num_components` values, component fastest.
struct DataArray {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  int num_components = 1;
  std::int64_t num_tuples = 0;
  std::string unit;  // empty if the file names none
  bool is_cell_data = false;
  Bytes bytes;  // num_tuples * num_components * size_of(type), native byte order
  // What a stored number s stands for: s * value_scale + value_offset (NIfTI's slope and intercept,
  // DICOM's rescale). Finite, value_scale not 0. Everything that shows or takes values applies it.
  double value_scale = 1.0;
  double value_offset = 0.0;
  // Instead of `bytes`, where the reader was allowed to (ReadOptions::may_stay_in_file): one
  // component, a type that lattices show as it is. make_lattice_field() takes such arrays; whatever
  // else looks into `bytes` finds none.
  std::shared_ptr<const StoredSamples> stored{};
  ChannelDisplay display{};

  bool is_scaled() const noexcept { return value_scale != 1.0 || value_offset != 0.0; }
};

// One of several volumes that an input holds: a series of a DICOM folder.
struct DatasetBlock {
  std::string name;         // what ReadOptions::block takes
  std::string description;  // one line for people
};

// The patient coordinate system of medical files. World coordinates are the file's own, nothing is
// flipped.
enum class Space { kNone, kLps, kRas };

const char* name_of(Space space) noexcept;  // "none", "LPS", "RAS"

// A cell's shape by its corners, whose order is VTK's. Quadratic and other curved cells are given
// by their corners (their middle nodes are nodes like others, joined to the corners of their edge);
// polyhedra, polygons and everything else are kOther: all nodes are taken for neighbours.
enum class CellType : std::uint8_t {
  kVertex,
  kLine,
  kTriangle,
  kQuad,
  kTetrahedron,
  kHexahedron,
  kVoxel,
  kWedge,
  kPyramid,
  kQuadraticTetrahedron,
  kQuadraticHexahedron,
  kQuadraticWedge,
  kQuadraticPyramid,
  kTriQuadraticHexahedron,
  kPolyLine,  // a line through its nodes, one after the other
  kOther,
};

// What kind of thing a dataset is; it says which members hold positions.
enum class DatasetKind {
  kLattice,    // `lattice`: a sample at every lattice position
  kMesh,       // `positions`, `cells`: nodes and the cells between them
  kBoxes,      // `positions`, `box_sizes`: centres and edge lengths of axis-aligned cells (AMR)
  kParticles,  // `positions`
  kKernels,  // `positions` and the arrays "scale" (3 sigmas), "rotation" (quaternion w x y z) and,
             // optionally, "weight": kernels as a file stored them
};

const char* name_of(
    DatasetKind kind) noexcept;  // "lattice", "mesh", "boxes", "particles", "kernels"

// What the time steps of an input are to each other.
enum class SeriesKind : std::uint8_t {
  kSteps,      // every step is a dataset that is whole by itself
  kStaggered,  // Cartesian lattices of which every second one is shifted by half of each axis
               // vector: even and odd steps are the two halves of a body-centred lattice in space
               // and time (D4*); neighbouring steps lie T / sqrt(2) apart in time, as the halves do
               // in space
};

const char* name_of(SeriesKind kind) noexcept;  // "steps", "staggered"

// The cells of a mesh. Either explicit: cell c has the nodes connectivity[offsets[c]] to
// connectivity[offsets[c + 1] - 1], in VTK's order for its type. Or structured: `dims` nodes along
// i, j, k (i fastest) with hexahedra between them, and the others are empty.
struct Cells {
  SharedValues<CellType> types;              // [num_cells]
  SharedValues<std::int64_t> offsets;        // [num_cells + 1], rising from 0
  SharedValues<std::uint32_t> connectivity;  // node numbers
  Index3 dims{0, 0, 0};

  bool is_structured() const noexcept { return dims[0] > 0; }
  std::int64_t count() const noexcept;
};

// Which of a file's rows a dataset holds: `first` and those behind it, of `total`. Of a mesh the
// rows are its cells, as its files count them, and it holds fewer where some of them are duplicates
// or hidden; its nodes are those of these cells, and each node of no cell is in one share.
struct DatasetShare {
  std::int64_t first = 0;
  std::int64_t total = 0;
  // kMesh: [num_positions()] which nodes of the whole they are, rising: 2^32 times the number of
  // the piece that has the node, plus its number there. Of nodes that several pieces have at one
  // place those of the first piece count.
  SharedValues<std::uint64_t> nodes{};
  // The array of the whole that is drawn where none is named, once it is agreed upon
  // (agree_on_array()); empty: not yet.
  std::string array{};
};

// What a file says, before any choice of kernels: one lattice, mesh or set of points with its
// arrays. A lattice's samples lie x fastest in memory, then y, then z; a mesh's arrays hold a tuple
// per node, or per cell where `is_cell_data`; the others' a tuple per position.
struct Dataset {
  std::string source;  // path as given, for messages
  std::string format;  // "NRRD", "VTI", ...
  DatasetKind kind = DatasetKind::kLattice;
  LatticeGeometry lattice;              // kLattice only
  DataArray positions;                  // [n, 3] float32 or float64, world units; not scaled
  Cells cells;                          // kMesh only
  DataArray box_sizes;                  // kBoxes only: [n, 3] float64, world units
  std::optional<Bounds3> periodic_box;  // kParticles: opposite faces are the same place
  // kKernels: how they are meant to be summed and cut off, in sigmas, where that is known.
  std::optional<Reconstruction> reconstruction;
  std::optional<double> cutoff;
  // Everything but lattices: set if a share of the rows was asked for (ReadOptions::share), which
  // may be none: positions and arrays have rows [first, first + num_positions()) of the whole, of
  // meshes what DatasetShare says, and all else is the whole's.
  std::optional<DatasetShare> share;
  Space space = Space::kNone;
  std::vector<DataArray> arrays;
  std::vector<DatasetBlock> blocks;        // all volumes of the input; empty if it is one
  std::string block;                       // the one that was read; empty if the input is one
  std::int64_t num_steps = 1;              // time steps that the input holds
  std::int64_t step = 0;                   // the one that was read
  SeriesKind series = SeriesKind::kSteps;  // staggered: `lattice` is that of the step that was read
  std::vector<double> times;               // time values of the steps; empty if the file names none
  std::string time_unit;                   // of the times; empty if the file names none
  std::vector<std::string> notes;          // what a reader assumed or found odd, one line each

  std::int64_t num_positions() const noexcept { return positions.num_tuples; }

  // The array called `name`; empty name: of particles and boxes a density ("density", "rho"), else
  // the first of nodes, samples or points that varies and does no bookkeeping, else the first such
  // of cells, else the first that does none, else the first. Bookkeeping do arrays called "vtk*",
  // numbers of nodes, cells, blocks and particles (GlobalNodeId, ParticleIDs and their like), and
  // the shapes of stored kernels. Throws Error(kInvalidArgument) naming the arrays that exist. Cost
  // of the default: one pass over the arrays looked at. Of a share the default depends on the rows
  // that it holds, unless shares have agreed upon one (agree_on_array()).
  const DataArray& array(const std::string& name = {}) const&;
  DataArray array(const std::string& name = {}) const&& { return array(name); }  // of a temporary
};

}  // namespace ovoid
