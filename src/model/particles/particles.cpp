// SPDX-License-Identifier: Apache-2.0
// Particles: one ball, or one ellipsoid, each.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "data/bookkeeping.h"
#include "data/kernels/smoothing_codes.h"
#include "data/parallel.h"
#include "model/mesh/ellipsoid_set.h"
#include "model/mesh/ellipsoid_shape.h"
#include "model/mesh/voronoi_sites.h"
#include "model/particles/heaps.h"
#include "model/particles/kernel_parts.h"
#include "model/particles/particle_lengths.h"
#include "model/team/team_run.h"
#include "model/team/team_sites.h"
#include "ovoid/error.h"
#include "ovoid/kernel_field.h"

namespace ovoid::model {

namespace {

constexpr double kParticleCutoff = 4;           // sigma = h / 2 makes that the support 2 h
constexpr double kLeastParticleAxis = 1.0 / 8;  // of the longest, for ellipsoids

// Which arrays say what. Null: none.
struct ParticleRoles {
  bool is_density = false;
  const DataArray* radius = nullptr;
  const DataArray* mass = nullptr;
  const DataArray* density = nullptr;
};

// The array with one of the names, in their order; what is before the last '/' does not count. "h"
// and "m" are small letters: "H" is hydrogen.
const DataArray* find_called(const Dataset& dataset, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    for (const DataArray& array : dataset.arrays) {
      const std::size_t slash = array.name.rfind('/');
      const std::string last =
          slash == std::string::npos ? array.name : array.name.substr(slash + 1);
      if (last == name && array.num_components == 1) return &array;
    }
  }
  return nullptr;
}

const DataArray* find_mass(const Dataset& dataset) {
  return find_called(dataset, {"m", "mass", "Mass", "masses", "Masses"});
}

ParticleRoles find_roles(const ModelRun& run) {
  const Dataset& dataset = run.dataset;
  const KernelModelOptions& options = run.options;
  ParticleRoles roles;
  roles.is_density = draws_density(dataset, options);
  roles.radius =
      !options.radius_array.empty()
          ? &dataset.array(options.radius_array)
          : find_called(dataset, {"h", "hsml", "Hsml", "SmoothingLength", "SmoothingLengths",
                                  "smoothing_length", "smoothing_lengths", "radii"});
  if (!options.mass) {
    roles.mass =
        !options.mass_array.empty() ? &dataset.array(options.mass_array) : find_mass(dataset);
  }
  roles.density = find_called(dataset, {"rho", "density", "Density", "Densities"});
  return roles;
}

[[noreturn]] void refuse_particle(const ModelRun& run, const DataArray& array, std::size_t index,
                                  float value) {
  const std::int64_t first = run.dataset.share ? run.dataset.share->first : 0;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}[{}] = {}: must be > 0", array.name,
                          first + static_cast<std::int64_t>(index), value));
}

// Phantom marks particles that a sink has accreted by h < 0.
bool marks_dead_particles(const Dataset& dataset) {
  return dataset.format.find("Phantom") != std::string::npos;
}

// The particles that become kernels; in a periodic box, inside it.
struct ParticleSites {
  std::vector<double> centers;         // [n, 3]
  std::vector<std::uint32_t> sources;  // index in the dataset
  std::optional<Bounds3> periodic_box;
  std::int64_t num_all = 0;           // of a team's, all processes'; else their own
  std::vector<std::uint64_t> orders;  // of a team's: numbers among all of them, rising

  std::size_t count() const noexcept { return sources.size(); }
};

// The columns of particles, by index in the dataset.
struct ParticleColumns {
  SiteValues values;
  std::vector<float> radius, mass, density;
  bool have_volumes = false;  // mass over density
};

