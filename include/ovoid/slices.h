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
#include "ovoid/field.h"
#include "ovoid/model.h"
#include "ovoid/series.h"

namespace OVOID_API ovoid {

// Over which kernels a time slice of a staggered series (D4*) is taken; others have one way.
enum class TimeFilter : std::uint8_t {
  kFourSteps,  // of each half four steps, by the cubic through them; then what alternates from half
               // to half and moves is taken out, which no step alone can tell from the data
  kTwoSteps,  // of each half its two steps around the time, weighted by a Gaussian less what it has
              // at the next step, so that nothing jumps where a step comes in
  kGaussian,  // of each half all steps that the kernel reaches along time, as published
  kExact,     // all kernels of the four-dimensional lattice, both halves for every sample
};

// A step of a series and its share in a time slice.
struct StepWeight {
  std::int64_t step;
  double weight;
};

// The shares of the steps at `time`. Steps: those before and behind it, linearly, or the one that
// it is at. Staggered: of the half `half` (0: even steps, 1: odd ones); a time before its first or
// behind its last step is at that. Shares add up to 1; they are positive, but for those by four
// steps, which are not all of that filter. `times` as Series::times().
// Throws Error(kInvalidArgument) for a time that is not finite or lies outside of all steps' times.
// Sources: [Neophytou 2006, section 2.3], [Keys 1981].
std::vector<StepWeight> weights_of_steps(const std::vector<double>& times, double time);
std::vector<StepWeight> weights_of_half(const std::vector<double>& times, int half, double time,
                                        TimeFilter filter = TimeFilter::kFourSteps);

struct TimeSliceOptions {
  TimeFilter filter = TimeFilter::kFourSteps;
  int threads = 0;  // 0: one per hardware thread
  std::stop_token stop;
};

// The series at a time: a step as it is where it is at one, else a dataset made of several.
// Lattices: arrays of values, float32, NaN where one that has a share is; staggered series become
// body-centred lattices. Meshes whose cells stay, and particles whose numbers ("id" and the like)
// stay, move linearly with their arrays; others do not: the nearest step is taken, and a note says
// why. Throws what Series::step and weights_of_steps throw; kOutOfMemory. Cost: reading the steps
// that are not held, a pass over them.
Dataset slice_at_time(const Series& series, double time, const TimeSliceOptions& options = {});

// Slices as fields that blend what a renderer asks for, cube by cube when it first asks: no volume
// is made for a time, and what is clipped away, irrelevant or hidden is never blended. Keeps the
// fields of the steps of the last slice, so that one beside it in time costs next to nothing before
// it is drawn. Not for use from several threads at once; its fields are, and outlive it.
class SliceFields {
 public:
  // `series` outlives this. Its steps become fields as `model` says. Throws
  // Error(kInvalidArgument) for TimeFilter::kExact, which is no sum over steps alone.
  SliceFields(const Series& series, LatticeModelOptions model,
              const TimeSliceOptions& options = {});
  SliceFields(const Series&& series, LatticeModelOptions model,
              const TimeSliceOptions& options = {}) = delete;  // a temporary
  ~SliceFields();
  SliceFields(SliceFields&&) noexcept;
  SliceFields& operator=(SliceFields&&) noexcept;

  // The field of slice_at_time(series, time, options), equal but for rounding; its value range may
  // be wider, as sums of the steps' are. Memory: the steps that have a share, as they are stored,
  // and of the slice what was drawn, as float32. Staggered series that are prefiltered, or sliced
  // by kFourSteps, are no such sums: of these the whole volume is made. Throws what Series::step,
  // weights_of_steps and make_lattice_field throw.
  LatticeField at(double time);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A trail is what was in the data during the last `length` units of time, all at once.
struct TrailOptions {
  double length = 1;  // > 0
  double decay = 0;   // what was there `age` ago counts exp(-decay * age / length)
  int threads = 0;    // 0: one per hardware thread
  std::stop_token stop;
  // Of kernel sets: how many moments stand for all of the time at most, and bytes for their
  // kernels.
  int most_moments = 64;
  std::size_t memory_limit = std::size_t{1} << 30;

  static constexpr double kMaxDecay = 100;
};

// The shares of the steps in a trail that ends at `time`: integrals over time of what lies between
// them, linearly; staggered, of the half `half`, between its own. Positive, they add up to 1. None
// at the first time, before which there is nothing; a trail begins no earlier. Throws
// Error(kInvalidArgument) for a time as weights_of_steps(), a length that is not finite and > 0, a
// decay out of [0, kMaxDecay].
std::vector<StepWeight> weights_of_trail(const std::vector<double>& times, double time,
                                         double length, double decay);
std::vector<StepWeight> weights_of_half_trail(const std::vector<double>& times, int half,
                                              double time, double length, double decay);

// The mean of a series of lattices over a trail, on the lattice of slice_at_time(series, time). At
// the first time it is the slice itself. Memory: the result and one step. Throws what
// weights_of_trail and Series::step throw; kInvalidArgument for what is no lattice; kOutOfMemory.
// Source: [Neophytou 2006, section 2.2].
Dataset trail_before(const Series& series, double time, const TrailOptions& options);

// The trail of a series of meshes, particles, boxes or kernels.
struct KernelTrail {
  std::vector<KernelMoment>
      moments;                     // by time; shares add up to 1. Of sums one: all moments' kernels
  std::vector<std::string> notes;  // on what moves by steps, or farther than kernels overlap
};

// The fields of a series at moments of a trail, each as make_kernel_field(slice_at_time(), model)
// makes it; `now`, the field at `time`, says how far kernels may move from one moment to the next.
// Times and shares: docs/numerics.md, "With a trail of kernel sets". At the first time it is that
// moment. Throws what weights_of_trail, Series::step and make_kernel_field throw; kInvalidArgument
// for `most_moments` < 1, and for steps that make kernels of several shapes; kOutOfMemory. Cost:
// two passes over the steps, a model for each moment.
KernelTrail kernel_trail_before(const Series& series, double time, const TrailOptions& options,
                                const KernelModelOptions& model, const KernelField& now);

}  // namespace ovoid
