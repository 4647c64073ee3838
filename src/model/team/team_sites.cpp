// SPDX-License-Identifier: Apache-2.0
#include "model/team/team_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "data/kernels/kernel_bricks.h"
#include "data/kernels/letters.h"
#include "data/parallel.h"
#include "model/particles/particle_lengths.h"
#include "model/particles/periodic_images.h"
#include "model/particles/site_groups.h"
#include "model/team/team_run.h"
#include "model/team/territory.h"
#include "ovoid/kernel_team.h"

namespace ovoid::model {
namespace {

Vec3 site(std::span<const double> centers, std::size_t i) {
  return {centers[3 * i], centers[3 * i + 1], centers[3 * i + 2]};
}

// Of those that have a finite place.
Bounds3 bounds_of_all(const ModelRun& run, std::span<const double> centers) {
  Bounds3 bounds;
  for (std::size_t i = 0; i < centers.size() / 3; ++i) {
    if (site(centers, i).allFinite()) bounds.extend(site(centers, i));
  }
  for (const Bounds3& theirs : joined(run, std::vector<Bounds3>{bounds})) bounds.extend(theirs);
  return bounds;
}

// Where on the curve the stretch of each process but the first begins: quantiles of some keys of
// all, each of which stands for as many rows.
std::vector<std::uint64_t> stretches(const ModelRun& run, std::span<const std::uint64_t> keys) {
  constexpr std::int64_t kMostSamples = 1 << 16;
  const auto num_all = total_of(run, static_cast<std::int64_t>(keys.size()));
  const auto every = static_cast<std::size_t>(std::max<std::int64_t>(1, num_all / kMostSamples));
  std::vector<std::uint64_t> some;
  some.reserve(keys.size() / every + 1);
  for (std::size_t i = 0; i < keys.size(); i += every) some.push_back(keys[i]);
  some = joined(run, std::move(some));
  std::sort(some.begin(), some.end());
  std::vector<std::uint64_t> begins;
  const auto count = static_cast<std::size_t>(run.team->count());
  for (std::size_t p = 1; p < count; ++p)
    begins.push_back(some.empty() ? 0 : some[p * some.size() / count]);
  return begins;
}

}  // namespace

SpaceShares::SpaceShares(const ModelRun& run, std::span<const double> sites)
    : cube_(data::MortonCube::around(bounds_of_all(run, sites))), owners_(sites.size() / 3) {
  std::vector<std::uint64_t> keys(owners_.size());
  data::parallel_ranges({static_cast<std::int64_t>(keys.size()), kSiteGrain, run.threads, run.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (auto i = static_cast<std::size_t>(begin);
                               i < static_cast<std::size_t>(end); ++i)
                            keys[i] = key_of(site(sites, i));
                        });
  begins_ = stretches(run, keys);
  for (std::size_t i = 0; i < keys.size(); ++i) owners_[i] = owner_of_key(keys[i]);
}

std::uint64_t SpaceShares::key_of(const Vec3& place) const {
  return cube_ && place.allFinite() ? cube_->key_of(place) : 0;
}

int SpaceShares::owner_of_key(std::uint64_t key) const {
  return static_cast<int>(std::upper_bound(begins_.begin(), begins_.end(), key) - begins_.begin());
}

SiteRows share_by_place(const ModelRun& run, SiteRows rows) {
  std::vector<std::vector<std::uint32_t>> lists(static_cast<std::size_t>(run.team->count()));
  {
    const SpaceShares shares(run, rows.centers);
    for (std::uint32_t i = 0; i < rows.count(); ++i)
      lists[static_cast<std::size_t>(shares.owners()[i])].push_back(i);
  }
  const std::size_t num_edges = greatest_of(run, rows.edges.empty() ? 0 : 1) > 0 ? 3 : 0;
  const std::size_t row_bytes = sizeof(std::uint64_t) + (3 + num_edges) * sizeof(double) +
                                rows.columns.size() * sizeof(float);
  KernelTeam::Letters letters = data::letters_of(lists, row_bytes);
  data::append_rows(letters, lists, 1, rows.orders);
  data::append_rows(letters, lists, 3, rows.centers);
  data::append_rows(letters, lists, num_edges, rows.edges);
  for (std::vector<float>& column : rows.columns) data::append_rows(letters, lists, 1, column);
  KernelTeam::Letters received = run.team->exchange(std::move(letters));
  SiteRows own;
  own.columns.resize(rows.columns.size());
  std::size_t num_rows = 0;
  for (const data::Letter& letter : received) num_rows += letter.size() / row_bytes;
  own.orders.reserve(num_rows);
  own.centers.reserve(3 * num_rows);
  own.edges.reserve(num_edges * num_rows);
  for (std::vector<float>& column : own.columns) column.reserve(num_rows);
  // Shares are in the order of the processes, and so are orders.
  for (data::Letter& letter : received) {
    const std::size_t count = letter.size() / row_bytes;
    data::LetterReader reader(letter);
    reader.take(count, own.orders);
    reader.take(3 * count, own.centers);
    reader.take(num_edges * count, own.edges);
    for (std::vector<float>& column : own.columns) reader.take(count, column);
    letter = {};
  }
  return own;
}

namespace {

struct Question {
  Vec3 at;
  double square;  // no farther than its root
};

// Distances of sites, squared: the `wanted` least of those that are not greater than the bound.
void add_near(const SiteGroups& groups, const std::optional<Bounds3>& periodic_box,
              const Question& question, std::size_t wanted, std::vector<double>& squares) {
  const std::size_t before = squares.size();
  double bound = question.square;
  const auto keep_wanted = [&] {
    const auto first = squares.begin() + static_cast<std::ptrdiff_t>(before);
    const auto last = first + static_cast<std::ptrdiff_t>(wanted);
    if (last >= squares.end()) return;
    std::nth_element(first, last - 1, squares.end());
    bound = *(last - 1);
    squares.erase(last, squares.end());
  };
  const auto add_image = [&](const Vec3& shift) {
    const Vec3 place = question.at + shift;
    groups.visit_near(
        Bounds3(place), [&](double square) { return square <= bound; },
        [&](const SiteGroups::Group& near) {
          for (const SiteGroups::Site& one : near.sites) {
            const double square = (one.at - place).squaredNorm();
            if (square <= bound) squares.push_back(square);
          }
          if (squares.size() - before > 2 * wanted) keep_wanted();
        });
  };
  add_image(Vec3::Zero());
  if (periodic_box)
    for_each_image(*periodic_box, Bounds3(question.at), std::sqrt(bound), add_image);
  keep_wanted();
}

bool is_within(const Territory& territory, const std::optional<Bounds3>& periodic_box,
               const Bounds3& box, double square) {
  bool is = territory.is_within(box, square);
  if (!is && periodic_box)
    for_each_image(*periodic_box, box, std::sqrt(square), [&](const Vec3& shift) {
      is = is || territory.is_within(box.translated(shift), square);
    });
  return is;
}

// A site of whose neighbours another process may have some.
struct Asked {
  std::uint32_t site;
  std::int32_t process;
};

// By site.
std::vector<Asked> find_asked(const ModelRun& run, const SiteGroups& groups,
                              std::span<const Territory> territories,
                              const std::optional<Bounds3>& periodic_box,
                              std::span<const double> bounds) {
  std::vector<Asked> asked;
  for (std::size_t g = 0; g < groups.count(); ++g) {
    const SiteGroups::Group group = groups.group(g);
    double widest = 0;
    for (const SiteGroups::Site& one : group.sites) widest = std::max(widest, bounds[one.index]);
    for (int p = 0; p < run.team->count(); ++p) {
      const Territory& territory = territories[static_cast<std::size_t>(p)];
      if (p == run.team->number() || widest == 0 || group.sites.empty() ||
          !is_within(territory, periodic_box, group.box, widest))
        continue;
      for (const SiteGroups::Site& one : group.sites) {
        const double square = bounds[one.index];
        // Where all wanted ones are at one place, none is nearer.
        if (square > 0 && is_within(territory, periodic_box, Bounds3(one.at), square))
          asked.push_back({one.index, p});
      }
    }
  }
  std::sort(asked.begin(), asked.end(), [](const Asked& a, const Asked& b) {
    return std::pair(a.site, a.process) < std::pair(b.site, b.process);
  });
  return asked;
}

// To a letter of questions: how many squares for each, then all squares.
data::Letter answered(const ModelRun& run, const SiteGroups* groups,
                      const std::optional<Bounds3>& periodic_box, std::size_t wanted,
                      const data::Letter& letter) {
  std::vector<Question> questions;
  data::LetterReader(letter).take(letter.size() / sizeof(Question), questions);
  std::vector<std::vector<double>> squares(questions.size());
  data::parallel_ranges({static_cast<std::int64_t>(groups == nullptr ? 0 : questions.size()), 256,
                         run.threads, run.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (auto q = static_cast<std::size_t>(begin);
                               q < static_cast<std::size_t>(end); ++q)
                            add_near(*groups, periodic_box, questions[q], wanted, squares[q]);
                        });
  std::vector<std::uint32_t> counts;
  counts.reserve(squares.size());
  std::vector<double> all;
  for (const std::vector<double>& some : squares) {
    counts.push_back(static_cast<std::uint32_t>(some.size()));
    all.insert(all.end(), some.begin(), some.end());
  }
  data::Letter answer;
  data::append(answer, std::span<const std::uint32_t>(counts));
  data::append(answer, std::span<const double>(all));
  return answer;
}

// What lies near the sites of a process, here and elsewhere.
class NeighborSearch {
 public:
  NeighborSearch(const ModelRun& run, std::span<const double> sites, std::int64_t num_all,
                 const std::optional<Bounds3>& periodic_box)
      : run_(run),
        sites_(sites),
        periodic_box_(periodic_box),
        wanted_(static_cast<std::size_t>(std::min<std::int64_t>(run.options.neighbors, num_all))),
        bounds_(sites.size() / 3, std::numeric_limits<double>::infinity()) {}

