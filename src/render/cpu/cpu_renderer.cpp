// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <mutex>
#include <numbers>
#include <tuple>
#include <utility>

#include "ovoid/error.h"
#include "render/cpu/ticks.h"
#include "render/cpu/tile.h"

namespace ovoid::cpu {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Gauss-Legendre nodes on [-1/2, 1/2], by Newton's method on the Legendre polynomials.
void set_slab_nodes(CpuFrame& frame, int count) {
  frame.num_slab_nodes = count;
  for (int i = 0; i < count; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    double slope = 1;
    for (int step = 0; step < 20; ++step) {
      double p = 1;
      double before = 0;
      for (int n = 0; n < count; ++n) {
        const double next = ((2 * n + 1) * x * p - n * before) / (n + 1);
        before = p;
        p = next;
      }
      slope = count * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    frame.slab_nodes[static_cast<std::size_t>(i)] = {
        static_cast<float>(x / 2), static_cast<float>(1 / ((1 - x * x) * slope * slope))};
  }
}

// Enough nodes for the slab's mean to err by less than the agreement tier allows: four per two
// sigmas of the narrowest kernel.
int slab_nodes_for(const LatticeField& field, const view::ViewLattice& lattice) {
  double longest = 0;  // slab in spacings
  const view::SheetMap here = lattice.index_map(0);
  const view::SheetMap next = lattice.index_map(1);
  for (const double x : {0.0, lattice.width() - 1.0}) {
    for (const double y : {0.0, lattice.height() - 1.0}) {
      longest = std::max(longest, (next.at(x, y) - here.at(x, y)).norm());
    }
  }
  return std::clamp(2 + static_cast<int>(std::ceil(2 * longest / field.kernel().sigma)), 4,
                    kMaxSlabNodes);
}

void set_kernel(CpuFrame& frame, const LatticeField& field) {
  const LatticeKernel& kernel = field.kernel();
  frame.sigma = static_cast<float>(kernel.sigma);
  frame.support = static_cast<float>(kernel.support_radius());
  frame.inverse_variance = 1.0F / (frame.sigma * frame.sigma);
  frame.near_weight = std::exp(-0.5F * frame.inverse_variance);
  frame.far_weight = std::exp(-2.0F * frame.inverse_variance);
  frame.is_sum = field.reconstruction() == Reconstruction::kSum;
  frame.sum_weight =
      static_cast<float>(1.0 / (std::pow(2 * std::numbers::pi, 1.5) * std::pow(kernel.sigma, 3)));
  for (int a = 0; a < 3; ++a) frame.dims[a] = static_cast<std::int32_t>(field.geometry().dims[a]);
  frame.value_scale = static_cast<float>(field.source().value_scale());
  frame.value_offset = static_cast<float>(field.source().value_offset());
  const Mat3 gradient = field.geometry().world_from_index.linear().inverse().transpose();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c)
      frame.world_from_index_gradient[3 * r + c] = static_cast<float>(gradient(r, c));
  }
}

void set_view(CpuFrame& frame, const view::FramePlan& plan) {
  const view::ViewLattice& lattice = plan.lattice;
  frame.is_parallel = lattice.is_parallel();
  frame.sampling_distance = static_cast<float>(lattice.sampling_distance());
  frame.ray_direction = lattice.ray_direction();
  const view::SheetMap map = lattice.world_map(0);
  const double sign = lattice.is_parallel() || lattice.depth(0) > 0
                          ? 1.0
                          : -1.0;  // a sheet behind the eye is mirrored
  const Vec3 right = map.per_x.normalized() * sign;
  const Vec3 up = -map.per_y.normalized() * sign;
  const Vec3 axis = lattice.view_axis();
  for (int a = 0; a < 3; ++a) {
    frame.right[a] = static_cast<float>(right[a]);
    frame.up[a] = static_cast<float>(up[a]);
    frame.axis[a] = static_cast<float>(axis[a]);
  }
  const auto slope_along = [&](const Vec3& v) {
    const view::SheetMap& direction = frame.ray_direction;
    return view::ClipMap{v.dot(direction.origin), v.dot(direction.per_x), v.dot(direction.per_y)};
  };
  frame.ray_slope_right = slope_along(right);
  frame.ray_slope_up = slope_along(up);
}

// Memory of what a frame's tables point to.
struct LookTables {
  FloatBuffer look, integrals, fading;
};

