// SPDX-License-Identifier: Apache-2.0
// The relevant samples of a lattice alone, run-length encoded [Neophytou 2006, section 2.2]: a
// volume of which a small part can be seen takes a small part of its memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "ovoid/lattice.h"

namespace ovoid::data {

// Which stored numbers are relevant: those in any of some closed intervals, such as the visible
// ones of a look, and missing ones (NaN, infinities), which must stay missing.
class RelevantValues {
 public:
  using Interval = std::array<double, 2>;  // least and greatest, both included

  // Neither bound is NaN; an interval whose greatest is less than its least holds nothing.
  explicit RelevantValues(std::vector<Interval> intervals) : intervals_(std::move(intervals)) {}
  static RelevantValues above(double number);  // greater than it
  static RelevantValues below(double number);  // less than it
  static RelevantValues other_than(double number);

  std::span<const Interval> intervals() const noexcept { return intervals_; }
  bool contains(double number) const noexcept;

 private:
  std::vector<Interval> intervals_;
};

// What is encoded: samples of one type, x fastest, of one step.
struct SampleBox {
  ScalarType type = ScalarType::kFloat32;
  Index3 dims{1, 1, 1};  // of body-centred lattices the third counts layers
};

// The same as lists: what files hold.
struct RunLists {
  std::vector<std::uint32_t> row_runs;  // [dims.z * dims.y] runs of each row
  std::vector<std::uint32_t> starts;    // [runs] first sample of each in its row, rising
  std::vector<std::uint32_t> lengths;   // [runs] >= 1
};

// Rows along x of relevant samples and what stands for all others, the background. Immutable.
//
// Encoding. Rows come in groups of up to kGroupRows of one layer. A group without runs takes no
// code; of another, each row is its number of runs, then for each run the samples between it and
// the one before (or the row's begin) and its length less one, all three as numbers of 7 bits to
// the byte, least ones first, the highest bit saying that more follow. So a run takes 2 bytes where
// both are below 128 and 4 up to 16384, where start and end as 16-bit numbers always take 4 and
// would need an escape for longer rows. A group has two numbers more, where its codes and its
// values begin: 16 bytes, one for each row, for which a row is found at once and a brick of 16 x 16
// x 16 samples unpacked from 16 such places.
class RelevantRuns {
 public:
  static constexpr std::int64_t kGroupRows = 16;

  // Encodes num_samples(box.dims) samples, native byte order. `background`: the stored number that
  // stands for the others, rounded and clamped to the type. Throws Error(kCancelled). Cost: a pass
  // over the samples, about a nanosecond each.
  RelevantRuns(const SampleBox& box, std::span<const std::byte> samples,
               const RelevantValues& relevant, double background, const std::stop_token& stop = {});
  // From lists that need not be right, and the bytes of the relevant samples and of the background.
  // Throws Error(kFileFormat) unless they fit each other and the box.
  RelevantRuns(const SampleBox& box, const RunLists& lists, std::span<const std::byte> values,
               std::span<const std::byte> background);

  const SampleBox& box() const noexcept { return box_; }
  std::int64_t num_relevant() const noexcept { return num_relevant_; }
  std::int64_t num_runs() const noexcept { return num_runs_; }
  std::size_t num_bytes() const noexcept;  // of the encoding: codes, groups, values
  double background() const noexcept;
  std::span<const std::byte> background_bytes() const noexcept {
    return {background_.data(), size_of(box_.type)};
  }
  std::span<const std::byte> values() const noexcept { return values_; }  // [num_relevant]
  RunLists lists() const;

  // Unpacks the samples lo <= (i, j, k) < hi, x fastest, without padding; lo and hi lie within the
  // box. Cost: the samples, and the codes of all groups that it meets.
  void decode(const Index3& lo, const Index3& hi, std::byte* to) const;
  // True if a group of rows that meets the box has a run: if not, all of it is background.
  bool may_hold_runs(const Index3& lo, const Index3& hi) const noexcept;

  // Calls on_run(row, start, length, first_value) for every run of rows first <= row < last of a
  // layer, in their order; first_value counts samples in values().
  template <class OnRun>
  void for_each_run(std::int64_t layer, std::int64_t first, std::int64_t last,
                    const OnRun& on_run) const;

 private:
  struct Group {
    std::uint64_t first_code;
    std::uint64_t first_value;
  };
  class Builder;

  std::int64_t groups_per_layer() const noexcept {
    return (box_.dims[1] + kGroupRows - 1) / kGroupRows;
  }
  static std::uint64_t next_number(const std::uint8_t*& at) noexcept {
    std::uint64_t number = 0;
    int shift = 0;
    for (; *at >= 0x80; ++at, shift += 7) number |= std::uint64_t{*at & 0x7fU} << shift;
    return number | std::uint64_t{*at++} << shift;
  }

  SampleBox box_;
  std::vector<Group> groups_;  // and one behind the last
  std::vector<std::uint8_t> codes_;
  std::vector<std::byte> values_;
  std::array<std::byte, 8> background_{};
  std::int64_t num_relevant_ = 0;
  std::int64_t num_runs_ = 0;
};

template <class OnRun>
void RelevantRuns::for_each_run(std::int64_t layer, std::int64_t first, std::int64_t last,
                                const OnRun& on_run) const {
  for (std::int64_t row = first - first % kGroupRows; row < last; row += kGroupRows) {
    const std::int64_t index = layer * groups_per_layer() + row / kGroupRows;
    const Group& group = groups_[static_cast<std::size_t>(index)];
    if (group.first_code == groups_[static_cast<std::size_t>(index) + 1].first_code) continue;
    const std::uint8_t* at = codes_.data() + group.first_code;
    auto value = static_cast<std::int64_t>(group.first_value);
    const std::int64_t end = row + kGroupRows < last ? row + kGroupRows : last;
    for (std::int64_t y = row; y < end; ++y) {
      std::int64_t x = 0;
      for (std::uint64_t left = next_number(at); left > 0; --left) {
        x += static_cast<std::int64_t>(next_number(at));
        const std::int64_t length = static_cast<std::int64_t>(next_number(at)) + 1;
        if (y >= first) on_run(y, x, length, value);
        x += length;
        value += length;
      }
    }
  }
}

}  // namespace ovoid::data
