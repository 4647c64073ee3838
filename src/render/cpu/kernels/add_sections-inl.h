// SPDX-License-Identifier: Apache-2.0
// Adds sections to the planes of a level, row by row. On a row a Gaussian section is a Gaussian of
// one variable. Most are added in strips of columns, whose factors follow from row to row by a
// product; thin and slanted ones, and other profiles, a group of samples at a time.
#if defined(OVOID_RENDER_CPU_ADD_SECTIONS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_ADD_SECTIONS_INL_H_
#undef OVOID_RENDER_CPU_ADD_SECTIONS_INL_H_
#else
#define OVOID_RENDER_CPU_ADD_SECTIONS_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "render/cpu/kernels/sections-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Ends and middle of the rows of a section.
struct RowRuns {
  static constexpr int kMost = kValueRows + 16;
  alignas(64) float middle[kMost];
  alignas(64) float amplitude[kMost];
  alignas(64) float q_row[kMost];    // kProfile: of m^2, what the whole row has
  alignas(64) float tangent[kMost];  // Gaussians: tangent_at() the middle
  alignas(64) std::int32_t first[kMost];
  alignas(64) std::int32_t last[kMost];
  int row0 = 0, count = 0;
};

// How the samples of a row are worked out.
enum class RowWay { kGaussian, kProfile };

// Slant |axy| / sqrt(axx ayy) up to which strips stay in range: at the corners of the cut's box
// exponents reach 8 / (1 - slant) at cut-off 4, a float's e^-87.
inline constexpr float kMaxSlant = 0.8F;
inline constexpr float kMaxStripRoom = 36.0F;  // cut-off 6

template <RowWay kWay>
HWY_INLINE void find_rows(const Section& section, const LevelExtent& extent, RowRuns& runs) {
  const float schur = section.ayy - section.axy * section.axy / section.axx;
  const float reach = std::sqrt(section.room / schur);
  const float top = static_cast<float>(extent.size - 1);
  const float from = std::ceil(std::max(section.y - reach, 0.0F));
  const float to = std::floor(std::min(section.y + reach, top));
  runs.count = 0;
  if (!(from <= to)) return;
  runs.row0 = static_cast<int>(from);
  runs.count = static_cast<int>(to) - runs.row0 + 1;
  const V slant = hn::Set(d, -section.axy / section.axx);
  const V inverse_axx = hn::Set(d, 1.0F / section.axx);
  for (int i = 0; i < runs.count; i += group_size()) {
    const V dy = hn::Sub(hn::Iota(d, static_cast<float>(runs.row0 + i)), hn::Set(d, section.y));
    const V q = hn::Mul(hn::Mul(dy, dy), hn::Set(d, schur));
    const V room = hn::Max(hn::Sub(hn::Set(d, section.room), q), hn::Zero(d));
    const V half = hn::Sqrt(hn::Mul(room, inverse_axx));
    const V middle = hn::MulAdd(slant, dy, hn::Set(d, section.x));
    const V lo = hn::Max(hn::Ceil(hn::Sub(middle, half)), hn::Zero(d));
    const V hi =
        hn::Min(hn::Floor(hn::Add(middle, half)), hn::Set(d, static_cast<float>(extent.size - 1)));
    hn::Store(middle, d, runs.middle + i);
    // Clamped before they are turned into integers: a section may lie far beside the tile.
    hn::Store(hn::ConvertTo(di, hn::Min(lo, hn::Set(d, 1e6F))), di, runs.first + i);
    hn::Store(hn::ConvertTo(di, hn::Max(hi, hn::Set(d, -1e6F))), di, runs.last + i);
    if constexpr (kWay == RowWay::kGaussian) {
      hn::Store(hn::Mul(hn::Set(d, section.amplitude), gaussian_at(q)), d, runs.amplitude + i);
      hn::Store(tangent_at(section, q), d, runs.tangent + i);
    } else {
      hn::Store(hn::Add(q, hn::Set(d, section.q_along)), d, runs.q_row + i);
    }
  }
}

// Adds coefficient[c] * phi to the channels' planes at `row`, lanes of the group at `x`.
template <int kChannels>
HWY_INLINE void add_group(const V* coefficient, V phi, float* at, std::size_t plane_size) {
  for (int c = 0; c < kChannels; ++c, at += plane_size)
    hn::StoreU(hn::MulAdd(coefficient[c], phi, hn::LoadU(d, at)), d, at);
}

HWY_INLINE V first_lanes(V phi, int count) {
  if (count >= group_size()) return phi;
  return hn::IfThenElseZero(hn::FirstN(d, static_cast<std::size_t>(count)), phi);
}

