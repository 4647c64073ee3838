// SPDX-License-Identifier: Apache-2.0
// From labels to the scores of one brick (docs/numerics.md, "Labels").
//
// In:  ranks of 28 x 28 x 28 samples around the brick.
// Out: for each label that can win in it, how much of it is around each sample (fine) and, more
//      widely, around every second (coarse); and which labels can win in which cell.
//
// Each label's indicator, 1 where it holds and 0 elsewhere, is smoothed along one axis after the
// other. Loops run along rows without a branch, so that compilers make them SIMD code for the
// target that this is compiled for.
#if defined(OVOID_LABELS_SMOOTH_BRICK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_LABELS_SMOOTH_BRICK_INL_H_
#undef OVOID_LABELS_SMOOTH_BRICK_INL_H_
#else
#define OVOID_LABELS_SMOOTH_BRICK_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

#include "labels/smooth_brick.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::labels {
namespace HWY_NAMESPACE {

// Boxes within the window, by their edges: scores before they meet the B-spline (kRaw), from which
// what wins at a sample (kWins) is known for all neighbours of the fine scores' samples.
inline constexpr int kFineReach = 2;
inline constexpr int kWinsEdge = kFineEdge + 2;
inline constexpr int kRawEdge = kWinsEdge + 2;
inline constexpr int kLabelsEdge = kRawEdge + 2 * kFineReach;
inline constexpr int kCoarseReach = 3;
inline constexpr int kHalfWindow = kWindowEdge / 2;
static_assert(kHalfWindow == kCoarseEdge + 2 * kCoarseReach);

// Widths of the Gaussians, samples: before the B-spline, whose own is 0.58. Fine scores say where a
// surface lies: structures of two samples stay. Coarse ones say which way it faces: the steps of a
// sphere of up to 60 samples turn their slope by 5 degrees at most.
inline constexpr double kFineSigma = 0.7;
inline constexpr double kCoarseSigma = 1.22;  // of two samples each: 2.5 samples with their means

// What a label is given where it would be lost: enough that a line as thin as a sample is seen.
inline constexpr std::uint8_t kKeptScore = 250;

template <int kReach>
std::array<float, 2 * kReach + 1> gaussian_weights(double sigma) {
  std::array<float, 2 * kReach + 1> weights{};
  double sum = 0;
  for (int i = -kReach; i <= kReach; ++i) sum += std::exp(-0.5 * i * i / (sigma * sigma));
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double x = static_cast<double>(i) - kReach;
    weights[i] = static_cast<float>(std::exp(-0.5 * x * x / (sigma * sigma)) / sum);
  }
  return weights;
}

// [kFrom]^3 to [kTo]^3: a weighted sum along each axis. `between`: memory for both steps.
template <int kFrom, int kTo>
void convolve(const float* from, const std::array<float, kFrom - kTo + 1>& weights, float* to,
              std::vector<float>& between) {
  constexpr int kTaps = kFrom - kTo + 1;
  between.resize(kFrom * kFrom * kTo + kFrom * kTo * kTo);
  float* const along_z = between.data();
  float* const along_zy = along_z + kFrom * kFrom * kTo;
  constexpr int kPlane = kFrom * kFrom;
  for (int z = 0; z < kTo; ++z) {
    float* const out = along_z + z * kPlane;
    const float* const in = from + z * kPlane;
    for (int i = 0; i < kPlane; ++i) out[i] = weights[0] * in[i];
    for (int t = 1; t < kTaps; ++t) {
      const float w = weights[static_cast<std::size_t>(t)];
      const float* const next = in + t * kPlane;
      for (int i = 0; i < kPlane; ++i) out[i] += w * next[i];
    }
  }
  for (int z = 0; z < kTo; ++z) {
    for (int y = 0; y < kTo; ++y) {
      float* const out = along_zy + (z * kTo + y) * kFrom;
      const float* const in = along_z + z * kPlane + y * kFrom;
      for (int x = 0; x < kFrom; ++x) {
        float sum = 0;
        for (int t = 0; t < kTaps; ++t)
          sum += weights[static_cast<std::size_t>(t)] * in[t * kFrom + x];
        out[x] = sum;
      }
    }
  }
  for (int row = 0; row < kTo * kTo; ++row) {
    const float* const in = along_zy + row * kFrom;
    float* const out = to + row * kTo;
    for (int x = 0; x < kTo; ++x) {
      float sum = 0;
      for (int t = 0; t < kTaps; ++t) sum += weights[static_cast<std::size_t>(t)] * in[x + t];
      out[x] = sum;
    }
  }
}

