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
  for (int a = 0; a < 3; ++a) eye[a] = step[a] > 0 ? -1.0 : static_cast<double>(cells[a]) + 1.0;
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
  const double pixel =
      std::max({here.per_x.cwiseAbs().maxCoeff(), here.per_y.cwiseAbs().maxCoeff(),
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

// Rounds of all loops for one sample of a sheet, its gradient included.
double rounds_of_sample(const Drawing& drawing, const device::LatticeConstants& lattice) {
  const double widening = drawing.plan.greatest_widening;
  const double taps = std::floor(2 * static_cast<double>(lattice.support) * widening) + 1;
  const bool has_four_taps = (drawing.flags & device::kHasFourTaps) != 0 && widening == 1 &&
                             (drawing.flags & device::kMayMiss) == 0;
  // A row of taps goes by fours.
  const double per_node =
      has_four_taps ? 30 : taps * (taps * (std::ceil(taps / 4) + 1) + 1) + 9 * taps;
  const bool is_surface = drawing.mode == Mode::kIsosurface;
  const double samples = is_surface ? device::kSurfaceSteps + 3 : drawing.takes_differences ? 8 : 2;
  return samples * per_node * lattice.num_slab_nodes * drawing.field.geometry().num_sublattices();
}

// Where a node's share of samples is looked for.
double rounds_of_spread(const device::LatticeConstants& lattice, double apart) {
  double rounds = 2;
  const device::vec4& along = lattice.camera_rows[2];
  const double tau = static_cast<double>(lattice.sigma) * std::hypot(along.x, along.y, along.z);
  const double reach = static_cast<double>(lattice.support / lattice.sigma) * tau;
  for (const device::vec4& row : lattice.camera_columns)
    rounds *=
        2 * (static_cast<double>(row.x + row.y) * apart + static_cast<double>(row.z) * reach) + 2;
  return rounds;
}

std::uint32_t filter_number(PostConvolution how) {
  switch (how) {
    case PostConvolution::kBilinear:
      return device::kFilterBilinear;
    case PostConvolution::kGaussian:
      return device::kFilterGaussian;
    case PostConvolution::kCubic:
      return device::kFilterCubic;
    default:
      return device::kFilterLagrange;
  }
}

// The bound of kAuto holds where the field is as smooth as its kernel, and the gradient no
// difference of neighbours, which would be as far apart as nodes.
constexpr double kLeastCutoff = 3.99;
bool may_have_nodes(const LatticeField& field, const RenderOptions& options,
                    const view::Behind* behind) {
  if (behind != nullptr || options.post_convolution == PostConvolution::kOff) return false;
  if (options.post_convolution != PostConvolution::kAuto) return true;
  const LatticeKernel kernel = field.index_kernel();
  return field.reconstruction() == Reconstruction::kNormalized && kernel.sigma >= 0.25 &&
         kernel.cutoff >= kLeastCutoff && options.gradient != GradientMethod::kCentral;
}

// Pixels per node from which kAuto takes nodes: a tile's, with those around it, are half as many as
// its pixels, whose taps of nodes are a fifth of those of samples.
constexpr double kWorthwhilePitch = 2.0;

}  // namespace

void LatticeRenderer::keep(Kept& kept, const LatticeField& field, const view::LatticePlan& plan,
                           std::uint64_t most_bytes) {
  const int reach = reach_of(field, plan);
  const bool suffices = kept.lattice && kept.lattice->is_of(field) &&
                        (kept.lattice->num_boxes() == 1 || kept.lattice->reach() >= reach);
  if (suffices) return;
  kept = {};
  // Somewhat more, so that not every change of the view cuts anew.
  kept.lattice =
      std::make_unique<DeviceLattice>(bench_.device, field, reach + reach / 2, most_bytes);
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
  if (!other) kept_behind_ = {};
  Tables tables;
  device::LatticeFrame frame{};
  frame.view = view_constants(own.plan, options);
  for (std::uint32_t f = 0; f < num_fields; ++f) {
    Drawn& drawn = f == 0 ? own : *other;
    keep(*drawn.kept, *drawn.field, drawn.plan, bench_.most_bytes / num_fields);
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
  Constants constants = {mode_number(look.mode),
                         flags,
                         type_number(kept_.lattice->type()),
                         lattice_flags(field, options, kept_.lattice->may_miss()),
                         0,
                         0};
  if (other) {
    constants[4] = type_number(kept_behind_.lattice->type());
    constants[5] = lattice_flags(*behind->field, options, kept_behind_.lattice->may_miss());
  }

  reserve(frame_, bench_.device, sizeof(frame), BufferUse::kDevice);
  reserve(tables_, bench_.device, tables.size() * sizeof(device::vec4), BufferUse::kDevice);
  reserve(nothing_, bench_.device, 16, BufferUse::kDevice);
  commands.upload(frame_, 0, std::as_bytes(std::span(&frame, 1)));
  commands.upload(tables_, 0, std::as_bytes(std::span(tables)));
  const bool has_nodes = may_have_nodes(field, options, behind);
  const auto pitch_of = [&](std::int64_t sheet) {
    if (!has_nodes) return 1.0;
    const double pitch = own.plan.node_pitch(options.post_convolution, sheet);
    const bool is_auto = options.post_convolution == PostConvolution::kAuto;
    return is_auto && pitch < kWorthwhilePitch ? 1.0 : pitch;
  };
  const bool is_software = bench_.device->info().kind == DeviceKind::kSoftware;
  const bool takes_differences = (flags & device::kTakesDifferences) != 0;
  double rounds = rounds_of_sample({field, own.plan, constants[3], look.mode, takes_differences},
                                   frame.fields[0]);
  if (other)
    rounds += rounds_of_sample(
        {*behind->field, other->plan, constants[5], behind->look.mode, false}, frame.fields[1]);
  // Sheets [first, end) that one list of commands draws, and the pitch of their nodes.
  struct Part {
    int first, end;
    float pitch;
  };
  std::vector<Part> parts;
  for (int first = 0; first < frame.view.num_sheets;) {
    const std::int64_t sheet = own.plan.sheets.first + first;
    const double pitch = pitch_of(sheet);
    int end = frame.view.num_sheets;
    if (has_nodes)
      end = static_cast<int>(
          std::min<std::int64_t>(end, view::next_layer(sheet) - own.plan.sheets.first));
    // Of nodes a thread has up to four, and four pixels that may have to stand for themselves.
    double per_sheet = pitch > 1 ? 8 * rounds + 2500 : rounds + 20;
    if (pitch > 1 && options.spread == Spread::kBilinear) {
      const double apart = pitch * own.plan.lattice.pitch(sheet);
      per_sheet += 4 * 7 * rounds_of_spread(frame.fields[0], apart);
    }
    const int most = is_software ? static_cast<int>(kMostRounds / per_sheet) : end - first;
    if (most < 1)
      throw Error(ErrorCode::kUnsupported,
                  "backend vulkan: software drivers cannot sum so many kernels for one sample: "
                  "expected a larger picture, a nearer view, or backend cpu");
    end = std::min(end, first + most);
    parts.push_back({first, end, static_cast<float>(pitch)});
    first = end;
  }
  Constants node_constants = constants;
  node_constants.push_back(filter_number(options.post_convolution));
  const std::vector<std::size_t> order =
      kept_.lattice->front_to_back(eye_of(camera, own.plan, field));
  const std::vector<Band> bands = bench_.pixels.bands(options, hooks, sizeof(device::vec4));
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
      for (const Part& part : parts) {
        place.first_sheet = part.first;
        place.end_sheet = part.end;
        place.pitch = part.pitch;
        const bool is_at_nodes = part.pitch > 1;
        const Groups node_groups{
            groups_for(static_cast<std::uint64_t>(options.width), device::kNodeTile),
            groups_for(static_cast<std::uint64_t>(band.rows()), device::kNodeTile), 1};
        commands.dispatch(
            is_at_nodes ? Stage::kLatticeNodes : Stage::kLattice,
            is_at_nodes ? node_constants : constants,
            {&frame_, &tables_, &box.samples, samples_behind, &kept_.bricks, bricks_behind,
             &bench_.pixels.colors(), &bench_.pixels.depths(), &bench_.pixels.states(), &counts_},
            place, is_at_nodes ? node_groups : groups);
      }
    }
    commands.mark("read back");
    commands.submit_and_wait();
    bench_.pixels.finish(commands, look, band, image);
    add_counts(commands, counts_, std::size_t{groups.x} * groups.y, profile);
    if (hooks.tile_done) hooks.tile_done({0, band.first, options.width, band.end, &image});
    if (hooks.progress)
      hooks.progress(static_cast<double>(band.end) / static_cast<double>(options.height));
  }
}

}  // namespace ovoid::vulkan
