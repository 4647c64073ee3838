// SPDX-License-Identifier: Apache-2.0
// Classifies and lights a batch of samples.
//
// In:  values, gradients and paths of the samples.
// Out: their colours and opacities.
#if defined(OVOID_RENDER_CPU_SAMPLE_BATCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_SAMPLE_BATCH_INL_H_
#undef OVOID_RENDER_CPU_SAMPLE_BATCH_INL_H_
#else
#define OVOID_RENDER_CPU_SAMPLE_BATCH_INL_H_
#endif

#include "render/cpu/shade/sample_batch.h"
#include "render/cpu/shade/segments-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

template <class Body>
HWY_INLINE void for_each_batch_group(const SampleBatch& batch, const Body& body) {
  for (int i = 0; i < batch.num_samples; i += group_size()) body(i);
}

inline void classify_batch(const CpuFrame& frame, SampleBatch& batch) {
  for_each_batch_group(batch, [&](int i) {
    const Classified seen = classify(frame.look.table, hn::Load(d, &batch.value[i]));
    hn::Store(seen.opacity, d, &batch.opacity[i]);
    hn::Store(seen.red, d, &batch.red[i]);
    hn::Store(seen.green, d, &batch.green[i]);
    hn::Store(seen.blue, d, &batch.blue[i]);
  });
}

// By another attribute.
inline void color_batch(const CpuFrame& frame, SampleBatch& batch) {
  for_each_batch_group(batch, [&](int i) {
    const Classified color = classify(frame.look.color, hn::Load(d, &batch.color_value[i]));
    hn::Store(color.red, d, &batch.red[i]);
    hn::Store(color.green, d, &batch.green[i]);
    hn::Store(color.blue, d, &batch.blue[i]);
  });
}

HWY_INLINE WorldVector load_vector(const std::array<SampleBatch::Floats, 3>& vectors, int i) {
  return {hn::Load(d, &vectors[0][i]), hn::Load(d, &vectors[1][i]), hn::Load(d, &vectors[2][i])};
}

inline void fade_batch(const CpuFrame& frame, SampleBatch& batch) {
  for_each_batch_group(batch, [&](int i) {
    const WorldVector gradient = load_vector(batch.gradient, i);
    const V length = hn::Sqrt(dot_product(gradient, gradient));
    const V share = classify(frame.look.fading, length).opacity;
    hn::Store(hn::Mul(hn::Load(d, &batch.opacity[i]), share), d, &batch.opacity[i]);
  });
}

inline void classify_batch_in_plane(const CpuFrame& frame, SampleBatch& batch) {
  for_each_batch_group(batch, [&](int i) {
    const WorldVector gradient = load_vector(batch.gradient, i);
    const Classified seen = classify_in_plane(frame.look.plane, hn::Load(d, &batch.value[i]),
                                              hn::Sqrt(dot_product(gradient, gradient)));
    hn::Store(seen.opacity, d, &batch.opacity[i]);
    hn::Store(seen.red, d, &batch.red[i]);
    hn::Store(seen.green, d, &batch.green[i]);
    hn::Store(seen.blue, d, &batch.blue[i]);
  });
}

// How a sample of the batch is lit, or dimmed. The frame takes light.
HWY_INLINE Lighting lighting_of(const CpuFrame& frame, const SampleBatch& batch, int i,
                                const WorldVector& axis) {
  ArrivingShares arriving{hn::Set(d, 1.0F), hn::Set(d, 1.0F)};
  if (frame.light != nullptr) arriving.around = hn::Load(d, &batch.around[i]);
  if (frame.has_key_light) arriving.key = hn::Load(d, &batch.key[i]);
  if (!frame.is_lit) return dim_sample(arriving);
  const WorldVector eye = frame.is_parallel ? axis : load_vector(batch.eye, i);
  const WorldVector gradient = load_vector(batch.gradient, i);
  V distance;
  if (frame.fades_at_cuts) distance = hn::Load(d, &batch.clearance[i]);
  const V* const clearance = frame.fades_at_cuts ? &distance : nullptr;
  if (frame.light == nullptr)
    return light_sample(frame.look.constants, gradient, eye, nullptr, clearance);
  return light_sample(frame.look.constants, gradient, eye, &arriving, clearance);
}

inline void light_batch(const CpuFrame& frame, SampleBatch& batch) {
  const WorldVector axis{hn::Set(d, -frame.camera.axis[0]), hn::Set(d, -frame.camera.axis[1]),
                         hn::Set(d, -frame.camera.axis[2])};
  for_each_batch_group(batch, [&](int i) {
    const Lighting light = lighting_of(frame, batch, i, axis);
    for (float* color : {&batch.red[i], &batch.green[i], &batch.blue[i]})
      hn::Store(lit_color(hn::Load(d, color), light), d, color);
  });
}

inline void correct_batch(SampleBatch& batch) {
  for_each_batch_group(batch, [&](int i) {
    const V opacity = hn::Load(d, &batch.opacity[i]);
    hn::Store(correct_opacity(opacity, hn::Load(d, &batch.path[i])), d, &batch.opacity[i]);
  });
}

// The same at once, where the look is a few segments and nothing else decides.
template <bool kTakesLight>
inline void shade_batch_in_segments(const CpuFrame& frame, SampleBatch& batch) {
  const WorldVector axis{hn::Set(d, -frame.camera.axis[0]), hn::Set(d, -frame.camera.axis[1]),
                         hn::Set(d, -frame.camera.axis[2])};
  const FrameLook& look = frame.look;
  for_each_batch_group(batch, [&](int i) {
    Classified seen = classify_in_segments(look.color_segments, look.table.constants,
                                           hn::Load(d, &batch.value[i]));
    if constexpr (kTakesLight) {
      const Lighting light = lighting_of(frame, batch, i, axis);
      seen.red = lit_color(seen.red, light);
      seen.green = lit_color(seen.green, light);
      seen.blue = lit_color(seen.blue, light);
    }
    hn::Store(seen.red, d, &batch.red[i]);
    hn::Store(seen.green, d, &batch.green[i]);
    hn::Store(seen.blue, d, &batch.blue[i]);
    const V path = hn::Load(d, &batch.path[i]);
    const V opacity = look.color_segments.has_logarithms ? opacity_of_logarithm(seen.opacity, path)
                                                         : correct_opacity(seen.opacity, path);
    hn::Store(opacity, d, &batch.opacity[i]);
  });
}

inline void shade_batch(const CpuFrame& frame, SampleBatch& batch) {
  if (are_usable(frame.look.color_segments) && !frame.has_own_color && !frame.fades_by_gradient) {
    return frame.takes_light() ? shade_batch_in_segments<true>(frame, batch)
                               : shade_batch_in_segments<false>(frame, batch);
  }
  if (frame.look.plane.entries != nullptr) {
    classify_batch_in_plane(frame, batch);
  } else {
    classify_batch(frame, batch);
    if (frame.has_own_color) color_batch(frame, batch);
    if (frame.fades_by_gradient) fade_batch(frame, batch);
  }
  if (frame.takes_light()) light_batch(frame, batch);
  correct_batch(batch);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
