// SPDX-License-Identifier: Apache-2.0
#include "io/core/chunked_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "data/bookkeeping.h"
#include "data/parallel.h"
#include "io/core/axis_order.h"
#include "io/core/memory.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostChannels = 10'000;
constexpr std::int64_t kMostComponents = 65'536;
constexpr std::int64_t kMostChunksRead = std::int64_t{1} << 21;  // of an array, at once

std::int64_t item_size(const ChunkedArray& array) {
  return static_cast<std::int64_t>(size_of(array.type));
}

// Chunks that samples [first, first + count) of an axis lie in.
struct ChunkRange {
  std::int64_t first = 0, count = 1;
};

// One channel, or all components, of one step: which chunks, and where their samples go.
class ChunkReader {
 public:
  ChunkReader(const ChunkedArray& array, std::int64_t step,
              std::vector<std::pair<std::int64_t, std::byte*>> channels)
      : array_(array), step_(step), channels_(std::move(channels)) {
    const std::int64_t item = item_size(array);
    const Index3 dims = array.dims();
    const std::int64_t sample = item * (array.has_components() ? array.size_of_axis('c') : 1);
    for (std::size_t a = 0; a < array.axes.size(); ++a) {
      const char letter = array.axes[a];
      strides_.push_back(letter == 'x'                             ? sample
                         : letter == 'y'                           ? sample * dims[0]
                         : letter == 'z'                           ? sample * dims[0] * dims[1]
                         : letter == 'c' && array.has_components() ? item
                                                                   : 0);
      ChunkRange range{0, (array.shape[a] - 1) / array.chunk[a] + 1};
      if (letter == 't') range = {step / array.chunk[a], 1};
      if (letter == 'c' && !array.has_components()) {
        range.first = channels_.front().first / array.chunk[a];
        range.count = channels_.back().first / array.chunk[a] - range.first + 1;
      }
      ranges_.push_back(range);
      num_chunks_ *= range.count;
    }
  }

  std::int64_t num_chunks() const { return num_chunks_; }

  void read(std::int64_t index, std::span<std::byte> buffer) const {
    const std::size_t rank = ranges_.size();
    std::vector<std::int64_t> number(rank);
    for (std::size_t a = rank; a-- > 0; index /= ranges_[a].count)
      number[a] = ranges_[a].first + index % ranges_[a].count;
    const bool is_there = load_chunk(array_, number, buffer);
    ChunkBox box{std::vector<std::int64_t>(rank), std::vector<std::int64_t>(rank), strides_};
    std::int64_t to = 0;
    std::size_t channel_axis = rank;
    for (std::size_t a = 0; a < rank; ++a) {
      const std::int64_t begin = number[a] * array_.chunk[a];
      box.count[a] = std::min(array_.chunk[a], array_.shape[a] - begin);
      to += begin * strides_[a];
      const char letter = array_.axes[a];
      if (letter == 't') box.first[a] = step_ - begin;
      if (letter == 't') box.count[a] = 1;
      if (letter == 'c' && !array_.has_components()) channel_axis = a;
    }
    const std::span<const std::byte> chunk =
        is_there ? std::span<const std::byte>(buffer) : std::span<const std::byte>();
    for (const auto& [channel, out] : channels_) {
      if (channel_axis < rank) {
        const std::int64_t begin = number[channel_axis] * array_.chunk[channel_axis];
        const std::int64_t in_chunk = channel - begin;
        if (in_chunk < 0 || in_chunk >= array_.chunk[channel_axis]) continue;
        box.first[channel_axis] = in_chunk;
        box.count[channel_axis] = 1;
      }
      copy_chunk_box(array_, chunk, box, out + to);
    }
  }

 private:
  const ChunkedArray& array_;
  std::int64_t step_;
  std::vector<std::pair<std::int64_t, std::byte*>> channels_;  // and where each goes; rising
  std::vector<ChunkRange> ranges_;
  std::vector<std::int64_t> strides_;  // bytes in memory; 0 for time and channels
  std::int64_t num_chunks_ = 1;
};

// What of an array is read.
struct ChosenChannels {
  const ChunkedArray* array = nullptr;
  std::vector<std::int64_t> channels;
};

