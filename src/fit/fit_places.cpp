// SPDX-License-Identifier: Apache-2.0
#include "fit/fit_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "data/parallel.h"
#include "model/mesh_cells.h"
#include "model/noise.h"

namespace ovoid::fit {
namespace {

constexpr std::int64_t kPlaceGrain = 1024;
// Random places near a kernel are within so many sigmas: neighbours' centres are about two away. Of
// a sum every second one is further off, where it fades and a wider kernel would not.
constexpr double kNearSigmas = 1.5, kFarSigmas = 6;
// Beside the nodes so many places in cells are seen for each node, if there are as many cells; of
// each cell two at most.
constexpr double kPlacesPerNode = 2;

using CornerShares = std::array<double, 8>;

// How many nodes of a solid cell are its corners, which give its values; 0: no cell that we
// interpolate in.
std::size_t num_corners(CellType type) {
  switch (type) {
    case CellType::kTetrahedron:
    case CellType::kQuadraticTetrahedron:
      return 4;
    case CellType::kPyramid:
    case CellType::kQuadraticPyramid:
      return 5;
    case CellType::kWedge:
    case CellType::kQuadraticWedge:
      return 6;
    case CellType::kHexahedron:
    case CellType::kVoxel:
    case CellType::kQuadraticHexahedron:
    case CellType::kTriQuadraticHexahedron:
      return 8;
    default:
      return 0;
  }
}

// Evenly over a tetrahedron, or over a triangle: shares of its corners, which sum to 1.
template <std::size_t N>
std::array<double, N> random_shares(model::Random& random) {
  std::array<double, N> shares;
  double sum = 0;
  for (double& share : shares) {
    share = -std::log(1 - random.uniform(0, 1));
    sum += share;
  }
  for (double& share : shares) share /= sum;
  return shares;
}

// Shares of the corners at a random place of the cell: even where opposite faces are parallel.
CornerShares random_place(CellType type, model::Random& random) {
  CornerShares shares{};
  switch (num_corners(type)) {
    case 4: {
      const auto corners = random_shares<4>(random);
      std::copy(corners.begin(), corners.end(), shares.begin());
      break;
    }
    case 5: {
      const double up = 1 - std::cbrt(1 - random.uniform(0, 1));
      const double x = random.uniform(0, 1), y = random.uniform(0, 1);
      shares = {(1 - x) * (1 - y) * (1 - up), x * (1 - y) * (1 - up), x * y * (1 - up),
                (1 - x) * y * (1 - up), up};
      break;
    }
    case 6: {
      const auto corners = random_shares<3>(random);
      const double up = random.uniform(0, 1);
      for (std::size_t i = 0; i < 3; ++i) {
        shares[i] = corners[i] * (1 - up);
        shares[i + 3] = corners[i] * up;
      }
      break;
    }
    default: {
      const double x = random.uniform(0, 1), y = random.uniform(0, 1), z = random.uniform(0, 1);
      const std::array<double, 4> face = {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
      for (std::size_t i = 0; i < 4; ++i) {
        // A voxel's corners lie row by row.
        const std::size_t to = type == CellType::kVoxel && i >= 2 ? 5 - i : i;
        shares[to] = face[i] * (1 - z);
        shares[to + 4] = face[i] * z;
      }
    }
  }
  return shares;
}

// Cells in which values at the corners are interpolated.
class MeshValues {
 public:
  MeshValues(const Dataset& dataset, const PlaceOptions& options)
      : run_{dataset, options.model, report_, options.threads, options.stop},
        nodes_(model::load_nodes(run_)),
        cells_(model::load_cells(run_)) {
    const model::ChosenArrays chosen = model::choose_arrays(run_);
    values_ = model::load_values(run_, chosen, dataset.num_positions(), "nodes");
    const model::CellMeasures measures = model::measure_cells(run_, nodes_, cells_);
    for (std::size_t c = 0; c < cells_.count(); ++c) {
      const double volume = std::abs(measures.volumes[c]);
      if (!(volume > 0) || num_corners(cells_.types[c]) == 0 || !has_values(c)) continue;
      solid_.push_back(static_cast<std::uint32_t>(c));
      volumes_.push_back(volume);
      up_to_.push_back((up_to_.empty() ? 0 : up_to_.back()) + volume);
    }
  }

  std::size_t count() const noexcept { return solid_.size(); }
  double volume(std::size_t i) const noexcept { return volumes_[i]; }
  double whole_volume() const noexcept { return up_to_.back(); }

  std::size_t random_cell(model::Random& random) const {
    const double at = random.uniform(0, whole_volume());
    const auto found = std::upper_bound(up_to_.begin(), up_to_.end(), at);
    return std::min(static_cast<std::size_t>(found - up_to_.begin()), solid_.size() - 1);
  }

  void append_middle(std::size_t i, double share, Places& places) const {
    CornerShares shares{};
    const std::size_t corners = num_corners(cells_.types[solid_[i]]);
    std::fill_n(shares.begin(), corners, 1 / static_cast<double>(corners));
    append(i, shares, share, places);
  }
  void append_random(std::size_t i, double share, model::Random& random, Places& places) const {
    append(i, random_place(cells_.types[solid_[i]], random), share, places);
  }

 private:
  bool has_values(std::size_t cell) const {
    const auto nodes = cells_.nodes(cell);
    return std::all_of(nodes.begin(), nodes.end(),
                       [&](std::uint32_t node) { return values_.is_finite(node); });
  }

  void append(std::size_t i, const CornerShares& corners, double share, Places& places) const {
    const auto nodes = cells_.nodes(solid_[i]);
    Vec3 at = Vec3::Zero();
    std::array<double, kMaxAttributes> values{};
    for (std::size_t n = 0; n < num_corners(cells_.types[solid_[i]]); ++n) {
      at += corners[n] * nodes_.at(nodes[n]);
      for (std::size_t a = 0; a < values_.columns.size(); ++a)
        values[a] += corners[n] * static_cast<double>(values_.columns[a][nodes[n]]);
    }
    places.at.insert(places.at.end(), {at[0], at[1], at[2]});
    places.shares.push_back(share);
    for (std::size_t a = 0; a < places.targets.size(); ++a) places.targets[a].push_back(values[a]);
  }

  KernelModelReport report_;
  model::ModelRun run_;
  model::MeshNodes nodes_;
  model::MeshCells cells_;
  model::SiteValues values_;
  std::vector<std::uint32_t> solid_;
  std::vector<double> volumes_, up_to_;
};

void append_centers(const SourceKernels& kernels, double share, Places& places) {
  places.at = kernels.centers;
  for (const double volume : kernels.volumes) places.shares.push_back(share * volume);
  for (std::size_t a = 0; a < places.targets.size(); ++a)
    places.targets[a].assign(kernels.values[a].begin(), kernels.values[a].end());
}

FitPlaces places_of_mesh(const Dataset& dataset, const SourceKernels& kernels,
                         const PlaceOptions& options) {
  FitPlaces places;
  places.seen.targets.resize(kernels.values.size());
  places.unseen.targets.resize(kernels.values.size());
  const MeshValues mesh(dataset, options);
  model::Random random(options.seed);
  const std::size_t of_nodes = kernels.count();
  append_centers(kernels, 0.5, places.seen);
  if (mesh.count() == 0) return places;
  const auto wanted = std::min(static_cast<double>(options.most) - static_cast<double>(of_nodes),
                               kPlacesPerNode * static_cast<double>(of_nodes));
  const double per_cell = std::clamp(wanted / static_cast<double>(mesh.count()), 0.01, 2.0);
  double due = 0;
  for (std::size_t i = 0; i < mesh.count(); ++i) {
    due += per_cell;
    const double share = 0.5 * mesh.volume(i) / per_cell;
    if (due >= 1) mesh.append_middle(i, share, places.seen);
    if (due >= 2) mesh.append_random(i, share, random, places.seen);
    due -= std::floor(due);
  }
  for (std::size_t t = 0; t < options.test; ++t)
    mesh.append_random(mesh.random_cell(random), mesh.whole_volume(), random, places.unseen);
  return places;
}

Vec3 random_near(const SourceKernels& kernels, std::size_t i, model::Random& random) {
  const bool is_far = kernels.reconstruction == Reconstruction::kSum && (random.next() & 1) != 0;
  const double sigmas = is_far ? kFarSigmas : kNearSigmas;
  Vec3 at;
  do {
    for (int a = 0; a < 3; ++a) at[a] = random.uniform(-1, 1);
  } while (at.squaredNorm() > 1);
  return kernels.center(i) + sigmas * (kernels.factor(i) * at);
}

// Fills targets with the field's values; leaves out places where it is not defined.
void sample_field(const KernelField& field, const PlaceOptions& options, Places& places) {
  const KernelSampler sampler(field);
  std::vector<KernelSample> samples(places.count());
  data::parallel_ranges(
      {static_cast<std::int64_t>(samples.size()), kPlaceGrain, options.threads, options.stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
          samples[i] = sampler.at(Vec3(places.at.data() + 3 * i));
      });
  const bool is_sum = field.reconstruction() == Reconstruction::kSum;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].is_defined && !is_sum) continue;
    std::copy_n(places.at.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                places.at.begin() + static_cast<std::ptrdiff_t>(3 * kept));
    places.shares[kept++] = places.shares[i];
    places.targets[0].push_back(samples[i].value);
    if (places.targets.size() > 1) places.targets[1].push_back(samples[i].color_value);
  }
  places.at.resize(3 * kept);
  places.shares.resize(kept);
}