// The part of the window with that edge in its middle, where fine scores have theirs.
template <int kEdge>
constexpr int first_of() {
  return kBeforeBrick - 1 - (kEdge - kFineEdge) / 2;
}

// Labels in the window's part that fine scores are made of, the most frequent in the cells first.
inline std::vector<std::uint16_t> labels_around(const std::uint16_t* window, bool* is_complete) {
  std::vector<std::pair<std::uint16_t, int>> counts;
  constexpr int kFirst = first_of<kLabelsEdge>();
  constexpr int kLabelsInAll = kLabelsEdge * kLabelsEdge * kLabelsEdge;
  constexpr int kFirstNear = (kLabelsEdge - kBrickEdge - 1) / 2;
  const auto is_near = [](int i) { return i >= kFirstNear && i <= kFirstNear + kBrickEdge; };
  std::size_t at = 0;
  for (int z = 0; z < kLabelsEdge; ++z) {
    for (int y = 0; y < kLabelsEdge; ++y) {
      const std::uint16_t* const row =
          window + ((z + kFirst) * kWindowEdge + y + kFirst) * kWindowEdge + kFirst;
      for (int x = 0; x < kLabelsEdge; ++x) {
        if (at >= counts.size() || counts[at].first != row[x]) {
          at = 0;
          while (at < counts.size() && counts[at].first != row[x]) ++at;
          if (at == counts.size()) counts.emplace_back(row[x], 0);
        }
        counts[at].second += is_near(x) && is_near(y) && is_near(z) ? kLabelsInAll : 1;
      }
    }
  }
  std::sort(counts.begin(), counts.end(), [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first < b.first;
  });
  *is_complete = counts.size() <= kMostInBrick;
  if (!*is_complete) counts.resize(kMostInBrick);
  std::vector<std::uint16_t> labels;
  labels.reserve(counts.size());
  for (const auto& [rank, count] : counts) labels.push_back(rank);
  return labels;
}

// 1 where the label holds, 0 elsewhere.
template <int kEdge>
void indicate(const std::uint16_t* window, std::uint16_t rank, float* out) {
  constexpr int kFirst = first_of<kEdge>();
  for (int z = 0; z < kEdge; ++z) {
    for (int y = 0; y < kEdge; ++y) {
      const std::uint16_t* const row =
          window + ((z + kFirst) * kWindowEdge + y + kFirst) * kWindowEdge + kFirst;
      float* const to = out + (z * kEdge + y) * kEdge;
      for (int x = 0; x < kEdge; ++x) to[x] = row[x] == rank ? 1.0F : 0.0F;
    }
  }
}

// Shares of the label in two samples along each axis.
inline void indicate_halves(const std::uint16_t* window, std::uint16_t rank, float* out) {
  std::array<std::uint8_t, kWindowEdge> sums{};
  for (int z = 0; z < kHalfWindow; ++z) {
    for (int y = 0; y < kHalfWindow; ++y) {
      const std::uint16_t* const row = window + (2 * z * kWindowEdge + 2 * y) * kWindowEdge;
      constexpr int kPlane = kWindowEdge * kWindowEdge;
      for (int x = 0; x < kWindowEdge; ++x) {
        const int sum = (row[x] == rank) + (row[kWindowEdge + x] == rank) +
                        (row[kPlane + x] == rank) + (row[kPlane + kWindowEdge + x] == rank);
        sums[static_cast<std::size_t>(x)] = static_cast<std::uint8_t>(sum);
      }
      float* const to = out + (z * kHalfWindow + y) * kHalfWindow;
      for (std::size_t x = 0; x < kHalfWindow; ++x)
        to[x] = 0.125F * static_cast<float>(sums[2 * x] + sums[2 * x + 1]);
    }
  }
}

inline std::uint8_t stored_score(float score) {
  constexpr float kHalf = 0.5F;  // rounds, as no score is negative
  return static_cast<std::uint8_t>(score * kScoreSteps + kHalf);
}

