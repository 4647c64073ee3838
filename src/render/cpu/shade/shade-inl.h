// SPDX-License-Identifier: Apache-2.0
// Stage "shade": reconstructed samples become colour and opacity. Classification comes first and
// alone decides which samples are visible; only those get a gradient and light.
//
// In:  one sheet's values, the classification table; for light: the gradients.
// Out: visible bits, sample opacity (corrected for its path) and colour.
#if defined(OVOID_RENDER_CPU_SHADE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_SHADE_INL_H_
#undef OVOID_RENDER_CPU_SHADE_INL_H_
#else
#define OVOID_RENDER_CPU_SHADE_INL_H_
#endif

#include "render/cpu/kernels/entries-inl.h"
#include "render/cpu/lattice/differences-inl.h"
#include "render/cpu/shade/light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// LookAxis::place().
HWY_INLINE V place_of(const device::TableConstants& axis, V value) {
  V steps;
  if (axis.scale == device::kScaleLinear) {
    steps = hn::Sub(value, hn::Set(d, axis.origin));
  } else if (axis.scale == device::kScaleLog) {
    const VI bits = hn::BitCast(di, hn::Max(value, hn::Set(d, view::LookAxis::kLeast)));
    steps = hn::ConvertTo(d, hn::Sub(bits, hn::Set(di, axis.origin_bits)));
  } else {
    const V one = hn::Set(d, 1.0F);
    const V scaled = hn::Mul(hn::Abs(value), hn::Set(d, axis.inverse_width));
    const VI magnitude = hn::Sub(hn::BitCast(di, hn::Add(one, scaled)), hn::BitCast(di, one));
    const auto is_negative = hn::RebindMask(di, hn::Lt(value, hn::Zero(d)));
    const VI bits = hn::IfThenElse(is_negative, hn::Neg(magnitude), magnitude);
    steps = hn::ConvertTo(d, hn::Sub(bits, hn::Set(di, axis.origin_bits)));
  }
  return hn::Mul(steps, hn::Set(d, axis.cells_per_step));
}

inline constexpr auto kLastEntry = static_cast<float>(device::kTableCells);

// Where a value lies in a table.
struct TableCell {
  VI entry;
  V fraction;
};

HWY_INLINE TableCell cell_of(const ClassificationTable& table, V value) {
  const V at = place_of(table.constants, value);
  // The order of operands makes NaN, of lanes that nobody asked for, an entry too.
  const V clamped = hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, kLastEntry));
  const V entry = hn::Floor(clamped);
  V fraction = hn::Sub(clamped, entry);
  const VI integers = nearest_integer(entry);
  if (table.steps != nullptr) {
    const V step = hn::GatherIndex(d, table.steps, integers);
    const V side = hn::IfThenElseZero(hn::Ge(fraction, step), hn::Set(d, 1.0F));
    fraction = hn::IfThenElse(hn::Lt(step, hn::Zero(d)), fraction, side);
  }
  return {integers, fraction};
}

// Opacity of a value, and how much the look varies up to it.
struct VariationAt {
  V opacity, variation;
};

HWY_INLINE VariationAt variation_at(const FrameLook& look, V value) {
  const TableCell cell = cell_of(look.table, value);
  alignas(64) std::int32_t index[16];
  hn::Store(cell.entry, di, index);
  const Classified ends = transpose_entries(&look.cells.front().x, index);
  const auto mix = [&](V a, V b) { return hn::MulAdd(hn::Sub(b, a), cell.fraction, a); };
  return {mix(ends.blue, ends.opacity), mix(ends.red, ends.green)};
}

// An entry is four floats, so a lane's two entries are two loads; hardware gathers of eight
// separate columns take longer.
HWY_INLINE Classified classify(const ClassificationTable& table, V value) {
  const TableCell cell = cell_of(table, value);
  alignas(64) std::int32_t index[16];
  hn::Store(cell.entry, di, index);
  const Classified lo = transpose_entries(table.entries, index);
  const Classified hi = transpose_entries(table.entries + 4, index);
  const auto mix = [&](V a, V b) { return hn::MulAdd(hn::Sub(b, a), cell.fraction, a); };
  return {mix(lo.red, hi.red), mix(lo.green, hi.green), mix(lo.blue, hi.blue),
          mix(lo.opacity, hi.opacity)};
}