// The nodes of ClassificationTable.
FloatBuffer classification_nodes(const view::LookTable& table, double path_in_units) {
  FloatBuffer nodes;
  float* node = nodes.reserve(std::size_t{4} * view::LookTable::kPaddedNodes);
  for (int i = 0; i < view::LookTable::kPaddedNodes; ++i, node += 4) {
    node[0] = table.red()[i];
    node[1] = table.green()[i];
    node[2] = table.blue()[i];
    node[3] = static_cast<float>(
        1.0 - std::pow(1.0 - static_cast<double>(table.opacity()[i]), path_in_units));
  }
  return nodes;
}

// A range outside of which the table has no opacity, a cell wider than it need be.
std::pair<float, float> visible_values(const view::LookTable& table) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const float* const opacity = table.opacity();
  const float* const end = opacity + view::LookTable::kNodes;
  const auto shows = [](float a) { return a > 0.0F; };
  const auto first = std::find_if(opacity, end, shows) - opacity;
  if (first == view::LookTable::kNodes) return {kInfinity, -kInfinity};
  const auto last =
      std::find_if(std::reverse_iterator(end), std::reverse_iterator(opacity), shows).base() - 1 -
      opacity;
  const auto value_at = [&](std::ptrdiff_t node) {
    return static_cast<float>(table.axis().value_of_node(static_cast<double>(node)));
  };
  // Values beyond the table read its ends.
  return {first == 0 ? -kInfinity : value_at(first - 2),
          last == view::LookTable::kCells ? kInfinity : value_at(last + 2)};
}

// As ClassificationTable says; `nodes` is what classification_nodes() made of `table`.
ClassificationTable classification_table(const view::LookTable& table, const FloatBuffer& nodes) {
  ClassificationTable result{nodes.data.get(), table.has_steps() ? table.step() : nullptr,
                             table.axis(), static_cast<float>(view::LookTable::kCells)};
  std::tie(result.visible_lo, result.visible_hi) = visible_values(table);
  return result;
}

// What IntegralTable integrates, at node i.
std::array<double, 4> integrand_at(const view::LookTable& table, int i) {
  const double opacity = table.opacity()[i];
  const double extinction =
      opacity < 1.0 ? std::min(-std::log1p(-opacity), kGreatestExtinction) : kGreatestExtinction;
  return {extinction * table.red()[i], extinction * table.green()[i], extinction * table.blue()[i],
          extinction};
}

// Fills `nodes`, and the frame's IntegralTable that points to them.
IntegralTable integral_table(const view::LookTable& table, FloatBuffer& nodes) {
  using view::LookTable;
  constexpr int kParts = 8;
  float* node = nodes.reserve(std::size_t{kParts} * LookTable::kPaddedNodes);
  const double first = table.axis().value_of_node(0);
  const double last = table.axis().value_of_node(LookTable::kCells);
  const double per_value = LookTable::kCells / (last - first);
  std::array<double, 4> sum{};
  std::array<double, 4> here = integrand_at(table, 0);
  for (int i = 0; i < LookTable::kPaddedNodes; ++i, node += kParts) {
    for (std::size_t c = 0; c < 4; ++c) {
      node[c] = static_cast<float>(sum[c]);
      node[c + 4] = static_cast<float>(sum[c] - static_cast<double>(node[c]));
    }
    if (i >= LookTable::kCells) continue;
    const std::array<double, 4> next = integrand_at(table, i + 1);
    // Of a cell with a step, each side has its share.
    const double share = table.step()[i] >= 0.0F ? static_cast<double>(table.step()[i]) : 0.5;
    const double width =
        (table.axis().value_of_node(i + 1) - table.axis().value_of_node(i)) * per_value;
    for (std::size_t c = 0; c < 4; ++c)
      sum[c] += width * (share * here[c] + (1.0 - share) * next[c]);
    here = next;
  }
  IntegralTable result;
  result.nodes = nodes.data.get();
  result.per_value = static_cast<float>(per_value);
  result.value_lo = static_cast<float>(first);
  result.value_hi = static_cast<float>(last);
  for (std::size_t c = 0; c < 4; ++c) {
    result.before[c] = static_cast<float>(integrand_at(table, 0)[c]);
    result.behind[c] = static_cast<float>(integrand_at(table, LookTable::kCells)[c]);
  }
  return result;
}

