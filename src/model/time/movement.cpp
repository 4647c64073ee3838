// SPDX-License-Identifier: Apache-2.0
#include "model/time/movement.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "data/scalar_visit.h"
#include "model/time/step_blend.h"

namespace ovoid::model {
namespace {

bool have_equal_bytes(const DataArray& a, const DataArray& b) {
  return a.type == b.type && a.bytes.view.size() == b.bytes.view.size() &&
         std::memcmp(a.bytes.view.data(), b.bytes.view.data(), a.bytes.view.size()) == 0;
}

bool is_identity(const DataArray& array) {
  for (const char* const name : {"id", "ids", "particleids", "particle_ids", "globalnodeid"}) {
    std::string lower = array.name;
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (lower == name) return true;
  }
  return false;
}

double position_number(const Dataset& dataset, std::int64_t i) {
  const DataArray& array = dataset.positions;
  return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(data::load_scalar<T>(array.bytes.view.data(), i));
  });
}

// Number i of the positions: the shortest way through a periodic box.
double way_along(const Dataset& from, const Dataset& to, std::int64_t i) {
  double way = position_number(to, i) - position_number(from, i);
  if (from.periodic_box) {
    const double side = from.periodic_box->sizes()[static_cast<int>(i % 3)];
    if (side > 0) way -= side * std::round(way / side);
  }
  return way;
}

}  // namespace

std::string difference_of(const Dataset& a, const Dataset& b) {
  if (a.num_positions() != b.num_positions()) return "their numbers of positions differ";
  if (a.kind == DatasetKind::kMesh) {
    const bool are_equal = a.cells.types == b.cells.types && a.cells.offsets == b.cells.offsets &&
                           a.cells.connectivity == b.cells.connectivity &&
                           a.cells.dims == b.cells.dims;
    return are_equal ? "" : "their cells differ";
  }
  if (a.kind != DatasetKind::kParticles) return "only lattices, meshes and particles move";
  for (const DataArray& array : a.arrays) {
    if (!is_identity(array)) continue;
    return have_equal_bytes(array, same_array(b, array)) ? "" : "particles come in another order";
  }
  return "particles have no numbers (an array 'id') that tell which is which";
}

DataArray moved_positions(const Dataset& from, const Dataset& to, double share) {
  const std::int64_t count = 3 * from.num_positions();
  const auto memory = std::make_shared<double[]>(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i)
    memory[i] = position_number(from, i) + share * way_along(from, to, i);
  DataArray positions = from.positions;
  positions.type = ScalarType::kFloat64;
  positions.bytes = {memory, std::as_bytes(std::span<const double>(
                                 memory.get(), static_cast<std::size_t>(count)))};
  return positions;
}

double usual_way(const Dataset& from, const Dataset& to) {
  constexpr std::int64_t kMostWays = 1 << 16;
  constexpr double kShare = 0.95;
  const std::int64_t count = from.num_positions();
  const std::int64_t stride = std::max<std::int64_t>(1, (count + kMostWays - 1) / kMostWays);
  std::vector<double> ways;
  for (std::int64_t i = 0; i < count; i += stride) {
    double squares = 0;
    for (std::int64_t a = 0; a < 3; ++a) {
      const double way = way_along(from, to, 3 * i + a);
      squares += way * way;
    }
    if (std::isfinite(squares)) ways.push_back(std::sqrt(squares));
  }
  if (ways.empty()) return 0;
  const auto at = ways.begin() + std::lround(kShare * static_cast<double>(ways.size() - 1));
  std::nth_element(ways.begin(), at, ways.end());
  return *at;
}

}  // namespace ovoid::model