FitPlaces places_of_field(const KernelField& field, const SourceKernels& kernels,
                          const PlaceOptions& options) {
  FitPlaces places;
  places.seen.targets.resize(kernels.values.size());
  places.unseen.targets.resize(kernels.values.size());
  model::Random random(options.seed);
  const auto append = [&](const Vec3& at, double share, Places& to) {
    to.at.insert(to.at.end(), {at[0], at[1], at[2]});
    to.shares.push_back(share);
  };
  const std::size_t every =
      std::max<std::size_t>(1, 2 * kernels.count() / std::max<std::size_t>(options.most, 1));
  std::vector<double> up_to;
  double whole = 0;
  for (std::size_t i = 0; i < kernels.count(); ++i) {
    up_to.push_back(whole += kernels.volumes[i]);
    if (i % every != 0) continue;
    const double share = 0.5 * kernels.volumes[i] * static_cast<double>(every);
    append(kernels.center(i), share, places.seen);
    append(random_near(kernels, i, random), share, places.seen);
  }
  for (std::size_t t = 0; t < options.test; ++t) {
    const auto found = std::upper_bound(up_to.begin(), up_to.end(), random.uniform(0, whole));
    const std::size_t i =
        std::min(static_cast<std::size_t>(found - up_to.begin()), up_to.size() - 1);
    append(random_near(kernels, i, random), whole, places.unseen);
  }
  sample_field(field, options, places.seen);
  sample_field(field, options, places.unseen);
  return places;
}

