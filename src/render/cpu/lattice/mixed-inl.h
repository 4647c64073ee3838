// SPDX-License-Identifier: Apache-2.0
// Stages "shade" and "composite" of several volumes on the same sheets: what they show at a place
// is mixed (docs/numerics.md, "Several volumes").
//
// In:  the values of all layers on a sheet, and of pieces on the one before it.
// Out: the tile's state.
//
// Each layer classifies and lights in its own way, with its own tables, and has a batch of its own
// for the samples of its pieces. Where several layers show something in a pixel's piece, all of
// them cut it into the same number of steps; a run of steps of the one then stands beside a run of
// each other, and is mixed with it before it joins the pixel. Where one layer shows alone, as in
// most of a picture, its samples join the pixels as those of a frame without others do.
#if defined(OVOID_RENDER_CPU_MIXED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_MIXED_INL_H_
#undef OVOID_RENDER_CPU_MIXED_INL_H_
#else
#define OVOID_RENDER_CPU_MIXED_INL_H_
#endif

#include "render/cpu/lattice/gradient-inl.h"
#include "render/cpu/lattice/lattice_pieces-inl.h"
#include "render/cpu/lattice/nodes.h"
#include "render/cpu/shade/finish-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

enum class PartState { kNothing, kTooLarge, kReady };

// One field of a frame and what is known of it in the block in hand.
struct Layer {
  const LatticeFrame* frame = nullptr;
  Workspace* work = nullptr;
  PartState state = PartState::kNothing;
  int next = 0;  // sheet of its block

  bool is_ready() const noexcept { return state == PartState::kReady; }
};

// The frame's own field first.
struct Layers {
  std::array<Layer, kMostLayers> all{};
  std::size_t count = 0;

  Layer* begin() noexcept { return all.data(); }
  Layer* end() noexcept { return all.data() + count; }
  const Layer& operator[](std::size_t i) const noexcept { return all[i]; }
};

inline Layers layers_of(const LatticeFrame& frame, LatticeWorkspace& work) {
  Layers layers;
  layers.all[layers.count++] = {&frame, &work.pixels};
  for (std::size_t i = 0; i < frame.beside.size(); ++i)
    layers.all[layers.count++] = {frame.beside[i], work.beside[i].get()};
  return layers;
}

// Lanes or rows of each layer.
using LayerLanes = std::array<std::uint32_t, kMostLayers>;
using LayerBits = std::array<RowBits, kMostLayers>;

// e^-12: what lets less light through is mixed as if it were this.
inline constexpr float kLeastThroughMixed = 6.1442124e-6F;

// The sum of what layers show in a group's samples.
struct MixedGroup {
  HWY_INLINE explicit MixedGroup(Mixing by)
      : mixing(by),
        through(hn::Set(d, 1.0F)),
        weight(hn::Zero(d)),
        own_color{hn::Zero(d), hn::Zero(d), hn::Zero(d)},
        sum{hn::Zero(d), hn::Zero(d), hn::Zero(d)} {}

  // `layer`: 0 is the frame's own. `opacity`: 0 where the layer shows nothing.
  HWY_INLINE void add(std::size_t layer, const GroupColor& color, V opacity) {
    const V one = hn::Set(d, 1.0F);
    const V layer_through = hn::Sub(one, opacity);
    if (mixing == Mixing::kColored) {
      if (layer > 0) return add_colors(one, color);
      through = layer_through;
      own_color = color;
      return;
    }
    const V share = hn::Neg(vector_log2(hn::Max(layer_through, hn::Set(d, kLeastThroughMixed))));
    const bool is_added = mixing == Mixing::kAdded;
    through = is_added ? hn::Min(through, layer_through) : hn::Mul(through, layer_through);
    weight = is_added ? hn::Max(weight, share) : hn::Add(weight, share);
    add_colors(share, color);
  }
  HWY_INLINE V opacity() const { return hn::Sub(hn::Set(d, 1.0F), through); }
  HWY_INLINE GroupColor color() const {
    const V one = hn::Set(d, 1.0F);
    if (mixing == Mixing::kColored) {
      return {hn::Mul(hn::Min(sum.red, one), own_color.red),
              hn::Mul(hn::Min(sum.green, one), own_color.green),
              hn::Mul(hn::Min(sum.blue, one), own_color.blue)};
    }
    const M is_something = hn::Gt(weight, hn::Zero(d));
    const V inverse =
        hn::IfThenElseZero(is_something, hn::Div(one, hn::IfThenElse(is_something, weight, one)));
    return {hn::Min(hn::Mul(sum.red, inverse), one), hn::Min(hn::Mul(sum.green, inverse), one),
            hn::Min(hn::Mul(sum.blue, inverse), one)};
  }

