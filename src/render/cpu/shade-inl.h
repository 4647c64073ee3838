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

#include "render/cpu/gradient-inl.h"
#include "render/cpu/path-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Colour and opacity of a group's values.
struct Classified {
  V red, green, blue, opacity;
};

#if HWY_TARGET != HWY_SCALAR
// Nodes of the lanes k, k + 4, k + 8, ...: one 128-bit block each.
HWY_INLINE V load_nodes(const float* nodes, const std::int32_t* index, int k) {
  const hn::FixedTag<float, 4> four;
  const auto block = [&](int lane) { return hn::Load(four, nodes + 4 * index[lane]); };
#if HWY_MAX_BYTES >= 64
  const hn::FixedTag<float, 8> eight;
  return hn::Combine(d, hn::Combine(eight, block(k + 12), block(k + 8)),
                     hn::Combine(eight, block(k + 4), block(k)));
#elif HWY_MAX_BYTES >= 32
  return hn::Combine(d, block(k + 4), block(k));
#else
  return block(k);
#endif
}

// The four channels of every lane's node: a 4 x 4 transposition within blocks.
HWY_INLINE Classified transpose_nodes(const float* nodes, const std::int32_t* index) {
  const hn::RepartitionToWide<D> pairs;
  const V n0 = load_nodes(nodes, index, 0), n1 = load_nodes(nodes, index, 1);
  const V n2 = load_nodes(nodes, index, 2), n3 = load_nodes(nodes, index, 3);
  const auto rg01 = hn::BitCast(pairs, hn::InterleaveLower(d, n0, n1));
  const auto rg23 = hn::BitCast(pairs, hn::InterleaveLower(d, n2, n3));
  const auto ba01 = hn::BitCast(pairs, hn::InterleaveUpper(d, n0, n1));
  const auto ba23 = hn::BitCast(pairs, hn::InterleaveUpper(d, n2, n3));
  return {hn::BitCast(d, hn::InterleaveLower(pairs, rg01, rg23)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, rg01, rg23)),
          hn::BitCast(d, hn::InterleaveLower(pairs, ba01, ba23)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, ba01, ba23))};
}
#else
HWY_INLINE Classified transpose_nodes(const float* nodes, const std::int32_t* index) {
  const float* n = nodes + 4 * index[0];
  return {hn::Load(d, n), hn::Load(d, n + 1), hn::Load(d, n + 2), hn::Load(d, n + 3)};
}
#endif

// A node is four floats, so a lane's two nodes are two loads; hardware gathers of eight separate
// columns take longer.
HWY_INLINE Classified classify(const ClassificationTable& table, V value) {
  const V at =
      hn::Mul(hn::Sub(value, hn::Set(d, table.value_lo)), hn::Set(d, table.nodes_per_value));
  // The order of operands makes NaN, of lanes that nobody asked for, a node too.
  const V clamped = hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, table.last_node));
  const V node = hn::Floor(clamped);
  V fraction = hn::Sub(clamped, node);
  alignas(64) std::int32_t index[16];
  const auto integers = nearest_integer(node);
  hn::Store(integers, di, index);
  if (table.steps != nullptr) {
    const V step = hn::GatherIndex(d, table.steps, integers);
    const V side = hn::IfThenElseZero(hn::Ge(fraction, step), hn::Set(d, 1.0F));
    fraction = hn::IfThenElse(hn::Lt(step, hn::Zero(d)), fraction, side);
  }
  const Classified lo = transpose_nodes(table.nodes, index);
  const Classified hi = transpose_nodes(table.nodes + 4, index);
  const auto mix = [&](V a, V b) { return hn::MulAdd(hn::Sub(b, a), fraction, a); };
  return {mix(lo.red, hi.red), mix(lo.green, hi.green), mix(lo.blue, hi.blue),
          mix(lo.opacity, hi.opacity)};
}

// x^power for x in [0, 1].
HWY_INLINE V vector_power(V x, float power) {
  const V log = vector_log2(hn::Max(x, hn::Set(d, 1e-30F)));
  return vector_exp2(d, hn::Max(hn::Mul(log, hn::Set(d, power)), hn::Set(d, -126.0F)));
}

// 1 - (1 - a)^exponent, the opacity of a path that is `exponent` sampling distances long.
HWY_INLINE V correct_opacity(V a, V exponent) {
  const V log = vector_log2(hn::Max(hn::Sub(hn::Set(d, 1.0F), a), hn::Set(d, 1e-30F)));
  const V through = vector_exp2(d, hn::Max(hn::Mul(log, exponent), hn::Set(d, -126.0F)));
  // An opaque sample stays opaque however short its path, if it has one.
  return hn::IfThenElse(hn::Ge(a, hn::Set(d, 1.0F)), a, hn::Sub(hn::Set(d, 1.0F), through));
}