// In random order, so that the first of them are as even as all.
void shuffle(std::uint64_t seed, Places& places) {
  std::vector<std::uint32_t> order(places.count());
  std::iota(order.begin(), order.end(), 0U);
  model::Random random(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.next() % i]);
  Places from = std::move(places);
  places = {};
  places.targets.resize(from.targets.size());
  for (const std::uint32_t i : order) {
    const double* const at = from.at.data() + std::size_t{3} * i;
    places.at.insert(places.at.end(), at, at + 3);
    places.shares.push_back(from.shares[i]);
    for (std::size_t a = 0; a < from.targets.size(); ++a)
      places.targets[a].push_back(from.targets[a][i]);
  }
}

}  // namespace

FitPlaces make_places(const Dataset& dataset, const KernelField& field,
                      const SourceKernels& kernels, const PlaceOptions& options) {
  const bool has_nodes = dataset.kind == DatasetKind::kMesh &&
                         !dataset.array(options.model.array).is_cell_data &&
                         kernels.reconstruction == Reconstruction::kNormalized;
  FitPlaces places = has_nodes ? places_of_mesh(dataset, kernels, options)
                               : places_of_field(field, kernels, options);
  for (Places* of : {&places.seen, &places.unseen}) {
    // Shares of the whole, so that what a place counts has no unit.
    double sum = 0;
    for (const double share : of->shares) sum += share;
    for (double& share : of->shares) share /= sum;
  }
  shuffle(options.seed, places.seen);
  return places;
}

}  // namespace ovoid::fit
