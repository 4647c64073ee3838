// SPDX-License-Identifier: Apache-2.0
// VTKHDF's unstructured grids and polygonal data. The numbers of all parts of all steps lie one
// behind the other in each array; counts say how many a part has, and Steps where a step begins.
#ifdef OVOID_IO_HDF5
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data/cell_builder.h"
#include "io/core/point_arrays.h"
#include "io/foreign/vtkhdf_arrays.h"
#include "io/vtk/vtk_cells.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// VTK's numbers of kinds of cells.
constexpr int kPolyVertex = 2, kPolyLine = 4, kStrip = 6, kPolygon = 7, kPixel = 8;

// Cells of one kind of polygonal data, or all of an unstructured grid.
struct VtkHdfTopology {
  VtkHdfGroup group;
  int type = 0;                                  // of all its cells; 0: an array says each one's
  std::vector<std::int64_t> num_cells, num_ids;  // per part of the file
  std::int64_t first_cell = 0, first_id = 0;     // of the step
};

std::int64_t sum_of_counts(const std::vector<std::int64_t>& numbers, std::int64_t first,
                           std::int64_t count) {
  return std::accumulate(numbers.begin() + first, numbers.begin() + first + count, std::int64_t{0});
}

class VtkHdfMeshReader {
 public:
  VtkHdfMeshReader(const VtkHdfGroup& root, bool is_surface, const VtkHdfSteps& steps,
                   const VtkHdfRead& read)
      : root_(root),
        objects_(root.objects()),
        is_surface_(is_surface),
        steps_(steps),
        read_(read) {}

  std::vector<MeshPart> run() {
    num_points_ = root_.counts("NumberOfPoints");
    const auto num_all = static_cast<std::int64_t>(num_points_.size());
    first_part_ = steps_.offset("PartOffsets", read_.step);
    first_point_ = steps_.offset("PointOffsets", read_.step);
    const std::int64_t num_parts = steps_.num_parts(read_.step, num_all);
    if (first_part_ > num_all || num_parts > num_all - first_part_)
      objects_.fail(fmt::format("step {} has {} parts from {} on: the file has {}", read_.step,
                                num_parts, first_part_, num_all));
    find_topologies(num_all);
    std::vector<MeshPart> parts;
    for (std::int64_t part = 0; part < num_parts; ++part) parts.push_back(read_part(part));
    return parts;
  }

 private:
  void find_topologies(std::int64_t num_all) {
    if (!is_surface_) {
      add_topology(root_, 0, 0, num_all);
      return;
    }
    constexpr std::array<std::pair<const char*, int>, 4> kKinds{{{"Vertices", kPolyVertex},
                                                                 {"Lines", kPolyLine},
                                                                 {"Polygons", kPolygon},
                                                                 {"Strips", kStrip}}};
    for (std::size_t i = 0; i < kKinds.size(); ++i) {
      if (auto group = root_.group(kKinds[i].first))
        add_topology(std::move(*group), kKinds[i].second, static_cast<std::int64_t>(i), num_all);
    }
  }

  void add_topology(VtkHdfGroup group, int type, std::int64_t column, std::int64_t num_all) {
    VtkHdfTopology topology{std::move(group), type, {}, {}, 0, 0};
    topology.num_cells = topology.group.counts("NumberOfCells");
    topology.num_ids = topology.group.counts("NumberOfConnectivityIds");
    for (const auto* numbers : {&topology.num_cells, &topology.num_ids}) {
      if (static_cast<std::int64_t>(numbers->size()) >= num_all) continue;
      objects_.fail(fmt::format("'{}' counts cells of {} parts: the file has {}",
                                topology.group.place(), numbers->size(), num_all));
    }
    topology.first_cell = steps_.offset("CellOffsets", read_.step, column);
    topology.first_id = steps_.offset("ConnectivityIdOffsets", read_.step, column);
    topologies_.push_back(std::move(topology));
  }

  MeshPart read_part(std::int64_t part) {
    MeshPart mesh;
    const std::int64_t num_points = num_points_[static_cast<std::size_t>(first_part_ + part)];
    const std::int64_t points_before = sum_of_counts(num_points_, first_part_, part);
    mesh.positions = read_points(first_point_ + points_before, num_points);
    data::CellBuilder cells;
    std::int64_t cells_of_file = 0, cells_before = 0;
    for (const VtkHdfTopology& topology : topologies_) {
      add_cells(topology, part, num_points, cells);
      mesh.is_surface = mesh.is_surface || (is_surface_ && topology.type != kPolyVertex &&
                                            num_cells_of(topology, part) > 0);
      cells_of_file += topology.first_cell;
      cells_before += sum_of_counts(topology.num_cells, first_part_, part);
    }
    const auto num_cells = static_cast<std::int64_t>(cells.types.size());
    if (num_cells > 0) mesh.cells = std::move(cells).finish();
    // Particles keep what says how large and heavy they are.
    VtkHdfRead read = read_;
    if (is_point_set(mesh) || mesh.is_surface) read.array.clear();
    add_arrays(mesh, "PointData", false, first_point_, points_before, num_points, read);
    add_arrays(mesh, "CellData", true, cells_of_file, cells_before, num_cells, read);
    return mesh;
  }

  std::int64_t num_cells_of(const VtkHdfTopology& topology, std::int64_t part) const {
    return topology.num_cells[static_cast<std::size_t>(first_part_ + part)];
  }