// Opacity of every sample in `bits`, and which are visible.
inline void classify_sheet(const CpuFrame& frame, Block& block, int s, const RowBits& bits) {
  const float* values = block.values[s & (kRingSheets - 1)];
  const bool has_own_path = !frame.is_parallel || frame.plan->is_clipped;
  for (int y = 0; y < block.rows; ++y) {
    block.visible[y] = 0;
    for_each_group(
        bits[y], block.margin, block.columns - block.margin, [&](int column, std::uint32_t lanes) {
          const int at = y * kPlaneStride + column;
          const V value = hn::LoadU(d, values + at);
          const M may_show = hn::And(hn::Ge(value, hn::Set(d, frame.table.visible_lo)),
                                     hn::Le(value, hn::Set(d, frame.table.visible_hi)));
          if ((bits_of(may_show) & lanes) == 0) return;
          const Classified color = classify(frame.table, value);
          V a = color.opacity;
          const std::uint32_t visible = bits_of(hn::Gt(a, hn::Zero(d))) & lanes;
          if (visible == 0) return;
          if (has_own_path) {
            const V fraction = path_fraction(frame, block, s, column, y);
            a = correct_opacity(a, hn::Mul(fraction, ray_length(frame, block, column, y)));
          }
          hn::StoreU(a, d, block.sample_alpha + at);
          hn::StoreU(color.red, d, block.sample_red + at);
          hn::StoreU(color.green, d, block.sample_green + at);
          hn::StoreU(color.blue, d, block.sample_blue + at);
          block.visible[y] |= visible << column;
        });
  }
}

// Direction from the sample to the eye, unit length.
HWY_INLINE WorldVector direction_to_eye(const CpuFrame& frame, const Block& block, int column,
                                        int row) {
  const view::SheetMap& direction = frame.ray_direction;
  if (frame.is_parallel) {
    return {hn::Set(d, -frame.axis[0]), hn::Set(d, -frame.axis[1]), hn::Set(d, -frame.axis[2])};
  }
  const V x = pixel_x(block, column);
  const float y = pixel_y(block, row);
  const auto along = [&](int a) {
    return evaluate2d({direction.origin[a], direction.per_x[a], direction.per_y[a]}, x, y);
  };
  const V scale = hn::Div(hn::Set(d, -1.0F), ray_length(frame, block, column, row));
  return {hn::Mul(along(0), scale), hn::Mul(along(1), scale), hn::Mul(along(2), scale)};
}

HWY_INLINE V dot_product(const WorldVector& a, const WorldVector& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

// Factor on the colour, and what is added to it.
struct Lighting {
  V factor, highlight;
};

HWY_INLINE Lighting light_sample(const CpuFrame& frame, const WorldVector& gradient,
                                 const WorldVector& eye) {
  const V squared = hn::Max(dot_product(gradient, gradient), hn::Set(d, 1e-36F));
  const V inverse = reciprocal_sqrt(squared);
  const V length = hn::Mul(squared, inverse);
  const WorldVector normal{hn::Mul(gradient.x, inverse), hn::Mul(gradient.y, inverse),
                           hn::Mul(gradient.z, inverse)};
  const V flatness =
      hn::Min(hn::Mul(length, hn::Set(d, frame.flat_gradient_inverse)), hn::Set(d, 1.0F));
  const V to_eye = dot_product(normal, eye);
  V diffuse = hn::Abs(to_eye);
  V specular = diffuse;
  if (!frame.has_headlight) {
    const WorldVector light{hn::Set(d, frame.light[0]), hn::Set(d, frame.light[1]),
                            hn::Set(d, frame.light[2])};
    const V to_light = dot_product(normal, light);
    diffuse = hn::Abs(to_light);
    const WorldVector half{hn::Add(light.x, eye.x), hn::Add(light.y, eye.y),
                           hn::Add(light.z, eye.z)};
    const V half_length = hn::Sqrt(dot_product(half, half));
    const V cosine =
        hn::Div(hn::Abs(dot_product(normal, half)), hn::Max(half_length, hn::Set(d, 1e-6F)));
    specular = hn::IfThenElseZero(hn::Ge(hn::Mul(to_light, to_eye), hn::Zero(d)), cosine);
  }
  const V lit = hn::MulAdd(flatness, hn::Sub(diffuse, hn::Set(d, 1.0F)), hn::Set(d, 1.0F));
  Lighting out{hn::MulAdd(hn::Set(d, frame.diffuse), lit, hn::Set(d, frame.ambient)), hn::Zero(d)};
  if (frame.specular > 0) {
    const V shine = vector_power(hn::Min(specular, hn::Set(d, 1.0F)), frame.specular_power);
    out.highlight = hn::Mul(hn::Mul(flatness, hn::Set(d, frame.specular)), shine);
  }
  return out;
}

HWY_INLINE V lit_color(V color, const Lighting& light) {
  const V c = hn::MulAdd(color, light.factor, light.highlight);
  return hn::Min(hn::Max(c, hn::Zero(d)), hn::Set(d, 1.0F));
}

inline void light_sheet(const CpuFrame& frame, Block& block) {
  for (int y = 0; y < block.rows; ++y) {
    for_each_group(block.visible[y], block.margin, block.columns - block.margin,
                   [&](int column, std::uint32_t) {
                     const int at = y * kPlaneStride + column;
                     const WorldVector g{hn::LoadU(d, block.gradient[0] + at),
                                         hn::LoadU(d, block.gradient[1] + at),
                                         hn::LoadU(d, block.gradient[2] + at)};
                     const Lighting light =
                         light_sample(frame, g, direction_to_eye(frame, block, column, y));
                     for (float* color : {block.sample_red + at, block.sample_green + at,
                                          block.sample_blue + at}) {
                       hn::StoreU(lit_color(hn::LoadU(d, color), light), d, color);
                     }
                   });
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
