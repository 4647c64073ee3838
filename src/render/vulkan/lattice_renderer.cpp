// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/lattice_renderer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "data/parallel.h"
#include "ovoid/error.h"
#include "render/shared/look_values.h"
#include "render/vulkan/shader_flags.h"
#include "render/vulkan/software_limits.h"

namespace ovoid::vulkan {
namespace {

// The eye in index space; in parallel projection far away, where the rays come from.
Vec3 eye_of(const Camera& camera, const view::LatticePlan& plan, const LatticeField& field) {
  if (!plan.lattice.is_parallel())
    return field.geometry().world_from_index.inverse() * camera.position;
  const Vec3 step = plan.lattice.index_map(1).origin - plan.lattice.index_map(0).origin;
  const Index3 cells = field.geometry().cells();
  Vec3 eye;
  for (int a = 0; a < 3; ++a) eye[a] = step[a] > 0 ? -1.0 : static_cast<double>(cells[a]) + 1.0;
  return eye;
}

// Cells that what one sample reads may be away from it: its kernels, neighbours on sheets and
// pixels, and, where there are nodes, three of those and their neighbours, a cell apart at most.
constexpr double kNodeReach = 5;

int reach_of(const LatticeField& field, const view::LatticePlan& plan, bool has_nodes) {
  const view::SheetMap here = plan.lattice.index_map(plan.sheets.first);
  const view::SheetMap next = plan.lattice.index_map(plan.sheets.first + 1);
  double step = 0;
  for (const double x : {0.0, plan.lattice.width() - 1.0}) {
    for (const double y : {0.0, plan.lattice.height() - 1.0})
      step = std::max(step, (next.at(x, y) - here.at(x, y)).cwiseAbs().maxCoeff());
  }
  const view::SheetMap last = plan.lattice.index_map(plan.sheets.last);
  const double pixel =
      std::max({here.per_x.cwiseAbs().maxCoeff(), here.per_y.cwiseAbs().maxCoeff(),
                last.per_x.cwiseAbs().maxCoeff(), last.per_y.cwiseAbs().maxCoeff()});
  const double kernel = field.index_kernel().support_radius() * plan.greatest_widening;
  const double nodes = has_nodes ? kNodeReach : 0;
  // The front end of a piece has neighbours of its own.
  const double steps = plan.is_refined ? 2 * step : step;
  return static_cast<int>(std::ceil(std::max(kernel, 2.0) + steps + pixel + nodes)) + 1;
}

// Pixels per node from which kAuto takes nodes on software drivers: a tile's, with those around it,
// are half as many as its pixels, whose taps of nodes are a fifth of those of samples. On graphics
// processors every pixel for itself was twice as fast (docs/performance.md, "Graphics processors").
constexpr double kWorthwhileNodeStep = 2.0;

}  // namespace

// One field of a frame.
struct LatticeRenderer::Drawn {
  Drawn(const LatticeField& of, const Camera& camera, const Look& with,
        const RenderOptions& options, Kept& on)
      : field(of),
        look(with),
        plan(of, camera, with, options),
        frame_traits(ovoid::frame_traits(plan, with, options)),
        traits(lattice_traits(of, frame_traits, options)),
        kept(on) {}

  const LatticeField& field;
  const Look& look;
  view::LatticePlan plan;
  FrameTraits frame_traits;
  LatticeTraits traits;
  Kept& kept;
};

// One frame.
struct LatticeRenderer::Job {
  // Sheets [first, end) that one dispatch draws.
  struct Part {
    int first, end;
    float node_step;  // pixels between their nodes; 1: none
    bool is_narrow;   // no kernel is widened on them
  };

