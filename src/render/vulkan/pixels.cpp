// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <limits>

#include "data/parallel.h"
#include "ovoid/error.h"
#include "render/shared/device_layout.h"
#include "render/vulkan/workbench.h"
#include "view/plan/finished_pixel.h"

namespace ovoid::vulkan {
namespace {

constexpr int kWatchedRows = 128;
constexpr int kRowsOfTile = device::kGroupEdge;

// last_stops.comp reads the view of any frame.
static_assert(offsetof(device::LatticeFrame, view) == 0);
static_assert(offsetof(device::KernelFrame, view) == 0);

// Numbers of a strip's stops: [first, end).
struct StopNumbers {
  std::uint32_t first, end;
  std::uint32_t count() const noexcept { return end - first; }
};

StopNumbers stops_of(const DepthLimits& limits, const Strip& strip) {
  const auto width = static_cast<std::size_t>(limits.width);
  return {limits.first[static_cast<std::size_t>(strip.first) * width],
          limits.first[static_cast<std::size_t>(strip.end) * width]};
}

// The first rows of a strip, as whole tiles, that have so many stops at most.
Strip with_few_stops(const DepthLimits& limits, Strip strip, std::uint64_t most) {
  while (stops_of(limits, strip).count() > most) {
    if (strip.rows() <= kRowsOfTile)
      throw Error(ErrorCode::kOutOfMemory,
                  fmt::format("depth limits: {} stops in rows {} to {}, the device's buffers hold "
                              "{}: expected fewer, or backend cpu",
                              stops_of(limits, strip).count(), strip.first, strip.end - 1, most));
    const int tiles = (strip.rows() + kRowsOfTile - 1) / kRowsOfTile;
    strip.end = strip.first + tiles / 2 * kRowsOfTile;
  }
  return strip;
}

// Of a pixel, as composite.glsl has them.
struct Depths {
  float half, front;
};

// Of a strip's `count` pixels, what the buffer has of each, handed to do_with(pixel, of_pixel) by
// several threads.
template <class T, class DoWith>
void for_each_pixel(Commands& commands, const Buffer& from, std::size_t count,
                    const DoWith& do_with) {
  const std::byte* const found = commands.fetch(from, 0, count * sizeof(T)).data();
  constexpr std::int64_t kGrain = 1 << 14;
  data::parallel_ranges(
      {static_cast<std::int64_t>(count), kGrain, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          T of_pixel;
          std::memcpy(&of_pixel, found + i * sizeof(T), sizeof(T));
          do_with(i, of_pixel);
        }
      });
}

}  // namespace

std::vector<Strip> Pixels::strips(const RenderOptions& options, const RenderHooks& hooks,
                                  std::uint64_t bytes_per_pixel) const {
  const std::uint64_t per_row = static_cast<std::uint64_t>(options.width) * bytes_per_pixel;
  const std::uint64_t most =
      std::max<std::uint64_t>(device_->limits().maxStorageBufferRange / per_row, 1);
  int rows = static_cast<int>(std::min<std::uint64_t>(most, options.height));
  // Graphics processors are done before anybody looks.
  const bool is_slow = device_->info().kind == DeviceKind::kSoftware;
  const bool is_watched = is_slow && (hooks.stop.stop_possible() || hooks.progress != nullptr ||
                                      hooks.tile_done != nullptr);
  if (is_watched) rows = std::min(rows, kWatchedRows);
  if (rows < options.height && rows > kRowsOfTile) rows -= rows % kRowsOfTile;
  const std::uint64_t most_stops =
      device_->limits().maxStorageBufferRange / sizeof(device::DepthStop);
  std::vector<Strip> strips;
  for (int first = 0; first < options.height; first = strips.back().end) {
    const Strip strip{first, std::min(first + rows, options.height)};
    strips.push_back(options.depth_limits == nullptr
                         ? strip
                         : with_few_stops(*options.depth_limits, strip, most_stops));
  }
  return strips;
}

