// SPDX-License-Identifier: Apache-2.0
#include "io/xdmf/xdmf_grid.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/memory.h"
#include "io/core/point_arrays.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "io/vtk/rectilinear.h"
#include "io/xdmf/xdmf_cells.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

class XdmfGridReader {
 public:
  XdmfGridReader(const XdmfTree& tree, const XdmfItems& items, XdmfNode grid)
      : tree_(tree), items_(items), grid_(grid) {}

  XdmfGrid run(const std::string& array, std::vector<std::string>& notes) {
    const std::vector<XdmfNode> topologies = tree_.children(grid_, "Topology");
    const std::vector<XdmfNode> geometries = tree_.children(grid_, "Geometry");
    if (topologies.size() > 1 || geometries.size() != 1) {
      tree_.fail(grid_, fmt::format("has {} topologies and {} geometries: expected one each",
                                    topologies.size(), geometries.size()));
    }
    geometry_ = geometries[0];
    kind_ = lower(tree_.attribute(geometry_, {"GeometryType", "Type"}));
    if (kind_.empty()) kind_ = "xyz";
    if (topologies.empty()) {
      read_points();
    } else if (const std::string type = xdmf_topology_type(tree_, topologies[0]);
               is_xdmf_structured(type)) {
      read_structured(topologies[0], notes);
    } else {
      read_points();
      if (!is_xdmf_points(tree_, topologies[0]))
        content_.part.cells =
            read_xdmf_cells(tree_, items_, topologies[0], content_.part.num_nodes());
    }
    read_attributes(array, notes);
    return std::move(content_);
  }

 private:
  // --- where nodes are
  // ----------------------------------------------------------------------------

  std::vector<XdmfNumbers> geometry_items(std::size_t count) const {
    const std::vector<XdmfNode> found = tree_.children(geometry_, "DataItem");
    if (found.size() != count) {
      tree_.fail(geometry_,
                 fmt::format("has {} DataItems: {} takes {}", found.size(), kind_, count));
    }
    std::vector<XdmfNumbers> numbers;
    numbers.reserve(count);
    for (const XdmfNode item : found) numbers.push_back(items_.read(item));
    return numbers;
  }