// Which two entries of `count`, of a line or a column, a place lies between. The order of operands
// makes NaN an entry, too.
HWY_INLINE TableCell cell_along(V place, int count) {
  const V clamped = hn::Min(hn::Max(place, hn::Zero(d)), hn::Set(d, static_cast<float>(count - 1)));
  const V entry = hn::Min(hn::Floor(clamped), hn::Set(d, static_cast<float>(count - 2)));
  return {nearest_integer(entry), hn::Sub(clamped, entry)};
}

// In rows of the plane, not clamped.
HWY_INLINE V row_of(const ClassificationPlane& plane, V gradient) {
  return hn::Mul(hn::Sub(gradient, hn::Set(d, plane.first_gradient)),
                 hn::Set(d, plane.rows_per_gradient));
}

// TransferFunction2D::at(), `gradient` in the frame's unit.
HWY_INLINE Classified classify_in_plane(const ClassificationPlane& plane, V value, V gradient) {
  const V column =
      hn::Mul(hn::Sub(value, hn::Set(d, plane.first_value)), hn::Set(d, plane.columns_per_value));
  const TableCell v = cell_along(column, plane.columns);
  const TableCell g = cell_along(row_of(plane, gradient), plane.rows);
  alignas(64) std::int32_t index[16];
  hn::Store(hn::Add(hn::Mul(g.entry, hn::Set(di, plane.columns)), v.entry), di, index);
  const float* const next_row =
      plane.entries + std::size_t{4} * static_cast<std::size_t>(plane.columns);
  const Classified a = transpose_entries(plane.entries, index);
  const Classified b = transpose_entries(plane.entries + 4, index);
  const Classified c = transpose_entries(next_row, index);
  const Classified e = transpose_entries(next_row + 4, index);
  const auto mix = [&](V p, V q, V r, V s) {
    const V lower = hn::MulAdd(hn::Sub(q, p), v.fraction, p);
    const V upper = hn::MulAdd(hn::Sub(s, r), v.fraction, r);
    return hn::MulAdd(hn::Sub(upper, lower), g.fraction, lower);
  };
  return {mix(a.red, b.red, c.red, e.red), mix(a.green, b.green, c.green, e.green),
          mix(a.blue, b.blue, c.blue, e.blue), mix(a.opacity, b.opacity, c.opacity, e.opacity)};
}

// How much the plane varies up to a gradient.
HWY_INLINE V plane_variation(const ClassificationPlane& plane, V gradient) {
  const TableCell cell = cell_along(row_of(plane, gradient), plane.rows);
  const V lo = hn::GatherIndex(d, plane.variation.data(), cell.entry);
  const V hi = hn::GatherIndex(d, plane.variation.data() + 1, cell.entry);
  return hn::MulAdd(hn::Sub(hi, lo), cell.fraction, lo);
}

// x^power for x in [0, 1].
HWY_INLINE V vector_power(V x, float power) {
  const V log = vector_log2(hn::Max(x, hn::Set(d, 1e-30F)));
  return vector_exp2(d, hn::Max(hn::Mul(log, hn::Set(d, power)), hn::Set(d, -126.0F)));
}

// The same for power 0, 1, 2, ...
HWY_INLINE V whole_power(V x, unsigned power) {
  V result = hn::Set(d, 1.0F);
  for (;; x = hn::Mul(x, x)) {
    if ((power & 1U) != 0) result = hn::Mul(result, x);
    if ((power >>= 1U) == 0) return result;
  }
}

// Powers up to this are worked out by multiplication where they are whole numbers.
inline constexpr float kMostWholePower = 256;

HWY_INLINE V shine_of(V cosine, float power) {
  const bool is_whole = power <= kMostWholePower && power == std::floor(power);
  return is_whole ? whole_power(cosine, static_cast<unsigned>(power)) : vector_power(cosine, power);
}

