// SPDX-License-Identifier: Apache-2.0
// One ray through a label map (docs/numerics.md, "Labels").
//
// In:  a ray in index space, and which labels are one body.
// Out: the changes of the body that wins along it.
//
// The ray goes from brick to brick, and in a brick from cell to cell. A brick with one label, and a
// cell in which one body alone can win, are passed without a score. In the other cells scores are
// taken along the ray, as far from each other as what wins is ahead, and where it has changed the
// place is narrowed down.
#if defined(OVOID_LABELS_LABEL_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_LABELS_LABEL_RAYS_INL_H_
#undef OVOID_LABELS_LABEL_RAYS_INL_H_
#else
#define OVOID_LABELS_LABEL_RAYS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "labels/box_walk.h"
#include "labels/label_rays.h"
#include "labels/scores-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::labels {
namespace HWY_NAMESPACE {

// Between two scores along a ray at least, samples: less than what the thinnest structure is wide,
// one that smoothing left and one that was kept against it.
inline constexpr double kStep = 0.4;
inline constexpr double kStepInKept = 0.35;
// How fast a body's lead over another changes at most, per sample, where nothing was kept: twice
// the smoothing kernel's greatest line integral across, which at the axes is 0.88.
inline constexpr double kSteepest = 0.95;
// Fewer bricks of one label are passed one by one.
inline constexpr int kWorthLeap = 3;
// How well a surface's place is known, samples.
inline constexpr double kExact = 0.004;
inline constexpr float kExactLead = 0.004F * kScoreSteps;
inline constexpr int kMostNarrowings = 12;

inline std::array<int, 3> bricks_along(const LabelGrid& grid) {
  const Index3& num = grid.num_bricks();
  return {static_cast<int>(num[0]), static_cast<int>(num[1]), static_cast<int>(num[2])};
}

// Index space.
inline Vec3 corner_of(const std::array<int, 3>& brick) {
  return {static_cast<double>(brick[0] * kBrickEdge - 1),
          static_cast<double>(brick[1] * kBrickEdge - 1),
          static_cast<double>(brick[2] * kBrickEdge - 1)};
}

// A ray on its way.
class Tracer {
 public:
  Tracer(const LabelGrid& grid, const Bodies& bodies, const LabelRay& ray,
         std::vector<LabelCrossing>& crossings)
      : grid_(grid),
        bodies_(bodies),
        ray_(ray),
        slopes_(ray),
        crossings_(crossings),
        num_bricks_(bricks_along(grid)),
        length_(ray.direction.norm()) {}

  Bodies::Id walk(Rank* rank) {
    *rank = kNoLabel;
    BoxWalk bricks(slopes_, ray_.begin, Vec3::Constant(-1), kBrickEdge, num_bricks_);
    do {
      const double end = std::min(bricks.leave(), ray_.end);
      const auto [i, j, k] = bricks.box;
      const Rank only = grid_.only_label(grid_.brick_at(i, j, k));
      if (only != LabelGrid::kMixed) {
        pass(only, bricks.enter(), rank);
      } else {
        enter_brick(grid_.brick(i, j, k), bricks.box);
        if (brick_->ranks.size() == 1) {
          pass(brick_->ranks.front(), bricks.enter(), rank);
        } else {
          walk_cells(bricks.enter(), end, rank);
        }
      }
      if (is_done_ || end >= ray_.end) break;
      if (only == LabelGrid::kMixed) continue;
      const int steps = grid_.steps_to_others(grid_.brick_at(i, j, k));
      if (steps < kWorthLeap) continue;
      const double landing = bricks.leave_after(steps - 1);
      if (landing >= ray_.end) break;
      bricks = BoxWalk(slopes_, landing, Vec3::Constant(-1), kBrickEdge, num_bricks_);
    } while (bricks.advance());
    return start_;
  }

