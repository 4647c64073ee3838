// SPDX-License-Identifier: Apache-2.0
#include "model/particles/particle_lengths.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>

#include "data/parallel.h"
#include "model/particles/kth_smallest.h"
#include "model/particles/nearest_squares.h"
#include "model/particles/periodic_images.h"
#include "model/particles/site_groups.h"
#include "model/team/team_run.h"

namespace ovoid::model {

namespace {

constexpr std::int64_t kGroupGrain = 128;

// The `wanted` smallest of the numbers it is given.
class Smallest {
 public:
  void start(std::size_t wanted) {
    wanted_ = wanted;
    count_ = 0;
    bound_ = std::numeric_limits<double>::infinity();
  }

  // Only smaller ones change the greatest of the wanted: as great a one leaves it as it is. (In a
  // heap of sites at one place all distances are equal; looking at each of them would cost the
  // square of their number.)
  double bound() const { return bound_; }
  static bool is_of_interest(double least, double bound) {
    return least < bound || bound == std::numeric_limits<double>::infinity();
  }

  // Adds number(i) for i from 0 to `count` - 1.
  template <class Number>
  void add(std::size_t count, const Number& number) {
    if (count_ > kSlack * wanted_) keep_wanted();
    if (numbers_.size() < count_ + count + 1) {
      numbers_.resize(2 * (count_ + count + 1));
      spare_.resize(numbers_.size());
    }
    // Without a branch: nobody can foresee which are small enough.
    double* to = numbers_.data() + count_;
    const double bound = bound_;
    for (std::size_t i = 0; i < count; ++i) {
      *to = number(i);
      to += *to <= bound ? 1 : 0;
    }
    count_ = static_cast<std::size_t>(to - numbers_.data());
  }

  // The greatest of the wanted, or of all if there are fewer; at least one was added.
  double greatest() {
    if (count_ >= wanted_) {
      keep_wanted();
      return bound_;
    }
    return *std::max_element(numbers_.begin(),
                             numbers_.begin() + static_cast<std::ptrdiff_t>(count_));
  }

 private:
  static constexpr std::size_t kSlack = 2;

  void keep_wanted() {
    bound_ = kth_smallest(std::span(numbers_).first(count_), wanted_, spare_);
    count_ = wanted_;
  }

  std::size_t wanted_ = 0, count_ = 0;
  double bound_ = 0;
  std::vector<double> numbers_, spare_;
};

// Searches around one group at a time for the neighbours of each of its sites.
class GroupSearch {
 public:
  GroupSearch(const SiteGroups& groups, const std::optional<Bounds3>& periodic_box, std::size_t k)
      : groups_(groups), periodic_box_(periodic_box), k_(std::min(k, groups.num_sites())) {}

  // Calls visit(site, square) with the squared distance of each site's k-th nearest, itself
  // counted.
  template <class Visit>
  void run(const SiteGroups::Group& group, const Visit& visit) {
    if (squares_.size() < group.sites.size()) squares_.resize(group.sites.size());
    for (std::size_t i = 0; i < group.sites.size(); ++i) squares_[i].start(k_);
    widest_ = std::numeric_limits<double>::infinity();
    add_image(group, Vec3::Zero());
    if (periodic_box_)
      for_each_image(*periodic_box_, group.box, std::sqrt(widest_),
                     [&](const Vec3& shift) { add_image(group, shift); });
    for (std::size_t i = 0; i < group.sites.size(); ++i)
      visit(group.sites[i], squares_[i].greatest());
  }

  std::int64_t num_pairs() const noexcept { return num_pairs_; }

 private:
  // The sites around the group as seen from a box shifted by `shift`.
  void add_image(const SiteGroups::Group& group, const Vec3& shift) {
    groups_.visit_near(
        group.box.translated(shift),
        [&](double square) { return Smallest::is_of_interest(square, widest_); },
        [&](const SiteGroups::Group& near) {
          widest_ = 0;
          for (std::size_t i = 0; i < group.sites.size(); ++i) {
            add_sites(group.sites[i].at + shift, near, squares_[i]);
            widest_ = std::max(widest_, squares_[i].bound());
          }
        });
  }

  void add_sites(const Vec3& at, const SiteGroups::Group& near, Smallest& squares) {
    if (!Smallest::is_of_interest(square_from(near.box, at), squares.bound())) return;
    num_pairs_ += static_cast<std::int64_t>(near.sites.size());
    squares.add(near.sites.size(),
                [&](std::size_t i) { return (near.sites[i].at - at).squaredNorm(); });
  }

