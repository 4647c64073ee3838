// SPDX-License-Identifier: Apache-2.0
// Scores of labels at a place in a brick, and their slopes (docs/numerics.md, "Labels").
//
// A score is 4 x 4 x 4 taps of a cubic B-spline, four bytes of a row at a time.
#if defined(OVOID_LABELS_SCORES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_LABELS_SCORES_INL_H_
#undef OVOID_LABELS_SCORES_INL_H_
#else
#define OVOID_LABELS_SCORES_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "labels/label_brick.h"
#include "ovoid/math.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::labels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
struct Four {
  std::array<float, 4> v{};

  static Four of(const float* p) { return {{p[0], p[1], p[2], p[3]}}; }
  void add_bytes(const std::uint8_t* bytes, float weight) {
    for (std::size_t i = 0; i < 4; ++i) v[i] += weight * static_cast<float>(bytes[i]);
  }
  void add(const Four& other, float weight) {
    for (std::size_t i = 0; i < 4; ++i) v[i] += weight * other.v[i];
  }
  float dot(const Four& w) const {
    return v[0] * w.v[0] + v[1] * w.v[1] + v[2] * w.v[2] + v[3] * w.v[3];
  }
};
#else
// Four floats, of neighbours along x.
class Four {
 public:
  using D4 = hn::FixedTag<float, 4>;
  using DI4 = hn::FixedTag<std::int32_t, 4>;
  using DB4 = hn::FixedTag<std::uint8_t, 4>;

  HWY_INLINE Four() : v_(hn::Zero(D4())) {}
  static HWY_INLINE Four of(const float* p) {
    Four four;
    four.v_ = hn::LoadU(D4(), p);
    return four;
  }
  HWY_INLINE void add_bytes(const std::uint8_t* bytes, float weight) {
    const auto wide = hn::PromoteTo(DI4(), hn::LoadU(DB4(), bytes));
    v_ = hn::MulAdd(hn::ConvertTo(D4(), wide), hn::Set(D4(), weight), v_);
  }
  HWY_INLINE void add(const Four& other, float weight) {
    v_ = hn::MulAdd(other.v_, hn::Set(D4(), weight), v_);
  }
  HWY_INLINE float dot(const Four& w) const {
    return hn::GetLane(hn::SumOfLanes(D4(), hn::Mul(v_, w.v_)));
  }

 private:
  hn::Vec<D4> v_;
};
#endif

// Of the four taps around a place, a share `f` behind the second.
struct TapWeights {
  std::array<float, 4> of;

  HWY_INLINE explicit TapWeights(float f) {
    constexpr float kSixth = 1.0F / 6;
    const float g = 1 - f;
    of = {kSixth * g * g * g, kSixth * ((3 * f - 6) * f * f + 4),
          kSixth * ((3 * g - 6) * g * g + 4), kSixth * f * f * f};
  }
};

// How they change with the place.
struct TapSlopes {
  std::array<float, 4> of;

  HWY_INLINE explicit TapSlopes(float f) {
    const float g = 1 - f;
    of = {-0.5F * g * g, 0.5F * (3 * f - 4) * f, 0.5F * (4 - 3 * g) * g, 0.5F * f * f};
  }
};

inline std::size_t number_of(const std::array<int, 3>& cell) {
  const int number = (cell[2] * kBrickEdge + cell[1]) * kBrickEdge + cell[0];
  return static_cast<std::size_t>(number);
}

// A place in a brick: its cell, and how far in it.
struct PlaceInBrick {
  std::array<int, 3> cell;
  std::array<float, 3> share;  // each in [0, 1]

  // `in_brick`: in cells from its corner.
  HWY_INLINE void set_share(const Vec3& in_brick) {
    for (std::size_t a = 0; a < 3; ++a) {
      const double share_in = in_brick[static_cast<Eigen::Index>(a)] - cell[a];
      share[a] = std::clamp(static_cast<float>(share_in), 0.0F, 1.0F);
    }
  }
};

// The scores of some labels of a brick at one place, as they are stored.
struct Scores {
  Scores() = default;
  HWY_INLINE Scores(const LabelBrick& brick, std::uint32_t labels, const PlaceInBrick& at) {
    const TapWeights x(at.share[0]), y(at.share[1]), z(at.share[2]);
    const Four wx = Four::of(x.of.data());
    const std::uint8_t* const corner =
        brick.fine.data() + (at.cell[2] * kFineEdge + at.cell[1]) * kFineEdge + at.cell[0];
    for (std::uint32_t left = labels; left != 0; left &= left - 1) {
      const int l = std::countr_zero(left);
      const std::uint8_t* slice = corner + static_cast<std::size_t>(l) * kNumFine;
      Four sum;
      for (std::size_t k = 0; k < 4; ++k, slice += kFineEdge * kFineEdge) {
        Four rows;
        for (std::size_t j = 0; j < 4; ++j) rows.add_bytes(slice + j * kFineEdge, y.of[j]);
        sum.add(rows, z.of[k]);
      }
      of_label[static_cast<std::size_t>(l)] = sum.dot(wx);
    }
  }

  std::array<float, kMostInBrick> of_label;  // of those that were asked for
};

// The one with the greatest score, of at least one.
inline std::size_t best_of(const Scores& scores, std::uint32_t labels) {
  auto best = static_cast<std::size_t>(std::countr_zero(labels));
  for (std::uint32_t left = labels & (labels - 1); left != 0; left &= left - 1) {
    const auto l = static_cast<std::size_t>(std::countr_zero(left));
    if (scores.of_label[l] > scores.of_label[best]) best = l;
  }
  return best;
}

// The slope of a label's coarse score, per sample; as it is stored.
HWY_INLINE Vec3 coarse_slope(const LabelBrick& brick, int label, const PlaceInBrick& at) {
  std::array<int, 3> first;
  std::array<float, 3> share;
  for (std::size_t a = 0; a < 3; ++a) {
    // A score stands for two samples, those before and behind it.
    const float place = 0.5F * (static_cast<float>(at.cell[a]) + at.share[a] - 0.5F);
    const float below = std::floor(place);
    first[a] = static_cast<int>(below) + 1;
    share[a] = place - below;
  }
  const TapWeights x(share[0]), y(share[1]), z(share[2]);
  const TapSlopes dx(share[0]), dy(share[1]), dz(share[2]);
  const std::uint8_t* slice = brick.coarse.data() + static_cast<std::size_t>(label) * kNumCoarse +
                              (first[2] * kCoarseEdge + first[1]) * kCoarseEdge + first[0];
  Four sum, along_y, along_z;
  for (std::size_t k = 0; k < 4; ++k, slice += kCoarseEdge * kCoarseEdge) {
    Four rows, slopes;
    for (std::size_t j = 0; j < 4; ++j) {
      rows.add_bytes(slice + j * kCoarseEdge, y.of[j]);
      slopes.add_bytes(slice + j * kCoarseEdge, dy.of[j]);
    }
    sum.add(rows, z.of[k]);
    along_y.add(slopes, z.of[k]);
    along_z.add(rows, dz.of[k]);
  }
  const Four wx = Four::of(x.of.data());
  return 0.5 * Vec3(sum.dot(Four::of(dx.of.data())), along_y.dot(wx), along_z.dot(wx));
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::labels
HWY_AFTER_NAMESPACE();

#endif