 private:
  void enter_brick(const LabelBrick& brick, const std::array<int, 3>& box) {
    brick_ = &brick;
    corner_ = corner_of(box);
    const std::size_t num = brick.ranks.size();
    for (std::size_t l = 0; l < num; ++l) body_[l] = bodies_.of(brick.ranks[l]);
    for (std::size_t i = 0; i < std::min(kKnownSets, brick.candidate_sets.size()); ++i)
      body_of_set_[i] = only_body_in(brick.candidate_sets[i]);
    few_ = 0;
    if (brick.adds_up && num > 1) find_few(num);
  }

  // Where there are two bodies, the labels of the one that has fewer.
  void find_few(std::size_t num) {
    std::uint32_t first = 0;
    std::uint32_t second = 0;
    for (std::size_t l = 0; l < num; ++l) {
      if (body_[l] == body_[0]) {
        first |= 1U << l;
        continue;
      }
      if (second == 0) other_body_ = body_[l];
      if (body_[l] != other_body_) return;
      second |= 1U << l;
    }
    few_body_ = body_[0];
    few_ = first;
    if (second == 0 || std::popcount(first) <= std::popcount(second)) return;
    std::swap(few_body_, other_body_);
    few_ = second;
  }

  // Everything from here on, for a while, is that label's.
  void pass(Rank only, double t, Rank* rank) {
    const Bodies::Id body = bodies_.of(only);
    if (!has_started_) {
      start(body, only, rank);
    } else if (body != now_) {
      // The surface lies on the side of the box, as far as rounding lets see.
      cross({t, now_, body, label_shown(body, only), ray_.direction});
    }
  }

  Rank label_shown(Bodies::Id body, Rank rank) const {
    return bodies_.all[body].is_shown ? rank : kNoLabel;
  }

  void start(Bodies::Id body, Rank label, Rank* rank) {
    start_ = now_ = body;
    *rank = label;
    has_started_ = true;
    is_done_ = bodies_.all[body].is_opaque;
  }

  void cross(const LabelCrossing& crossing) {
    crossings_.push_back(crossing);
    now_ = crossing.behind;
    is_done_ = bodies_.all[now_].is_opaque;
  }

  void walk_cells(double begin, double end, Rank* rank) {
    BoxWalk cells(slopes_, begin, corner_, 1, {kBrickEdge, kBrickEdge, kBrickEdge});
    do {
      const double leave = std::min(cells.leave(), end);
      const std::size_t set = brick_->candidates[number_of(cells.box)];
      const Bodies::Id body =
          set < kKnownSets ? body_of_set_[set] : only_body_in(brick_->candidate_sets[set]);
      if (body == now_ && has_started_) continue;
      candidates_ = brick_->candidate_sets[set];
      if (!has_started_) {
        place_.cell = cells.box;
        start_in_cell(cells.enter(), rank);
      }
      if (is_done_) return;
      if (body != kSeveral) {
        pass(brick_->ranks[static_cast<std::size_t>(std::countr_zero(candidates_))], cells.enter(),
             rank);
      } else if (leave > safe_until_) {
        place_.cell = cells.box;
        search(cells.enter(), leave);
      }
      if (is_done_) return;
    } while (cells.leave() < end && cells.advance());
  }

  // kSeveral: they are not of one.
  Bodies::Id only_body_in(std::uint32_t labels) const {
    const Bodies::Id first = body_[static_cast<std::size_t>(std::countr_zero(labels))];
    for (std::uint32_t left = labels & (labels - 1); left != 0; left &= left - 1)
      if (body_[static_cast<std::size_t>(std::countr_zero(left))] != first) return kSeveral;
    return first;
  }

  void go_to(double t) { place_.set_share(ray_.origin + t * ray_.direction - corner_); }

  // The body that wins at t; `lead`: over the second.
  HWY_INLINE Bodies::Id body_at(double t, float* lead) {
    go_to(t);
    if (few_ != 0) {
      const float ahead = lead_of_few();
      *lead = std::abs(ahead);
      return ahead > 0 ? few_body_ : other_body_;
    }
    scores_ = Scores(*brick_, candidates_, place_);
    return best_body(lead);
  }

