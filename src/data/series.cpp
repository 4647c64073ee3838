// SPDX-License-Identifier: Apache-2.0
// One lock guards all; it is not held while a step is read or given back. A slot stands for a step
// that is being read, kept, or pushed out while somebody still uses it: that one is found again
// instead of being read twice, and goes the moment it is let go of.
#include "ovoid/series.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "data/step_likeness.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

using Held = std::shared_ptr<const Dataset>;

std::size_t bytes_of(const Dataset& dataset) {
  std::size_t bytes = dataset.positions.bytes.view.size() + dataset.box_sizes.bytes.view.size() +
                      dataset.cells.types.size() * sizeof(CellType) +
                      dataset.cells.offsets.size() * sizeof(std::int64_t) +
                      dataset.cells.connectivity.size() * sizeof(std::uint32_t);
  for (const DataArray& array : dataset.arrays) bytes += array.bytes.view.size();
  return bytes;
}

}  // namespace

struct __attribute__((visibility("hidden"))) Series::Impl {
  struct Slot {
    Held kept;                          // by the series
    std::weak_ptr<const Dataset> seen;  // finds it while anybody has it
    std::size_t bytes = 0;              // while it is read: a guess
    std::uint64_t last_used = 0;
    bool is_loading = false;

    bool is_used_elsewhere() const { return kept ? kept.use_count() > 1 : !seen.expired(); }
  };
  using Lock = std::unique_lock<std::mutex>;

  std::shared_ptr<const StepSource> source;
  SeriesOptions options;

  mutable std::mutex mutex;
  std::condition_variable_any loaded;   // a slot is no longer loading
  std::condition_variable_any planned;  // `wanted` has a step
  std::map<std::int64_t, Slot> slots;
  std::optional<data::StepLikeness> likeness;  // of the first step that was read
  std::uint64_t clock = 0;
  std::size_t greatest = 0;  // bytes of a step so far

  std::int64_t last = -1;  // asked for
  std::int64_t stride = 1, stride_before = 1;
  std::optional<std::int64_t> wanted, reading_ahead;
  std::stop_source ahead_stop;
  bool is_over = false;
  std::jthread reader;  // the last member: it uses the others

  ~Impl() {
    {
      const Lock lock(mutex);
      is_over = true;
      ahead_stop.request_stop();
    }
    if (!reader.joinable()) return;
    reader.request_stop();
    reader.join();
  }

  Held step(std::int64_t number, const std::stop_token& stop);
  Held load(Lock& lock, std::int64_t number, const std::stop_token& stop);
  std::size_t bytes_in_memory();
  std::vector<Held> trim();
  void note_request(std::int64_t number);
  std::optional<std::int64_t> next_likely() const;
  bool has_room_ahead() const;
  void plan();
  void read_ahead(const std::stop_token& stop);
};

// Of all slots. Forgets those whose step nobody has.
std::size_t Series::Impl::bytes_in_memory() {
  std::size_t bytes = 0;
  for (auto slot = slots.begin(); slot != slots.end();) {
    const bool is_there =
        slot->second.is_loading || slot->second.kept || !slot->second.seen.expired();
    if (is_there) bytes += slot->second.bytes;
    slot = is_there ? std::next(slot) : slots.erase(slot);
  }
  return bytes;
}

// Pushes out what is too much. The result is to be freed when the lock is no longer held.
std::vector<Held> Series::Impl::trim() {
  std::vector<Held> out;
  const auto push_oldest_out = [&](bool is_used) {
    Slot* oldest = nullptr;
    for (auto& [number, slot] : slots) {
      const bool is_candidate = slot.kept && slot.is_used_elsewhere() == is_used;
      if (is_candidate && (oldest == nullptr || slot.last_used < oldest->last_used)) oldest = &slot;
    }
    if (oldest == nullptr) return false;
    out.push_back(std::move(oldest->kept));
    oldest->kept.reset();
    if (!is_used) oldest->seen.reset();
    return true;
  };
  while (bytes_in_memory() > options.memory_limit && push_oldest_out(false)) {
  }
  // The rest is in use, and to go when it is let go of.
  const auto num_kept_bytes = [&] {
    std::size_t bytes = 0;
    for (const auto& [number, slot] : slots) bytes += slot.kept ? slot.bytes : 0;
    return bytes;
  };
  while (num_kept_bytes() > options.memory_limit && push_oldest_out(true)) {
  }
  return out;
}

Held Series::Impl::load(Lock& lock, std::int64_t number, const std::stop_token& stop) {
  Slot& loading = slots[number];
  loading.is_loading = true;
  loading.bytes = greatest;
  std::vector<Held> pushed_out = trim();
  lock.unlock();
  pushed_out.clear();
  Held data;
  try {
    data = Held(new Dataset(source->read(number, stop)));
    lock.lock();
    if (!likeness) likeness.emplace(*data, number, source->kind());
    likeness->check(*data, number);
  } catch (...) {
    if (!lock.owns_lock()) lock.lock();
    slots.erase(number);
    loaded.notify_all();
    throw;
  }
  Slot& slot = slots[number];
  slot.kept = data;
  slot.seen = data;
  slot.bytes = bytes_of(*data);
  slot.last_used = ++clock;
  slot.is_loading = false;
  greatest = std::max(greatest, slot.bytes);
  loaded.notify_all();
  return data;
}