  const SiteGroups& groups_;
  const std::optional<Bounds3>& periodic_box_;
  std::size_t k_;
  std::vector<Smallest> squares_;  // of distances, per site of the group
  double widest_ = 0;              // of their bounds
  std::int64_t num_pairs_ = 0;
};

// Each group's sites as offsets from the middle of its box.
std::vector<CandidateChunk> chunks_of(const SiteGroups& groups, const ModelRun& run) {
  static_assert(CandidateChunk::kRoom == SiteGroups::kMostInGroup);
  std::vector<CandidateChunk> chunks(groups.count());
  data::parallel_ranges(
      {static_cast<std::int64_t>(groups.count()), kGroupGrain, run.threads, run.stop},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto g = static_cast<std::size_t>(begin); g < static_cast<std::size_t>(end); ++g) {
          const SiteGroups::Group group = groups.group(g);
          const Vec3 center = group.box.center();
          chunks[g].count = static_cast<std::int32_t>(group.sites.size());
          for (std::size_t i = 0; i < group.sites.size(); ++i) {
            const Vec3 offset = group.sites[i].at - center;
            for (std::size_t a = 0; a < 3; ++a)
              chunks[g].places[a][i] = static_cast<float>(offset[static_cast<int>(a)]);
          }
        }
      });
  return chunks;
}

// The same in floats, many candidates at a time. What floats do not tell apart goes to GroupSearch.
class FastSearch {
 public:
  // `chunks`: chunks_of(groups).
  FastSearch(const SiteGroups& groups, std::span<const CandidateChunk> chunks,
             const std::optional<Bounds3>& periodic_box, std::size_t k)
      : groups_(groups),
        chunks_(chunks),
        periodic_box_(periodic_box),
        k_(std::min(k, groups.num_sites())),
        nearest_(k_),
        exact_(groups, periodic_box, k) {}

  template <class Visit>
  void run(const SiteGroups::Group& group, const Visit& visit) {
    center_ = group.box.center();
    unit_ = group.box.sizes().maxCoeff();
    if (!(unit_ > kLeastUnit && unit_ < kGreatestUnit)) return exact_.run(group, visit);
    nearest_.start();
    for (const SiteGroups::Site& site : group.sites) {
      const std::array<float, 3> at = place(site.at, Vec3::Zero());
      nearest_.add_site(at[0], at[1], at[2]);
    }
    greatest_ = 1;
    estimate(group);
    add_image(group, Vec3::Zero());
    if (periodic_box_)
      for_each_image(*periodic_box_, group.box, std::sqrt(widest_),
                     [&](const Vec3& shift) { add_image(group, shift); });
    flush(NearestSquares::Wanted::kLast);
    const float least = kLeastTrusted * greatest_;
    for (std::size_t i = 0; i < group.sites.size(); ++i) {
      const float square = nearest_.bound(i);
      if (square >= least * least && square < NearestSquares::kNoBound) {
        visit(group.sites[i], static_cast<double>(square) * unit_ * unit_);
      } else {
        exact_.run({Bounds3(group.sites[i].at), group.sites.subspan(i, 1)}, visit);
      }
    }
  }

  std::int64_t num_pairs() const noexcept { return num_pairs_ + exact_.num_pairs(); }

 private:
  // Squares of the units, and of floats in them, stay in range.
  static constexpr double kLeastUnit = 1e-30, kGreatestUnit = 1e30;
  // Floats err by 6e-8 of the greatest coordinate, and distances shorter than this part of it by
  // more than some 1e-5 of themselves.
  static constexpr float kLeastTrusted = 0.01F;

  std::array<float, 3> place(const Vec3& at, const Vec3& shift) const {
    const Vec3 scaled = ((at - shift) - center_) / unit_;
    constexpr double kFar = CandidateBatch::kFarAway;
    return {static_cast<float>(std::clamp(scaled[0], -kFar, kFar)),
            static_cast<float>(std::clamp(scaled[1], -kFar, kFar)),
            static_cast<float>(std::clamp(scaled[2], -kFar, kFar))};
  }

  void append(const SiteGroups::Group& near, const Vec3& shift) {
    batch_.append(chunks_[near.number], place(near.box.center(), shift),
                  static_cast<float>(1 / unit_), place(near.box.min(), shift),
                  place(near.box.max(), shift));
  }

  // Bounds, by a few groups around this one.
  void estimate(const SiteGroups::Group& group) {
    constexpr std::size_t kSlack = 3;
    widest_ = std::numeric_limits<double>::infinity();
    std::size_t count = 0;
    groups_.visit_near(
        group.box,
        [&](double) {
          return count < kSlack * k_ && batch_.num_chunks() < CandidateBatch::kMostChunks;
        },
        [&](const SiteGroups::Group& near) {
          append(near, Vec3::Zero());
          count += near.sites.size();
        });
    flush(NearestSquares::Wanted::kEstimate);
  }

  void add_image(const SiteGroups::Group& group, const Vec3& shift) {
    groups_.visit_near(
        group.box.translated(shift), [&](double square) { return square <= widest_; },
        [&](const SiteGroups::Group& near) {
          if (batch_.num_chunks() == CandidateBatch::kMostChunks)
            flush(NearestSquares::Wanted::kMoreToCome);
          append(near, shift);
        });
  }

