// SPDX-License-Identifier: Apache-2.0
#include "view/plan/relevance.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "data/kernels/kernel_weight.h"

namespace ovoid::view {
namespace {

// Rounding of float sums is covered by widening bounds by this fraction of their magnitude (64 taps
// of half an ulp each are 4e-6).
constexpr float kBoundSlack = 1e-5F;

// Greatest value of sum_i w |phi(u - i)| of kernels without end: it peaks at the samples, for the
// odd harmonics of two sublattices cancel; where weights are negative, between them.
double greatest_sum(const LatticeField& field) {
  const LatticeKernel kernel = field.index_kernel();
  const double weight = 1 / (field.geometry().density() * std::pow(data::axis_mass(kernel), 3));
  double sum = 0;
  for (int s = 0; s < field.geometry().num_sublattices(); ++s) {
    double along_axis = 0;
    const int most = static_cast<int>(kernel.support_radius()) + 1;
    for (int i = -most; i <= most; ++i) {
      const double d = i - field.geometry().offset_of(s)[0];
      along_axis += data::is_piecewise(kernel.kind)
                        ? std::abs(data::axis_weight(kernel, d))
                        : std::exp(-0.5 * d * d / (kernel.sigma * kernel.sigma));
    }
    sum += along_axis * along_axis * along_axis;
  }
  return weight * sum * (1 + 2 * data::overshoot_of(kernel, /*is_whole=*/true));
}

}  // namespace

RelevanceMap::RelevanceMap(const LatticeField& field, double widening, int grow, double beyond)
    : field_(&field) {
  const BrickSource& source = field.source();
  const int edge = source.brick_edge();
  shift_ = std::countr_zero(static_cast<unsigned>(edge));
  const Index3 cells = field.geometry().cells();
  for (int a = 0; a < 3; ++a) num_bricks_[a] = (cells[a] + edge - 1) / edge;
  for (int a = 0; a < 3; ++a) num_groups_[a] = (num_bricks_[a] + 3) / 4;
  words_per_row_ = static_cast<int>((num_bricks_[0] + 31) / 32);
  words_.assign(static_cast<std::size_t>(words_per_row_ * num_bricks_[1] * num_bricks_[2]), 0);
  groups_.assign(static_cast<std::size_t>(num_samples(num_groups_)), 0);
  double reach = field.index_kernel().support_radius() * widening + beyond;
  // From a brick's faces, which lie on samples, only whole numbers reach other samples.
  if (field.geometry().kind == LatticeKind::kCartesian) reach = std::floor(reach);
  const double missing_reach = std::max(0.0, reach - source.range_reach());
  dilation_ = grow + static_cast<int>(std::ceil(missing_reach / edge - 1e-9));
  sum_bound_ = greatest_sum(field) * 1.0001;
}

void RelevanceMap::fill_layer(int bz, const MayMatter& may_matter) {
  const bool is_sum = field_->reconstruction() == Reconstruction::kSum;
  const LatticeKernel& kernel = field_->kernel();
  const auto overshoot = static_cast<float>(data::overshoot_of(kernel, /*is_whole=*/true));
  const auto most_overshoot = static_cast<float>(data::overshoot_of(kernel, /*is_whole=*/false));
  // Neighbouring bricks often have the same range, background above all.
  ValueRange known;
  bool known_matters = false;
  for (std::int64_t by = 0; by < num_bricks_[1]; ++by) {
    std::uint32_t* row = words_.data() + (bz * num_bricks_[1] + by) * words_per_row_;
    for (std::int64_t bx = 0; bx < num_bricks_[0]; ++bx) {
      const ValueRange range = field_->source().brick_range(bx, by, bz);
      if (range.is_empty()) continue;
      const bool may_overshoot_more =
          overshoot > 0 && range.lo < range.hi && field_->source().has_missing(bx, by, bz);
      if (range.lo == known.lo && range.hi == known.hi && !may_overshoot_more) {
        if (known_matters) row[bx >> 5] |= 1U << (bx & 31);
        continue;
      }
      float lo = range.lo;
      float hi = range.hi;
      if (is_sum) {
        lo = static_cast<float>(std::min(lo, 0.0F) * sum_bound_);
        hi = static_cast<float>(std::max(hi, 0.0F) * sum_bound_);
        // Negative weights turn the ends over.
        if (overshoot > 0) {
          hi = std::max(hi, -lo);
          lo = -hi;
        }
      } else if (overshoot > 0) {
        const float beyond = (hi - lo) * (may_overshoot_more ? most_overshoot : overshoot);
        lo -= beyond;
        hi += beyond;
      }
      lo -= kBoundSlack * std::abs(lo);
      hi += kBoundSlack * std::abs(hi);
      const bool matters = may_matter(lo, hi);
      if (!may_overshoot_more) {
        known = range;
        known_matters = matters;
      }
      if (matters) row[bx >> 5] |= 1U << (bx & 31);
    }
  }
}

void RelevanceMap::fill_everything() {
  std::fill(words_.begin(), words_.end(), ~0U);
  dilation_ = 0;
}

void RelevanceMap::finish() {
  for (int i = 0; i < dilation_; ++i) words_ = grown(words_);
  neighbour_words_ = grown(words_);
  for (std::int64_t bz = 0; bz < num_bricks_[2]; ++bz) {
    for (std::int64_t by = 0; by < num_bricks_[1]; ++by) {
      for (std::int64_t bx = 0; bx < num_bricks_[0]; bx += 4) {
        const auto word = words_[static_cast<std::size_t>(
            (bz * num_bricks_[1] + by) * words_per_row_ + (bx >> 5))];
        const bool any = ((word >> (bx & 31)) & 0xFU) != 0;
        const auto group = ((bz >> 2) * num_groups_[1] + (by >> 2)) * num_groups_[0] + (bx >> 2);
        if (any) groups_[static_cast<std::size_t>(group)] = 1;
      }
    }
  }
}

// The marked bricks and the 26 around each, one axis after the other.
std::vector<std::uint32_t> RelevanceMap::grown(const std::vector<std::uint32_t>& words) const {
  const std::int64_t rows = num_bricks_[1] * num_bricks_[2];
  const auto past = static_cast<unsigned>(num_bricks_[0] % 32);  // of the last word's bits
  const std::uint32_t last_bits = past == 0 ? ~0U : (1U << past) - 1;
  std::vector<std::uint32_t> along_x(words.size());
  for (std::int64_t row = 0; row < rows; ++row) {
    const std::uint32_t* in = words.data() + row * words_per_row_;
    std::uint32_t* out = along_x.data() + row * words_per_row_;
    for (int w = 0; w < words_per_row_; ++w) {
      out[w] = in[w] | in[w] << 1 | in[w] >> 1;
      if (w > 0) out[w] |= in[w - 1] >> 31;
      if (w + 1 < words_per_row_) out[w] |= in[w + 1] << 31;
    }
    out[words_per_row_ - 1] &= last_bits;
  }
  // `stride` words from one of `count` to the next.
  const auto spread = [&](const std::vector<std::uint32_t>& in, std::int64_t stride,
                          std::int64_t count) {
    std::vector<std::uint32_t> out(in.size());
    for (std::size_t i = 0; i < in.size(); ++i) {
      const std::int64_t at = static_cast<std::int64_t>(i) / stride % count;
      out[i] = in[i];
      if (at > 0) out[i] |= in[i - static_cast<std::size_t>(stride)];
      if (at + 1 < count) out[i] |= in[i + static_cast<std::size_t>(stride)];
    }
    return out;
  };
  return spread(spread(along_x, words_per_row_, num_bricks_[1]), words_per_row_ * num_bricks_[1],
                num_bricks_[2]);
}

bool RelevanceMap::any_in(const Vec3& lo, const Vec3& hi) const noexcept {
  Index3 first{};
  Index3 last{};
  for (int a = 0; a < 3; ++a) {
    const double top = static_cast<double>(num_bricks_[a] - 1);
    first[a] =
        static_cast<std::int64_t>(std::clamp(std::floor(std::ldexp(lo[a], -shift_)), 0.0, top));
    last[a] =
        static_cast<std::int64_t>(std::clamp(std::floor(std::ldexp(hi[a], -shift_)), 0.0, top));
  }
  for (std::int64_t gz = first[2] >> 2; gz <= last[2] >> 2; ++gz) {
    for (std::int64_t gy = first[1] >> 2; gy <= last[1] >> 2; ++gy) {
      for (std::int64_t gx = first[0] >> 2; gx <= last[0] >> 2; ++gx) {
        if (groups_[static_cast<std::size_t>((gz * num_groups_[1] + gy) * num_groups_[0] + gx)] ==
            0)
          continue;
        for (std::int64_t bz = std::max(first[2], gz * 4); bz <= std::min(last[2], gz * 4 + 3);
             ++bz) {
          for (std::int64_t by = std::max(first[1], gy * 4); by <= std::min(last[1], gy * 4 + 3);
               ++by) {
            for (std::int64_t bx = std::max(first[0], gx * 4); bx <= std::min(last[0], gx * 4 + 3);
                 ++bx) {
              if (at(bx, by, bz)) return true;
            }
          }
        }
      }
    }
  }
  return false;
}

std::int64_t RelevanceMap::num_relevant() const noexcept {
  std::int64_t count = 0;
  for (const std::uint32_t word : words_) count += std::popcount(word);
  return count;
}

}  // namespace ovoid::view
