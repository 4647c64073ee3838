// SPDX-License-Identifier: Apache-2.0
#include "labels/label_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <type_traits>

#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "labels/smooth_brick.h"
#include "ovoid/error.h"

namespace ovoid::labels {
namespace {

constexpr std::uint8_t kNoLabelInByte = 0xFF;
constexpr int kMissing = std::numeric_limits<int>::min();
constexpr double kMostLabel = 1 << 24;  // up to which floats are whole numbers without gaps

// A sample's label; kMissing: it has none. Throws Error(kInvalidArgument) for what is none.
int label_of(double value) {
  if (!std::isfinite(value)) return kMissing;
  if (value != std::round(value) || std::abs(value) > kMostLabel) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("labels: the value {:g} is no label, expected whole numbers up to {}",
                            value, 1 << 24));
  }
  return static_cast<int>(value);
}

// Calls row(first sample's index, [n] labels) for all rows of a brick's samples.
template <class Row>
void for_rows(const BrickSource& source, const Index3& brick, const Row& row) {
  const int edge = source.brick_edge();
  const Index3& dims = source.geometry().dims;
  const BrickView view = source.acquire(brick[0], brick[1], brick[2], 0.0);
  Index3 lo, hi;
  for (std::size_t a = 0; a < 3; ++a) {
    lo[a] = brick[a] * edge;
    hi[a] = std::min(lo[a] + edge, dims[a]);
  }
  std::vector<int> labels(static_cast<std::size_t>(hi[0] - lo[0]));
  data::visit_scalar(view.type, [&]<class T>(std::type_identity<T>) {
    for (std::int64_t z = lo[2]; z < hi[2]; ++z) {
      for (std::int64_t y = lo[1]; y < hi[1]; ++y) {
        const std::int64_t first = (lo[0] - view.lo[0]) + (y - view.lo[1]) * view.stride_y +
                                   (z - view.lo[2]) * view.stride_z;
        T stored{};
        int label = kMissing;
        bool is_known = false;
        for (std::int64_t x = lo[0]; x < hi[0]; ++x) {
          const T next =
              data::load_scalar<T>(static_cast<const std::byte*>(view.data), first + x - lo[0]);
          if (!is_known || next != stored) {
            label =
                label_of(static_cast<double>(next) * source.value_scale() + source.value_offset());
            stored = next;
            is_known = true;
          }
          labels[static_cast<std::size_t>(x - lo[0])] = label;
        }
        row(Index3{lo[0], y, z}, labels);
      }
    }
  });
}

Index3 bricks_of(const BrickSource& source) {
  Index3 num;
  for (std::size_t a = 0; a < 3; ++a)
    num[a] = (source.geometry().dims[a] + source.brick_edge() - 1) / source.brick_edge();
  return num;
}

Index3 nth_brick(const Index3& num, std::int64_t n) {
  return {n % num[0], n / num[0] % num[1], n / num[0] / num[1]};
}

// Every label that occurs, rising.
std::vector<int> all_labels(const BrickSource& source, int threads, const std::stop_token& stop) {
  const Index3 num = bricks_of(source);
  const auto require_few = [](std::size_t num_labels) {
    if (num_labels <= kMostRanks) return;
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("labels: more than {} different values, expected names of things", kMostRanks));
  };
  std::mutex mutex;
  std::vector<int> all;
  data::parallel_ranges({num_samples(num), 16, threads, stop}, [&](auto begin, auto end) {
    std::vector<int> seen;
    for (std::int64_t b = begin; b < end; ++b) {
      for_rows(source, nth_brick(num, b), [&](const Index3&, const std::vector<int>& row) {
        int last = kMissing;
        for (const int label : row) {
          if (label == last) continue;
          last = label;
          if (label == kMissing) continue;
          const auto at = std::lower_bound(seen.begin(), seen.end(), label);
          if (at == seen.end() || *at != label) seen.insert(at, label);
        }
        require_few(seen.size());
      });
    }
    const std::scoped_lock lock(mutex);
    std::vector<int> both;
    std::set_union(all.begin(), all.end(), seen.begin(), seen.end(), std::back_inserter(both));
    all = std::move(both);
  });
  require_few(all.size());
  return all;
}

}  // namespace

LabelGrid::LabelGrid(const LatticeField& field, int threads, const std::stop_token& stop)
    : geometry_(field.geometry()) {
  if (geometry_.kind != LatticeKind::kCartesian)
    throw Error(ErrorCode::kUnsupported,
                "labels: are on Cartesian lattices, not body-centred ones");
  read_labels(field, threads, stop);
  // The cells of the map reach from half a cell before the first sample to half behind the last.
  for (std::size_t a = 0; a < 3; ++a) num_bricks_[a] = geometry_.dims[a] / kBrickEdge + 1;
  find_even_bricks(threads, stop);
  find_steps_to_others();
  bricks_ = std::make_unique<std::atomic<const LabelBrick*>[]>(only_label_.size());
}

