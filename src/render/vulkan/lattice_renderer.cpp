// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/lattice_renderer.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "data/parallel.h"
#include "ovoid/error.h"

namespace ovoid::vulkan {
namespace {

// The eye in index space; in parallel projection far away, where the rays come from.
Vec3 eye_of(const Camera& camera, const view::LatticePlan& plan, const LatticeField& field) {
  if (!plan.lattice.is_parallel())
    return field.geometry().world_from_index.inverse() * camera.position;
  const Vec3 step = plan.lattice.index_map(1).origin - plan.lattice.index_map(0).origin;
  const Index3 cells = field.geometry().cells();
  Vec3 eye;
  for (int a = 0; a < 3; ++a)
    eye[a] = step[a] > 0 ? -1.0 : static_cast<double>(cells[a]) + 1.0;
  return eye;
}

// Cells that what one sample reads may be away from it.
int reach_of(const LatticeField& field, const view::LatticePlan& plan) {
  const view::SheetMap here = plan.lattice.index_map(plan.sheets.first);
  const view::SheetMap next = plan.lattice.index_map(plan.sheets.first + 1);
  double step = 0;
  for (const double x : {0.0, plan.lattice.width() - 1.0}) {
    for (const double y : {0.0, plan.lattice.height() - 1.0})
      step = std::max(step, (next.at(x, y) - here.at(x, y)).cwiseAbs().maxCoeff());
  }
  const view::SheetMap last = plan.lattice.index_map(plan.sheets.last);
  const double pixel = std::max({here.per_x.cwiseAbs().maxCoeff(), here.per_y.cwiseAbs().maxCoeff(),
                                 last.per_x.cwiseAbs().maxCoeff(), last.per_y.cwiseAbs().maxCoeff()});
  const double kernel = field.index_kernel().support_radius() * plan.greatest_widening;
  return static_cast<int>(std::ceil(std::max(kernel, 2.0) + step + pixel)) + 1;
}

// Software drivers end a shader's loops, all of them together, after 65535 rounds, and say nothing:
// so many sheets at a time stay within. 0: not even one.
constexpr double kMostRounds = 60000;

struct Drawing {
  const LatticeField& field;
  const view::LatticePlan& plan;
  std::uint32_t flags;
  Mode mode;
  bool takes_differences;
};

int sheets_at_a_time(const Drawing& drawing, const device::LatticeConstants& lattice) {
  const double widening = drawing.plan.greatest_widening;
  const double taps = std::floor(2 * static_cast<double>(lattice.support) * widening) + 1;
  const bool has_four_taps =
      (drawing.flags & device::kHasFourTaps) != 0 && widening == 1 &&
      (drawing.flags & device::kMayMiss) == 0;
  // A row of taps goes by fours.
  const double per_node =
      has_four_taps ? 30 : taps * (taps * (std::ceil(taps / 4) + 1) + 1) + 9 * taps;
  const double per_sample = per_node * lattice.num_slab_nodes *
                            drawing.field.geometry().num_sublattices();
  const bool is_surface = drawing.mode == Mode::kIsosurface;
  const double samples = is_surface ? device::kSurfaceSteps + 3 : drawing.takes_differences ? 8 : 2;
  return static_cast<int>(kMostRounds / (per_sample * samples + 20));
}

}  // namespace

void LatticeRenderer::keep(Kept& kept, const LatticeField& field, const view::LatticePlan& plan) {
  const int reach = reach_of(field, plan);
  const bool suffices = kept.lattice && kept.lattice->is_of(field) &&
                        (kept.lattice->num_boxes() == 1 || kept.lattice->reach() >= reach);
  if (suffices) return;
  kept = {};
  // Somewhat more, so that not every change of the view cuts anew.
  kept.lattice = std::make_unique<DeviceLattice>(bench_.device, field, reach + reach / 2,
                                                 bench_.most_bytes / 2);
}

// Which bricks can show, and how far each is from one that can.
void LatticeRenderer::decide_relevance(Kept& kept, view::LatticePlan& plan,
                                       const RenderOptions& options) {
  view::RelevanceMap& map = plan.relevance;
  if (!plan.may_matter) {
    map.fill_everything();
  } else {
    data::parallel_ranges({map.num_layers(), 1, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t layer = begin; layer < end; ++layer)
        map.fill_layer(static_cast<int>(layer), plan.may_matter);
    });
  }
  map.finish();
  const Index3& n = map.num_bricks();
  const std::vector<std::uint8_t>& missing = kept.lattice->missing();
  // What is known of a brick's surroundings goes as far as kernels do on the field's own lattice.
  const bool reaches_farther = plan.greatest_widening > 1 || options.slab == Slab::kMean;
  const bool all_may_miss = kept.lattice->may_miss() && reaches_farther;
  std::vector<std::uint8_t> bytes(missing.size());
  data::parallel_ranges({n[2], 4, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t z = begin; z < end; ++z) {
      for (std::int64_t y = 0; y < n[1]; ++y) {
        const std::uint32_t* words = map.words() + (z * n[1] + y) * map.words_per_row();
        for (std::int64_t x = 0; x < n[0]; ++x) {
          const auto at = static_cast<std::size_t>((z * n[1] + y) * n[0] + x);
          const bool is_relevant = (words[x >> 5] >> (x & 31) & 1U) != 0;
          const auto distance =
              static_cast<std::uint8_t>(is_relevant ? 0 : device::kFarBricks);
          const std::uint8_t misses =
              all_may_miss ? static_cast<std::uint8_t>(device::kMissingBit) : missing[at];
          bytes[at] = static_cast<std::uint8_t>(distance | misses);
        }
      }
    }
  });
  if (bytes == kept.bytes) return;
  Commands& commands = bench_.commands;
  reserve(kept.bricks, bench_.device, bytes.size() + 4, BufferUse::kDevice);
  reserve(kept.other_bricks, bench_.device, bytes.size() + 4, BufferUse::kDevice);
  commands.upload(kept.other_bricks, 0, std::as_bytes(std::span(bytes)));
  kept.bytes = std::move(bytes);
  const Groups grid = grid_of(groups_for(kept.bytes.size(), 256));
  const Buffer* from = &kept.other_bricks;
  const Buffer* to = &kept.bricks;
  for (int axis = 0; axis < 3; ++axis) {
    const device::DistanceConstants constants{{static_cast<std::int32_t>(n[0]),
                                               static_cast<std::int32_t>(n[1]),
                                               static_cast<std::int32_t>(n[2]), axis}};
    commands.dispatch(Stage::kDistance, {}, {from, to}, constants, grid);
    std::swap(from, to);
  }
}

