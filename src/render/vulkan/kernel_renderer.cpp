// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/kernel_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "ovoid/error.h"
#include "render/shared/look_values.h"
#include "render/vulkan/half_sheets.h"
#include "render/vulkan/shader_flags.h"
#include "render/vulkan/software_limits.h"

namespace ovoid::vulkan {
namespace {

// Of sheets that are kept at a time: more would be worked out behind what is opaque.
constexpr int kMostChunkLayers = 4;
constexpr int kTileEdge = device::kGroupEdge;

// What a brick's kernels can reach: layers and rows of pixels, half open.
struct Reach {
  int first_layer, end_layer;
  double first_row, end_row;

  bool meets(int first, int end, const Strip& strip) const {
    return first_layer < end && end_layer > first && first_row < strip.end && end_row > strip.first;
  }
};

// Sums on coarse levels take longer than they save where arithmetic is cheap: on a data-centre
// device direct sums were three times as fast (docs/performance.md, "Graphics processors").
KernelTraits traits_on(const Device& device, const KernelField& field, const view::KernelPlan& plan,
                       const Look& look, RenderOptions options) {
  if (device.info().is_hardware() && options.post_convolution == PostConvolution::kAuto)
    options.post_convolution = PostConvolution::kOff;
  return kernel_traits(field, plan, look, options);
}

// Filters bring a kernel from the coarsest samples, 64 pixels wide, to pixels three of them
// farther.
constexpr double kFilteredRows = 4 * 64;

Reach reach_of(const KernelBrick& brick, const view::KernelPlan& plan, double cutoff,
               bool has_levels) {
  const view::SplatSpace& space = plan.space;
  Bounds3 box;  // camera coordinates
  for (int corner = 0; corner < 8; ++corner)
    box.extend(
        space.camera_from_world(brick.support.corner(static_cast<Bounds3::CornerType>(corner))));
  // Kernels are widened to half a sheet; a mean stands for half a sheet on either side.
  const double reach = 0.5 * cutoff + (plan.is_mean ? 0.5 : 0.0) + 0.01;
  const double layers = plan.num_blocks[2];
  const double first = (space.sheet_of(box.min()[2]) - reach) / view::kBlockDepth;
  const double last = (space.sheet_of(box.max()[2]) + reach) / view::kBlockDepth;
  // Rows are farthest apart where the brick is nearest; across, kernels are widened to pixels.
  const double ds = space.sampling_distance;
  const double nearest = std::max(box.min()[2] - reach * ds, plan.lattice.near_depth());
  const double farthest = std::max(box.max()[2] + reach * ds, nearest);
  const double beyond =
      (has_levels ? kFilteredRows : 2.0) +
      0.5 * view::kLeastPixels * cutoff * (space.is_parallel ? 1.0 : farthest / nearest);
  const auto row_at = [&](double y, bool is_low) {
    const bool is_wide = (y < 0) == is_low;
    return space.center_y + y / space.pitch * space.scale(is_wide ? nearest : farthest);
  };
  return {static_cast<int>(std::clamp(std::floor(first), 0.0, layers)),
          static_cast<int>(std::clamp(std::floor(last) + 1, 0.0, layers)),
          row_at(box.min()[1], true) - beyond, row_at(box.max()[1], false) + beyond};
}

int floor_divided(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

// Throws Error(kUnsupported) where a software driver would end the loops over stops early.
void require_few_stops(const DepthLimits* limits, DeviceKind kind) {
  if (limits == nullptr || kind != DeviceKind::kSoftware) return;
  if (rounds_of_stops(*limits) >= kMostRounds)
    throw Error(ErrorCode::kUnsupported,
                "backend vulkan: software drivers cannot pass so many depth limits in one pixel: "
                "expected fewer, or backend cpu");
}

// The rear half of a strip's rows, in whole tiles. Throws Error(kOutOfMemory) if it is one.
Strip second_half(const Strip& strip) {
  if (strip.rows() <= kTileEdge)
    throw Error(
        ErrorCode::kOutOfMemory,
        "backend vulkan: the device's memory does not hold the kernels that reach one row of "
        "tiles and four sheets: expected a larger device memory limit, a finer "
        "--sampling-distance, or backend cpu");
  const int tiles = (strip.rows() + kTileEdge - 1) / kTileEdge;
  return {strip.first + (tiles + 1) / 2 * kTileEdge, strip.end};
}

}  // namespace

struct KernelRenderer::Set {
  Set(const Device& device, const KernelField& of, const Camera& camera, const Look& with,
      const RenderOptions& as, const view::LightVolume* by)
      : field(of),
        look(with),
        options(as),
        light(by),
        plan(of, camera, with, as),
        traits(traits_on(device, of, plan, with, as)),
        frame(kernel_constants(plan, traits, as.post_convolution)) {
    if (options.sheet_precision == SheetPrecision::kSingle) return;
    why_no_half_sheets = why_not_half_sheets(field, plan, look);
    has_half_sheets = why_no_half_sheets.empty();
  }

