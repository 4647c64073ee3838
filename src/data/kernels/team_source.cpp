// SPDX-License-Identifier: Apache-2.0
#include "data/kernels/team_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>
#include <vector>

#include "data/kernels/kernel_shape.h"
#include "data/kernels/letters.h"
#include "data/lattice/merged_range.h"
#include "data/lattice/page_cache.h"
#include "ovoid/error.h"

namespace ovoid::data {
namespace {

// Bricks are fetched by pages of at least so many kernels, some 60 kB, which neighbours in space
// are on.
constexpr std::int64_t kPageKernels = 2048;

// The bricks of all, and who has which.
struct Layout {
  std::vector<KernelBrick> bricks;
  std::vector<std::int64_t> owners;  // the first brick of each process, and their number
  std::vector<std::int64_t> pages;   // the first brick of each page, and their number
  std::int64_t num_kernels = 0;

  void add_bricks_of_next(const std::vector<KernelBrick>& more) {
    owners.push_back(static_cast<std::int64_t>(bricks.size()));
    std::int64_t on_page = kPageKernels;
    for (const KernelBrick& brick : more) {
      if (on_page >= kPageKernels) {
        pages.push_back(static_cast<std::int64_t>(bricks.size()));
        on_page = 0;
      }
      on_page += brick.count;
      num_kernels += brick.count;
      bricks.push_back(brick);
    }
  }
  void end() {
    owners.push_back(static_cast<std::int64_t>(bricks.size()));
    pages.push_back(static_cast<std::int64_t>(bricks.size()));
  }
  // Of a list of firsts the one that a brick is of.
  static std::int64_t place_in(const std::vector<std::int64_t>& firsts, std::int64_t brick) {
    return std::upper_bound(firsts.begin(), firsts.end(), brick) - firsts.begin() - 1;
  }
  std::int64_t first_of_page(std::int64_t page) const {
    return pages[static_cast<std::size_t>(page)];
  }
  std::int64_t kernels_before(std::int64_t from, std::int64_t brick) const {
    std::int64_t count = 0;
    for (std::int64_t b = from; b < brick; ++b) count += bricks[static_cast<std::size_t>(b)].count;
    return count;
  }
};

// Some of the kernels of a process: of its bricks [begin, end) every `stride`-th, from one of the
// first brick on.
struct Chosen {
  std::int64_t begin = 0, end = 0;
  std::int64_t first = 0;
  std::int64_t stride = 1;
};

// Runs `body(brick, first)` for the bricks that have kernels among those: `first` is the first.
template <class Body>
void for_bricks_of(const Layout& layout, const Chosen& chosen, const Body& body) {
  std::int64_t next = chosen.first;
  for (std::int64_t b = chosen.begin; b < chosen.end; ++b) {
    const std::int64_t count = layout.bricks[static_cast<std::size_t>(b)].count;
    if (next < count) {
      body(b, next);
      next += (count - next + chosen.stride - 1) / chosen.stride * chosen.stride;
    }
    next -= count;
  }
}

std::int64_t count_in(std::int64_t in_brick, std::int64_t first, std::int64_t stride) {
  return (in_brick - first + stride - 1) / stride;
}

// All that process `owner` has of every `stride`-th kernel of all.
Chosen every_of(const Layout& layout, std::int64_t owner, std::int64_t stride) {
  const std::int64_t begin = layout.owners[static_cast<std::size_t>(owner)];
  const std::int64_t before = layout.kernels_before(0, begin);
  return {begin, layout.owners[static_cast<std::size_t>(owner) + 1],
          (stride - before % stride) % stride, stride};
}

Chosen page_of(const Layout& layout, std::int64_t page) {
  return {layout.first_of_page(page), layout.first_of_page(page + 1)};
}

// Kernels on their way: columns of floats, one for each coordinate, shape number, the weight and
// each value, of all of them.
Letter written(const KernelSource& own, const Layout& layout, std::int64_t first_own,
               const Chosen& chosen) {
  std::size_t count = 0;
  for_bricks_of(layout, chosen, [&](std::int64_t b, std::int64_t first) {
    count += static_cast<std::size_t>(
        count_in(layout.bricks[static_cast<std::size_t>(b)].count, first, chosen.stride));
  });
  const auto num_shapes = static_cast<std::size_t>(num_shape_numbers(own.shape()));
  const std::size_t num_values = own.attributes().size();
  const std::size_t num_columns = 3 + num_shapes + 1 + num_values;
  std::vector<float> columns(num_columns * count);
  std::size_t to = 0;
  for_bricks_of(layout, chosen, [&](std::int64_t b, std::int64_t first) {
    const KernelView view = own.acquire(b - first_own, 0.0);
    for (std::int64_t k = first; k < view.count; k += chosen.stride, ++to) {
      const auto i = static_cast<std::int32_t>(k);
      const std::array<float, 6> shape = shape_numbers(view, own.shape(), i);
      float* at = columns.data() + to;
      const auto put = [&](float number) {
        *at = number;
        at += count;
      };
      for (const float* const center : view.center) put(center[i]);
      for (std::size_t c = 0; c < num_shapes; ++c) put(shape[c]);
      put(weight_of(view, i));
      for (std::size_t a = 0; a < num_values; ++a) put(view.value[a][i]);
    }
  });
  Letter letter;
  append(letter, std::span<const float>(columns));
  return letter;
}

// Such columns read.
struct Columns {
  KernelShape shape = KernelShape::kBalls;
  std::size_t num_values = 0;