std::vector<ChosenChannels> choose_channels(const std::vector<ChunkedArray>& arrays,
                                            const ReadOptions& options) {
  std::vector<ChosenChannels> chosen;
  std::vector<std::string> known;
  for (const ChunkedArray& array : arrays) {
    ChosenChannels wanted{&array, {}};
    for (std::int64_t c = 0; c < array.num_channels(); ++c) {
      known.push_back(array.channel_name(c));
      if (options.array.empty() || options.array == known.back()) wanted.channels.push_back(c);
    }
    if (!wanted.channels.empty()) chosen.push_back(std::move(wanted));
  }
  if (!chosen.empty()) return chosen;
  constexpr std::size_t kListed = 20;
  std::string list;
  for (std::size_t i = 0; i < std::min(kListed, known.size()); ++i)
    list += fmt::format(" '{}'", known[i]);
  if (known.size() > kListed) list += fmt::format(" and {} more", known.size() - kListed);
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: array '{}': no such array or channel: expected one of{}",
                          arrays.front().where, options.array, list));
}

std::int64_t num_bytes_of_array(const ChunkedArray& array) {
  const Index3 dims = array.dims();
  return checked_num_bytes(array.where + ": shape", dims, array.type,
                           array.has_components() ? static_cast<int>(array.size_of_axis('c')) : 1);
}

DataArray empty_array(const ChunkedArray& array, std::int64_t channel) {
  DataArray result;
  result.name = array.channel_name(channel);
  result.type = array.type;
  result.num_components = array.has_components() ? static_cast<int>(array.size_of_axis('c')) : 1;
  result.num_tuples = num_samples(array.dims());
  const auto index = static_cast<std::size_t>(channel);
  if (index < array.channels.size()) result.display = array.channels[index].display;
  return result;
}

// The chosen arrays of one step, in memory.
std::vector<DataArray> read_chunked_step(const std::vector<ChosenChannels>& chosen,
                                         std::int64_t step, const ReadOptions& options) {
  const int threads = std::max(1, data::resolve_threads(0) / std::max(1, options.processes_beside));
  std::int64_t total = 0, most_chunk = 0;
  for (const ChosenChannels& one : chosen) {
    total += num_bytes_of_array(*one.array) * static_cast<std::int64_t>(one.channels.size());
    total = std::min(total, kMaxNumBytes);
    most_chunk = std::max(most_chunk, num_chunk_bytes(*one.array));
  }
  require_memory(fmt::format("{}: {}", chosen.front().array->where,
                             layout_text(chosen.front().array->dims(), chosen.front().array->type)),
                 total + 2 * most_chunk * threads);
  std::vector<DataArray> arrays;
  std::vector<SampleBuffer> buffers;
  std::vector<ChunkReader> readers;
  std::int64_t num_chunks = 0;
  for (const ChosenChannels& one : chosen) {
    const std::int64_t num_bytes = num_bytes_of_array(*one.array);
    std::vector<std::pair<std::int64_t, std::byte*>> places;
    for (const std::int64_t channel : one.channels) {
      arrays.push_back(empty_array(*one.array, channel));
      places.emplace_back(channel, buffers.emplace_back().extend(num_bytes, num_bytes).data());
    }
    readers.emplace_back(*one.array, step, std::move(places));
    num_chunks += readers.back().num_chunks();
    if (readers.back().num_chunks() > kMostChunksRead) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: {} chunks: expected at most {}", one.array->where,
                              readers.back().num_chunks(), kMostChunksRead));
    }
  }
  ReadProgress progress(options, num_chunks);
  for (std::size_t r = 0; r < readers.size(); ++r) {
    const auto chunk_bytes = static_cast<std::size_t>(num_chunk_bytes(*chosen[r].array));
    // Progress is told by this thread, after each batch.
    const std::int64_t batch = std::int64_t{16} * threads;
    for (std::int64_t begin = 0; begin < readers[r].num_chunks(); begin += batch) {
      data::ParallelPlan plan{.count = std::min(batch, readers[r].num_chunks() - begin)};
      plan.threads = threads;
      plan.grain = 4;
      data::parallel_ranges(plan, [&](std::int64_t from, std::int64_t to) {
        std::vector<std::byte> buffer(chunk_bytes);
        for (std::int64_t i = from; i < to; ++i) readers[r].read(begin + i, buffer);
      });
      progress.advance(plan.count);
    }
  }
  std::size_t next = 0;
  for (const ChosenChannels& one : chosen) {
    for (std::size_t c = 0; c < one.channels.size(); ++c, ++next) {
      arrays[next].bytes = buffers[next].release();
      widen_short_floats(one.array->short_float, arrays[next]);
    }
  }
  return arrays;
}

