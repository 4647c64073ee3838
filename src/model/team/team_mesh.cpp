// SPDX-License-Identifier: Apache-2.0
// Cells go to all processes that have one of their nodes. A node's kernel, and whether a face is
// shared, follow from the cells around a node, so that its owner works them out alone.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

#include "data/kernels/letters.h"
#include "model/mesh/local_mesh.h"
#include "model/team/team_run.h"
#include "model/team/team_sites.h"
#include "ovoid/error.h"

namespace ovoid::model {
namespace {

// A mesh on its way, and how it arrives.
struct Sent {
  std::vector<std::uint64_t> numbers;  // DatasetShare::nodes
  std::vector<double> places;          // [n, 3]
  std::vector<CellType> types;
  std::vector<std::uint32_t> sizes;  // nodes of each cell
  std::vector<std::uint32_t> connectivity;
  std::vector<std::vector<float>> columns;  // per node, or per cell
};

std::uint64_t piece_of(std::uint64_t number) noexcept { return number >> 32U; }

void require_numbers(const ModelRun& run) {
  const std::size_t expected = static_cast<std::size_t>(run.dataset.num_positions());
  const auto& nodes = run.dataset.share->nodes;
  if (nodes.size() == expected && std::is_sorted(nodes.begin(), nodes.end())) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("'{}': a share of a mesh has {} numbers of nodes: expected {}, rising",
                          run.dataset.source, nodes.size(), expected));
}

// The share, as it was read, and who gets what of it.
class ShareOfMesh {
 public:
  ShareOfMesh(const ModelRun& run, const ChosenArrays& chosen)
      : numbers_(run.dataset.share->nodes),
        positions_(load_positions(run)),
        cells_(load_cells(run)),
        is_cell_data_(chosen.is_cell_data),
        values_(load_values(
            run, chosen,
            is_cell_data_ ? static_cast<std::int64_t>(cells_.count()) : run.dataset.num_positions(),
            is_cell_data_ ? "cells" : "nodes")),
        shares_(run, positions_) {
    const auto count = static_cast<std::size_t>(run.team->count());
    cell_lists_.resize(count);
    node_lists_.resize(count);
    for (std::uint32_t node = 0; node < numbers_.size(); ++node)
      node_lists_[owner(node)].push_back(node);
    std::vector<std::size_t> owners;
    for (std::uint32_t c = 0; c < cells_.count(); ++c) {
      owners.clear();
      for (const std::uint32_t node : cells_.nodes(c)) owners.push_back(owner(node));
      if (owners.empty()) owners.push_back(0);
      std::sort(owners.begin(), owners.end());
      owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
      for (const std::size_t p : owners) {
        cell_lists_[p].push_back(c);
        if (owners.size() == 1) continue;
        for (const std::uint32_t node : cells_.nodes(c)) {
          if (owner(node) != p) node_lists_[p].push_back(node);
        }
      }
    }
    for (std::vector<std::uint32_t>& list : node_lists_) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
  }

  const SpaceShares& shares() const noexcept { return shares_; }
  std::vector<KernelAttribute> take_attributes() { return std::move(values_.attributes); }

  KernelTeam::Letters letters() const {
    KernelTeam::Letters letters(node_lists_.size());
    std::vector<std::uint32_t> place_in_list(numbers_.size());
    for (std::size_t p = 0; p < letters.size(); ++p) {
      const Sent sent = sent_to(p, place_in_list);
      data::Letter& letter = letters[p];
      const std::array<std::uint64_t, 3> counts{sent.numbers.size(), sent.types.size(),
                                                sent.connectivity.size()};
      data::append(letter, std::span<const std::uint64_t>(counts));
      data::append(letter, std::span<const std::uint64_t>(sent.numbers));
      data::append(letter, std::span<const double>(sent.places));
      data::append(letter, std::span<const CellType>(sent.types));
      data::append(letter, std::span<const std::uint32_t>(sent.sizes));
      data::append(letter, std::span<const std::uint32_t>(sent.connectivity));
      for (const std::vector<float>& column : sent.columns)
        data::append(letter, std::span<const float>(column));
    }
    return letters;
  }

 private:
  std::size_t owner(std::uint32_t node) const {
    return static_cast<std::size_t>(shares_.owners()[node]);
  }

