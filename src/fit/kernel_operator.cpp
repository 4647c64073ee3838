// SPDX-License-Identifier: Apache-2.0
// Rows of the operator. Input: kernels, places. Output: for each place the kernels that reach it
// and what of the field each is. Places are sorted along a Morton curve, so that neighbours are
// found together and a product walks through memory in order; they are dealt out in chunks, each of
// which keeps its rows by itself.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <utility>

#include "data/parallel.h"
#include "model/particles/kernel_groups.h"
#include "model/particles/site_order.h"
#include "ovoid/error.h"
#include "ovoid/fit.h"

namespace ovoid {
namespace {

using model::KernelGroups;

constexpr std::size_t kChunkPlaces = 1024;
constexpr std::size_t kPlacesAtATime = 16;  // for which neighbours are found together
// A splat adds up in so many sums, each of its own range of chunks, which are added in order.
constexpr std::size_t kHands = 8;

struct Chunk {
  std::vector<std::uint32_t> starts;  // [places + 1]
  std::vector<std::uint32_t> kernels;
  std::vector<float> entries;
};

void require_length(const char* name, std::size_t length, std::size_t expected) {
  if (length == expected) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: has {} numbers, expected {}", name, length, expected));
}

// [n, 6] of a column that may hold one for all, or balls.
std::vector<float> ellipsoids_of(const KernelColumns& kernels, std::size_t count) {
  const auto per_kernel = static_cast<std::size_t>(num_shape_numbers(kernels.shape));
  const bool is_one = kernels.shapes.size() == per_kernel && count != 1;
  if (!is_one) require_length("shapes", kernels.shapes.size(), per_kernel * count);
  std::vector<float> shapes(6 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const float* const from = kernels.shapes.data() + (is_one ? 0 : per_kernel * i);
    float* const to = shapes.data() + 6 * i;
    if (kernels.shape == KernelShape::kBalls) {
      to[0] = to[2] = to[5] = from[0];
    } else {
      std::copy_n(from, 6, to);
    }
    for (const std::size_t diagonal : {0, 2, 5}) {
      if (to[diagonal] > 0 && std::isfinite(to[diagonal])) continue;
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("shapes[{}]: {} must be > 0", i, to[diagonal]));
    }
  }
  return shapes;
}

void require_finite(const char* name, std::span<const double> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (std::isfinite(numbers[i])) continue;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}[{}] = {}: must be finite", name, i / 3, numbers[i]));
  }
}

}  // namespace

struct KernelOperator::Impl {
  std::size_t num_kernels = 0;
  int threads = 1;
  std::vector<std::uint32_t> order;  // of the places
  std::vector<Chunk> chunks;
  std::vector<float> weights;
  std::vector<bool> is_defined;

  std::size_t first_place(std::size_t chunk) const noexcept { return chunk * kChunkPlaces; }
  std::size_t num_places(std::size_t chunk) const noexcept {
    return std::min(kChunkPlaces, order.size() - first_place(chunk));
  }

  // Calls body(chunk) for every chunk, from several threads.
  template <class Body>
  void for_chunks(const std::stop_token& stop, const Body& body) const {
    data::parallel_ranges({static_cast<std::int64_t>(chunks.size()), 1, threads, stop},
                          [&](std::int64_t begin, std::int64_t end) {
                            for (auto c = static_cast<std::size_t>(begin);
                                 c < static_cast<std::size_t>(end); ++c)
                              body(c);
                          });
  }

  // For each kernel the sum of term(entry, number of the place).
  template <class Term>
  std::vector<double> splat(std::span<const double> numbers, const Term& term) const {
    require_length("numbers", numbers.size(), order.size());
    const std::size_t hands = std::min(kHands, std::max<std::size_t>(chunks.size(), 1));
    std::vector<std::vector<double>> sums(hands);
    data::parallel_ranges({static_cast<std::int64_t>(hands), 1, threads}, [&](std::int64_t begin,
                                                                              std::int64_t end) {
      for (auto h = static_cast<std::size_t>(begin); h < static_cast<std::size_t>(end); ++h) {
        std::vector<double>& sum = sums[h];
        sum.assign(num_kernels, 0.0);
        for (std::size_t c = h * chunks.size() / hands; c < (h + 1) * chunks.size() / hands; ++c) {
          const Chunk& chunk = chunks[c];
          for (std::size_t k = 0; k < num_places(c); ++k) {
            const double number = numbers[order[first_place(c) + k]];
            for (std::uint32_t e = chunk.starts[k]; e < chunk.starts[k + 1]; ++e)
              sum[chunk.kernels[e]] += term(static_cast<double>(chunk.entries[e]), number);
          }
        }
      }
    });
    for (std::size_t h = 1; h < hands; ++h) {
      for (std::size_t i = 0; i < num_kernels; ++i) sums[0][i] += sums[h][i];
    }
    return std::move(sums[0]);
  }
};

