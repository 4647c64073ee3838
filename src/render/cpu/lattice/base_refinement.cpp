// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/lattice/base_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace ovoid::cpu {
namespace {

// How much colours and opacities may bend at the corners of what is interpolated: the difference
// of a sample to the mean of its neighbours on either side. The cubic through four samples errs by
// a sixteenth of that at most, unless the picture has finer patterns than the samples.
constexpr float kMostBend = 5.0F / 255;
// Where they bend by more, but differ by no more than this, straight lines fill.
constexpr float kMostDifference = 1.0F / 255;

// Between depths that differ by more sheets there is nothing.
constexpr double kMostSheetsBetween = 4;

constexpr std::size_t kChannels = 4;

// Numbers of a row of samples, kChannels each.
using Row = std::vector<float>;

enum class Cell : std::uint8_t { kEmpty, kStraight, kCubic, kDrawn };

constexpr float kNowhere = std::numeric_limits<float>::infinity();

// Halfway between the middle two of four samples.
float cubic_between(float a, float b, float c, float d) {
  return std::clamp((9.0F / 16) * (b + c) - (1.0F / 16) * (a + d), 0.0F, 1.0F);
}

// What lies between two rows of samples, and beside the upper one.
class RowOfCells {
 public:
  RowOfCells(const Image& few, double sheet_distance, Image& picture, SampleMask& mask)
      : few_(few),
        most_depth_(static_cast<float>(kMostSheetsBetween * sheet_distance)),
        picture_(picture),
        mask_(mask),
        across_(static_cast<std::size_t>(few.width)) {
    for (Row* row : {&below_, &right_, &middle_}) row->resize(kChannels * across_);
    for (Row& bend : bend_) bend.resize(across_);
  }

  // The cells below row y.
  void fill(int y) {
    const bool is_next = y == y_ + 1;
    y_ = y;
    if (is_next) {
      std::swap(bend_[0], bend_[1]);
    } else {
      set_bends(y, bend_[0]);
    }
    set_bends(y + 1, bend_[1]);
    if (is_empty()) return;
    const float* const rows[4] = {row(y - 1), row(y), row(y + 1), row(y + 2)};
    for (std::size_t i = 0; i < below_.size(); ++i)
      below_[i] = cubic_between(rows[0][i], rows[1][i], rows[2][i], rows[3][i]);
    set_between(rows[1], right_);
    set_between(below_.data(), middle_);
    for (int x = 0; x < few_.width; ++x) fill_cell(x, cell_at(x));
  }

 private:
  // Beyond the picture the outermost row goes on.
  const float* row(int y) const { return few_.rgba.data() + kChannels * across_ * row_number(y); }
  std::size_t row_number(int y) const {
    return static_cast<std::size_t>(std::clamp(y, 0, few_.height - 1));
  }

  bool is_empty() const {
    for (int y = y_ - 1; y <= y_ + 2; ++y) {
      const float* const from = row(y);
      if (std::any_of(from, from + kChannels * across_, [](float v) { return v != 0; }))
        return false;
    }
    return true;
  }

  // Halfway between the samples of a row and those to their right.
  void set_between(const float* from, Row& between) const {
    const auto at = [&](std::ptrdiff_t x, std::size_t c) {
      const auto last = static_cast<std::ptrdiff_t>(across_) - 1;
      return from[kChannels * static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(x, 0, last)) + c];
    };
    const auto set = [&](std::size_t x) {
      const auto i = static_cast<std::ptrdiff_t>(x);
      for (std::size_t c = 0; c < kChannels; ++c)
        between[kChannels * x + c] =
            cubic_between(at(i - 1, c), at(i, c), at(i + 1, c), at(i + 2, c));
    };
    // All but the ends in one loop over numbers, which compilers make vectors of.
    if (across_ > 3) {
      for (std::size_t i = kChannels; i < kChannels * (across_ - 2); ++i)
        between[i] = cubic_between(from[i - kChannels], from[i], from[i + kChannels],
                                   from[i + 2 * kChannels]);
    }
    for (std::size_t x = 0; x < across_; ++x) {
      if (across_ <= 3 || x == 0 || x + 2 >= across_) set(x);
    }
  }

  // How much each sample of row y bends along either axis, in any channel.
  void set_bends(int y, Row& bend) const {
    const float* const above = row(y - 1);
    const float* const own = row(y);
    const float* const below = row(y + 1);
    for (std::size_t x = 0; x < across_; ++x) {
      const std::size_t left = x == 0 ? 0 : x - 1;
      const std::size_t right = std::min(x + 1, across_ - 1);
      float most = 0;
      for (std::size_t c = 0; c < kChannels; ++c) {
        const float here = own[kChannels * x + c];
        const float along = 0.5F * (own[kChannels * left + c] + own[kChannels * right + c]);
        const float down = 0.5F * (above[kChannels * x + c] + below[kChannels * x + c]);
        most = std::max(most, std::max(std::abs(here - along), std::abs(here - down)));
      }
      bend[x] = most;
    }
  }