  Mixing mixing;
  V through, weight;
  GroupColor own_color, sum;

 private:
  HWY_INLINE void add_colors(V share, const GroupColor& color) {
    sum.red = hn::MulAdd(share, color.red, sum.red);
    sum.green = hn::MulAdd(share, color.green, sum.green);
    sum.blue = hn::MulAdd(share, color.blue, sum.blue);
  }
};

// Whether one layer that shows something alone is drawn as it is: not one that only has colours.
inline bool may_be_alone(const LatticeFrame& frame) {
  return !frame.is_mixed || frame.mixing != Mixing::kColored;
}

// --- samples on a sheet

// What the layers show on a sheet becomes one shaded sheet.
inline void mix_sheets(const Layers& layers, int rows, ShadedSheet& mixed) {
  const BlockPlace& place = layers[0].work->block.place;
  for (int y = 0; y < rows; ++y) {
    RowWord any = 0;
    for (std::size_t i = 0; i < layers.count; ++i)
      any |= layers[i].is_ready() ? layers[i].work->shaded.visible[y] : 0;
    mixed.visible[y] = any;
    for_each_group(any, place.margin, place.columns - place.margin, [&](int column, std::uint32_t) {
      const int at = y * kTilePlane.stride + column;
      MixedGroup sum(layers[0].frame->mixing);
      for (std::size_t i = 0; i < layers.count; ++i) {
        if (!layers[i].is_ready()) continue;
        const ShadedSheet& own = layers[i].work->shaded;
        const std::uint32_t lanes = lanes_at(own.visible[y], column);
        if (lanes == 0) continue;
        const auto load = [&](const float* from) {
          return hn::IfThenElseZero(mask_of(lanes), hn::LoadU(d, from + at));
        };
        sum.add(i, {load(own.red), load(own.green), load(own.blue)}, load(own.alpha));
      }
      const GroupColor color = sum.color();
      hn::StoreU(sum.opacity(), d, mixed.alpha + at);
      hn::StoreU(color.red, d, mixed.red + at);
      hn::StoreU(color.green, d, mixed.green + at);
      hn::StoreU(color.blue, d, mixed.blue + at);
    });
  }
}

// The samples of sheet s, those named by `bits` of each layer.
inline void finish_mixed_samples(const LatticeFrame& frame, Layers& layers, MixedSamples& mixed,
                                 int s, const LayerBits& bits, StageClock& clock) {
  Layer* visible = nullptr;
  int num_visible = 0;
  for (std::size_t i = 0; i < layers.count; ++i) {
    Layer& layer = layers.all[i];
    layer.work->shaded.visible = {};
    if (!layer.is_ready()) continue;
    const bool is_visible = shade_samples(*layer.frame, layer.work->in_hand(), s, bits[i], clock,
                                          [&] { gradient_of_sheet(*layer.frame, *layer.work, s); });
    if (!is_visible) continue;
    visible = &layer;
    ++num_visible;
  }
  if (num_visible == 0) return;
  const TileInHand tile = layers[0].work->in_hand();
  const ShadedSheet* shaded = &visible->work->shaded;
  if (num_visible > 1 || !may_be_alone(frame)) {
    mix_sheets(layers, tile.place.rows, mixed.shaded);
    shaded = &mixed.shaded;
  }
  composite_sheet(frame, tile.place, s, *shaded, tile.pixels);
  clock.lap(kComposite);
}

// --- pieces between sheets

