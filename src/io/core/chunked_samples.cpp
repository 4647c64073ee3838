// SPDX-License-Identifier: Apache-2.0
// Samples that stay in their chunks. A chunk is loaded when a row of it is read first, and kept as
// a box with x fastest; what was used last stays.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <list>
#include <map>
#include <mutex>

#include "io/core/axis_order.h"
#include "io/core/chunked_array.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

class ChunkedSamples final : public StoredSamples {
 public:
  ChunkedSamples(ChunkedArray array, std::int64_t step, std::int64_t channel, std::int64_t memory)
      : array_(std::move(array)),
        step_(step),
        channel_(channel),
        memory_for_pages_(memory / 2),
        memory_for_boxes_(memory - memory / 2),
        item_(static_cast<std::int64_t>(size_of(array_.type))),
        dims_(array_.dims()) {
    constexpr std::string_view kSpace = "xyz";
    for (std::size_t i = 0; i < 3; ++i) {
      const auto place = axis_place(array_.axes, kSpace[i]);
      edges_[i] = place ? array_.chunk[*place] : 1;
    }
    const double layer = static_cast<double>(dims_[0]) * static_cast<double>(dims_[1]) *
                         static_cast<double>(std::min(edges_[2], dims_[2]) * item_);
    if (layer <= static_cast<double>(memory_for_boxes_)) return;
    throw Error(
        ErrorCode::kOutOfMemory,
        fmt::format("{}: is larger than memory, and so is a layer of its chunks, {:.0f} MiB: "
                    "{:.0f} MiB are left for it: take an array of lower resolution",
                    array_.where, layer / (1 << 20),
                    static_cast<double>(memory_for_boxes_) / (1 << 20)));
  }

  std::int64_t num_bytes() const noexcept override { return num_samples(dims_) * item_; }
  std::int64_t memory_for_pages() const noexcept override { return memory_for_pages_; }

  void read(std::int64_t offset, std::span<std::byte> out) const override {
    std::int64_t sample = offset / item_;
    std::byte* to = out.data();
    std::int64_t left = static_cast<std::int64_t>(out.size()) / item_;
    while (left > 0) {
      const std::int64_t x = sample % dims_[0], row = sample / dims_[0];
      const std::int64_t y = row % dims_[1], z = row / dims_[1];
      const std::array<std::int64_t, 3> number{x / edges_[0], y / edges_[1], z / edges_[2]};
      const std::shared_ptr<Box> box = loaded(number);
      const Index3& size = box->dims;
      const std::int64_t in_box = x % edges_[0];
      const std::int64_t count = std::min(left, size[0] - in_box);
      const std::int64_t from = ((z % edges_[2]) * size[1] + y % edges_[1]) * size[0] + in_box;
      std::memcpy(to, box->samples.data() + from * item_, static_cast<std::size_t>(count * item_));
      to += count * item_;
      sample += count;
      left -= count;
    }
  }

 private:
  using Number = std::array<std::int64_t, 3>;  // of a chunk along x, y, z
  struct Box {
    std::mutex mutex;  // held while it is loaded
    Index3 dims{};
    std::vector<std::byte> samples;  // empty: not loaded yet
  };
  struct Kept {
    Number number;
    std::shared_ptr<Box> box;
  };

  std::int64_t num_box_bytes() const { return edges_[0] * edges_[1] * edges_[2] * item_; }

  // The box, kept or new; the longest unused goes.
  std::shared_ptr<Box> keep(const Number& number) const {
    const std::scoped_lock lock(mutex_);
    const auto place = places_.find(number);
    if (place != places_.end()) {
      boxes_.splice(boxes_.begin(), boxes_, place->second);
      return boxes_.front().box;
    }
    const auto most =
        static_cast<std::size_t>(std::max<std::int64_t>(memory_for_boxes_ / num_box_bytes(), 2));
    while (boxes_.size() >= most) {
      places_.erase(boxes_.back().number);
      boxes_.pop_back();
    }
    boxes_.push_front({number, std::make_shared<Box>()});
    places_.emplace(number, boxes_.begin());
    return boxes_.front().box;
  }

  std::shared_ptr<Box> loaded(const Number& number) const {
    std::shared_ptr<Box> box = keep(number);
    const std::scoped_lock lock(box->mutex);
    if (box->samples.empty()) load(number, *box);
    return box;
  }

  void load(const Number& number, Box& box) const {
    for (std::size_t i = 0; i < 3; ++i)
      box.dims[i] = std::min(edges_[i], dims_[i] - number[i] * edges_[i]);
    const std::size_t rank = array_.axes.size();
    std::vector<std::int64_t> chunk_number(rank, 0);
    ChunkBox copied{std::vector<std::int64_t>(rank, 0), std::vector<std::int64_t>(rank, 1),
                    std::vector<std::int64_t>(rank, 0)};
    const auto place_in_space = [&](std::size_t a, std::size_t i, std::int64_t stride) {
      chunk_number[a] = number[i];
      copied.count[a] = box.dims[i];
      copied.to_strides[a] = stride;
    };
    for (std::size_t a = 0; a < rank; ++a) {
      const char letter = array_.axes[a];
      if (letter == 'x') place_in_space(a, 0, item_);
      if (letter == 'y') place_in_space(a, 1, item_ * box.dims[0]);
      if (letter == 'z') place_in_space(a, 2, item_ * box.dims[0] * box.dims[1]);
      if (letter != 't' && letter != 'c') continue;
      const std::int64_t at = letter == 't' ? step_ : channel_;
      chunk_number[a] = at / array_.chunk[a];
      copied.first[a] = at % array_.chunk[a];
    }
    std::vector<std::byte> chunk(static_cast<std::size_t>(num_chunk_bytes(array_)));
    const bool is_there = load_chunk(array_, chunk_number, chunk);
    std::vector<std::byte> samples(static_cast<std::size_t>(num_samples(box.dims) * item_));
    copy_chunk_box(array_,
                   is_there ? std::span<const std::byte>(chunk) : std::span<const std::byte>(),
                   copied, samples.data());
    box.samples = std::move(samples);
  }

  ChunkedArray array_;
  std::int64_t step_, channel_;
  std::int64_t memory_for_pages_, memory_for_boxes_;
  std::int64_t item_;
  Index3 dims_;
  Index3 edges_{};  // of a chunk

  mutable std::mutex mutex_;       // of what follows
  mutable std::list<Kept> boxes_;  // the last used first
  mutable std::map<Number, std::list<Kept>::iterator> places_;
};

}  // namespace

std::shared_ptr<const StoredSamples> stored_chunks(const ChunkedArray& array, std::int64_t step,
                                                   std::int64_t channel,
                                                   std::int64_t memory_for_pages) {
  return std::make_shared<ChunkedSamples>(array, step, channel, memory_for_pages);
}

}  // namespace ovoid::io
