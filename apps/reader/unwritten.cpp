// SPDX-License-Identifier: Apache-2.0
#include "unwritten.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/error.h"

namespace ovoid::reader {
namespace {

using RawBytes = std::span<const std::byte>;

// Four of them are -5e-15 or 6e-16 as a float32, eight -1e-117 or 7e-125 as a float64: nothing that
// is measured.
constexpr std::array<std::uint8_t, 2> kFills = {0xA7, 0x26};

// What malloc() gives out is full of this byte from now on. The library keeps small pieces of its
// own, which reader_environment() switches off.
void fill_new_memory([[maybe_unused]] std::uint8_t fill) {
#ifdef __GLIBC__
  ::mallopt(M_PERTURB, fill ^ 0xFF);  // it inverts the byte
#endif
}

template <typename Word>
bool holds_word(RawBytes bytes, std::uint8_t fill) {
  Word wanted{};
  std::memset(&wanted, fill, sizeof(Word));
  for (std::size_t i = 0; i + sizeof(Word) <= bytes.size(); i += sizeof(Word)) {
    Word word{};
    std::memcpy(&word, bytes.data() + i, sizeof(Word));
    if (word == wanted) return true;
  }
  return false;
}

// Whether some of it may never have been written: a number of 4 bytes or more, 8 bytes of shorter
// ones, or the last.
bool may_be_unwritten(RawBytes bytes, std::size_t number_size, std::uint8_t fill) {
  if (bytes.empty()) return false;
  const RawBytes last = bytes.last(std::min(number_size, bytes.size()));
  if (std::all_of(last.begin(), last.end(), [&](std::byte b) { return b == std::byte{fill}; }))
    return true;
  return number_size == 4 ? holds_word<std::uint32_t>(bytes, fill)
                          : holds_word<std::uint64_t>(bytes, fill);
}

RawBytes bytes_of(const DataArray& array) { return array.bytes.view; }

template <typename T>
RawBytes bytes_of(const SharedValues<T>& values) {
  return std::as_bytes(std::span<const T>(values.begin(), values.end()));
}

// What all arrays stand on.
std::vector<RawBytes> frame_of(const Dataset& dataset) {
  return {bytes_of(dataset.positions),          bytes_of(dataset.box_sizes),
          bytes_of(dataset.cells.types),        bytes_of(dataset.cells.offsets),
          bytes_of(dataset.cells.connectivity), std::as_bytes(std::span(dataset.times))};
}

bool may_be_unwritten(const Dataset& dataset, std::uint8_t fill) {
  const std::array sizes = {
      size_of(dataset.positions.type), sizeof(double), std::size_t{1}, sizeof(std::int64_t),
      sizeof(std::uint32_t),           sizeof(double)};
  const std::vector<RawBytes> frame = frame_of(dataset);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (may_be_unwritten(frame[i], sizes[i], fill)) return true;
  }
  return std::any_of(dataset.arrays.begin(), dataset.arrays.end(), [&](const DataArray& array) {
    return may_be_unwritten(bytes_of(array), size_of(array.type), fill);
  });
}

bool are_equal(RawBytes a, RawBytes b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size()) == 0);
}

[[noreturn]] void fail(const std::string& source, const std::string& what) {
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: {} are not all in the file: is it damaged?", source, what));
}

void leave_out_unwritten(Dataset& dataset, const Dataset& again, const std::string& source,
                         const std::string& wanted) {
  const std::vector<RawBytes> frame = frame_of(dataset), other = frame_of(again);
  if (!std::equal(frame.begin(), frame.end(), other.begin(), are_equal))
    fail(source, "its places, cells or times");
  std::vector<DataArray> whole;
  for (std::size_t i = 0; i < dataset.arrays.size(); ++i) {
    DataArray& array = dataset.arrays[i];
    if (i < again.arrays.size() && are_equal(bytes_of(array), bytes_of(again.arrays[i]))) {
      whole.push_back(std::move(array));
      continue;
    }
    if (array.name == wanted) fail(source, fmt::format("the numbers of array '{}'", array.name));
    dataset.notes.push_back(
        fmt::format("{}: array '{}' is left out: the file names it, and does not hold all its "
                    "numbers",
                    source, array.name));
  }
  if (whole.empty() && !dataset.arrays.empty()) fail(source, "the numbers of its arrays");
  dataset.arrays = std::move(whole);
}

}  // namespace

Dataset read_what_is_written(const io::ReaderRequest& request, ReadHere read) {
  fill_new_memory(kFills[0]);
  Dataset dataset = read(request);
  if (!may_be_unwritten(dataset, kFills[0])) return dataset;
  fill_new_memory(kFills[1]);
  const Dataset again = read(request);
  leave_out_unwritten(dataset, again, request.source, request.options.array);
  return dataset;
}

}  // namespace ovoid::reader