bool may_stay_stored(const std::vector<ChosenChannels>& chosen, const ReadOptions& options) {
  std::int64_t total = 0;
  for (const ChosenChannels& one : chosen) {
    if (one.array->has_components() && one.array->size_of_axis('c') > 1) return false;
    total += num_bytes_of_array(*one.array) * static_cast<std::int64_t>(one.channels.size());
    total = std::min(total, kMaxNumBytes);
  }
  return stays_in_file(chosen.front().array->type, total, options) &&
         std::all_of(chosen.begin(), chosen.end(), [&](const ChosenChannels& one) {
           return one.array->type == chosen.front().array->type &&
                  one.array->short_float == chosen.front().array->short_float;
         });
}

// Where a step lies, if it lies by itself, x fastest.
std::shared_ptr<const StoredSamples> place_of_step(const ChunkedArray& array, std::int64_t step) {
  std::string order;
  for (std::size_t a = 0; a < array.axes.size(); ++a)
    if (array.shape[a] > 1) order += array.axes[a];
  const bool is_in_time = array.size_of_axis('t') > 1;
  if (is_in_time && array.axes[0] != 't') return nullptr;
  if (is_in_time) order.erase(0, 1);
  constexpr std::string_view kOrder = "zyx";
  std::size_t last = 0;
  for (const char letter : order) {
    const std::size_t place = kOrder.find(letter);
    if (place == std::string_view::npos || place < last) return nullptr;
    last = place;
  }
  return is_in_time ? array.stored_rows(step, 1) : array.stored_rows(0, array.shape[0]);
}

// The chosen arrays of one step, which stay in their file; false if one cannot.
bool keep_stored(const std::vector<ChosenChannels>& chosen, const ReadOptions& options,
                 Dataset& dataset) {
  std::int64_t num_arrays = 0;
  for (const ChosenChannels& one : chosen)
    num_arrays += static_cast<std::int64_t>(one.channels.size());
  for (const ChosenChannels& one : chosen) {
    for (const std::int64_t channel : one.channels) {
      DataArray array = empty_array(*one.array, channel);
      array.stored = one.array->stored_rows ? place_of_step(*one.array, dataset.step)
                                            : stored_chunks(*one.array, dataset.step, channel,
                                                            memory_for_pages(options) / num_arrays);
      if (array.stored == nullptr) {
        dataset.arrays.clear();
        return false;
      }
      widen_short_floats(one.array->short_float, array);
      dataset.arrays.push_back(std::move(array));
    }
  }
  return true;
}

}  // namespace

std::int64_t ChunkedArray::size_of_axis(char letter) const {
  const auto place = axis_place(axes, letter);
  return place ? shape[*place] : 1;
}

std::string ChunkedArray::channel_name(std::int64_t channel) const {
  if (num_channels() == 1 && channels.size() != 1) return name;
  std::string number = fmt::format("channel {}", channel + 1);
  const auto index = static_cast<std::size_t>(channel);
  if (index >= channels.size() || channels[index].name.empty()) {
    if (num_channels() == 1) return name;
    return name == "values" ? number : fmt::format("{} {}", name, number);
  }
  return name_among(channels, index, number);
}

std::int64_t num_chunk_bytes(const ChunkedArray& array) {
  return checked_num_bytes(array.where + ": chunks", array.chunk, array.type);
}

void check_chunked(const ChunkedArray& array) {
  checked_num_bytes(array.where + ": shape", array.shape, array.type);
  if (num_chunk_bytes(array) > ChunkedArray::kMostChunkBytes) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: chunks of {}: expected at most 2 GiB in each", array.where,
                            layout_text(array.chunk, array.type)));
  }
  for (std::size_t a = 0; a < array.axes.size(); ++a) {
    if (array.axes[a] == kPassedAxis && array.shape[a] != 1) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: axis {} of shape {} is none of time, channels, z, y and x: say "
                              "which is which with --axis-order",
                              array.where, a, dims_text(array.shape)));
    }
  }
  check_num_steps(array.where + ": shape", array.size_of_axis('t'));
  const std::int64_t num_channels = array.size_of_axis('c');
  const std::int64_t most = array.has_components() ? kMostComponents : kMostChannels;
  if (num_channels > most) {
    throw Error(ErrorCode::kUnsupported, fmt::format("{}: {} channels: expected at most {}",
                                                     array.where, num_channels, most));
  }
}