  void read_points() {
    const bool is_apart = kind_ == "x_y_z" || kind_ == "x_y";
    const std::size_t num_axes = kind_ == "xy" || kind_ == "x_y" ? 2 : 3;
    if (!is_apart && kind_ != "xyz" && kind_ != "xy") {
      tree_.refuse(geometry_, fmt::format("is of GeometryType '{}': expected XYZ, XY, X_Y_Z or X_Y "
                                          "of these cells",
                                          kind_.substr(0, 40)));
    }
    const std::vector<XdmfNumbers> numbers = geometry_items(is_apart ? num_axes : 1);
    if (!is_apart && num_axes == 3) return set_positions(numbers[0]);
    const auto per_item = static_cast<std::int64_t>(is_apart ? 1 : num_axes);
    const std::int64_t count = numbers[0].count() / per_item;
    for (const XdmfNumbers& one : numbers) {
      if (one.count() == count * per_item && one.type == numbers[0].type) continue;
      tree_.fail(geometry_, fmt::format("has arrays of {} {} and {} {}", numbers[0].count(),
                                        name_of(numbers[0].type), one.count(), name_of(one.type)));
    }
    const std::size_t size = size_of(numbers[0].type);
    DataArray all{"positions", numbers[0].type, 3, count, "", false, {}};
    std::byte* to = nullptr;
    all = new_array(std::move(all), to);
    std::memset(to, 0, all.bytes.view.size());
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      for (std::size_t axis = 0; axis < num_axes; ++axis) {
        const auto& from = numbers[is_apart ? axis : 0].bytes.view;
        const std::size_t at = is_apart ? i : i * num_axes + axis;
        std::memcpy(to + (3 * i + axis) * size, from.data() + at * size, size);
      }
    }
    content_.part.positions = floating_values(all);
  }

  void set_positions(const XdmfNumbers& numbers) {
    if (numbers.count() % 3 != 0)
      tree_.fail(geometry_, fmt::format("has {} numbers: XYZ takes three a node", numbers.count()));
    content_.part.positions = floating_values(
        {"positions", numbers.type, 3, numbers.count() / 3, "", false, numbers.bytes});
  }

  // --- structured grids
  // ---------------------------------------------------------------------------

  void read_structured(XdmfNode topology, std::vector<std::string>& notes) {
    const std::string text = tree_.attribute(topology, {"Dimensions", "NumberOfElements"});
    std::vector<std::int64_t> dims = xdmf_dims(tree_, topology, text);
    const std::size_t wanted = xdmf_topology_type(tree_, topology).starts_with("2d") ? 2 : 3;
    if (dims.size() == 3 && wanted == 2 && dims[0] == 1) dims.erase(dims.begin());
    if (dims.size() != wanted) {
      tree_.fail(topology,
                 fmt::format("has Dimensions '{}': expected {} numbers, the slowest first",
                             text.substr(0, 80), wanted));
    }
    std::reverse(dims.begin(), dims.end());
    std::copy(dims.begin(), dims.end(), dims_.begin());
    if (kind_.starts_with("origin_")) return read_even(wanted, notes);
    if (kind_ == "vxvyvz" || kind_ == "vxvy") return read_rectilinear();
    read_points();
    content_.part.cells.dims = dims_;
    if (content_.part.num_nodes() == num_samples(dims_)) return;
    tree_.fail(geometry_, fmt::format("has {} points, Dimensions {} need another number",
                                      content_.part.num_nodes(), dims_text(dims_)));
  }

  // Origin and spacing, in the order of Dimensions: z, y, x.
  void read_even(std::size_t num_axes, std::vector<std::string>& notes) {
    const std::vector<XdmfNumbers> numbers = geometry_items(2);
    const std::int64_t count = numbers[0].count();
    if (numbers[1].count() != count || count > 3 || count < static_cast<std::int64_t>(num_axes)) {
      tree_.fail(geometry_, fmt::format("has {} and {} numbers: expected {} of origin and spacing",
                                        count, numbers[1].count(), num_axes));
    }
    Vec3 origin = Vec3::Zero(), spacing = Vec3::Zero();
    for (std::int64_t i = 0; i < count; ++i) {
      origin[i] = numbers[0].number(count - 1 - i);
      spacing[i] = numbers[1].number(count - 1 - i);
    }
    double smallest = 0;
    for (int i = 0; i < 3; ++i) {
      if (dims_[static_cast<std::size_t>(i)] == 1 || spacing[i] == 0) continue;
      smallest = smallest == 0 ? std::abs(spacing[i]) : std::min(smallest, std::abs(spacing[i]));
    }
    for (int i = 0; i < 3; ++i) {
      if (dims_[static_cast<std::size_t>(i)] == 1 && spacing[i] == 0)
        spacing[i] = smallest > 0 ? smallest : 1.0;
    }
    LatticeGeometry lattice;
    lattice.dims = dims_;
    lattice.world_from_index.linear() = spacing.asDiagonal();
    lattice.world_from_index.translation() = origin;
    check_geometry(fmt::format("{}: {}", tree_.source().name(), tree_.where(geometry_)),
                   lattice.world_from_index);
    const auto is_told = [&](const Vec3& values) {
      return values[0] != values[count == 2 ? 1 : 2];
    };
    if (is_told(origin) || (is_told(spacing) && dims_[count == 2 ? 1 : 2] > 1)) {
      notes.push_back(
          fmt::format("{}: origin and spacing are taken in the order of Dimensions, "
                      "{}: spacing {:g}, {:g}, {:g} along x, y, z",
                      tree_.source().name(), count == 2 ? "y and x" : "z, y and x", spacing[0],
                      spacing[1], spacing[2]));
    }
    content_.lattice = std::move(lattice);
  }

  void read_rectilinear() {
    const std::vector<XdmfNumbers> numbers = geometry_items(kind_ == "vxvy" ? 2 : 3);
    std::array<AxisCoordinates, 3> axes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis >= numbers.size()) {
        axes[axis].values = {0};
      } else {
        const XdmfNumbers& one = numbers[axis];
        axes[axis].is_float32 = one.type == ScalarType::kFloat32;
        for (std::int64_t i = 0; i < one.count(); ++i) axes[axis].values.push_back(one.number(i));
      }
      const auto count = static_cast<std::int64_t>(axes[axis].values.size());
      if (count != dims_[axis]) {
        tree_.fail(geometry_, fmt::format("has {} {} coordinates: Dimensions say {}", count,
                                          "xyz"[axis], dims_[axis]));
      }
    }
    const std::string where = fmt::format("{}: {}", tree_.source().name(), tree_.where(geometry_));
    content_.lattice = lattice_of_coordinates(where, axes);
    if (content_.lattice) return;
    require_memory(where, checked_num_bytes(where, dims_, ScalarType::kFloat64, 3));
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(3 * num_samples(dims_)));
    for (const double z : axes[2].values)
      for (const double y : axes[1].values)
        for (const double x : axes[0].values) values.insert(values.end(), {x, y, z});
    content_.part.positions = {
        "positions", ScalarType::kFloat64,           3, num_samples(dims_), "",
        false,       bytes_owning(std::move(values))};
    content_.part.cells.dims = dims_;
  }

  // --- attributes
  // ---------------------------------------------------------------------------------

  std::int64_t num_tuples(bool is_cell_data) const {
    if (!content_.lattice)
      return is_cell_data ? content_.part.cells.count() : content_.part.num_nodes();
    std::int64_t count = 1;
    for (const std::int64_t dim : dims_)
      count *= is_cell_data ? std::max<std::int64_t>(1, dim - 1) : dim;
    return count;
  }

  bool has_cells() const { return content_.lattice || content_.part.cells.count() > 0; }

  std::string name_of_attribute(XdmfNode attribute, std::size_t index) const {
    const std::string name = tree_.attribute(attribute, {"Name"});
    return name.empty() ? fmt::format("attribute {}", index + 1) : name;
  }

  void read_attributes(const std::string& wanted, std::vector<std::string>& notes) {
    const std::vector<XdmfNode> attributes = tree_.children(grid_, "Attribute");
    bool is_there = false;
    for (std::size_t i = 0; i < attributes.size(); ++i)
      is_there = is_there || (!wanted.empty() && name_of_attribute(attributes[i], i) == wanted);
    const bool keeps_all = !content_.lattice && is_point_set(content_.part);
    for (std::size_t i = 0; i < attributes.size(); ++i) {
      const std::string name = name_of_attribute(attributes[i], i);
      if (is_there && !keeps_all && name != wanted) continue;
      read_attribute(attributes[i], name, is_there && name == wanted, notes);
    }
  }

  void read_attribute(XdmfNode attribute, const std::string& name, bool is_wanted,
                      std::vector<std::string>& notes) {
    const std::string center = lower(tree_.attribute(attribute, {"Center"}));
    const std::string kind = lower(tree_.attribute(attribute, {"ItemType"}));
    std::string why;
    if (!center.empty() && center != "node" && center != "cell")
      why = fmt::format("belongs to Center '{}'", center.substr(0, 40));
    if (kind == "finiteelementfunction") why = "is a finite element function";
    const std::vector<XdmfNode> found = tree_.children(attribute, "DataItem");
    if (found.size() == 1 && is_xdmf_formula(tree_, found[0])) why = "is a function of others";
    if (!why.empty()) {
      why += ", which is not read: expected values of nodes or cells";
      if (is_wanted) tree_.refuse(attribute, why);
      notes.push_back(
          fmt::format("{}: array '{}' is left out: it {}", tree_.source().name(), name, why));
      return;
    }
    if (found.size() != 1)
      tree_.fail(attribute, fmt::format("has {} DataItems: expected one", found.size()));
    const XdmfNumbers numbers = items_.read(found[0]);
    DataArray array{name, numbers.type, 1, 0, "", center == "cell" && has_cells(), numbers.bytes};
    array.num_tuples = num_tuples(array.is_cell_data);
    const std::int64_t num_components =
        array.num_tuples > 0 ? numbers.count() / array.num_tuples : 0;
    if (num_components < 1 || num_components * array.num_tuples != numbers.count() ||
        !fits_type(attribute, num_components)) {
      tree_.fail(attribute, fmt::format("has {} numbers: expected {} of {} {}", numbers.count(),
                                        type_of(attribute), array.num_tuples,
                                        array.is_cell_data ? "cells" : "nodes"));
    }
    array.num_components = static_cast<int>(num_components);
    content_.part.arrays.push_back(std::move(array));
  }

  std::string type_of(XdmfNode attribute) const {
    const std::string type = lower(tree_.attribute(attribute, {"AttributeType", "Type"}));
    return type.empty() ? "scalar" : type.substr(0, 40);
  }

  // Vectors of plane grids may have two components, their tensors four.
  bool fits_type(XdmfNode attribute, std::int64_t num_components) const {
    const std::string type = type_of(attribute);
    if (type == "vector") return num_components == 2 || num_components == 3;
    if (type == "tensor") return num_components == 4 || num_components == 9;
    if (type == "tensor6") return num_components == 6;
    constexpr std::int64_t kMostComponents = 4096;
    if (type == "matrix") return num_components <= kMostComponents;
    return num_components == 1;
  }

  const XdmfTree& tree_;
  const XdmfItems& items_;
  XdmfNode grid_, geometry_;
  std::string kind_;
  Index3 dims_{1, 1, 1};
  XdmfGrid content_;
};

}  // namespace

XdmfGrid read_xdmf_grid(const XdmfTree& tree, const XdmfItems& items, XdmfNode grid,
                        const std::string& array, std::vector<std::string>& notes) {
  return XdmfGridReader(tree, items, grid).run(array, notes);
}

}  // namespace ovoid::io