ParticleColumns load_particle_columns(const ModelRun& run, const ParticleRoles& roles) {
  const std::int64_t count = run.dataset.num_positions();
  ParticleColumns columns;
  if (roles.radius != nullptr) columns.radius = load_column(run, *roles.radius, count, "particles");
  columns.have_volumes = !roles.is_density && roles.mass != nullptr && roles.density != nullptr;
  if (roles.mass != nullptr && (roles.is_density || columns.have_volumes))
    columns.mass = load_column(run, *roles.mass, count, "particles");
  if (columns.have_volumes) columns.density = load_column(run, *roles.density, count, "particles");
  if (!roles.is_density) {
    columns.values = load_values(run, choose_arrays(run), count, "particles");
    return columns;
  }
  run.report.array = run.report.color_array = "density";
  columns.values.columns.push_back(std::move(columns.mass));
  columns.mass = {};
  if (roles.mass == nullptr)
    columns.values.columns[0].assign(static_cast<std::size_t>(count),
                                     static_cast<float>(run.options.mass.value_or(1)));
  columns.values.attributes.push_back({"density", "", {}});
  if (run.options.color_array.empty()) return columns;
  const DataArray& color = run.dataset.array(run.options.color_array);
  require_tuples(color, count, "particles");
  SiteValues colors = load_values(run, {{&color}, false}, count, "particles");
  columns.values.columns.push_back(std::move(colors.columns[0]));
  columns.values.attributes.push_back(colors.attributes[0]);
  run.report.color_array = color.name;
  return columns;
}

Vec3 wrapped(const Vec3& place, const Bounds3& box) {
  Vec3 inside = place;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min()[axis], edge = box.sizes()[axis];
    inside[axis] -= std::floor((inside[axis] - low) / edge) * edge;
    inside[axis] = std::clamp(inside[axis], low, box.max()[axis]);  // rounding
  }
  return inside;
}

// Throws on sizes that are not positive, unless the format says what they mean.
bool is_alive(const ModelRun& run, const ParticleRoles& roles, const ParticleColumns& columns,
              std::size_t i) {
  if (roles.radius == nullptr) return true;
  const float radius = columns.radius[i];
  if (radius > 0 && std::isfinite(radius)) return true;
  if (radius < 0 && marks_dead_particles(run.dataset)) return false;
  refuse_particle(run, *roles.radius, i, radius);
}

void check_volume(const ModelRun& run, const ParticleRoles& roles, const ParticleColumns& columns,
                  std::size_t i) {
  if (!columns.have_volumes) return;
  if (!(columns.mass[i] > 0)) refuse_particle(run, *roles.mass, i, columns.mass[i]);
  if (!(columns.density[i] > 0)) refuse_particle(run, *roles.density, i, columns.density[i]);
}

ParticleSites choose_particles(const ModelRun& run, const ParticleRoles& roles,
                               const ParticleColumns& columns) {
  std::vector<double> all = load_positions(run);
  const std::size_t count = all.size() / 3;
  ParticleSites sites;
  sites.periodic_box = run.dataset.periodic_box;
  if (sites.periodic_box && !(sites.periodic_box->sizes().array() > 0).all())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': the periodic box has no volume", run.dataset.source));
  std::vector<std::uint32_t> kept;
  std::int64_t num_dead = 0;
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 at(all[3 * i], all[3 * i + 1], all[3 * i + 2]);
    if (!at.allFinite()) {
      ++run.report.num_misplaced;
    } else if (!is_alive(run, roles, columns, i)) {
      ++num_dead;
    } else if (!columns.values.is_finite(i)) {
      ++run.report.num_missing;
    } else {
      check_volume(run, roles, columns, i);
      if (sites.periodic_box) at = wrapped(at, *sites.periodic_box);
      for (std::size_t a = 0; a < 3; ++a) all[3 * kept.size() + a] = at[static_cast<int>(a)];
      kept.push_back(static_cast<std::uint32_t>(i));
    }
  }
  all.resize(3 * kept.size());
  num_dead = total_of(run, num_dead);
  if (num_dead > 0)
    run.report.notes.push_back(fmt::format(
        "{} particles are accreted ('{}' < 0) and make no kernel", num_dead, roles.radius->name));
  run.report.num_sites = static_cast<std::int64_t>(count);
  sites.num_all = total_of(run, static_cast<std::int64_t>(kept.size()));
  if (sites.num_all == 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': no kernel: of {} particles, {} have no finite value of '{}' and "
                            "{} no finite position",
                            run.dataset.source, count, run.report.num_missing, run.report.array,
                            run.report.num_misplaced));
  sites.centers = std::move(all);
  sites.sources = std::move(kept);
  return sites;
}