Held Series::Impl::step(std::int64_t number, const std::stop_token& stop) {
  if (number < 0 || number >= source->num_steps()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: step {}: expected 0 to {}", source->name(), number,
                            source->num_steps() - 1));
  }
  std::vector<Held> pushed_out;  // freed behind the lock
  Lock lock(mutex);
  note_request(number);
  Held data;
  while (!data) {
    const auto found = slots.find(number);
    if (found == slots.end()) {
      data = load(lock, number, stop);
    } else if (found->second.is_loading) {
      loaded.wait(lock, stop, [&] {
        const auto slot = slots.find(number);
        return slot == slots.end() || !slot->second.is_loading;
      });
      if (stop.stop_requested()) {
        throw Error(ErrorCode::kCancelled,
                    fmt::format("{}: step {}: stopped by the caller", source->name(), number));
      }
    } else {
      Slot& slot = found->second;
      data = slot.kept ? slot.kept : slot.seen.lock();
      if (!data) {
        slots.erase(found);
        continue;
      }
      slot.kept = data;
      slot.last_used = ++clock;
    }
  }
  pushed_out = trim();
  plan();
  return data;
}

// Only Impl::step's own requests tell where the reader of the series is going.
void Series::Impl::note_request(std::int64_t number) {
  if (last >= 0 && number != last) {
    stride_before = stride;
    stride = number - last;
  }
  last = number;
  // What is being read ahead and no longer likely makes way.
  if (reading_ahead && *reading_ahead != number && reading_ahead != next_likely())
    ahead_stop.request_stop();
}

std::optional<std::int64_t> Series::Impl::next_likely() const {
  const std::int64_t sign = stride < 0 ? -1 : 1;
  const std::int64_t next = last + (stride == stride_before ? stride : sign);
  if (next < 0 || next >= source->num_steps()) return std::nullopt;
  return next;
}

// Without pushing out what is in use, or was asked for last.
bool Series::Impl::has_room_ahead() const {
  std::size_t staying = greatest;
  for (const auto& [number, slot] : slots) {
    if (slot.is_loading || number == last || slot.is_used_elsewhere()) staying += slot.bytes;
  }
  return staying <= options.memory_limit;
}

void Series::Impl::plan() {
  if (!options.prefetch || is_over) return;
  wanted = next_likely();
  if (!wanted) return;
  try {
    if (!reader.joinable())
      reader = std::jthread([this](const std::stop_token& stop) { read_ahead(stop); });
  } catch (const std::system_error&) {
    options.prefetch = false;  // no thread is to be had: steps are read when they are asked for
    return;
  }
  planned.notify_one();
}

void Series::Impl::read_ahead(const std::stop_token& stop) {
  while (true) {
    std::vector<Held> pushed_out;  // freed behind the lock
    Lock lock(mutex);
    planned.wait(lock, stop, [&] { return wanted.has_value(); });
    if (is_over || stop.stop_requested()) return;
    const std::int64_t number = *std::exchange(wanted, std::nullopt);
    const auto found = slots.find(number);
    const bool is_there = found != slots.end() && (found->second.is_loading || found->second.kept ||
                                                   !found->second.seen.expired());
    if (is_there || !has_room_ahead()) continue;
    if (found != slots.end()) slots.erase(found);
    reading_ahead = number;
    ahead_stop = std::stop_source();
    try {
      load(lock, number, ahead_stop.get_token());
      pushed_out = trim();
    } catch (...) {  // NOLINT(bugprone-empty-catch): whoever asks for the step is told
    }
    reading_ahead.reset();
  }
}

Series::Series(std::shared_ptr<const StepSource> source, const SeriesOptions& options)
    : impl_(std::make_unique<Impl>()) {
  if (!source) throw Error(ErrorCode::kInvalidArgument, "source: is null, expected steps");
  data::check_times(*source);
  impl_->source = std::move(source);
  impl_->options = options;
}

Series::~Series() = default;
Series::Series(Series&&) noexcept = default;
Series& Series::operator=(Series&&) noexcept = default;

const StepSource& Series::source() const noexcept { return *impl_->source; }
std::int64_t Series::num_steps() const noexcept { return impl_->source->num_steps(); }
const std::vector<double>& Series::times() const noexcept { return impl_->source->times(); }

std::int64_t Series::nearest_step(double time) const noexcept {
  const std::vector<double>& all = times();
  const auto after = std::lower_bound(all.begin(), all.end(), time);
  if (after == all.begin()) return 0;
  const auto before = after - 1;
  const bool is_later = after != all.end() && *after - time < time - *before;
  return (is_later ? after : before) - all.begin();
}

std::shared_ptr<const Dataset> Series::step(std::int64_t step, std::stop_token stop) const {
  return impl_->step(step, stop);
}

std::size_t Series::resident_bytes() const noexcept {
  const Impl::Lock lock(impl_->mutex);
  std::size_t bytes = 0;
  for (const auto& [number, slot] : impl_->slots) bytes += slot.kept ? slot.bytes : 0;
  return bytes;
}

std::int64_t Series::num_resident() const noexcept {
  const Impl::Lock lock(impl_->mutex);
  return std::count_if(impl_->slots.begin(), impl_->slots.end(),
                       [](const auto& entry) { return entry.second.kept != nullptr; });
}

}  // namespace ovoid
