// SPDX-License-Identifier: Apache-2.0
#include "io/core/strided_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

#include "data/varies.h"
#include "io/core/memory.h"
#include "io/core/parts_stream.h"
#include "io/core/samples.h"

namespace ovoid::io {
namespace {

// Takes the samples in the order of the files and puts those of one step into their places.
class SampleSpreader {
 public:
  SampleSpreader(const StridedLayout& layout, std::int64_t step, std::byte* to)
      : axes_(layout.axes),
        step_(step),
        to_(to),
        size_(static_cast<std::int64_t>(size_of(layout.type))),
        at_(axes_.size(), 0) {
    for (std::size_t a = 0; a < axes_.size(); ++a)
      if (axes_[a].is_of_steps) axis_of_steps_ = a;
  }

  void add(std::span<const std::byte> samples) {
    const std::byte* from = samples.data();
    std::int64_t num_left = static_cast<std::int64_t>(samples.size()) / size_;
    while (num_left > 0) {
      const std::int64_t run = std::min(num_left, axes_[0].count - at_[0]);
      add_run(from, run);
      from += run * size_;
      num_left -= run;
      advance(run);
    }
  }

 private:
  // Along the fastest axis.
  void add_run(const std::byte* from, std::int64_t run) {
    if (axis_of_steps_ == 0) {
      const std::int64_t i = step_ - at_[0];
      if (i >= 0 && i < run) copy(from + i * size_, to_ + offset_);
      return;
    }
    if (axis_of_steps_ < axes_.size() && at_[axis_of_steps_] != step_) return;
    const std::int64_t stride = axes_[0].to_stride;
    std::byte* to = to_ + offset_ + at_[0] * stride;
    if (stride == size_) {
      std::memcpy(to, from, static_cast<std::size_t>(run * size_));
      return;
    }
    for (std::int64_t i = 0; i < run; ++i) copy(from + i * size_, to + i * stride);
  }

  void copy(const std::byte* from, std::byte* to) const {
    std::memcpy(to, from, static_cast<std::size_t>(size_));
  }

  void advance(std::int64_t run) {
    at_[0] += run;
    for (std::size_t a = 0; a + 1 < axes_.size() && at_[a] == axes_[a].count; ++a) {
      if (a > 0) offset_ -= at_[a] * axes_[a].to_stride;
      at_[a] = 0;
      ++at_[a + 1];
      offset_ += axes_[a + 1].to_stride;
    }
  }

  const std::vector<StridedLayout::Axis>& axes_;
  std::int64_t step_;
  std::byte* to_;
  std::int64_t size_;
  std::vector<std::int64_t> at_;  // of the next sample, along each axis
  std::int64_t offset_ = 0;       // in memory, of the row along the fastest axis that it is in
  std::size_t axis_of_steps_ = SIZE_MAX;
};

void read_to(const SampleParts& parts, const StridedLayout& layout, std::int64_t step,
             ReadProgress& progress, std::vector<std::string>& notes, std::span<std::byte> out) {
  constexpr std::int64_t kWindow = std::int64_t{4} << 20;
  PartsStream stream(parts, progress, notes);
  SampleSpreader spreader(layout, step, out.data());
  SampleBuffer window;
  const std::int64_t total = layout.num_bytes * layout.num_steps;
  for (std::int64_t at = 0; at < total; at += window.size()) {
    window.shrink(window.size());
    stream.append(std::min(kWindow, total - at), window);
    spreader.add(window.bytes());
  }
  const bool is_native_big = std::endian::native == std::endian::big;
  if (parts.encoding != Encoding::kText && layout.is_big_endian != is_native_big)
    swap_bytes(out, size_of(layout.type));
}

}  // namespace

StepSamples read_strided_step(const SampleParts& parts, const StridedLayout& layout,
                              const ReadOptions& options, std::vector<std::string>& notes) {
  const std::string& name = parts.each.header;
  if (options.step) check_step(name, *options.step, layout.num_steps);
  ReadProgress progress(options, check_parts(parts, options));
  require_memory(fmt::format("{}: {}", name, parts.each.layout), layout.num_bytes);
  SampleBuffer samples;
  const std::span<std::byte> out = samples.extend(layout.num_bytes, layout.num_bytes);
  DataArray array;
  array.type = layout.type;
  array.num_components = layout.num_components;
  array.bytes.view = out;
  // Each step that is looked at costs a walk over all files.
  constexpr std::int64_t kMostTried = 50;
  const std::int64_t end =
      options.step ? *options.step + 1 : std::min(layout.num_steps, kMostTried);
  StepSamples result;
  bool is_found = false;
  std::vector<std::string> stream_notes;
  for (result.step = options.step.value_or(0); result.step < end; ++result.step) {
    stream_notes.clear();
    read_to(parts, layout, result.step, progress, stream_notes, out);
    is_found = !options.step && layout.num_steps > 1 && data::varies(array);
    if (options.step || layout.num_steps == 1 || is_found) break;
  }
  if (result.step == end) {  // none varies
    result.step = 0;
    stream_notes.clear();
    read_to(parts, layout, 0, progress, stream_notes, out);
  }
  notes.insert(notes.end(), stream_notes.begin(), stream_notes.end());
  if (is_found) notes.push_back(chosen_step_note(name, result.step, layout.num_steps));
  result.bytes = samples.release();
  return result;
}

}  // namespace ovoid::io