// Brings the particles of a team to the processes whose part of space they are in, with what else
// is known of them.
void share_out(const ModelRun& run, ParticleSites& sites, ParticleColumns& columns) {
  SiteRows rows;
  std::uint64_t order = 0;  // of the first that is kept here
  const std::vector<std::uint64_t> counts =
      joined(run, std::vector<std::uint64_t>{sites.sources.size()});
  for (int p = 0; p < run.team->number(); ++p) order += counts[static_cast<std::size_t>(p)];
  rows.orders.resize(sites.count());
  std::iota(rows.orders.begin(), rows.orders.end(), order);
  rows.centers = std::move(sites.centers);
  std::vector<std::vector<float>*> all = {&columns.radius, &columns.mass, &columns.density};
  for (std::vector<float>& column : columns.values.columns) all.push_back(&column);
  // What is there of these is so for all processes, but may have no rows.
  const std::size_t num_rows = sites.count();
  std::vector<std::vector<float>*> moved;
  for (std::vector<float>* const column : all) {
    if (greatest_of(run, static_cast<std::int64_t>(column->size())) == 0) continue;
    moved.push_back(column);
    std::vector<float>& kept = rows.columns.emplace_back(num_rows);
    for (std::size_t i = 0; i < num_rows; ++i) kept[i] = (*column)[sites.sources[i]];
    *column = {};
  }
  rows = share_by_place(run, std::move(rows));
  for (std::size_t c = 0; c < moved.size(); ++c) *moved[c] = std::move(rows.columns[c]);
  sites.centers = std::move(rows.centers);
  sites.orders = std::move(rows.orders);
  sites.sources.resize(sites.orders.size());
  std::iota(sites.sources.begin(), sites.sources.end(), 0U);
}

// The factor of a ball of `sigma` drawn out as its neighbours lie, of the same volume.
Mat3 drawn_out(const float* covariance, double sigma) {
  Mat3 spread;
  spread << covariance[0], covariance[1], covariance[3], covariance[1], covariance[2],
      covariance[4], covariance[3], covariance[4], covariance[5];
  const Mat3 factor = limited_shape(spread, kLeastParticleAxis).factor;
  return factor * (sigma / std::cbrt(factor.determinant()));
}

// Where kernels end, in the lengths that the radii are.
double smoothing_reach(const ModelRun& run) {
  return run.options.smoothing_reach.value_or(data::smoothing_reach(run.dataset.format));
}

// Smoothing lengths into sigmas or factors. Returns the sites that have so many at their own place
// that their neighbours tell no length: their shapes follow from the place alone.
std::vector<std::uint32_t> make_shapes(const ModelRun& run, const ParticleSites& sites,
                                       const ParticleRoles& roles, const ParticleColumns& columns,
                                       KernelParts& parts) {
  const KernelModelOptions& options = run.options;
  parts.profile = options.profile;
  parts.cutoff = options.cutoff.value_or(kParticleCutoff);
  const bool has_radii = roles.radius != nullptr;
  // The array's lengths, in those that kernels end at twice of.
  const double per_radius = has_radii ? smoothing_reach(run) / 2 : 1;
  NearestStatistics nearest;
  if (run.team != nullptr && !has_radii) {
    nearest.lengths = team_lengths(run, sites.centers, sites.num_all, sites.periodic_box);
  } else if (!has_radii || options.anisotropic) {
    nearest =
        nearest_statistics(run, sites.centers, sites.periodic_box,
                           options.anisotropic ? WithCovariances::kYes : WithCovariances::kNo);
  }
  std::vector<std::uint32_t> heaped;
  if (!has_radii) {
    for (std::uint32_t i = 0; i < sites.count(); ++i) {
      if (!(nearest.lengths[i] > 0)) heaped.push_back(i);
    }
    raise_zero_lengths(run, nearest.lengths);
  } else {
    nearest.lengths.resize(sites.count());
    for (std::size_t i = 0; i < sites.count(); ++i)
      nearest.lengths[i] = static_cast<float>(per_radius * columns.radius[sites.sources[i]]);
  }
  // A Gaussian's sigma is h / 2 wherever it is cut; the others end at 2 h.
  const double per_length = options.profile == KernelProfile::kGaussian ? 0.5 : 2 / parts.cutoff;
  parts.shape = options.anisotropic ? KernelShape::kEllipsoids : KernelShape::kBalls;
  if (!options.anisotropic) {
    parts.shapes = std::move(nearest.lengths);
    for (float& sigma : parts.shapes) sigma = static_cast<float>(per_length * sigma);
    return heaped;
  }
  parts.shapes.reserve(6 * sites.count());
  for (std::size_t i = 0; i < sites.count(); ++i)
    append_factor(drawn_out(nearest.covariances.data() + 6 * i, per_length * nearest.lengths[i]),
                  parts.shapes);
  return heaped;
}