void Pixels::upload_limits(Commands& commands, const DepthLimits& limits, const Strip& strip) {
  const StopNumbers numbers = stops_of(limits, strip);
  std::vector<device::PixelStops> of_pixels(num_pixels_);
  const std::uint32_t* const first =
      limits.first.data() + static_cast<std::size_t>(strip.first) * limits.width;
  for (std::size_t i = 0; i < of_pixels.size(); ++i)
    of_pixels[i] = {first[i] - numbers.first, first[i + 1] - numbers.first,
                    first[i] - numbers.first};
  std::vector<device::DepthStop> stops(numbers.count());
  constexpr std::int64_t kGrain = 1 << 16;
  data::parallel_ranges(
      {numbers.count(), kGrain, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          const DepthLimits::Stop& stop = limits.stops[numbers.first + i];
          stops[i].depth = stop.depth;
          stops[i].flags = (stop.is_field_behind ? device::kFieldBehind : 0) |
                           (stop.is_seam ? device::kSeam : 0);
          std::copy(stop.rgba.begin(), stop.rgba.end(), std::begin(stops[i].rgba));
        }
      });
  commands.submit_and_wait();  // what was recorded may read those of another strip
  reserve(pixel_stops_, device_, of_pixels.size() * sizeof(device::PixelStops), BufferUse::kDevice);
  reserve(stops_, device_, stops.size() * sizeof(device::DepthStop), BufferUse::kDevice);
  commands.upload(pixel_stops_, 0, std::as_bytes(std::span(of_pixels)));
  commands.upload(stops_, 0, std::as_bytes(std::span(stops)));
}

void Pixels::record_last_stops(Commands& commands, const Buffer& frame,
                               const Constants& constants) {
  const std::uint32_t flags = constants[1];
  if ((flags & device::kHasLimits) == 0) return;
  constexpr std::uint32_t kThreads = 64;  // of last_stops.comp
  commands.mark("last stops");
  commands.dispatch(Stage::kLastStops, {constants[0], flags},
                    {&frame, &colors_, &depths_, &states_, &pixel_stops_, &stops_},
                    device::StripConstants{num_pixels_},
                    grid_of(groups_for(num_pixels_, kThreads)));
}

void Pixels::clear(Commands& commands, const RenderOptions& options, const Strip& strip) {
  const std::uint64_t count = static_cast<std::uint64_t>(options.width) * strip.rows();
  num_pixels_ = static_cast<std::uint32_t>(count);
  if (options.depth_limits != nullptr) upload_limits(commands, *options.depth_limits, strip);
  // Shaders are given them in any case.
  reserve(pixel_stops_, device_, sizeof(device::PixelStops), BufferUse::kDevice);
  reserve(stops_, device_, sizeof(device::DepthStop), BufferUse::kDevice);
  reserve(colors_, device_, count * sizeof(device::vec4), BufferUse::kDevice);
  reserve(depths_, device_, count * sizeof(Depths), BufferUse::kDevice);
  reserve(states_, device_, count * sizeof(device::PixelState), BufferUse::kDevice);
  commands.fill(colors_, 0);
  commands.fill(depths_, std::bit_cast<std::uint32_t>(std::numeric_limits<float>::infinity()));
  commands.fill(states_, 0);
}

void Pixels::finish(Commands& commands, const Look& look, bool keeps_values, const Strip& strip,
                    Image& image) {
  const HostStage stage(commands, "read back");
  const std::size_t first = static_cast<std::size_t>(strip.first) * image.width;
  const std::size_t count = static_cast<std::size_t>(strip.rows()) * image.width;
  for_each_pixel<Depths>(commands, depths_, count, [&](std::size_t i, const Depths& depths) {
    image.depth[first + i] = depths.half;
    image.front_depth[first + i] = depths.front;
  });
  if (look.mode == Mode::kComposite || look.mode == Mode::kIsosurface) {
    using Rgba = std::array<float, 4>;
    for_each_pixel<Rgba>(commands, colors_, count, [&](std::size_t i, const Rgba& rgba) {
      std::copy(rgba.begin(), rgba.end(), image.rgba.data() + 4 * (first + i));
    });
    return;
  }
  for_each_pixel<device::PixelState>(
      commands, states_, count, [&](std::size_t i, const device::PixelState& state) {
        if ((state.flags & device::kSeen) == 0) return;
        float* const rgba = image.rgba.data() + 4 * (first + i);
        if (keeps_values) {
          keep_value(state.best, state.path, rgba);
        } else {
          show_value(look, state.best, state.path, rgba);
        }
        image.front_depth[first + i] = front_depth_of_value(rgba, image.depth[first + i]);
      });
}

}  // namespace ovoid::vulkan