  Cell cell_at(int x) const {
    const auto left = static_cast<std::size_t>(x);
    const std::size_t right = std::min(left + 1, across_ - 1);
    const float bends = std::max(std::max(bend_[0][left], bend_[0][right]),
                                 std::max(bend_[1][left], bend_[1][right]));
    const float* const upper = row(y_);
    const float* const lower = row(y_ + 1);
    float greatest = 0;
    float difference = 0;
    for (std::size_t c = 0; c < kChannels; ++c) {
      const std::array<float, 4> corners{upper[kChannels * left + c], upper[kChannels * right + c],
                                         lower[kChannels * left + c], lower[kChannels * right + c]};
      const auto [lo, hi] = std::minmax_element(corners.begin(), corners.end());
      greatest = std::max(greatest, *hi);
      difference = std::max(difference, *hi - *lo);
    }
    if (bends > kMostBend) return difference <= kMostDifference ? Cell::kStraight : Cell::kDrawn;
    return greatest == 0 && bends == 0 ? Cell::kEmpty : Cell::kCubic;
  }

  void fill_cell(int x, Cell cell) {
    if (cell == Cell::kEmpty) return;
    const auto left = static_cast<std::size_t>(x);
    const std::size_t right = std::min(left + 1, across_ - 1);
    const float* const upper = row(y_);
    const float* const lower = row(y_ + 1);
    const std::size_t starts[2] = {across_ * row_number(y_), across_ * row_number(y_ + 1)};
    put(2 * x, 2 * y_, upper + kChannels * left, few_.depth[starts[0] + left],
        few_.front_depth[starts[0] + left]);
    const auto place = [&](int dx, int dy, const Row& cubic, std::size_t to_x, std::size_t to_y) {
      if (2 * x + dx >= picture_.width || 2 * y_ + dy >= picture_.height) return;
      if (cell == Cell::kDrawn) return mask_.add(2 * x + dx, 2 * y_ + dy);
      std::array<float, kChannels> mean{};
      if (cell == Cell::kStraight) {
        for (std::size_t c = 0; c < kChannels; ++c)
          mean[c] = 0.5F * (upper[kChannels * left + c] +
                            (to_y == 0 ? upper : lower)[kChannels * to_x + c]);
      }
      const float* const rgba =
          cell == Cell::kStraight ? mean.data() : cubic.data() + kChannels * left;
      const std::size_t from = starts[0] + left;
      const std::size_t to = starts[to_y] + to_x;
      float front = between(few_.front_depth[from], few_.front_depth[to]);
      if (front == kNowhere) front = few_.front_depth[to];
      if (!(rgba[3] >= kLeastVisibleOpacity)) front = kNowhere;
      put(2 * x + dx, 2 * y_ + dy, rgba, between(few_.depth[from], few_.depth[to]), front);
    };
    place(1, 0, right_, right, 0);
    place(0, 1, below_, left, 1);
    place(1, 1, middle_, right, 1);
  }

  // The mean of two depths, or, where they are of different things, the first.
  float between(float near, float far) const {
    const bool is_one = std::abs(far - near) <= most_depth_;  // not if either is infinite
    return is_one ? 0.5F * (near + far) : near;
  }

  void put(int x, int y, const float* rgba, float depth, float front_depth) {
    if (x >= picture_.width || y >= picture_.height) return;
    const std::size_t to = static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) +
                           static_cast<std::size_t>(x);
    std::copy_n(rgba, kChannels, picture_.rgba.data() + kChannels * to);
    picture_.depth[to] = depth;
    picture_.front_depth[to] = front_depth;
  }

  const Image& few_;
  const float most_depth_;
  Image& picture_;
  SampleMask& mask_;
  std::size_t across_;
  int y_ = -2;
  Row below_, right_, middle_;  // what cubics are, of every cell
  std::array<Row, 2> bend_;     // of the samples of rows y and y + 1
};

}  // namespace

SampleMask::SampleMask(int width, int height)
    : tiles_across_(static_cast<std::size_t>((width + kTileSize - 1) / kTileSize)),
      rows_(tiles_across_ * static_cast<std::size_t>((height + kTileSize - 1) / kTileSize) *
            kTileSize) {}

bool SampleMask::is_empty(int x, int y) const noexcept {
  const RowWord* const first = of_tile(x, y);
  return std::all_of(first, first + kTileSize, [](RowWord row) { return row == 0; });
}

view::BasePlane every_nth_sample(const view::BasePlane& base, int n) {
  view::BasePlane few = base;
  few.width = (base.width - 1 + n - 1) / n + 1;
  few.height = (base.height - 1 + n - 1) / n + 1;
  few.samples_per_spacing /= n;
  few.per_x *= n;
  few.per_y *= n;
  few.depth.per_x *= n;
  few.depth.per_y *= n;
  Mat3 base_from_few = Mat3::Identity();
  base_from_few(0, 0) = base_from_few(1, 1) = n;
  few.picture_from_base.matrix = base.picture_from_base.matrix * base_from_few;
  few.base_from_picture.matrix = few.picture_from_base.matrix.inverse();
  return few;
}

SampleMask interpolate_smooth(const Image& few, double sheet_distance, Image& picture,
                              Runner& runner) {
  SampleMask mask(picture.width, picture.height);
  constexpr int kRows = kTileSize / 2;  // tasks share no tile
  runner.run((few.height + kRows - 1) / kRows, [&](int task, int) {
    RowOfCells cells(few, sheet_distance, picture, mask);
    for (int y = task * kRows; y < std::min((task + 1) * kRows, few.height); ++y) cells.fill(y);
  });
  return mask;
}

}  // namespace ovoid::cpu
