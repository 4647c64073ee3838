// SPDX-License-Identifier: Apache-2.0
// What the ways from a dataset to kernels share: the run's settings, checked input columns, and the
// kernels as they are put together before they are sorted into bricks.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/kernel_field.h"
#include "ovoid/kernel_team.h"
#include "ovoid/model.h"

namespace ovoid::model {

// One call of make_kernel_field(): options resolved, report not null.
struct ModelRun {
  const Dataset& dataset;
  const KernelModelOptions& options;
  KernelModelReport& report;
  int threads = 1;
  std::stop_token stop{};
  std::shared_ptr<KernelTeam> team{};  // with others, each of a share of the dataset; null: alone
  std::shared_ptr<const Surface>* surface = nullptr;  // where it goes, of all; null: is not wanted
};

// Kernels site by site; becomes KernelColumns. A column of shapes or weights may hold one for all.
struct KernelParts {
  KernelShape shape = KernelShape::kBalls;
  KernelProfile profile = KernelProfile::kGaussian;
  double cutoff = 4.0;
  Reconstruction reconstruction = Reconstruction::kNormalized;
  std::vector<double> centers;  // [n, 3]
  std::vector<float> shapes;
  std::vector<float> weights;
  std::vector<std::vector<float>> values;
  std::vector<KernelAttribute> attributes;
  std::vector<ValueRange> ranges;  // as KernelColumns has them

  std::size_t count() const noexcept { return centers.size() / 3; }
  Vec3 center(std::size_t i) const noexcept {
    return {centers[3 * i], centers[3 * i + 1], centers[3 * i + 2]};
  }
};

// The parts' columns, borrowed.
KernelColumns columns_of(const KernelParts& parts);

// Work for parallel_ranges() over `count` items of a run.
inline constexpr std::int64_t kSiteGrain = 4096;

// Throws Error(kInvalidArgument) unless the array has `expected` tuples and the bytes for them.
// `noun` names what it has a tuple for: "nodes".
void require_tuples(const DataArray& array, std::int64_t expected, const char* noun);

// The dataset's positions, as doubles. Throws Error(kInvalidArgument) unless they are [n, 3] of a
// floating type with n >= 1 and n < 2^32.
std::vector<double> load_positions(const ModelRun& run);

// Three or four numbers per site of a floating array, as doubles; checked like positions.
std::vector<double> load_tuples(const DataArray& array, std::int64_t expected, int components,
                                const char* noun);

// The arrays that options name, at most two: opacity's, then colour's if it is another.
struct ChosenArrays {
  std::vector<const DataArray*> arrays;
  bool is_cell_data = false;
};

// Throws Error(kInvalidArgument): unknown array; one per node and one per cell.
ChosenArrays choose_arrays(const ModelRun& run);

// The wanted component of each chosen array, a float per site (NaN: missing), and its name and
// unit.
struct SiteValues {
  std::vector<std::vector<float>> columns;
  std::vector<KernelAttribute> attributes;

  bool is_finite(std::size_t site) const noexcept;
};

SiteValues load_values(const ModelRun& run, const ChosenArrays& chosen, std::int64_t num_sites,
                       const char* noun);

// One column, whatever its component options: for masses, radii and densities.
std::vector<float> load_column(const ModelRun& run, const DataArray& array, std::int64_t num_sites,
                               const char* noun);

// Appends site `site` as a kernel's centre and values.
void append_site(KernelParts& parts, const Vec3& center, const SiteValues& values,
                 std::size_t site);

// Appends the six numbers of a factor, as KernelShape::kEllipsoids says. A diagonal that underflows
// a float would be no shape at all, and becomes the least that is one.
void append_factor(const Mat3& factor, std::vector<float>& shapes);

// The ways themselves. Each fills counts and notes of the report that it knows of.
KernelParts mesh_kernels(const ModelRun& run);
KernelParts box_kernels(const ModelRun& run);
KernelParts particle_kernels(const ModelRun& run);
KernelParts stored_kernels(const ModelRun& run);

}  // namespace ovoid::model