LabelGrid::~LabelGrid() {
  if (bricks_ == nullptr) return;
  for (std::size_t b = 0; b < only_label_.size(); ++b) delete bricks_[b].load();
}

void LabelGrid::read_labels(const LatticeField& field, int threads, const std::stop_token& stop) {
  const BrickSource& source = field.samples();
  labels_ = all_labels(source, threads, stop);
  const auto num = static_cast<std::size_t>(num_samples(geometry_.dims));
  if (labels_.size() < kNoLabelInByte) {
    ranks_.emplace<std::vector<std::uint8_t>>(num);
  } else {
    ranks_.emplace<std::vector<std::uint16_t>>(num);
  }
  const Index3 bricks = bricks_of(source);
  std::visit(
      [&](auto& ranks) {
        using T = typename std::remove_reference_t<decltype(ranks)>::value_type;
        data::parallel_ranges({num_samples(bricks), 16, threads, stop}, [&](auto begin, auto end) {
          for (std::int64_t b = begin; b < end; ++b) {
            for_rows(source, nth_brick(bricks, b), [&](const Index3& first, const auto& row) {
              T* out = ranks.data() +
                       (first[2] * geometry_.dims[1] + first[1]) * geometry_.dims[0] + first[0];
              int last = kMissing;
              auto rank = std::numeric_limits<T>::max();
              for (const int label : row) {
                if (label != last) {
                  rank =
                      label == kMissing
                          ? std::numeric_limits<T>::max()
                          : static_cast<T>(std::lower_bound(labels_.begin(), labels_.end(), label) -
                                           labels_.begin());
                  last = label;
                }
                *out++ = rank;
              }
            });
          }
        });
      },
      ranks_);
}

Rank LabelGrid::rank_at(std::int64_t i, std::int64_t j, std::int64_t k) const noexcept {
  const Index3& dims = geometry_.dims;
  i = std::clamp<std::int64_t>(i, 0, dims[0] - 1);
  j = std::clamp<std::int64_t>(j, 0, dims[1] - 1);
  k = std::clamp<std::int64_t>(k, 0, dims[2] - 1);
  const auto at = static_cast<std::size_t>((k * dims[1] + j) * dims[0] + i);
  if (const auto* bytes = std::get_if<0>(&ranks_))
    return (*bytes)[at] == kNoLabelInByte ? kNoLabel : (*bytes)[at];
  return std::get<1>(ranks_)[at];
}

void LabelGrid::copy_window(const Index3& lo, Rank* window) const {
  const Index3& dims = geometry_.dims;
  std::visit(
      [&](const auto& ranks) {
        using T = typename std::remove_reference_t<decltype(ranks)>::value_type;
        const bool is_inside = lo[0] >= 0 && lo[0] + kWindowEdge <= dims[0];
        for (std::int64_t z = 0; z < kWindowEdge; ++z) {
          const std::int64_t k = std::clamp<std::int64_t>(lo[2] + z, 0, dims[2] - 1);
          for (std::int64_t y = 0; y < kWindowEdge; ++y) {
            const std::int64_t j = std::clamp<std::int64_t>(lo[1] + y, 0, dims[1] - 1);
            const T* const row = ranks.data() + (k * dims[1] + j) * dims[0];
            std::array<T, kWindowEdge> own;
            if (is_inside) {
              std::copy_n(row + lo[0], kWindowEdge, own.begin());
            } else {
              for (std::int64_t x = 0; x < kWindowEdge; ++x)
                own[static_cast<std::size_t>(x)] =
                    row[std::clamp<std::int64_t>(lo[0] + x, 0, dims[0] - 1)];
            }
            for (const T rank : own)
              *window++ = rank == std::numeric_limits<T>::max() ? kNoLabel : rank;
          }
        }
      },
      ranks_);
}