  std::size_t number() const noexcept {
    return 3 + static_cast<std::size_t>(num_shape_numbers(shape)) + 1 + num_values;
  }
  void check(const Letter& letter, std::size_t num_kernels, std::int64_t sender) const {
    const std::size_t expected = number() * num_kernels * sizeof(float);
    if (letter.size() == expected) return;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("process {} of the team has sent {} bytes of kernels, expected {}",
                            sender, letter.size(), expected));
  }
  // `count` kernels from number `first` on, of `num_kernels` in all.
  KernelView view(std::shared_ptr<const Letter> letter, std::size_t num_kernels, std::int64_t first,
                  std::int32_t count) const {
    // From operator new: aligned for floats.
    const float* column = reinterpret_cast<const float*>(letter->data()) + first;
    const auto next = [&] { return std::exchange(column, column + num_kernels); };
    KernelView view;
    view.count = count;
    for (const float*& center : view.center) center = next();
    for (int c = 0; c < num_shape_numbers(shape); ++c)
      view.shape[static_cast<std::size_t>(c)] = next();
    view.weight = next();
    for (std::size_t a = 0; a < num_values; ++a) view.value[a] = next();
    view.pin = std::move(letter);
    return view;
  }
};

// Every so many-th kernel of all, in memory.
class ChosenKernels final : public KernelSource {
 public:
  ChosenKernels(const TeamSet& set, Columns columns) : set_(set), columns_(columns) {}

  void add(const KernelBrick& brick, std::int64_t count, std::size_t letter, std::int64_t first) {
    bricks_.push_back(brick);
    bricks_.back().count = static_cast<std::int32_t>(count);
    places_.push_back({letter, first});
    num_kernels_ += count;
  }
  std::size_t add(Letter letter, std::size_t num_kernels) {
    letters_.push_back({std::make_shared<const Letter>(std::move(letter)), num_kernels});
    return letters_.size() - 1;
  }

  KernelShape shape() const noexcept override { return set_.shape; }
  KernelProfile profile() const noexcept override { return set_.profile; }
  double cutoff() const noexcept override { return set_.cutoff; }
  std::span<const KernelAttribute> attributes() const noexcept override { return set_.attributes; }
  std::int64_t num_kernels() const noexcept override { return num_kernels_; }
  std::int64_t num_bricks() const noexcept override { return std::ssize(bricks_); }
  const KernelBrick& brick(std::int64_t index) const noexcept override {
    return bricks_[static_cast<std::size_t>(index)];
  }
  KernelView acquire(std::int64_t index, double /*time*/) const override {
    const Place& place = places_[static_cast<std::size_t>(index)];
    const Sent& sent = letters_[place.letter];
    return columns_.view(sent.letter, sent.num_kernels, place.first, brick(index).count);
  }
  std::size_t resident_bytes() const noexcept override {
    return bricks_.size() * sizeof(KernelBrick) +
           static_cast<std::size_t>(num_kernels_) * columns_.number() * sizeof(float);
  }