// 1 - 2^(log exponent), log <= 0.
HWY_INLINE V opacity_of_logarithm(V log, V exponent) {
  const V through = vector_exp2(d, hn::Max(hn::Mul(log, exponent), hn::Set(d, -126.0F)));
  return hn::Sub(hn::Set(d, 1.0F), through);
}

// 1 - (1 - a)^exponent, the opacity of a path that is `exponent` sampling distances long.
HWY_INLINE V correct_opacity(V a, V exponent) {
  const V log = vector_log2(hn::Max(hn::Sub(hn::Set(d, 1.0F), a), hn::Set(d, 1e-30F)));
  // An opaque sample stays opaque however short its path, if it has one.
  return hn::IfThenElse(hn::Ge(a, hn::Set(d, 1.0F)), a, opacity_of_logarithm(log, exponent));
}

// What a segment of straight values between `from` and `to` shows: the mean of what is integrated.
HWY_INLINE Classified classify_segment(const FrameLook& tables, V from, V to) {
  const device::LookConstants& look = tables.constants;
  const float* const entries = tables.integrals;
  alignas(64) std::int32_t index[16];
  const V lo = hn::Set(d, look.integral_lo);
  const V hi = hn::Set(d, look.integral_hi);
  struct Integrals {
    Classified high, low;
  };
  const auto integrals_to = [&](V value) -> Integrals {
    const V inside = hn::Min(hn::Max(value, lo), hi);
    const V place =
        hn::Min(hn::Max(place_of(look.look, inside), hn::Zero(d)), hn::Set(d, kLastEntry));
    const V entry = hn::Floor(place);
    const V fraction = hn::Sub(place, entry);
    hn::Store(hn::ShiftLeft<1>(nearest_integer(entry)), di, index);
    const Classified a = transpose_entries(entries, index);
    const Classified b = transpose_entries(entries + 8, index);
    const Classified a_low = transpose_entries(entries + 4, index);
    const Classified b_low = transpose_entries(entries + 12, index);
    const V excess = hn::Mul(hn::Sub(value, inside), hn::Set(d, look.integral_per_value));
    const M is_before = hn::Lt(excess, hn::Zero(d));
    const auto low = [&](V p, V q, V p_low, V q_low, float before, float behind) {
      const V end = hn::IfThenElse(is_before, hn::Set(d, before), hn::Set(d, behind));
      const V step = hn::Add(hn::Sub(q, p), hn::Sub(q_low, p_low));
      return hn::MulAdd(step, fraction, hn::MulAdd(end, excess, p_low));
    };
    const device::vec4& before = look.integrals_before;
    const device::vec4& behind = look.integrals_behind;
    return {a,
            {low(a.red, b.red, a_low.red, b_low.red, before.x, behind.x),
             low(a.green, b.green, a_low.green, b_low.green, before.y, behind.y),
             low(a.blue, b.blue, a_low.blue, b_low.blue, before.z, behind.z),
             low(a.opacity, b.opacity, a_low.opacity, b_low.opacity, before.w, behind.w)}};
  };
  const Integrals begin = integrals_to(from);
  const Integrals end = integrals_to(to);
  const auto difference = [](V p, V q, V p_low, V q_low) {
    return hn::Add(hn::Sub(q, p), hn::Sub(q_low, p_low));
  };
  const V extinction =
      difference(begin.high.opacity, end.high.opacity, begin.low.opacity, end.low.opacity);
  const M is_something = hn::Ne(extinction, hn::Zero(d));
  const V inverse =
      hn::Div(hn::Set(d, 1.0F), hn::IfThenElse(is_something, extinction, hn::Set(d, 1.0F)));
  const auto color = [&](V p, V q, V p_low, V q_low) {
    const V c = hn::Mul(difference(p, q, p_low, q_low), inverse);
    return hn::Min(hn::Max(c, hn::Zero(d)), hn::Set(d, 1.0F));
  };
  const V length = hn::Mul(hn::Sub(to, from), hn::Set(d, look.integral_per_value));
  const V mean = hn::Max(hn::Div(extinction, length), hn::Zero(d));
  constexpr float kLog2E = 1.44269504F;
  const V through =
      vector_exp2(d, hn::Max(hn::Mul(mean, hn::Set(d, -kLog2E)), hn::Set(d, -126.0F)));
  return {color(begin.high.red, end.high.red, begin.low.red, end.low.red),
          color(begin.high.green, end.high.green, begin.low.green, end.low.green),
          color(begin.high.blue, end.high.blue, begin.low.blue, end.low.blue),
          hn::IfThenElseZero(is_something, hn::Sub(hn::Set(d, 1.0F), through))};
}