  void flush(NearestSquares::Wanted wanted) {
    for (std::size_t c = 0; c < batch_.num_chunks(); ++c) {
      for (int a = 0; a < 3; ++a)
        greatest_ = std::max({greatest_, -batch_.lows[a][c], batch_.highs[a][c]});
    }
    num_pairs_ += nearest_.add(target_, batch_, wanted);
    batch_.clear();
    const float widest = nearest_.widest_bound();
    // Rounded up, for bounds are floats.
    if (widest < NearestSquares::kNoBound)
      widest_ = 1.0001 * static_cast<double>(widest) * unit_ * unit_;
  }

  const SiteGroups& groups_;
  std::span<const CandidateChunk> chunks_;
  const std::optional<Bounds3>& periodic_box_;
  std::size_t k_;
  simd::SimdTarget target_;
  NearestSquares nearest_;
  GroupSearch exact_;
  CandidateBatch batch_;
  Vec3 center_ = Vec3::Zero();
  double unit_ = 1;     // of the floats
  double widest_ = 0;   // square of the widest bound
  float greatest_ = 1;  // coordinate of a candidate
  std::int64_t num_pairs_ = 0;
};

// Second moments about the site itself of its neighbours, those no farther than the root of
// `square`, over h^2; the trace of a ball's worth is then about 2.4.
// Returns how many sites were looked at.
std::int64_t store_covariance(const SiteGroups& groups, const std::optional<Bounds3>& periodic_box,
                              const Vec3& at, double square, float* to) {
  if (square == 0) {  // all at one place, and perhaps very many
    std::fill_n(to, 6, 0.0F);
    return 0;
  }
  std::int64_t num_pairs = 0;
  Mat3 sum = Mat3::Zero();
  double count = 0;
  const auto add_image = [&](const Vec3& shift) {
    const Vec3 place = at + shift;
    groups.visit_near(
        Bounds3(place), [square](double from) { return from <= square; },
        [&](const SiteGroups::Group& near) {
          num_pairs += static_cast<std::int64_t>(near.sites.size());
          for (const SiteGroups::Site& site : near.sites) {
            const Vec3 offset = site.at - place;
            if (offset.squaredNorm() > square) continue;
            sum += offset * offset.transpose();
            ++count;
          }
        });
  };
  add_image(Vec3::Zero());
  if (periodic_box) for_each_image(*periodic_box, Bounds3(at), std::sqrt(square), add_image);
  sum *= 4 / (square * count);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column <= row; ++column) *to++ = static_cast<float>(sum(row, column));
  }
  return num_pairs;
}

}  // namespace

namespace {

// Calls visit(site, square) for the sites of all groups, on many threads; make() makes a search.
// Returns the number of pairs.
template <class Make, class Visit>
std::int64_t search_all(const ModelRun& run, const SiteGroups& groups, const Make& make,
                        const Visit& visit) {
  std::atomic<std::int64_t> num_pairs = 0;
  data::parallel_ranges(
      {static_cast<std::int64_t>(groups.count()), kGroupGrain, run.threads, run.stop},
      [&](std::int64_t begin, std::int64_t end) {
        const auto search = make();
        for (auto g = static_cast<std::size_t>(begin); g < static_cast<std::size_t>(end); ++g)
          search->run(groups.group(g), visit);
        num_pairs += search->num_pairs();
      });
  return num_pairs;
}

}  // namespace

NearestStatistics nearest_statistics(const ModelRun& run, std::span<const double> sites,
                                     const std::optional<Bounds3>& periodic_box,
                                     WithCovariances with) {
  NearestStatistics statistics;
  statistics.lengths.resize(sites.size() / 3);
  const SiteGroups groups(sites, run.threads, run.stop);
  const auto k = static_cast<std::size_t>(run.options.neighbors);
  const auto set_length = [&](const SiteGroups::Site& site, double square) {
    statistics.lengths[site.index] = static_cast<float>(std::sqrt(square) / 2);
  };
  if (with == WithCovariances::kNo) {
    const std::vector<CandidateChunk> chunks = chunks_of(groups, run);
    statistics.num_pairs = search_all(
        run, groups, [&] { return std::make_unique<FastSearch>(groups, chunks, periodic_box, k); },
        set_length);
    return statistics;
  }
  statistics.covariances.resize(6 * sites.size() / 3);
  std::atomic<std::int64_t> num_compared = 0;
  statistics.num_pairs = search_all(
      run, groups, [&] { return std::make_unique<GroupSearch>(groups, periodic_box, k); },
      [&](const SiteGroups::Site& site, double square) {
        set_length(site, square);
        num_compared +=
            store_covariance(groups, periodic_box, site.at, square,
                             statistics.covariances.data() + 6 * std::size_t{site.index});
      });
  statistics.num_pairs += num_compared;
  return statistics;
}

void raise_zero_lengths(const ModelRun& run, std::vector<float>& lengths) {
  float least = std::numeric_limits<float>::infinity();
  for (const float length : lengths) {
    if (length > 0) least = std::min(least, length);
  }
  least = least_of(run, least);
  if (!std::isfinite(least)) least = 1;
  for (float& length : lengths) {
    if (length > 0) continue;
    length = least;
    ++run.report.num_degenerate;
  }
}

}  // namespace ovoid::model