  const KernelField& field;
  const Look& look;
  const RenderOptions& options;
  const view::LightVolume* light;
  view::KernelPlan plan;
  KernelTraits traits;
  device::KernelFrame frame;
  bool has_half_sheets = false;
  std::string why_no_half_sheets;  // if they are asked for
  Constants constants;
  std::vector<std::uint32_t> needed_layers;
  std::vector<Reach> reaches;  // of the plan's bricks
  Strip strip;                 // that is drawn now
  std::uint32_t lists_per_layer = 0;
  std::uint64_t plane_samples = 0;   // of the finest level
  std::uint64_t coarse_numbers = 0;  // of all others, of a sheet
  int chunk_layers = 1;
};

device::KernelPush KernelRenderer::push_of(const Layers& layers) const {
  device::KernelPush push{};
  push.first_layer = layers.first;
  push.end_layer = layers.end;
  push.coarsest = layers.coarsest;
  push.only_sheet = -1;
  return push;
}

// Levels, their tiles and lists, of a strip of the picture.
void KernelRenderer::prepare_strip(Set& set, const Strip& strip) {
  const auto channels = static_cast<std::uint32_t>(set.traits.num_channels);
  std::uint32_t first_list = 0;
  set.coarse_numbers = 0;
  for (int level = 0; level < device::kNumLevels; ++level) {
    device::LevelConstants& constants = set.frame.levels[level];
    const int edge = kTileEdge << level;
    // One tile beside the picture all around: what filters and differences read there.
    const int first_x = -1;
    const int last_x = floor_divided(set.options.width - 1, edge) + 1;
    const int first_y = floor_divided(strip.first, edge) - 1;
    const int last_y = floor_divided(strip.end - 1, edge) + 1;
    constants.tiles = {last_x - first_x + 1, last_y - first_y + 1, first_x, first_y};
    const auto tiles = static_cast<std::uint32_t>(constants.tiles.x * constants.tiles.y);
    constants.first_list = first_list;
    first_list += tiles;
    if (level == 0) {
      set.plane_samples = std::uint64_t{tiles} * device::kGroupSize;
    } else {
      set.coarse_numbers += std::uint64_t{tiles} * device::kGroupSize * channels;
    }
  }
  set.lists_per_layer = first_list;
  set.frame.num_blocks = {set.plan.num_blocks[0], set.plan.num_blocks[1], set.plan.num_blocks[2],
                          static_cast<std::int32_t>(first_list)};

  // As many layers at a time as fit into a buffer, with the sheets before that differences need.
  const std::uint64_t most = bench_.device->limits().maxStorageBufferRange;
  const auto fits = [&](int layers) {
    const std::uint64_t num_sheets = static_cast<std::uint64_t>(layers) * view::kBlockDepth;
    const std::uint64_t coarse =
        set.frame.max_level > 0 ? num_sheets * set.coarse_numbers * sizeof(float) : 0;
    return (num_sheets + view::kBlockDepth) * set.plane_samples * sizeof(float) <= most &&
           coarse <= most;
  };
  set.chunk_layers = kMostChunkLayers;
  while (set.chunk_layers > 1 && !fits(set.chunk_layers)) --set.chunk_layers;
  set.chunk_layers = std::clamp(set.chunk_layers, 1, std::max(set.plan.num_blocks[2], 1));
  const int chunk_sheets = set.chunk_layers * view::kBlockDepth;
  set.frame.ring_sheets = chunk_sheets + view::kBlockDepth;
  std::uint32_t plane_at = 0;
  for (int level = 1; level < device::kNumLevels; ++level) {
    device::LevelConstants& constants = set.frame.levels[level];
    constants.plane_at = plane_at;
    plane_at += static_cast<std::uint32_t>(constants.tiles.x * constants.tiles.y) *
                device::kGroupSize * channels * static_cast<std::uint32_t>(chunk_sheets);
  }

  Commands& commands = bench_.commands;
  reserve(frame_, bench_.device, sizeof(set.frame), BufferUse::kDevice);
  commands.upload(frame_, 0, std::as_bytes(std::span(&set.frame, 1)));
  // There even if no kernel reaches the strip.
  reserve(splats_, bench_.device, sizeof(device::DeviceSplat), BufferUse::kDevice);
  reserve(pairs_, bench_.device, 8, BufferUse::kDevice);
  const std::uint64_t ring =
      static_cast<std::uint64_t>(set.frame.ring_sheets) * set.plane_samples * sizeof(float);
  reserve(sheets_, bench_.device, set.has_half_sheets ? ring / 2 : ring, BufferUse::kDevice);
  reserve(color_sheets_, bench_.device, set.field.has_own_color() ? ring : 4, BufferUse::kDevice);
  reserve(planes_, bench_.device,
          set.frame.max_level > 0
              ? set.coarse_numbers * sizeof(float) * static_cast<std::uint64_t>(chunk_sheets)
              : 4,
          BufferUse::kDevice);
  // Tiles beside the picture have no pixels to wait for.
  const device::ivec4& tiles = set.frame.levels[0].tiles;
  std::vector<std::uint32_t> open(static_cast<std::size_t>(tiles.x) * tiles.y, 0);
  for (int y = 1; y + 1 < tiles.y; ++y)
    std::fill_n(open.begin() + static_cast<std::ptrdiff_t>(y) * tiles.x + 1, tiles.x - 2, 1);
  reserve(open_, bench_.device, open.size() * sizeof(std::uint32_t), BufferUse::kDevice);
  commands.upload(open_, 0, std::as_bytes(std::span(open)));
  reserve(counts_, bench_.device, open.size() * 16, BufferUse::kDevice);
  commands.fill(counts_, 0);
}

void KernelRenderer::scan(const Buffer& numbers, std::uint32_t count) {
  std::array<std::uint32_t, 4> counts{count};
  std::array<const Buffer*, 4> of{&numbers};
  int levels = 0;
  // The last level's one sum goes nowhere.
  for (; levels < 3; ++levels) {
    const auto l = static_cast<std::size_t>(levels);
    counts[l + 1] = groups_for(counts[l], device::kScanItems);
    reserve(sums_[l], bench_.device, std::uint64_t{4} * counts[l + 1], BufferUse::kDevice);
    of[l + 1] = &sums_[l];
    device::KernelPush push{};
    push.num_items = counts[l];
    bench_.commands.dispatch(Stage::kScan, {}, {of[l], of[l + 1]}, push, grid_of(counts[l + 1]));
    if (counts[l + 1] == 1) break;
  }
  for (int level = levels - 1; level >= 0; --level) {
    const auto l = static_cast<std::size_t>(level);
    device::KernelPush push{};
    push.num_items = counts[l];
    bench_.commands.dispatch(Stage::kScanAdd, {}, {of[l], of[l + 1]}, push, grid_of(counts[l + 1]));
  }
}

// Splats of the kernels that reach the layers, and how many lists they belong to.
KernelRenderer::Layers KernelRenderer::project_layers(Set& set, int first, int end) {
  Commands& commands = bench_.commands;
  Layers layers{first, end};
  std::vector<device::BrickConstants> bricks;
  std::vector<std::pair<std::size_t, std::uint32_t>> pages;  // and its first brick here
  for (std::size_t i = 0; i < set.plan.bricks.size(); ++i) {
    if (!set.reaches[i].meets(first, end, set.strip)) continue;
    const std::int64_t number = set.plan.bricks[i];
    const KernelBrick& brick = set.field.source().brick(number);
    if (pages.empty() || pages.back().first != kernels_->page_of(number))
      pages.emplace_back(kernels_->page_of(number), static_cast<std::uint32_t>(bricks.size()));
    const Vec3 at = set.plan.space.camera_from_world(brick.origin);
    device::BrickConstants constants{};
    constants.origin = {static_cast<float>(at[0]), static_cast<float>(at[1]),
                        static_cast<float>(at[2] - set.plan.space.first_depth), 0};
    constants.first = kernels_->first_in_page(number);
    constants.count = static_cast<std::uint32_t>(brick.count);
    constants.first_splat = layers.num_splats;
    layers.num_splats += constants.count;
    bricks.push_back(constants);
  }
  commands.submit_and_wait();  // what was recorded may use the buffers that grow now
  if (layers.num_splats == 0) return layers;
  reserve(bricks_, bench_.device, bricks.size() * sizeof(device::BrickConstants),
          BufferUse::kDevice);
  reserve(splats_, bench_.device, std::uint64_t{64} * layers.num_splats, BufferUse::kDevice);
  reserve(offsets_, bench_.device, std::uint64_t{4} * layers.num_splats + 4, BufferUse::kDevice);
  reserve(coarsest_, bench_.device, 4, BufferUse::kDevice);
  commands.upload(bricks_, 0, std::as_bytes(std::span(bricks)));
  commands.mark("project");
  commands.fill(offsets_, 0);
  commands.fill(coarsest_, 0);
  for (std::size_t p = 0; p < pages.size(); ++p) {
    commands.submit_and_wait();
    const Buffer& page = kernels_->acquire(pages[p].first, set.field, commands);
    const auto past =
        p + 1 < pages.size() ? pages[p + 1].second : static_cast<std::uint32_t>(bricks.size());
    device::KernelPush push = push_of(layers);
    push.first_item = pages[p].second;
    push.num_items = past - pages[p].second;
    commands.mark("project");
    commands.dispatch(Stage::kProject, set.constants,
                      {&frame_, &page, &bricks_, &needed_layers_, &splats_, &offsets_, &coarsest_},
                      push, grid_of(push.num_items));
  }
  commands.mark("scan");
  scan(offsets_, layers.num_splats + 1);
  commands.submit_and_wait();
  commands.read_back(offsets_, std::uint64_t{4} * layers.num_splats,
                     std::as_writable_bytes(std::span(&layers.num_pairs, 1)));
  std::uint32_t coarsest = 0;
  commands.read_back(coarsest_, 0, std::as_writable_bytes(std::span(&coarsest, 1)));
  layers.coarsest = static_cast<int>(coarsest);
  return layers;
}

std::optional<KernelRenderer::Layers> KernelRenderer::bin_layers(Set& set, int first) {
  const std::uint64_t most =
      std::min<std::uint64_t>(bench_.device->limits().maxStorageBufferRange, bench_.most_bytes);
  const std::uint64_t most_splats = most / sizeof(device::DeviceSplat);
  const std::uint64_t most_pairs = most / 8;
  const std::uint64_t most_lists = bench_.device->limits().maxStorageBufferRange / 8;
  int end = set.plan.num_blocks[2];
  for (;; end = first + (end - first) / 2) {
    std::uint64_t num_splats = 0;
    for (std::size_t i = 0; i < set.plan.bricks.size(); ++i) {
      if (set.reaches[i].meets(first, end, set.strip))
        num_splats +=
            static_cast<std::uint64_t>(set.field.source().brick(set.plan.bricks[i]).count);
    }
    const bool is_one = end - first <= 1;
    const std::uint64_t lists =
        std::uint64_t{set.lists_per_layer} * static_cast<std::uint64_t>(end - first);
    if (num_splats <= most_splats && lists <= most_lists) {
      const Layers layers = project_layers(set, first, end);
      if (layers.num_pairs <= most_pairs) {
        list_and_sort(set, layers);
        return layers;
      }
    }
    if (is_one) return std::nullopt;
  }
}

void KernelRenderer::list_and_sort(Set& set, const Layers& layers) {
  Commands& commands = bench_.commands;
  const std::uint32_t num_lists =
      set.lists_per_layer * static_cast<std::uint32_t>(layers.end - layers.first);
  reserve(ends_, bench_.device, std::uint64_t{8} * num_lists, BufferUse::kDevice);
  commands.fill(ends_, 0);
  if (layers.num_pairs == 0) return;
  const std::uint64_t pair_bytes = std::uint64_t{8} * layers.num_pairs;
  reserve(pairs_, bench_.device, pair_bytes, BufferUse::kDevice);
  reserve(other_pairs_, bench_.device, pair_bytes, BufferUse::kDevice);
  const std::uint32_t blocks = groups_for(layers.num_pairs, device::kSortItems);
  const std::uint32_t num_digits = blocks * device::kSortBins;
  reserve(digits_, bench_.device, std::uint64_t{4} * num_digits, BufferUse::kDevice);
  device::KernelPush push = push_of(layers);
  push.num_items = layers.num_splats;
  commands.mark("list");
  commands.dispatch(Stage::kList, set.constants,
                    {&frame_, &splats_, &offsets_, &needed_layers_, &pairs_}, push,
                    grid_of(groups_for(layers.num_splats, 256)));
  commands.mark("sort");
  push.num_items = layers.num_pairs;
  // Who belongs to no list has the greatest number there is, and more bits than any list's.
  const auto bits = static_cast<std::uint32_t>(std::bit_width(num_lists));
  for (push.shift = 0; push.shift < bits; push.shift += device::kSortBits) {
    commands.dispatch(Stage::kSortCount, {}, {&pairs_, &digits_}, push, grid_of(blocks));
    scan(digits_, num_digits);
    commands.dispatch(Stage::kSortScatter, {}, {&pairs_, &digits_, &other_pairs_}, push,
                      grid_of(blocks));
    std::swap(pairs_, other_pairs_);
  }
  commands.dispatch(Stage::kListEnds, {}, {&pairs_, &ends_}, push,
                    grid_of(groups_for(layers.num_pairs, 256)));
  require_short_loops(set, layers, num_lists);
}

// Software drivers end loops early, and say nothing (software_limits.h): over the lists of a
// kernel, over the kernels of a list, with those of all the larger tiles around it.
void KernelRenderer::require_short_loops(const Set& set, const Layers& layers,
                                         std::uint32_t num_lists) {
  if (bench_.device->info().kind != DeviceKind::kSoftware) return;
  Commands& commands = bench_.commands;
  commands.submit_and_wait();
  std::vector<std::uint32_t> offsets(layers.num_splats + std::size_t{1});
  commands.read_back(offsets_, 0, std::as_writable_bytes(std::span(offsets)));
  std::uint32_t longest = 0;
  for (std::size_t i = 1; i < offsets.size(); ++i)
    longest = std::max(longest, offsets[i] - offsets[i - 1]);
  std::vector<std::array<std::uint32_t, 2>> ends(num_lists);
  commands.read_back(ends_, 0, std::as_writable_bytes(std::span(ends)));
  std::array<std::uint32_t, device::kNumLevels> fullest{};  // list of each level
  for (std::uint32_t list = 0; list < num_lists; ++list) {
    std::size_t level = device::kNumLevels - 1;
    while (list % set.lists_per_layer < set.frame.levels[level].first_list) --level;
    fullest[level] = std::max(fullest[level], ends[list][1] - ends[list][0]);
  }
  const bool takes_points =
      set.traits.takes_means && set.traits.profile != KernelProfile::kGaussian;
  const std::uint32_t most = std::accumulate(fullest.begin(), fullest.end(), 0U);
  const double rounds = 1.1 * most * (takes_points ? device::kProfilePoints : 1);
  if (longest < kMostRounds && rounds < kMostRounds) return;
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("backend vulkan: software drivers cannot sum the {} kernels that reach one "
                  "tile, or list one kernel at {} tiles: expected a nearer view, or backend "
                  "cpu",
                  most, longest));
}

// Layers [first, end) become sheets of the ring, coarse levels first.
void KernelRenderer::reconstruct(Set& set, const Layers& layers, int first, int end) {
  const bool has_levels = set.frame.max_level > 0;
  device::KernelPush push = push_of(layers);
  push.layer = first;
  for (int level = has_levels ? layers.coarsest : 0; level >= 0; --level) {
    push.level = level;
    Constants constants = set.constants;
    constants.push_back((level == 0 ? device::kIsFinest : 0) |
                        (has_levels && level < layers.coarsest ? device::kHasCoarser : 0));
    const device::ivec4& tiles = set.frame.levels[level].tiles;
    bench_.commands.mark("reconstruct");
    // Two half sheets share a word: they go together.
    const bool is_packed = set.options.pack_sheets || set.has_half_sheets;
    for (int sheet = is_packed ? -1 : 0; sheet < (is_packed ? 0 : view::kBlockDepth); ++sheet) {
      push.only_sheet = sheet;
      bench_.commands.dispatch(
          Stage::kReconstruct, constants,
          {&frame_, &splats_, &pairs_, &ends_, &needed_blocks_, &open_, &planes_, &sheets_,
           &color_sheets_, &counts_},
          push,
          {static_cast<std::uint32_t>(tiles.x), static_cast<std::uint32_t>(tiles.y),
           static_cast<std::uint32_t>(end - first)});
    }
  }
}

void KernelRenderer::shade(Set& set, const Strip& strip, int first_sheet, int end_sheet) {
  if (first_sheet >= end_sheet) return;
  device::KernelPush push{};
  push.first_sheet = first_sheet;
  push.end_sheet = end_sheet;
  push.first_row = static_cast<std::uint32_t>(strip.first);
  push.end_row = static_cast<std::uint32_t>(strip.end);
  bench_.commands.mark("shade and composite");
  bench_.commands.dispatch(
      Stage::kShade, set.constants,
      {&frame_, &tables_, &sheets_, &color_sheets_, &needed_blocks_, &open_,
       &bench_.pixels.colors(), &bench_.pixels.depths(), &bench_.pixels.states(), &counts_,
       &bench_.pixels.pixel_stops(), &bench_.pixels.stops()},
      push, groups_of(set.options, strip, device::kGroupEdge));
}

bool KernelRenderer::draw_strip(Set& set, const Strip& strip, const RenderHooks& hooks,
                                FrameProfile& profile) {
  set.strip = strip;
  prepare_strip(set, strip);
  const int num_layers = set.plan.num_blocks[2];
  const int num_sheets = set.frame.num_sheets;
  int shaded_to = 0;
  for (int first = 0; first < num_layers;) {
    if (set.needed_layers[static_cast<std::size_t>(first)] == 0) {
      ++first;
      continue;
    }
    const std::optional<Layers> binned = bin_layers(set, first);
    if (!binned) return false;
    const Layers& layers = *binned;
    profile.kernels_loaded += layers.num_pairs;
    for (int layer = layers.first; layer < layers.end;) {
      if (hooks.stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "rendering was cancelled");
      if (set.needed_layers[static_cast<std::size_t>(layer)] == 0) {
        // Nothing here can show, nor on the last sheet before.
        shaded_to = ++layer * view::kBlockDepth;
        continue;
      }
      int end = layer + 1;
      while (end < layers.end && end - layer < set.chunk_layers &&
             set.needed_layers[static_cast<std::size_t>(end)] != 0)
        ++end;
      reconstruct(set, layers, layer, end);
      // The last sheet waits for the one behind it.
      const int shade_to = std::min(end * view::kBlockDepth - 1, num_sheets);
      shade(set, strip, shaded_to, shade_to);
      shaded_to = std::max(shaded_to, shade_to);
      layer = end;
      // Who waits for a software driver wants to be able to stop.
      if (hooks.stop.stop_possible() && bench_.device->info().kind == DeviceKind::kSoftware)
        bench_.commands.submit_and_wait();
    }
    first = layers.end;
  }
  shade(set, strip, shaded_to, num_sheets);
  return true;
}

// The frame's constants and tables.
void KernelRenderer::set_constants(Set& set) {
  const KernelField& field = set.field;
  const RenderOptions& options = set.options;
  const FrameTraits traits = frame_traits(set.plan, set.look, options);
  FrameTables tables;
  device::KernelFrame& frame = set.frame;
  frame.view = view_constants(set.plan, options);
  frame.looks[0] = look_constants(set.plan, set.look, traits.corrects_late, tables);
  const SheetRange sheets = sheet_range(field.value_range(), field.reconstruction());
  frame.sheet_scale = sheets.scale;
  frame.sheet_offset = sheets.offset;
  frame.num_sheets = frame.view.num_sheets;
  frame.num_numbers = kernels_->num_numbers();
  set.constants = {number_of(set.look.mode), frame_flags(traits, options),
                   set_flags(set.traits, field, traits.is_parallel) |
                       (set.has_half_sheets ? device::kSetHalfSheets : 0),
                   number_of(set.traits.profile),
                   static_cast<std::uint32_t>(set.traits.num_channels)};
  if (set.light != nullptr) {
    frame.looks[0].volume = light_constants(set.plan, *set.light);
    frame.looks[0].volume.dims.w = append_light(*set.light, tables);
    set.constants[1] |= device::kHasLightVolume;
  }
  reserve(tables_, bench_.device, tables.size() * sizeof(device::vec4), BufferUse::kDevice);
  bench_.commands.upload(tables_, 0, std::as_bytes(std::span(tables)));
}

// Which of the plan's blocks, and layers of them, are needed, and which bricks those are of.
void KernelRenderer::set_needs(Set& set) {
  const int num_layers = set.plan.num_blocks[2];
  const std::size_t per_layer =
      static_cast<std::size_t>(set.plan.num_blocks[0]) * set.plan.num_blocks[1];
  std::vector<std::uint8_t> blocks(set.plan.is_needed.size());
  set.needed_layers.assign(static_cast<std::size_t>(std::max(num_layers, 1)), 0);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    blocks[i] =
        static_cast<std::uint8_t>((set.plan.is_needed[i] != 0 ? device::kBlockIsNeeded : 0) |
                                  (set.plan.is_relevant[i] != 0 ? device::kBlockIsRelevant : 0));
    if (set.plan.is_needed[i] != 0) set.needed_layers[i / per_layer] = 1;
  }
  set.reaches.reserve(set.plan.bricks.size());
  for (const std::int64_t brick : set.plan.bricks) {
    set.reaches.push_back(reach_of(set.field.source().brick(brick), set.plan,
                                   set.field.source().cutoff(), set.frame.max_level > 0));
  }
  reserve(needed_layers_, bench_.device, set.needed_layers.size() * 4, BufferUse::kDevice);
  reserve(needed_blocks_, bench_.device, blocks.size() + 4, BufferUse::kDevice);
  bench_.commands.upload(needed_layers_, 0, std::as_bytes(std::span(set.needed_layers)));
  bench_.commands.upload(needed_blocks_, 0, std::as_bytes(std::span(blocks)));
}