// Pre-integrated: the piece from the sheet before to the sample. Where both ends lie within
// kClosePieces cells the look is as good as straight between them, and its middle stands for it; so
// it does for a sample that has none before it.
HWY_INLINE Classified classify_from(const FrameLook& look, V before, V value) {
  const V middle = hn::MulAdd(hn::Sub(value, before), hn::Set(d, 0.5F), before);
  const Classified close = classify(look.table, middle);
  const V cells = hn::Abs(
      hn::Sub(place_of(look.table.constants, value), place_of(look.table.constants, before)));
  const M is_far = hn::Gt(cells, hn::Set(d, device::kClosePieces));
  if (bits_of(is_far) == 0) return close;
  const Classified far = classify_segment(look, before, value);
  return {hn::IfThenElse(is_far, far.red, close.red),
          hn::IfThenElse(is_far, far.green, close.green),
          hn::IfThenElse(is_far, far.blue, close.blue),
          hn::IfThenElse(is_far, far.opacity, close.opacity)};
}

// How many sampling distances long the path of a sample is.
HWY_INLINE V path_length(const CpuFrame& frame, const BlockPlace& place, int s, int column,
                         int row) {
  return hn::Mul(path_fraction(frame, place, s, column, row),
                 ray_length(frame, place, column, row));
}

// Opacity of every sample in `bits`, and which are visible.
inline void classify_sheet(const CpuFrame& frame, const BlockPlace& place, const SheetRing& ring,
                           int s, const RowBits& bits, ShadedSheet& shaded) {
  const Sheet& sheet = ring[place.number_of(s)];
  const Sheet& sheet_before = ring[place.number_of(s - 1)];
  const bool has_own_path = !frame.is_parallel || frame.is_clipped;
  for (int y = 0; y < place.rows; ++y) {
    shaded.visible[y] = 0;
    for_each_group(
        bits[y], place.margin, place.columns - place.margin, [&](int column, std::uint32_t lanes) {
          const int at = y * kTilePlane.stride + column;
          const V value = hn::LoadU(d, sheet.values + at);
          V before = value;
          if (frame.is_preintegrated) {
            std::uint32_t with_before = lanes_at(sheet_before.defined[y], column) & lanes;
            if (with_before != 0)
              with_before &= with_path_by_planes(frame, place, s - 1, column, y);
            before =
                hn::IfThenElse(mask_of(with_before), hn::LoadU(d, sheet_before.values + at), value);
          }
          const M may_show = hn::And(
              hn::Ge(hn::Max(value, before), hn::Set(d, frame.look.constants.look.visible_lo)),
              hn::Le(hn::Min(value, before), hn::Set(d, frame.look.constants.look.visible_hi)));
          if ((bits_of(may_show) & lanes) == 0) return;
          const Classified color = frame.is_preintegrated ? classify_from(frame.look, before, value)
                                                          : classify(frame.look.table, value);
          V a = color.opacity;
          const std::uint32_t visible = bits_of(hn::Gt(a, hn::Zero(d))) & lanes;
          if (visible == 0) return;
          if (has_own_path && !frame.corrects_late)
            a = correct_opacity(a, path_length(frame, place, s, column, y));
          hn::StoreU(a, d, shaded.alpha + at);
          hn::StoreU(color.red, d, shaded.red + at);
          hn::StoreU(color.green, d, shaded.green + at);
          hn::StoreU(color.blue, d, shaded.blue + at);
          shaded.visible[y] |= RowWord{visible} << column;
        });
  }
}