// Layers' runs that stand beside each other: numbers of runs in their batches.
inline void note_runs(const Layers& layers, const LayerLanes& lanes, int most,
                      const std::array<int, kMostLayers>& first, MixedSamples& mixed) {
  const auto add = [&](const auto& run_of) {
    MixedSamples::Run& run = mixed.runs[static_cast<std::size_t>(mixed.num_runs++)];
    for (std::size_t i = 0; i < kMostLayers; ++i) run[i] = i < layers.count ? run_of(i) : -1;
  };
  if (most > 0) {
    for (int m = 0; m < most; ++m)
      add([&](std::size_t i) { return lanes[i] != 0 ? first[i] + m : -1; });
    return;
  }
  std::array<int, kMostLayers> next = first;
  std::uint32_t all = 0;
  for (const std::uint32_t own : lanes) all |= own;
  for (; all != 0; all &= all - 1) {
    const std::uint32_t lane = all & (~all + 1);
    add([&](std::size_t i) { return (lanes[i] & lane) != 0 ? next[i]++ : -1; });
  }
}

// Mixes runs into the batch of what is mixed, from its first sample on; returns them as one.
inline SampleBatch::Run mix_runs(const Layers& layers, const MixedSamples::Run& runs,
                                 SampleBatch& mixed) {
  SampleBatch::Run out{};
  for (std::size_t i = 0; i < layers.count; ++i) {
    if (runs[i] < 0) continue;
    const SampleBatch::Run& run = layers[i].work->batch.runs[static_cast<std::size_t>(runs[i])];
    out = {run.pixel, 0, run.count, out.lanes | run.lanes};
  }
  const int samples = out.count == 0 ? group_size() : out.count;
  for (int first = 0; first < samples; first += group_size()) {
    MixedGroup sum(layers[0].frame->mixing);
    V depth = hn::Zero(d);
    M has_depth = hn::FirstN(d, 0);
    for (std::size_t i = layers.count; i-- > 0;) {
      if (runs[i] < 0) continue;
      const SampleBatch& batch = layers[i].work->batch;
      const SampleBatch::Run& run = batch.runs[static_cast<std::size_t>(runs[i])];
      const M exists =
          run.count == 0
              ? mask_of(run.lanes)
              : hn::FirstN(d, static_cast<std::size_t>(std::min(run.count - first, group_size())));
      const auto load = [&](const SampleBatch::Floats& floats) {
        return hn::LoadU(
            d, &floats[static_cast<std::size_t>(run.first) + static_cast<std::size_t>(first)]);
      };
      const auto load_or_0 = [&](const SampleBatch::Floats& floats) {
        return hn::IfThenElseZero(exists, load(floats));
      };
      const V opacity = hn::Max(load_or_0(batch.opacity), hn::Zero(d));
      sum.add(i, {load_or_0(batch.red), load_or_0(batch.green), load_or_0(batch.blue)}, opacity);
      // The first layer's that shows something, or of any that is there.
      const M shows =
          hn::Or(hn::And(exists, hn::Gt(opacity, hn::Zero(d))), hn::AndNot(has_depth, exists));
      depth = hn::IfThenElse(shows, load(batch.depth), depth);
      has_depth = hn::Or(has_depth, shows);
    }
    const GroupColor color = sum.color();
    hn::StoreU(color.red, d, &mixed.red[static_cast<std::size_t>(first)]);
    hn::StoreU(color.green, d, &mixed.green[static_cast<std::size_t>(first)]);
    hn::StoreU(color.blue, d, &mixed.blue[static_cast<std::size_t>(first)]);
    hn::StoreU(sum.opacity(), d, &mixed.opacity[static_cast<std::size_t>(first)]);
    hn::StoreU(depth, d, &mixed.depth[static_cast<std::size_t>(first)]);
  }
  return out;
}