  std::vector<float> lengths() && {
    if (!sites_.empty()) {
      lengths_ = nearest_statistics(run_, sites_, periodic_box_, WithCovariances::kNo).lengths;
      groups_.emplace(sites_, run_.threads, run_.stop);
    }
    // Own neighbours alone are no nearer than the nearest of all.
    constexpr double kRounding = 1.0001;
    for (std::size_t i = 0; bounds_.size() >= wanted_ && i < bounds_.size(); ++i)
      bounds_[i] = kRounding * std::pow(2 * static_cast<double>(lengths_[i]), 2);
    const std::vector<Asked> asked = asked_of_all();
    // In rounds, so that questions and answers take little memory.
    std::size_t next = 0;
    while (least_of(run_, next < asked.size() ? -1 : 0) < 0) {
      std::size_t end = std::min(next + kMostInRound, asked.size());
      while (end < asked.size() && asked[end].site == asked[end - 1].site) ++end;
      ask(std::span(asked).subspan(next, end - next));
      next = end;
    }
    return std::move(lengths_);
  }

 private:
  static constexpr std::size_t kMostInRound = 8192;  // some 2 MB of answers

  std::vector<Asked> asked_of_all() const {
    const std::vector<Territory> territories =
        territories_of_all(run_, groups_ ? territory_of(*groups_) : Territory());
    if (!groups_) return {};
    return find_asked(run_, *groups_, territories, periodic_box_, bounds_);
  }