double volume_of_shape(const KernelParts& parts, std::size_t i) {
  if (parts.shape == KernelShape::kEllipsoids) {
    const float* l = parts.shapes.data() + 6 * i;
    return static_cast<double>(l[0]) * l[2] * l[5];
  }
  return std::pow(static_cast<double>(parts.shapes[i]), 3);
}

// Throws if not even the greatest density is a number of 32 bits, as values are.
void check_densities(const ModelRun& run, const KernelParts& parts, double integral) {
  double greatest = 0;
  for (std::size_t i = 0; i < parts.count(); ++i) {
    greatest = std::max(greatest, static_cast<double>(std::abs(parts.values[0][i])) /
                                      (integral * volume_of_shape(parts, i)));
  }
  greatest = greatest_of(run, greatest);
  using Values = std::numeric_limits<float>;
  if (greatest == 0 || (greatest >= Values::min() && greatest <= Values::max())) return;
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("'{}': its density is up to about {:.2g}, expected {:.2g} to {:.2g}; give "
                  "lengths or masses in another unit",
                  run.dataset.source, greatest, Values::min(), Values::max()));
}

// Densities: v w = m / integral. The two share it so that neither leaves float32's range where
// lengths are in centimetres of a galaxy.
void weigh_densities(const ModelRun& run, KernelParts& parts) {
  const double integral = profile_integral(parts.profile, parts.cutoff);
  check_densities(run, parts, integral);
  double least = std::numeric_limits<double>::infinity(), greatest = 0;
  for (std::size_t i = 0; i < parts.count(); ++i) {
    const double weight = 1 / (integral * volume_of_shape(parts, i));
    least = std::min(least, weight);
    greatest = std::max(greatest, weight);
  }
  least = least_of(run, least);
  greatest = greatest_of(run, greatest);
  double unit = 1;
  if (least < 1e-30 || greatest > 1e30)
    unit = std::exp2(std::round(-0.5 * (std::log2(least) + std::log2(greatest))));
  parts.weights.resize(parts.count());
  for (std::size_t i = 0; i < parts.count(); ++i)
    parts.weights[i] = static_cast<float>(unit / (integral * volume_of_shape(parts, i)));
  if (unit == 1) return;
  for (std::vector<float>& column : parts.values) {
    for (float& value : column) value = static_cast<float>(static_cast<double>(value) / unit);
  }
}

// Some sites, evenly among all.
struct SizedSite {
  Vec3 at;
  double sigma;
};

std::vector<SizedSite> some_sites(const ModelRun& run, const ParticleSites& sites,
                                  const KernelParts& parts) {
  constexpr std::int64_t kMost = 64;
  const std::int64_t wanted = std::min(kMost, sites.num_all);
  std::vector<SizedSite> own;
  for (std::int64_t s = 0; s < wanted; ++s) {
    const auto order = static_cast<std::uint64_t>((2 * s + 1) * sites.num_all / (2 * wanted));
    std::size_t i = order;
    if (run.team != nullptr) {
      const auto found = std::lower_bound(sites.orders.begin(), sites.orders.end(), order);
      if (found == sites.orders.end() || *found != order) continue;
      i = static_cast<std::size_t>(found - sites.orders.begin());
    }
    own.push_back({parts.center(i), std::cbrt(volume_of_shape(parts, i))});
  }
  return joined(run, std::move(own));
}