// Draws the samples of all batches, and empties them.
inline void flush_mixed(Layers& layers, MixedSamples& mixed) {
  for (const Layer& layer : layers) {
    if (layer.is_ready()) shade_batch(*layer.frame, layer.work->batch);
  }
  for (int r = 0; r < mixed.num_runs; ++r) {
    const MixedSamples::Run& runs = mixed.runs[static_cast<std::size_t>(r)];
    const Layer* alone = nullptr;
    int num_layers = 0;
    std::size_t own = 0;
    for (std::size_t i = 0; i < layers.count; ++i) {
      if (runs[i] < 0) continue;
      alone = &layers[i];
      own = i;
      ++num_layers;
    }
    const auto composite = [](const LatticeFrame& frame, const TileInHand& tile,
                              const SampleBatch::Run& run) {
      run.count == 0 ? composite_step(frame, tile, run) : composite_piece(frame, tile, run);
    };
    if (num_layers == 1 && may_be_alone(*layers[0].frame)) {
      composite(*alone->frame, alone->work->in_hand(),
                alone->work->batch.runs[static_cast<std::size_t>(runs[own])]);
      continue;
    }
    Workspace& work = *layers[0].work;
    const SampleBatch::Run run = mix_runs(layers, runs, mixed.batch);
    composite(*layers[0].frame,
              {work.block.place, work.ring, *work.tile, work.shaded, mixed.batch, work.stats}, run);
  }
  for (const Layer& layer : layers) layer.work->batch.num_samples = layer.work->batch.num_runs = 0;
  mixed.num_runs = 0;
}

// Samples of a group's pieces join the batches. `lanes`: of each layer, those that may show.
HWY_INLINE void add_mixed_pieces(Layers& layers, MixedSamples& mixed, const SampleGroup& at,
                                 LayerLanes lanes) {
  for (const Layer& layer : layers) {
    if (layer.work->batch.has_room()) continue;
    flush_mixed(layers, mixed);
    break;
  }
  PieceGroup groups[kMostLayers];
  PieceSteps steps[kMostLayers];
  const V one = hn::Set(d, 1.0F);
  V count = one;
  std::uint32_t with_more = 0;
  for (std::size_t i = 0; i < layers.count; ++i) {
    if (lanes[i] == 0) continue;
    const Layer& layer = layers[i];
    groups[i] = pieces_of(*layer.frame, layer.work->in_hand(), {at.s, at.column, at.row, lanes[i]});
    const std::uint32_t own = groups[i].take_more_steps();
    if (own == 0) continue;
    with_more |= own;
    count = hn::Max(count, hn::IfThenElse(mask_of(own), steps_for(groups[i].need()), one));
  }
  std::uint32_t any = 0;
  for (std::size_t i = 0; i < layers.count; ++i) {
    if (lanes[i] == 0) continue;
    const Layer& layer = layers[i];
    const Block& block = layer.work->block;
    steps[i] =
        steps_of(*layer.frame, block.place, groups[i], count, LatticePieces{*layer.frame, block});
    lanes[i] = groups[i].at.lanes;
    any |= lanes[i];
  }
  if (any == 0) return;
  const int most = steps_of_pixels(count, any, with_more & any);
  std::array<int, kMostLayers> first{};
  for (std::size_t i = 0; i < layers.count; ++i) {
    if (lanes[i] == 0) continue;
    const Layer& layer = layers[i];
    first[i] = layer.work->batch.num_runs;
    if (most > 0) {
      add_steps(*layer.frame, layer.work->in_hand(), groups[i], steps[i], most);
    } else {
      add_pieces_alone(*layer.frame, layer.work->in_hand(), groups[i], steps[i]);
    }
  }
  note_runs(layers, lanes, most, first, mixed);
}