  const RenderOptions& options;
  const view::LightVolume* light;
  Drawn own;
  std::optional<Drawn> trail{};
  bool has_nodes = false;
  device::LatticeFrame frame{};
  Constants constants{};  // of the shader without nodes; that with them has one more
  std::vector<Part> parts{};
};

void LatticeRenderer::keep(Drawn& drawn, const BoxCut& cut, bool must_equal) {
  Kept& kept = drawn.kept;
  if (kept.lattice && kept.lattice->is_of(drawn.field)) {
    const BoxCut& has = kept.lattice->cut();
    const bool reaches = kept.lattice->num_boxes() == 1 || has.reach >= cut.reach;
    if (must_equal ? has == cut : reaches && has.most_bytes == cut.most_bytes) return;
  }
  kept = {};
  kept.lattice = std::make_unique<DeviceLattice>(bench_.device, drawn.field, cut);
}

// Which bricks can show, and how far each is from one that can.
void LatticeRenderer::decide_relevance(Drawn& drawn, const RenderOptions& options) {
  Kept& kept = drawn.kept;
  view::LatticePlan& plan = drawn.plan;
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
          const auto distance = static_cast<std::uint8_t>(is_relevant ? 0 : device::kFarBricks);
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
  commands.mark("relevance");
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

// What both fields of a frame need to be cut into the same boxes.
void LatticeRenderer::upload(Job& job) {
  const std::uint64_t num_fields = job.trail ? 2 : 1;
  BoxCut cut;
  cut.most_bytes = bench_.most_bytes / num_fields;
  for (const Drawn* drawn : {&job.own, job.trail ? &*job.trail : nullptr}) {
    if (drawn == nullptr) continue;
    const int reach = reach_of(drawn->field, drawn->plan, job.has_nodes);
    // Somewhat more, so that not every change of the view cuts anew.
    cut.reach = std::max(cut.reach, reach + reach / 2);
    cut.sample_bytes = std::max(cut.sample_bytes, stored_size(drawn->field));
  }
  if (!job.trail) kept_trail_ = {};
  keep(job.own, cut, job.trail.has_value());
  decide_relevance(job.own, job.options);
  if (!job.trail) return;
  keep(*job.trail, cut, true);
  decide_relevance(*job.trail, job.options);
}

// On graphics processors memory is what takes time: a gradient asks for the samples that its value
// has asked for.
bool LatticeRenderer::gathers_gradients(const Job& job) const {
  const FrameTraits& traits = job.own.frame_traits;
  return bench_.device->info().is_hardware() && job.own.look.mode == Mode::kComposite &&
         traits.takes_gradients && !traits.takes_differences && !traits.is_preintegrated;
}

void LatticeRenderer::set_constants(Job& job) {
  FrameTables tables;
  const auto add = [&](const Drawn& drawn, std::size_t number) {
    job.frame.looks[number] =
        look_constants(drawn.plan, drawn.look, drawn.frame_traits.corrects_late, tables);
    job.frame.fields[number] = lattice_constants(drawn.field, drawn.plan, drawn.traits);
    job.constants[2 + 2 * number] = type_number(drawn.kept.lattice->type());
    job.constants[3 + 2 * number] = lattice_flags(
        drawn.traits, drawn.field.geometry().num_sublattices() > 1, drawn.kept.lattice->may_miss());
  };
  job.frame.view = view_constants(job.own.plan, job.options);
  job.constants = {
      number_of(job.own.look.mode),
      frame_flags(job.own.frame_traits, job.options) | (job.trail ? device::kHasTrail : 0),
      0,
      0,
      0,
      0};
  if (gathers_gradients(job)) job.constants[1] |= device::kGathersGradients;
  add(job.own, 0);
  if (job.trail) add(*job.trail, 1);
  if (job.light != nullptr) {
    job.frame.looks[0].volume = light_constants(job.own.plan, *job.light);
    job.frame.looks[0].volume.dims.w = append_light(*job.light, tables);
    job.constants[1] |= device::kHasLightVolume;
  }

  Commands& commands = bench_.commands;
  commands.submit_and_wait();  // of relevance, whose buffers stay
  reserve(frame_, bench_.device, sizeof(job.frame), BufferUse::kDevice);
  reserve(tables_, bench_.device, tables.size() * sizeof(device::vec4), BufferUse::kDevice);
  reserve(nothing_, bench_.device, 16, BufferUse::kDevice);
  commands.upload(frame_, 0, std::as_bytes(std::span(&job.frame, 1)));
  commands.upload(tables_, 0, std::as_bytes(std::span(tables)));
}

// A part is of one layer, whose nodes have one node_step, or of several without nodes, and on
// software drivers as short as those need it.
void LatticeRenderer::divide_sheets(Job& job) const {
  const view::LatticePlan& plan = job.own.plan;
  const bool is_software = bench_.device->info().kind == DeviceKind::kSoftware;
  const bool is_auto = job.options.post_convolution == PostConvolution::kAuto;
  const auto rounds_of = [&](const Drawn& drawn, std::size_t number) {
    return rounds_of_sample({drawn.plan.greatest_widening, drawn.field.geometry().num_sublattices(),
                             job.constants[3 + 2 * number], drawn.look.mode,
                             drawn.frame_traits.takes_differences, drawn.frame_traits.is_refined},
                            job.frame.fields[number]);
  };
  const double rounds = rounds_of(job.own, 0) + (job.trail ? rounds_of(*job.trail, 1) : 0.0);
  // A thread of nodes has four pixels.
  const double stop_rounds =
      is_software && job.options.depth_limits != nullptr
          ? (job.has_nodes ? 4 : 1) * rounds_of_stops(*job.options.depth_limits)
          : 0;
  const int num_sheets = job.frame.view.num_sheets;
  for (int first = 0; first < num_sheets;) {
    const std::int64_t sheet = plan.sheets.first + first;
    double node_step = job.has_nodes ? plan.node_step(job.options.post_convolution, sheet) : 1.0;
    if (is_auto && node_step < kWorthwhileNodeStep) node_step = 1.0;
    int end = num_sheets;
    if (job.has_nodes || (!is_software && plan.greatest_widening > 1))
      end = static_cast<int>(
          std::min<std::int64_t>(end, view::next_layer(sheet) - plan.sheets.first));
    // Of the shader for narrow kernels alone there is less, so that more of its threads run at
    // once.
    const std::int64_t last_sheet = plan.sheets.first + end;
    const bool is_narrow =
        is_software ? plan.greatest_widening == 1 : plan.widening(last_sheet).maxCoeff() == 1;
    // Without nodes, layers are as good together; a graphics processor waits at their ends.
    if (!is_software && node_step == 1.0 && !job.parts.empty() &&
        job.parts.back().node_step == 1.0F && job.parts.back().is_narrow == is_narrow) {
      job.parts.back().end = end;
      first = end;
      continue;
    }
    // Of nodes a thread has up to four, and four pixels that may have to stand for themselves.
    double per_sheet = node_step > 1 ? 8 * rounds + 2500 : rounds + 20;
    if (node_step > 1 && job.options.spread == Spread::kBilinear)
      per_sheet +=
          4 * 7 * rounds_of_spread(job.frame.fields[0], node_step * plan.lattice.pitch(sheet));
    const int most =
        is_software ? static_cast<int>((kMostRounds - stop_rounds) / per_sheet) : end - first;
    if (most < 1)
      throw Error(ErrorCode::kUnsupported,
                  "backend vulkan: software drivers cannot sum so many kernels for one sample, or "
                  "pass so many depth limits: expected a larger picture, a nearer view, fewer "
                  "limits, or backend cpu");
    end = std::min(end, first + most);
    job.parts.push_back({first, end, static_cast<float>(node_step), is_narrow});
    first = end;
  }
}

// All sheets of one box of the lattice, on one strip of the picture.
void LatticeRenderer::draw_box(const Job& job, std::size_t number, const Strip& strip) {
  Commands& commands = bench_.commands;
  commands.submit_and_wait();
  const LatticeBox& box = job.own.kept.lattice->acquire(number, job.own.field, commands);
  const Buffer* trail_samples = &nothing_;
  const Buffer* trail_bricks = &nothing_;
  if (job.trail) {
    trail_samples = &job.trail->kept.lattice->acquire(number, job.trail->field, commands).data;
    trail_bricks = &job.trail->kept.bricks;
  }
  device::BoxConstants place = job.own.kept.lattice->constants_of(box);
  place.first_row = static_cast<std::uint32_t>(strip.first);
  place.end_row = static_cast<std::uint32_t>(strip.end);
  place.tile_y = place.first_row;
  commands.mark("draw");
  for (const Job::Part& part : job.parts) {
    place.first_sheet = part.first;
    place.end_sheet = part.end;
    place.node_step = part.node_step;
    const bool is_at_nodes = part.node_step > 1;
    Constants constants = job.constants;
    if (part.is_narrow && (constants[3] & device::kHasFourTaps) != 0)
      constants[3] |= device::kIsNarrow;
    if (is_at_nodes) constants.push_back(number_of(job.options.post_convolution));
    commands.dispatch(
        is_at_nodes ? Stage::kLatticeNodes : Stage::kLattice, constants,
        {&frame_, &tables_, &box.data, trail_samples, &job.own.kept.bricks, trail_bricks,
         &bench_.pixels.colors(), &bench_.pixels.depths(), &bench_.pixels.states(), &counts_,
         &bench_.pixels.pixel_stops(), &bench_.pixels.stops()},
        place, groups_of(job.options, strip, is_at_nodes ? device::kNodeTile : device::kGroupEdge));
  }
}

void LatticeRenderer::render(const FrameJob& frame, Image& image, FrameProfile& profile) {
  const auto& [any_field, camera, look, trail, options, hooks, light, base, further, mixing] =
      frame;
  const LatticeField& field = *any_field.lattice();
  std::optional<HostStage> planning(std::in_place, bench_.commands, "plan");
  Job job{options, light, {field, camera, look, options, kept_}};
  const bool takes_every_pixel =
      bench_.device->info().is_hardware() && options.post_convolution == PostConvolution::kAuto;
  job.has_nodes = job.own.traits.may_have_nodes && !takes_every_pixel;
  if (trail != nullptr) {
    job.trail.emplace(*trail->field, camera, trail->look, trail->options, kept_trail_);
    // Both count sheets from the same one, and have gradients in one unit.
    job.trail->plan.gradient_unit = job.own.plan.gradient_unit;
    view::ViewLattice::SheetRange& own = job.own.plan.sheets;
    view::ViewLattice::SheetRange& of_trail = job.trail->plan.sheets;
    own = of_trail = {std::min(own.first, of_trail.first), std::max(own.last, of_trail.last)};
  }
  upload(job);
  set_constants(job);
  divide_sheets(job);
  planning.reset();
  const int edge = field.source().brick_edge();
  profile.kernels_drawn =
      std::min(field.num_kernels(), job.own.plan.relevance.num_relevant() * edge * edge * edge *
                                        field.geometry().num_sublattices());
  Commands& commands = bench_.commands;
  const std::vector<std::size_t> order =
      kept_.lattice->front_to_back(eye_of(camera, job.own.plan, field));
  for (const Strip& strip : bench_.pixels.strips(options, hooks, sizeof(device::vec4))) {
    const Groups groups = groups_of(options, strip, device::kGroupEdge);
    bench_.pixels.clear(commands, options, strip);
    reserve(counts_, bench_.device, std::uint64_t{16} * groups.x * groups.y, BufferUse::kDevice);
    commands.fill(counts_, 0);
    for (const std::size_t number : order) {
      if (hooks.stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "rendering was cancelled");
      draw_box(job, number, strip);
    }
    bench_.pixels.record_last_stops(commands, frame_, job.constants);
    commands.submit_and_wait();
    bench_.pixels.finish(commands, look, options.part != nullptr, strip, image);
    add_counts(commands, counts_, std::size_t{groups.x} * groups.y, profile);
    tell_of(strip, hooks, image);
  }
}

}  // namespace ovoid::vulkan
