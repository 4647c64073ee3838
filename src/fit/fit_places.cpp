// SPDX-License-Identifier: Apache-2.0
#include "fit/fit_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "data/parallel.h"
#include "model/lattice/noise.h"
#include "model/mesh/mesh_cells.h"
#include "ovoid/fit.h"

namespace ovoid::fit {
namespace {

constexpr std::int64_t kPlaceGrain = 1024;
// Random places near a kernel are within so many sigmas: neighbours' centres are about two away. Of
// a sum every second one is further off, where it fades and a wider kernel would not.
constexpr double kNearSigmas = 1.5, kFarSigmas = 6;
// The domain of a sum ends that many times a kernel's cutoff away from it: a fitted kernel must not
// reach beyond the source's unseen.
constexpr double kReachOfSums = 1.5;
// Places whose kernels are counted together: the rows of all would take gigabytes.
constexpr std::size_t kCountedTogether = 1 << 13;
constexpr std::uint32_t kNoKernel = std::numeric_limits<std::uint32_t>::max();
// Make other random numbers of the same seed.
constexpr std::uint64_t kUnseenSeed = 0x5DEECE66D, kEvenSeed = 0xB5297A4D, kDomainSeed = 0x9E3779B9;

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
    }
  }

  std::size_t count() const noexcept { return solid_.size(); }
  double volume(std::size_t i) const noexcept { return volumes_[i]; }

  Vec3 middle(std::size_t i) const {
    const auto nodes = cells_.nodes(solid_[i]);
    const std::size_t corners = num_corners(cells_.types[solid_[i]]);
    Vec3 sum = Vec3::Zero();
    for (std::size_t n = 0; n < corners; ++n) sum += nodes_.at(nodes[n]);
    return sum / static_cast<double>(corners);
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
    places.sites.push_back(static_cast<std::uint32_t>(i));
    for (std::size_t a = 0; a < places.targets.size(); ++a) places.targets[a].push_back(values[a]);
  }

  KernelModelReport report_;
  model::ModelRun run_;
  model::MeshNodes nodes_;
  model::MeshCells cells_;
  model::SiteValues values_;
  std::vector<std::uint32_t> solid_;
  std::vector<double> volumes_;
};

void append_centers(const SourceKernels& kernels, double share, Places& places) {
  places.at = kernels.centers;
  for (const double volume : kernels.volumes) places.shares.push_back(share * volume);
  places.sites.assign(kernels.count(), kNoSite);
  for (std::size_t a = 0; a < places.targets.size(); ++a)
    places.targets[a].assign(kernels.values[a].begin(), kernels.values[a].end());
}

// The kernel that each place is mostly of; one that is not there where none reaches.
std::vector<std::uint32_t> greatest_at(const KernelOperator& kernels) {
  std::vector<std::uint32_t> greatest(kernels.num_places(), kNoKernel);
  for (std::size_t r = 0; r < kernels.num_places(); ++r) {
    const KernelOperator::Row row = kernels.row(r);
    const auto most = std::max_element(row.entries.begin(), row.entries.end());
    if (most != row.entries.end())
      greatest[row.place] = row.kernels[static_cast<std::size_t>(most - row.entries.begin())];
  }
  return greatest;
}

// Evenly within so many sigmas of a kernel, from its centre.
Vec3 random_offset(const SourceKernels& kernels, std::size_t i, double sigmas,
                   model::Random& random) {
  Vec3 at;
  do {
    for (int a = 0; a < 3; ++a) at[a] = random.uniform(-1, 1);
  } while (at.squaredNorm() > 1);
  return sigmas * (kernels.factor(i) * at);
}

Vec3 random_near(const SourceKernels& kernels, std::size_t i, model::Random& random) {
  const bool is_far = kernels.reconstruction == Reconstruction::kSum && (random.next() & 1) != 0;
  return kernels.center(i) + random_offset(kernels, i, is_far ? kFarSigmas : kNearSigmas, random);
}

// A number by its weight, where sums[i] are those of the weights up to i's.
std::size_t random_by_weight(const std::vector<double>& sums, model::Random& random) {
  const auto found = std::upper_bound(sums.begin(), sums.end(), random.uniform(0, sums.back()));
  return std::min(static_cast<std::size_t>(found - sums.begin()), sums.size() - 1);
}