// Which samples would lose their label: it wins neither there nor at any neighbour that has it.
class LostSamples {
 public:
  // `raw`: [labels][kRawEdge]^3.
  LostSamples(const std::uint16_t* window, const std::vector<std::uint16_t>& labels,
              const std::vector<std::vector<float>>& raw, std::vector<float>& between) {
    constexpr int kNum = kWinsEdge * kWinsEdge * kWinsEdge;
    static constexpr std::array<float, 3> kSpline{1.0F / 6, 4.0F / 6, 1.0F / 6};
    std::vector<float> best(kNum, -1.0F);
    std::vector<float> score(kNum);
    std::vector<std::uint16_t> winner(kNum, labels.front());
    for (std::size_t l = 0; l < labels.size(); ++l) {
      convolve<kRawEdge, kWinsEdge>(raw[l].data(), kSpline, score.data(), between);
      for (int i = 0; i < kNum; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const bool wins = score[at] > best[at];
        best[at] = wins ? score[at] : best[at];
        winner[at] = wins ? labels[l] : winner[at];
      }
    }
    constexpr int kFirst = first_of<kWinsEdge>();
    for (int z = 0; z < kWinsEdge; ++z) {
      for (int y = 0; y < kWinsEdge; ++y) {
        for (int x = 0; x < kWinsEdge; ++x) {
          const std::size_t at = place(x - 1, y - 1, z - 1);
          own_[at] = window[((z + kFirst) * kWindowEdge + y + kFirst) * kWindowEdge + x + kFirst];
          wins_[at] = winner[at] == own_[at] ? 1 : 0;
        }
      }
    }
  }

  // Of the fine scores' sample.
  bool is_lost(int x, int y, int z) const {
    const std::size_t at = place(x, y, z);
    if (wins_[at] != 0) return false;
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const std::size_t other = place(x + dx, y + dy, z + dz);
          if (wins_[other] != 0 && own_[other] == own_[at]) return false;
        }
      }
    }
    return true;
  }
  std::uint16_t own(int x, int y, int z) const { return own_[place(x, y, z)]; }

 private:
  static std::size_t place(int x, int y, int z) {
    const int at = ((z + 1) * kWinsEdge + y + 1) * kWinsEdge + x + 1;
    return static_cast<std::size_t>(at);
  }

  std::array<std::uint16_t, kWinsEdge * kWinsEdge * kWinsEdge> own_{};
  std::array<std::uint8_t, kWinsEdge * kWinsEdge * kWinsEdge> wins_{};
};

// The least and greatest of a label's scores that reach each cell.
struct CellScores {
  std::array<std::uint8_t, kNumCells> least, greatest;
};

inline CellScores scores_of_cells(const std::uint8_t* fine) {
  // Along x, then y, then z: four in a row each time.
  std::array<std::uint8_t, kFineEdge * kFineEdge * kBrickEdge> lo, hi;
  for (int row = 0; row < kFineEdge * kFineEdge; ++row) {
    const std::uint8_t* const in = fine + row * kFineEdge;
    std::uint8_t* const least = lo.data() + row * kBrickEdge;
    std::uint8_t* const most = hi.data() + row * kBrickEdge;
    for (int x = 0; x < kBrickEdge; ++x) {
      least[x] = std::min(std::min(in[x], in[x + 1]), std::min(in[x + 2], in[x + 3]));
      most[x] = std::max(std::max(in[x], in[x + 1]), std::max(in[x + 2], in[x + 3]));
    }
  }
  std::array<std::uint8_t, kFineEdge * kBrickEdge * kBrickEdge> lo2, hi2;
  const auto fold = [](const std::uint8_t* in, int stride, auto pick, std::uint8_t* out) {
    for (int x = 0; x < kBrickEdge; ++x) {
      out[x] = pick(pick(in[x], in[x + stride]), pick(in[x + 2 * stride], in[x + 3 * stride]));
    }
  };
  const auto least = [](std::uint8_t a, std::uint8_t b) { return std::min(a, b); };
  const auto most = [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); };
  for (int z = 0; z < kFineEdge; ++z) {
    for (int y = 0; y < kBrickEdge; ++y) {
      const int in = (z * kFineEdge + y) * kBrickEdge;
      const int out = (z * kBrickEdge + y) * kBrickEdge;
      fold(lo.data() + in, kBrickEdge, least, lo2.data() + out);
      fold(hi.data() + in, kBrickEdge, most, hi2.data() + out);
    }
  }
  CellScores cells;
  constexpr int kPlane = kBrickEdge * kBrickEdge;
  for (int row = 0; row < kPlane; ++row) {
    const int at = row * kBrickEdge;
    fold(lo2.data() + at, kPlane, least, cells.least.data() + at);
    fold(hi2.data() + at, kPlane, most, cells.greatest.data() + at);
  }
  return cells;
}