  // One round: whole sites.
  void ask(std::span<const Asked> asked) {
    KernelTeam::Letters letters(static_cast<std::size_t>(run_.team->count()));
    for (const auto& [number, process] : asked) {
      const Question question{site(sites_, number), bounds_[number]};
      data::append(letters[static_cast<std::size_t>(process)],
                   std::span<const Question>(&question, 1));
    }
    letters = run_.team->exchange(std::move(letters));
    for (data::Letter& letter : letters)
      letter = answered(run_, groups_ ? &*groups_ : nullptr, periodic_box_, wanted_, letter);
    letters = run_.team->exchange(std::move(letters));
    std::vector<data::LetterReader> readers;
    std::vector<std::vector<std::uint32_t>> counts(letters.size());
    for (std::size_t p = 0; p < letters.size(); ++p) {
      const auto num_questions = std::count_if(asked.begin(), asked.end(), [&](const Asked& one) {
        return static_cast<std::size_t>(one.process) == p;
      });
      readers.emplace_back(letters[p]).take(static_cast<std::size_t>(num_questions), counts[p]);
    }
    std::vector<std::size_t> next(letters.size(), 0);  // question of each process
    std::vector<double> squares;
    for (std::size_t i = 0; i < asked.size();) {
      const std::size_t number = asked[i].site;
      squares.clear();
      for (; i < asked.size() && asked[i].site == number; ++i) {
        const auto p = static_cast<std::size_t>(asked[i].process);
        readers[p].take(counts[p][next[p]++], squares);
      }
      if (squares.empty()) continue;
      add_near(*groups_, periodic_box_, {site(sites_, number), bounds_[number]}, wanted_, squares);
      const auto last = squares.begin() + static_cast<std::ptrdiff_t>(wanted_ - 1);
      std::nth_element(squares.begin(), last, squares.end());
      lengths_[number] = static_cast<float>(std::sqrt(*last) / 2);
    }
  }

  const ModelRun& run_;
  std::span<const double> sites_;
  const std::optional<Bounds3>& periodic_box_;
  std::size_t wanted_;
  std::vector<double> bounds_;  // squares of distances beyond which no neighbour is wanted
  std::vector<float> lengths_;
  std::optional<SiteGroups> groups_;
};

}  // namespace

std::vector<float> team_lengths(const ModelRun& run, std::span<const double> sites,
                                std::int64_t num_all, const std::optional<Bounds3>& periodic_box) {
  return NeighborSearch(run, sites, num_all, periodic_box).lengths();
}

}  // namespace ovoid::model
