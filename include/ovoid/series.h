// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/export.h"

namespace OVOID_API ovoid {

// Where the steps of a series come from: files (open_steps() in ovoid/io.h), memory, another
// process. Immutable; all members are called from many threads at once.
class StepSource {
 public:
  virtual ~StepSource() = default;

  virtual SeriesKind kind() const noexcept { return SeriesKind::kSteps; }
  virtual const std::string& name() const noexcept = 0;  // for messages
  virtual std::int64_t num_steps() const noexcept = 0;   // >= 1
  // [num_steps], finite and strictly rising; the steps' numbers where the input names no times.
  virtual const std::vector<double>& times() const noexcept = 0;
  virtual bool has_times() const noexcept = 0;  // the input names them

  // One step. Throws Error: kInvalidArgument for a step that is not there; file trouble, naming the
  // file; kCancelled.
  virtual Dataset read(std::int64_t step, std::stop_token stop = {}) const = 0;
};

// When steps in memory are.
struct StepTimes {
  // [number of steps], finite and strictly rising. Empty: what the steps say themselves
  // (Dataset::times) where all say it and not all the same, else their numbers.
  std::vector<double> values;
  std::string unit;  // empty: what the first step says
};

// Steps that are in memory, whose arrays are shared; reading one copies none. Each is a dataset by
// itself: what it says of other steps counts for nothing. `name`: for messages. Reads nothing, but
// compares all steps. Throws Error: kInvalidArgument for no step, times that are not as above, or
// steps that are not alike (Series::step); kUnsupported for several steps whose samples stay in
// their files.
std::shared_ptr<const StepSource> make_steps(const std::string& name,
                                             std::vector<std::shared_ptr<const Dataset>> steps,
                                             const StepTimes& times = {});

// The step that is shown where none is chosen: the first in which the array varies, or without a
// name any that is worth showing, told in a note; if there is none, the first. Of one step that.
// Throws what StepSource::read throws, and Error(kInvalidArgument) for an array that is not there.
Dataset step_to_show(const StepSource& source, const std::string& array = {},
                     std::stop_token stop = {});

struct SeriesOptions {
  // Bytes of steps in memory, those that are being read included (they count as much as the
  // greatest so far). Steps in use elsewhere are held in any case. What a reader needs beside the
  // step while it reads is not counted (docs/formats.md).
  std::size_t memory_limit = std::size_t{1} << 30;
  // Reads in the background the step that is likely wanted next: the one behind the last in the
  // direction of the last two, or as far on as both of the last two strides. Not done where it
  // would push out the last one, or go over the limit.
  bool prefetch = true;
};

// The steps of a series, read when they are asked for and kept while memory allows; those asked for
// longest ago go first. All members but the special ones may be called from many threads; a step is
// read once even if several ask for it.
class Series {
 public:
  // Reads nothing. Throws Error(kInvalidArgument) for a null source, or one whose times are not
  // num_steps() finite rising numbers.
  explicit Series(std::shared_ptr<const StepSource> source, const SeriesOptions& options = {});
  ~Series();  // stops reading in the background, and waits until it has
  Series(Series&&) noexcept;
  Series& operator=(Series&&) noexcept;

  const StepSource& source() const noexcept;
  std::int64_t num_steps() const noexcept;
  const std::vector<double>& times() const noexcept;

  // The step whose time is nearest, the earlier of two. O(log num_steps).
  std::int64_t nearest_step(double time) const noexcept;

  // The step, read now unless it is held or on its way. Whoever holds the pointer keeps its memory.
  // Throws what StepSource::read throws, a failure in the background when the step is asked for;
  // Error(kInvalidArgument) for a step that is not there; and Error(kFileFormat), naming the step
  // and what differs, if it is of another kind or lattice than the first that was read, or lacks
  // one of its arrays or has it with another type, number of components or place (nodes, cells): a
  // series is one thing in time. An array that is alone is the same whatever it is called. The
  // scale of an array may change, and so may the numbers of nodes, cells and particles.
  std::shared_ptr<const Dataset> step(std::int64_t step, std::stop_token stop = {}) const;

  std::size_t resident_bytes() const noexcept;  // of the steps held here
  std::int64_t num_resident() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovoid
