// SPDX-License-Identifier: Apache-2.0
#include "view/field_samples.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <new>
#include <optional>

#include "data/out_of_memory.h"
#include "data/scalar_visit.h"
#include "data/some_kernels.h"

namespace ovoid::view {
namespace {

// Reads single samples, and keeps the brick that it read last.
class SampleReader {
 public:
  explicit SampleReader(const BrickSource& source)
      : source_(source),
        dims_(source.geometry().dims),
        edge_(source.brick_edge()),
        scale_(source.value_scale()),
        offset_(source.value_offset()) {}

  // NaN if it is missing or lies outside.
  float at(const Index3& index) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (index[a] < 0 || index[a] >= dims_[a]) return std::numeric_limits<float>::quiet_NaN();
    }
    for (std::size_t a = 0; a < 3; ++a) {
      if (index[a] >= view_.lo[a] && index[a] < view_.hi[a]) continue;
      view_ = source_.acquire(index[0] / edge_, index[1] / edge_,
                              index[2] / (edge_ * source_.geometry().num_sublattices()), 0.0);
      break;
    }
    const std::int64_t position = (index[0] - view_.lo[0]) +
                                  (index[1] - view_.lo[1]) * view_.stride_y +
                                  (index[2] - view_.lo[2]) * view_.stride_z;
    return data::visit_scalar(view_.type, [&]<class T>(std::type_identity<T>) {
      const auto stored = static_cast<double>(
          data::load_scalar<T>(static_cast<const std::byte*>(view_.data), position));
      const auto value = static_cast<float>(stored * scale_ + offset_);
      return std::isfinite(value) ? value : std::numeric_limits<float>::quiet_NaN();
    });
  }

 private:
  const BrickSource& source_;
  const Index3 dims_;
  const std::int64_t edge_;
  const double scale_;
  const double offset_;
  BrickView view_;  // of nothing: lo == hi
};

// Numbers that look random and are the same everywhere (a finalizer of splitmix64's kind).
std::uint64_t scrambled(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

// Calls visit(index) for about one in `every` places of the box [lo, hi), in order.
template <class Visit>
void visit_some(const Index3& lo, const Index3& hi, std::int64_t every, const Visit& visit) {
  // What a row's end leaves over is carried into the next, behind a scrambled start: no pattern in
  // the data can meet one in the places.
  const std::int64_t width = hi[0] - lo[0];
  Index3 index{};
  for (index[2] = lo[2]; index[2] < hi[2]; ++index[2]) {
    for (index[1] = lo[1]; index[1] < hi[1]; ++index[1]) {
      const auto row = static_cast<std::uint64_t>(index[2] * 0x1000003 + index[1]);
      auto x = static_cast<std::int64_t>(scrambled(row) % static_cast<std::uint64_t>(every));
      for (; x < width; x += every) {
        index[0] = lo[0] + x;
        visit(index);
      }
    }
  }
}

std::int64_t one_in(std::int64_t count) {
  return std::max<std::int64_t>(1, (count + kWantedSamples - 1) / kWantedSamples);
}

void take_face_samples(SampleReader& reader, const Index3& dims, std::vector<float>& values) {
  const std::int64_t area = 2 * (dims[0] * dims[1] + dims[1] * dims[2] + dims[2] * dims[0]);
  const std::int64_t every = one_in(area);
  for (std::size_t a = 0; a < 3; ++a) {
    for (const std::int64_t place : {std::int64_t{0}, dims[a] - 1}) {
      Index3 lo{0, 0, 0};
      Index3 hi = dims;
      lo[a] = place;
      hi[a] = place + 1;
      visit_some(lo, hi, every, [&](const Index3& index) {
        const float value = reader.at(index);
        if (!std::isnan(value)) values.push_back(value);
      });
      if (dims[a] == 1) break;
    }
  }
}

[[noreturn]] void throw_no_memory() {
  data::throw_out_of_memory("samples of the field, to choose a look",
                            2 * kWantedSamples * sizeof(float));
}

}  // namespace

FieldSamples take_samples(const LatticeField& field) try {
  const LatticeGeometry& geometry = field.geometry();
  SampleReader reader(field.source());
  FieldSamples samples;
  std::int64_t num_pairs = 0;
  std::int64_t num_equal = 0;
  visit_some({0, 0, 0}, geometry.dims, one_in(num_samples(geometry.dims)),
             [&](const Index3& index) {
               const float value = reader.at(index);
               if (std::isnan(value)) return;
               samples.values.push_back(value);
               const float next = reader.at({index[0] + 1, index[1], index[2]});
               if (std::isnan(next)) return;
               ++num_pairs;
               if (next == value) ++num_equal;
             });
  take_face_samples(reader, geometry.dims, samples.on_faces);
  for (std::vector<float>* list : {&samples.values, &samples.on_faces})
    std::sort(list->begin(), list->end());
  samples.share_of_equals =
      num_pairs > 0 ? static_cast<double>(num_equal) / static_cast<double>(num_pairs) : 0.0;
  return samples;
} catch (const std::bad_alloc&) {
  throw_no_memory();
}

FieldSamples take_samples(const KernelField& field) try {
  constexpr std::int64_t kWantedSums = 4096;
  const KernelSource& source = field.source();
  const bool is_sum = field.reconstruction() == Reconstruction::kSum;
  std::optional<KernelSampler> sampler;
  if (is_sum) sampler.emplace(field);
  FieldSamples samples;
  data::for_some_kernels(
      source, is_sum ? kWantedSums : kWantedSamples,
      [&](const KernelBrick& brick, const KernelView& view, std::int32_t i) {
        const Vec3 offset(view.center[0][i], view.center[1][i], view.center[2][i]);
        samples.values.push_back(is_sum
                                     ? static_cast<float>(sampler->at(brick.origin + offset).value)
                                     : view.value[static_cast<std::size_t>(field.attribute())][i]);
      });
  std::sort(samples.values.begin(), samples.values.end());
  return samples;
} catch (const std::bad_alloc&) {
  throw_no_memory();
}

double quantile(std::span<const float> sorted, double q) {
  const double place = std::clamp(q, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(static_cast<double>(sorted[below]), static_cast<double>(sorted[above]),
                   place - static_cast<double>(below));
}

std::vector<int> few_integers(const LatticeField& field, std::size_t most) {
  constexpr int kGreatest = 65535;
  const Index3& dims = field.geometry().dims;
  SampleReader reader(field.source());
  std::vector<int> found;
  std::bitset<kGreatest + 1> is_found;
  Index3 index{};
  for (index[2] = 0; index[2] < dims[2]; ++index[2]) {
    for (index[1] = 0; index[1] < dims[1]; ++index[1]) {
      for (index[0] = 0; index[0] < dims[0]; ++index[0]) {
        const float value = reader.at(index);
        if (std::isnan(value)) continue;
        if (!(value >= 0 && value <= kGreatest) || value != std::floor(value)) return {};
        const auto number = static_cast<std::size_t>(value);
        if (is_found[number]) continue;
        if (found.size() == most) return {};
        is_found[number] = true;
        found.push_back(static_cast<int>(number));
      }
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace ovoid::view