// Fills targets with the field's values; leaves out places where it is not defined.
void fill_from_field(const KernelField& field, const PlaceOptions& options, Places& places) {
  const std::vector<KernelSample> samples =
      sample_field(field, places.at, options.threads, options.stop);
  const bool is_sum = field.reconstruction() == Reconstruction::kSum;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].is_defined && !is_sum) continue;
    std::copy_n(places.at.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                places.at.begin() + static_cast<std::ptrdiff_t>(3 * kept));
    places.sites[kept] = places.sites[i];
    places.shares[kept++] = places.shares[i];
    places.targets[0].push_back(samples[i].value);
    if (places.targets.size() > 1) places.targets[1].push_back(samples[i].color_value);
  }
  places.at.resize(3 * kept);
  places.shares.resize(kept);
  places.sites.resize(kept);
}

// Cells, in which values are interpolated.
class PlacesInMesh final : public PlaceMaker {
 public:
  PlacesInMesh(const Dataset& dataset, const SourceKernels& kernels, const PlaceOptions& options)
      : PlaceMaker(kernels, options), mesh_(dataset, options) {}

  // Whether there are any that values can be interpolated in.
  bool has_cells() const { return mesh_.count() > 0; }

 private:
  std::size_t num_sites() const override { return mesh_.count(); }
  double volume(std::size_t site) const override { return mesh_.volume(site); }
  Vec3 middle(std::size_t site) const override { return mesh_.middle(site); }
  void append_random(std::size_t site, double share, model::Random& random,
                     Places& places) const override {
    mesh_.append_random(site, share, random, places);
  }
  void append_beside(std::size_t site, const Vec3& /*at*/, double /*sigmas*/, model::Random& random,
                     Places& places) const override {
    mesh_.append_random(site, 1, random, places);
  }

  Places unseen() const override {
    Places places = empty();
    std::vector<double> volumes(mesh_.count());
    double whole = 0;
    for (std::size_t i = 0; i < volumes.size(); ++i) volumes[i] = whole += mesh_.volume(i);
    model::Random random(options_.seed ^ kUnseenSeed);
    for (std::size_t t = 0; t < options_.test; ++t)
      mesh_.append_random(random_by_weight(volumes, random), 1, random, places);
    return places;
  }

  Places seen() const override {
    Places places = empty();
    model::Random random(options_.seed);
    append_centers(kernels_, 0.5, places);
    const auto wanted = static_cast<double>(options_.most) - static_cast<double>(kernels_.count());
    const double per_cell = std::max(wanted / static_cast<double>(mesh_.count()), 0.01);
    double due = 0;
    for (std::size_t i = 0; i < mesh_.count(); ++i) {
      due += per_cell;
      const double share = 0.5 * mesh_.volume(i) / per_cell;
      for (bool is_first = true; due >= 1; --due, is_first = false) {
        if (is_first)
          mesh_.append_middle(i, share, places);
        else
          mesh_.append_random(i, share, random, places);
      }
    }
    return places;
  }

  MeshValues mesh_;
};

// Kernels, near which their field is sampled.
class PlacesNearKernels final : public PlaceMaker {
 public:
  PlacesNearKernels(const KernelField& field, const SourceKernels& kernels,
                    const PlaceOptions& options)
      : PlaceMaker(kernels, options), field_(field) {
    for (std::size_t i = 0; i < kernels.count(); ++i) box_.extend(kernels.center(i));
  }

 private:
  std::size_t num_sites() const override { return kernels_.count(); }
  double volume(std::size_t site) const override { return kernels_.volumes[site]; }
  Vec3 middle(std::size_t site) const override { return kernels_.center(site); }
  void append_random(std::size_t site, double share, model::Random& random,
                     Places& places) const override {
    append(site, random_near(kernels_, site, random), share, places);
  }
  void append_beside(std::size_t site, const Vec3& at, double sigmas, model::Random& random,
                     Places& places) const override {
    append(site, at + random_offset(kernels_, site, sigmas, random), 1, places);
  }
  void fill(Places& places) const override { fill_from_field(field_, options_, places); }

