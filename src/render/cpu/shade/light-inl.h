// SPDX-License-Identifier: Apache-2.0
// How much of the light arrives at samples, read from a coarse volume (view/plan/light_volume.h).
// Of the eight cells around a place four of a slice lie side by side; each is both shares in one
// float.
//
// In:  places and gradients of a group of samples. Out: shares of the light around and of the key.
#if defined(OVOID_RENDER_CPU_LIGHT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_LIGHT_INL_H_
#undef OVOID_RENDER_CPU_LIGHT_INL_H_
#else
#define OVOID_RENDER_CPU_LIGHT_INL_H_
#endif

#include "render/cpu/kernels/entries-inl.h"
#include "render/cpu/lattice/differences-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

HWY_INLINE V dot_product(const WorldVector& a, const WorldVector& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

// q of docs/numerics.md. `length`: the gradient's. `clearance`: from cut faces, of any size; null:
// there are none.
HWY_INLINE V flatness_of(const device::LookConstants& look, V length, const V* clearance) {
  const V one = hn::Set(d, 1.0F);
  const V flatness = hn::Min(hn::Mul(length, hn::Set(d, look.flat_gradient_inverse)), one);
  if (clearance == nullptr) return flatness;
  return hn::Mul(flatness, hn::Min(hn::Max(*clearance, hn::Zero(d)), one));
}

// In [0, 1].
struct ArrivingShares {
  V around, key;
};

// The shares at places in cell coordinates.
HWY_INLINE ArrivingShares read_light(const float* cells, const device::ivec4& dims,
                                     const WorldVector& place, bool has_key) {
  const auto split = [](V at, int count, V& fraction) -> V {
    const V inside = hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, static_cast<float>(count - 1)));
    const V whole = hn::Min(hn::Floor(inside), hn::Set(d, static_cast<float>(count - 2)));
    fraction = hn::Sub(inside, whole);
    return whole;
  };
  V fx, fy, fz;
  const VI x = nearest_integer(split(place.x, dims.x, fx));
  const VI y = nearest_integer(split(place.y, dims.y, fy));
  const VI z = nearest_integer(split(place.z, dims.z, fz));
  const VI first =
      hn::Add(x, hn::Mul(hn::Set(di, dims.x), hn::Add(y, hn::Mul(hn::Set(di, dims.y), z))));
  alignas(64) std::int32_t index[16];
  hn::Store(first, di, index);
  const V per_step = hn::Set(d, 1.0F / device::kLightSteps);
  if (!has_key) {
    // All of the key's light arrives, and what is above it is the light around.
    const auto blend = [](V a, V b, V t) { return hn::MulAdd(hn::Sub(b, a), t, a); };
    const auto around_of = [&](int offset) -> V {
      const Classified four = transpose_squares(cells + offset, index, dims.x);
      const auto without_key = [](V packed) {
        return hn::Sub(packed, hn::Set(d, device::kLightSteps * device::kLightRadix));
      };
      return blend(blend(without_key(four.red), without_key(four.green), fx),
                   blend(without_key(four.blue), without_key(four.opacity), fx), fy);
    };
    const V around = blend(around_of(0), around_of(dims.x * dims.y), fz);
    return {hn::Mul(around, per_step), hn::Set(d, 1.0F)};
  }
  const auto split_shares = [](V packed) -> ArrivingShares {
    const V key = hn::Floor(hn::Mul(packed, hn::Set(d, 1.0F / device::kLightRadix)));
    return {hn::NegMulAdd(key, hn::Set(d, device::kLightRadix), packed), key};
  };
  const auto mix = [](const ArrivingShares& a, const ArrivingShares& b, V t) -> ArrivingShares {
    return {hn::MulAdd(hn::Sub(b.around, a.around), t, a.around),
            hn::MulAdd(hn::Sub(b.key, a.key), t, a.key)};
  };
  const auto slice = [&](int offset) -> ArrivingShares {
    const Classified four = transpose_squares(cells + offset, index, dims.x);
    return mix(mix(split_shares(four.red), split_shares(four.green), fx),
               mix(split_shares(four.blue), split_shares(four.opacity), fx), fy);
  };
  const ArrivingShares steps = mix(slice(0), slice(dims.x * dims.y), fz);
  return {hn::Mul(steps.around, per_step), hn::Mul(steps.key, per_step)};
}

