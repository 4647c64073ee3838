// SPDX-License-Identifier: Apache-2.0
#include "io/xdmf/xdmf_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "data/cell_builder.h"
#include "data/scalar_visit.h"
#include "io/core/numbers.h"
#include "io/core/text_scanner.h"

namespace ovoid::io {
namespace {

// A kind of cells: its names, its number in Mixed, its nodes (0: a count goes before them). Nodes
// stand in VTK's order.
struct XdmfCell {
  const char* name;
  const char* other_name;
  int number;
  int num_nodes;
  CellType type;
};

constexpr XdmfCell kXdmfCells[] = {
    {"polyvertex", "", 1, 0, CellType::kVertex},
    {"polyline", "", 2, 0, CellType::kLine},
    {"polygon", "", 3, 0, CellType::kOther},
    {"triangle", "tri", 4, 3, CellType::kTriangle},
    {"quadrilateral", "quad", 5, 4, CellType::kQuad},
    {"tetrahedron", "tet", 6, 4, CellType::kTetrahedron},
    {"pyramid", "pyr", 7, 5, CellType::kPyramid},
    {"wedge", "prism", 8, 6, CellType::kWedge},
    {"hexahedron", "hex", 9, 8, CellType::kHexahedron},
    {"edge_3", "", 34, 3, CellType::kOther},
    {"quadrilateral_9", "quad_9", 35, 9, CellType::kOther},
    {"triangle_6", "tri_6", 36, 6, CellType::kOther},
    {"quadrilateral_8", "quad_8", 37, 8, CellType::kOther},
    {"tetrahedron_10", "tet_10", 38, 10, CellType::kQuadraticTetrahedron},
    {"pyramid_13", "pyr_13", 39, 13, CellType::kQuadraticPyramid},
    {"wedge_15", "", 40, 15, CellType::kQuadraticWedge},
    {"wedge_18", "", 41, 18, CellType::kOther},
    {"hexahedron_20", "hex_20", 48, 20, CellType::kQuadraticHexahedron},
    {"hexahedron_24", "hex_24", 49, 24, CellType::kOther},
    {"hexahedron_27", "hex_27", 50, 27, CellType::kTriQuadraticHexahedron}};

constexpr int kPolyhedron = 16;

const XdmfCell* cell_called(const std::string& name) {
  const auto* const found =
      std::find_if(std::begin(kXdmfCells), std::end(kXdmfCells), [&](const XdmfCell& cell) {
        return name == cell.name || (*cell.other_name != '\0' && name == cell.other_name);
      });
  return found == std::end(kXdmfCells) ? nullptr : found;
}

const XdmfCell* cell_numbered(std::int64_t number) {
  const auto* const found =
      std::find_if(std::begin(kXdmfCells), std::end(kXdmfCells),
                   [&](const XdmfCell& cell) { return number == cell.number; });
  return found == std::end(kXdmfCells) ? nullptr : found;
}

// Passes the numbers of a topology one by one.
class XdmfCellReader {
 public:
  XdmfCellReader(const XdmfTree& tree, XdmfNode topology, std::vector<std::int64_t> numbers,
                 std::int64_t num_nodes, std::int64_t base)
      : tree_(tree),
        topology_(topology),
        numbers_(std::move(numbers)),
        num_nodes_(num_nodes),
        base_(base) {}

  bool at_end() const noexcept { return at_ == numbers_.size(); }
  std::int64_t num_left() const noexcept {
    return static_cast<std::int64_t>(numbers_.size() - at_);
  }

  std::int64_t next() {
    if (at_end()) tree_.fail(topology_, fmt::format("ends within cell {}", cells_.types.size()));
    return numbers_[at_++];
  }

  std::int64_t next_count() {
    const std::int64_t count = next();
    if (count < 1 || count > num_left()) {
      tree_.fail(topology_, fmt::format("cell {} has {} nodes or faces: {} numbers are left",
                                        cells_.types.size(), count, num_left()));
    }
    return count;
  }

  void add_nodes(std::int64_t count) {
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t node = next() - base_;
      if (node < 0 || node >= num_nodes_) {
        tree_.fail(topology_, fmt::format("cell {} has node {}: the grid has {} of them, from {}",
                                          cells_.types.size(), node + base_, num_nodes_, base_));
      }
      cells_.connectivity.push_back(static_cast<std::uint32_t>(node));
    }
  }

  void add(const XdmfCell& cell, std::int64_t count) {
    add_nodes(count);
    CellType type = cell.type;
    if (type == CellType::kOther && cell.num_nodes == 0 && count == 3) type = CellType::kTriangle;
    if (type == CellType::kOther && cell.num_nodes == 0 && count == 4) type = CellType::kQuad;
    if (type == CellType::kLine && count != 2) type = CellType::kOther;
    cells_.end_cell(type);
  }

  // Faces, each a count and its nodes: each node once.
  void add_polyhedron() {
    const auto begin = static_cast<std::ptrdiff_t>(cells_.connectivity.size());
    for (std::int64_t faces = next_count(); faces > 0; --faces) add_nodes(next_count());
    auto& nodes = cells_.connectivity;
    std::sort(nodes.begin() + begin, nodes.end());
    nodes.erase(std::unique(nodes.begin() + begin, nodes.end()), nodes.end());
    cells_.end_cell(CellType::kOther);
  }