  // By how much a body is ahead of now_ at t.
  HWY_INLINE float lead_at(double t, Bodies::Id body) {
    go_to(t);
    if (few_ != 0) return body == few_body_ ? lead_of_few() : -lead_of_few();
    scores_ = Scores(*brick_, candidates_, place_);
    return score_of(body) - score_of(now_);
  }

  // Of two bodies whose scores add up, one says all.
  HWY_INLINE float lead_of_few() {
    const Scores scores(*brick_, few_, place_);
    float sum = 0;
    for (std::uint32_t left = few_; left != 0; left &= left - 1)
      sum += scores.of_label[static_cast<std::size_t>(std::countr_zero(left))];
    return 2 * sum - kScoreSteps;
  }

  float score_of(Bodies::Id body) const {
    float sum = 0;
    for (std::uint32_t left = candidates_; left != 0; left &= left - 1) {
      const auto l = static_cast<std::size_t>(std::countr_zero(left));
      if (body_[l] == body) sum += scores_.of_label[l];
    }
    return sum;
  }

  Bodies::Id best_body(float* lead) const {
    Bodies::Id best = 0;
    float most = -1;
    float second = -1;
    for (std::uint32_t left = candidates_; left != 0; left &= left - 1) {
      const Bodies::Id body = body_[static_cast<std::size_t>(std::countr_zero(left))];
      if (most >= 0 && body == best) continue;
      const float score = score_of(body);
      if (score > most) {
        second = most;
        most = score;
        best = body;
      } else {
        second = std::max(second, score);
      }
    }
    *lead = most - second;
    return best;
  }

  // The body's label that is ahead of its others at a place.
  Rank best_label(Bodies::Id body) const {
    std::uint32_t labels = 0;
    for (std::size_t l = 0; l < brick_->ranks.size(); ++l)
      if (body_[l] == body) labels |= 1U << l;
    if (labels == 0) return kNoLabel;
    if (std::has_single_bit(labels))
      return brick_->ranks[static_cast<std::size_t>(std::countr_zero(labels))];
    return brick_->ranks[best_of(Scores(*brick_, labels, place_), labels)];
  }

  // Where a body is made of several labels, too.
  void start_in_cell(double t, Rank* rank) {
    float lead = 0;
    const Bodies::Id first = body_at(t, &lead);
    start(first, best_label(first), rank);
  }

  // Of the part of the ray that lies in the cell. Where a body leads by much, nothing changes for a
  // while.
  void search(double begin, double end) {
    float lead = 0;
    const double least_step = (brick_->adds_up ? kStep : kStepInKept) / length_;
    double from = begin;
    while (from < end && !is_done_) {
      const double to = std::min(std::max(from + least_step, safe_until_), end);
      if (to < safe_until_) return;  // the whole cell
      const Bodies::Id body = body_at(to, &lead);
      safe_until_ = to;
      if (body != now_) {
        const float before = from == last_.t && few_ != 0 ? -last_.lead : lead_at(from, body);
        const float behind = few_ != 0 ? lead : lead_at(to, body);
        found(narrowed({from, before}, {to, behind}, body), body);
      } else if (brick_->adds_up) {
        safe_until_ += lead / (kScoreSteps * kSteepest * length_);
      }
      last_ = {to, lead};
      from = to;
    }
  }

  // How far a body is ahead somewhere along the ray.
  struct LeadAt {
    double t = 0;
    float lead = 0;
  };