void KernelRenderer::render(const FrameJob& job, Image& image, FrameProfile& profile) {
  const KernelField& field = *job.field.kernels();
  const auto& [any_field, camera, look, trail, options, hooks, light, base, further, mixing] = job;
  require_few_stops(options.depth_limits.get(), bench_.device->info().kind);
  Commands& commands = bench_.commands;
  std::optional<HostStage> planning(std::in_place, commands, "plan");
  Set set(*bench_.device, field, camera, look, options, light);
  if (!kernels_ || !kernels_->is_of(field)) {
    kernels_.reset();
    kernels_ = std::make_unique<DeviceKernels>(bench_.device, field, bench_.most_bytes);
  }

  if (!set.why_no_half_sheets.empty())
    profile.notice = fmt::format("sheet precision: floats, as 16 bits could be seen: {}",
                                 set.why_no_half_sheets);
  set_constants(set);
  set_needs(set);
  planning.reset();
  for (const std::int64_t brick : set.plan.bricks)
    profile.kernels_drawn += field.source().brick(brick).count;
  // A ring of two layers of sheets at least, and as much again for coarser levels, must fit.
  const std::uint64_t margin = 4 * device::kGroupEdge;
  const auto width = static_cast<std::uint64_t>(options.width);
  const std::uint64_t bytes_per_pixel = (64 * (width + margin) + width - 1) / width;
  std::vector<Strip> strips = bench_.pixels.strips(options, hooks, bytes_per_pixel);
  std::reverse(strips.begin(), strips.end());
  while (!strips.empty()) {
    const Strip strip = strips.back();
    strips.pop_back();
    bench_.pixels.clear(commands, options, strip);
    commands.submit_and_wait();
    if (!draw_strip(set, strip, hooks, profile)) {
      // Fewer kernels reach half as many rows.
      strips.push_back(second_half(strip));
      strips.push_back({strip.first, strips.back().first});
      continue;
    }
    bench_.pixels.record_last_stops(commands, frame_, set.constants);
    commands.submit_and_wait();
    bench_.pixels.finish(commands, look, options.part != nullptr, strip, image);
    add_counts(commands, counts_,
               static_cast<std::size_t>(set.frame.levels[0].tiles.x) * set.frame.levels[0].tiles.y,
               profile);
    tell_of(strip, hooks, image);
  }
}

}  // namespace ovoid::vulkan