// What view::light_shift() says, in cells.
HWY_INLINE WorldVector light_shift(const device::LookConstants& look, const WorldVector& gradient,
                                   const WorldVector& eye, const V* clearance) {
  const V squared = hn::Max(dot_product(gradient, gradient), hn::Set(d, 1e-36F));
  const V inverse = reciprocal_sqrt(squared);
  const V flatness = flatness_of(look, hn::Mul(squared, inverse), clearance);
  const V one = hn::Set(d, 1.0F);
  const V towards_eye = hn::Mul(dot_product(gradient, eye), inverse);
  const V facing = hn::Min(
      hn::Max(hn::Mul(towards_eye, hn::Set(d, device::kLightSteepness)), hn::Neg(one)), one);
  const V share = hn::Mul(facing, flatness);
  const V of_gradient = hn::Mul(share, inverse);
  const V of_eye = hn::Sub(one, hn::Abs(share));
  const auto component = [&](V g, V e) { return hn::MulAdd(g, of_gradient, hn::Mul(e, of_eye)); };
  const WorldVector shift{component(gradient.x, eye.x), component(gradient.y, eye.y),
                          component(gradient.z, eye.z)};
  const auto along = [&](const device::vec4& row) {
    return dot_product(shift, {hn::Set(d, row.x), hn::Set(d, row.y), hn::Set(d, row.z)});
  };
  return {along(look.volume.shift[0]), along(look.volume.shift[1]), along(look.volume.shift[2])};
}

// Cell coordinates of a group's samples, `back` sheets behind sheet s of the block.
HWY_INLINE WorldVector light_place(const CpuFrame& frame, const BlockPlace& place,
                                   const SampleGroup& group, V back) {
  const device::LightConstants& light = frame.look.constants.volume;
  const auto s = static_cast<float>(place.number_of(group.s) - frame.plan->sheets.first);
  const V x = pixel_x(place, group.column);
  const float y = pixel_y(place, group.row);
  const V sheet = hn::Add(hn::Set(d, s), back);
  const auto along = [&](auto component) {
    const V start =
        hn::MulAdd(x, hn::Set(d, component(light.start[1])),
                   hn::Set(d, component(light.start[0]) + y * component(light.start[2])));
    const V step = hn::MulAdd(x, hn::Set(d, component(light.step[1])),
                              hn::Set(d, component(light.step[0]) + y * component(light.step[2])));
    return hn::MulAdd(sheet, step, start);
  };
  return {along([](const device::vec4& v) { return v.x; }),
          along([](const device::vec4& v) { return v.y; }),
          along([](const device::vec4& v) { return v.z; })};
}

// Of what is not lit, and so has no normals.
HWY_INLINE WorldVector no_gradient() { return {hn::Zero(d), hn::Zero(d), hn::Zero(d)}; }

// What arrives at a group's samples, or between sheets; their lanes do not matter.
HWY_INLINE ArrivingShares arriving_between(const CpuFrame& frame, const BlockPlace& place,
                                           const SampleGroup& group, V back,
                                           const WorldVector& gradient, const WorldVector& eye,
                                           const V* clearance) {
  const WorldVector at = light_place(frame, place, group, back);
  const WorldVector shift = light_shift(frame.look.constants, gradient, eye, clearance);
  return read_light(frame.light, frame.look.constants.volume.dims,
                    {hn::Add(at.x, shift.x), hn::Add(at.y, shift.y), hn::Add(at.z, shift.z)},
                    frame.has_key_light);
}

HWY_INLINE ArrivingShares arriving_at_sample(const CpuFrame& frame, const BlockPlace& place,
                                             const SampleGroup& group, const WorldVector& gradient,
                                             const WorldVector& eye, const V* clearance) {
  return arriving_between(frame, place, group, hn::Zero(d), gradient, eye, clearance);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
