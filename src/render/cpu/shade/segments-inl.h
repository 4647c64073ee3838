// SPDX-License-Identifier: Apache-2.0
// Looks that are a few straight segments, read out of registers (look_segments.h); other looks by
// their tables.
#if defined(OVOID_RENDER_CPU_SEGMENTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_SEGMENTS_INL_H_
#undef OVOID_RENDER_CPU_SEGMENTS_INL_H_
#else
#define OVOID_RENDER_CPU_SEGMENTS_INL_H_
#endif

#include "render/cpu/shade/look_segments.h"
#include "render/cpu/shade/shade-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// As many segments as a register has lanes.
inline bool are_usable(const Segments& segments) {
  return HWY_TARGET != HWY_SCALAR && segments.count > 0 && segments.count <= group_size();
}

#if HWY_TARGET == HWY_SCALAR
// Never used.
struct SegmentsOfGroup {
  SegmentsOfGroup(const Segments&, const device::TableConstants&, V) {}
  V pick(const float*) const { return hn::Zero(d); }
  V place() const { return hn::Zero(d); }
};
#else
// The segments that a group's values lie on.
class SegmentsOfGroup {
 public:
  HWY_INLINE SegmentsOfGroup(const Segments& segments, const device::TableConstants& table,
                             V value) {
    // The order of operands makes NaN, of lanes that nobody asked for, a place too.
    place_ = hn::Min(hn::Max(place_of(table, value), hn::Zero(d)), hn::Set(d, kLastEntry));
    const V first = hn::Load(d, segments.first);
    VI segment = hn::Zero(di);
    for (int bit = group_size() / 2; bit > 0; bit /= 2) {
      if (bit >= segments.count) continue;
      const VI next = hn::Or(segment, hn::Set(di, bit));
      const V begin = hn::TableLookupLanes(first, hn::IndicesFromVec(d, next));
      segment = hn::IfThenElse(hn::RebindMask(di, hn::Ge(place_, begin)), next, segment);
    }
    index_ = hn::IndicesFromVec(d, segment);
  }

  // Each lane's own of numbers of all segments.
  HWY_INLINE V pick(const float* numbers) const {
    return hn::TableLookupLanes(hn::Load(d, numbers), index_);
  }
  V place() const { return place_; }

 private:
  V place_;
  decltype(hn::IndicesFromVec(d, hn::Zero(di))) index_;
};
#endif

HWY_INLINE Classified classify_in_segments(const ColorSegments& segments,
                                           const device::TableConstants& table, V value) {
  const SegmentsOfGroup at(segments, table, value);
  const auto number = [&](int c) {
    return hn::MulAdd(at.pick(segments.slope[c]), at.place(), at.pick(segments.base[c]));
  };
  // Segments may be darker than black, by their error.
  const auto color = [&](int c) { return hn::Max(number(c), hn::Zero(d)); };
  return {color(0), color(1), color(2), number(3)};
}

// Something that is 0 where a value has no opacity, and how much the look varies up to it.
HWY_INLINE VariationAt variation_of(const FrameLook& look, V value) {
  const VariationSegments& segments = look.variation_segments;
  if (!are_usable(segments)) return variation_at(look, value);
  const SegmentsOfGroup at(segments, look.table.constants, value);
  const auto term = [&](int i) { return at.pick(segments.terms[i]); };
  return {at.pick(segments.shows),
          hn::MulAdd(hn::MulAdd(term(2), at.place(), term(1)), at.place(), term(0))};
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
