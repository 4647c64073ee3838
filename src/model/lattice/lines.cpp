// SPDX-License-Identifier: Apache-2.0
#include "model/lattice/lines.h"

#include <algorithm>

#include "data/parallel.h"

namespace ovoid::model {
namespace {

constexpr std::int64_t kSideBySide = 16;  // lines: a cache line of floats

// Lines that lie side by side in memory, one after the other in a buffer.
class Bundle {
 public:
  explicit Bundle(std::int64_t length)
      : length_(length), samples_(static_cast<std::size_t>(length * kSideBySide)) {}

  std::span<float> line(std::int64_t i) {
    return {samples_.data() + i * length_, static_cast<std::size_t>(length_)};
  }
  void take(const float* from, std::int64_t stride, std::int64_t count) {
    for (std::int64_t i = 0; i < length_; ++i) {
      for (std::int64_t l = 0; l < count; ++l) samples_[l * length_ + i] = from[i * stride + l];
    }
  }
  void give(float* to, std::int64_t stride, std::int64_t count) const {
    for (std::int64_t i = 0; i < length_; ++i) {
      for (std::int64_t l = 0; l < count; ++l) to[i * stride + l] = samples_[l * length_ + i];
    }
  }

 private:
  std::int64_t length_;
  std::vector<float> samples_;
};

}  // namespace

std::vector<float> transform_lines(std::span<const float> samples, const Index3& dims,
                                   std::int64_t size, const LineTransform& transform,
                                   const LineOptions& options) {
  const auto axis = static_cast<std::size_t>(options.axis);
  Index3 out_dims = dims;
  out_dims[axis] = size;
  std::vector<float> out(static_cast<std::size_t>(num_samples(out_dims)));
  const std::int64_t length = dims[axis];
  // Lines are numbered by block (of all faster axes together) and place in it.
  std::int64_t stride = 1;
  for (std::size_t a = 0; a < axis; ++a) stride *= dims[a];
  const std::int64_t num_blocks = num_samples(dims) / (stride * length);
  const std::int64_t bundles_per_block = (stride + kSideBySide - 1) / kSideBySide;
  data::parallel_ranges({num_blocks * bundles_per_block, 16, options.threads, options.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          Bundle from(length);
                          Bundle to(size);
                          for (std::int64_t b = begin; b < end; ++b) {
                            const std::int64_t block = b / bundles_per_block;
                            const std::int64_t first = b % bundles_per_block * kSideBySide;
                            const std::int64_t count = std::min(kSideBySide, stride - first);
                            from.take(samples.data() + block * stride * length + first, stride,
                                      count);
                            for (std::int64_t l = 0; l < count; ++l)
                              transform(from.line(l), to.line(l));
                            to.give(out.data() + block * stride * size + first, stride, count);
                          }
                        });
  return out;
}

}  // namespace ovoid::model