// One row after the other, an exponential for every group.
template <int kChannels, RowWay kWay>
HWY_INLINE void add_rows(KernelProfile profile, float cutoff, const Section& section,
                         const V* coefficient, const LevelExtent& extent, float* planes,
                         std::size_t plane_size) {
  RowRuns runs;
  find_rows<kWay>(section, extent, runs);
  const V axx = hn::Set(d, section.axx);
  const V half_tail = hn::Set(d, 0.5F * section.tail);
  for (int i = 0; i < runs.count; ++i) {
    const int last = runs.last[i];
    float* row = planes + static_cast<std::size_t>(runs.row0 + i) * extent.stride;
    for (int x = runs.first[i]; x <= last; x += group_size()) {
      const V dx = hn::Iota(d, static_cast<float>(x) - runs.middle[i]);
      const V q = hn::Mul(hn::Mul(dx, dx), axx);
      V phi;
      if constexpr (kWay == RowWay::kGaussian) {
        const V tangent = hn::NegMulAdd(q, half_tail, hn::Set(d, runs.tangent[i]));
        phi = smooth_end(hn::Set(d, runs.amplitude[i]), gaussian_at(q), tangent);
      } else {
        phi = hn::Mul(hn::Set(d, section.amplitude),
                      profile_at(profile, hn::Add(q, hn::Set(d, runs.q_row[i])), cutoff));
      }
      add_group<kChannels>(coefficient, first_lanes(phi, last - x + 1), row + x, plane_size);
    }
  }
}

// Rows of a section.
struct StripRows {
  static constexpr int kMost = kValueRows + 16;
  alignas(64) float dy[kMost];         // from the centre
  alignas(64) float amplitude[kMost];  // with the part of exp(-q / 2) that is the row's own
  alignas(64) float room[kMost];       // that the row's own part of q leaves
  int row0 = 0, count = 0;
};

// Whole numbers [first, past).
struct Span {
  int first, past;
};

// The samples of a level within `reach` of a place along an axis.
HWY_INLINE Span samples_within(float at, float reach, const LevelExtent& extent) {
  const float from = std::ceil(std::max(at - reach, 0.0F));
  const float to = std::floor(std::min(at + reach, static_cast<float>(extent.size - 1)));
  if (!(from <= to)) return {0, 0};
  return {static_cast<int>(from), static_cast<int>(to) + 1};
}

HWY_INLINE void find_strip_rows(const Section& section, const Span& span, StripRows& rows) {
  rows.row0 = span.first;
  rows.count = span.past - span.first;
  for (int i = 0; i < rows.count; i += group_size()) {
    const V dy = hn::Sub(hn::Iota(d, static_cast<float>(span.first + i)), hn::Set(d, section.y));
    const V q = hn::Mul(hn::Mul(dy, dy), hn::Set(d, section.ayy));
    hn::Store(dy, d, rows.dy + i);
    hn::Store(hn::Mul(hn::Set(d, section.amplitude), gaussian_at(q)), d, rows.amplitude + i);
    hn::Store(hn::Sub(hn::Set(d, section.room), q), d, rows.room + i);
  }
}

// The same of kGroups groups of columns. exp(-1/2 (axx dx^2 + 2 axy dx dy)) is carried from row to
// row: the next row's is this one's times exp(-axy dx). Round cuts have no mixed term and one
// factor for all rows. So a group costs a product, not an exponential, and its factors stay in
// registers.
template <int kGroups, bool kIsRound>
struct StripColumns {
  V factor[kGroups], q[kGroups];
  V step[kGroups], mixed[kGroups];  // not of round ones
};

// `box_q`: q of the columns where the cut's box ends.
template <int kGroups, bool kIsRound>
HWY_INLINE StripColumns<kGroups, kIsRound> find_strip_columns(const Section& section, int x0,
                                                              float dy0, float box_q) {
  StripColumns<kGroups, kIsRound> columns;
  for (int g = 0; g < kGroups; ++g) {
    const V dx =
        hn::Sub(hn::Iota(d, static_cast<float>(x0 + g * group_size())), hn::Set(d, section.x));
    columns.q[g] = hn::Mul(hn::Mul(dx, dx), hn::Set(d, section.axx));
    V q = columns.q[g];
    if constexpr (!kIsRound) {
      columns.mixed[g] = hn::Mul(dx, hn::Set(d, 2.0F * section.axy));
      q = hn::MulAdd(columns.mixed[g], hn::Set(d, dy0), q);
      columns.step[g] = vector_exp2(d, hn::Mul(columns.mixed[g], hn::Set(d, -kHalfLog2E)));
    }
    columns.factor[g] = hn::IfThenElseZero(hn::Le(columns.q[g], hn::Set(d, box_q)), gaussian_at(q));
  }
  return columns;
}