// Label l can win in a cell, since no other is greater everywhere in it.
inline void set_candidates(const std::vector<std::uint8_t>& fine, std::size_t num_labels,
                           LabelBrick* brick) {
  std::vector<CellScores> cells;
  for (std::size_t l = 0; l < num_labels; ++l)
    cells.push_back(scores_of_cells(fine.data() + l * kNumFine));
  std::vector<std::uint32_t>& sets = brick->candidate_sets;
  std::size_t last = 0;
  for (std::size_t c = 0; c < kNumCells; ++c) {
    std::uint32_t bits = 0;
    std::uint8_t best = 0;
    std::size_t of = 0;
    for (std::size_t l = 0; l < num_labels; ++l) {
      if (cells[l].least[c] < best || (l > 0 && cells[l].least[c] == best)) continue;
      best = cells[l].least[c];
      of = l;
    }
    for (std::size_t l = 0; l < num_labels; ++l) {
      if (l == of || cells[l].greatest[c] > best) bits |= 1U << l;
    }
    if (last >= sets.size() || sets[last] != bits) {
      last = static_cast<std::size_t>(std::find(sets.begin(), sets.end(), bits) - sets.begin());
      if (last == sets.size()) sets.push_back(bits);
      if (last >= kMostSets) {
        last = kMostSets - 1;
        sets.resize(kMostSets);
        sets[last] = num_labels == 32 ? ~0U : (1U << num_labels) - 1U;
      }
    }
    brick->candidates.push_back(static_cast<std::uint8_t>(last));
  }
}

inline LabelBrick smoothed_on_target(const std::uint16_t* window) {
  LabelBrick brick;
  bool is_complete = false;
  std::vector<std::uint16_t> labels = labels_around(window, &is_complete);
  if (labels.size() == 1) {
    brick.ranks = std::move(labels);
    return brick;
  }
  static const auto kFineWeights = gaussian_weights<kFineReach>(kFineSigma);
  static const auto kCoarseWeights = gaussian_weights<kCoarseReach>(kCoarseSigma);
  constexpr int kNumRaw = kRawEdge * kRawEdge * kRawEdge;
  std::vector<float> between;
  std::vector<float> indicator(kLabelsEdge * kLabelsEdge * kLabelsEdge);
  std::vector<std::vector<float>> raw(labels.size());
  for (std::size_t l = 0; l < labels.size(); ++l) {
    raw[l].resize(kNumRaw);
    indicate<kLabelsEdge>(window, labels[l], indicator.data());
    convolve<kLabelsEdge, kRawEdge>(indicator.data(), kFineWeights, raw[l].data(), between);
  }
  const LostSamples lost(window, labels, raw, between);
  brick.adds_up = is_complete;
  std::vector<std::uint8_t> fine(labels.size() * kNumFine);
  for (std::size_t l = 0; l < labels.size(); ++l) {
    constexpr int kIn = (kRawEdge - kFineEdge) / 2;
    std::uint8_t* out = fine.data() + l * kNumFine;
    for (int z = 0; z < kFineEdge; ++z) {
      for (int y = 0; y < kFineEdge; ++y, out += kFineEdge) {
        const float* const in = raw[l].data() + ((z + kIn) * kRawEdge + y + kIn) * kRawEdge + kIn;
        for (int x = 0; x < kFineEdge; ++x) out[x] = stored_score(in[x]);
      }
    }
  }
  for (int z = 0, i = 0; z < kFineEdge; ++z) {
    for (int y = 0; y < kFineEdge; ++y) {
      for (int x = 0; x < kFineEdge; ++x, ++i) {
        if (!lost.is_lost(x, y, z)) continue;
        brick.adds_up = false;
        for (std::size_t l = 0; l < labels.size(); ++l)
          fine[l * kNumFine + static_cast<std::size_t>(i)] =
              labels[l] == lost.own(x, y, z) ? kKeptScore : 0;
      }
    }
  }
  set_candidates(fine, labels.size(), &brick);
  if (brick.candidate_sets.size() == 1 && std::has_single_bit(brick.candidate_sets.front())) {
    const int only = std::countr_zero(brick.candidate_sets.front());
    LabelBrick alone;
    alone.ranks = {labels[static_cast<std::size_t>(only)]};
    return alone;
  }
  constexpr int kNumHalf = kHalfWindow * kHalfWindow * kHalfWindow;
  std::vector<float> halves(kNumHalf);
  std::array<float, kNumCoarse> smooth;
  for (const std::uint16_t label : labels) {
    indicate_halves(window, label, halves.data());
    convolve<kHalfWindow, kCoarseEdge>(halves.data(), kCoarseWeights, smooth.data(), between);
    for (const float score : smooth) brick.coarse.push_back(stored_score(score));
  }
  brick.fine = std::move(fine);
  brick.fine.resize(brick.fine.size() + 3);
  brick.ranks = std::move(labels);
  return brick;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::labels
HWY_AFTER_NAMESPACE();

#endif