// By the labels of 8 x 8 x 8 samples each: where a brick's neighbours have no other, nothing else
// reaches it.
void LabelGrid::find_even_bricks(int threads, const std::stop_token& stop) {
  const auto num = static_cast<std::size_t>(num_samples(num_bricks_));
  std::vector<Rank> own(num);
  const auto for_bricks = [&](const auto& body) {
    data::parallel_ranges({num_samples(num_bricks_), 64, threads, stop}, [&](auto begin, auto end) {
      for (std::int64_t b = begin; b < end; ++b)
        body(static_cast<std::size_t>(b), nth_brick(num_bricks_, b));
    });
  };
  for_bricks([&](std::size_t b, const Index3& brick) {
    Index3 lo, hi;
    for (std::size_t a = 0; a < 3; ++a) {
      lo[a] = std::max<std::int64_t>(brick[a] * kBrickEdge - 1, 0);
      hi[a] = std::min<std::int64_t>((brick[a] + 1) * kBrickEdge - 1, geometry_.dims[a]);
      lo[a] = std::min(lo[a], hi[a] - 1);
    }
    own[b] = std::visit(
        [&](const auto& ranks) {
          using T = typename std::remove_reference_t<decltype(ranks)>::value_type;
          const Index3& dims = geometry_.dims;
          const T first =
              ranks[static_cast<std::size_t>((lo[2] * dims[1] + lo[1]) * dims[0] + lo[0])];
          for (std::int64_t k = lo[2]; k < hi[2]; ++k) {
            for (std::int64_t j = lo[1]; j < hi[1]; ++j) {
              const T* const row = ranks.data() + (k * dims[1] + j) * dims[0];
              unsigned differs = 0;
              for (std::int64_t i = lo[0]; i < hi[0]; ++i) differs |= row[i] ^ first;
              if (differs != 0) return kMixed;
            }
          }
          return first == std::numeric_limits<T>::max() ? kNoLabel : static_cast<Rank>(first);
        },
        ranks_);
  });
  only_label_ = std::vector<std::atomic<Rank>>(num);
  for_bricks([&](std::size_t b, const Index3& brick) {
    Rank only = own[b];
    for (std::int64_t k = -1; k <= 1; ++k) {
      for (std::int64_t j = -1; j <= 1; ++j) {
        for (std::int64_t i = -1; i <= 1; ++i) {
          const Index3 other{brick[0] + i, brick[1] + j, brick[2] + k};
          bool is_there = true;
          for (std::size_t a = 0; a < 3; ++a)
            is_there = is_there && other[a] >= 0 && other[a] < num_bricks_[a];
          if (is_there && own[brick_at(other[0], other[1], other[2])] != only) only = kMixed;
        }
      }
    }
    only_label_[b] = only;
  });
}

// Distances in two sweeps, one from each end: a brick is one step further away than the nearest of
// those that it has beside it.
void LabelGrid::find_steps_to_others() {
  steps_to_others_.assign(only_label_.size(), 255);
  const auto sweep = [&](std::int64_t k, std::int64_t j, std::int64_t i, std::int64_t sign) {
    const std::size_t here = brick_at(i, j, k);
    const Rank own = only_label(here);
    int steps = own == kMixed ? 0 : steps_to_others_[here];
    // The thirteen that the sweep has met.
    for (std::int64_t n = 0; n < 13 && steps > 1; ++n) {
      const std::int64_t x = i + sign * (n % 3 - 1);
      const std::int64_t y = j + sign * (n / 3 % 3 - 1);
      const std::int64_t z = k + sign * (n / 9 - 1);
      if (x < 0 || y < 0 || z < 0 || x >= num_bricks_[0] || y >= num_bricks_[1] ||
          z >= num_bricks_[2])
        continue;
      const std::size_t other = brick_at(x, y, z);
      steps = std::min(steps, only_label(other) == own ? steps_to_others_[other] + 1 : 1);
    }
    steps_to_others_[here] = static_cast<std::uint8_t>(steps);
  };
  for (std::int64_t k = 0; k < num_bricks_[2]; ++k)
    for (std::int64_t j = 0; j < num_bricks_[1]; ++j)
      for (std::int64_t i = 0; i < num_bricks_[0]; ++i) sweep(k, j, i, 1);
  for (std::int64_t k = num_bricks_[2] - 1; k >= 0; --k)
    for (std::int64_t j = num_bricks_[1] - 1; j >= 0; --j)
      for (std::int64_t i = num_bricks_[0] - 1; i >= 0; --i) sweep(k, j, i, -1);
}

const LabelBrick& LabelGrid::brick(std::int64_t i, std::int64_t j, std::int64_t k) const {
  const std::size_t at = brick_at(i, j, k);
  std::atomic<const LabelBrick*>& place = bricks_[at];
  if (const LabelBrick* const made = place.load(std::memory_order_acquire)) return *made;
  thread_local std::vector<Rank> window(kWindowEdge * kWindowEdge * kWindowEdge);
  constexpr std::int64_t kBefore = 1 + kBeforeBrick;
  copy_window({i * kBrickEdge - kBefore, j * kBrickEdge - kBefore, k * kBrickEdge - kBefore},
              window.data());
  auto made = std::make_unique<const LabelBrick>(smoothed_brick(target_, window.data()));
  const LabelBrick* none = nullptr;
  // Two threads may make the same one: the bytes are the same, and the second is dropped.
  if (place.compare_exchange_strong(none, made.get(), std::memory_order_acq_rel)) {
    brick_bytes_ += made->bytes();
    if (made->ranks.size() == 1)
      only_label_[at].store(made->ranks.front(), std::memory_order_relaxed);
    return *made.release();
  }
  return *none;
}

std::size_t LabelGrid::resident_bytes() const noexcept {
  const std::size_t ranks =
      std::visit([](const auto& all) { return all.size() * sizeof(all[0]); }, ranks_);
  const std::size_t per_brick = sizeof(Rank) + sizeof(std::uint8_t) + sizeof(void*);
  return ranks + labels_.size() * sizeof(int) + only_label_.size() * per_brick + brick_bytes_;
}

}  // namespace ovoid::labels
