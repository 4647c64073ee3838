// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/device_kernels.h"

#include <algorithm>

#include "data/kernels/kernel_shape.h"
#include "data/parallel.h"

namespace ovoid::vulkan {
namespace {

// Of a page: small enough that one gives way for another without much being sent again.
constexpr std::uint64_t kPageBytes = std::uint64_t{128} << 20;

int numbers_of(const KernelField& field) {
  return 3 + num_shape_numbers(field.source().shape()) + 2 + (field.has_own_color() ? 1 : 0);
}

}  // namespace

DeviceKernels::DeviceKernels(std::shared_ptr<Device> device, const KernelField& field,
                             std::uint64_t most_bytes)
    : device_(std::move(device)),
      id_(field.id()),
      version_(field.version()),
      num_numbers_(numbers_of(field)),
      residency_(most_bytes) {
  const std::uint64_t page_bytes =
      std::min<std::uint64_t>({kPageBytes, device_->limits().maxStorageBufferRange, most_bytes});
  const std::int64_t num_bricks = field.source().num_bricks();
  page_of_brick_.reserve(static_cast<std::size_t>(num_bricks));
  first_in_page_.reserve(static_cast<std::size_t>(num_bricks));
  for (std::int64_t b = 0; b < num_bricks; ++b) {
    const auto count = static_cast<std::uint32_t>(field.source().brick(b).count);
    const bool is_full =
        !pages_.empty() && bytes_of(pages_.back()) + std::uint64_t{4} * count *
                                                         static_cast<std::uint64_t>(num_numbers_) >
                               page_bytes;
    if (pages_.empty() || is_full) {
      pages_.emplace_back();
      pages_.back().first_brick = b;
    }
    page_of_brick_.push_back(static_cast<std::uint32_t>(pages_.size() - 1));
    first_in_page_.push_back(pages_.back().num_kernels);
    pages_.back().num_kernels += count;
    pages_.back().last_brick = b + 1;
  }
}

std::vector<float> DeviceKernels::pack(const Page& page, const KernelField& field) const {
  const KernelSource& source = field.source();
  std::vector<float> numbers(std::size_t{page.num_kernels} *
                             static_cast<std::size_t>(num_numbers_));
  const auto attribute = static_cast<std::size_t>(field.attribute());
  const auto color = static_cast<std::size_t>(field.color_attribute());
  const int num_shape = num_shape_numbers(source.shape());
  data::parallel_ranges(
      {page.last_brick - page.first_brick, 64, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t b = page.first_brick + begin; b < page.first_brick + end; ++b) {
          const KernelView view = source.acquire(b, 0.0);
          float* to = numbers.data() +
                      std::size_t{first_in_page(b)} * static_cast<std::size_t>(num_numbers_);
          for (std::int32_t i = 0; i < view.count; ++i) {
            for (std::size_t a = 0; a < 3; ++a) *to++ = view.center[a][i];
            const auto shape = data::shape_numbers(view, source.shape(), i);
            to = std::copy_n(shape.begin(), num_shape, to);
            *to++ = data::weight_of(view, i);
            *to++ = view.value[attribute][i];
            if (field.has_own_color()) *to++ = view.value[color][i];
          }
        }
      });
  return numbers;
}

const Buffer& DeviceKernels::acquire(std::size_t page, const KernelField& field,
                                     Commands& commands) {
  Page& own = pages_[page];
  residency_.touch(own);
  if (own.data.is_empty()) {
    const std::vector<float> numbers = pack(own, field);
    residency_.send<Page>(own, pages_, std::as_bytes(std::span(numbers)), device_, commands);
  }
  return own.data;
}

}  // namespace ovoid::vulkan
