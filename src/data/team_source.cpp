// SPDX-License-Identifier: Apache-2.0
#include "data/team_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "data/kernel_shape.h"
#include "data/letters.h"
#include "data/merged_range.h"
#include "data/page_cache.h"
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

// A page on its way: columns of floats, one for each coordinate, shape number, the weight and each
// value, of all kernels of its bricks.
Letter written_page(const KernelSource& own, const Layout& layout, std::int64_t first_own,
                    std::int64_t page) {
  const std::int64_t begin = layout.first_of_page(page);
  const std::int64_t end = layout.first_of_page(page + 1);
  const auto count = static_cast<std::size_t>(layout.kernels_before(begin, end));
  const auto num_shapes = static_cast<std::size_t>(num_shape_numbers(own.shape()));
  const std::size_t num_values = own.attributes().size();
  const std::size_t num_columns = 3 + num_shapes + 1 + num_values;
  std::vector<float> columns(num_columns * count);
  std::size_t to = 0;
  for (std::int64_t b = begin; b < end; ++b) {
    const KernelView view = own.acquire(b - first_own, 0.0);
    for (std::int32_t i = 0; i < view.count; ++i, ++to) {
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
  }
  Letter letter;
  append(letter, std::span<const float>(columns));
  return letter;
}

class TeamSource final : public KernelSource {
 public:
  TeamSource(TeamSet set, std::shared_ptr<const KernelSource> own, std::shared_ptr<KernelTeam> team,
             std::int64_t kept_bytes)
      : set_(std::move(set)),
        own_(std::move(own)),
        team_(std::move(team)),
        pages_(static_cast<std::size_t>(std::max<std::int64_t>(
            (kept_bytes > 0 ? kept_bytes : usual_kept_bytes()) / page_bytes(), kLeastPages))) {
    gather();
    first_own_ = layout_->owners[static_cast<std::size_t>(team_->number())];
    question_ =
        team_->answer([own = own_, layout = layout_, first = first_own_](std::int64_t page) {
          return written_page(*own, *layout, first, page);
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
      Letter letter = team_->fetch(static_cast<int>(owner), question_, number);
      if (letter.size() != num_columns() * count * sizeof(float))
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("process {} of the team has sent {} bytes of kernels, expected {}",
                                owner, letter.size(), num_columns() * count * sizeof(float)));
      return letter;
    });
    // From operator new: aligned for floats.
    const float* column =
        reinterpret_cast<const float*>(page->data()) + layout_->kernels_before(begin, index);
    const auto next = [&] { return std::exchange(column, column + count); };
    KernelView view;
    view.count = brick(index).count;
    for (const float*& center : view.center) center = next();
    for (int c = 0; c < num_shape_numbers(set_.shape); ++c)
      view.shape[static_cast<std::size_t>(c)] = next();
    view.weight = next();
    for (std::size_t a = 0; a < set_.attributes.size(); ++a) view.value[a] = next();
    view.pin = std::move(page);
    return view;
  }

  std::size_t resident_bytes() const noexcept override {
    return (own_ ? own_->resident_bytes() : 0) + layout_->bricks.size() * sizeof(KernelBrick) +
           pages_.count() * static_cast<std::size_t>(page_bytes());
  }

 private:
  static constexpr std::int64_t kLeastPages = 8;

  std::int64_t usual_kept_bytes() const noexcept {
    constexpr std::int64_t kLeast = std::int64_t{64} << 20;
    return std::max(kLeast,
                    own_ == nullptr ? 0 : static_cast<std::int64_t>(own_->resident_bytes()));
  }

  std::size_t num_columns() const noexcept {
    return 3 + static_cast<std::size_t>(num_shape_numbers(set_.shape)) + 1 + set_.attributes.size();
  }
  std::int64_t page_bytes() const noexcept {
    return kPageKernels * static_cast<std::int64_t>(num_columns() * sizeof(float));
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
  std::shared_ptr<const KernelSource> own_;
  std::shared_ptr<KernelTeam> team_;
  std::shared_ptr<Layout> layout_ = std::make_shared<Layout>();
  std::int64_t first_own_ = 0;
  int question_ = 0;
  mutable PageCache<Letter> pages_;
};

}  // namespace

std::shared_ptr<const KernelSource> make_team_source(TeamSet set,
                                                     std::shared_ptr<const KernelSource> own,
                                                     const std::shared_ptr<KernelTeam>& team,
                                                     std::int64_t kept_bytes) {
  return std::make_shared<TeamSource>(std::move(set), std::move(own), team, kept_bytes);
}

}  // namespace ovoid::data
