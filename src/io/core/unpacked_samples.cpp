// SPDX-License-Identifier: Apache-2.0
#include "io/core/unpacked_samples.h"

#include <vector>

#include "io/core/memory.h"
#include "io/core/samples_in_file.h"

namespace ovoid::io {

UnpackedSamples::UnpackedSamples(const std::string& name, std::int64_t num_bytes, bool are_in_file)
    : num_bytes_(num_bytes) {
  if (are_in_file)
    file_.emplace(name, num_bytes);
  else
    require_memory(name, num_bytes);
}

void UnpackedSamples::append(std::int64_t count, const Fill& fill) {
  if (file_)
    put(num_appended_, count, fill);
  else
    fill(memory_.extend(count, num_bytes_));
  num_appended_ += count;
}

void UnpackedSamples::reserve() {
  if (!file_) memory_.reserve(num_bytes_);
}

void UnpackedSamples::make_room() {
  if (!file_) memory_.extend(num_bytes_, num_bytes_);
}

void UnpackedSamples::put(std::int64_t offset, std::int64_t count, const Fill& fill) {
  if (!file_) {
    fill(
        memory_.bytes().subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(count)));
    return;
  }
  std::vector<std::byte> bytes(static_cast<std::size_t>(count));
  fill(bytes);
  file_->write(offset, bytes);
}

void UnpackedSamples::release(const ReadOptions& options, DataArray* array) {
  if (file_)
    array->stored = samples_unpacked(file_->finish(), array->type, options);
  else
    array->bytes = memory_.release();
}

}  // namespace ovoid::io