// The pieces that end on sheet s, those named by `bits` of each layer, within the spans in hand.
inline void finish_mixed_pieces_in_hand(Layers& layers, MixedSamples& mixed, int s,
                                        const LayerBits& bits, StageClock& clock) {
  Layer* visible = nullptr;
  int num_visible = 0;
  for (std::size_t i = 0; i < layers.count; ++i) {
    Layer& layer = layers.all[i];
    layer.work->shaded.visible = {};
    if (!layer.is_ready()) continue;
    const TileInHand tile = layer.work->in_hand();
    classify_pieces(*layer.frame, tile.place, tile.ring, s,
                    with_an_end(tile.place, tile.ring, s, bits[i]), tile.shaded);
    if (count_bits(tile.shaded.visible, tile.place.rows) == 0) continue;
    visible = &layer;
    ++num_visible;
    clock.lap(kShade);
    if (layer.frame->takes_gradients) {
      gradients_of_ends(*layer.frame, *layer.work, s);
      clock.lap(kGradient);
    }
  }
  if (num_visible == 0) return;
  if (num_visible == 1 && may_be_alone(*layers[0].frame)) {
    draw_pieces(*visible->frame, visible->work->in_hand(), s,
                LatticePieces{*visible->frame, visible->work->block});
    clock.lap(kShade);
    return;
  }
  const TileInHand tile = layers[0].work->in_hand();
  const BlockPlace& place = tile.place;
  for (int y = place.margin; y < place.rows - place.margin; ++y) {
    RowWord any = 0;
    for (const Layer& layer : layers) any |= layer.is_ready() ? layer.work->shaded.visible[y] : 0;
    if (any == 0) continue;
    const RowWord open = tile.pixels.open[tile_row(place, y)];
    for_each_group(any & open >> place.x0 << place.margin, place.margin,
                   place.columns - place.margin, [&](int column, std::uint32_t all) {
                     LayerLanes lanes{};
                     for (std::size_t i = 0; i < layers.count; ++i) {
                       if (layers[i].is_ready())
                         lanes[i] = lanes_at(layers[i].work->shaded.visible[y], column) & all;
                     }
                     add_mixed_pieces(layers, mixed, {s, column, y, all}, lanes);
                   });
  }
  flush_mixed(layers, mixed);
  clock.lap(kShade);
}

// The same, whatever depth limits there are: one span of a piece after the other.
inline void finish_mixed_pieces(const LatticeFrame& frame, Layers& layers, MixedSamples& mixed,
                                int s, const RowBits& any, const LayerBits& bits,
                                StageClock& clock) {
  const TileInHand tile = layers[0].work->in_hand();
  const BlockPlace& place = tile.place;
  if (place.limits == nullptr) return finish_mixed_pieces_in_hand(layers, mixed, s, bits, clock);
  const float far = place.sheets[s].depth;
  const float near = far - frame.camera.sampling_distance;
  leave_spans(frame, place, any, near, tile.pixels);
  RowBits left = within_spans(frame, place, any, near, far, tile.pixels);
  while (count_bits(left, place.rows) > 0) {
    LayerBits own{};
    for (std::size_t i = 0; i < layers.count; ++i) {
      for (int y = 0; y < place.rows; ++y) own[i][y] = bits[i][y] & left[y];
    }
    finish_mixed_pieces_in_hand(layers, mixed, s, own, clock);
    left = at_next_spans(frame, place, left, far, tile.pixels);
    left = within_spans(frame, place, left, near, far, tile.pixels);
  }
}

// Classifies, lights, mixes and composites what the layers have on sheet s of their blocks, or
// between it and the one before it; their values, and neighbours' if differences are taken, are
// there.
inline void finish_mixed_sheet(const LatticeFrame& frame, Layers& layers, MixedSamples& mixed,
                               int s, StageClock& clock) {
  const TileInHand tile = layers[0].work->in_hand();
  const BlockPlace& place = tile.place;
  LayerBits bits{};
  RowBits any{};
  RowWord is_any = 0;
  for (std::size_t i = 0; i < layers.count; ++i) {
    if (!layers[i].is_ready()) continue;
    const Workspace& work = *layers[i].work;
    const RowBits& defined = work.ring[place.number_of(s)].defined;
    for (int y = 0; y < place.rows; ++y) {
      bits[i][y] = work.block.bits.relevant[s][y] & open_samples(frame, place, tile.pixels, y);
      if (!frame.is_refined) bits[i][y] &= defined[y];
      if (i > 0 && !may_be_alone(frame)) bits[i][y] &= bits[0][y];
      any[y] |= bits[i][y];
      is_any |= bits[i][y];
    }
  }
  for (const Layer& layer : layers) layer.work->shaded.visible = {};
  if (is_any != 0 && frame.is_refined) {
    finish_mixed_pieces(frame, layers, mixed, s, any, bits, clock);
  } else if (is_any != 0) {
    if (place.limits != nullptr) {
      const RowBits with_path = with_path_within(frame, place, s, any, tile.pixels);
      for (RowBits& own : bits) {
        for (int y = 0; y < place.rows; ++y) own[y] &= with_path[y];
      }
    }
    finish_mixed_samples(frame, layers, mixed, s, bits, clock);
  }
  for (const Layer& layer : layers) layer.work->was_visible = layer.work->shaded.visible;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