// Median over some sites of the sum of all kernels as large as the site's own. Brute force, which
// for so few is cheaper than a tree.
double median_sum(const ModelRun& run, const ParticleSites& sites, const KernelParts& parts) {
  const std::size_t count = parts.count();
  const std::vector<SizedSite> some = some_sites(run, sites, parts);
  const std::size_t samples = some.size();
  std::vector<double> sums(samples);
  data::parallel_ranges(
      {static_cast<std::int64_t>(samples), 1, run.threads, run.stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto s = static_cast<std::size_t>(begin); s < static_cast<std::size_t>(end); ++s) {
          const auto& [at, sigma] = some[s];
          const double reach = sigma * parts.cutoff;
          for (std::size_t j = 0; j < count; ++j) {
            const double square = (parts.center(j) - at).squaredNorm();
            if (square <= reach * reach)
              sums[s] += profile_value(parts.profile, std::sqrt(square) / sigma, parts.cutoff);
          }
        }
      });
  add_of_all(run, sums);
  std::nth_element(sums.begin(), sums.begin() + static_cast<std::ptrdiff_t>(samples / 2),
                   sums.end());
  return sums[samples / 2];
}

// One weight for all, so that the sum of weights is about 1 in the middle of the data. Where h
// comes from the neighbours, V is the support's volume over the particles in it, the same multiple
// of every kernel's volume; else nothing is known but the particles themselves.
float shared_weight(const ModelRun& run, const ParticleSites& sites, const ParticleRoles& roles,
                    const KernelParts& parts) {
  if (roles.radius != nullptr) return static_cast<float>(1 / median_sum(run, sites, parts));
  const double support = parts.profile == KernelProfile::kGaussian ? 4 : parts.cutoff;  // sigmas
  const double volume = 4.0 / 3 * std::numbers::pi * std::pow(support, 3) / run.options.neighbors;
  return static_cast<float>(volume / profile_integral(parts.profile, parts.cutoff));
}

void weigh_attributes(const ModelRun& run, const ParticleSites& sites, const ParticleRoles& roles,
                      const ParticleColumns& columns, KernelParts& parts) {
  if (!columns.have_volumes) {
    parts.weights = {shared_weight(run, sites, roles, parts)};
    return;
  }
  const double integral = profile_integral(parts.profile, parts.cutoff);
  parts.weights.resize(parts.count());
  for (std::size_t i = 0; i < sites.count(); ++i) {
    const std::uint32_t from = sites.sources[i];
    const double volume = static_cast<double>(columns.mass[from]) / columns.density[from];
    parts.weights[i] = static_cast<float>(volume / (integral * volume_of_shape(parts, i)));
  }
}

// Kernels that reach across a face of the periodic box are there once more, beyond the opposite
// one.
void add_images(const ModelRun& run, KernelParts& parts, const Bounds3& box) {
  const std::size_t count = parts.count();
  const auto per_kernel = static_cast<std::size_t>(num_shape_numbers(parts.shape));
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 at = parts.center(i);
    Vec3 reach = Vec3::Constant(parts.shapes[per_kernel * i]);
    if (parts.shape == KernelShape::kEllipsoids) {
      const float* l = parts.shapes.data() + 6 * i;
      reach = {std::abs(l[0]), std::hypot(l[1], l[2]), std::hypot(l[3], l[4], l[5])};
    }
    reach *= parts.cutoff;
    Eigen::Vector3i low, high;  // images in units of the box's edges
    for (int axis = 0; axis < 3; ++axis) {
      high[axis] = at[axis] - reach[axis] < box.min()[axis] ? 1 : 0;
      low[axis] = at[axis] + reach[axis] > box.max()[axis] ? -1 : 0;
    }
    for (int z = low[2]; z <= high[2]; ++z) {
      for (int y = low[1]; y <= high[1]; ++y) {
        for (int x = low[0]; x <= high[0]; ++x) {
          if (x == 0 && y == 0 && z == 0) continue;
          const Vec3 image = at + box.sizes().cwiseProduct(Vec3(x, y, z));
          parts.centers.insert(parts.centers.end(), {image[0], image[1], image[2]});
          for (std::size_t c = 0; c < per_kernel; ++c)
            parts.shapes.push_back(parts.shapes[per_kernel * i + c]);
          if (parts.weights.size() > 1 || count == 1) parts.weights.push_back(parts.weights[i]);
          for (auto& column : parts.values) column.push_back(column[i]);
        }
      }
    }
  }
  run.report.num_copies = static_cast<std::int64_t>(parts.count() - count);
  const std::int64_t num_all = total_of(run, run.report.num_copies);
  if (num_all > 0)
    run.report.notes.push_back(fmt::format(
        "{} kernels reach across a face of the periodic box and are copied there", num_all));
}

}  // namespace

