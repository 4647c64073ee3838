// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/relevant_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "data/lattice/stored_number.h"
#include "data/scalar_visit.h"
#include "ovoid/error.h"

namespace ovoid::data {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Layers between two looks at the stop token take milliseconds.
void check_stop(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "encoding: stopped by the caller");
}

// contains() for one type, as fast as the type allows: a table for small integers, one comparison
// for one interval.
template <class T>
class IsRelevant {
 public:
  explicit IsRelevant(const RelevantValues& values) : values_(values) {
    if constexpr (kHasTable) {
      table_.resize(std::size_t{1} << (8 * sizeof(T)));
      for (std::size_t i = 0; i < table_.size(); ++i)
        table_[i] = values.contains(static_cast<double>(static_cast<T>(i))) ? 1 : 0;
    }
    if (values.intervals().size() == 1) {
      lo_ = values.intervals()[0][0];
      hi_ = values.intervals()[0][1];
    }
  }

  bool operator()(T number) const noexcept {
    if constexpr (kHasTable) return table_[static_cast<std::make_unsigned_t<T>>(number)] != 0;
    const auto wide = static_cast<double>(number);
    if (wide >= lo_ && wide <= hi_) return true;
    return values_.contains(wide);
  }

 private:
  static constexpr bool kHasTable = std::is_integral_v<T> && sizeof(T) <= 2;

  const RelevantValues& values_;
  double lo_ = 1, hi_ = 0;
  std::vector<std::uint8_t> table_;
};

}  // namespace

RelevantValues RelevantValues::above(double number) {
  return RelevantValues({{std::nextafter(number, kInfinity), kInfinity}});
}

RelevantValues RelevantValues::below(double number) {
  return RelevantValues({{-kInfinity, std::nextafter(number, -kInfinity)}});
}

RelevantValues RelevantValues::other_than(double number) {
  return RelevantValues({{-kInfinity, std::nextafter(number, -kInfinity)},
                         {std::nextafter(number, kInfinity), kInfinity}});
}

bool RelevantValues::contains(double number) const noexcept {
  if (!std::isfinite(number)) return true;
  return std::any_of(intervals_.begin(), intervals_.end(), [number](const Interval& interval) {
    return number >= interval[0] && number <= interval[1];
  });
}

// Takes the rows of all groups in their order, run by run.
class RelevantRuns::Builder {
 public:
  explicit Builder(RelevantRuns& runs) : runs_(runs) {
    const std::int64_t count = runs_.groups_per_layer() * runs_.box_.dims[2];
    runs_.groups_.reserve(static_cast<std::size_t>(count) + 1);
  }

  void begin_row() {
    if (y_ % kGroupRows == 0) begin_group();
    ++y_;
    end_ = 0;
    row_.clear();
    num_in_row_ = 0;
  }
  void add_run(std::int64_t start, std::int64_t length) {
    put(row_, static_cast<std::uint64_t>(start - end_));
    put(row_, static_cast<std::uint64_t>(length - 1));
    end_ = start + length;
    ++num_in_row_;
    ++runs_.num_runs_;
    runs_.num_relevant_ += length;
  }
  void end_row() {
    put(group_, num_in_row_);
    group_.insert(group_.end(), row_.begin(), row_.end());
    has_runs_ = has_runs_ || num_in_row_ > 0;
    if (y_ == runs_.box_.dims[1]) y_ = 0;
    if (y_ % kGroupRows == 0) end_group();
  }
  void finish() {
    begin_group();
    runs_.codes_.shrink_to_fit();
  }

 private:
  static void put(std::vector<std::uint8_t>& to, std::uint64_t number) {
    for (; number >= 0x80; number >>= 7U)
      to.push_back(static_cast<std::uint8_t>(0x80U | (number & 0x7fU)));
    to.push_back(static_cast<std::uint8_t>(number));
  }
  void begin_group() {
    runs_.groups_.push_back({runs_.codes_.size(), static_cast<std::uint64_t>(runs_.num_relevant_)});
    group_.clear();
    has_runs_ = false;
  }
  void end_group() {
    if (has_runs_) runs_.codes_.insert(runs_.codes_.end(), group_.begin(), group_.end());
  }

  RelevantRuns& runs_;
  std::vector<std::uint8_t> group_, row_;
  std::int64_t y_ = 0;    // rows begun in the layer
  std::int64_t end_ = 0;  // of the last run
  std::uint64_t num_in_row_ = 0;
  bool has_runs_ = false;
};

RelevantRuns::RelevantRuns(const SampleBox& box, std::span<const std::byte> samples,
                           const RelevantValues& relevant, double background,
                           const std::stop_token& stop)
    : box_(box) {
  assert(samples.size() == static_cast<std::size_t>(num_samples(box.dims)) * size_of(box.type));
  Builder builder(*this);
  visit_scalar(box.type, [&]<class T>(std::type_identity<T>) {
    const T stored = stored_number<T>(background);
    std::memcpy(background_.data(), &stored, sizeof(T));
    const IsRelevant<T> is_relevant(relevant);
    const std::int64_t nx = box_.dims[0];
    const std::byte* row = samples.data();
    for (std::int64_t r = 0; r < box_.dims[1] * box_.dims[2]; ++r) {
      if (r % box_.dims[1] == 0) check_stop(stop);
      builder.begin_row();
      const auto at = [row](std::int64_t x) { return load_scalar<T>(row, x); };
      for (std::int64_t x = 0; x < nx;) {
        while (x < nx && !is_relevant(at(x))) ++x;
        const std::int64_t start = x;
        while (x < nx && is_relevant(at(x))) ++x;
        if (x == start) break;
        builder.add_run(start, x - start);
        values_.insert(values_.end(), row + start * static_cast<std::int64_t>(sizeof(T)),
                       row + x * static_cast<std::int64_t>(sizeof(T)));
      }
      builder.end_row();
      row += static_cast<std::size_t>(nx) * sizeof(T);
    }
  });
  builder.finish();
  values_.shrink_to_fit();
}