  Sent sent_to(std::size_t process, std::vector<std::uint32_t>& place_in_list) const {
    const std::vector<std::uint32_t>& nodes = node_lists_[process];
    const std::vector<std::uint32_t>& cells = cell_lists_[process];
    Sent sent;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
      const std::uint32_t node = nodes[i];
      place_in_list[node] = i;
      sent.numbers.push_back(numbers_[node]);
      const double* const at = positions_.data() + std::size_t{3} * node;
      sent.places.insert(sent.places.end(), at, at + 3);
    }
    for (const std::uint32_t c : cells) {
      sent.types.push_back(cells_.types[c]);
      sent.sizes.push_back(static_cast<std::uint32_t>(cells_.nodes(c).size()));
      for (const std::uint32_t node : cells_.nodes(c))
        sent.connectivity.push_back(place_in_list[node]);
    }
    for (const std::vector<float>& column : values_.columns) {
      std::vector<float>& some = sent.columns.emplace_back();
      for (const std::uint32_t row : is_cell_data_ ? cells : nodes) some.push_back(column[row]);
    }
    return sent;
  }

  SharedValues<std::uint64_t> numbers_;
  std::vector<double> positions_;
  MeshCells cells_;
  bool is_cell_data_;
  SiteValues values_;
  SpaceShares shares_;
  std::vector<std::vector<std::uint32_t>> cell_lists_, node_lists_;  // by process; rising
};

// Letters of all, in the order of the processes, as one: cells are in the order of the whole then.
Sent received(KernelTeam::Letters letters, std::size_t num_columns, bool is_cell_data) {
  Sent all;
  all.columns.resize(num_columns);
  for (data::Letter& letter : letters) {
    data::LetterReader reader(letter);
    std::vector<std::uint64_t> counts;
    reader.take(3, counts);
    const auto before = static_cast<std::uint32_t>(all.numbers.size());
    const std::size_t first = all.connectivity.size();
    reader.take(counts[0], all.numbers);
    reader.take(3 * counts[0], all.places);
    reader.take(counts[1], all.types);
    reader.take(counts[1], all.sizes);
    reader.take(counts[2], all.connectivity);
    for (std::size_t i = first; i < all.connectivity.size(); ++i) all.connectivity[i] += before;
    for (std::vector<float>& column : all.columns)
      reader.take(counts[is_cell_data ? 1 : 0], column);
    letter = {};
  }
  if (all.numbers.size() >= std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::kUnsupported,
                fmt::format("a process' part of the mesh has {} nodes, must be fewer than 2^32; "
                            "more processes have smaller parts",
                            all.numbers.size()));
  return all;
}

// Which of the nodes that have arrived stay, by the order of their numbers, and which of these each
// of them is.
struct NodeChoice {
  std::vector<std::uint32_t> kept;       // of those that have arrived
  std::vector<std::uint32_t> number_of;  // of those that have arrived: a number among the kept
  std::int64_t num_replaced = 0;         // by nodes of earlier pieces
};

// A node that several processes have sent is one, and of those at one place those of the first
// piece stay, as where one process reads all pieces.
NodeChoice choose_nodes(const Sent& sent) {
  std::vector<std::uint32_t> order(sent.numbers.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return sent.numbers[a] < sent.numbers[b];
  });
  const bool is_one_piece = order.empty() || piece_of(sent.numbers[order.front()]) ==
                                                 piece_of(sent.numbers[order.back()]);
  std::unordered_map<Vec3, std::uint32_t, PlaceHash> first_at;  // of the kept
  NodeChoice choice;
  choice.number_of.resize(order.size());
  const auto is_same = [&](std::uint32_t a, std::uint32_t b) {
    return sent.numbers[a] == sent.numbers[b];
  };
  // The node that stands for another piece's, if there is one.
  const auto first_of_place = [&](std::uint32_t node, std::uint32_t next) {
    const auto [found, is_first] =
        first_at.try_emplace(Vec3(sent.places.data() + std::size_t{3} * node), next);
    if (is_first) return next;
    const std::uint64_t other = sent.numbers[choice.kept[found->second]];
    return piece_of(other) == piece_of(sent.numbers[node]) ? next : found->second;
  };
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::uint32_t node = order[k];
    if (k > 0 && is_same(node, order[k - 1])) {
      choice.number_of[node] = choice.number_of[order[k - 1]];
      continue;
    }
    const auto next = static_cast<std::uint32_t>(choice.kept.size());
    choice.number_of[node] = is_one_piece ? next : first_of_place(node, next);
    if (choice.number_of[node] == next) {
      choice.kept.push_back(node);
    } else {
      ++choice.num_replaced;
    }
  }
  return choice;
}

template <class T>
std::vector<T> rows_of(const std::vector<T>& column, const std::vector<std::uint32_t>& rows,
                       std::size_t width) {
  std::vector<T> some;
  some.reserve(width * rows.size());
  for (const std::size_t row : rows) {
    for (std::size_t c = 0; c < width; ++c) some.push_back(column[width * row + c]);
  }
  return some;
}