KernelParts particle_kernels(const ModelRun& run) {
  const ParticleRoles roles = find_roles(run);
  if (roles.is_density && !run.options.is_density) {
    run.report.notes.push_back(
        fmt::format("{}; the field is the particles' {} per volume",
                    run.dataset.arrays.empty() ? "there are no arrays" : "no array is named",
                    roles.mass != nullptr || run.options.mass ? "mass" : "number"));
  }
  ParticleColumns columns = load_particle_columns(run, roles);
  ParticleSites sites = choose_particles(run, roles, columns);
  if (run.team != nullptr) share_out(run, sites, columns);
  KernelParts parts;
  parts.attributes = columns.values.attributes;
  parts.values.resize(columns.values.columns.size());
  for (std::size_t a = 0; a < parts.values.size(); ++a) {
    parts.values[a].resize(sites.count());
    for (std::size_t i = 0; i < sites.count(); ++i)
      parts.values[a][i] = columns.values.columns[a][sites.sources[i]];
    columns.values.columns[a] = {};
  }
  if (run.options.neighborhood == Neighborhood::kVoronoi && !roles.is_density &&
      roles.radius == nullptr) {
    parts.centers = std::move(sites.centers);
    std::vector<std::uint32_t> all(sites.count());
    std::iota(all.begin(), all.end(), 0U);
    run.report.num_merged =
        merge_heaps(std::move(all), static_cast<std::size_t>(run.options.neighbors), parts);
    std::vector<SiteKernel> kernels = voronoi_kernels(parts.centers, run.stop);
    return fit_ellipsoids(run, {std::move(parts), std::move(kernels)});
  }
  std::vector<std::uint32_t> heaped = make_shapes(run, sites, roles, columns, parts);
  parts.centers = std::move(sites.centers);
  parts.reconstruction = run.options.reconstruction.value_or(
      roles.is_density ? Reconstruction::kSum : Reconstruction::kNormalized);
  if (roles.is_density) {
    weigh_densities(run, parts);
  } else {
    weigh_attributes(run, sites, roles, columns, parts);
  }
  run.report.num_merged = merge_heaps(std::move(heaped), 2, parts);
  run.report.num_degenerate -= run.report.num_merged;  // those that went had no length
  if (sites.periodic_box) add_images(run, parts, *sites.periodic_box);
  return parts;
}

}  // namespace ovoid::model

namespace ovoid {

bool draws_density(const Dataset& dataset, const KernelModelOptions& options) {
  if (dataset.kind != DatasetKind::kParticles) return false;
  if (options.is_density) return *options.is_density;
  if (!options.array.empty() || !options.color_array.empty()) return false;
  const auto any = [&](const auto& is_wanted) {
    return std::any_of(dataset.arrays.begin(), dataset.arrays.end(), is_wanted);
  };
  const bool has_mass =
      options.mass || !options.mass_array.empty() || model::find_mass(dataset) != nullptr;
  if (has_mass && !any([](const DataArray& array) { return data::is_density(array); })) return true;
  return !any([&](const DataArray& array) {
    return !data::is_bookkeeping(dataset, array) && !data::is_part_of_vector(dataset, array);
  });
}

}  // namespace ovoid