void set_look(CpuFrame& frame, const LatticeField& field, const Look& look,
              const view::FramePlan& plan, LookTables& tables) {
  const bool is_composite = look.mode == Mode::kComposite;
  frame.mode = look.mode;
  frame.shade = look.shade;
  frame.is_preintegrated = is_composite && plan.is_preintegrated;
  frame.fades_by_gradient = is_composite && plan.fading.has_value();
  frame.takes_gradients = is_composite && (look.shade || frame.fades_by_gradient);
  frame.corrects_late = frame.is_preintegrated || frame.fades_by_gradient;
  const double path_in_units = plan.lattice.sampling_distance() / plan.unit_distance;
  frame.path_in_units = static_cast<float>(path_in_units);
  tables.look = classification_nodes(plan.look_table, frame.corrects_late ? 1.0 : path_in_units);
  frame.table = classification_table(plan.look_table, tables.look);
  if (frame.is_preintegrated) frame.integrals = integral_table(plan.look_table, tables.integrals);
  if (frame.fades_by_gradient) {
    tables.fading = classification_nodes(*plan.fading, 1.0);
    frame.fading = classification_table(*plan.fading, tables.fading);
  }
  frame.isovalue = static_cast<float>(look.isovalue);
  const Rgb color = look.transfer_function.color_at(look.isovalue);
  for (int c = 0; c < 3; ++c) frame.isosurface_color[c] = static_cast<float>(color[c]);
  frame.ambient = static_cast<float>(look.material.ambient);
  frame.diffuse = static_cast<float>(look.material.diffuse);
  frame.specular = static_cast<float>(look.material.specular);
  frame.specular_power = static_cast<float>(look.material.specular_power);
  frame.has_headlight = !look.light_direction.has_value();
  if (look.light_direction) {
    const Vec3 light = look.light_direction->normalized();
    for (int a = 0; a < 3; ++a) frame.light[a] = static_cast<float>(light[a]);
  }
  constexpr double kFlat =
      1e-4;  // of the drawn range, per smallest spacing (docs/numerics.md, "Light")
  const double span = look.mode == Mode::kIsosurface
                          ? static_cast<double>(field.value_range().hi) - field.value_range().lo
                          : look.transfer_function.hi() - look.transfer_function.lo();
  const double h = field.geometry().spacing().minCoeff();
  frame.flat_gradient_inverse =
      static_cast<float>(span > 0 ? std::min(h / (kFlat * span), 1e30) : 1e30);
}

void decide_relevance(view::FramePlan& plan, Runner& runner) {
  if (!plan.may_matter) {
    plan.relevance.fill_everything();
  } else {
    runner.run(plan.relevance.num_layers(),
               [&](int layer, int) { plan.relevance.fill_layer(layer, plan.may_matter); });
  }
  plan.relevance.finish();
}

// Stage "finish": a tile's state becomes pixels.
void finish_tile(const CpuFrame& frame, const Look& look, const TileState& tile,
                 const TileRect& rect, Image& image) {
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      const int i = (y - rect.y0) * kTileSize + (x - rect.x0);
      const std::size_t pixel = static_cast<std::size_t>(y) * image.width + x;
      float* rgba = image.rgba.data() + 4 * pixel;
      image.depth[pixel] = tile.depth[i];
      if (frame.mode == Mode::kComposite || frame.mode == Mode::kIsosurface) {
        rgba[0] = tile.red[i];
        rgba[1] = tile.green[i];
        rgba[2] = tile.blue[i];
        rgba[3] = tile.alpha[i];
        continue;
      }
      if ((tile.seen[y - rect.y0] >> (x - rect.x0) & 1U) == 0) continue;
      if (frame.mode == Mode::kXray) {
        rgba[0] = rgba[1] = rgba[2] = tile.best[i];
        rgba[3] = 1.0F;
        continue;
      }
      const double value = frame.mode == Mode::kMean ? tile.best[i] / tile.path[i] : tile.best[i];
      const Rgb color = look.transfer_function.color_at(value);
      const double opacity = look.transfer_function.opacity_at(value);
      for (int c = 0; c < 3; ++c) rgba[c] = static_cast<float>(color[c] * opacity);
      rgba[3] = static_cast<float>(opacity);
    }
  }
}

std::vector<TileRect> tiles_of(int width, int height) {
  std::vector<TileRect> tiles;
  for (int y = 0; y < height; y += kTileSize) {
    for (int x = 0; x < width; x += kTileSize) {
      tiles.push_back({x, y, std::min(x + kTileSize, width), std::min(y + kTileSize, height)});
    }
  }
  return tiles;
}

// Reports tiles one at a time, whatever the number of workers.
class Watch {
 public:
  Watch(const RenderHooks& hooks, std::size_t num_tiles) : hooks_(hooks), num_tiles_(num_tiles) {}
  void tile_done(const TileRect& rect, const Image& image) {
    if (!hooks_.progress && !hooks_.tile_done) return;
    const std::lock_guard lock(mutex_);
    ++done_;
    if (hooks_.tile_done) hooks_.tile_done({rect.x0, rect.y0, rect.x1, rect.y1, &image});
    if (hooks_.progress)
      hooks_.progress(static_cast<double>(done_) / static_cast<double>(num_tiles_));
  }

