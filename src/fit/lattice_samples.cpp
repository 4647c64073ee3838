// SPDX-License-Identifier: Apache-2.0
#include "fit/lattice_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "data/lattice/sample_reader.h"
#include "data/parallel.h"
#include "fit/fit_goal.h"
#include "ovoid/model.h"

namespace ovoid::fit {
namespace {

void check_lattice(const Dataset& dataset, const std::string& what) {
  if (dataset.kind != DatasetKind::kLattice)
    refuse_fit(fmt::format("'{}' is no lattice", dataset.source));
  if (dataset.lattice.kind != LatticeKind::kCartesian)
    refuse_fit(
        fmt::format("{} hold Cartesian lattices, this one is body-centred: expected the "
                    "Cartesian lattice that it was made of",
                    what));
  const std::int64_t count = num_samples(dataset.lattice.dims);
  if (count > std::int64_t{std::numeric_limits<std::uint32_t>::max()})
    refuse_fit(fmt::format("{} samples: {} hold fewer than 2^32", count, what));
}

double background_of(const LatticeSamples& samples) {
  if (!(samples.greatest > samples.least)) return samples.least;
  constexpr int kBins = 4096;
  struct Bin {
    std::int64_t count = 0;
    double sum = 0;
  };
  std::vector<Bin> bins(kBins);
  const double scale = kBins / (samples.greatest - samples.least);
  for (const float value : samples.values) {
    if (value != value) continue;
    const double at = (static_cast<double>(value) - samples.least) * scale;
    Bin& bin = bins[static_cast<std::size_t>(std::min(at, kBins - 1.0))];
    ++bin.count;
    bin.sum += static_cast<double>(value);
  }
  const auto most = std::max_element(bins.begin(), bins.end(),
                                     [](const Bin& a, const Bin& b) { return a.count < b.count; });
  return most->sum / static_cast<double>(most->count);
}

void read_values(const LatticeField& field, const SampleChoice& choice, LatticeSamples& samples) {
  const BrickSource& source = field.samples();
  samples.dims = source.geometry().dims;
  const Index3& dims = samples.dims;
  samples.values.resize(static_cast<std::size_t>(num_samples(dims)));
  data::parallel_ranges({dims[2], 4, choice.threads, choice.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          data::SampleReader reader(source);
                          auto* to = samples.values.data() + begin * dims[0] * dims[1];
                          for (std::int64_t z = begin; z < end; ++z) {
                            for (std::int64_t y = 0; y < dims[1]; ++y) {
                              for (std::int64_t x = 0; x < dims[0]; ++x)
                                *to++ = reader.at({x, y, z});
                            }
                          }
                        });
}

void find_range(LatticeSamples& samples) {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -least;
  for (const float value : samples.values) {
    if (value != value) {
      ++samples.num_missing;
      continue;
    }
    least = std::min(least, static_cast<double>(value));
    greatest = std::max(greatest, static_cast<double>(value));
  }
  if (!(least <= greatest)) return;
  samples.least = least;
  samples.greatest = greatest;
  samples.background = background_of(samples);
}

}  // namespace

LatticeSamples read_lattice_samples(const Dataset& dataset, const SampleChoice& choice,
                                    const std::string& what) {
  check_lattice(dataset, what);
  LatticeModelOptions model;
  model.component = choice.component;
  model.prefilter = false;
  model.threads = choice.threads;
  Dataset stored = dataset;
  stored.arrays = {dataset.array(choice.array)};
  DataArray& array = stored.arrays[0];
  LatticeSamples samples;
  samples.array = array.name;
  samples.whole = !is_floating(array.type) && size_of(array.type) <= 2 && model.component >= 0;
  if (samples.whole) {
    samples.scale = std::exchange(array.value_scale, 1.0);
    samples.offset = std::exchange(array.value_offset, 0.0);
  }
  samples.field = make_lattice_field(stored, model, nullptr, choice.stop);
  read_values(*samples.field, choice, samples);
  find_range(samples);
  return samples;
}

}  // namespace ovoid::fit