 private:
  struct Place {
    std::size_t letter;
    std::int64_t first;  // in it
  };
  struct Sent {
    std::shared_ptr<const Letter> letter;
    std::size_t num_kernels;
  };
  const TeamSet set_;
  const Columns columns_;
  std::vector<KernelBrick> bricks_;
  std::vector<Place> places_;
  std::vector<Sent> letters_;
  std::int64_t num_kernels_ = 0;
};

class TeamSource final : public KernelSource {
 public:
  TeamSource(TeamSet set, std::shared_ptr<const KernelSource> own, std::shared_ptr<KernelTeam> team,
             std::int64_t kept_bytes)
      : set_(std::move(set)),
        columns_{set_.shape, set_.attributes.size()},
        own_(std::move(own)),
        team_(std::move(team)),
        pages_(static_cast<std::size_t>(std::max<std::int64_t>(
            (kept_bytes > 0 ? kept_bytes : usual_kept_bytes()) / page_bytes(), kLeastPages))) {
    gather();
    first_own_ = layout_->owners[static_cast<std::size_t>(team_->number())];
    const auto answer = [&](auto chosen) {
      return team_->answer(
          [own = own_, layout = layout_, first = first_own_, chosen](std::int64_t number) {
            return written(*own, *layout, first, chosen(*layout, number));
          });
    };
    page_question_ = answer(page_of);
    every_question_ = answer([number = team_->number()](const Layout& layout, std::int64_t stride) {
      return every_of(layout, number, stride);
    });
  }

  KernelShape shape() const noexcept override { return set_.shape; }
  KernelProfile profile() const noexcept override { return set_.profile; }
  double cutoff() const noexcept override { return set_.cutoff; }
  std::span<const KernelAttribute> attributes() const noexcept override { return set_.attributes; }
  std::int64_t num_kernels() const noexcept override { return layout_->num_kernels; }
  std::int64_t num_bricks() const noexcept override {
    return static_cast<std::int64_t>(layout_->bricks.size());
  }
  const KernelBrick& brick(std::int64_t index) const noexcept override {
    return layout_->bricks[static_cast<std::size_t>(index)];
  }

  KernelView acquire(std::int64_t index, double time) const override {
    const std::int64_t owner = Layout::place_in(layout_->owners, index);
    if (owner == team_->number()) return own_->acquire(index - first_own_, time);
    const std::int64_t number = Layout::place_in(layout_->pages, index);
    const std::int64_t begin = layout_->first_of_page(number);
    const auto count = static_cast<std::size_t>(
        layout_->kernels_before(begin, layout_->first_of_page(number + 1)));
    std::shared_ptr<const Letter> page = pages_.get(number, [&] {
      Letter letter = team_->fetch(static_cast<int>(owner), page_question_, number);
      columns_.check(letter, count, owner);
      return letter;
    });
    return columns_.view(std::move(page), count, layout_->kernels_before(begin, index),
                         brick(index).count);
  }

  std::shared_ptr<const KernelSource> every(std::int64_t stride) const override {
    const std::scoped_lock lock(chosen_mutex_);
    for (const auto& [of, chosen] : chosen_) {
      if (of == stride) return chosen;
    }
    std::rotate(chosen_.begin(), chosen_.end() - 1, chosen_.end());
    chosen_.front() = {stride, fetched(stride)};
    return chosen_.front().second;
  }