  static void append(std::size_t site, const Vec3& at, double share, Places& places) {
    places.at.insert(places.at.end(), {at[0], at[1], at[2]});
    places.shares.push_back(share);
    places.sites.push_back(static_cast<std::uint32_t>(site));
  }

  Places unseen() const override { return over_domain(options_.test, kUnseenSeed); }

  // Random places wherever a kernel reaches, gaps between kernels included. A kernel is drawn by
  // its volume and a place within its reach: so a place is as likely as kernels reach it, and its
  // share is one over their number. Targets are left out; shares add up to 1.
  Places over_domain(std::size_t count, std::uint64_t seed) const {
    Places places = empty();
    model::Random random(options_.seed ^ seed);
    KernelColumns columns = kernels_.columns();
    if (kernels_.reconstruction == Reconstruction::kSum)
      columns.cutoff = std::min(kReachOfSums * columns.cutoff, KernelColumns::kMaxCutoff);
    std::vector<double> volumes(kernels_.count());
    double whole = 0;
    for (std::size_t i = 0; i < volumes.size(); ++i) volumes[i] = whole += kernels_.det(i);
    while (places.count() < count) {
      const std::size_t i = random_by_weight(volumes, random);
      const Vec3 at = kernels_.center(i) + random_offset(kernels_, i, columns.cutoff, random);
      if (is_in_domain(i, at, columns.cutoff)) append(i, at, 1, places);
    }
    double shares = 0;
    for (std::size_t first = 0; first < count; first += kCountedTogether) {
      const std::size_t number = std::min(kCountedTogether, count - first);
      const KernelOperator reaching(columns, Reconstruction::kSum,
                                    std::span(places.at).subspan(3 * first, 3 * number),
                                    options_.threads, options_.stop);
      for (std::size_t r = 0; r < number; ++r) {
        const KernelOperator::Row row = reaching.row(r);
        const auto kernels = std::max<std::size_t>(row.kernels.size(), 1);
        shares += places.shares[first + row.place] = 1 / static_cast<double>(kernels);
      }
    }
    for (double& share : places.shares) share /= shares;
    return places;
  }

  // Means end at the box of the centres, behind which kernels only go on with what they have
  // inside. Along an axis on which the box is flat there is no end.
  bool is_in_domain(std::size_t i, const Vec3& at, double sigmas) const {
    if (kernels_.reconstruction == Reconstruction::kSum) return true;
    const Vec3 extents = sigmas * kernels_.factor(i).rowwise().norm();
    for (int a = 0; a < 3; ++a) {
      if (box_.sizes()[a] > extents[a] && (at[a] < box_.min()[a] || at[a] > box_.max()[a]))
        return false;
    }
    return true;
  }

  Places seen() const override {
    Places places = empty();
    model::Random random(options_.seed);
    const std::size_t count = kernels_.count();
    const std::size_t every =
        std::max<std::size_t>(1, 2 * count / std::max<std::size_t>(options_.most, 1));
    const std::size_t near = std::max<std::size_t>(2, options_.most / count) - 1;
    double whole = 0;
    for (std::size_t i = 0; i < count; i += every) {
      const double share = 0.5 * kernels_.volumes[i] * static_cast<double>(every);
      append(i, kernels_.center(i), share, places);
      for (std::size_t n = 0; n < near; ++n)
        append(i, random_near(kernels_, i, random), share / static_cast<double>(near), places);
      whole += 2 * share;
    }
    const Places more = over_domain(places.count() / 2, kDomainSeed);
    for (std::size_t n = 0; n < more.count(); ++n) places.append(more, n, whole * more.shares[n]);
    fill(places);
    return places;
  }

  const KernelField& field_;
  Bounds3 box_;  // of the centres
};

// In random order, so that the first of them are as even as all; shares of the whole, so that what
// a place counts has no unit.
Places finished(std::uint64_t seed, const Places& from) {
  std::vector<std::uint32_t> order(from.count());
  std::iota(order.begin(), order.end(), 0U);
  model::Random random(seed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.next() % i]);
  double whole = 0;
  for (const double share : from.shares) whole += share;
  Places places;
  places.targets.resize(from.targets.size());
  for (const std::uint32_t i : order) places.append(from, i, from.shares[i] / whole);
  return places;
}

}  // namespace