namespace {

// What finds a chunk's rows.
struct RowFinder {
  const KernelGroups& groups;
  std::span<const float> kernel_weights;  // [n], or one
  std::span<const double> places;
  std::span<const std::uint32_t> order;
  bool is_normalized;

  Vec3 place(std::size_t sorted) const {
    const double* const at = places.data() + std::size_t{3} * order[sorted];
    return {at[0], at[1], at[2]};
  }

  float weight_of(std::uint32_t kernel) const {
    return kernel_weights.size() == 1 ? kernel_weights[0] : kernel_weights[kernel];
  }

  // Appends a row; returns its sum of weights.
  double append_row(const Vec3& at, const std::vector<std::uint32_t>& near, Chunk& chunk) const {
    KernelGroups::Squares squares;
    const std::size_t first = chunk.kernels.size();
    double sum = 0;
    for (const std::uint32_t g : near) {
      if (!groups.may_reach(g, at)) continue;
      groups.find_squares(g, at, squares);
      for (std::size_t i = 0; i < groups.size_of(g); ++i) {
        if (!(squares[i] <= groups.most_square())) continue;
        const std::uint32_t kernel = groups.kernel(g, i);
        const float entry = weight_of(kernel) * groups.profile(squares[i]);
        if (!(entry > 0)) continue;
        chunk.kernels.push_back(kernel);
        chunk.entries.push_back(entry);
        sum += static_cast<double>(entry);
      }
    }
    if (is_normalized && !(sum >= KernelField::kLeastWeight)) {
      chunk.kernels.resize(first);
      chunk.entries.resize(first);
    } else if (is_normalized) {
      for (std::size_t e = first; e < chunk.entries.size(); ++e)
        chunk.entries[e] = static_cast<float>(static_cast<double>(chunk.entries[e]) / sum);
    }
    return sum;
  }

  // The rows of `count` places from `first` on, and their sums of weights by the places' numbers.
  void find(std::size_t first, std::size_t count, Chunk& chunk, std::vector<float>& weights) const {
    std::vector<std::uint32_t> near;
    chunk.starts.assign(1, 0);
    for (std::size_t k = 0; k < count; k += kPlacesAtATime) {
      const std::size_t end = std::min(count, k + kPlacesAtATime);
      Bounds3 box;
      for (std::size_t i = k; i < end; ++i) box.extend(place(first + i));
      near.clear();
      groups.find_near(box, near);
      for (std::size_t i = k; i < end; ++i) {
        weights[order[first + i]] = static_cast<float>(append_row(place(first + i), near, chunk));
        chunk.starts.push_back(static_cast<std::uint32_t>(chunk.kernels.size()));
      }
    }
    chunk.kernels.shrink_to_fit();
    chunk.entries.shrink_to_fit();
  }
};

}  // namespace

