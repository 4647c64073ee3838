// SPDX-License-Identifier: Apache-2.0
#include "model/particles/heaps.h"

#include <algorithm>
#include <span>

namespace ovoid::model {

namespace {

// The kernels of `heap` as the first of them.
void merge(std::span<const std::uint32_t> heap, KernelParts& parts) {
  const std::size_t first = heap.front();
  const auto weight_of = [&](std::size_t i) {
    return parts.weights.empty() ? 1.0 : static_cast<double>(parts.weights[i]);
  };
  double sum = 0;
  for (const std::size_t i : heap) sum += weight_of(i);
  // The colour of a sum weighs by what is summed, which the first column holds until it is merged.
  const bool is_sum = parts.reconstruction == Reconstruction::kSum;
  for (std::size_t a = parts.values.size(); a-- > 0;) {
    std::vector<float>& column = parts.values[a];
    double numerator = 0, denominator = 0;
    for (const std::size_t i : heap) {
      const double share = weight_of(i) * (is_sum && a > 0 ? double{parts.values[0][i]} : 1.0);
      numerator += share * static_cast<double>(column[i]);
      denominator += share;
    }
    if (denominator != 0) column[first] = static_cast<float>(numerator / denominator);
  }
  if (!parts.weights.empty()) parts.weights[first] = static_cast<float>(sum);
}

// Takes the marked items, of `size` numbers each, out of a column.
template <typename T>
void remove_items(const std::vector<bool>& is_gone, std::size_t size, std::vector<T>& column) {
  if (column.size() != size * is_gone.size()) return;  // one for all, or none yet
  std::size_t kept = 0;
  for (std::size_t i = 0; i < is_gone.size(); ++i) {
    if (is_gone[i]) continue;
    for (std::size_t c = 0; c < size; ++c) column[size * kept + c] = column[size * i + c];
    ++kept;
  }
  column.resize(size * kept);
}

}  // namespace

std::int64_t merge_heaps(std::vector<std::uint32_t> candidates, std::size_t least,
                         KernelParts& parts) {
  std::sort(candidates.begin(), candidates.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 p = parts.center(a), q = parts.center(b);
    return p != q ? std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end()) : a < b;
  });
  std::int64_t num_gone = 0;
  std::vector<bool> is_gone;
  for (std::size_t from = 0, to = 0; from < candidates.size(); from = to) {
    while (to < candidates.size() && parts.center(candidates[to]) == parts.center(candidates[from]))
      ++to;
    if (to - from < std::max<std::size_t>(least, 2)) continue;
    if (num_gone == 0) {
      is_gone.resize(parts.count());
      if (parts.weights.size() == 1) parts.weights.assign(parts.count(), float{parts.weights[0]});
      for (const std::vector<float>& column : parts.values) {
        const auto [lo, hi] = std::minmax_element(column.begin(), column.end());
        parts.ranges.push_back({*lo, *hi});
      }
    }
    merge(std::span(candidates).subspan(from, to - from), parts);
    for (std::size_t i = from + 1; i < to; ++i) is_gone[candidates[i]] = true;
    num_gone += static_cast<std::int64_t>(to - from - 1);
  }
  if (num_gone == 0) return 0;
  remove_items(is_gone, static_cast<std::size_t>(num_shape_numbers(parts.shape)), parts.shapes);
  remove_items(is_gone, 1, parts.weights);
  for (std::vector<float>& column : parts.values) remove_items(is_gone, 1, column);
  remove_items(is_gone, 3, parts.centers);
  return num_gone;
}

}  // namespace ovoid::model