// `at`: the strip's first column of the first row.
template <int kGroups, int kChannels, bool kIsRound>
HWY_INLINE void add_strip(StripColumns<kGroups, kIsRound> columns, const StripRows& rows,
                          float section_tail, const V* coefficient, float* at, std::size_t stride,
                          std::size_t plane_size) {
  const V half_tail = hn::Set(d, 0.5F * section_tail);
  const V tail = hn::Set(d, section_tail);
  for (int i = 0; i < rows.count; ++i, at += stride) {
    const V amplitude = hn::Set(d, rows.amplitude[i]);
    const V room = hn::Set(d, rows.room[i]);
    for (int g = 0; g < kGroups; ++g) {
      V q = columns.q[g];
      if constexpr (!kIsRound) q = hn::MulAdd(columns.mixed[g], hn::Set(d, rows.dy[i]), q);
      const V rest = hn::Sub(room, q);
      const V phi = smooth_end(amplitude, columns.factor[g], hn::MulAdd(half_tail, rest, tail));
      const V inside = hn::IfThenElseZero(hn::Ge(rest, hn::Zero(d)), phi);
      add_group<kChannels>(coefficient, inside, at + g * group_size(), plane_size);
      if constexpr (!kIsRound) columns.factor[g] = hn::Mul(columns.factor[g], columns.step[g]);
    }
  }
}

// How a Gaussian section is added.
enum class SectionWay {
  kRound,    // strips: a circle
  kTame,     // strips
  kSlanted,  // row by row, an exponential for each group: so thin and slanted that the factors of
             // strips would leave the range of a float
};

HWY_INLINE SectionWay way_of(float axx, float axy, float ayy, float room) {
  if (!(axy * axy <= kMaxSlant * kMaxSlant * axx * ayy && room <= kMaxStripRoom))
    return SectionWay::kSlanted;
  return axy == 0.0F && axx == ayy ? SectionWay::kRound : SectionWay::kTame;
}

// Rows and columns of a level that a section reaches.
struct SectionBox {
  Span rows, columns;
  bool is_empty() const { return rows.first >= rows.past || columns.first >= columns.past; }
};

template <int kChannels, bool kIsRound>
HWY_INLINE void add_box(const Section& section, const SectionBox& box, const V* coefficient,
                        const LevelExtent& extent, float* planes, std::size_t plane_size) {
  constexpr float kBoxSlack = 1.0001F;  // no column is lost by rounding
  StripRows rows;
  find_strip_rows(section, box.rows, rows);
  const float box_q = kBoxSlack * section.room *
                      (kIsRound ? 1.0F
                                : section.axx * section.ayy /
                                      (section.axx * section.ayy - section.axy * section.axy));
  const auto stride = static_cast<std::size_t>(extent.stride);
  float* const row = planes + static_cast<std::size_t>(rows.row0) * stride;
  const auto add = [&](auto groups, int x) {
    const auto columns = find_strip_columns<groups, kIsRound>(section, x, rows.dy[0], box_q);
    add_strip<groups, kChannels>(columns, rows, section.tail, coefficient, row + x, stride,
                                 plane_size);
  };
  // Strips begin with a group: what splats that overlap write and read again is the same memory.
  int x = box.columns.first / group_size() * group_size();
  for (; x + group_size() < box.columns.past; x += 2 * group_size())
    add(std::integral_constant<int, 2>(), x);
  if (x < box.columns.past) add(std::integral_constant<int, 1>(), x);
}

HWY_INLINE SectionBox box_of(const Section& section, const LevelExtent& extent) {
  const float per = section.room / (section.axx * section.ayy - section.axy * section.axy);
  return {samples_within(section.y, std::sqrt(per * section.axx), extent),
          samples_within(section.x, std::sqrt(per * section.ayy), extent)};
}

// Adds coefficient[c] * phi of a Gaussian to the planes of one sheet.
template <int kChannels>
HWY_INLINE void add_gaussian(const Section& section, const SectionBox& box, SectionWay way,
                             const V* coefficient, const LevelExtent& extent, float* planes,
                             std::size_t plane_size) {
  switch (way) {
    case SectionWay::kRound:
      return add_box<kChannels, true>(section, box, coefficient, extent, planes, plane_size);
    case SectionWay::kTame:
      return add_box<kChannels, false>(section, box, coefficient, extent, planes, plane_size);
    case SectionWay::kSlanted:
      break;
  }
  add_rows<kChannels, RowWay::kGaussian>(KernelProfile::kGaussian, 0.0F, section, coefficient,
                                         extent, planes, plane_size);
}

// The same of any section.
template <int kChannels, bool kIsGaussian>
HWY_INLINE void add_section(const KernelFrame& frame, const Section& section,
                            const float* coefficients, const LevelExtent& extent, float* planes,
                            std::size_t plane_size) {
  V coefficient[kChannels];
  for (int c = 0; c < kChannels; ++c) coefficient[c] = hn::Set(d, coefficients[c]);
  if constexpr (kIsGaussian) {
    const SectionBox box = box_of(section, extent);
    if (box.is_empty()) return;
    add_gaussian<kChannels>(section, box,
                            way_of(section.axx, section.axy, section.ayy, section.room),
                            coefficient, extent, planes, plane_size);
  } else {
    add_rows<kChannels, RowWay::kProfile>(frame.profile, frame.cutoff, section, coefficient, extent,
                                          planes, plane_size);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
