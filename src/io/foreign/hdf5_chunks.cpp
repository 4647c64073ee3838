// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_chunks.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ovoid::io {
namespace {

// A box of samples goes to the front of a chunk along each axis.
void copy_to_chunk(std::span<const std::byte> box, std::span<const std::int64_t> count,
                   std::span<const std::int64_t> chunk, std::span<std::byte> out) {
  std::size_t num_runs = 1;
  for (const std::int64_t n : count.first(count.size() - 1))
    num_runs *= static_cast<std::size_t>(n);
  const std::size_t run = box.size() / num_runs;
  const std::size_t row =
      run / static_cast<std::size_t>(count.back()) * static_cast<std::size_t>(chunk.back());
  for (std::size_t i = 0; i < num_runs; ++i) {
    std::size_t rest = i, to = 0, stride = row;
    for (std::size_t axis = count.size() - 1; axis-- > 0;) {
      to += rest % static_cast<std::size_t>(count[axis]) * stride;
      rest /= static_cast<std::size_t>(count[axis]);
      stride *= static_cast<std::size_t>(chunk[axis]);
    }
    std::copy_n(box.begin() + static_cast<std::ptrdiff_t>(i * run), run,
                out.begin() + static_cast<std::ptrdiff_t>(to));
  }
}

}  // namespace

void read_chunks_of_hdf5(const std::shared_ptr<const Hdf5Handle>& dataset, const Hdf5Extent& extent,
                         Hdf5Reading& reading, ChunkedArray& array) {
  array.type = extent.type.type;
  array.is_big_endian = std::endian::native == std::endian::big;  // as boxes are read
  const Hdf5Handle plist(H5Dget_create_plist(dataset->get()), H5Pclose);
  H5Pget_fill_value(plist.get(), hdf5_native_type(array.type), array.fill.data());
  array.read = [dataset, extent, &reading, chunk = array.chunk, fill = array.fill](
                   std::span<const std::int64_t> number, std::span<std::byte> out) {
    std::vector<std::int64_t> first, count;
    std::int64_t num_read = 1;
    for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
      first.push_back(number[axis] * chunk[axis]);
      count.push_back(std::min(chunk[axis], extent.dims[axis] - first.back()));
      if (count.back() < 1) return false;
      num_read *= count.back();
    }
    const std::scoped_lock lock(reading.mutex);
    if (count == chunk) {
      read_hdf5_box(dataset->get(), extent, first, count, out, reading.progress);
      return true;
    }
    const auto item = static_cast<std::size_t>(extent.item_size());
    for (std::size_t at = 0; at < out.size(); at += item)
      std::copy_n(fill.begin(), item, out.begin() + static_cast<std::ptrdiff_t>(at));
    std::vector<std::byte> box(static_cast<std::size_t>(num_read) * item);
    read_hdf5_box(dataset->get(), extent, first, count, box, reading.progress);
    copy_to_chunk(box, count, chunk, out);
    return true;
  };
}

}  // namespace ovoid::io
#endif