  std::size_t resident_bytes() const noexcept override {
    return (own_ ? own_->resident_bytes() : 0) + layout_->bricks.size() * sizeof(KernelBrick) +
           pages_.count() * static_cast<std::size_t>(page_bytes());
  }

 private:
  static constexpr std::int64_t kLeastPages = 8;

  std::shared_ptr<const KernelSource> fetched(std::int64_t stride) const {
    auto some = std::make_shared<ChosenKernels>(set_, columns_);
    for (int owner = 0; owner < team_->count(); ++owner) {
      const Chosen chosen = every_of(*layout_, owner, stride);
      std::vector<std::int64_t> counts, bricks;
      std::size_t count = 0;
      for_bricks_of(*layout_, chosen, [&](std::int64_t b, std::int64_t first) {
        bricks.push_back(b);
        counts.push_back(count_in(brick(b).count, first, stride));
        count += static_cast<std::size_t>(counts.back());
      });
      if (count == 0) continue;
      Letter letter = owner == team_->number() ? written(*own_, *layout_, first_own_, chosen)
                                               : team_->fetch(owner, every_question_, stride);
      columns_.check(letter, count, owner);
      const std::size_t number = some->add(std::move(letter), count);
      std::int64_t first = 0;
      for (std::size_t i = 0; i < bricks.size(); ++i) {
        some->add(brick(bricks[i]), counts[i], number, first);
        first += counts[i];
      }
    }
    return some;
  }

  std::int64_t usual_kept_bytes() const noexcept {
    constexpr std::int64_t kLeast = std::int64_t{64} << 20;
    return std::max(kLeast,
                    own_ == nullptr ? 0 : static_cast<std::int64_t>(own_->resident_bytes()));
  }

  std::int64_t page_bytes() const noexcept {
    return kPageKernels * static_cast<std::int64_t>(columns_.number() * sizeof(float));
  }

  void gather() {
    std::vector<KernelBrick> bricks;
    std::vector<ValueRange> ranges;
    for (const KernelAttribute& attribute : set_.attributes) ranges.push_back(attribute.range);
    if (own_ != nullptr) {
      for (std::int64_t b = 0; b < own_->num_bricks(); ++b) bricks.push_back(own_->brick(b));
      for (std::size_t a = 0; a < ranges.size(); ++a) merge(ranges[a], own_->attributes()[a].range);
    }
    Letter letter;
    append(letter, std::span<const ValueRange>(ranges));
    append(letter, std::span<const KernelBrick>(bricks));
    for (KernelAttribute& attribute : set_.attributes) attribute.range = {};
    for (const Letter& from : gathered_letters(*team_, letter)) {
      LetterReader reader(from);
      std::vector<ValueRange> theirs;
      reader.take(ranges.size(), theirs);
      for (std::size_t a = 0; a < theirs.size(); ++a) merge(set_.attributes[a].range, theirs[a]);
      std::vector<KernelBrick> more;
      reader.take(reader.num_left() / sizeof(KernelBrick), more);
      layout_->add_bricks_of_next(more);
    }
    layout_->end();
  }

  TeamSet set_;
  const Columns columns_;
  std::shared_ptr<const KernelSource> own_;
  std::shared_ptr<KernelTeam> team_;
  std::shared_ptr<Layout> layout_ = std::make_shared<Layout>();
  std::int64_t first_own_ = 0;
  int page_question_ = 0;
  int every_question_ = 0;
  mutable PageCache<Letter> pages_;
  // Of the two strides that were asked for last: range and report, sums and framing share theirs.
  mutable std::mutex chosen_mutex_;
  mutable std::array<std::pair<std::int64_t, std::shared_ptr<const KernelSource>>, 2> chosen_{};
};

}  // namespace

std::shared_ptr<const KernelSource> make_team_source(TeamSet set,
                                                     std::shared_ptr<const KernelSource> own,
                                                     const std::shared_ptr<KernelTeam>& team,
                                                     std::int64_t kept_bytes) {
  return std::make_shared<TeamSource>(std::move(set), std::move(own), team, kept_bytes);
}

}  // namespace ovoid::data
