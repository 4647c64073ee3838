// SPDX-License-Identifier: Apache-2.0
// The pixels of a picture on the device, some rows of it at a time.
#pragma once

#include <memory>

#include "ovoid/renderer.h"
#include "render/vulkan/commands.h"

namespace ovoid::vulkan {

// Rows [first, end) of a picture.
struct Strip {
  int first = 0, end = 0;
  int rows() const noexcept { return end - first; }
};

class Pixels {
 public:
  explicit Pixels(std::shared_ptr<Device> device) : device_(std::move(device)) {}

  // A picture in strips that a buffer of `bytes_per_pixel` at most can hold, and, if somebody
  // watches, of at most kWatchedRows.
  std::vector<Strip> strips(const RenderOptions& options, const RenderHooks& hooks,
                            std::uint64_t bytes_per_pixel) const;

  // Room for a strip in which nothing is drawn yet. Recorded, not submitted.
  void clear(Commands& commands, int width, const Strip& strip);
  // A finished strip becomes pixels of the picture.
  void finish(Commands& commands, const Look& look, const Strip& strip, Image& image);

  const Buffer& colors() const noexcept { return colors_; }
  const Buffer& depths() const noexcept { return depths_; }
  const Buffer& states() const noexcept { return states_; }

 private:
  std::shared_ptr<Device> device_;
  Buffer colors_, depths_, states_;
};

}  // namespace ovoid::vulkan
