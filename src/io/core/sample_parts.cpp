// SPDX-License-Identifier: Apache-2.0
#include "io/core/sample_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include "data/varies.h"
#include "io/core/memory.h"
#include "io/core/parts_stream.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/core/temporary_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

class StepReader {
 public:
  StepReader(const SampleParts& parts, const StepLayout& layout, ReadProgress& progress,
             std::vector<std::string>& notes)
      : parts_(parts), layout_(layout), stream_(parts, progress, notes) {}

  std::int64_t plane_bytes() const {
    return is_planar() ? layout_.num_bytes / layout_.num_components : layout_.num_bytes;
  }
  bool is_planar() const { return layout_.order == StepLayout::Order::kPlanar; }

  void read(std::int64_t step, SampleBuffer& samples) {
    if (parts_.encoding == Encoding::kRaw) samples.reserve(layout_.num_bytes);
    stream_.skip(step * plane_bytes());
    append_plane(samples);
    append_other_planes(samples);
  }

  // To a temporary file, a few MiB at a time.
  std::shared_ptr<const StoredSamples> unpack(std::int64_t step, const ReadOptions& options) {
    constexpr std::int64_t kWindow = std::int64_t{4} << 20;
    TemporaryFile file(parts_.each.header, layout_.num_bytes);
    stream_.skip(step * layout_.num_bytes);
    SampleBuffer window;
    for (std::int64_t at = 0; at < layout_.num_bytes; at += window.size()) {
      window.shrink(window.size());
      append_samples(std::min(kWindow, layout_.num_bytes - at), window);
      file.write(at, window.bytes());
    }
    return samples_unpacked(file.finish(), layout_.type, options);
  }

  // Reads the first that varies, in one pass over the file.
  std::optional<std::int64_t> find(SampleBuffer& samples) {
    for (std::int64_t step = 0; step < layout_.num_steps; ++step) {
      append_plane(samples);
      if (does_vary(samples)) {
        append_other_planes(samples);
        return step;
      }
      samples.shrink(samples.size());
    }
    return std::nullopt;
  }

 private:
  void append_plane(SampleBuffer& samples) { append_samples(plane_bytes(), samples); }

  void append_samples(std::int64_t num_bytes, SampleBuffer& samples) {
    const auto begin = static_cast<std::size_t>(samples.size());
    stream_.append(num_bytes, samples);
    const bool is_native_big = std::endian::native == std::endian::big;
    if (parts_.encoding != Encoding::kText && layout_.is_big_endian != is_native_big)
      swap_bytes(samples.bytes().subspan(begin), size_of(layout_.type));
  }

  // The step's samples of the other components, each behind the other steps of the one before.
  void append_other_planes(SampleBuffer& samples) {
    for (int i = 1; is_planar() && i < layout_.num_components; ++i) {
      stream_.skip((layout_.num_steps - 1) * plane_bytes());
      append_plane(samples);
    }
  }

  bool does_vary(SampleBuffer& samples) const {
    DataArray array;
    array.type = layout_.type;
    array.num_components = is_planar() ? 1 : layout_.num_components;
    array.bytes.view = samples.bytes();
    return data::varies(array);
  }

  const SampleParts& parts_;
  const StepLayout& layout_;
  PartsStream stream_;
};

// A step of raw samples, where it is.
std::shared_ptr<const StoredSamples> step_in_file(const SampleParts& parts,
                                                  const StepLayout& layout, std::int64_t step,
                                                  const ReadOptions& options) {
  const SamplePart part = parts.open(0);
  const std::int64_t first = parts.each.num_skipped < 0 ? part.source->size() - parts.each.num_bytes
                                                        : part.offset + parts.each.num_skipped;
  return samples_in_file(
      *part.source,
      {layout.type, layout.is_big_endian, first + step * layout.num_bytes, layout.num_bytes},
      options);
}

// [num_components, num_samples] to [num_samples, num_components].
Bytes interleave(SampleBuffer& planar, std::size_t sample_size, std::int64_t num_components) {
  SampleBuffer samples;
  std::byte* const out = samples.extend(planar.size(), planar.size()).data();
  const std::byte* in = planar.bytes().data();
  const auto tuple_size = static_cast<std::size_t>(num_components) * sample_size;
  const std::size_t num_tuples = static_cast<std::size_t>(planar.size()) / tuple_size;
  for (std::size_t c = 0; c < static_cast<std::size_t>(num_components); ++c) {
    for (std::size_t i = 0; i < num_tuples; ++i, in += sample_size)
      std::memcpy(out + i * tuple_size + c * sample_size, in, sample_size);
  }
  return samples.release();
}

}  // namespace

StepSamples read_step(const SampleParts& parts, const StepLayout& layout,
                      const ReadOptions& options, std::vector<std::string>& notes) {
  const std::string& name = parts.each.header;
  if (options.step) check_step(name, *options.step, layout.num_steps);
  ReadProgress progress(options, check_parts(parts, options));
  const bool is_planar = layout.order == StepLayout::Order::kPlanar && layout.num_components > 1;
  const bool is_chosen = options.step || layout.num_steps == 1;
  if (is_chosen && layout.num_components == 1 &&
      stays_in_file(layout.type, layout.num_bytes, options)) {
    const std::int64_t step = options.step.value_or(0);
    const bool is_there = parts.count == 1 && parts.encoding == Encoding::kRaw;
    return {{},
            is_there ? step_in_file(parts, layout, step, options)
                     : StepReader(parts, layout, progress, notes).unpack(step, options),
            step};
  }
  // Planes are put together in memory of their own.
  require_memory(fmt::format("{}: {}", name, parts.each.layout),
                 layout.num_bytes * (is_planar ? 2 : 1));
  SampleBuffer samples;
  StepSamples result;
  std::optional<std::int64_t> found;
  std::vector<std::string> stream_notes;
  if (!options.step && layout.num_steps > 1) {
    found = StepReader(parts, layout, progress, stream_notes).find(samples);
    if (found) stream_notes.push_back(chosen_step_note(name, *found, layout.num_steps));
  }
  result.step = found.value_or(options.step.value_or(0));
  if (!found) {
    stream_notes.clear();  // of a vain search
    StepReader(parts, layout, progress, stream_notes).read(result.step, samples);
  }
  notes.insert(notes.end(), stream_notes.begin(), stream_notes.end());
  result.bytes = is_planar ? interleave(samples, size_of(layout.type), layout.num_components)
                           : samples.release();
  return result;
}

void check_num_steps(const std::string& where, std::int64_t num_steps) {
  constexpr std::int64_t kMaxNumSteps = 1'000'000;
  if (num_steps <= kMaxNumSteps) return;
  throw Error(ErrorCode::kUnsupported, fmt::format("{}: {} time steps: expected at most {}", where,
                                                   num_steps, kMaxNumSteps));
}

void check_step(const std::string& name, std::int64_t step, std::int64_t num_steps) {
  if (step >= 0 && step < num_steps) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: step {}: expected 0 to {}", name, step, num_steps - 1));
}

}  // namespace ovoid::io