std::vector<KernelSample> sample_field(const KernelField& field, std::span<const double> at,
                                       int threads, const std::stop_token& stop) {
  const KernelSampler sampler(field);
  std::vector<KernelSample> samples(at.size() / 3);
  data::parallel_ranges({static_cast<std::int64_t>(samples.size()), kPlaceGrain, threads, stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (auto i = static_cast<std::size_t>(begin);
                               i < static_cast<std::size_t>(end); ++i)
                            samples[i] = sampler.at(Vec3(at.data() + 3 * i));
                        });
  return samples;
}

void Places::append(const Places& from, std::size_t index, double share) {
  const double* const place = from.at.data() + 3 * index;
  at.insert(at.end(), place, place + 3);
  shares.push_back(share);
  sites.push_back(from.sites[index]);
  for (std::size_t a = 0; a < from.targets.size(); ++a) {
    if (!from.targets[a].empty()) targets[a].push_back(from.targets[a][index]);
  }
}

Places PlaceMaker::empty() const {
  Places places;
  places.targets.resize(kernels_.values.size());
  return places;
}

FitPlaces PlaceMaker::make() const {
  Places test = unseen();
  fill(test);
  return {finished(options_.seed, seen()), finished(options_.seed, test)};
}

Places PlaceMaker::make_beside(const Places& places, double sigmas, std::uint64_t seed) const {
  Places beside = empty();
  model::Random random(seed);
  for (std::size_t n = 0; n < places.count(); ++n) {
    if (places.sites[n] == kNoSite) continue;
    append_beside(places.sites[n], Vec3(places.at.data() + 3 * n), sigmas, random, beside);
  }
  fill(beside);
  return beside;
}

Places PlaceMaker::make_evenly(const KernelColumns& kernels, double per_kernel) const {
  const std::size_t num_kernels = kernels.weights.size();
  // Sites that are looked at, and which kernel each belongs to.
  const double wanted = per_kernel * static_cast<double>(num_kernels);
  const std::size_t every =
      std::max<std::size_t>(1, static_cast<std::size_t>(static_cast<double>(num_sites()) / wanted));
  // At random: the sites of a grid, at even steps, would lie in a few planes.
  model::Random random(options_.seed ^ kEvenSeed);
  std::vector<std::size_t> sites;
  std::vector<double> middles;
  for (std::size_t first = 0; first < num_sites(); first += every) {
    const std::size_t count = std::min(every, num_sites() - first);
    sites.push_back(first + random.next() % count);
    const Vec3 at = middle(sites.back());
    middles.insert(middles.end(), {at[0], at[1], at[2]});
  }
  const std::vector<std::uint32_t> owners = greatest_at(
      KernelOperator(kernels, kernels_.reconstruction, middles, options_.threads, options_.stop));
  std::vector<double> owned(num_kernels);
  for (const std::uint32_t owner : owners) {
    if (owner != kNoKernel) owned[owner] += 1;
  }
  Places places = empty();
  for (std::size_t s = 0; s < owners.size(); ++s) {
    if (owners[s] == kNoKernel) continue;
    const double number = per_kernel / owned[owners[s]];
    const double share = volume(sites[s]) / number;
    for (auto due = std::floor(number + random.uniform(0, 1)); due >= 1; --due)
      append_random(sites[s], share, random, places);
  }
  fill(places);
  return finished(options_.seed, places);
}

std::unique_ptr<PlaceMaker> make_place_maker(const Dataset& dataset, const KernelField& field,
                                             const SourceKernels& kernels,
                                             const PlaceOptions& options) {
  const bool has_nodes = dataset.kind == DatasetKind::kMesh &&
                         !dataset.array(options.model.array).is_cell_data &&
                         kernels.reconstruction == Reconstruction::kNormalized;
  if (has_nodes) {
    auto in_mesh = std::make_unique<PlacesInMesh>(dataset, kernels, options);
    if (in_mesh->has_cells()) return in_mesh;
  }
  return std::make_unique<PlacesNearKernels>(field, kernels, options);
}

}  // namespace ovoid::fit