  void add_mixed() {
    const std::int64_t number = next();
    if (number == kPolyhedron) return add_polyhedron();
    const XdmfCell* const cell = cell_numbered(number);
    if (cell == nullptr)
      tree_.refuse(topology_, fmt::format("cell {} is of kind {}, which is not known",
                                          cells_.types.size(), number));
    add(*cell, cell->num_nodes > 0 ? cell->num_nodes : next_count());
  }

  Cells finish() && { return std::move(cells_).finish(); }
  std::int64_t count() const noexcept { return static_cast<std::int64_t>(cells_.types.size()); }

 private:
  const XdmfTree& tree_;
  XdmfNode topology_;
  std::vector<std::int64_t> numbers_;
  std::int64_t num_nodes_, base_;
  std::size_t at_ = 0;
  data::CellBuilder cells_;
};

std::vector<std::int64_t> whole_numbers(const XdmfTree& tree, XdmfNode topology,
                                        const XdmfNumbers& numbers) {
  std::vector<std::int64_t> values(static_cast<std::size_t>(numbers.count()));
  data::visit_scalar(numbers.type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const T value = data::load_scalar<T>(numbers.bytes.view.data(), static_cast<std::int64_t>(i));
      // Node numbers have 32 bits.
      constexpr auto kMost = static_cast<double>(std::numeric_limits<std::uint32_t>::max());
      const auto real = static_cast<double>(value);
      if (!(real >= 0 && real <= kMost) || real != std::floor(real))
        tree.fail(topology, fmt::format("number {} is {}: expected a node's", i, real));
      values[i] = static_cast<std::int64_t>(real);
    }
  });
  return values;
}

std::optional<std::int64_t> number_attribute(const XdmfTree& tree, XdmfNode element,
                                             std::initializer_list<const char*> names) {
  const std::string text = tree.attribute(element, names);
  if (text.empty()) return std::nullopt;
  std::int64_t count = 1;
  for (const std::string_view word : words(text)) {
    const auto value = parse_integer(word);
    const auto product = value ? checked_product(std::array{count, *value}) : std::nullopt;
    if (!product)
      tree.fail(element, fmt::format("has '{}': expected a number", text.substr(0, 40)));
    count = *product;
  }
  return count;
}

}  // namespace

std::string xdmf_topology_type(const XdmfTree& tree, XdmfNode topology) {
  return lower(tree.attribute(topology, {"TopologyType", "Type"}));
}

bool is_xdmf_structured(const std::string& type) {
  for (const char* const kind : {"corectmesh", "rectmesh", "smesh"})
    if (type == std::string("2d") + kind || type == std::string("3d") + kind) return true;
  return false;
}

bool is_xdmf_points(const XdmfTree& tree, XdmfNode topology) {
  const std::string type = xdmf_topology_type(tree, topology);
  return type == "notopology" ||
         (type == "polyvertex" && tree.children(topology, "DataItem").empty());
}

Cells read_xdmf_cells(const XdmfTree& tree, const XdmfItems& items, XdmfNode topology,
                      std::int64_t num_nodes) {
  const std::string type = xdmf_topology_type(tree, topology);
  const XdmfCell* const cell = cell_called(type);
  const bool is_mixed = type == "mixed", is_polyhedron = type == "polyhedron";
  if (cell == nullptr && !is_mixed && !is_polyhedron) {
    tree.refuse(topology,
                fmt::format("is of TopologyType '{}', which is not known", type.substr(0, 40)));
  }
  if (!tree.attribute(topology, {"Order"}).empty())
    tree.refuse(topology, "has an Order of nodes of its own");
  const std::vector<XdmfNode> found = tree.children(topology, "DataItem");
  if (found.size() != 1)
    tree.fail(topology, fmt::format("has {} DataItems: expected one of nodes", found.size()));
  const auto base = number_attribute(tree, topology, {"BaseOffset", "Offset"}).value_or(0);
  XdmfCellReader reader(tree, topology, whole_numbers(tree, topology, items.read(found[0])),
                        num_nodes, base);
  std::int64_t size = cell != nullptr ? cell->num_nodes : 0;
  if (cell != nullptr && size == 0) {
    size = number_attribute(tree, topology, {"NodesPerElement"})
               .value_or(cell->type == CellType::kVertex ? 1
                         : cell->type == CellType::kLine ? 2
                                                         : 0);
    if (size < 1 || size > reader.num_left())
      tree.fail(topology, "says no NodesPerElement: expected a number from 1");
  }
  const auto stated = number_attribute(tree, topology, {"NumberOfElements", "Dimensions"});
  // More cells than stated may be there as padding of Mixed alone.
  while (!reader.at_end() && !(is_mixed && stated && reader.count() == *stated)) {
    if (is_mixed)
      reader.add_mixed();
    else if (is_polyhedron)
      reader.add_polyhedron();
    else
      reader.add(*cell, size);
  }
  if (stated && *stated != reader.count()) {
    tree.fail(topology, fmt::format("holds {} cells, {} are stated", reader.count(), *stated));
  }
  return std::move(reader).finish();
}

}  // namespace ovoid::io