void read_chunked(const std::vector<ChunkedArray>& arrays, const ReadOptions& options,
                  Dataset& dataset) {
  const std::vector<ChosenChannels> chosen = choose_channels(arrays, options);
  const ChunkedArray& first = arrays.front();
  dataset.lattice.dims = first.dims();
  dataset.num_steps = first.size_of_axis('t');
  if (options.step) check_step(first.where, *options.step, dataset.num_steps);
  dataset.step = options.step.value_or(0);
  if ((options.step || dataset.num_steps == 1) && may_stay_stored(chosen, options) &&
      keep_stored(chosen, options, dataset))
    return;
  for (std::int64_t step = dataset.step; step < dataset.num_steps; ++step) {
    dataset.arrays.clear();
    dataset.step = step;
    dataset.arrays = read_chunked_step(chosen, step, options);
    if (options.step || data::is_worth_showing(dataset, options.array)) break;
    if (step + 1 < dataset.num_steps || step == 0) continue;
    dataset.arrays.clear();  // none varies
    dataset.step = 0;
    dataset.arrays = read_chunked_step(chosen, 0, options);
    break;
  }
  if (!options.step && dataset.step > 0)
    dataset.notes.push_back(chosen_step_note(first.where, dataset.step, dataset.num_steps));
}

bool load_chunk(const ChunkedArray& array, std::span<const std::int64_t> number,
                std::span<std::byte> out) {
  if (!array.read(number, out)) return false;
  if (array.is_big_endian != (std::endian::native == std::endian::big))
    swap_bytes(out, size_of(array.type));
  return true;
}

namespace {

// One axis of a copy: samples, and the bytes from one to the next.
struct CopyAxis {
  std::int64_t count, from_stride, to_stride;
};

template <std::size_t kSize>
void copy_items(const CopyAxis& axis, const std::byte* from, std::byte* to) {
  for (std::int64_t i = 0; i < axis.count; ++i)
    std::memcpy(to + i * axis.to_stride, from + i * axis.from_stride, kSize);
}

void copy_along(const CopyAxis& axis, std::size_t size, const std::byte* from, std::byte* to) {
  const auto item = static_cast<std::int64_t>(size);
  if (axis.from_stride == item && axis.to_stride == item) {
    std::memcpy(to, from, static_cast<std::size_t>(axis.count) * size);
    return;
  }
  if (size == 1) copy_items<1>(axis, from, to);
  if (size == 2) copy_items<2>(axis, from, to);
  if (size == 4) copy_items<4>(axis, from, to);
  if (size == 8) copy_items<8>(axis, from, to);
}

void copy_axes(std::span<const CopyAxis> axes, std::size_t size, const std::byte* from,
               std::byte* to) {
  if (axes.size() == 1) {
    copy_along(axes[0], size, from, to);
    return;
  }
  for (std::int64_t i = 0; i < axes[0].count; ++i)
    copy_axes(axes.subspan(1), size, from + i * axes[0].from_stride, to + i * axes[0].to_stride);
}

}  // namespace

void copy_chunk_box(const ChunkedArray& array, std::span<const std::byte> chunk,
                    const ChunkBox& box, std::byte* to) {
  const std::size_t rank = array.chunk.size(), size = size_of(array.type);
  std::vector<std::int64_t> from_strides(rank);
  std::int64_t stride = chunk.empty() ? 0 : static_cast<std::int64_t>(size);
  for (std::size_t i = 0; i < rank; ++i) {
    const std::size_t a = array.is_first_fastest ? i : rank - 1 - i;
    from_strides[a] = stride;
    stride *= array.chunk[a];
  }
  std::vector<CopyAxis> axes;
  std::int64_t from = 0;
  for (std::size_t a = 0; a < rank; ++a) {
    from += box.first[a] * from_strides[a];
    if (box.count[a] > 1) axes.push_back({box.count[a], from_strides[a], box.to_strides[a]});
  }
  if (axes.empty()) axes.push_back({1, 0, 0});
  // Writes are in order: they go to new memory.
  std::stable_sort(axes.begin(), axes.end(),
                   [](const CopyAxis& a, const CopyAxis& b) { return a.to_stride > b.to_stride; });
  copy_axes(axes, size, chunk.empty() ? array.fill.data() : chunk.data() + from, to);
}

}  // namespace ovoid::io