RelevantRuns::RelevantRuns(const SampleBox& box, const RunLists& lists,
                           std::span<const std::byte> values, std::span<const std::byte> background)
    : box_(box) {
  const auto fail = [](const std::string& what) { throw Error(ErrorCode::kFileFormat, what); };
  const std::size_t num_rows = static_cast<std::size_t>(box.dims[1] * box.dims[2]);
  if (lists.row_runs.size() != num_rows)
    fail(fmt::format("runs of {} rows: expected {}", lists.row_runs.size(), num_rows));
  if (lists.starts.size() != lists.lengths.size())
    fail(fmt::format("{} starts and {} lengths: expected as many", lists.starts.size(),
                     lists.lengths.size()));
  if (background.size() != size_of(box.type))
    fail(
        fmt::format("a background of {} bytes: expected {}", background.size(), size_of(box.type)));
  std::copy(background.begin(), background.end(), background_.begin());
  Builder builder(*this);
  std::size_t next = 0;
  for (std::size_t row = 0; row < num_rows; ++row) {
    if (lists.row_runs[row] > lists.starts.size() - next)
      fail(fmt::format("row {} has {} runs: there are {} left", row, lists.row_runs[row],
                       lists.starts.size() - next));
    builder.begin_row();
    std::int64_t end = 0;
    for (const std::size_t last = next + lists.row_runs[row]; next < last; ++next) {
      const std::int64_t start = lists.starts[next], length = lists.lengths[next];
      if (start < end || length < 1 || length > box.dims[0] || start > box.dims[0] - length) {
        fail(fmt::format("run {} has {} samples from {} on: must lie between {} and {}", next,
                         length, start, end, box.dims[0]));
      }
      builder.add_run(start, length);
      end = start + length;
    }
    builder.end_row();
  }
  builder.finish();
  if (next != lists.starts.size())
    fail(fmt::format("{} runs: the rows have {}", lists.starts.size(), next));
  if (values.size() / size_of(box.type) != static_cast<std::size_t>(num_relevant_))
    fail(fmt::format("{} values: the runs have {}", values.size() / size_of(box.type),
                     num_relevant_));
  values_.assign(values.begin(), values.end());
}

std::size_t RelevantRuns::num_bytes() const noexcept {
  return codes_.size() + groups_.size() * sizeof(Group) + values_.size();
}

double RelevantRuns::background() const noexcept {
  return visit_scalar(box_.type, [this]<class T>(std::type_identity<T>) {
    return static_cast<double>(load_scalar<T>(background_.data(), 0));
  });
}

RunLists RelevantRuns::lists() const {
  RunLists lists;
  lists.row_runs.resize(static_cast<std::size_t>(box_.dims[1] * box_.dims[2]));
  lists.starts.reserve(static_cast<std::size_t>(num_runs_));
  lists.lengths.reserve(static_cast<std::size_t>(num_runs_));
  for (std::int64_t z = 0; z < box_.dims[2]; ++z) {
    for_each_run(z, 0, box_.dims[1],
                 [&](std::int64_t y, std::int64_t start, std::int64_t length, std::int64_t) {
                   ++lists.row_runs[static_cast<std::size_t>(z * box_.dims[1] + y)];
                   lists.starts.push_back(static_cast<std::uint32_t>(start));
                   lists.lengths.push_back(static_cast<std::uint32_t>(length));
                 });
  }
  return lists;
}

void RelevantRuns::decode(const Index3& lo, const Index3& hi, std::byte* to) const {
  const auto item = static_cast<std::int64_t>(size_of(box_.type));
  const Index3 size{hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]};
  visit_scalar(box_.type, [&]<class T>(std::type_identity<T>) {
    const T background = load_scalar<T>(background_.data(), 0);
    for (std::int64_t i = 0; i < num_samples(size); ++i)
      std::memcpy(to + static_cast<std::size_t>(i) * sizeof(T), &background, sizeof(T));
  });
  for (std::int64_t z = lo[2]; z < hi[2]; ++z) {
    std::byte* const layer = to + (z - lo[2]) * size[1] * size[0] * item;
    for_each_run(z, lo[1], hi[1],
                 [&](std::int64_t y, std::int64_t start, std::int64_t length, std::int64_t value) {
                   const std::int64_t first = std::max(start, lo[0]);
                   const std::int64_t last = std::min(start + length, hi[0]);
                   if (first >= last) return;
                   std::memcpy(layer + ((y - lo[1]) * size[0] + first - lo[0]) * item,
                               values_.data() + (value + first - start) * item,
                               static_cast<std::size_t>((last - first) * item));
                 });
  }
}

bool RelevantRuns::may_hold_runs(const Index3& lo, const Index3& hi) const noexcept {
  for (std::int64_t z = lo[2]; z < hi[2]; ++z) {
    const std::int64_t layer = z * groups_per_layer();
    const auto first = static_cast<std::size_t>(layer + lo[1] / kGroupRows);
    const auto last = static_cast<std::size_t>(layer + (hi[1] - 1) / kGroupRows) + 1;
    if (groups_[first].first_code != groups_[last].first_code) return true;
  }
  return false;
}

}  // namespace ovoid::data
