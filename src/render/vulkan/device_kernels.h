// SPDX-License-Identifier: Apache-2.0
// A kernel set on the device, in pages of whole bricks, as many of them at a time as its memory
// holds.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ovoid/kernel_field.h"
#include "render/vulkan/residency.h"

namespace ovoid::vulkan {

class DeviceKernels {
 public:
  // Nothing is uploaded yet.
  DeviceKernels(std::shared_ptr<Device> device, const KernelField& field, std::uint64_t most_bytes);

  bool is_of(const KernelField& field) const noexcept {
    return field.id() == id_ && field.version() == version_;
  }
  // Of a kernel: offset x, y, z; sigma or the factor's six numbers; weight; value; colour's value,
  // if another attribute gives it.
  int num_numbers() const noexcept { return num_numbers_; }

  std::size_t page_of(std::int64_t brick) const noexcept {
    return page_of_brick_[static_cast<std::size_t>(brick)];
  }
  std::uint32_t first_in_page(std::int64_t brick) const noexcept {
    return first_in_page_[static_cast<std::size_t>(brick)];
  }

  // With its kernels on the device; others give way. Throws what the source throws.
  const Buffer& acquire(std::size_t page, const KernelField& field, Commands& commands);

 private:
  struct Page : Resident {
    std::int64_t first_brick = 0, last_brick = 0;
    std::uint32_t num_kernels = 0;
  };
  std::uint64_t bytes_of(const Page& page) const noexcept {
    return std::uint64_t{4} * page.num_kernels * static_cast<std::uint64_t>(num_numbers_);
  }
  std::vector<float> pack(const Page& page, const KernelField& field) const;

  std::shared_ptr<Device> device_;
  std::uint64_t id_, version_;
  int num_numbers_;
  std::vector<Page> pages_;
  std::vector<std::uint32_t> page_of_brick_, first_in_page_;
  Residency residency_;
};

}  // namespace ovoid::vulkan
