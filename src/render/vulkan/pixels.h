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

  // A picture in strips that a buffer of `bytes_per_pixel` at most can hold, whose depth limits'
  // stops a buffer can hold, and, if somebody watches, of at most kWatchedRows. Throws
  // Error(kOutOfMemory) if one row of tiles has too many stops.
  std::vector<Strip> strips(const RenderOptions& options, const RenderHooks& hooks,
                            std::uint64_t bytes_per_pixel) const;

  // Room for a strip in which nothing is drawn yet, and its depth limits, for which what was
  // recorded is submitted. Recorded, not submitted.
  void clear(Commands& commands, const RenderOptions& options, const Strip& strip);
  // The stops of depth limits, if there are any, that stand behind all that was drawn join their
  // pixels. `frame`: the frame's buffer; `constants`: of its stages, the mode and flags first.
  // Recorded, not submitted.
  void record_last_stops(Commands& commands, const Buffer& frame, const Constants& constants);
  // A finished strip becomes pixels of the picture.
  // `keeps_values`: of modes that show values, which a part of a picture holds as they are.
  void finish(Commands& commands, const Look& look, bool keeps_values, const Strip& strip,
              Image& image);

  const Buffer& colors() const noexcept { return colors_; }
  const Buffer& depths() const noexcept { return depths_; }
  const Buffer& states() const noexcept { return states_; }
  // Of depth limits; there in frames without any, too.
  const Buffer& pixel_stops() const noexcept { return pixel_stops_; }
  const Buffer& stops() const noexcept { return stops_; }

 private:
  void upload_limits(Commands& commands, const DepthLimits& limits, const Strip& strip);

  std::shared_ptr<Device> device_;
  Buffer colors_, depths_, states_, pixel_stops_, stops_;
  std::uint32_t num_pixels_ = 0;  // of the strip
};

}  // namespace ovoid::vulkan
