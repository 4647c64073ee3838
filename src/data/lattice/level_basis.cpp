// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/level_basis.h"

#include <algorithm>
#include <cmath>

#include "data/parallel.h"
#include "ovoid/kernel_field.h"
#include "ovoid/lattice_levels.h"

namespace ovoid::data {
namespace {

// Planes of samples that are made together; the planes of nodes between them are made twice.
constexpr std::int64_t kPlanes = 16;
// Room before and behind a row of nodes, for taps of nodes that are not there.
constexpr std::int64_t kRoom = LevelAxis::kTaps;

void add(float factor, const float* from, std::int64_t count, float* to) {
  for (std::int64_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

bool is_zero(const float* values, std::int64_t count) {
  return std::all_of(values, values + count, [](float value) { return value == 0; });
}

// From a row of nodes, with kRoom around it, to samples.
void expand_row(const LevelAxis& axis, const float* nodes, float* samples) {
  if (axis.stride == 1) {
    const auto& taps = axis.taps[0];
    for (std::int64_t x = 0; x < axis.num_samples; ++x)
      samples[x] = taps[0] * nodes[x - 1] + taps[1] * nodes[x] + taps[2] * nodes[x + 1];
    return;
  }
  for (std::int64_t x = 0, i = 0; x < axis.num_samples; ++i) {
    for (std::size_t r = 0; r < axis.taps.size() && x < axis.num_samples; ++r, ++x) {
      const float* const from = nodes + i + axis.first[r];
      const auto& taps = axis.taps[r];
      samples[x] = taps[0] * from[0] + taps[1] * from[1] + taps[2] * from[2] + taps[3] * from[3];
    }
  }
}

// The transpose; `nodes` with kRoom around it.
void reduce_row(const LevelAxis& axis, const float* samples, float* nodes) {
  std::fill(nodes - kRoom, nodes + axis.num_nodes + kRoom, 0.0F);
  for (std::int64_t x = 0, i = 0; x < axis.num_samples; ++i) {
    for (std::size_t r = 0; r < axis.taps.size() && x < axis.num_samples; ++r, ++x) {
      float* const to = nodes + i + axis.first[r];
      for (std::size_t t = 0; t < LevelAxis::kTaps; ++t) to[t] += axis.taps[r][t] * samples[x];
    }
  }
}

// Calls visit(node, tap) for the nodes that reach a sample.
template <class Visit>
void visit_nodes(const LevelAxis& axis, std::int64_t sample, const Visit& visit) {
  const std::int64_t i = sample / axis.stride;
  const auto r = static_cast<std::size_t>(sample % axis.stride);
  for (std::size_t t = 0; t < LevelAxis::kTaps; ++t) {
    const std::int64_t node = i + axis.first[r] + static_cast<std::int64_t>(t);
    if (node >= 0 && node < axis.num_nodes && axis.taps[r][t] != 0) visit(node, axis.taps[r][t]);
  }
}

// Calls visit(sample, tap) for the samples that a node reaches.
template <class Visit>
void visit_samples(const LevelAxis& axis, std::int64_t node, const Visit& visit) {
  const std::int64_t begin = std::max<std::int64_t>(0, (node - 2) * axis.stride);
  const std::int64_t end = std::min(axis.num_samples, (node + 3) * axis.stride);
  for (std::int64_t x = begin; x < end; ++x) {
    const auto r = static_cast<std::size_t>(x % axis.stride);
    const std::int64_t t = node - x / axis.stride - axis.first[r];
    if (t < 0 || t >= LevelAxis::kTaps) continue;
    const float tap = axis.taps[r][static_cast<std::size_t>(t)];
    if (tap != 0) visit(x, tap);
  }
}

}  // namespace

LevelAxis::LevelAxis(std::int64_t samples, int level)
    : num_samples(samples), stride(std::int64_t{1} << level) {
  num_nodes = (num_samples + stride - 1) / stride;
  const auto size = static_cast<double>(stride);
  for (std::int64_t r = 0; r < stride; ++r) {
    // From the middle of the sample's own block, in blocks.
    const double at = (static_cast<double>(r) - (size - 1) / 2) / size;
    const int start = at < 0 ? -2 : -1;
    std::array<float, kTaps> row{};
    for (int t = 0; t < kTaps; ++t) {
      const double distance = std::abs(at - (start + t));
      if (distance < LatticeLevels::kReach) {
        row[static_cast<std::size_t>(t)] = static_cast<float>(
            profile_value(KernelProfile::kGaussian, distance / LatticeLevels::kSigma,
                          LatticeLevels::kReach / LatticeLevels::kSigma));
      }
    }
    first.push_back(start);
    taps.push_back(row);
  }
}

std::vector<double> LevelAxis::squared_norms() const {
  std::vector<double> norms(static_cast<std::size_t>(num_nodes));
  for (std::int64_t node = 0; node < num_nodes; ++node) {
    visit_samples(*this, node, [&](std::int64_t, float tap) {
      norms[static_cast<std::size_t>(node)] += static_cast<double>(tap) * static_cast<double>(tap);
    });
  }
  return norms;
}

std::vector<std::array<double, LevelAxis::kTaps>> LevelAxis::products() const {
  std::vector<std::array<double, kTaps>> products(static_cast<std::size_t>(num_nodes));
  for (std::int64_t x = 0; x < num_samples; ++x) {
    visit_nodes(*this, x, [&](std::int64_t i, float of_i) {
      visit_nodes(*this, x, [&](std::int64_t other, float of_other) {
        if (other <= i)
          products[static_cast<std::size_t>(i)][static_cast<std::size_t>(i - other)] +=
              static_cast<double>(of_i) * static_cast<double>(of_other);
      });
    });
  }
  return products;
}

LevelBasis::LevelBasis(const Index3& dims, int num_levels) : dims_(dims), offsets_{0} {
  for (int level = 0; level < num_levels; ++level) {
    axes_.push_back(
        {LevelAxis(dims[0], level), LevelAxis(dims[1], level), LevelAxis(dims[2], level)});
    offsets_.push_back(offsets_.back() +
                       static_cast<std::size_t>(ovoid::num_samples(nodes(level))));
  }
}

Index3 LevelBasis::nodes(int level) const noexcept {
  return {axis(level, 0).num_nodes, axis(level, 1).num_nodes, axis(level, 2).num_nodes};
}

std::size_t LevelBasis::num_samples() const noexcept {
  return static_cast<std::size_t>(ovoid::num_samples(dims_));
}

void LevelBasis::expand(std::span<const float> weights, int first, int last, float factor,
                        std::span<float> samples, const LevelWork& work) const {
  parallel_ranges(
      {dims_[2], kPlanes, work.threads, work.stop}, [&](std::int64_t begin, std::int64_t end) {
        for (int level = first; level < last; ++level)
          expand_planes(weights.subspan(offset(level)), level, begin, end, factor, samples);
      });
}

void LevelBasis::expand_level(std::span<const float> weights, int level, float factor,
                              std::span<float> samples, const LevelWork& work) const {
  parallel_ranges({dims_[2], kPlanes, work.threads, work.stop},
                  [&](std::int64_t begin, std::int64_t end) {
                    expand_planes(weights, level, begin, end, factor, samples);
                  });
}

void LevelBasis::expand_planes(std::span<const float> of_level, int level, std::int64_t begin,
                               std::int64_t end, float factor, std::span<float> samples) const {
  const LevelAxis &x = axis(level, 0), &y = axis(level, 1), &z = axis(level, 2);
  const std::int64_t plane_size = dims_[0] * dims_[1];
  std::vector<float> padded(static_cast<std::size_t>(x.num_nodes + 2 * kRoom));
  std::vector<float> rows(static_cast<std::size_t>(y.num_nodes * dims_[0]));
  std::vector<char> is_row(static_cast<std::size_t>(y.num_nodes));
  // The last planes of nodes, along x and y already samples.
  std::array<std::vector<float>, LevelAxis::kTaps + 1> planes;
  std::array<std::int64_t, LevelAxis::kTaps + 1> plane_nodes;
  std::array<bool, LevelAxis::kTaps + 1> is_plane{};
  plane_nodes.fill(-1);
  const auto make_plane = [&](std::int64_t node) -> std::size_t {
    const auto slot = static_cast<std::size_t>(node) % planes.size();
    if (plane_nodes[slot] == node) return slot;
    plane_nodes[slot] = node;
    is_plane[slot] = false;
    const float* const from =
        of_level.data() + static_cast<std::size_t>(node * x.num_nodes * y.num_nodes);
    for (std::int64_t j = 0; j < y.num_nodes; ++j) {
      const float* const row = from + j * x.num_nodes;
      is_row[static_cast<std::size_t>(j)] = static_cast<char>(!is_zero(row, x.num_nodes));
      if (is_row[static_cast<std::size_t>(j)] == 0) continue;
      is_plane[slot] = true;
      std::copy(row, row + x.num_nodes, padded.data() + kRoom);
      expand_row(x, padded.data() + kRoom, rows.data() + j * dims_[0]);
    }
    if (!is_plane[slot]) return slot;
    planes[slot].assign(static_cast<std::size_t>(plane_size), 0);
    for (std::int64_t sample = 0; sample < dims_[1]; ++sample) {
      visit_nodes(y, sample, [&](std::int64_t j, float tap) {
        if (is_row[static_cast<std::size_t>(j)] != 0)
          add(tap, rows.data() + j * dims_[0], dims_[0], planes[slot].data() + sample * dims_[0]);
      });
    }
    return slot;
  };
  for (std::int64_t sample = begin; sample < end; ++sample) {
    visit_nodes(z, sample, [&](std::int64_t node, float tap) {
      const std::size_t slot = make_plane(node);
      if (is_plane[slot])
        add(factor * tap, planes[slot].data(), plane_size, samples.data() + sample * plane_size);
    });
  }
}

void LevelBasis::reduce(std::span<const float> samples, int first, int last,
                        std::span<float> weights, const LevelWork& work) const {
  for (int level = first; level < last; ++level) {
    parallel_ranges({axis(level, 2).num_nodes, 1, work.threads, work.stop},
                    [&](std::int64_t begin, std::int64_t end) {
                      for (std::int64_t node = begin; node < end; ++node)
                        reduce_plane(samples, level, node, weights);
                    });
  }
}

void LevelBasis::reduce_plane(std::span<const float> samples, int level, std::int64_t node,
                              std::span<float> weights) const {
  const LevelAxis &x = axis(level, 0), &y = axis(level, 1), &z = axis(level, 2);
  const std::int64_t plane_size = dims_[0] * dims_[1];
  std::vector<float> plane(static_cast<std::size_t>(plane_size));
  visit_samples(z, node, [&](std::int64_t sample, float tap) {
    add(tap, samples.data() + sample * plane_size, plane_size, plane.data());
  });
  std::vector<float> row(static_cast<std::size_t>(dims_[0]));
  std::vector<float> padded(static_cast<std::size_t>(x.num_nodes + 2 * kRoom));
  float* to =
      weights.data() + offset(level) + static_cast<std::size_t>(node * x.num_nodes * y.num_nodes);
  for (std::int64_t j = 0; j < y.num_nodes; ++j, to += x.num_nodes) {
    std::fill(row.begin(), row.end(), 0.0F);
    visit_samples(y, j, [&](std::int64_t sample, float tap) {
      add(tap, plane.data() + sample * dims_[0], dims_[0], row.data());
    });
    reduce_row(x, row.data(), padded.data() + kRoom);
    std::copy_n(padded.data() + kRoom, x.num_nodes, to);
  }
}

}  // namespace ovoid::data
