// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>

namespace ovoid::data {

// Pages by number; those that were used last are kept. Many threads may ask at once: who asks for a
// page that another reads waits for it.
template <class Page>
class PageCache {
 public:
  explicit PageCache(std::size_t most_pages) : most_pages_(most_pages) {}

  // The page, which read() makes if it is not there; it stays for as long as the result is held.
  // Throws what read() throws, and the next who asks reads again.
  template <class Read>
  std::shared_ptr<const Page> get(std::int64_t number, const Read& read) {
    const std::shared_ptr<Slot> slot = slot_of(number);
    const std::scoped_lock lock(slot->mutex);
    if (!slot->page) slot->page.emplace(read());
    return {slot, &*slot->page};
  }

  std::size_t count() const {
    const std::scoped_lock lock(mutex_);
    return slots_.size();
  }

 private:
  struct Slot {
    std::mutex mutex;  // held while it is read
    std::optional<Page> page;
  };
  struct Kept {
    std::int64_t number;
    std::shared_ptr<Slot> slot;
  };

  // The longest unused goes.
  std::shared_ptr<Slot> slot_of(std::int64_t number) {
    const std::scoped_lock lock(mutex_);
    const auto place = places_.find(number);
    if (place != places_.end()) {
      slots_.splice(slots_.begin(), slots_, place->second);
      return slots_.front().slot;
    }
    if (slots_.size() >= most_pages_) {
      places_.erase(slots_.back().number);
      slots_.pop_back();
    }
    slots_.push_front({number, std::make_shared<Slot>()});
    places_.emplace(number, slots_.begin());
    return slots_.front().slot;
  }

  std::size_t most_pages_;
  mutable std::mutex mutex_;  // of what follows
  std::list<Kept> slots_;     // the last used first
  std::unordered_map<std::int64_t, typename std::list<Kept>::iterator> places_;
};

}  // namespace ovoid::data