// Where another attribute gives the colour: its colours, at its own values, for the visible
// samples.
inline void color_sheet(const CpuFrame& frame, const BlockPlace& place, const Sheet& sheet,
                        ShadedSheet& shaded) {
  for (int y = 0; y < place.rows; ++y) {
    for_each_group(shaded.visible[y], place.margin, place.columns - place.margin,
                   [&](int column, std::uint32_t) {
                     const int at = y * kTilePlane.stride + column;
                     const Classified color =
                         classify(frame.look.color, hn::LoadU(d, sheet.colors + at));
                     hn::StoreU(color.red, d, shaded.red + at);
                     hn::StoreU(color.green, d, shaded.green + at);
                     hn::StoreU(color.blue, d, shaded.blue + at);
                   });
  }
}

// Where opacities are corrected late: fades the visible samples by their gradients, which are
// there, or classifies them by these, too, and corrects for the path. What fades away is no longer
// visible.
inline void correct_sheet(const CpuFrame& frame, const BlockPlace& place, int s, const Sheet& sheet,
                          ShadedSheet& shaded) {
  const bool has_own_path = !frame.is_parallel || frame.is_clipped;
  for (int y = 0; y < place.rows; ++y) {
    const RowWord candidates = shaded.visible[y];
    for_each_group(candidates, place.margin, place.columns - place.margin,
                   [&](int column, std::uint32_t lanes) {
                     const int at = y * kTilePlane.stride + column;
                     V a = hn::LoadU(d, shaded.alpha + at);
                     if (frame.fades_by_gradient) {
                       V squared = hn::Zero(d);
                       for (const float* g : sheet.gradient) {
                         const V component = hn::LoadU(d, g + at);
                         squared = hn::MulAdd(component, component, squared);
                       }
                       if (frame.look.plane.entries == nullptr) {
                         a = hn::Mul(a, classify(frame.look.fading, hn::Sqrt(squared)).opacity);
                       } else {
                         const Classified seen = classify_in_plane(
                             frame.look.plane, hn::LoadU(d, sheet.values + at), hn::Sqrt(squared));
                         a = seen.opacity;
                         hn::StoreU(seen.red, d, shaded.red + at);
                         hn::StoreU(seen.green, d, shaded.green + at);
                         hn::StoreU(seen.blue, d, shaded.blue + at);
                       }
                     }
                     V length = hn::Set(d, frame.look.constants.path_in_units);
                     if (has_own_path)
                       length = hn::Mul(length, path_length(frame, place, s, column, y));
                     const std::uint32_t gone = bits_of(hn::Le(a, hn::Zero(d))) & lanes;
                     shaded.visible[y] &= ~(RowWord{gone} << column);
                     hn::StoreU(correct_opacity(a, length), d, shaded.alpha + at);
                   });
  }
}

// Direction from the sample to the eye, unit length.
HWY_INLINE WorldVector direction_to_eye(const CpuFrame& frame, const BlockPlace& place, int column,
                                        int row) {
  if (frame.is_parallel) {
    return {hn::Set(d, -frame.camera.axis[0]), hn::Set(d, -frame.camera.axis[1]),
            hn::Set(d, -frame.camera.axis[2])};
  }
  const int at = tile_index(place, column, row);
  const auto along = [&](int a) { return hn::LoadU(d, place.rays->eye[a] + at); };
  return {along(0), along(1), along(2)};
}

// Factor on the colour, and what is added to it.
struct Lighting {
  V factor, highlight;
};

// The key's share of the diffuse light, by its cosine.
inline constexpr float kKeySlope = device::kKeyShare / (1.0F + device::kKeyWrap);
inline constexpr float kKeyOffset = device::kKeyWrap * kKeySlope;

// The cosine between the normal and the direction half-way between two of unit length, of which
// `to_light` and `to_eye` are the cosines.
HWY_INLINE V half_way_cosine(const WorldVector& light, const WorldVector& eye, V to_light,
                             V to_eye) {
  // |l + e|^2 of two unit vectors.
  const V half_squared = hn::MulAdd(hn::Set(d, 2.0F), dot_product(light, eye), hn::Set(d, 2.0F));
  const V half_inverse = reciprocal_sqrt(hn::Max(half_squared, hn::Set(d, 1e-12F)));
  return hn::Mul(hn::Abs(hn::Add(to_light, to_eye)), half_inverse);
}