  DataArray read_points(std::int64_t first, std::int64_t count) const {
    DataArray positions = root_.needed("Points").rows(first, count, *read_.progress);
    if (count > 0 && positions.num_components != 3)
      objects_.fail(fmt::format("'{}/Points' has {} numbers a point: expected 3", root_.place(),
                                positions.num_components));
    positions.num_components = 3;
    positions.name = "positions";
    return floating_values(positions);
  }

  // Each part has an offset more than cells, so that the numbers of parts before count, too: of the
  // file by the format's reader; but where steps share cells and not points, of those with cells.
  std::vector<std::int64_t> read_offsets(const VtkHdfTopology& topology, std::int64_t part) const {
    const std::int64_t count = num_cells_of(topology, part);
    const std::int64_t before =
        topology.first_cell + sum_of_counts(topology.num_cells, first_part_, part) + part;
    std::int64_t num_counted = 0;
    for (std::int64_t sum = 0; num_counted < first_part_ && sum < topology.first_cell;
         ++num_counted)
      sum += topology.num_cells[static_cast<std::size_t>(num_counted)];
    const VtkHdfArray& array = topology.group.needed("Offsets");
    const std::int64_t num_ids = topology.num_ids[static_cast<std::size_t>(first_part_ + part)];
    const auto tries =
        is_surface_ ? std::array{num_counted, first_part_} : std::array{first_part_, num_counted};
    for (const std::int64_t parts_before : tries) {
      const std::int64_t first = before + parts_before;
      if (first > array.num_rows() || count + 1 > array.num_rows() - first) continue;
      std::vector<std::int64_t> offsets =
          whole_numbers_of(objects_, array.place(), array.rows(first, count + 1, *read_.progress));
      if (static_cast<std::int64_t>(offsets.size()) == count + 1 && offsets.front() == 0 &&
          offsets.back() == num_ids)
        return offsets;
    }
    objects_.fail(fmt::format("'{}': part {} of step {} has no {} offsets from 0 to {}",
                              array.place(), part, read_.step, count + 1, num_ids));
  }

  void add_cells(const VtkHdfTopology& topology, std::int64_t part, std::int64_t num_points,
                 data::CellBuilder& cells) const {
    const std::int64_t count = num_cells_of(topology, part);
    if (count == 0) return;
    const std::vector<std::int64_t> offsets = read_offsets(topology, part);
    const std::int64_t first_cell =
        topology.first_cell + sum_of_counts(topology.num_cells, first_part_, part);
    const std::int64_t first_id =
        topology.first_id + sum_of_counts(topology.num_ids, first_part_, part);
    const VtkHdfArray& ids = topology.group.needed("Connectivity");
    const std::vector<std::int64_t> nodes = whole_numbers_of(
        objects_, ids.place(), ids.rows(first_id, offsets.back(), *read_.progress));
    std::vector<std::int64_t> types;
    if (topology.type == 0) {
      const VtkHdfArray& array = topology.group.needed("Types");
      types =
          whole_numbers_of(objects_, array.place(), array.rows(first_cell, count, *read_.progress));
    }
    for (std::size_t c = 0; c < static_cast<std::size_t>(count); ++c) {
      if (offsets[c + 1] < offsets[c] || offsets[c + 1] > offsets.back())
        objects_.fail(fmt::format("'{}/Offsets': cell {} ends at {}, behind {} of {}",
                                  topology.group.place(), c, offsets[c + 1], offsets[c],
                                  offsets.back()));
      for (std::int64_t i = offsets[c]; i < offsets[c + 1]; ++i) {
        const std::int64_t node = nodes[static_cast<std::size_t>(i)];
        if (node >= num_points)
          objects_.fail(fmt::format("'{}': number {} is {}: the part has {} points", ids.place(), i,
                                    node, num_points));
        cells.connectivity.push_back(static_cast<std::uint32_t>(node));
      }
      const std::int64_t size = offsets[c + 1] - offsets[c];
      std::int64_t type = types.empty() ? topology.type : types[c];
      if (types.empty() && type == kPolygon && size == 3) type = 5;
      if (types.empty() && type == kPolygon && size == 4) type = 9;
      if (type == kPixel && size == 4)
        std::swap(*(cells.connectivity.end() - 1), *(cells.connectivity.end() - 2));
      cells.end_cell(cell_type_of_vtk(type));
    }
  }

  // `origin`: where the step's points or cells begin, and its arrays, unless they say otherwise.
  void add_arrays(MeshPart& mesh, const char* group, bool is_cell_data, std::int64_t origin,
                  std::int64_t before, std::int64_t count, const VtkHdfRead& read) const {
    const std::string offsets = fmt::format("{}Offsets", group);
    std::vector<DataArray> arrays = read_vtkhdf_arrays(
        root_, group, is_cell_data, read, [&](const std::string& name, const VtkHdfArray& array) {
          const auto own = steps_.offset_of_array(offsets.c_str(), name, read_.step);
          return array.rows(own.value_or(origin) + before, count, *read_.progress);
        });
    for (DataArray& array : arrays) mesh.arrays.push_back(std::move(array));
  }

  const VtkHdfGroup& root_;
  const Hdf5Objects& objects_;
  bool is_surface_;
  const VtkHdfSteps& steps_;
  const VtkHdfRead& read_;
  std::vector<std::int64_t> num_points_;  // per part of the file
  std::int64_t first_part_ = 0, first_point_ = 0;
  std::vector<VtkHdfTopology> topologies_;
};

}  // namespace

std::vector<MeshPart> read_vtkhdf_mesh(const VtkHdfGroup& group, bool is_surface,
                                       const VtkHdfSteps& steps, const VtkHdfRead& read) {
  return VtkHdfMeshReader(group, is_surface, steps, read).run();
}

}  // namespace ovoid::io
#endif