  // Where both bodies are as far: at `from` now_ is ahead, at `to` the other.
  double narrowed(LeadAt from, LeadAt to, Bodies::Id body) {
    int side = 0;
    for (int i = 0; i < kMostNarrowings && (to.t - from.t) * length_ > kExact; ++i) {
      const float gap = to.lead - from.lead;
      const double share = gap > 0 ? std::clamp(-from.lead / gap, 0.0F, 1.0F) : 0.5;
      const double middle = from.t + share * (to.t - from.t);
      const float there = lead_at(middle, body);
      if (std::abs(there) < kExactLead) return middle;
      // Illinois: an end that stays counts half.
      if (there < 0) {
        from = {middle, there};
        if (side < 0) to.lead *= 0.5F;
        side = -1;
      } else {
        to = {middle, there};
        if (side > 0) from.lead *= 0.5F;
        side = 1;
      }
    }
    return 0.5 * (from.t + to.t);
  }

  void found(double t, Bodies::Id body) {
    go_to(t);
    LabelCrossing crossing{t, now_, body, kNoLabel, Vec3::Zero()};
    if (bodies_.all[body].is_shown || bodies_.all[now_].is_shown) {
      crossing.rank = best_label(bodies_.all[body].is_shown ? body : now_);
      for (std::uint32_t l = 0; l < brick_->ranks.size(); ++l) {
        const bool is_told = few_ == 0 || (few_ >> l & 1U) != 0;  // by the others
        const double sign = body_[l] == body ? 1 : body_[l] == now_ ? -1 : 0;
        if (!is_told || sign == 0) continue;
        crossing.into += sign * coarse_slope(*brick_, static_cast<int>(l), place_);
      }
    }
    cross(crossing);
  }

  const LabelGrid& grid_;
  const Bodies& bodies_;
  const LabelRay& ray_;
  const RaySlopes slopes_;
  std::vector<LabelCrossing>& crossings_;
  const std::array<int, 3> num_bricks_;
  const double length_;  // of the direction, samples for each unit of t

  bool has_started_ = false, is_done_ = false;
  LeadAt last_{-std::numeric_limits<double>::infinity(), 0};  // of now_, where it was taken last
  double safe_until_ = -std::numeric_limits<double>::infinity();  // now_ wins from here to there
  Bodies::Id start_ = 0, now_ = 0;
  const LabelBrick* brick_ = nullptr;
  Vec3 corner_ = Vec3::Zero();
  std::uint32_t candidates_ = 0;
  static constexpr Bodies::Id kSeveral = 0xFFFF;
  static constexpr std::size_t kKnownSets = 32;
  std::array<Bodies::Id, kKnownSets> body_of_set_{};  // of the brick's first sets of candidates
  std::uint32_t few_ = 0;  // 0: there are more than two bodies, or scores do not add up
  Bodies::Id few_body_ = 0, other_body_ = 0;
  std::array<Bodies::Id, kMostInBrick> body_{};
  PlaceInBrick place_{};
  Scores scores_;
};

inline Bodies::Id trace_on_target(const LabelGrid& grid, const Bodies& bodies, const LabelRay& ray,
                                  Rank* rank, std::vector<LabelCrossing>& crossings) {
  return Tracer(grid, bodies, ray, crossings).walk(rank);
}

inline Rank winner_on_target(const LabelGrid& grid, const Vec3& place) {
  const RaySlopes here({place, Vec3::UnitX(), 0, 0});
  const BoxWalk bricks(here, 0, Vec3::Constant(-1), kBrickEdge, bricks_along(grid));
  const auto [i, j, k] = bricks.box;
  const Rank only = grid.only_label(grid.brick_at(i, j, k));
  if (only != LabelGrid::kMixed) return only;
  const LabelBrick& brick = grid.brick(i, j, k);
  if (brick.ranks.size() == 1) return brick.ranks.front();
  const Vec3 corner = corner_of(bricks.box);
  const BoxWalk cells(here, 0, corner, 1, {kBrickEdge, kBrickEdge, kBrickEdge});
  PlaceInBrick at{};
  at.cell = cells.box;
  at.set_share(place - corner);
  const std::uint32_t candidates = brick.candidate_sets[brick.candidates[number_of(cells.box)]];
  return brick.ranks[best_of(Scores(brick, candidates, at), candidates)];
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::labels
HWY_AFTER_NAMESPACE();

#endif