// Sums of what further lights add, before flatness and material.
struct FurtherShares {
  V diffuse, flat, shine;
};

// `along`: the cosine between the normal and a direction.
template <class Along>
HWY_INLINE FurtherShares further_lights(const device::LookConstants& look, const WorldVector& eye,
                                        V to_eye, const Along& along) {
  FurtherShares sum{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (std::uint32_t i = 0; i < look.num_further_lights; ++i) {
    const device::vec4& from = look.further_lights[i];
    const V intensity = hn::Set(d, from.w);
    const WorldVector light{hn::Set(d, from.x), hn::Set(d, from.y), hn::Set(d, from.z)};
    const V to_light = along(light);
    sum.diffuse = hn::MulAdd(intensity, hn::Abs(to_light), sum.diffuse);
    sum.flat = hn::MulAdd(intensity, hn::Set(d, device::kMeanCosine), sum.flat);
    if (!(look.specular > 0)) continue;
    const V cosine = hn::Min(half_way_cosine(light, eye, to_light, to_eye), hn::Set(d, 1.0F));
    const M is_same_side = hn::Ge(hn::Mul(to_light, to_eye), hn::Zero(d));
    const V shine = hn::IfThenElseZero(is_same_side, shine_of(cosine, look.specular_power));
    sum.shine = hn::MulAdd(intensity, shine, sum.shine);
  }
  return sum;
}

// Everything is lit by what arrives: the light around, and the key or the only light there is.
// `clearance`: as flatness_of() has it.
HWY_INLINE Lighting light_sample(const device::LookConstants& look, const WorldVector& gradient,
                                 const WorldVector& eye, const ArrivingShares* arriving,
                                 const V* clearance) {
  const V squared = hn::Max(dot_product(gradient, gradient), hn::Set(d, 1e-36F));
  const V inverse = reciprocal_sqrt(squared);
  const V length = hn::Mul(squared, inverse);
  const auto along = [&](const WorldVector& v) {
    return hn::Mul(dot_product(gradient, v), inverse);
  };
  const V flatness = flatness_of(look, length, clearance);
  const V to_eye = along(eye);
  V diffuse = hn::Abs(to_eye);
  V specular = diffuse;
  // Of the diffuse light where the field is flat; what the highlight's light has left.
  V flat = hn::Set(d, 1.0F);
  V bright = flat;
  if (arriving != nullptr) {
    flat = bright = look.light_kind == device::kHeadlight ? arriving->around : arriving->key;
    diffuse = hn::Mul(diffuse, bright);
  }
  if (look.light_kind != device::kHeadlight) {
    const WorldVector light{hn::Set(d, look.light.x), hn::Set(d, look.light.y),
                            hn::Set(d, look.light.z)};
    V to_light = along(light);
    const V cosine = half_way_cosine(light, eye, to_light, to_eye);
    if (look.light_kind == device::kSingleLight) {
      diffuse = hn::Mul(bright, hn::Abs(to_light));
      specular = hn::IfThenElseZero(hn::Ge(hn::Mul(to_light, to_eye), hn::Zero(d)), cosine);
    } else {
      to_light = hn::Xor(to_light, hn::And(hn::SignBit(d), to_eye));  // of the side that is seen
      V key =
          hn::Max(hn::MulAdd(to_light, hn::Set(d, kKeySlope), hn::Set(d, kKeyOffset)), hn::Zero(d));
      V fill = hn::Set(d, 0.5F * (1.0F - device::kKeyShare));
      if (arriving != nullptr) {
        key = hn::Mul(key, bright);
        fill = hn::Mul(fill, arriving->around);
        flat = hn::MulAdd(hn::Set(d, device::kKeyShare), bright, hn::Add(fill, fill));
      }
      diffuse = hn::Add(key, hn::MulAdd(fill, hn::Abs(to_eye), fill));
      specular = hn::IfThenElseZero(hn::Gt(to_light, hn::Zero(d)), cosine);
    }
  }
  FurtherShares further;
  if (look.num_further_lights > 0) {
    further = further_lights(look, eye, to_eye, along);
    const V around = arriving != nullptr ? arriving->around : hn::Set(d, 1.0F);
    diffuse = hn::MulAdd(around, further.diffuse, diffuse);
    flat = hn::MulAdd(around, further.flat, flat);
    further.shine = hn::Mul(around, further.shine);
  }
  const V lit = hn::MulAdd(flatness, hn::Sub(diffuse, flat), flat);
  V ambient = hn::Set(d, look.ambient);
  if (arriving != nullptr) ambient = hn::Mul(ambient, arriving->around);
  Lighting out{hn::MulAdd(hn::Set(d, look.diffuse), lit, ambient), hn::Zero(d)};
  if (look.specular > 0) {
    const V shine = shine_of(hn::Min(specular, hn::Set(d, 1.0F)), look.specular_power);
    out.highlight = hn::Mul(hn::Mul(flatness, hn::Set(d, look.specular)), shine);
    if (arriving != nullptr) out.highlight = hn::Mul(out.highlight, bright);
    if (look.num_further_lights > 0) {
      out.highlight =
          hn::MulAdd(hn::Mul(flatness, hn::Set(d, look.specular)), further.shine, out.highlight);
    }
  }
  return out;
}

// What arrives is what is left of a colour that is not lit.
HWY_INLINE Lighting dim_sample(const ArrivingShares& arriving) {
  return {hn::Mul(arriving.around, arriving.key), hn::Zero(d)};
}

// A surface's, a share t of the way from sheet s - 1 to the group's. The frame takes light.
HWY_INLINE Lighting light_between(const CpuFrame& frame, const BlockPlace& place,
                                  const SampleGroup& group, V t, const WorldVector& gradient) {
  const WorldVector eye = direction_to_eye(frame, place, group.column, group.row);
  if (frame.light == nullptr)
    return light_sample(frame.look.constants, gradient, eye, nullptr, nullptr);
  const V back = hn::Sub(t, hn::Set(d, 1.0F));
  const ArrivingShares arriving =
      arriving_between(frame, place, group, back, gradient, eye, nullptr);
  if (!frame.is_lit) return dim_sample(arriving);
  return light_sample(frame.look.constants, gradient, eye, &arriving, nullptr);
}

// Neither colours nor strengths are negative.
HWY_INLINE V lit_color(V color, const Lighting& light) {
  return hn::Min(hn::MulAdd(color, light.factor, light.highlight), hn::Set(d, 1.0F));
}

inline void light_sheet(const CpuFrame& frame, const BlockPlace& place, int s, const Sheet& sheet,
                        ShadedSheet& shaded) {
  for (int y = 0; y < place.rows; ++y) {
    for_each_group(
        shaded.visible[y], place.margin, place.columns - place.margin,
        [&](int column, std::uint32_t) {
          const int at = y * kTilePlane.stride + column;
          WorldVector g = no_gradient();
          if (frame.is_lit) {
            g = {hn::LoadU(d, sheet.gradient[0] + at), hn::LoadU(d, sheet.gradient[1] + at),
                 hn::LoadU(d, sheet.gradient[2] + at)};
          }
          const WorldVector eye = direction_to_eye(frame, place, column, y);
          const SampleGroup group{s, column, y, 0};
          V distance;
          if (frame.fades_at_cuts) distance = clearance_of(frame, place, group);
          const V* const clearance = frame.fades_at_cuts ? &distance : nullptr;
          ArrivingShares arriving;
          if (frame.light != nullptr)
            arriving = arriving_at_sample(frame, place, group, g, eye, clearance);
          const Lighting light =
              frame.is_lit ? light_sample(frame.look.constants, g, eye,
                                          frame.light != nullptr ? &arriving : nullptr, clearance)
                           : dim_sample(arriving);
          for (float* color : {shaded.red + at, shaded.green + at, shaded.blue + at}) {
            hn::StoreU(lit_color(hn::LoadU(d, color), light), d, color);
          }
        });
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
