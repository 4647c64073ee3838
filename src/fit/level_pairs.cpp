// SPDX-License-Identifier: Apache-2.0
#include "fit/level_pairs.h"

#include <algorithm>
#include <atomic>

#include "data/parallel.h"

namespace ovoid::fit {
namespace {

using data::LevelAxis;

constexpr std::int64_t kRows = 512, kParts = 16;

// The kernels of an axis, sampled: where each begins, and its values.
struct SampledKernels {
  std::vector<std::int64_t> firsts;
  std::vector<std::vector<float>> values;
};

SampledKernels sampled_kernels(const LevelAxis& axis) {
  SampledKernels kernels;
  for (std::int64_t node = 0; node < axis.num_nodes; ++node) {
    const std::int64_t begin = std::max<std::int64_t>(0, (node - 2) * axis.stride);
    const std::int64_t end = std::min(axis.num_samples, (node + 3) * axis.stride);
    kernels.firsts.push_back(begin);
    std::vector<float>& values = kernels.values.emplace_back();
    for (std::int64_t x = begin; x < end; ++x) {
      const auto r = static_cast<std::size_t>(x % axis.stride);
      const std::int64_t t = node - x / axis.stride - axis.first[r];
      values.push_back(t < 0 || t >= LevelAxis::kTaps ? 0
                                                      : axis.taps[r][static_cast<std::size_t>(t)]);
    }
  }
  return kernels;
}

float product(const SampledKernels& a, std::int64_t i, const SampledKernels& b, std::int64_t j) {
  const auto at = static_cast<std::size_t>(i), to = static_cast<std::size_t>(j);
  const std::int64_t begin = std::max(a.firsts[at], b.firsts[to]);
  const std::int64_t end = std::min(a.firsts[at] + static_cast<std::int64_t>(a.values[at].size()),
                                    b.firsts[to] + static_cast<std::int64_t>(b.values[to].size()));
  double sum = 0;
  for (std::int64_t x = begin; x < end; ++x) {
    sum += static_cast<double>(a.values[at][static_cast<std::size_t>(x - a.firsts[at])]) *
           static_cast<double>(b.values[to][static_cast<std::size_t>(x - b.firsts[to])]);
  }
  return static_cast<float>(sum);
}

}  // namespace

SharedAlong::SharedAlong(const LevelAxis& of, const LevelAxis& with) : begins_{0} {
  const SampledKernels a = sampled_kernels(of), b = sampled_kernels(with);
  for (std::int64_t i = 0; i < of.num_nodes; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const std::int64_t begin = a.firsts[at];
    const std::int64_t end = begin + static_cast<std::int64_t>(a.values[at].size());
    std::int64_t first = std::max<std::int64_t>(0, begin / with.stride - 3);
    const std::int64_t last = std::min(with.num_nodes, (end - 1) / with.stride + 4);
    while (first < last && product(a, i, b, first) == 0) ++first;
    firsts_.push_back(first);
    for (std::int64_t j = first; j < last; ++j) products_.push_back(product(a, i, b, j));
    while (products_.size() > begins_.back() && products_.back() == 0) products_.pop_back();
    begins_.push_back(products_.size());
  }
}

LevelPairs::LevelPairs(const data::LevelBasis& basis)
    : basis_(basis), number_of_(basis.num_weights()) {
  for (int of = 0; of < basis.num_levels(); ++of) {
    auto& coarser = shared_.emplace_back();
    for (int with = of; with < basis.num_levels(); ++with) {
      const auto along = [&](int a) { return SharedAlong(basis.axis(of, a), basis.axis(with, a)); };
      coarser.push_back({along(0), along(1), along(2)});
    }
  }
}

bool LevelPairs::assemble(std::span<const std::uint32_t> nodes, std::size_t most,
                          const data::LevelWork& work) {
  for (const std::uint32_t node : nodes_) number_of_[node] = 0;
  nodes_.assign(nodes.begin(), nodes.end());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    number_of_[nodes[i]] = static_cast<std::uint32_t>(i + 1);
  const auto count = static_cast<std::int64_t>(nodes.size());
  rows_.clear();
  rows_.resize(static_cast<std::size_t>((count + kRows - 1) / kRows));
  std::atomic<std::size_t> entries = 0;
  data::parallel_ranges({count, kRows, work.threads, work.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          Rows& rows = rows_[static_cast<std::size_t>(begin / kRows)];
                          for (std::int64_t i = begin; i < end && entries <= most; ++i)
                            add_row(nodes_[static_cast<std::size_t>(i)], rows);
                          entries += rows.columns.size();
                        });
  if (entries <= most) return true;
  rows_.clear();
  return false;
}

void LevelPairs::add_row(std::uint32_t node, Rows& rows) const {
  int level = 0;
  while (node >= basis_.offset(level + 1)) ++level;
  const Index3 own = basis_.nodes(level);
  const auto within = static_cast<std::int64_t>(node - basis_.offset(level));
  const Index3 at{within % own[0], within / own[0] % own[1], within / (own[0] * own[1])};
  const std::uint32_t number = number_of_[node];
  for (int with = level; with < basis_.num_levels(); ++with) {
    const auto& along =
        shared_[static_cast<std::size_t>(level)][static_cast<std::size_t>(with - level)];
    const Index3 others = basis_.nodes(with);
    const std::span<const float> x = along[0].products(at[0]), y = along[1].products(at[1]),
                                 z = along[2].products(at[2]);
    for (std::size_t k = 0; k < z.size(); ++k) {
      for (std::size_t j = 0; j < y.size(); ++j) {
        const float share = z[k] * y[j];
        const std::int64_t row =
            (along[2].first(at[2]) + static_cast<std::int64_t>(k)) * others[1] +
            along[1].first(at[1]) + static_cast<std::int64_t>(j);
        const std::uint32_t* const numbers =
            number_of_.data() + basis_.offset(with) +
            static_cast<std::size_t>(row * others[0] + along[0].first(at[0]));
        for (std::size_t i = 0; i < x.size(); ++i) {
          if (numbers[i] < number) continue;  // none, or mirrored
          rows.columns.push_back(numbers[i] - 1);
          rows.products.push_back(share * x[i]);
        }
      }
    }
  }
  rows.ends.push_back(rows.columns.size());
}

void LevelPairs::multiply(std::span<const double> values, std::span<double> out,
                          const data::LevelWork& work) const {
  // Each part of the rows has sums of its own, which are added in order.
  const auto num_blocks = static_cast<std::int64_t>(rows_.size());
  std::vector<std::vector<double>> sums(kParts);
  data::parallel_ranges({kParts, 1, work.threads, work.stop}, [&](std::int64_t begin,
                                                                  std::int64_t end) {
    for (std::int64_t part = begin; part < end; ++part) {
      std::vector<double>& sum = sums[static_cast<std::size_t>(part)];
      sum.resize(values.size());
      for (std::int64_t b = part * num_blocks / kParts; b < (part + 1) * num_blocks / kParts; ++b)
        multiply_rows(rows_[static_cast<std::size_t>(b)], static_cast<std::size_t>(b * kRows),
                      values, sum);
    }
  });
  data::parallel_ranges({static_cast<std::int64_t>(out.size()), 4096, work.threads, work.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (auto i = static_cast<std::size_t>(begin);
                               i < static_cast<std::size_t>(end); ++i) {
                            out[i] = 0;
                            for (const std::vector<double>& sum : sums) out[i] += sum[i];
                          }
                        });
}

void LevelPairs::multiply_rows(const Rows& rows, std::size_t first, std::span<const double> values,
                               std::vector<double>& sums) {
  std::size_t entry = 0;
  for (std::size_t r = 0; r < rows.ends.size(); ++r) {
    const std::size_t own = first + r;
    double sum = 0;
    for (; entry < rows.ends[r]; ++entry) {
      const std::uint32_t column = rows.columns[entry];
      const auto product = static_cast<double>(rows.products[entry]);
      sum += product * values[column];
      if (column != own) sums[column] += product * values[own];
    }
    sums[own] += sum;
  }
}

}  // namespace ovoid::fit