void LatticeRenderer::render(const LatticeField& field, const Camera& camera, const Look& look,
                             const RenderOptions& options, const RenderHooks& hooks,
                             const view::Behind* behind, Image& image, FrameProfile& profile) {
  Commands& commands = bench_.commands;
  Drawn own{&field, &look, view::LatticePlan(field, camera, look, options), &kept_};
  std::optional<Drawn> other;
  if (behind != nullptr) {
    RenderOptions plain = options;
    plain.classification = Classification::kSampled;
    other.emplace(Drawn{behind->field, &behind->look,
                        view::LatticePlan(*behind->field, camera, behind->look, plain),
                        &kept_behind_});
    // Both count sheets from the same one.
    const std::int64_t first = std::min(own.plan.sheets.first, other->plan.sheets.first);
    const std::int64_t last = std::max(own.plan.sheets.last, other->plan.sheets.last);
    own.plan.sheets = other->plan.sheets = {first, last};
  }
  const int edge = field.source().brick_edge();
  const auto num_fields = other ? 2U : 1U;
  Tables tables;
  device::LatticeFrame frame{};
  frame.view = view_constants(own.plan, options);
  for (std::uint32_t f = 0; f < num_fields; ++f) {
    Drawn& drawn = f == 0 ? own : *other;
    keep(*drawn.kept, *drawn.field, drawn.plan);
    commands.mark("relevance");
    decide_relevance(*drawn.kept, drawn.plan, options);
    frame.looks[f] = look_constants(drawn.plan, *drawn.look, drawn.field->value_range(), tables);
    frame.fields[f] = lattice_constants(*drawn.field, drawn.plan, options);
  }
  commands.submit_and_wait();
  profile.kernels_drawn =
      std::min(field.num_kernels(), own.plan.relevance.num_relevant() * edge * edge * edge *
                                        field.geometry().num_sublattices());
  const std::uint32_t flags =
      frame_flags(own.plan, look, options) | (other ? device::kHasBehind : 0);
  Constants constants = {mode_number(look.mode), flags, type_number(kept_.lattice->type()),
                         lattice_flags(field, options, kept_.lattice->may_miss()), 0, 0};
  if (other) {
    constants[4] = type_number(kept_behind_.lattice->type());
    constants[5] = lattice_flags(*behind->field, options, kept_behind_.lattice->may_miss());
  }

  reserve(frame_, bench_.device, sizeof(frame), BufferUse::kDevice);
  reserve(tables_, bench_.device, tables.size() * sizeof(device::vec4), BufferUse::kDevice);
  reserve(nothing_, bench_.device, 16, BufferUse::kDevice);
  commands.upload(frame_, 0, std::as_bytes(std::span(&frame, 1)));
  commands.upload(tables_, 0, std::as_bytes(std::span(tables)));
  int sheets = frame.view.num_sheets;
  if (bench_.device->info().kind == DeviceKind::kSoftware) {
    const bool takes_differences = (flags & device::kTakesDifferences) != 0;
    sheets = sheets_at_a_time({field, own.plan, constants[3], look.mode, takes_differences},
                              frame.fields[0]);
    if (other)
      sheets = std::min(sheets, sheets_at_a_time({*behind->field, other->plan, constants[5],
                                                  behind->look.mode, false},
                                                 frame.fields[1])) /
               2;
    if (sheets < 1)
      throw Error(ErrorCode::kUnsupported,
                  "backend vulkan: software drivers cannot sum so many kernels for one sample: "
                  "expected a larger picture, a nearer view, or backend cpu");
  }
  const std::vector<std::size_t> order =
      kept_.lattice->front_to_back(eye_of(camera, own.plan, field));
  const std::vector<Band> bands = bench_.pixels.bands(options, hooks, sizeof(device::vec4));
  std::vector<std::uint32_t> counts;
  for (const Band& band : bands) {
    const Groups groups{groups_for(static_cast<std::uint64_t>(options.width), device::kGroupEdge),
                        groups_for(static_cast<std::uint64_t>(band.rows()), device::kGroupEdge), 1};
    bench_.pixels.clear(commands, options.width, band);
    reserve(counts_, bench_.device, std::uint64_t{16} * groups.x * groups.y, BufferUse::kDevice);
    commands.fill(counts_, 0);
    for (const std::size_t number : order) {
      if (hooks.stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "rendering was cancelled");
      commands.submit_and_wait();
      const LatticeBox& box = kept_.lattice->acquire(number, field, commands);
      const Buffer* samples_behind = &nothing_;
      const Buffer* bricks_behind = &nothing_;
      if (other) {
        samples_behind = &kept_behind_.lattice->acquire(number, *behind->field, commands).samples;
        bricks_behind = &kept_behind_.bricks;
      }
      device::BoxConstants place = kept_.lattice->constants_of(box);
      place.first_row = static_cast<std::uint32_t>(band.first);
      place.end_row = static_cast<std::uint32_t>(band.end);
      place.tile_y = place.first_row;
      commands.mark("draw");
      for (int first = 0; first < frame.view.num_sheets; first += sheets) {
        place.first_sheet = first;
        place.end_sheet = std::min(first + sheets, frame.view.num_sheets);
        commands.dispatch(Stage::kLattice, constants,
                          {&frame_, &tables_, &box.samples, samples_behind, &kept_.bricks,
                           bricks_behind, &bench_.pixels.colors(), &bench_.pixels.depths(),
                           &bench_.pixels.states(), &counts_},
                          place, groups);
      }
    }
    commands.mark("read back");
    commands.submit_and_wait();
    bench_.pixels.finish(commands, look, band, image);
    if (options.collect_profile) {
      counts.resize(std::size_t{4} * groups.x * groups.y);
      commands.read_back(counts_, 0, std::as_writable_bytes(std::span(counts)));
      for (std::size_t i = 0; i < counts.size(); i += 4) {
        profile.samples_reconstructed += counts[i];
        profile.samples_shaded += counts[i + 1];
        profile.gradients += counts[i + 2];
      }
    }
    if (hooks.tile_done) hooks.tile_done({0, band.first, options.width, band.end, &image});
    if (hooks.progress)
      hooks.progress(static_cast<double>(band.end) / static_cast<double>(options.height));
  }
}

}  // namespace ovoid::vulkan