 private:
  const RenderHooks& hooks_;
  std::size_t num_tiles_;
  std::size_t done_ = 0;
  std::mutex mutex_;
};

void merge(const std::vector<std::unique_ptr<Workspace>>& workspaces, double ticks_per_ms,
           FrameProfile& profile) {
  std::array<double, kNumStages> ms{};
  for (const auto& work : workspaces) {
    const WorkerStats& stats = work->stats;
    profile.samples_reconstructed += stats.samples_reconstructed;
    profile.samples_shaded += stats.samples_shaded;
    profile.gradients += stats.gradients;
    profile.kernels_loaded += stats.kernels_loaded;
    profile.blocks_total += stats.blocks_total;
    profile.blocks_drawn += stats.blocks_drawn;
    profile.blocks_skipped_empty += stats.skipped_empty;
    profile.blocks_skipped_irrelevant += stats.skipped_irrelevant;
    profile.blocks_skipped_opaque += stats.skipped_opaque;
    for (int i = 0; i < kNumStages; ++i)
      ms[i] += static_cast<double>(stats.ticks[i]) / ticks_per_ms;
  }
  if (ticks_per_ms <= 0) return;
  for (int i = 0; i < kNumStages; ++i) profile.stages_ms.emplace_back(kStageNames[i], ms[i]);
}

}  // namespace

Frame render(const LatticeField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, const RenderHooks& hooks, Runner& runner) {
  const Clock::time_point start = Clock::now();
  const std::uint64_t start_ticks = read_ticks();
  Frame out;
  out.profile.backend = "cpu";
  out.profile.simd_target = simd_target_in_use();
  out.profile.threads = runner.num_workers();
  out.profile.kernels_total = field.num_kernels();
  out.image.width = options.width;
  out.image.height = options.height;
  const std::size_t num_pixels = static_cast<std::size_t>(options.width) * options.height;
  out.image.rgba.assign(4 * num_pixels, 0.0F);
  out.image.depth.assign(num_pixels, std::numeric_limits<float>::infinity());

  view::FramePlan plan(field, camera, look, options);
  decide_relevance(plan, runner);
  LookTables tables;
  CpuFrame frame;
  frame.plan = &plan;
  frame.field = &field;
  frame.stop = hooks.stop;
  set_kernel(frame, field);
  set_view(frame, plan);
  set_look(frame, field, look, plan, tables);
  const bool is_mean = options.slab == Slab::kMean;
  set_slab_nodes(frame, is_mean ? slab_nodes_for(field, plan.lattice) : 1);
  frame.central_gradient = options.gradient == GradientMethod::kCentral && frame.takes_gradients;
  frame.corrects_gradient = options.gradient != GradientMethod::kExact && !frame.is_sum;
  frame.evaluate = options.evaluate;
  frame.stop_opaque = options.stop_opaque;
  frame.collect_profile = options.collect_profile;
  frame.has_four_taps = frame.support == 2.0F && frame.sigma >= 0.25F && frame.sigma <= 2.0F &&
                        !frame.is_sum && !is_mean;
  const int edge = field.source().brick_edge();
  out.profile.kernels_drawn =
      std::min(field.num_kernels(), plan.relevance.num_relevant() * edge * edge * edge);
  const double plan_ms = ms_since(start);

  const std::vector<TileRect> tiles = tiles_of(options.width, options.height);
  std::vector<std::unique_ptr<Workspace>> workspaces;
  workspaces.reserve(static_cast<std::size_t>(runner.num_workers()));
  for (int i = 0; i < runner.num_workers(); ++i)
    workspaces.push_back(std::make_unique<Workspace>());
  Watch watch(hooks, tiles.size());
  runner.run(static_cast<int>(tiles.size()), [&](int task, int worker) {
    if (hooks.stop.stop_requested()) return;
    Workspace& work = *workspaces[static_cast<std::size_t>(worker)];
    const TileRect& rect = tiles[static_cast<std::size_t>(task)];
    render_tile(frame, work, rect);
    finish_tile(frame, look, work.tile, rect, out.image);
    watch.tile_done(rect, out.image);
  });
  if (hooks.stop.stop_requested()) throw Error(ErrorCode::kCancelled, "rendering was cancelled");

  out.profile.frame_ms = ms_since(start);
  const double ticks_per_ms =
      static_cast<double>(read_ticks() - start_ticks) / out.profile.frame_ms;
  if (options.collect_profile) out.profile.stages_ms.emplace_back("plan", plan_ms);
  merge(workspaces, options.collect_profile ? ticks_per_ms : 0.0, out.profile);
  return out;
}

}  // namespace ovoid::cpu