KernelOperator::KernelOperator(const KernelColumns& kernels, Reconstruction reconstruction,
                               BorrowedValues<double> places, int threads, std::stop_token stop)
    : impl_(std::make_unique<Impl>()) {
  Impl& own = *impl_;
  const std::size_t count = kernels.centers.size() / 3;
  if (count == 0) throw Error(ErrorCode::kInvalidArgument, "centers: holds no kernels");
  require_length("centers", kernels.centers.size(), 3 * count);
  require_length("places", places.size(), places.size() / 3 * 3);
  require_finite("centers", kernels.centers);
  require_finite("places", places);
  if (kernels.profile != KernelProfile::kGaussian)
    throw Error(ErrorCode::kInvalidArgument, "profile: must be Gaussian");
  if (!(kernels.cutoff >= 1 && kernels.cutoff <= KernelColumns::kMaxCutoff))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("cutoff = {}: must be 1 to {:g}", kernels.cutoff, KernelColumns::kMaxCutoff));
  if (kernels.weights.size() != 1) require_length("weights", kernels.weights.size(), count);
  try {
    own.num_kernels = count;
    own.threads = data::resolve_threads(threads);
    const std::vector<float> shapes = ellipsoids_of(kernels, count);
    const KernelGroups groups(kernels.centers, shapes, kernels.cutoff, own.threads);
    own.order = model::morton_order(places, own.threads);
    own.weights.resize(own.order.size());
    own.chunks.resize((own.order.size() + kChunkPlaces - 1) / kChunkPlaces);
    const RowFinder finder = {groups, kernels.weights, places, own.order,
                              reconstruction == Reconstruction::kNormalized};
    own.for_chunks(stop, [&](std::size_t c) {
      finder.find(own.first_place(c), own.num_places(c), own.chunks[c], own.weights);
    });
    own.is_defined.resize(own.order.size());
    for (std::size_t k = 0; k < own.order.size(); ++k) {
      const std::vector<std::uint32_t>& starts = own.chunks[k / kChunkPlaces].starts;
      own.is_defined[own.order[k]] = starts[k % kChunkPlaces] < starts[k % kChunkPlaces + 1];
    }
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("no memory for the rows of {} places", places.size() / 3));
  }
}
KernelOperator::~KernelOperator() = default;
KernelOperator::KernelOperator(KernelOperator&&) noexcept = default;
KernelOperator& KernelOperator::operator=(KernelOperator&&) noexcept = default;

std::size_t KernelOperator::num_kernels() const noexcept { return impl_->num_kernels; }
std::size_t KernelOperator::num_places() const noexcept { return impl_->order.size(); }
std::span<const float> KernelOperator::weights() const noexcept { return impl_->weights; }
bool KernelOperator::is_defined(std::size_t place) const noexcept {
  return impl_->is_defined[place];
}

KernelOperator::Row KernelOperator::row(std::size_t number) const noexcept {
  const Chunk& chunk = impl_->chunks[number / kChunkPlaces];
  const std::size_t begin = chunk.starts[number % kChunkPlaces];
  const std::size_t size = chunk.starts[number % kChunkPlaces + 1] - begin;
  return {impl_->order[number], std::span(chunk.kernels).subspan(begin, size),
          std::span(chunk.entries).subspan(begin, size)};
}

std::size_t KernelOperator::resident_bytes() const noexcept {
  std::size_t bytes = impl_->order.size() * (sizeof(std::uint32_t) + sizeof(float));
  for (const Chunk& chunk : impl_->chunks) {
    bytes += sizeof(Chunk) + chunk.starts.capacity() * sizeof(std::uint32_t) +
             chunk.kernels.capacity() * sizeof(std::uint32_t) +
             chunk.entries.capacity() * sizeof(float);
  }
  return bytes;
}

std::vector<double> KernelOperator::gather(std::span<const double> values) const {
  require_length("values", values.size(), impl_->num_kernels);
  std::vector<double> field(impl_->order.size());
  impl_->for_chunks({}, [&](std::size_t c) {
    const Chunk& chunk = impl_->chunks[c];
    for (std::size_t k = 0; k < impl_->num_places(c); ++k) {
      double sum = 0;
      for (std::uint32_t e = chunk.starts[k]; e < chunk.starts[k + 1]; ++e)
        sum += static_cast<double>(chunk.entries[e]) * values[chunk.kernels[e]];
      field[impl_->order[impl_->first_place(c) + k]] = sum;
    }
  });
  return field;
}

std::vector<double> KernelOperator::splat(std::span<const double> numbers) const {
  return impl_->splat(numbers, [](double entry, double number) { return entry * number; });
}

std::vector<double> KernelOperator::splat_squares(std::span<const double> numbers) const {
  return impl_->splat(numbers, [](double entry, double number) { return entry * entry * number; });
}

}  // namespace ovoid