// Which node stands for several at one place is known to the owner of the place alone: the others
// take its number and values from there.
void take_from_owners(const ModelRun& run, const SpaceShares& shares, LocalMesh& mesh) {
  const MeshNodes& nodes = mesh.nodes;
  std::unordered_map<Vec3, std::uint32_t, PlaceHash> own_at;
  data::RowLists asked(static_cast<std::size_t>(run.team->count()));
  for (std::uint32_t node = 0; node < nodes.count(); ++node) {
    if (mesh.is_own_node[node]) {
      if (nodes.stands_for(node) == node) own_at.try_emplace(nodes.at(node), node);
      mesh.numbers[node] = mesh.numbers[nodes.stands_for(node)];
    } else if (nodes.is_placed(node)) {
      asked[static_cast<std::size_t>(shares.owner_of(nodes.at(node)))].push_back(node);
    }
  }
  // Nodes are there beside the cells that have them, so that owners know every place.
  KernelTeam::Letters letters = data::letters_of(asked, 3 * sizeof(double));
  data::append_rows(letters, asked, 3, nodes.positions);
  letters = run.team->exchange(std::move(letters));
  for (data::Letter& letter : letters) {
    std::vector<Vec3> places;
    data::LetterReader(letter).take(letter.size() / sizeof(Vec3), places);
    letter.clear();
    const auto answer = [&](const auto& column) {
      for (const Vec3& place : places)
        data::append(letter, std::span(&column[own_at.at(place)], 1));
    };
    answer(mesh.numbers);
    if (mesh.is_cell_data) continue;
    for (const std::vector<float>& column : mesh.values.columns) answer(column);
  }
  letters = run.team->exchange(std::move(letters));
  for (std::size_t p = 0; p < letters.size(); ++p) {
    data::LetterReader reader(letters[p]);
    const auto take = [&]<class T>(std::vector<T>& column) {
      std::vector<T> answers;
      reader.take(asked[p].size(), answers);
      for (std::size_t i = 0; i < answers.size(); ++i) column[asked[p][i]] = answers[i];
    };
    take(mesh.numbers);
    if (mesh.is_cell_data) continue;
    for (std::vector<float>& column : mesh.values.columns) take(column);
  }
}

}  // namespace

LocalMesh team_mesh(const ModelRun& run, const ChosenArrays& chosen) {
  require_numbers(run);
  std::optional<ShareOfMesh> share(std::in_place, run, chosen);
  const SpaceShares shares = share->shares();
  LocalMesh mesh;
  mesh.is_cell_data = chosen.is_cell_data;
  mesh.values.attributes = share->take_attributes();
  KernelTeam::Letters letters = share->letters();
  share.reset();  // before as much arrives
  Sent sent =
      received(run.team->exchange(std::move(letters)), chosen.arrays.size(), mesh.is_cell_data);
  const NodeChoice choice = choose_nodes(sent);

  mesh.nodes = merged_nodes(rows_of(sent.places, choice.kept, 3));
  for (std::vector<float>& column : sent.columns)
    mesh.values.columns.push_back(mesh.is_cell_data ? std::move(column)
                                                    : rows_of(column, choice.kept, 1));
  for (std::uint32_t& node : sent.connectivity) node = choice.number_of[node];
  std::vector<std::int64_t> offsets = {0};
  offsets.reserve(sent.sizes.size() + 1);
  for (const std::uint32_t size : sent.sizes) offsets.push_back(offsets.back() + size);
  mesh.cells =
      cells_owning(std::move(sent.types), std::move(offsets), std::move(sent.connectivity));

  const int own = run.team->number();
  mesh.is_own_node.reserve(mesh.nodes.count());
  for (std::uint32_t node = 0; node < mesh.nodes.count(); ++node)
    mesh.is_own_node.push_back(shares.owner_of(mesh.nodes.at(node)) == own);
  mesh.is_own_cell.reserve(mesh.cells.count());
  for (std::size_t c = 0; c < mesh.cells.count(); ++c) {
    const auto nodes = mesh.cells.nodes(c);
    mesh.is_own_cell.push_back(nodes.empty() ? own == 0 : mesh.is_own_node[nodes[0]]);
  }
  mesh.numbers = rows_of(sent.numbers, choice.kept, 1);
  if (total_of(run, mesh.nodes.num_merged + choice.num_replaced) > 0)
    take_from_owners(run, shares, mesh);
  return mesh;
}

LocalMesh load_local_mesh(const ModelRun& run, const ChosenArrays& chosen) {
  if (run.team != nullptr) return team_mesh(run, chosen);
  LocalMesh mesh;
  mesh.nodes = load_nodes(run);
  mesh.cells = load_cells(run);
  mesh.is_cell_data = chosen.is_cell_data;
  mesh.values = load_values(run, chosen,
                            mesh.is_cell_data ? static_cast<std::int64_t>(mesh.cells.count())
                                              : run.dataset.num_positions(),
                            mesh.is_cell_data ? "cells" : "nodes");
  return mesh;
}

}  // namespace ovoid::model
