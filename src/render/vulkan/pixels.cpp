// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/pixels.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "data/parallel.h"
#include "render/shared/device_layout.h"
#include "render/shared/finished_pixel.h"

namespace ovoid::vulkan {
namespace {

constexpr int kWatchedRows = 128;

template <class T>
std::span<std::byte> bytes_of(T* at, std::size_t count) {
  return std::as_writable_bytes(std::span<T>(at, count));
}

}  // namespace

std::vector<Strip> Pixels::strips(const RenderOptions& options, const RenderHooks& hooks,
                                  std::uint64_t bytes_per_pixel) const {
  const std::uint64_t per_row = static_cast<std::uint64_t>(options.width) * bytes_per_pixel;
  const std::uint64_t most =
      std::max<std::uint64_t>(device_->limits().maxStorageBufferRange / per_row, 1);
  const auto edge = static_cast<int>(device::kGroupEdge);
  int rows = static_cast<int>(std::min<std::uint64_t>(most, options.height));
  // Graphics processors are done before anybody looks.
  const bool is_slow = device_->info().kind == DeviceKind::kSoftware;
  const bool is_watched = is_slow && (hooks.stop.stop_possible() || hooks.progress != nullptr ||
                                      hooks.tile_done != nullptr);
  if (is_watched) rows = std::min(rows, kWatchedRows);
  if (rows > edge) rows -= rows % edge;
  std::vector<Strip> strips;
  for (int first = 0; first < options.height; first += rows)
    strips.push_back({first, std::min(first + rows, options.height)});
  return strips;
}

void Pixels::clear(Commands& commands, int width, const Strip& strip) {
  const std::uint64_t count = static_cast<std::uint64_t>(width) * strip.rows();
  reserve(colors_, device_, count * sizeof(device::vec4), BufferUse::kDevice);
  reserve(depths_, device_, count * sizeof(float), BufferUse::kDevice);
  reserve(states_, device_, count * sizeof(device::PixelState), BufferUse::kDevice);
  commands.fill(colors_, 0);
  commands.fill(depths_, std::bit_cast<std::uint32_t>(std::numeric_limits<float>::infinity()));
  commands.fill(states_, 0);
}

void Pixels::finish(Commands& commands, const Look& look, const Strip& strip, Image& image) {
  const std::size_t first = static_cast<std::size_t>(strip.first) * image.width;
  const std::size_t count = static_cast<std::size_t>(strip.rows()) * image.width;
  commands.read_back(depths_, 0, bytes_of(image.depth.data() + first, count));
  if (look.mode == Mode::kComposite || look.mode == Mode::kIsosurface) {
    commands.read_back(colors_, 0, bytes_of(image.rgba.data() + 4 * first, 4 * count));
    return;
  }
  std::vector<device::PixelState> states(count);
  commands.read_back(states_, 0, bytes_of(states.data(), count));
  constexpr std::int64_t kGrain = 4096;
  data::parallel_ranges(
      {static_cast<std::int64_t>(count), kGrain, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          if ((states[i].flags & device::kSeen) == 0) continue;
          show_value(look, states[i].best, states[i].path, image.rgba.data() + 4 * (first + i));
        }
      });
}

}  // namespace ovoid::vulkan
